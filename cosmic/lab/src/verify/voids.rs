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
    /// Microseconds per step saved without them; `None` if not measured.
    pub saving: Option<f64>,
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
                if is_void(edge) {
                    pull[node] += kept.stiffness[edge];
                } else {
                    is_held[node] = true;
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
            saving: None,
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

    /// The body without void edges if the case's steps compute them, or with all edges if they do not.
    pub(super) fn other_body(&self, case: &Case) -> Body<f64> {
        if self.dropped {
            body_with_all_edges(case)
        } else {
            body(case, VoidEdges::Drop)
        }
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

/// The body of a case whose steps compute every edge, even one without stiffness.
fn body_with_all_edges(case: &Case) -> Body<f64> {
    let mut body = body(case, VoidEdges::Keep);
    keep_all(&mut body.stiffness);
    body
}

/// How far a whole rollout carries a node from rest for every unit of a constant acceleration, s2.
fn way_per_acceleration(physics: &PhysicsSettings) -> f64 {
    let h = physics.dt / physics.substeps as f64;
    let decay = (-physics.damping * h).exp();
    let (mut speed, mut way) = (0.0, 0.0);
    for _ in 0..physics.steps * physics.substeps {
        speed = decay * speed + h;
        way += h * speed;
    }
    way
}

#[cfg(test)]
mod tests {
    use super::way_per_acceleration;
    use cosmic::scene::PhysicsSettings;

    #[test]
    fn the_way_is_that_of_free_fall_and_of_a_fall_through_syrup() {
        let way = |damping: f64, substeps: usize| {
            way_per_acceleration(&PhysicsSettings {
                damping,
                substeps,
                ..PhysicsSettings::default()
            })
        };
        let time = 0.002 * 8192.0;
        // A first-order step is off by half a step in time: 1e-4 of the way, or less.
        assert!((way(0.0, 1) / (0.5 * time * time) - 1.0).abs() < 2e-4);
        // The speed it falls with in the end is g / damping, within h damping / 2 = 2 %.
        assert!((way(20.0, 1) / (time / 20.0) - 1.0).abs() < 0.025);
        assert!((way(20.0, 64) / (time / 20.0) - 1.0).abs() < 0.005);
    }
}
