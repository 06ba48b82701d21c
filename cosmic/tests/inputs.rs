use autodiff::Real;
use cosmic::case::Case;
use cosmic::geometry::flat;
use cosmic::inputs::{ALL, Inputs};
use cosmic::scene::Scene;
use cosmic::simulator::Span;

/// The two products use the same Jacobian: for the states of a rollout, the cotangent times the JVP equals the VJP
/// times the tangent.
#[test]
fn both_products_are_of_one_jacobian() {
    let scene = Scene::parse(
        "small",
        "base = \"stability\"\n[lattice]\ncolumns = 3\nrows = 2",
    )
    .unwrap();
    let case = Case::of_scene(&scene, 1).unwrap();
    let (task, inputs) = (case.task(), case.inputs());
    fn seen<R: Real>(case: &Case, task: &cosmic::task::Task, inputs: &Inputs<R>) -> Vec<R> {
        let design = case.projected(case.projection, &inputs.z);
        let span = Span::from_start(vec![8, 32]);
        let seen = (task.simulator).rollout(
            &task.body(&design),
            &inputs.controller,
            &inputs.start,
            &span,
        );
        let states = seen.states.iter();
        states
            .flat_map(|s| [flat(&s.x), flat(&s.v)].concat())
            .collect()
    }
    let mut tangents = inputs.clone();
    let wave = |n: usize, of: fn(f64) -> f64| (0..n).map(|k| of(k as f64)).collect::<Vec<_>>();
    let tangent = wave(inputs.get(ALL).len(), f64::cos);
    tangents.set(ALL, &tangent);
    let (values, slopes) = inputs.jvp(&tangents, |inputs| seen(&case, &task, inputs));
    let cotangent = wave(values.len(), f64::sin);
    let recorded = |inputs: &Inputs<_>, _: &[_]| seen(&case, &task, inputs);
    let (same, gradient) = inputs.vjp(ALL, &[], recorded, &cotangent);
    // Dual numbers add the products of a layer in another order. So numbers of order one differ in their last bits.
    assert!(values.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-12));
    let [forward, reverse] = [f64::dot(&cotangent, &slopes), f64::dot(&gradient, &tangent)];
    // Each sum has about 600 terms with rounding errors of 1e-16. The sum is a hundred times smaller than its
    // terms.
    assert!(
        (forward - reverse).abs() < 1e-12 * forward.abs(),
        "{forward} {reverse}"
    );
    assert!(forward != 0.0);
}
