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

#[test]
fn files_have_the_vectors_and_the_layout() {
    let layout = Design::<[f64; 3]>::Layout(vec![Skeleton]);
    let text = serde_json::to_string(&layout).unwrap();
    assert_eq!(text, r#"{"z":[[0.0,1.0,0.0]],"materials":[1]}"#);
    assert_eq!(serde_json::from_str::<Design<_>>(&text).unwrap(), layout);
    // Before the snap, one-hot vectors are not a layout yet.
    let open = Design::Undecided(vec![[0.0, 1.0, 0.0]]);
    let text = serde_json::to_string(&open).unwrap();
    assert_eq!(serde_json::from_str::<Design<_>>(&text).unwrap(), open);
}
