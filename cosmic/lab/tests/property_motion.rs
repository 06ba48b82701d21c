//! What holds of every robot's motion.

use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::policy::{Controller, NETWORK, observation_length};
use cosmic::scene::{Scene, StartKind};
use cosmic::simulator::{Span, Trajectory};
use cosmic_lab::verify::stability::{Outcome, Trial, World};
use proptest::prelude::*;

/// Steps of a motion: a few times the fastest vibration, and not enough for chaos to make
/// anything of a rounding.
const STEPS: usize = 48;

/// A robot of 2x2 to 3x3 nodes with any mixture of materials, any controller and any velocities,
/// in the default world.
fn robots() -> impl Strategy<Value = Case> {
    let sizes = (2..=3usize, 2..=3usize, any::<u64>());
    sizes.prop_flat_map(|(columns, rows, seed)| {
        let mut scene = Scene::paper();
        (scene.lattice.columns, scene.lattice.rows) = (columns, rows);
        (scene.start.kind, scene.controller.hidden) = (StartKind::Uniform, 3);
        scene.physics.steps = STEPS;
        let case = Case::of_scene(&scene, seed).unwrap();
        let (edges, nodes) = (case.lattice.edges.len(), case.lattice.nodes());
        let z = prop::collection::vec(prop::array::uniform3(0.0..1.0), edges);
        let v = prop::collection::vec(prop::array::uniform2(-1.0..1.0), nodes);
        (z, v).prop_map(move |(z, v)| {
            let mut case = case.clone();
            (case.design, case.start.v) = (Design::Undecided(z), v);
            case
        })
    })
}

fn run(case: &Case) -> Trajectory<f64> {
    let design = case.own_design();
    let span = Span::from_start((0..=case.physics.steps).collect());
    let task = case.task();
    task.rollout(&design, &case.controller, &case.start, &span)
}

fn masses(case: &Case) -> Vec<f64> {
    case.body().mass
}

/// `sum m p`, and `sum m |p|` for scale.
fn moment(masses: &[f64], points: &[[f64; 2]]) -> ([f64; 2], f64) {
    let mut total = [0.0; 2];
    let mut scale = 0.0;
    for (m, p) in masses.iter().zip(points) {
        for k in 0..2 {
            total[k] += m * p[k];
            scale += m * p[k].abs();
        }
    }
    (total, scale)
}

/// Weights by which a robot seen in a mirror acts as its picture does: those on horizontal
/// offsets, velocities and goals have their signs turned.
fn mirrored(case: &Case) -> Controller<f64> {
    let mut controller = case.controller.clone();
    let clocks = case.observation.clocks;
    let inputs = observation_length(&case.observation, case.lattice.nodes());
    for row in controller.block_mut(NETWORK[0]).chunks_exact_mut(inputs) {
        // After the clocks pairs of x and y: goal, offsets, velocities.
        row[clocks..].iter_mut().step_by(2).for_each(|w| *w = -*w);
    }
    controller
}

fn mirror(state: &State<f64>) -> State<f64> {
    let turn = |points: &[[f64; 2]]| points.iter().map(|[x, y]| [-x, *y]).collect();
    State {
        x: turn(&state.x),
        v: turn(&state.v),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Edges push and pull their ends alike, whatever the controller tells them.
    #[test]
    fn momentum_is_conserved_where_nothing_acts_from_outside(mut case in robots()) {
        (case.physics.gravity, case.physics.damping) = (0.0, 0.0);
        case.physics.ground_height = -1e3;
        let masses = masses(&case);
        let seen = run(&case);
        let (start, _) = moment(&masses, &case.start.v);
        let (centre, _) = moment(&masses, &case.start.x);
        for (n, state) in seen.states.iter().enumerate() {
            let (now, scale) = moment(&masses, &state.v);
            // Each step rounds every velocity, and the sums here, at 1e-16 of their terms.
            let tolerance = 1e-15 * (n + 10) as f64 * (scale + 1.0);
            let time = n as f64 * case.physics.dt;
            let (place, scale) = moment(&masses, &state.x);
            for k in 0..2 {
                prop_assert!((now[k] - start[k]).abs() < tolerance);
                let expected = centre[k] + time * start[k];
                // Positions near the ground far below are rounded like numbers of its size.
                prop_assert!((place[k] - expected).abs() < 1e-12 * (scale + 1.0));
            }
        }
    }

    /// The controller sees offsets from the mean alone.
    #[test]
    fn motion_does_not_hang_on_the_place(
        mut case in robots(),
        moved in prop::array::uniform2(-4.0..4.0),
        coulomb in any::<bool>(),
    ) {
        // In the air at first: on the ground's very line rounding decides what touches.
        case.start.x.iter_mut().for_each(|x| x[1] += 0.01);
        if coulomb {
            case.physics.contact = ContactLaw::coulomb();
        }
        let here = run(&case);
        case.physics.ground_height += moved[1];
        for x in &mut case.start.x {
            *x = [x[0] + moved[0], x[1] + moved[1]];
        }
        let there = run(&case);
        for (a, b) in here.states.iter().zip(&there.states) {
            for (a, b) in a.x.iter().zip(&b.x) {
                // Positions near 4 are rounded at 4e-16, and neighbouring motions part by less
                // than a factor of 1e3 in so few steps.
                let off: [f64; 2] = [0, 1].map(|k: usize| f64::abs(b[k] - a[k] - moved[k]));
                prop_assert!(off[0].max(off[1]) < 1e-11, "{off:?}");
            }
        }
    }

    /// To the last bit: no operation of a step prefers a side.
    #[test]
    fn a_mirrored_robot_moves_in_mirrored_ways(mut case in robots(), coulomb in any::<bool>()) {
        if coulomb {
            case.physics.contact = ContactLaw::coulomb();
        }
        let seen = run(&case);
        case.controller = mirrored(&case);
        case.observation.goal[0] = -case.observation.goal[0];
        case.start = mirror(&case.start);
        let mirrored = run(&case);
        for (a, b) in seen.states.iter().zip(&mirrored.states) {
            prop_assert_eq!(&mirror(a), b);
        }
    }

    #[test]
    fn a_stable_step_keeps_the_energy_and_an_unstable_one_does_not(
        case in robots(),
        share in prop_oneof![0.1..0.96, 1.05..3.0],
        damping in prop_oneof![Just(0.0), 0.0..100.0],
    ) {
        let mut case = case;
        case.start.v.fill([0.0; 2]);
        (case.physics.steps, case.physics.damping) = (256, damping);
        let trial = Trial::new("any", "any", case, World::Free);
        if trial.limit.is_infinite() {
            return Err(TestCaseError::reject("nothing vibrates"));
        }
        let found = trial.at(share).run();
        prop_assert!(found.is_ok(), "{:?}", found);
        prop_assert_eq!(found.outcome == Outcome::Bounded, share < 1.0);
    }
}
