use crate::small::small;
use cosmic_lab::table::Standing;
use cosmic_lab::verify::gradients::{DRIVER, Gradients, Limit, Row, WAYS, angle};
use cosmic_lab::verify::probe::relative_error;

#[test]
fn every_way_is_as_good_as_it_can_be_and_a_wrong_one_fails() {
    let mut gradients = Gradients::of(&small([2, 2], |scene| scene.physics.steps = 128));
    let failures = gradients.section().failures;
    assert!(failures.is_empty(), "{failures:?}");
    for (way, of) in WAYS.iter().enumerate() {
        let rows: Vec<&Row> = gradients.rows.iter().filter(|row| row.way == way).collect();
        let horizons: Vec<usize> = rows.iter().map(|row| row.steps).collect();
        assert_eq!(horizons, [2, 4, 8, 16, 32, 64, 128]);
        let worst = rows.iter().map(|row| row.error).fold(0.0, f64::max);
        // The expected errors are as follows. Exact ways: the rounding of some hundred steps in the number type.
        // Differences: a third of the digits is lost. Truncated ways: a large error.
        let expected = match of.limit {
            Limit::Rounding => 0.0..1e-10,
            Limit::Single => 0.0..1e-2,
            Limit::Width => 0.0..1e-5,
            Limit::Truncation => 0.01..f64::INFINITY,
        };
        assert!(expected.contains(&worst), "{}: {worst}", of.name);
    }
    let driver = |row: &&mut Row| row.way == DRIVER;
    gradients.rows.iter_mut().rfind(driver).unwrap().error = 1e-3;
    let section = gradients.section();
    assert_eq!(section.failures.len(), 1, "{:?}", section.failures);
    let rows = section.tables[0].rows.iter();
    let failed: Vec<_> = rows
        .filter(|row| row.standing == Standing::Failed)
        .collect();
    assert!(failed.len() == 1 && failed[0].cells.contains(&"failed: wrong".into()));
}

#[test]
fn errors_and_angles() {
    let truth = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut turned = truth;
    turned[1] = 1.0;
    // The tolerances allow for the rounding of a square root and of an arc sine.
    assert!((relative_error(&turned, &truth) - 1.0).abs() < 1e-15);
    assert!((angle(&turned, &truth) - 45.0).abs() < 1e-13);
    assert_eq!(angle(&truth, &truth), 0.0);
    assert!(angle(&[f64::NAN; 8], &truth).is_nan());
    assert_eq!(relative_error(&[0.0; 8], &[0.0; 8]), 0.0);
}
