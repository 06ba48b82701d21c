//! Departures: the options by which a scene deliberately differs from the paper.

use super::{
    BinarisationMethod, GradientPrecision, Integrator, LatticeKind, Layout, LossKind, MovedBody,
    Pass, ProfileKind, Scene, SelectionKind, StartKind, TaskKind, VoidEdges,
};
use crate::laws::ContactLaw;
use serde::{Deserialize, Serialize};

/// An option of a scene that differs from what the paper does.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Departure {
    /// The setting, as `section.key`.
    pub option: String,
    /// The difference from the paper, in a sentence.
    pub says: String,
}

/// An option that can depart from the paper, and when it does.
struct KnownDeparture {
    in_force: fn(&Scene) -> bool,
    option: &'static str,
    says: &'static str,
}

/// Makes a list of known departures. Each has the key of the option, a sentence about the difference, and the condition
/// under which it is in force.
macro_rules! departures {
    ($($option:literal: $says:literal if $in_force:expr;)+) => {
        [$(KnownDeparture { option: $option, says: $says, in_force: $in_force }),+]
    };
}

/// All known departures, in the order in which summaries list them.
const KNOWN: &[KnownDeparture] = &departures! {
    "loss.kind": "the loss is the payload's mean position over the horizon's end, not its last"
        if |s| s.loss.kind == LossKind::Mean && s.has_task();
    "gradient.cotangent_bound": "the state's cotangent is bounded in the reverse sweep: gradients are not exact"
        if |s| s.gradient.cotangent_bound.is_some();
    "gradient.design_memory": "the design moves by a running mean of its gradients, not by the last ones alone"
        if |s| s.gradient.design_memory > 0.0 && s.designs();
    "gradient.precision": "rollouts during the optimisation are in f32, which has seven digits"
        if |s| s.gradient.precision == GradientPrecision::F32;
    "schedule.snap_trials": "the snap tries other materials for edges of little confidence, in full rollouts"
        if |s| s.schedule.snap_trials > 0 && s.designs();
    "schedule.polish_trials": "after the snap other materials are tried for single edges, in full rollouts"
        if |s| s.schedule.polish_trials > 0 && s.designs();
    "schedule.settle": "the end of the fine-tuning goes on from its best controller and takes back updates that lose distance"
        if |s| s.schedule.settle > 0.0;
    "selection.kind": "the controller with the best perturbed median is delivered, not the last"
        if |s| s.selection.kind == SelectionKind::Median;
    "design.one_piece": "all bars hang together with the payload, and nodes without a bar do not count"
        if |s| s.design.one_piece;
    "design.free_ends": "no bar may have an end where there is no other bar"
        if |s| !s.design.free_ends && s.designs();
    "design.crossings": "bars may not cross"
        if |s| !s.design.crossings && s.designs();
    "design.feet": "a number of nodes in the lowest row must have a bar"
        if |s| s.design.feet > 0 && s.designs();
    "projection.hold_materials": "each edge is held to one solid material, which the paper does only in its ablation"
        if |s| s.projection.hold_materials > 0.0 && s.designs();
    "lattice.kind": "the lattice has equilateral triangles, not squares with both diagonals"
        if |s| s.lattice.kind == LatticeKind::Triangular;
    "lattice.file": "nodes and edges come from a file or from the program, not from the paper's lattice"
        if |s| s.lattice.is_truss();
    "lattice.payload": "another node than the lower left one carries the payload"
        if |s| s.lattice.payload != 0 && s.is_generated();
    "start.layout": "the start follows another layout than the tall one of the paper's baseline"
        if |s| s.start.kind == StartKind::ThreeLegged && s.start.layout != Layout::Tall;
    "controller.policy": "another policy than the paper's network drives the robot"
        if |s| !s.controller.policy.is_default();
    "controller.goal_relative": "the goal is given relative to the robot, not absolute"
        if |s| s.controller.goal_relative;
    "start.tilt": "the initial design has more void towards one side, which the seed decides"
        if |s| s.start.tilt > 0.0;
    "physics.integrator": "steps are integrated by leapfrog"
        if |s| s.physics.integrator != Integrator::SymplecticEuler;
    "physics.substeps": "the mechanics take shorter steps than the controller"
        if |s| s.physics.substeps != 1;
    "physics.stiffening": "springs grow stiffer as they are stretched or compressed"
        if |s| s.physics.stiffening > 0.0;
    "physics.bending_radius": "bars in line resist bending at the node between them"
        if |s| s.physics.bending_radius > 0.0;
    "physics.forces": "additional forces act on the robot"
        if |s| s.physics.forces.laws().next().is_some();
    "physics.void_edges": "void edges of a one-hot layout do not pull"
        if |s| s.physics.void_edges == VoidEdges::Drop;
    "objective.task": "the robot is designed for another task than to get far"
        if |s| s.objective.task != TaskKind::Far && s.has_task();
    "objective.body": "the displacement is that of another part of the robot than its payload"
        if |s| s.objective.body != MovedBody::Payload;
    "objective.own_loss": "robots are designed for a loss that the program adds"
        if |s| !s.has_task();
    "robust.samples": "gradients are means over robots and surroundings drawn around the nominal ones"
        if |s| s.robust.samples > 0;
    "controller.two_goals": "the controller is trained for a goal behind as well"
        if |s| s.controller.two_goals;
    "materials.penalisation": "the stiffness of mixtures is penalised, as SIMP does"
        if |s| s.materials.penalisation != 1 && s.designs();
    "binarisation.method": "the binarisation measures are strict constraints, not augmented terms"
        if |s| s.binarisation.method == BinarisationMethod::Constraints && s.designs();
    "schedule.stability_share": "the stability projection moves nothing"
        if |s| s.schedule.stability_share == 0.0 && s.designs();
    "schedule.stability_share": "the performance projection moves nothing"
        if |s| s.schedule.stability_share == 1.0 && s.designs();
    "schedule.cycle": "the design does not change before the snap"
        if |s| !s.passes(Pass::Design);
    "schedule.cycle": "the controller does not learn before the snap"
        if |s| !s.passes(Pass::Controller);
    "ground.profile": "the ground has a height profile"
        if |s| s.physics.ground.profile != ProfileKind::Flat;
    "physics.contact": "there is no ground"
        if |s| !s.physics.contact.has_ground();
    "physics.contact": "the contact law is not in the paper"
        if |s| {
            let of_paper = [ContactLaw::infinite(), ContactLaw::coulomb()];
            let contact = &s.physics.contact;
            contact.has_ground() && of_paper.iter().all(|law| law.name() != contact.name())
        };
};

impl Scene {
    /// The departures that are in force, for the summary of a run. Without departures, the physics and the algorithm
    /// are those of the paper. Numbers such as sizes, widths, rates, weights and the angle of the ground are no
    /// departures, and neither is the order of the passes in a cycle. But a number that switches something on is a
    /// departure.
    pub fn departures(&self) -> Vec<Departure> {
        let in_force = KNOWN.iter().filter(|known| (known.in_force)(self));
        in_force
            .map(|known| Departure {
                option: known.option.to_string(),
                says: known.says.to_string(),
            })
            .collect()
    }

    /// True if the cycle has passes of this kind. Also true if the design is a layout, because then the cycle is not
    /// used.
    fn passes(&self, pass: Pass) -> bool {
        !self.designs() || self.schedule.cycle.contains(&pass)
    }
}
