//! Settings of the design vectors: projections, start, volume bounds, binarisation.

use super::field::Named;
use serde::Serialize;

/// The softmax projections from design vectors to mixtures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ProjectionSettings {
    /// Sharpness of the performance projection (paper, table 2).
    pub beta: f64,
    /// Sharpness of the stability projection's value (paper, table 2).
    pub beta_stability: f64,
    /// Sharpness of the stability projection's straight-through derivative (paper, table 2).
    pub beta_straight_through: f64,
    /// What keeps the pairwise measures from dividing zero by zero (D6).
    pub delta: f64,
    /// How much is taken off the solid entry that an edge does not have in the layout "filled",
    /// before every projection: the materials are held, and topology alone is designed (paper: 0,
    /// in its ablation a small constant).
    pub hold_materials: f64,
}

impl Default for ProjectionSettings {
    fn default() -> Self {
        ProjectionSettings {
            beta: 20.0,
            beta_stability: 500.0,
            beta_straight_through: 20.0,
            delta: 1e-6,
            hold_materials: 0.0,
        }
    }
}

/// The design that the optimisation starts from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StartSettings {
    /// Mixture of the edges at the start; "layout" is one-hot and trains the controller alone.
    pub kind: StartKind,
    /// Surplus of void at the topmost edge, for "stability" (paper: 0.12).
    pub void_shift: f64,
    /// Share of void where the layout is void for "three_legged", everywhere for "filled" (paper
    /// silent); less where `projection.beta` is so small that no design vector has as much.
    pub void: f64,
    /// Layout that "three_legged" and "layout" refer to.
    pub layout: Layout,
    /// Mean surplus of void, which grows towards a side drawn from the seed: about none at the
    /// opposite one, and twice as much here (paper: 0).
    pub tilt: f64,
}

impl Default for StartSettings {
    fn default() -> Self {
        StartSettings {
            kind: StartKind::Stability,
            void_shift: 0.12,
            void: 0.6,
            layout: Layout::Short,
            tilt: 0.0,
        }
    }
}

/// How the edges' mixtures begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// A third of each material everywhere (the paper's design d).
    Uniform,
    /// More void the higher an edge lies (design b).
    Stability,
    /// More void where a three-legged layout is void (design c).
    ThreeLegged,
    /// Little void anywhere, of the solid materials the same (the paper's ablation).
    Filled,
    /// A layout as it is, one-hot; the controller alone is trained (design a).
    Layout,
}

impl Named for StartKind {
    const ALL: &'static [(&'static str, Self)] = &[
        ("uniform", StartKind::Uniform),
        ("stability", StartKind::Stability),
        ("three_legged", StartKind::ThreeLegged),
        ("filled", StartKind::Filled),
        ("layout", StartKind::Layout),
    ];
}

/// A hand-made layout: three-legged ones of the 6x6 lattice within the volume budget, or one that
/// fills any lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Layout {
    /// Legs three cells high, all 22 actuators vertical: the paper's description.
    Tall,
    /// Legs two cells high, 18 vertical actuators, four in the top chord.
    Short,
    /// No void; actuators spread evenly over the vertical edges, skeleton elsewhere (the default
    /// design of the paper's ablation).
    Filled,
}

impl Named for Layout {
    const ALL: &'static [(&'static str, Self)] = &[
        ("tall", Layout::Tall),
        ("short", Layout::Short),
        ("filled", Layout::Filled),
    ];
}

/// Bounds on the volume fractions, and how far they widen on the way.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VolumeSettings {
    /// Least and most share of solid edges, skeleton and actuator (paper, table 2).
    pub solid: [f64; 2],
    /// Least and most share of actuator edges (paper, table 2).
    pub actuator: [f64; 2],
    /// How far each bound is widened in the end (paper: 0.03).
    pub widening: f64,
    /// First and last iteration of the widening (paper: 110 to 150).
    pub widening_over: [usize; 2],
}

impl Default for VolumeSettings {
    fn default() -> Self {
        VolumeSettings {
            solid: [0.50, 0.50],
            actuator: [0.20, 0.22],
            widening: 0.03,
            widening_over: [110, 150],
        }
    }
}

/// The augmented Lagrangian of the four binarisation measures, and the attraction to one-hot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BinarisationSettings {
    /// What holds the measures below their thresholds: augmented terms of the objective, or
    /// constraints of the design's optimiser (paper: augmented).
    pub method: BinarisationMethod,
    /// What each measure's threshold comes down to, from the measure's first value (paper silent).
    pub threshold: f64,
    /// First and last iteration of the thresholds' descent (paper silent).
    pub threshold_over: [usize; 2],
    /// Penalty weight at the start (paper, table 2).
    pub penalty: f64,
    /// Factor on a penalty weight where a violation grew, divisor where it fell (paper, table 2).
    pub penalty_growth: f64,
    /// Confidence above which an edge is attracted, first and last (paper silent).
    pub confidence: [f64; 2],
    /// Nudge of an attracted edge's design vector per iteration, first and last (paper silent).
    pub nudge: [f64; 2],
}

impl Default for BinarisationSettings {
    fn default() -> Self {
        BinarisationSettings {
            method: BinarisationMethod::Augmented,
            threshold: 0.03,
            threshold_over: [20, 180],
            penalty: 0.3,
            penalty_growth: 1.01,
            confidence: [0.9, 0.6],
            nudge: [0.002, 0.006],
        }
    }
}

/// How the four binarisation measures are held below their thresholds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BinarisationMethod {
    /// By the augmented Lagrangian, which lets them be violated for a while.
    Augmented,
    /// As constraints of MMA beside the volumes: strictly, at all times.
    Constraints,
}

impl Named for BinarisationMethod {
    const ALL: &'static [(&'static str, Self)] = &[
        ("augmented", BinarisationMethod::Augmented),
        ("constraints", BinarisationMethod::Constraints),
    ];
}
