//! The options by which a scene deliberately differs from the paper.

use super::{
    BinarisationMethod, GradientPrecision, Integrator, LatticeKind, Layout, LossKind, Pass,
    ProfileKind, Scene, SelectionKind, StartKind, TaskKind, VoidEdges,
};
use crate::laws::ContactLaw;
use serde::{Deserialize, Serialize};

/// A named option that differs from what the paper does.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Departure {
    /// The setting, as `section.key`.
    pub option: String,
    /// The difference from the paper, in a sentence.
    pub says: String,
}

/// An option that departs from the paper.
struct KnownDeparture {
    in_force: fn(&Scene) -> bool,
    option: &'static str,
    says: &'static str,
}

/// In the order in which summaries list them.
const KNOWN: &[KnownDeparture] = &[
    KnownDeparture {
        in_force: |s| s.loss.kind == LossKind::Mean && s.has_task(),
        option: "loss.kind",
        says: "the loss is the payload's mean position over the horizon's end, not its last",
    },
    KnownDeparture {
        in_force: |s| s.gradient.cotangent_bound.is_some(),
        option: "gradient.cotangent_bound",
        says: "the state's cotangent is bounded in the reverse sweep: gradients are not exact",
    },
    KnownDeparture {
        in_force: |s| s.gradient.design_memory > 0.0 && s.designs(),
        option: "gradient.design_memory",
        says: "the design moves by a running mean of its gradients, not by the last ones alone",
    },
    KnownDeparture {
        in_force: |s| s.gradient.precision == GradientPrecision::F32,
        option: "gradient.precision",
        says: "rollouts during the optimisation are in f32, which has seven digits",
    },
    KnownDeparture {
        in_force: |s| s.schedule.snap_trials > 0 && s.designs(),
        option: "schedule.snap_trials",
        says: "the snap tries other materials for edges of little confidence, in full rollouts",
    },
    KnownDeparture {
        in_force: |s| s.schedule.polish_trials > 0 && s.designs(),
        option: "schedule.polish_trials",
        says: "after the snap other materials are tried for single edges, in full rollouts",
    },
    KnownDeparture {
        in_force: |s| s.schedule.settle > 0.0,
        option: "schedule.settle",
        says: "the end of the fine-tuning goes on from its best controller and takes back updates that lose distance",
    },
    KnownDeparture {
        in_force: |s| s.selection.kind == SelectionKind::Median,
        option: "selection.kind",
        says: "the controller with the best perturbed median is delivered, not the last",
    },
    KnownDeparture {
        in_force: |s| s.design.one_piece,
        option: "design.one_piece",
        says: "all bars hang together with the payload, and nodes without a bar do not count",
    },
    KnownDeparture {
        in_force: |s| !s.design.free_ends && s.designs(),
        option: "design.free_ends",
        says: "no bar may have an end where there is no other bar",
    },
    KnownDeparture {
        in_force: |s| !s.design.crossings && s.designs(),
        option: "design.crossings",
        says: "bars may not cross",
    },
    KnownDeparture {
        in_force: |s| s.design.feet > 0 && s.designs(),
        option: "design.feet",
        says: "a number of nodes in the lowest row must have a bar",
    },
    KnownDeparture {
        in_force: |s| s.projection.hold_materials > 0.0 && s.designs(),
        option: "projection.hold_materials",
        says: "each edge is held to one solid material, which the paper does only in its ablation",
    },
    KnownDeparture {
        in_force: |s| s.lattice.kind == LatticeKind::Triangular,
        option: "lattice.kind",
        says: "the lattice has equilateral triangles, not squares with both diagonals",
    },
    KnownDeparture {
        in_force: |s| s.lattice.is_truss(),
        option: "lattice.file",
        says: "nodes and edges come from a file or from the program, not from the paper's lattice",
    },
    KnownDeparture {
        in_force: |s| s.start.kind == StartKind::ThreeLegged && s.start.layout != Layout::Tall,
        option: "start.layout",
        says: "the start follows another layout than the tall one of the paper's baseline",
    },
    KnownDeparture {
        in_force: |s| !s.controller.policy.is_default(),
        option: "controller.policy",
        says: "another policy than the paper's network drives the robot",
    },
    KnownDeparture {
        in_force: |s| s.controller.goal_relative,
        option: "controller.goal_relative",
        says: "the goal is given relative to the robot, not absolute",
    },
    KnownDeparture {
        in_force: |s| s.start.tilt > 0.0,
        option: "start.tilt",
        says: "the start thins out towards a side that is drawn from the seed",
    },
    KnownDeparture {
        in_force: |s| s.physics.integrator != Integrator::SymplecticEuler,
        option: "physics.integrator",
        says: "steps are integrated by leapfrog",
    },
    KnownDeparture {
        in_force: |s| s.physics.substeps != 1,
        option: "physics.substeps",
        says: "the mechanics take shorter steps than the controller",
    },
    KnownDeparture {
        in_force: |s| s.physics.stiffening > 0.0,
        option: "physics.stiffening",
        says: "springs grow stiffer as they are stretched or compressed",
    },
    KnownDeparture {
        in_force: |s| s.physics.bending_radius > 0.0,
        option: "physics.bending_radius",
        says: "bars in line resist bending at the node between them",
    },
    KnownDeparture {
        in_force: |s| s.physics.forces.laws().next().is_some(),
        option: "physics.forces",
        says: "additional forces act on the robot",
    },
    KnownDeparture {
        in_force: |s| s.physics.void_edges == VoidEdges::Drop,
        option: "physics.void_edges",
        says: "void edges of a one-hot layout do not pull",
    },
    KnownDeparture {
        in_force: |s| s.objective.task != TaskKind::Far && s.has_task(),
        option: "objective.task",
        says: "the robot is designed for another task than to get far",
    },
    KnownDeparture {
        in_force: |s| !s.has_task(),
        option: "objective.own_loss",
        says: "robots are designed for a loss that the program adds",
    },
    KnownDeparture {
        in_force: |s| s.robust.samples > 0,
        option: "robust.samples",
        says: "gradients are means over robots and surroundings drawn around the nominal ones",
    },
    KnownDeparture {
        in_force: |s| s.controller.two_goals,
        option: "controller.two_goals",
        says: "the controller is trained for a goal behind as well",
    },
    KnownDeparture {
        in_force: |s| s.materials.penalisation != 1 && s.designs(),
        option: "materials.penalisation",
        says: "the stiffness of mixtures is penalised, as SIMP does",
    },
    KnownDeparture {
        in_force: |s| s.binarisation.method == BinarisationMethod::Constraints && s.designs(),
        option: "binarisation.method",
        says: "the binarisation measures are strict constraints, not augmented terms",
    },
    KnownDeparture {
        in_force: |s| s.schedule.stability_share == 0.0 && s.designs(),
        option: "schedule.stability_share",
        says: "the stability projection moves nothing",
    },
    KnownDeparture {
        in_force: |s| s.schedule.stability_share == 1.0 && s.designs(),
        option: "schedule.stability_share",
        says: "the performance projection moves nothing",
    },
    KnownDeparture {
        in_force: |s| !s.passes(Pass::Design),
        option: "schedule.cycle",
        says: "the design does not change before the snap",
    },
    KnownDeparture {
        in_force: |s| !s.passes(Pass::Controller),
        option: "schedule.cycle",
        says: "the controller does not learn before the snap",
    },
    KnownDeparture {
        in_force: |s| s.physics.ground.profile != ProfileKind::Flat,
        option: "ground.profile",
        says: "the ground has a height profile",
    },
    KnownDeparture {
        in_force: |s| !s.physics.contact.has_ground(),
        option: "physics.contact",
        says: "there is no ground",
    },
    KnownDeparture {
        in_force: |s| {
            let of_paper = [ContactLaw::infinite(), ContactLaw::coulomb()];
            let contact = &s.physics.contact;
            contact.has_ground() && of_paper.iter().all(|law| law.name() != contact.name())
        },
        option: "physics.contact",
        says: "the contact law is not in the paper",
    },
];

impl Scene {
    /// The departures in force, for the summary of a run. Without departures, physics and algorithm are those of the
    /// paper. Sizes, widths, rates, weights, the angle of the ground and the order of the passes of a cycle are not
    /// departures. A number that switches something on is a departure.
    pub fn departures(&self) -> Vec<Departure> {
        let in_force = KNOWN.iter().filter(|known| (known.in_force)(self));
        in_force
            .map(|known| Departure {
                option: known.option.to_string(),
                says: known.says.to_string(),
            })
            .collect()
    }

    /// Whether the cycle has passes of this kind or needs none.
    fn passes(&self, pass: Pass) -> bool {
        !self.designs() || self.schedule.cycle.contains(&pass)
    }
}
