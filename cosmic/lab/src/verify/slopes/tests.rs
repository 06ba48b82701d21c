use super::{Gradients, Way, angle, error};
use crate::table::{Cell, Standing};
use crate::verify::probe::small;

#[test]
fn every_way_is_as_good_as_it_can_be() {
    let gradients = Gradients::of(&small([2, 2], |scene| scene.physics.steps = 128));
    assert_eq!(gradients.horizons, [2, 4, 8, 16, 32, 64, 128]);
    let failures = gradients.section().failures;
    assert!(failures.is_empty(), "{failures:?}");
    for row in &gradients.slopes {
        // Rounding of some hundred steps in each type; differences lose a third of the digits.
        let most = match row.way {
            Way::Duals | Way::Driver | Way::FullTape => 1e-10,
            Way::SingleDuals | Way::SingleDriver => 1e-2,
            Way::Differences => 1e-5,
            Way::Truncated(_) => continue,
        };
        assert!(row.error < most, "{row:?}");
    }
    let truncated = |way| {
        let mut rows = gradients.slopes.iter();
        rows.any(|row| row.way == way && row.error > 0.01)
    };
    assert!(truncated(Way::Truncated(2)) && truncated(Way::Truncated(4)));
    assert_eq!(gradients.driver_against_tape.len(), 7);
}

#[test]
fn a_wrong_gradient_fails() {
    let mut gradients = Gradients::of(&small([2, 2], |scene| scene.physics.steps = 32));
    let driver = |row: &&mut super::Slopes| row.way == Way::Driver;
    gradients.slopes.iter_mut().rfind(driver).unwrap().error = 1e-3;
    gradients.driver_against_tape[0] = f64::NAN;
    let section = gradients.section();
    assert_eq!(section.failures.len(), 2, "{:?}", section.failures);
    let failed = |table: usize, status: Cell| {
        let rows = section.tables[table].rows.iter();
        let rows = rows.filter(|row| row.standing == Standing::Failed);
        rows.filter(|row| row.cells.contains(&status)).count()
    };
    assert_eq!(failed(0, "failed: wrong".into()), 1);
    assert_eq!(failed(2, 1.into()), 1);
}

#[test]
fn errors_and_angles() {
    let truth = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let mut turned = truth;
    turned[1] = 1.0;
    // Rounding of a root and an arc sine.
    assert!((error(&turned, &truth) - 1.0).abs() < 1e-15);
    assert!((angle(&turned, &truth) - 45.0).abs() < 1e-13);
    assert_eq!(angle(&truth, &truth), 0.0);
    assert!(angle(&[f64::NAN; 8], &truth).is_nan());
    assert_eq!(error(&[0.0; 8], &[0.0; 8]), 0.0);
}
