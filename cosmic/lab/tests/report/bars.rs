use cosmic_lab::report::{Bar, bars};

#[test]
fn a_chart_has_room_for_names_and_a_shape_for_each_finite_number() {
    let chart = |name: String| {
        let bar = Bar {
            name,
            value: Some(-1.0),
            points: vec![-2.0, 0.5, f64::NEG_INFINITY],
            mark: Some(2.0),
        };
        bars("title", "m", &[bar, Bar::default()])
    };
    let svg = chart("a < b".to_owned());
    let shapes = ["<circle", "#d9541e", "#9fc0e4", "a &lt; b", "NaN", "inf"];
    let counts = shapes.map(|shape| svg.matches(shape).count());
    assert_eq!(counts, [2, 1, 1, 1, 0, 0]);
    // Returns the position of the right end of a name that has this many letters.
    let end = |letters: usize| {
        let svg = chart("x".repeat(letters));
        let (before, _) = svg.split_once(">xxxx").unwrap();
        let (_, x) = before.rsplit_once("<text x=\"").unwrap();
        x.split_once('"').unwrap().0.parse::<f64>().unwrap()
    };
    assert_eq!(end(4), end(30));
    // In a font of 12 pixels, letters are 6 pixels wide.
    assert!(end(60) > 60.0 * 6.0 && end(200) > 200.0 * 6.0);
}
