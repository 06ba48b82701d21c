//! The options by which a scene departs from the paper on purpose.

use super::{
    BinarisationMethod, Contact, GradientPrecision, Integrator, Layout, LossKind, Scene,
    SelectionKind, StartKind, TaskKind, VoidEdges,
};
use serde::{Deserialize, Serialize};

/// A named option that differs from what the paper does.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Departure {
    /// The setting, as `section.key`.
    pub option: String,
    /// What it does that the paper does not.
    pub says: String,
}

/// An option: whether a scene has it in force, its name, and what it does.
type Known = (fn(&Scene) -> bool, &'static str, &'static str);

/// In the order in which summaries have them.
const KNOWN: [Known; 24] = [
    (
        |s| s.loss.kind == LossKind::Mean,
        "loss.kind",
        "the loss is the payload's mean position over the horizon's end, not its last",
    ),
    (
        |s| s.gradient.cotangent_bound.is_some(),
        "gradient.cotangent_bound",
        "the state's cotangent is bounded in the reverse sweep: gradients are not exact",
    ),
    (
        |s| s.gradient.design_memory > 0.0 && s.designs(),
        "gradient.design_memory",
        "the design moves by a running mean of its gradients, not by the last ones alone",
    ),
    (
        |s| s.gradient.precision == GradientPrecision::F32,
        "gradient.precision",
        "rollouts on the way are in f32, which has seven digits",
    ),
    (
        |s| s.schedule.snap_trials > 0 && s.designs(),
        "schedule.snap_trials",
        "the snap tries other materials for edges of little confidence, in full rollouts",
    ),
    (
        |s| s.schedule.polish_trials > 0 && s.designs(),
        "schedule.polish_trials",
        "after the snap other materials are tried for single edges, in full rollouts",
    ),
    (
        |s| s.schedule.settle > 0.0,
        "schedule.settle",
        "the end of the fine-tuning goes on from its best controller and takes back updates that lose distance",
    ),
    (
        |s| s.selection.kind == SelectionKind::Median,
        "selection.kind",
        "the controller with the best perturbed median is delivered, not the last",
    ),
    (
        |s| s.start.kind == StartKind::ThreeLegged && s.start.layout != Layout::Tall,
        "start.layout",
        "the start follows another layout than the tall one of the paper's baseline",
    ),
    (
        |s| s.controller.goal_relative,
        "controller.goal_relative",
        "the goal is given relative to the robot, not absolute",
    ),
    (
        |s| s.start.tilt > 0.0,
        "start.tilt",
        "the start thins out towards a side that is drawn from the seed",
    ),
    (
        |s| s.physics.integrator != Integrator::SymplecticEuler,
        "physics.integrator",
        "steps are integrated by leapfrog",
    ),
    (
        |s| s.physics.substeps != 1,
        "physics.substeps",
        "the mechanics take shorter steps than the controller",
    ),
    (
        |s| s.physics.stiffening > 0.0,
        "physics.stiffening",
        "springs grow stiffer as they are stretched or compressed",
    ),
    (
        |s| s.physics.bending_radius > 0.0,
        "physics.bending_radius",
        "bars in line resist bending at the node between them",
    ),
    (
        |s| s.physics.void_edges == VoidEdges::Drop,
        "physics.void_edges",
        "void edges of a one-hot layout do not pull",
    ),
    (
        |s| s.objective.task != TaskKind::Far,
        "objective.task",
        "the robot is designed for another task than to get far",
    ),
    (
        |s| s.robust.samples > 0,
        "robust.samples",
        "gradients are means over robots and surroundings drawn around the nominal ones",
    ),
    (
        |s| s.controller.two_goals,
        "controller.two_goals",
        "the controller is trained for a goal behind as well",
    ),
    (
        |s| s.materials.penalisation != 1,
        "materials.penalisation",
        "the stiffness of mixtures is penalised, as SIMP does",
    ),
    (
        |s| s.binarisation.method == BinarisationMethod::Constraints,
        "binarisation.method",
        "the binarisation measures are strict constraints, not augmented terms",
    ),
    (
        |s| s.schedule.stability_share == 0.0,
        "schedule.stability_share",
        "the stability projection moves nothing",
    ),
    (
        |s| s.schedule.stability_share == 1.0,
        "schedule.stability_share",
        "the performance projection moves nothing",
    ),
    (
        |s| s.physics.contact == Contact::None,
        "physics.contact",
        "there is no ground",
    ),
];

impl Scene {
    /// The departures in force, for a run's summary. With none, physics and algorithm are the
    /// paper's. Numbers are the scene's, be they the paper's or not: sizes, widths, rates, weights,
    /// and how the passes of a cycle take turns.
    pub fn departures(&self) -> Vec<Departure> {
        let in_force = KNOWN.into_iter().filter(|(differs, ..)| differs(self));
        in_force
            .map(|(_, option, says)| Departure {
                option: option.to_string(),
                says: says.to_string(),
            })
            .collect()
    }

    /// Whether there are iterations of the design: a given layout has none.
    fn designs(&self) -> bool {
        self.start.kind != StartKind::Layout
    }
}
