//! The influence of a layout's void edges, and the effect of leaving them out.

use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::lattice::Body;
use cosmic::scene::{PhysicsSettings, VoidEdges};
use serde::Serialize;

/// A stiffness or a strain below any rounding but not zero, so that steps compute its edge.
const LEAST: f64 = 1e-150;

/// Replaces zeros by numbers that change nothing, so that steps compute all edges.
pub(super) fn keep_all(numbers: &mut [f64]) {
    for number in numbers.iter_mut().filter(|number| **number == 0.0) {
        *number = LEAST;
    }
}

/// The void edges of a one-hot layout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Voids {
    /// The number of void edges.
    pub edges: usize,
    /// True if steps leave them out: the scene drops them, or they have no stiffness.
    pub dropped: bool,
    /// The largest force of all void edges at one node, for each metre that they are stretched or
    /// compressed, N/m.
    pub force: f64,
    /// The bounds at the nodes that a solid edge holds, if there are any.
    pub body: Option<Pull>,
    /// The bounds at the nodes that only void edges hold, if there are any.
    pub detached: Option<Pull>,
}

/// A bound on the effect of void edges on nodes, for each metre that they are stretched or compressed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pull {
    /// On the acceleration, 1/s2.
    pub acceleration: f64,
    /// On the displacement of a node within the whole rollout, m/m: twice the way from rest under that
    /// acceleration and the scene's damping, because a node that is joined to others swings about the
    /// way that it would go alone. It holds while the motion does not multiply small changes, as a
    /// chaotic gait does in the long run.
    pub displacement: f64,
}

impl Voids {
    /// The void edges of a case's layout; `None` for a mixture, which has none.
    pub fn of(case: &Case) -> Option<Self> {
        let materials = case.design.layout()?;
        let is_void = |edge: usize| materials[edge] == Material::Void;
        let kept = body(case, VoidEdges::Keep);
        let mut pull = vec![0.0; case.lattice.nodes()];
        let mut is_held = vec![false; case.lattice.nodes()];
        for (edge, nodes) in case.lattice.edges.iter().enumerate() {
            for &node in nodes {
                match is_void(edge) {
                    true => pull[node] += kept.stiffness[edge],
                    false => is_held[node] = true,
                }
            }
        }
        let way = way_per_acceleration(&case.physics);
        let bound = |held: bool| {
            let nodes = (0..pull.len()).filter(|&node| is_held[node] == held);
            let most = nodes.map(|node| pull[node] / kept.mass[node]);
            most.reduce(f64::max).map(|acceleration| Pull {
                acceleration,
                displacement: 2.0 * acceleration * way,
            })
        };
        let dropped = case.physics.void_edges == VoidEdges::Drop
            || Material::Void.of(&case.materials.stiffness) == 0.0;
        Some(Self {
            edges: (0..materials.len()).filter(|&edge| is_void(edge)).count(),
            dropped,
            force: pull.iter().copied().fold(0.0, f64::max),
            body: bound(true),
            detached: bound(false),
        })
    }

    /// The reason for which steps compute them or not.
    pub(super) fn why(&self, case: &Case) -> String {
        let why = match (case.physics.void_edges, self.dropped) {
            (VoidEdges::Drop, _) => "physics.void_edges is \"drop\"",
            (VoidEdges::Keep, true) => "void has no stiffness",
            (VoidEdges::Keep, false) => "physics.void_edges is \"keep\"",
        };
        format!("{} of {}: {why}", self.edges, case.lattice.edges.len())
    }

    /// The body without void edges if the case's steps compute them, or with every edge, even one without
    /// stiffness, if they do not.
    pub(super) fn other_body(&self, case: &Case) -> Body<f64> {
        if !self.dropped {
            return body(case, VoidEdges::Drop);
        }
        let mut body = body(case, VoidEdges::Keep);
        keep_all(&mut body.stiffness);
        body
    }
}

/// The body of a case, its void edges kept or dropped.
fn body(case: &Case, void_edges: VoidEdges) -> Body<f64> {
    let physics = PhysicsSettings {
        void_edges,
        ..case.physics.clone()
    };
    Body {
        presence: case.body().presence,
        ..Body::new(&case.own_design(), &case.lattice, &case.materials, &physics)
    }
}

/// How far a whole rollout carries a node from rest for every unit of a constant acceleration, s2.
fn way_per_acceleration(physics: &PhysicsSettings) -> f64 {
    let (damping, time) = (physics.damping, physics.dt * physics.steps as f64);
    let decays = damping * time;
    // The difference below would lose its digits.
    if decays < 1e-6 {
        return 0.5 * time * time;
    }
    (decays + (-decays).exp_m1()) / (damping * damping)
}
