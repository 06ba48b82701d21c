use cosmic::numbers::{brief, clock, fixed, mass, plain, rounded, short, shortened};

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
    assert_eq!(fixed(-1.006, 2), "-1.01");
    assert_eq!(fixed(-0.001, 2), "0.00");
    assert_eq!(
        [fixed(-0.0, 3), fixed(-0.0004, 3), fixed(-0.0006, 3)],
        ["0.000", "0.000", "-0.001"]
    );
    assert_eq!(
        [0.0, -2e-5, 0.125, 1234.0].map(short),
        ["0", "-2.0e-5", "0.125", "1234"]
    );
    assert_eq!(fixed(3.0, 0), "3");
}

#[test]
fn durations_read_as_on_a_clock() {
    assert_eq!(
        [0.4, 59.6, 3599.0, 3600.0].map(clock),
        ["0:00", "1:00", "59:59", "1:00:00"]
    );
}

#[test]
fn numbers_have_two_digits() {
    let shown = [0.0, 0.00633, 0.994, 0.996, 9.94, 9.96, 99.6, 1234.0].map(brief);
    assert_eq!(
        shown,
        ["0", "0.0063", "0.99", "1.0", "9.9", "10", "100", "1234"]
    );
    assert_eq!(
        [0.03, 0.0994, 0.0996, 1.26].map(mass),
        ["30 g", "99 g", "0.10 kg", "1.3 kg"]
    );
}

#[test]
fn time_steps_are_rounded_to_five_digits() {
    let shown = [0.002, 0.001_943_817_264_512_3, 1e-7].map(|x| rounded(x, 5).to_string());
    assert_eq!(shown, ["0.002", "0.0019438", "0.0000001"]);
    let shown = ["10.0", "\"coulomb\"", "[1.999999999999, 0.2]"].map(shortened);
    assert_eq!(shown, ["10.0", "\"coulomb\"", "[2, 0.2]"]);
}
