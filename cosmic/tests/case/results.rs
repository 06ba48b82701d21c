use cosmic::case::{Case, CaseResults, DesignGradient};
use cosmic::geometry::Vector;
use cosmic::scene::Scene;
use serde_json::Value;

fn results() -> CaseResults {
    let scene = Scene::parse(
        "small",
        "base = \"stability\"\n[lattice]\ncolumns = 2\nrows = 2",
    )
    .unwrap();
    let case = Case::of_scene(&scene, 0).unwrap();
    case.evaluate(false, &[0, 2, 10]).unwrap()
}

#[test]
fn steps_come_in_their_order_and_absent_keys_are_left_out() {
    let text = results().to_json();
    let place = |key: &str| text.find(key).unwrap();
    assert!(place("\"2\":") < place("\"10\":"));
    assert!(!text.contains("grad") && !text.contains("performance"));
    assert!(results().not_finite().is_empty());
}

#[test]
fn numbers_that_are_not_finite_are_null_and_named_once() {
    let mut results = results();
    let state = results.trajectory.get_mut(&2).unwrap();
    state.x[0] = Vector::new([f64::NAN, f64::INFINITY]);
    results.l_disp = f64::NEG_INFINITY;
    results.grad_augmented = Some(DesignGradient {
        z: vec![[f64::NAN; 3]],
    });
    let names = results.not_finite();
    assert_eq!(names, ["grad_augmented.z", "l_disp", "trajectory.2.x"]);
    let file: Value = serde_json::from_str(&results.to_json()).unwrap();
    assert!(file["results"]["l_disp"].is_null());
}
