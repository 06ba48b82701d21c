//! The exported controller computes the activations of the library, also while goals change. The tests of the program
//! do the same with the exported player, in MuJoCo.

use cosmic::case::Case;
use cosmic::geometry::{Ground, Vector};
use cosmic::lattice::State;
use cosmic::policy::{Goals, Layer, Network};
use cosmic::scene::Scene;
use cosmic::walk;
use cosmic::world::Span;
use cosmic_lab::export::mujoco::{self, MujocoSettings};
use serde::Deserialize;
use std::fs;

/// The content of `controller.json` that is needed for activations. The last four entries are only there if goals are
/// given.
#[derive(Deserialize)]
struct Exported {
    nodes: Vec<usize>,
    actuators: Vec<usize>,
    w1: Vec<Vec<f64>>,
    b1: Vec<f64>,
    w2: Vec<Vec<f64>>,
    b2: Vec<f64>,
    strain: Vec<f64>,
    omega: f64,
    dt: f64,
    goal: Option<Vec<f64>>,
    #[serde(default)]
    goal_scale: f64,
    #[serde(default)]
    mean: Vec<f64>,
    #[serde(default)]
    gates: Vec<[f64; 5]>,
}

impl Exported {
    fn of(case: &Case) -> Self {
        let folder = tempfile::tempdir().unwrap();
        mujoco::write(case, &MujocoSettings::default(), folder.path()).unwrap();
        let text = fs::read(folder.path().join("controller.json")).unwrap();
        serde_json::from_slice(&text).unwrap()
    }

    /// The target strains of the actuators in a state that is given in the ground's frame, as the documentation of the
    /// file says.
    fn control(&self, state: &State<f64>, steps: usize, goal: Vector<f64>) -> Vec<f64> {
        let own = |points: &[Vector<f64>]| -> Vec<Vector<f64>> {
            self.nodes.iter().map(|&node| points[node]).collect()
        };
        let (x, v) = (own(&state.x), own(&state.v));
        let (sin, cos) = (self.omega * (steps as f64 * self.dt)).sin_cos();
        let flat = |points: &[Vector<f64>]| state.dimension.flat(points);
        let mut inputs = [flat(&x), flat(&v), vec![sin, cos]].concat();
        let mean = x.iter().zip(&self.mean);
        let mean = mean.fold(Vector::zero(), |sum, (&x, &weight)| sum + x * weight);
        let mut goal_seen = [0.0; 2];
        if self.goal.is_some() {
            let offset = (goal - mean) * self.goal_scale;
            let seen = offset * (1.0 / (1.0 + offset.dot(offset)).sqrt());
            inputs.extend(state.dimension.components(seen));
            goal_seen = [seen.forward(), seen.sideways()];
        }
        let layer = |weights: &[Vec<f64>], biases: &[f64]| Layer {
            weights: weights.concat(),
            biases: biases.to_vec(),
        };
        let network = Network {
            first: layer(&self.w1, &self.b1),
            gates: self.gates.clone(),
            second: layer(&self.w2, &self.b2),
        };
        let activation = network.activation(&inputs, goal_seen);
        let pairs = activation.iter().zip(&self.strain);
        pairs
            .map(|(activation, strain)| activation * strain)
            .collect()
    }
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn the_exported_controller_has_the_library_s_controls() {
    const SMALL: &str =
        "lattice.columns = 3\nlattice.rows = 2\nlattice.drop = 0.01\ncontroller.hidden = 6\n";
    const SLOPE: &str = "lattice.mirror = false\nlattice.payload = 0\nphysics.incline_deg = 12.0\n";
    const GIVEN: &str =
        "controller.goals = \"given\"\ncontroller.goal_scale = 2.0\nobjective.task = \"reach\"\n";
    const CUBIC: &str = "lattice.kind = \"cubic\"\nlattice.depth = 3\n";
    const OPEN: &str = "controller.policy = \"clock\"\n";
    for (base, settings, is_given) in [
        ("errand", [SMALL, ""], true),
        ("errand", [SMALL, "controller.policy = \"mlp\"\n"], true),
        ("errand", [SMALL, SLOPE], true),
        (
            "errand",
            [
                SLOPE,
                "controller.policy = \"mlp\"\ndesign.one_piece = false\n",
            ],
            true,
        ),
        // Scenes with layouts, in which nodes without a bar are left out.
        ("baseline_short", [GIVEN, ""], true),
        ("baseline_short", [GIVEN, SLOPE], true),
        ("baseline_short", [OPEN, ""], false),
        ("stability", [SMALL, OPEN], false),
        ("errand", [SMALL, CUBIC], true),
        ("cube", [GIVEN, SLOPE], true),
        ("cube", [SMALL, ""], false),
        ("cube", [SMALL, SLOPE], false),
        ("cube", [SMALL, OPEN], false),
    ] {
        let name = format!("{base} {settings:?}");
        let text = format!("base = \"{base}\"\n{}", settings.concat());
        let mut case = Case::of_scene(&Scene::parse("small", &text).unwrap(), 1).unwrap();
        // No number may be zero, neither a bias nor the change of a learned clock's frequency.
        let numbers = case.controller.numbers_mut().iter_mut().enumerate();
        numbers.for_each(|(k, number)| *number += 0.05 * (k as f64).cos());
        let dimension = case.lattice.dimension;
        let goals = [[1.5, 0.4, 0.1], [-1.5, -0.7, 0.2], [0.4, 0.2, 0.0]];
        let [first, second, third] = goals.map(|goal| dimension.onto(Vector::new(goal)));
        let goals = Goals::at(first).then(24, second).then(40, third);
        let (world, mut robot) = (case.world(), case.robot());
        if is_given {
            robot = robot.with_goals(goals.clone());
        }
        let span = Span::from_start(vec![0, 10, 24, 30, 40, 64]);
        let seen = world.run_one(&robot, &span);
        let moments = walk::moments(&world, &robot, &seen);
        let exported = Exported::of(&case);
        assert_eq!(exported.goal.is_some(), is_given, "{name}");
        let ground = Ground::from(&case.scene.physics);
        for ((&steps, state), moment) in seen.steps.iter().zip(&seen.states).zip(&moments) {
            let of_edge = |&edge: &usize| robot.body.strain[edge] * moment.activation[edge];
            let ours: Vec<f64> = exported.actuators.iter().map(of_edge).collect();
            let state = state.to_ground(&ground);
            let goal = goals.iter().nth(goals.place(steps)).unwrap();
            let there = exported.control(&state, steps, goal);
            let error = apart(&ours, &there);
            // Sums of up to 150 terms of order one, each with a rounding error of 1e-16, in another order.
            assert!(error < 1e-13, "{name}, {steps} steps: {error}");
            let other = exported.control(&state, steps, goal + Vector::upright(1.0, 0.0));
            assert_eq!(
                apart(&there, &other) > 1e-6,
                is_given,
                "{name}, {steps} steps"
            );
        }
    }
}

/// A new key of `[physics]` must be in the model, in the controller, or refused. `PHYSICS` says which.
#[test]
fn every_key_of_the_physics_is_known() {
    for setting in Scene::default().settings() {
        if let Some(key) = setting.key.strip_prefix("physics.") {
            assert!(mujoco::PHYSICS.contains(&key), "{key}");
        }
    }
}
