use cosmic_lab::table::{clock, decimals, plain, prose};

#[test]
fn plain_numbers_have_no_exponent_and_no_rounding_noise() {
    for (x, text) in [
        (3.4999999999999996e-2, "0.035"),
        (1e-4, "0.0001"),
        (-4e-10, "0"),
        (0.0, "0"),
        (100.0, "100"),
        (1e9, "1000000000"),
        (-0.5, "-0.5"),
        (f64::NAN, "NaN"),
    ] {
        assert_eq!(plain(x, 9), text);
    }
    assert_eq!(plain(1200.0, 0), "1200");
}

#[test]
fn numbers_have_a_minus_unless_they_are_shown_as_zero() {
    assert_eq!(decimals(-1.006, 2), "\u{2212}1.01");
    assert_eq!(decimals(-0.001, 2), "0.00");
    assert_eq!(decimals(3.0, 0), "3");
}

#[test]
fn code_in_backticks_is_code_in_html() {
    assert_eq!(prose("`a < b`: c"), "<code>a &lt; b</code>: c");
    assert_eq!(prose("no `pair & none"), "no `pair &amp; none");
}

#[test]
fn durations_read_as_on_a_clock() {
    assert_eq!(
        [0.4, 59.6, 3599.0, 3600.0].map(clock),
        ["0:00", "1:00", "59:59", "1:00:00"]
    );
}
