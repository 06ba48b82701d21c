//! Small robots, and a check of their gradients.

use autodiff::check::{Options, Verdict};
use cosmic::case::Case;
use cosmic::geometry::{Ground, Vector};
use cosmic::lattice::State;
use cosmic::scene::{PhysicsSettings, Scene};
use cosmic::world::Span;
use cosmic_lab::check::check_gradients;

use crate::laws;

/// A robot of 3x2 nodes that falls to the ground while it moves forward. All its edges have different mixtures.
/// `settings` is TOML that changes the paper's scene; it may name the laws of the [example programs](laws). The rollout of 90 steps is long enough to land and to push off,
/// and short enough for finite differences.
///
/// # Panics
/// If the settings are wrong.
pub fn robot(settings: &str) -> Case {
    robot_of(laws::scene(settings))
}

/// Like [`robot`], with the settings of any scene. The lattice, the number of steps and the network of [`robot`]
/// replace those of the scene.
///
/// # Panics
/// If the robot does not fit the scene.
pub fn robot_of(mut scene: Scene) -> Case {
    (scene.lattice.columns, scene.lattice.rows) = (3, 2);
    // The robot starts so high that no node touches the ground in the first step, and so low that it lands in the first
    // third of the time.
    scene.lattice.drop += 0.004;
    // The controller must have a noticeable effect within these few steps.
    (scene.controller.hidden, scene.controller.velocity_scale) = (6, 0.5);
    scene.physics.steps = 90;
    let mut case = Case::of_scene(&scene, 3).unwrap_or_else(|error| panic!("{error}"));
    let ground = Ground::from(&scene.physics);
    let velocity =
        |i: usize| ground.vector_to_world(Vector::from([0.5 + 0.02 * i as f64, -0.01 * i as f64]));
    case.start.v = (0..case.lattice.nodes()).map(velocity).collect();
    let z = case.design.undecided_mut().expect("a start of mixtures");
    for (e, z) in z.iter_mut().enumerate() {
        z[1] += 0.002 * (e as f64).sin();
        z[2] += 0.002 * (1.7 * e as f64).cos();
    }
    case
}

/// Every state of a case's rollout.
pub fn states(case: &Case) -> Vec<State<f64>> {
    let span = Span::from_start((0..=case.scene.physics.steps).collect());
    case.world().run_one(&case.robot(), &span).states
}

/// The largest distance between the positions of a node in two states, m.
pub fn farthest(a: &State<f64>, b: &State<f64>) -> f64 {
    let pairs = a.x.iter().zip(&b.x);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// The smallest height of any node above the terrain in any of the states, m.
pub fn least_height(physics: &PhysicsSettings, states: &[State<f64>]) -> f64 {
    let (profile, ground) = (physics.ground.resolved(), Ground::from(physics));
    let nodes = states.iter().flat_map(|state| &state.x);
    let heights = nodes.map(|&x| profile.above(ground.vector_to_ground(x)));
    heights.fold(f64::INFINITY, f64::min)
}

/// Options for checks of gradients of rollouts. Rollouts in double-doubles take long, and along a random direction an error
/// of any component shows.
pub fn few_directions() -> Options {
    Options {
        directions: 2,
        ..Options::default()
    }
}

/// Asserts that the gradients with respect to all blocks of a case's inputs agree with finite differences and forward
/// mode. Also asserts that no gradient is zero and that a wrong gradient is noticed.
///
/// # Panics
/// If one of these does not hold.
pub fn assert_smooth(name: &str, case: &Case) {
    let check = check_gradients(case, None, case.scene.physics.steps, &few_directions());
    for group in &check.groups {
        let text = format!("{name}, {}:\n{}", group.name, group.report);
        assert_eq!(group.verdict, Verdict::Smooth, "{text}");
        assert!(group.norm > 0.0, "{text}");
    }
    let control = check.control.map(|control| control.verdict);
    assert_eq!(
        control,
        Some(Verdict::Wrong),
        "{name}: the negative control"
    );
}
