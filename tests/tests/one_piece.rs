//! Robots with `design.one_piece`, whose nodes have a weight that depends on how solid their edges are. The tests cover
//! gradients and the snap.

use cosmic::case::Case;
use cosmic::design::{Design, Material, Mixture};
use cosmic::inputs::DESIGN;
use cosmic::lattice::State;
use cosmic::scene::Scene;
use cosmic::world::Span;

const STEPS: usize = 60;

/// A robot in the air whose controller reacts more to the nodes than to the clock. One node has edges that are almost
/// void.
fn robot() -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.lattice.drop, scene.physics.steps) = (1.0, STEPS);
    scene.design.one_piece = true;
    scene.controller.hidden = 6;
    (
        scene.controller.offset_scale,
        scene.controller.velocity_scale,
    ) = (3.0, 1.0);
    let mut case = Case::of_scene(&scene, 3).unwrap();
    for (i, v) in case.start.v.iter_mut().enumerate() {
        *v = [(i as f64).sin(), (2.0 * i as f64).cos()].into();
    }
    let z = case.design.undecided_mut().expect("a start of mixtures");
    for (e, z) in z.iter_mut().enumerate() {
        let near = case.lattice.edges[e].contains(&8);
        *z = if near {
            [0.45, 0.3, 0.35]
        } else {
            [0.3, 0.33, 0.34 + 0.003 * e as f64]
        };
    }
    case
}

/// Simulates a robot with this design and returns its last state.
fn end(case: &Case, design: &Design<Mixture<f64>>, start: &State<f64>) -> State<f64> {
    let world = case.world();
    let robot = world.robot(world.body(design), case.controller.clone(), start);
    (world.run_one(&robot, &Span::of_steps(STEPS)).states).remove(0)
}

/// The largest distance between the positions of a node in two states, m. Only nodes for which `nodes` is true count.
fn farthest(a: &State<f64>, b: &State<f64>, nodes: impl Fn(usize) -> bool) -> f64 {
    let pairs = a.x.iter().zip(&b.x).enumerate();
    let pairs = pairs.filter(|(node, _)| nodes(*node));
    pairs.fold(0.0, |most, (_, (a, b))| most.max(a.distance(*b)))
}

#[test]
fn gradients_flow_through_the_presence_of_nodes() {
    let case = robot();
    let presence = case.body().presence;
    assert!((0.1..0.9).contains(&presence[8]), "{presence:?}");
    // The presence of nodes contributes noticeably to the design gradient: without it, the gradient is different.
    let gradient = |one_piece: bool| {
        let mut other = case.clone();
        other.scene.design.one_piece = one_piece;
        let world = other.world();
        let (_, gradient) = other
            .inputs()
            .differentiate(DESIGN, |inputs| other.displacement_loss(&world, inputs));
        gradient
    };
    let [with, without] = [true, false].map(gradient);
    let size = |g: &[f64]| g.iter().map(|g| g * g).sum::<f64>().sqrt();
    let off: Vec<f64> = with.iter().zip(&without).map(|(a, b)| a - b).collect();
    assert!(
        size(&off) > 0.1 * size(&with),
        "{} of {}",
        size(&off),
        size(&with)
    );
}

/// A layout that has bars only along and across the cell at node 0.
fn cell(case: &Case) -> Vec<Material> {
    let material = |ends: &[usize; 2]| match ends {
        [0, 1] | [1, 0] => Material::Actuator,
        _ if ends.iter().all(|node| [0, 1, 3, 4].contains(node)) => Material::Skeleton,
        _ => Material::Void,
    };
    case.lattice.edges.iter().map(material).collect()
}

/// The motion does not jump when every edge gets a single material: as each edge approaches one material, the motion
/// with mixtures converges to the motion with the layout.
#[test]
fn nothing_jumps_at_the_snap() {
    let case = robot();
    let layout = Design::Layout(cell(&case));
    let live = |node: usize| [0, 1, 3, 4].contains(&node);
    let snapped = end(&case, &layout, &case.start);
    let off = |rest: f64| {
        let soft = |m: &Mixture<f64>| m.0.map(|share| share * (1.0 - 3.0 * rest) + rest);
        let soft: Vec<_> = layout.mixtures().iter().map(soft).collect();
        let soft = end(&case, &Design::of_shares(&soft), &case.start);
        farthest(&soft, &snapped, live)
    };
    // The difference between the motions is proportional to the shares that the other materials still have.
    let [far, near] = [1e-5, 1e-7].map(off);
    assert!(far > 0.0 && near < 0.02 * far, "{far} {near}");
    // If all nodes had equal weights, the robot with the layout would observe something else, and the motion would
    // jump.
    let mut alike = case.clone();
    alike.scene.design.one_piece = false;
    assert!(farthest(&end(&alike, &layout, &case.start), &snapped, live) > 10.0 * far);
}
