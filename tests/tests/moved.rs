//! The part of the robot whose displacement counts (`objective.body`), and the node of the payload.

use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::scene::{MovedBody, Named, Scene};
use cosmic::search::CoDesign;

/// A small robot whose payload is the middle node of the upper row.
const SCENE: &str = "
base = 'stability'
[lattice]
columns = 3
rows = 2
payload = 4
[physics]
steps = 64
[controller]
hidden = 4
gain = [6.0, 6.0]
[schedule]
iterations = 8
attraction_from = 4
snap_at = 6
horizon = [32, 64]
[loss]
window = 16
";

/// The small robot, whose displacement is that of `body`.
fn scene(body: MovedBody) -> Scene {
    let mut scene = Scene::parse("moved", SCENE).unwrap();
    scene.objective.body = body;
    scene
}

/// The weighted mean of the displacements of the nodes.
fn mean(weights: &[f64], from: &[Vector<f64>], to: &[Vector<f64>]) -> f64 {
    let nodes = weights.iter().zip(from.iter().zip(to));
    let moved: f64 = nodes
        .map(|(w, (from, to))| w * (to.forward() - from.forward()))
        .sum();
    moved / weights.iter().sum::<f64>()
}

/// A case keeps the body and the payload in its file, and its displacement is that of the body.
#[test]
fn an_evaluation_has_the_displacement_of_the_body() {
    let mut seen = Vec::new();
    for &(name, body) in MovedBody::ALL {
        let written = Case::of_scene(&scene(body), 3).unwrap();
        let case = Case::parse(name, &written.to_json()).unwrap();
        assert_eq!(
            (case.scene.objective.body, case.lattice.payload[0].node),
            (body, 4)
        );
        let results = case.evaluate(true, &[64]).unwrap();
        let (start, end) = (&case.start.x, &results.trajectory[&64].x);
        let body = case.body();
        // A node that is only partly present weighs as much less.
        let weights: Vec<f64> = (body.mass.iter().zip(&body.presence))
            .map(|(mass, presence)| mass * presence)
            .collect();
        let expected = match case.scene.objective.body {
            MovedBody::Payload => end[4].forward() - start[4].forward(),
            MovedBody::Mass => mean(&weights, start, end),
            MovedBody::Nodes => mean(&body.presence, start, end),
        };
        // Sums of six numbers below 1 m are rounded at 1e-16.
        let off = (results.displacement - expected).abs();
        assert!(off < 1e-15, "{name}: {off:e}");
        seen.push(results.displacement);
    }
    assert!(seen[0] != seen[1] && seen[1] != seen[2], "{seen:?}");
}

/// A whole run follows the body: the delivered displacement is that of the body, and the last iterations differ from
/// those of a run for the payload.
#[test]
fn a_run_delivers_the_displacement_of_the_body() {
    let deliver = |body| {
        CoDesign::new(&scene(body))
            .unwrap()
            .optimise(2, |_| ())
            .unwrap()
    };
    let payload = deliver(MovedBody::Payload);
    let delivery = deliver(MovedBody::Mass);
    let seen = &delivery.seen.trajectory;
    let weights = &seen.marker.weights;
    let moved = mean(weights, &seen.states[0].x, &seen.at(64).x);
    // Sums of six numbers below 1 m are rounded at 1e-16.
    assert!((delivery.displacement.forward() - moved).abs() < 1e-15);
    assert_ne!(delivery.controller, payload.controller);
}
