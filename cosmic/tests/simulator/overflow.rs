use cosmic::design::Design;
use cosmic::lattice::{Body, Lattice, State};
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::simulator::{Simulator, Sweep};

/// A robot of the scene `stability` without damping. Its motion amplifies small changes more and more.
fn wild() -> (Simulator, Body<f64>, Controller<f64>, State<f64>) {
    let scene = Scene::parse("wild", "base = \"stability\"\n[physics]\ndamping = 0.0").unwrap();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let design = Design::of_shares(&vec![[1.0 / 3.0; 3]; lattice.edges.len()]);
    let body = Body::new(&design, &lattice, &scene.materials, &scene.physics);
    let controller = Controller::xavier(&scene.controller, &lattice, 0);
    let simulator = Simulator::new(&lattice, &scene.physics, &scene.controller);
    (simulator, body, controller, lattice.state_at_rest())
}

/// The search by blocks finds the same step as a single sweep over all steps in which the cotangent overflows.
#[test]
fn the_step_that_overflows_is_found() {
    const STEPS: usize = 8192;
    let (simulator, body, controller, start) = wild();
    let divergence = simulator.divergence(&body, &controller, &start, 0..STEPS);
    assert_eq!(divergence, None);
    let found = simulator.overflow(&body, &controller, &start, STEPS);
    let found = found.expect("the gradient of this robot overflows");
    assert!(found.largest > 1e290, "{found:?}");

    let sweep = Sweep::new(&simulator, &body, &controller, &start);
    let start = simulator.flatten(&start);
    let mut seed = vec![0.0; start.len()];
    seed[0] = 1.0;
    let cotangent = |first: usize| {
        let state = sweep.run(&start, 0, vec![first]);
        sweep.pullback(&state, first..STEPS, &seed)
    };
    assert_eq!(sweep.lost_node(&cotangent(found.step + 1)), None);
    assert_eq!(sweep.lost_node(&cotangent(found.step)), Some(found.node));
}

#[test]
fn a_finite_gradient_overflows_nowhere() {
    let (simulator, body, controller, start) = wild();
    for steps in [0, 1, 100] {
        let found = simulator.overflow(&body, &controller, &start, steps);
        assert_eq!(found, None, "{steps} steps");
    }
}
