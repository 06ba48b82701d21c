use cosmic_lab::table::prose;

#[test]
fn code_in_backticks_is_code_in_html() {
    assert_eq!(prose("`a < b`: c"), "<code>a &lt; b</code>: c");
    assert_eq!(prose("no `pair & none"), "no `pair &amp; none");
}
