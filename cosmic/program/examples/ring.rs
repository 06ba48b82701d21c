//! A lattice that the program builds itself: a ring of triangles that rolls.
//!
//! `cargo run --release -p cosmic-program --example ring -- optimize --iterations 8 --out runs/ring`

use std::f64::consts::TAU;
use std::process::ExitCode;

use cosmic::geometry::Vector;
use cosmic::lattice::{EdgeRules, Payload, Truss};
use cosmic_program::Program;

/// The number of nodes on the inner circle, and on the outer circle.
const NODES: usize = 12;
/// Radius of the outer circle, m.
const OUTER: f64 = 0.3;
/// Radius of the inner circle, m.
const INNER: f64 = 0.2;

/// Builds two circles of nodes. Edges join each node to its neighbours on both circles. The payload is at the bottom,
/// and the edges of the outer circle are always solid.
fn ring() -> Truss {
    let node = |k: usize| {
        // Node 0 is the lowest outer node. The inner nodes are turned by half the angle between neighbours.
        let angle = TAU * ((k % NODES) as f64 + 0.5 * (k / NODES) as f64) / NODES as f64;
        let radius = if k < NODES { OUTER } else { INNER };
        Vector::from([0.4 + radius * angle.sin(), OUTER - radius * angle.cos()])
    };
    let edges = (0..NODES).flat_map(|k| {
        let next = (k + 1) % NODES;
        let (inner, inner_next) = (NODES + k, NODES + next);
        [[k, next], [k, inner], [inner, next], [inner, inner_next]]
    });
    Truss {
        nodes: (0..2 * NODES).map(node).collect(),
        edges: edges.collect(),
        payload: vec![Payload {
            node: 0,
            mass: Some(0.01),
        }],
        rules: EdgeRules {
            keep: (0..NODES).map(|k| 4 * k).collect(),
            ..EdgeRules::default()
        },
        ..Truss::default()
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[lattice]\nfile = \"ring\"\n[volume]\nsolid = [0.5, 0.7]";
    Program::new()
        .with_lattice("ring", ring())
        .with_scene("ring", scene)
        .run()
}
