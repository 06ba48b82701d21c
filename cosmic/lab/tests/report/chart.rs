use cosmic::geometry::Vector;
use cosmic_lab::report::chart::{Line, LogChart};

#[test]
fn points_without_a_logarithm_are_left_out() {
    let points = [[1e-3, 1e-9], [1e-2, 0.0], [0.1, f64::NAN], [1.0, 1e-3]];
    let chart = LogChart {
        name: "errors".to_owned(),
        caption: String::new(),
        title: "error, m".to_owned(),
        along: "time, s".to_owned(),
        lines: vec![Line::new(
            "a < b".to_owned(),
            0,
            "",
            points.into_iter().map(Vector::new),
        )],
        marked: Some((Vector::new([1.0, 1e-3]), "default".to_owned())),
    };
    let svg = chart.draw();
    assert_eq!(svg.matches("<circle").count(), 2 + 1);
    assert!(svg.contains("a &lt; b") && !svg.contains("NaN") && !svg.contains("inf"));
    let empty = LogChart {
        lines: Vec::new(),
        marked: None,
        ..chart
    };
    assert!(empty.draw().ends_with("</svg>\n"));
}
