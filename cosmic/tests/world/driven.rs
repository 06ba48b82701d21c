use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Parameters, Real};
use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::walk::{self, Cause};
use cosmic::world::{Span, Trajectory};
use std::sync::Arc;

/// The activations that the tests give to edges: full, zero and in between, with both signs.
const HELD: [f64; 6] = [0.0, 0.7, -0.7, 0.2, -1.0, 1.0];

/// Settings of scenes, each with at most one force besides Hooke's law.
fn forces() -> Vec<String> {
    let laws = ["damper", "stops"].map(|law| format!("physics.forces = [\"{law}\"]"));
    [String::new()].into_iter().chain(laws).collect()
}

/// The largest distance between the positions of a node at the ends of two rollouts.
fn apart(a: &Trajectory<f64>, b: &Trajectory<f64>) -> f64 {
    let [a, b] = [a, b].map(|seen| &seen.states.last().unwrap().x);
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Returns a case and the activations of its edges, which `held` gives. The controller of the case outputs the same
/// activations, because all its numbers except the biases are zero.
fn case_of(force: &str, held: impl Fn(usize) -> f64) -> (Case, Vec<f64>) {
    /// A bias so large that its hyperbolic tangent is 1 in double precision.
    const SATURATED: f64 = 40.0;
    let text = format!("{force}\n[lattice]\ncolumns = 3\nrows = 2\ndrop = 0.01");
    let scene = Scene::load("stability").unwrap();
    let mut case = Case::of_scene(&scene.with("small", &text).unwrap(), 1).unwrap();
    let held: Vec<f64> = (0..case.lattice.edges.len()).map(held).collect();
    let bias = |held: &f64| held.atanh().clamp(-SATURATED, SATURATED);
    let biases: Vec<f64> = held.iter().map(bias).collect();
    case.controller.block_mut("w2").fill(0.0);
    case.controller.block_mut("b2").copy_from_slice(&biases);
    // Every bar contains actuator material and starts longer than its stops allow, so that stops act on idle bars
    // too.
    case.design = Design::Undecided(vec![[0.0, 0.5, 1.0]; held.len()]);
    case.start.x.iter_mut().for_each(|x| *x += x.along() * 0.5);
    (case, held)
}

/// With every force, a robot with given activations moves like a robot whose controller outputs them.
#[test]
fn constant_activations_drive_as_a_controller_that_gives_them() {
    let span = Span::from_start(vec![200]);
    let mut all = Vec::new();
    for force in forces() {
        let robots = [0.0, 1.0, -1.0]
            .map(|scale: f64| case_of(&force, move |edge| scale * HELD[edge % HELD.len()]));
        let world = robots[0].0.world();
        let controlled = robots.each_ref().map(|(case, _)| case.robot());
        let driven = robots
            .map(|(case, held)| world.robot(case.body(), Controller::given(held), &case.start));
        let [by_controllers, seen] = [&controlled, &driven].map(|robots| world.run(robots, &span));
        for k in 0..3 {
            // Robots of one batch may have other controllers; each has the bits of a single rollout.
            for (batch, robots) in [(&by_controllers, &controlled), (&seen, &driven)] {
                let alone = world.run_one(&robots[k], &span);
                assert_eq!(alone.states, batch[k].states, "{force:?}, robot {k} alone");
            }
            // Activations are rounded at 1e-16; 200 steps with contacts amplify this error to less than
            // 1e-10.
            let far = apart(&by_controllers[k], &seen[k]);
            assert!(far < 1e-10, "{force:?}, robot {k}: {far}");
        }
        assert!(apart(&seen[0], &seen[1]) > 1e-3, "{force:?}");
        all.push(seen);
    }
    // Every force must change the motion: otherwise the test would not cover its law.
    for (force, seen) in forces().iter().zip(&all).skip(1) {
        for (k, (with, without)) in seen.iter().zip(&all[0]).enumerate() {
            assert!(
                apart(with, without) > 1e-6,
                "{force:?} has no effect on robot {k}"
            );
        }
    }
}

#[test]
#[should_panic(expected = "activations of a robot of 6 nodes")]
fn there_must_be_one_activation_per_edge() {
    let (case, held) = case_of("", |_| 0.0);
    let world = case.world();
    let given = Controller::given(held[1..].to_vec());
    let _ = world.run_one(
        &world.robot(case.body(), given, &case.start),
        &Span::of_steps(1),
    );
}

/// The number of steps of [`Moved`].
const STEPS: usize = 60;

/// The position of node 0 after [`STEPS`] steps, as a function of the stiffnesses, strains, rest lengths and masses of a
/// robot and of its activations in every step.
struct Moved(Case);

impl Moved {
    fn inputs(&self) -> Vec<f64> {
        let mut body = self.0.body();
        body.rest_length = self.0.lattice.rest_length.clone();
        let edges = body.strain.len();
        let activation = |k: usize| 0.8 * (k as f64 * 0.7).sin();
        [body.flatten(), (0..STEPS * edges).map(activation).collect()].concat()
    }

    fn end<R: Real>(&self, body: &[R], activations: &[R], steps: [usize; 2]) -> Vec<R> {
        let world = self.0.world();
        let mut like = self.0.body();
        like.rest_length = self.0.lattice.rest_length.clone();
        let (body, edges) = (Arc::new(like.with(body)), like.strain.len());
        let mut state = self.0.start.map(R::lit);
        // The rollout in two parts, of which the second continues the first.
        for (first, count) in [(0, steps[0]), (steps[0], steps[1])] {
            let span = Span {
                first,
                ..Span::from_start(vec![count])
            };
            let given = activations[first * edges..][..count * edges].to_vec();
            let robot = world.robot(Arc::clone(&body), Controller::given(given), &state);
            state = world.run_one(&robot, &span).states.remove(0);
        }
        state.to_columns()
    }
}

impl Function for Moved {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (body, activations) = x.split_at(x.len() - STEPS * self.0.lattice.edges.len());
        self.end(body, activations, [STEPS, 0])[0]
    }
}

/// Derivatives with respect to the body and to the activations of all steps agree in reverse mode, forward mode and finite
/// differences, and a rollout in two parts ends like the whole.
#[test]
fn a_rollout_is_differentiated_by_its_body_and_by_given_activations() {
    let (case, _) = case_of(
        "physics.forces = [\"damper\"]\nphysics.contact = \"coulomb\"",
        |_| 0.0,
    );
    let moved = Moved(case);
    let inputs = moved.inputs();
    let report = check_gradient(&moved, &inputs, &Options::default());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
    let (body, activations) = inputs.split_at(inputs.len() - STEPS * moved.0.lattice.edges.len());
    let [whole, parts] = [[STEPS, 0], [STEPS / 3, STEPS - STEPS / 3]]
        .map(|steps| moved.end(body, activations, steps));
    let far = whole.iter().zip(&parts).map(|(a, b)| (a - b).abs());
    // The state between the parts is converted to the world's frame and back, which rounds at 1e-16.
    assert!(far.fold(0.0, f64::max) < 1e-12, "{whole:?} {parts:?}");
    // The last activations have an effect.
    let other: Vec<f64> = activations.iter().map(|x| x * 0.9).collect();
    let last = (STEPS - 1) * moved.0.lattice.edges.len();
    let other = [&activations[..last], &other[last..]].concat();
    assert_ne!(moved.end(body, &other, [STEPS, 0]), whole);
}

/// A robot with given activations that flies apart is reported like any other: if the activation of an edge is NaN in one step,
/// it diverges in that step because of this edge. The walk is longer than a block of states that the search keeps.
#[test]
fn a_driven_robot_that_diverges_is_reported() {
    let (case, held) = case_of("", |_| 0.5);
    let (world, edges) = (case.world(), held.len());
    let (edge, wrong, steps) = (3, 100, 150);
    let mut given = held.repeat(steps);
    given[wrong * edges + edge] = f64::NAN;
    let robot = |given: Vec<f64>| world.robot(case.body(), Controller::given(given), &case.start);
    let reported = |given: &[f64], first: usize| {
        let span = Span {
            first,
            ..Span::of_steps(steps)
        };
        walk::guarded(&world, &robot(given.to_vec()), &span).divergence
    };
    assert_eq!(reported(&held, 0), None);
    for first in [0, 20] {
        let found = reported(&given, first).expect("an activation is NaN");
        assert_eq!(found.step, first + wrong);
        assert_eq!(found.term, Cause::Controller { edge });
    }
    let constant = [&[f64::NAN], &held[1..]].concat();
    let found = reported(&constant, 0).expect("an activation is NaN");
    assert_eq!((found.step, found.term), (0, Cause::Controller { edge: 0 }));
}
