//! Symmetries and conserved quantities of the motion, which hold for every robot.

use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::policy::{Controller, NETWORK};
use cosmic::scene::{Scene, StartKind};
use cosmic_tests::{laws, states};
use proptest::prelude::*;

/// The number of steps of a motion: enough for a few periods of the fastest vibration, but too few for chaos to amplify
/// rounding errors.
const STEPS: usize = 48;

/// Random robots of 2x2 to 3x3 nodes in the default world, with any mixtures, any controller and any velocities.
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
            let v = v.into_iter().map(Vector::from).collect();
            (case.design, case.start.v) = (Design::Undecided(z), v);
            case
        })
    })
}

/// The sum of mass times point, `sum m p`. Also the sum `sum m |p|`, to which the rounding error is proportional.
fn moment(masses: &[f64], points: &[Vector<f64>]) -> (Vector<f64>, f64) {
    let mut total = Vector::zero();
    let mut scale = 0.0;
    for (m, p) in masses.iter().zip(points) {
        total += *p * *m;
        scale += m * p.array().into_iter().map(|x| x.abs()).sum::<f64>();
    }
    (total, scale)
}

/// The controller of the mirrored robot: the weights of horizontal offsets, velocities and goals have the opposite
/// sign.
fn mirrored(case: &Case) -> Controller<f64> {
    let mut controller = case.controller.clone();
    let clocks = case.scene.controller.clocks;
    let inputs = case
        .scene
        .controller
        .observation_length(case.lattice.dimension, case.lattice.nodes());
    for row in controller.block_mut(NETWORK[0]).chunks_exact_mut(inputs) {
        // The inputs after the clocks are pairs of x and y: goal, offsets, velocities.
        row[clocks..].iter_mut().step_by(2).for_each(|w| *w = -*w);
    }
    controller
}

fn mirror(state: &State<f64>) -> State<f64> {
    let turn = |points: &[Vector<f64>]| points.iter().map(|x| (-*x).with_up(x.up())).collect();
    State {
        x: turn(&state.x),
        v: turn(&state.v),
        ..*state
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Momentum and angular momentum (spin) are conserved: an edge pulls both of its ends equally, and bars that resist
    /// bending do not turn the robot. This holds for any controller.
    #[test]
    fn momentum_and_spin_are_conserved_without_forces_from_outside(
        mut case in robots(),
        bends in any::<bool>(),
    ) {
        (case.scene.physics.gravity, case.scene.physics.damping) = (0.0, 0.0);
        case.scene.physics.contact = ContactLaw::none();
        if bends {
            case.scene.physics.forces = laws::forces("physics.forces = ['bending']\nbending.radius = 0.02");
        }
        let masses = case.body().mass;
        let seen = states(&case);
        let spin = |state: &State<f64>| -> f64 {
            let nodes = masses.iter().zip(state.x.iter().zip(&state.v));
            nodes.map(|(m, (x, v))| m * x.cross(*v)).sum()
        };
        let turned = (spin(&seen[STEPS]) - spin(&seen[0])).abs();
        // The softening lengthens an arm of 0.1 m by a fraction of 5e-11, and different arms by different fractions.
        prop_assert!(turned < 1e-10, "{turned:e}");
        let (start, _) = moment(&masses, &case.start.v);
        let (centre, _) = moment(&masses, &case.start.x);
        for (n, state) in seen.iter().enumerate() {
            let (now, scale) = moment(&masses, &state.v);
            // Velocities are rounded in each step, and the sums are rounded here once more, at 1e-16 of their terms.
            let tolerance = 1e-15 * (n + 10) as f64 * (scale + 1.0);
            let time = n as f64 * case.scene.physics.dt;
            let (place, scale) = moment(&masses, &state.x);
            let [now, start, centre, place] = [now, start, centre, place].map(Vector::in_plane);
            for k in 0..2 {
                prop_assert!((now[k] - start[k]).abs() < tolerance);
                let expected = centre[k] + time * start[k];
                // Positions are below 1 m, and rounded like velocities.
                prop_assert!((place[k] - expected).abs() < 1e-15 * (n + 10) as f64 * (scale + 1.0));
            }
        }
    }

    /// If the start is moved along the ground, the robot makes the same motion there: the controller observes offsets of
    /// nodes from their mean, not positions.
    #[test]
    fn motion_does_not_depend_on_the_place(
        mut case in robots(),
        moved in -4.0..4.0,
        coulomb in any::<bool>(),
    ) {
        // The robot starts in the air. If it started exactly on the ground, rounding would decide which nodes touch.
        case.start.x.iter_mut().for_each(|x| *x = x.with_up(x.up() + 0.01));
        if coulomb {
            case.scene.physics.contact = ContactLaw::coulomb();
        }
        let here = states(&case);
        let moved = Vector::upright(moved, 0.0);
        for x in &mut case.start.x {
            *x += moved;
        }
        let there = states(&case);
        for (a, b) in here.iter().zip(&there) {
            for (a, b) in a.x.iter().zip(&b.x) {
                // Positions near 4 are rounded at 4e-16. In so few steps, the motion amplifies this error by less than
                // 1e3.
                let off = (*b - *a).distance(moved);
                prop_assert!(off < 1e-11, "{off:?}");
            }
        }
    }

    /// A mirrored robot makes the mirrored motion, with the same bits, because no operation of a step prefers a side.
    #[test]
    fn a_mirrored_robot_moves_as_the_mirror_image(mut case in robots(), coulomb in any::<bool>()) {
        if coulomb {
            case.scene.physics.contact = ContactLaw::coulomb();
        }
        let seen = states(&case);
        case.controller = mirrored(&case);
        let goal = case.scene.controller.goal;
        case.scene.controller.goal = goal.with_forward(-goal.forward());
        case.start = mirror(&case.start);
        let mirrored = states(&case);
        for (a, b) in seen.iter().zip(&mirrored) {
            prop_assert_eq!(&mirror(a), b);
        }
    }
}
