//! Settings of the optimisation: schedule, both optimisers, gradient, loss, selection.

use super::field::Named;
use serde::Serialize;

/// Which iteration does what.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ScheduleSettings {
    /// Iterations in all (paper: 300, and 200 for the baseline).
    pub iterations: usize,
    /// Steps that carry the gradient, first and last (paper: 2048 to 4096).
    pub horizon: [usize; 2],
    /// First and last iteration of the horizon's growth (paper: 80 to 150).
    pub horizon_over: [usize; 2],
    /// Which steps carry the gradient: the first ones, or the last ones of a whole rollout (D11).
    pub horizon_mode: HorizonMode,
    /// First iteration that attracts edges to one-hot (paper: 170).
    pub attraction_from: usize,
    /// Iteration of the hard snap; 0 with a "layout" start, which has none (paper: 240).
    pub snap_at: usize,
    /// Changes of one edge's material, of those of the least confidence, that are tried in full
    /// rollouts at the snap, of which the best is kept (paper: 0).
    pub snap_trials: usize,
    /// Changes of one edge's material that are tried every so often after the snap, those from
    /// which a gradient promises most: each in a short rollout, the best quarter of them in full
    /// ones, of which the best is kept (paper: 0).
    pub polish_trials: usize,
    /// Iterations of the fine-tuning from one such polish to the next, the first right after the
    /// snap; those that settle have none (paper silent).
    pub polish_every: usize,
    /// Passes, repeated: d of the design, c of the controller (paper: three to two).
    pub cycle: Vec<Pass>,
    /// Share of the stability projection's update in a design pass (paper silent).
    pub stability_share: f64,
    /// Share of the fine-tuning at its end that goes on from the best controller and takes updates
    /// back that lose distance (paper: 0).
    pub settle: f64,
}

impl Default for ScheduleSettings {
    fn default() -> Self {
        const D: Pass = Pass::Design;
        const C: Pass = Pass::Controller;
        ScheduleSettings {
            iterations: 300,
            horizon: [2048, 4096],
            horizon_over: [80, 150],
            horizon_mode: HorizonMode::Head,
            attraction_from: 170,
            snap_at: 240,
            snap_trials: 20,
            polish_trials: 16,
            polish_every: 5,
            cycle: vec![D, C, D, C, D, D, C, D, C, D],
            stability_share: 1.0 / 3.0,
            settle: 0.25,
        }
    }
}

/// What one iteration of the co-design updates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// The design vectors, by MMA.
    Design,
    /// The controller's weights, by Adam.
    Controller,
}

/// Which steps of a rollout carry the gradient (D11).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum HorizonMode {
    /// A rollout of that many steps with the loss at its end.
    Head,
    /// The whole rollout, whose last so many steps carry the gradient.
    Tail,
}

impl Named for HorizonMode {
    const ALL: &'static [(&'static str, Self)] =
        &[("head", HorizonMode::Head), ("tail", HorizonMode::Tail)];
}

/// The method of moving asymptotes, for the design vectors (all values: paper silent).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MmaSettings {
    /// Largest change of a variable in an update, as a share of its range.
    pub move_limit: f64,
    /// Distance of the first asymptotes, as a share of the range.
    pub asyinit: f64,
    /// Factor on the distance of the asymptotes where a variable keeps its direction.
    pub asyincr: f64,
    /// Factor on the distance of the asymptotes where a variable turns.
    pub asydecr: f64,
    /// Least distance of the asymptotes, as a share of the range.
    pub asymin: f64,
    /// Largest distance of the asymptotes, as a share of the range.
    pub asymax: f64,
    /// Share of the distance to an asymptote that a variable keeps from it.
    pub albefa: f64,
    /// Curvature added to every term of the approximation.
    pub raa0: f64,
    /// Linear cost of the elastic variables.
    pub c: f64,
    /// Quadratic cost of the elastic variables.
    pub d: f64,
    /// Factor on the volume inequalities before MMA sees them.
    pub volume_row_scale: f64,
}

impl Default for MmaSettings {
    fn default() -> Self {
        MmaSettings {
            move_limit: 0.02,
            asyinit: 0.05,
            asyincr: 1.2,
            asydecr: 0.7,
            asymin: 0.01,
            asymax: 10.0,
            albefa: 0.1,
            raa0: 1e-5,
            c: 1000.0,
            d: 1.0,
            volume_row_scale: 10.0,
        }
    }
}

/// Adam, for the controller's weights (all values: paper silent).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdamSettings {
    /// Learning rate while design and controller move together.
    pub rate: f64,
    /// Learning rate at the start of the fine-tuning, when the controller moves alone.
    pub fine_rate: f64,
    /// Share of the fine-tuning's learning rate that is left at its end, reached linearly; where it
    /// settles, the rate falls to zero from there on.
    pub fine_decay: f64,
    /// Decay of the first and the second moment.
    pub betas: [f64; 2],
    /// What keeps the update from dividing by zero.
    pub epsilon: f64,
    /// Bound on the norm of the whole controller gradient, or "off".
    pub gradient_norm: Option<f64>,
}

impl Default for AdamSettings {
    fn default() -> Self {
        AdamSettings {
            rate: 0.002,
            fine_rate: 0.002,
            fine_decay: 0.1,
            betas: [0.9, 0.999],
            epsilon: 1e-8,
            gradient_norm: Some(1.0),
        }
    }
}

/// How far gradients are trusted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GradientSettings {
    /// Bound on the norm of the displacement's design gradient, or "off" (paper silent).
    pub design_norm: Option<f64>,
    /// Share that is kept of the mean of earlier design gradients, each bounded, in the mean with
    /// the next; 0 takes every gradient as it is (paper: 0).
    pub design_memory: f64,
    /// Bound on the norm of the state's cotangent in the reverse sweep, or "off" (paper: off).
    pub cotangent_bound: Option<f64>,
    /// Steps from one check of the cotangent to the next.
    pub cotangent_every: usize,
    /// Number type of the rollouts on the way: those that gradients are taken of, trials of other
    /// materials, and an iteration's full one. Medians over perturbed starts, by which controllers
    /// are chosen and results are quoted, are in f64 always.
    pub precision: GradientPrecision,
}

impl Default for GradientSettings {
    fn default() -> Self {
        GradientSettings {
            design_norm: Some(0.3),
            design_memory: 0.8,
            cotangent_bound: Some(3.0),
            cotangent_every: 16,
            precision: GradientPrecision::F64,
        }
    }
}

/// The number type of a rollout.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GradientPrecision {
    /// Sixteen digits.
    F64,
    /// Seven digits, at less of the time.
    F32,
}

impl Named for GradientPrecision {
    const ALL: &'static [(&'static str, Self)] = &[
        ("f64", GradientPrecision::F64),
        ("f32", GradientPrecision::F32),
    ];
}

/// The displacement loss that gradients are taken of; what is reported is the final displacement.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LossSettings {
    /// Payload's position at the horizon's end, or its mean over the last steps (paper: final).
    pub kind: LossKind,
    /// Steps at the horizon's end that the mean is taken over.
    pub window: usize,
    /// Steps from one position in the mean to the next.
    pub every: usize,
}

impl Default for LossSettings {
    fn default() -> Self {
        LossSettings {
            kind: LossKind::Mean,
            window: 2048,
            every: 16,
        }
    }
}

/// Where along the horizon the payload's position counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LossKind {
    /// At the last step (the paper's objective).
    Final,
    /// On average over the last steps.
    Mean,
}

impl Named for LossKind {
    const ALL: &'static [(&'static str, Self)] =
        &[("final", LossKind::Final), ("mean", LossKind::Mean)];
}

/// Which controller of the fine-tuning is delivered, and how designs are measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SelectionSettings {
    /// The last controller, or the one with the best median over perturbed starts (paper: last).
    pub kind: SelectionKind,
    /// Controllers with the best single rollouts that the median is taken of.
    pub candidates: usize,
    /// Rollouts from perturbed starts per median.
    pub perturbed_rollouts: usize,
    /// How far each coordinate of a perturbed start is moved, m.
    pub perturbation: f64,
}

impl Default for SelectionSettings {
    fn default() -> Self {
        SelectionSettings {
            kind: SelectionKind::Median,
            candidates: 6,
            perturbed_rollouts: 8,
            perturbation: 1e-9,
        }
    }
}

/// Which iterate is the result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SelectionKind {
    /// The last one (the paper's algorithm).
    Last,
    /// Of the best candidates, the one with the best median over perturbed starts.
    Median,
}

impl Named for SelectionKind {
    const ALL: &'static [(&'static str, Self)] = &[
        ("last", SelectionKind::Last),
        ("median", SelectionKind::Median),
    ];
}
