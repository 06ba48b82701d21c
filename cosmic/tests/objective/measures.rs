use cosmic::design::Design;
use cosmic::design::Material::{Actuator, Skeleton, Void};
use cosmic::objective::measures;

#[test]
fn the_measures_of_a_layout_are_its_volumes() {
    let layout = Design::Layout(vec![Void, Skeleton, Actuator, Skeleton]);
    let m = measures::<f64>(&layout.mixtures(), 1e-6);
    assert_eq!((m.volume, m.actuator_volume), (0.75, 0.25));
    assert_eq!(m.constrained(), [0.0; 4]);
}
