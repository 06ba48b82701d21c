//! Robots in space: they move like planar robots in the plane, turned about the vertical, mirrored, and in free flight; and
//! their gradients are right for every law.

use cosmic::case::Case;
use cosmic::geometry::{Dimension, Vector};
use cosmic::inputs::ALL;
use cosmic::lattice::State;
use cosmic::policy::{Controller, NETWORK, blocks_of};
use cosmic::scene::{LatticeKind, Scene};
use cosmic::world::{Span, Trajectory};
use cosmic_tests::{assert_smooth, farthest, laws, robot, robot_of, states};

/// A robot of 3x2x2 nodes that falls to the ground while it moves forward and sideways. `settings` is TOML as for [`robot`].
fn in_space(settings: &str) -> Case {
    let mut scene = laws::scene(settings);
    scene.lattice.kind = LatticeKind::Cubic;
    scene.lattice.depth = 2;
    let mut case = robot_of(scene);
    for (node, v) in case.start.v.iter_mut().enumerate() {
        *v += Vector::new([0.0, 0.3 + 0.013 * node as f64, 0.0]);
    }
    case
}

/// Puts a planar robot into space. Its nodes have no component across, and its network ignores these components.
fn put_into_space(planar: &Case) -> Case {
    let mut case = planar.clone();
    case.lattice.dimension = Dimension::Space;
    case.start.dimension = Dimension::Space;
    let (settings, blocks) = (
        &case.scene.controller,
        blocks_of(&case.scene.controller, &case.lattice),
    );
    let mut numbers = Vec::new();
    for (name, _, range) in planar.controller.blocks() {
        let block = &planar.controller.numbers()[range];
        if name != NETWORK[0] {
            numbers.extend_from_slice(block);
            continue;
        }
        let inputs = settings.observation_length(Dimension::Plane, case.lattice.nodes());
        for row in block.chunks_exact(inputs) {
            let (clocks, pairs) = row.split_at(settings.clocks);
            numbers.extend_from_slice(clocks);
            numbers.extend(
                pairs
                    .chunks_exact(2)
                    .flat_map(|pair| [pair[0], 0.0, pair[1]]),
            );
        }
    }
    case.controller = Controller::new(&blocks, numbers);
    case
}

/// The gradient of the loss with respect to z, x0 and v0.
fn gradient(case: &Case) -> [Vec<f64>; 3] {
    let mut inputs = case.inputs();
    let world = case.world();
    let (_, gradient) = inputs.differentiate(ALL, |inputs: &cosmic::inputs::Inputs<_>| {
        case.displacement_loss(&world, inputs)
    });
    inputs.set(ALL, &gradient);
    [
        inputs.z.into_flattened(),
        Dimension::Plane.flat(&inputs.start.x),
        Dimension::Plane.flat(&inputs.start.v),
    ]
}

#[test]
fn a_planar_robot_in_space_follows_the_planar_trajectory() {
    let worlds = [
        "",
        "physics = {contact = 'coulomb', friction = 0.4, incline_deg = 8}",
        "physics = {contact = 'coulomb', integrator = 'leapfrog', forces = ['damper', 'stops']}\nstops.at = 0.1",
        "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, incline_deg = 8}",
        "physics = {integrator = 'implicit', forces = ['damper', 'stops']}\nstops.at = 0.1",
        "physics = {integrator = 'implicit', contact = 'none'}",
        "controller = {goals = 'given', goal_scale = 3.0}\nobjective.task = 'reach'",
    ];
    for (k, settings) in worlds.into_iter().enumerate() {
        let mut planar = robot(settings);
        (planar.scene.physics.steps, planar.scene.physics.passes) = (256, 2 + k % 2);
        let embedded = put_into_space(&planar);
        for (a, b) in states(&planar).iter().zip(&states(&embedded)) {
            // Sums of squares have one more term, which is zero, so only their rounding may differ.
            assert!(farthest(a, b) < 1e-12, "{settings}: {}", farthest(a, b));
            assert!(b.x.iter().chain(&b.v).all(|x| x.sideways() == 0.0));
        }
        for (a, b) in gradient(&planar).iter().zip(&gradient(&embedded)) {
            let largest = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            for (a, b) in a.iter().zip(b) {
                // The reverse sweep amplifies rounding as the rollout does.
                assert!((a - b).abs() < 1e-10 * largest, "{settings}: {a} {b}");
            }
        }
    }
}

/// In steps of different lengths, an implicit step comes nearer to the explicit one in proportion to the length.
#[test]
fn short_implicit_steps_agree_with_explicit_ones() {
    for (contact, order) in [
        ("none", 0.9..1.1),
        ("infinite", 0.5..1.5),
        ("coulomb", 0.5..1.5),
    ] {
        let end = |integrator: &str, steps: usize| {
            let mut case = in_space(&format!(
                "physics = {{integrator = '{integrator}', contact = '{contact}', friction = 0.4}}"
            ));
            case.scene.physics.steps = steps;
            case.scene.physics.dt = 0.12 / steps as f64;
            states(&case).remove(steps)
        };
        let apart = [240, 960]
            .map(|steps| farthest(&end("implicit", steps), &end("symplectic_euler", steps)));
        // Four times as many steps.
        let observed = (apart[0] / apart[1]).log2() / 2.0;
        println!("{contact}: {apart:?}, order {observed}");
        assert!(order.contains(&observed), "{contact}: {apart:?}");
    }
}

/// A rollout with given activations, which do not depend on the direction in which the robot looks.
fn driven(case: &Case, start: &State<f64>) -> Trajectory<f64> {
    let world = case.world();
    let steps = case.scene.physics.steps;
    let edges = case.lattice.edges.len();
    let activations: Vec<f64> = (0..steps * edges).map(|k| (0.7 * k as f64).sin()).collect();
    let span = Span::from_start(vec![0, steps / 2, steps]);
    let robot = world.robot(case.body(), Controller::given(activations), start);
    world.run_one(&robot, &span)
}

/// The state with every point changed by `turn`.
fn changed(state: &State<f64>, turn: impl Fn(Vector<f64>) -> Vector<f64>) -> State<f64> {
    State {
        dimension: state.dimension,
        x: state.x.iter().map(|&x| turn(x)).collect(),
        v: state.v.iter().map(|&v| turn(v)).collect(),
    }
}

const SLIDING: [&str; 2] = [
    "physics = {contact = 'coulomb', friction = 0.4, forces = ['damper', 'bumpers']}",
    "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['damper', 'bumpers']}",
];

#[test]
fn a_turned_robot_makes_the_turned_motion() {
    for (settings, angle) in SLIDING
        .into_iter()
        .flat_map(|world| [0.3_f64, 1.9, -2.4].map(|angle| (world, angle)))
    {
        let case = in_space(settings);
        let (sin, cos) = angle.sin_cos();
        let turn = |x: Vector<f64>| {
            let (along, across) = (x.forward(), x.sideways());
            Vector::new([
                cos * along - sin * across,
                sin * along + cos * across,
                x.up(),
            ])
        };
        let here = driven(&case, &case.start);
        let there = driven(&case, &changed(&case.start, turn));
        for (a, b) in here.states.iter().zip(&there.states) {
            // Turning rounds positions at 1e-16, which ninety steps amplify by less than 1e4.
            let off = farthest(&changed(a, turn), b);
            assert!(off < 1e-12, "{angle}: {off:e}");
        }
    }
}

#[test]
fn a_robot_mirrored_across_makes_the_mirrored_motion() {
    let mirror = |x: Vector<f64>| Vector::new([x.forward(), -x.sideways(), x.up()]);
    for settings in SLIDING {
        let case = in_space(settings);
        let here = driven(&case, &case.start);
        let there = driven(&case, &changed(&case.start, mirror));
        for (a, b) in here.states.iter().zip(&there.states) {
            assert_eq!(&changed(a, mirror), b, "{settings}");
        }
    }
}

#[test]
fn momentum_and_angular_momentum_are_conserved_in_free_flight() {
    // Impulses of an implicit step act along the bars as they are at its end. So it loses some angular momentum: 0.7 %.
    for (integrator, bounds) in [
        ("symplectic_euler", [1e-10, 1e-10]),
        ("implicit", [1e-10, 2.5e-4]),
    ] {
        assert_conserves(integrator, bounds);
    }
}

fn assert_conserves(integrator: &str, bounds: [f64; 2]) {
    let world = "contact = 'none', gravity = 0.0, damping = 0.0";
    let mut case = in_space(&format!(
        "physics = {{integrator = '{integrator}', {world}}}"
    ));
    case.scene.physics.steps = 90;
    let masses = case.body().mass;
    let moments = |state: &State<f64>| {
        let nodes = || masses.iter().zip(state.x.iter().zip(&state.v));
        let momentum = nodes().fold(Vector::zero(), |sum, (&m, (_, &v))| sum + v * m);
        let spin = nodes().fold(Vector::zero(), |sum, (&m, (&x, &v))| {
            let ([a, b, c], [u, v, w]) = (x.array(), v.array());
            sum + Vector::new([b * w - c * v, c * u - a * w, a * v - b * u]) * m
        });
        [momentum, spin]
    };
    let seen = states(&case);
    let (first, last) = (moments(&seen[0]), moments(&seen[seen.len() - 1]));
    for ((a, b), bound) in first.into_iter().zip(last).zip(bounds) {
        assert!(a.norm() > 1e-3, "{a:?}");
        // Rounding of ninety steps; the softening changes arms of 0.1 m by a fraction of 5e-11.
        assert!(a.distance(b) < bound, "{integrator}: {a:?} {b:?}");
    }
}

#[test]
fn gradients_are_right_for_every_law() {
    assert_gradients(&[
        "",
        "physics = {contact = 'coulomb', friction = 0.4}",
        "physics.incline_deg = 15",
        "physics = {contact = 'coulomb', incline_deg = 15, friction = 0.4}",
        "physics = {contact = 'coulomb', integrator = 'leapfrog', friction = 0.3}",
        "physics = {contact = 'coulomb', substeps = 3, friction = 0.3}",
        "lattice.body_diagonals = true",
        "physics = {contact = 'coulomb', friction = 0.4, forces = ['damper', 'stops']}\nstops.at = 0.05",
        "physics = {contact = 'coulomb', friction = 0.4, forces = ['actuator']}\nactuator = {force = 0.1, speed = 4.0}",
        "physics.forces = ['rope']\nrope = {actuator = 0.0, skeleton = 0.5}",
        "physics.forces = ['bar_formula', 'node_formula']\n\
         bar_formula.tension = '0.2 * stiffness * (length - rest_length)'\n\
         node_formula = {force_x = '-0.02 * vx * abs(vx)', force_y = '0.01 * sin(9 * y) - 0.02 * vy'}",
        "physics = {contact = 'coulomb', friction = 0.4, forces = ['damper', 'bumpers']}\nbumpers.distance = 0.9",
        "physics.forces = ['wind']",
        "physics.forces = ['magnet', 'stiffening']",
        "physics.contact = 'mud'",
    ]);
}

#[test]
fn gradients_of_implicit_steps_are_right() {
    assert_gradients(&[
        "physics.integrator = 'implicit'",
        "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, incline_deg = 15}",
        "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.3, substeps = 2, \
         forces = ['damper', 'stops', 'stiffening']}\nstops.at = 0.05",
        "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['actuator', 'rope']}\n\
         actuator = {force = 0.1, speed = 4.0}\nrope = {actuator = 0.0, skeleton = 0.5}",
        "physics = {integrator = 'implicit', contact = 'coulomb', friction = 0.4, forces = ['bumpers']}\n\
         bumpers = {distance = 0.9, reach = 1}",
        "physics = {integrator = 'implicit', contact = 'none', forces = ['wind']}",
    ]);
}

fn assert_gradients(worlds: &[&str]) {
    for (k, settings) in worlds.iter().enumerate() {
        let mut case = in_space(settings);
        (case.scene.physics.steps, case.scene.physics.passes) = (60, 2 + k % 2);
        assert_smooth(settings, &case);
    }
}

#[test]
fn bars_of_a_cube_hold_it_rigid() {
    use cosmic::design::{Material, Structure};
    let case = in_space("");
    let layout = vec![Material::Skeleton; case.lattice.edges.len()];
    // Face diagonals make every cell rigid: 3 n - 6 - rank is 0.
    assert_eq!(Structure::new(&case.lattice, &layout).floppy_modes, Some(0));
}

/// How far a node is from the image of its image after 256 steps, at most, m. The robot walks on a slope, and its
/// payload is in the middle of its back.
fn skewness(settings: &str) -> f64 {
    let text = format!(
        "base = 'cube'\nlattice.columns = 3\nlattice.rows = 2\nlattice.payload = 3\nphysics.incline_deg = 5\n\
         controller.hidden = 6\n{settings}"
    );
    let mut scene = Scene::parse("sides", &text).unwrap();
    scene.physics.steps = 256;
    let case = Case::of_scene(&scene, 1).unwrap();
    let image = case.lattice.image().unwrap();
    let moved = states(&case).pop().unwrap();
    let middle = case.start.x[3].sideways();
    let nodes = image.nodes.iter().enumerate();
    let differences = nodes.map(|(node, &other)| {
        let [x, y] = [moved.x[node], moved.x[other]];
        let across = x.sideways() - middle + (y.sideways() - middle);
        across.abs().max((x.up() - y.up()).abs())
    });
    differences.fold(0.0, f64::max)
}

/// A robot in space that is its own mirror image stays on course with every network; without `mirror` it veers.
#[test]
fn a_robot_with_equal_sides_stays_on_course() {
    for policy in ["controller.policy = 'mlp'", "controller.policy = 'clock'"] {
        let [mirrored, other] =
            ["", "lattice.mirror = false\n"].map(|mirror| skewness(&format!("{mirror}{policy}")));
        // Rounding of positions near 0.3 m, amplified in 256 steps.
        assert!(mirrored < 1e-12, "{policy}: {mirrored}");
        assert!(other > 1e-6, "{policy}: {other}");
    }
}
