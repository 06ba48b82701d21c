use crate::small::lattice;
use cosmic::geometry::Ground;
use cosmic::lattice::{Lattice, State};
use cosmic::policy::{Controller, Network, Sight, clock, observation};
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::scene::{ControllerSettings, GoalKind, Scene};

/// The inputs of the folded network: the state in the ground's frame and the clock.
fn sensed(state: &State<f64>, clock: &[f64]) -> Vec<f64> {
    [&state.to_columns()[..], clock].concat()
}

fn random_state(nodes: usize) -> State<f64> {
    let mut stream = stream(1, Purpose::Judgement);
    let mut points = || -> Vec<[f64; 2]> {
        let point = |_| [(); 2].map(|()| symmetric(&mut stream, 1.0));
        (0..nodes).map(point).collect()
    };
    State::new(points(), points())
}

/// Checks that two networks compute the same activations: the folded network from the state, and the original
/// network from the observation.
fn check(settings: &ControllerSettings, presence: &[f64], ground: &Ground) {
    let lattice = lattice(3, 2, 0.0);
    let state = random_state(lattice.nodes());
    let controller = Controller::xavier(settings, &lattice, 0);
    let mut network = Network::of(&controller, settings, &lattice).unwrap();
    network.first.biases.fill(0.2);
    network.second.biases.fill(-0.1);
    let phase = settings.omega * (4096.0 * 0.002);
    let observed = observation(settings, phase, &state, presence, ground);
    let goal = &observed[settings.clocks..][..2];
    let plain = network.activation(&observed, [goal[0], 0.0]);
    let mut sensed = sensed(&state.to_ground(ground), &clock(phase));
    if settings.goals == GoalKind::Given {
        sensed.extend(goal);
    }
    let nodes = (lattice.dimension, lattice.nodes());
    let folded = network.folded(settings, nodes, Sight::Robot, presence, ground);
    let got = folded.activation(&sensed, [goal[0], 0.0]);
    assert_eq!(got.len(), plain.len());
    for (a, b) in got.iter().zip(&plain) {
        // Each sum has about thirty terms of order one, each with a rounding error of 1e-16. The phase of a clock
        // is near 82 rad, with a rounding error of 1e-14.
        assert!((a - b).abs() < 1e-13);
    }
}

#[test]
fn folding_changes_nothing_but_the_rounding() {
    for incline_deg in [0.0, 15.0, -40.0] {
        for (goal_relative, clocks) in [(false, 10), (true, 10), (true, 3), (false, 0)] {
            let settings = ControllerSettings {
                hidden: 7,
                clocks,
                goal_scale: 0.7,
                goal_relative,
                offset_scale: 1.3,
                velocity_scale: 0.4,
                ..ControllerSettings::default()
            };
            let ground = Ground { incline_deg };
            let errand = Scene::load("errand").unwrap().controller;
            for settings in [settings, errand] {
                check(&settings, &[], &ground);
                check(&settings, &[1.0, 0.3, 0.0, 0.9, 1e-3, 1.0], &ground);
            }
        }
    }
}

#[test]
fn the_network_has_the_paper_s_shapes_and_glorot_weights() {
    let mut scene = Scene::paper();
    scene.controller.gain = [2.0, 1.0];
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let controller = Controller::xavier(&scene.controller, &lattice, 0);
    let Network { first, second, .. } =
        Network::of(&controller, &scene.controller, &lattice).unwrap();
    let lengths = [
        &first.weights,
        &first.biases,
        &second.weights,
        &second.biases,
    ]
    .map(Vec::len);
    assert_eq!(lengths, [32 * 156, 32, 110 * 32, 110]);
    let largest = |w: &[f64]| w.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    // With thousands of draws, the largest draw is within a per cent of the limit.
    for (layer, limit) in [
        (&first, 2.0 * (6.0f64 / 188.0).sqrt()),
        (&second, (6.0f64 / 142.0).sqrt()),
    ] {
        let weights = largest(&layer.weights);
        assert!(weights <= limit && weights > 0.99 * limit);
        assert!(layer.biases.iter().all(|&b| b == 0.0));
    }
}
