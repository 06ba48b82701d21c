//! Nodes without a bar are no part of a finished robot. Plain numbers, forward mode and reverse mode must all see the
//! same robot: such a node stays where it starts, at rest.

use autodiff::{Dual, Parameters, Real, Var};
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::inputs::{ALL, Inputs};
use cosmic::lattice::{Body, State};
use cosmic::scene::{MovedBody, Scene, VoidEdges};
use cosmic::world::{Robot, Span, Trajectory, World};
use std::sync::Arc;

const STEPS: usize = 60;

/// A finished robot whose highest row has no bar, and which flies with a speed of its own for every node.
fn robot(scene: &str, change: impl Fn(&mut Scene)) -> Case {
    let mut scene = Scene::load(scene).unwrap();
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.lattice.drop, scene.physics.steps) = (1.0, STEPS);
    scene.design.one_piece = true;
    change(&mut scene);
    let mut case = Case::of_scene(&scene, 3).unwrap();
    let material = |(edge, ends): (usize, &[usize; 2])| match ends.iter().any(|&node| node > 5) {
        true => Material::Void,
        false => [Material::Skeleton, Material::Actuator, Material::Void][edge % 3],
    };
    case.design = Design::Layout(
        case.lattice
            .edges
            .iter()
            .enumerate()
            .map(material)
            .collect(),
    );
    for (node, v) in case.start.v.iter_mut().enumerate() {
        *v = [0.3 * (node as f64).sin(), 0.3 * (2.0 * node as f64).cos()].into();
    }
    case
}

/// Robots for every kind of step and every kind of marker.
fn robots() -> Vec<(&'static str, Case)> {
    vec![
        ("explicit", robot("earth", |_| ())),
        (
            "infinite friction, void edges",
            robot("stability", |s| s.physics.void_edges = VoidEdges::Keep),
        ),
        ("implicit", robot("workshop", |_| ())),
        ("substeps", robot("earth", |s| s.physics.substeps = 2)),
        (
            "centre of mass",
            robot("earth", |s| s.objective.body = MovedBody::Mass),
        ),
        (
            "mean of nodes",
            robot("earth", |s| s.objective.body = MovedBody::Nodes),
        ),
        (
            "on the ground",
            robot("stability", |s| s.lattice.drop = 0.004),
        ),
    ]
}

fn layout(case: &Case) -> &[Material] {
    case.design.layout().expect("the robot is finished")
}

fn body<R: Real>(case: &Case, inputs: &Inputs<R>) -> Body<R> {
    case.world().body_near(layout(case), &inputs.z)
}

fn span() -> Span {
    Span::from_start(vec![0, STEPS / 2, STEPS])
}

/// Positions and velocities of all nodes in all observed states, and the place of the marker at the end.
fn numbers<R: Real>(seen: &Trajectory<R>) -> Vec<R> {
    let states = seen.states.iter();
    let states = states.flat_map(|state| state.to_flat().concat());
    states.chain(seen.position(STEPS).in_plane()).collect()
}

fn seen<R: Real>(case: &Case, inputs: &Inputs<R>) -> Vec<R> {
    let (world, controller) = (case.world(), inputs.controller.clone());
    let robot = world.robot(body(case, inputs), controller, &inputs.start);
    numbers(&world.run_one(&robot, &span()))
}

/// Numbers without a pattern, between -1 and 1.
fn random(count: usize, seed: f64) -> Vec<f64> {
    (0..count)
        .map(|k| (1e4 * (12.9898 * k as f64 + seed).sin()).sin())
        .collect()
}

/// True if the numbers of two rollouts differ by rounding only. Forward mode, and lanes in implicit steps, add in another
/// order; sixty steps turn 1e-16 into less than 1e-11.
fn are_close(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-11)
}

#[test]
fn near_its_layout_a_robot_has_the_bits_of_its_layout() {
    for (name, case) in robots() {
        let inputs = case.inputs();
        let whole = case.world().run_one(&case.robot(), &span());
        assert_eq!(seen(&case, &inputs), numbers(&whole), "{name}");
        let State { x, v, .. } = &whole.states[2];
        for node in [6, 7, 8] {
            assert_eq!(
                (x[node], v[node].in_plane()),
                (case.start.x[node], [0.0; 2]),
                "{name}"
            );
        }
    }
}

#[test]
fn reverse_mode_forward_mode_and_differences_see_the_same_robot() {
    for (name, case) in robots() {
        let inputs = case.inputs();
        let plain = seen(&case, &inputs);
        let cotangents = random(plain.len(), 0.1);
        let (values, gradient) = inputs.vjp(ALL, |inputs| seen(&case, inputs), &cotangents);
        assert_eq!(values, plain, "{name}");
        for seed in [0.2, 0.3, 0.4] {
            let own = inputs.get(ALL);
            let direction = random(own.len(), seed);
            let at = |h: f64| {
                let mut moved = inputs.clone();
                let numbers = own.iter().zip(&direction).map(|(x, d)| x + h * d);
                moved.set(ALL, &numbers.collect::<Vec<_>>());
                moved
            };
            let mut tangents = inputs.clone();
            tangents.set(ALL, &direction);
            let (values, along) = inputs.jvp(&tangents, |inputs| seen(&case, inputs));
            assert!(are_close(&values, &plain), "{name}");
            let (reverse, forward) = (
                f64::dot(&gradient, &direction),
                f64::dot(&along, &cotangents),
            );
            // The two modes differ by rounding, which the chaos of sixty steps does not yet amplify.
            assert!(
                (reverse - forward).abs() < 1e-9 * forward.abs().max(1.0),
                "{name}: {reverse} {forward}"
            );
            // An implicit step counts negative slopes as 0, so a void bar's stiffness of 0 is a kink of its equations.
            if name == "implicit" {
                continue;
            }
            let difference = |h: f64| {
                let [ahead, behind] = [h, -h].map(|h| f64::dot(&seen(&case, &at(h)), &cotangents));
                (ahead - behind) / (2.0 * h)
            };
            // A step of 1e-6 leaves an error of 1e-12 times the third derivative and 1e-10 of rounding. Where a node
            // lands in another step within a stencil, a smaller one is right.
            let off = [1e-6, 1e-7].map(|h| (difference(h) - reverse).abs());
            let most = 1e-5 * reverse.abs().max(1.0);
            assert!(
                off.iter().any(|off| *off < most),
                "{name}: {reverse}, off by {off:?}"
            );
        }
    }
}

#[test]
fn single_precision_has_the_same_gradient() {
    for (name, case) in robots() {
        let inputs = case.inputs();
        let bars = random(seen(&case, &inputs).len(), 0.5);
        let (_, exact) = inputs.vjp(ALL, |inputs| seen(&case, inputs), &bars);
        let narrow = |x: &f64| *x as f32;
        let single = Inputs {
            z: inputs.z.iter().map(|z| z.map(|z| z as f32)).collect(),
            controller: inputs.controller.map(|x| x as f32),
            start: inputs.start.map(|x| x as f32),
        };
        let bars: Vec<f32> = bars.iter().map(narrow).collect();
        let (_, gradient) = single.vjp(ALL, |inputs| seen(&case, inputs), &bars);
        let size = f64::dot(&exact, &exact).sqrt();
        let off: Vec<f64> = exact
            .iter()
            .zip(&gradient)
            .map(|(a, &b)| a - f64::from(b))
            .collect();
        // Sixty steps of single precision, whose rounding is 6e-8.
        assert!(f64::dot(&off, &off).sqrt() < 1e-3 * size, "{name}");
    }
}

/// The robot of a case, and a robot that has all bars. They share their controller.
fn pair<R: Real>(case: &Case, world: &World, inputs: &Inputs<R>) -> [Robot<R>; 2] {
    let whole = vec![Material::Skeleton; case.lattice.edges.len()];
    let one_hot = vec![Material::Skeleton.one_hot().map(R::lit); whole.len()];
    let controller = Arc::new(inputs.controller.clone());
    [body(case, inputs), world.body_near(&whole, &one_hot)]
        .map(|body| world.robot(body, Arc::clone(&controller), &inputs.start))
}

#[test]
fn robots_with_other_nodes_in_one_batch_have_their_own_gradients() {
    for (name, case) in robots() {
        let (inputs, world) = (case.inputs(), case.world());
        let together = |inputs: &Inputs<Var<f64>>| {
            let walks = world.run(&pair(&case, &world, inputs), &span());
            walks.iter().flat_map(numbers).collect()
        };
        let alone = |inputs: &Inputs<Var<f64>>| {
            let robots = pair(&case, &world, inputs);
            let walks = robots.map(|robot| world.run_one(&robot, &span()));
            walks.iter().flat_map(numbers).collect()
        };
        let bars = random(2 * seen(&case, &inputs).len(), 0.6);
        let (values, gradient) = inputs.vjp(ALL, |inputs| together(inputs), &bars);
        let (expected, of_each) = inputs.vjp(ALL, |inputs| alone(inputs), &bars);
        assert!(are_close(&values, &expected), "{name}");
        let off: Vec<f64> = gradient.iter().zip(&of_each).map(|(a, b)| a - b).collect();
        // The sums are in another order, as in `are_close`, and stiff bars multiply the rounding.
        assert!(
            f64::dot(&off, &off).sqrt() < 1e-6 * f64::dot(&of_each, &of_each).sqrt(),
            "{name}"
        );
    }
}

/// A design that is still undecided may have shares of void that are exactly 1 although they have derivatives: those of
/// the sharp projection, whose derivative is that of a softer one.
#[test]
fn the_value_of_presence_decides_in_every_mode() {
    let case = robot("stability", |_| ());
    let start = &case.start;
    let shares = |z: f64| -> Vec<[f64; 3]> {
        let one_hot = layout(&case).iter().map(|material| material.one_hot());
        one_hot
            .map(|[void, skeleton, actuator]| [void * z, skeleton, actuator])
            .collect()
    };
    let end = |z: Vec<[Dual<f64, 1>; 3]>| {
        let (world, controller) = (case.world(), case.controller.map(Dual::constant));
        let body = world.body(&Design::of_shares(&z));
        let robot = world.robot(body, controller, &start.map(Dual::constant));
        world.run_one(&robot, &span()).states[2].x[8]
    };
    let moved = |tangent: f64| {
        let z = shares(1.0).into_iter().map(|row| {
            row.map(|value| Dual {
                value,
                tangent: [tangent],
            })
        });
        end(z.collect()).map(|x| x.value)
    };
    assert_eq!(moved(0.0), start.x[8]);
    assert_eq!(moved(1.0), start.x[8]);
}
