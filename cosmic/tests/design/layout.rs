use cosmic::design::Design;
use cosmic::design::Material::{Actuator, Skeleton, Void};

#[test]
fn a_design_is_a_layout_if_all_vectors_are_one_hot() {
    let mut z = vec![[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let design = Design::of_vectors(z.clone());
    assert_eq!(design, Design::Layout(vec![Skeleton, Void, Actuator]));
    assert_eq!(*design.vectors(), z[..]);
    z[1] = [1.0 - f64::EPSILON, 0.0, 0.0];
    assert_eq!(Design::of_vectors(z.clone()), Design::Undecided(z));
}
