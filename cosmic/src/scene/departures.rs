//! Departures: the options by which a scene deliberately differs from the paper.

use super::{
    ActuatorPart, BinarisationMethod, ClockKind, GoalKind, GradientPrecision, Integrator,
    LatticeKind, Layout, LossKind, MovedBody, Pass, ProfileKind, Scene, SelectionKind,
    SkeletonPart, StartKind, TaskKind, VoidEdges,
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

/// A possible departure from the paper: the key of an option, and the condition under which it is a departure.
struct KnownDeparture {
    in_force: fn(&Scene) -> bool,
    option: &'static str,
    says: &'static str,
}

/// Makes a list of possible departures. Each has the key of the option, a sentence about the difference, and the
/// condition under which it is a departure.
macro_rules! departures {
    ($($option:literal: $says:literal if $in_force:expr;)+) => {
        [$(KnownDeparture { option: $option, says: $says, in_force: $in_force }),+]
    };
}

/// All known departures, in the order in which summaries list them.
const KNOWN: &[KnownDeparture] = &departures! {
    "loss.kind": "the loss is the payload's mean position over the end of the horizon, not its last position"
        if |s| s.loss.kind == LossKind::Mean && s.has_task();
    "gradient.cotangent_bound": "the state's cotangent is bounded in the reverse sweep, so gradients are not exact"
        if |s| s.gradient.cotangent_bound.is_some();
    "gradient.design_memory": "the design is updated by a running mean of its gradients, not by the \
     last gradient alone"
        if |s| s.gradient.design_memory > 0.0 && s.designs();
    "gradient.precision": "rollouts during the optimisation are in f32, which has seven digits"
        if |s| s.gradient.precision == GradientPrecision::F32;
    "schedule.snap_trials": "the snap tries other materials for edges whose material is nearly \
     undecided, in full rollouts"
        if |s| s.schedule.snap_trials > 0 && s.designs();
    "schedule.polish_trials": "after the snap, other materials are tried for single edges in full rollouts"
        if |s| s.schedule.polish_trials > 0 && s.designs();
    "schedule.settle": "at its end, the fine-tuning continues from its best controller and takes back \
     updates that lose distance"
        if |s| s.schedule.settle > 0.0;
    "selection.kind": "the controller with the best displacement over several rollouts is delivered, not the last one"
        if |s| s.selection.kind != SelectionKind::Last;
    "design.one_piece": "all bars must be connected with the payload, and nodes without a bar are ignored"
        if |s| s.design.one_piece;
    "design.free_ends": "no bar may have an end without another bar"
        if |s| !s.design.free_ends && s.designs();
    "design.crossings": "bars may not cross"
        if |s| !s.design.crossings && s.designs();
    "design.feet": "a minimum number of nodes in the lowest row must have a bar"
        if |s| s.design.feet > 0 && s.designs();
    "projection.hold_materials": "the solid material of each edge is fixed, which the paper does only in its ablation"
        if |s| s.projection.hold_materials > 0.0 && s.designs();
    "lattice.kind": "the lattice has equilateral triangles, not squares with both diagonals"
        if |s| s.lattice.kind == LatticeKind::Triangular;
    "lattice.file": "nodes and edges come from a file or from the program, not from the paper's lattice"
        if |s| s.lattice.is_truss();
    "lattice.payload": "another node than the lower left one carries the payload"
        if |s| s.lattice.payload != 0 && s.is_generated();
    "start.layout": "the initial design follows another layout than the tall one of the paper's baseline"
        if |s| s.start.kind == StartKind::ThreeLegged && s.start.layout != Layout::Tall;
    "controller.policy": "the policy is not the paper's network"
        if |s| !s.controller.policy.is_default();
    "controller.clock": "the frequency of the clock is optimised with the controller"
        if |s| s.controller.clock == ClockKind::Learned;
    "controller.goal_relative": "the goal is relative to the robot, not absolute"
        if |s| s.controller.goal_relative && s.controller.goals != GoalKind::Given;
    "controller.goals": "the goal is an input of a rollout, and the robot observes its direction"
        if |s| s.controller.goals == GoalKind::Given;
    "controller.goals": "the controller is also trained for a goal behind the robot"
        if |s| s.controller.goals == GoalKind::Two;
    "start.tilt": "the initial design has more void on one side, which depends on the seed"
        if |s| s.start.tilt > 0.0;
    "physics.integrator": "steps are integrated by another method, leapfrog or an implicit one"
        if |s| s.physics.integrator != Integrator::SymplecticEuler;
    "physics.substeps": "the mechanics take shorter steps than the controller"
        if |s| s.physics.substeps != 1;
    "physics.forces": "additional forces act on the robot"
        if |s| s.physics.forces.laws().next().is_some();
    "physics.void_edges": "void edges of a one-hot layout exert no force"
        if |s| s.physics.void_edges == VoidEdges::Drop;
    "objective.task": "the robot is designed for another task than distance"
        if |s| s.objective.task != TaskKind::Far && s.has_task();
    "objective.body": "the displacement is that of another part of the robot than its payload"
        if |s| s.objective.body != MovedBody::Payload;
    "objective.own_loss": "robots are designed for a loss that the program adds"
        if |s| !s.has_task();
    "robust.samples": "gradients are means over random variations of the robot and its surroundings"
        if |s| s.robust.samples > 0;
    "lattice.mirror": "the robot is its own mirror image, front and back"
        if |s| s.lattice.mirror;
    "materials.penalisation": "the stiffness of mixtures is penalised, as in SIMP"
        if |s| s.materials.penalisation != 1 && s.designs();
    "parts.skeleton": "bars of skeleton are parts of a real material, whose stiffness depends on their length"
        if |s| s.materials.parts.skeleton != SkeletonPart::Numbers;
    "parts.actuator": "actuators are devices with a given mass and stroke"
        if |s| s.materials.parts.actuator != ActuatorPart::Numbers;
    "binarisation.method": "the binarisation measures are constraints, not terms of the augmented Lagrangian"
        if |s| s.binarisation.method == BinarisationMethod::Constraints && s.designs();
    "schedule.stability_share": "the stability projection has no share in design updates"
        if |s| s.schedule.stability_share == 0.0 && s.designs();
    "schedule.stability_share": "the performance projection has no share in design updates"
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
    /// The departures of this scene from the paper. Without departures, the physics and the algorithm are those of the
    /// paper. Numbers such as sizes, widths, rates, weights and the angle of the ground are no departures, and neither
    /// is the order of the passes in a cycle. But a number that switches something on is a departure.
    pub fn departures(&self) -> Vec<Departure> {
        let in_force = KNOWN.iter().filter(|known| (known.in_force)(self));
        in_force
            .map(|known| Departure {
                option: known.option.to_string(),
                says: known.says.to_string(),
            })
            .collect()
    }

    /// True if the cycle of the schedule has passes of this kind. Also true if the design is a layout, because the
    /// cycle is then not used.
    fn passes(&self, pass: Pass) -> bool {
        !self.designs() || self.schedule.cycle.contains(&pass)
    }
}
