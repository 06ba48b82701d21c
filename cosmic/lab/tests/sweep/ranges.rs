use cosmic_lab::sweep::{in_ranges, parse_ranges};

#[test]
fn ranges_read_back() {
    for (numbers, text) in [
        (vec![3, 4, 5, 40], "3-5,40"),
        (vec![0, 2, 3], "0,2-3"),
        (vec![7], "7"),
    ] {
        assert_eq!(in_ranges(&numbers), text);
        let read = parse_ranges(text).unwrap();
        assert_eq!(read.into_iter().flatten().collect::<Vec<_>>(), numbers);
    }
    assert_eq!(in_ranges(&[]), "");
}

#[test]
fn malformed_ranges_are_refused() {
    for text in ["", "3-", "-1", "5-3", "1,,2", "+1", "1 2", "a"] {
        assert_eq!(parse_ranges(text), None, "{text}");
    }
}
