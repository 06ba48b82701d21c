//! Settings of the design vectors: projections, start, volume bounds, binarisation.

use super::Scene;
use crate::settings;
use crate::settings::{ITERATIONS, SHARE, above, within};

settings! {
    /// The softmax projections from design vectors to mixtures.
    struct ProjectionSettings {
        /// Sharpness of the performance projection.
        beta: f64 = 20.0, allowed above(0.0, 1e4),
            read "with a start other than a layout" if Scene::designs,
            source "paper, table 2";
        /// Sharpness of the stability projection's value.
        beta_stability: f64 = 500.0, allowed above(0.0, 1e4),
            read "with a start other than a layout" if Scene::designs,
            source "paper, table 2";
        /// Sharpness of the stability projection's straight-through derivative.
        beta_straight_through: f64 = 20.0, allowed above(0.0, 1e4),
            read "with a start other than a layout" if Scene::designs,
            source "paper, table 2";
        /// What keeps the pairwise measures from dividing zero by zero.
        delta: f64 = 1e-6, allowed within(1e-15, 1.0), source "D6";
        /// How much is taken off the solid entry that an edge does not have in the layout "filled",
        /// before every projection: the materials are held, and topology alone is designed.
        hold_materials: f64 = 0.0, allowed within(0.0, 10.0), since 1,
            read "with a start other than a layout" if Scene::designs,
            source "paper: 0, in its ablation a small constant";
    }
}

settings! {
    /// The design that the optimisation starts from.
    struct StartSettings {
        /// Mixture of the edges at the start; "layout" is one-hot and trains the controller alone.
        kind: StartKind = StartKind::Stability, source "paper, design b";
        /// Surplus of void at the topmost edge, for "stability".
        void_shift: f64 = 0.12, allowed within(-0.33, 0.66),
            read "with the start `stability`" if |s: &Scene| s.start.kind == StartKind::Stability,
            source "paper: 0.12";
        /// Share of void where the layout is void for "three_legged", everywhere for "filled"; less
        /// where `projection.beta` is so small that no design vector has as much.
        void: f64 = 0.6, allowed within(0.001, 0.999),
            read "with the starts `three_legged` and `filled`" if |s: &Scene| [StartKind::ThreeLegged, StartKind::Filled].contains(&s.start.kind),
            source "paper silent";
        /// Layout that "three_legged" and "layout" refer to.
        layout: Layout = Layout::Short,
            read "with the starts `three_legged` and `layout`" if |s: &Scene| [StartKind::ThreeLegged, StartKind::Layout].contains(&s.start.kind),
            source "paper: tall";
        /// Mean surplus of void, which grows towards a side drawn from the seed: about none at the
        /// opposite one, and twice as much here.
        tilt: f64 = 0.0, allowed within(0.0, 0.5), since 1, source "paper: 0";
    }
}

settings! {
    /// How the edges' mixtures begin.
    enum StartKind {
        /// A third of each material everywhere (the paper's design d).
        Uniform = "uniform",
        /// More void the higher an edge lies (design b).
        Stability = "stability",
        /// More void where a three-legged layout is void (design c).
        ThreeLegged = "three_legged",
        /// Little void anywhere, of both solid materials as much (the paper's ablation).
        Filled = "filled",
        /// A layout as it is, one-hot; the controller alone is trained (design a).
        Layout = "layout",
    }
}

settings! {
    /// A hand-made layout: three-legged ones of the 6x6 lattice within the volume budget, or one
    /// that fills any lattice.
    enum Layout {
        /// Legs three cells high, all 22 actuators vertical: the paper's description.
        Tall = "tall",
        /// Legs two cells high, 18 vertical actuators, four in the top chord.
        Short = "short",
        /// No void; actuators spread evenly over the vertical edges, skeleton elsewhere (the default
        /// design of the paper's ablation).
        Filled = "filled",
    }
}

settings! {
    /// What layouts are to be like beyond their volumes. A bar is an edge of solid material.
    struct DesignSettings {
        /// Whether all bars are to hang together with the payload. Then a node counts in the mean
        /// position, and is observed, as much as its edges are solid: not at all without a bar.
        one_piece: bool = true, since 1 before false, source "paper: false";
        /// Whether a bar may have an end where there is no other bar.
        free_ends: bool = true, since 1,
            read "with a start other than a layout" if Scene::designs,
            source "paper silent";
        /// Whether bars may cross.
        crossings: bool = true, since 1,
            read "with a start other than a layout" if Scene::designs,
            source "paper: true";
        /// Least number of nodes of the lowest row that have a bar.
        feet: usize = 0, allowed within(0.0, 1e4), since 1,
            read "with a start other than a layout" if Scene::designs,
            source "paper: 0";
    }
}

settings! {
    /// Bounds on the volume fractions, and how far they widen during a run.
    struct VolumeSettings {
        /// Least and most share of solid edges, skeleton and actuator.
        solid: [f64; 2] = [0.50, 0.50], allowed SHARE, source "paper, table 2";
        /// Least and most share of actuator edges.
        actuator: [f64; 2] = [0.20, 0.22], allowed SHARE, source "paper, table 2";
        /// How far each bound is widened in the end.
        widening: f64 = 0.03, allowed SHARE, source "paper: 0.03";
        /// First and last iteration of the widening.
        widening_over: [usize; 2] = [110, 150], allowed ITERATIONS,
            read "with a `widening` above 0" if |s: &Scene| s.volume.widening > 0.0,
            source "paper: 110 to 150";
    }
}

settings! {
    /// The augmented Lagrangian of the four binarisation measures, and the attraction to one-hot.
    struct BinarisationSettings {
        /// What holds the measures below their thresholds: augmented terms of the objective, or
        /// constraints of the design's optimiser.
        method: BinarisationMethod = BinarisationMethod::Augmented, since 1, source "paper: augmented";
        /// What each measure's threshold comes down to, from the measure's first value.
        threshold: f64 = 0.03, allowed SHARE, source "found by experiment";
        /// First and last iteration of the thresholds' descent.
        threshold_over: [usize; 2] = [20, 180], allowed ITERATIONS, source "found by experiment";
        /// Penalty weight at the start.
        penalty: f64 = 0.3, allowed within(0.0, 1e6),
            read "with the method `augmented`" if |s: &Scene| s.binarisation.method == BinarisationMethod::Augmented,
            source "paper, table 2";
        /// Factor on a penalty weight where a violation grew, divisor where it fell.
        penalty_growth: f64 = 1.01, allowed within(1.0, 10.0),
            read "with the method `augmented`" if |s: &Scene| s.binarisation.method == BinarisationMethod::Augmented,
            source "paper, table 2";
        /// Confidence above which an edge is attracted, first and last.
        confidence: [f64; 2] = [0.9, 0.6], allowed SHARE, source "found by experiment";
        /// Nudge of an attracted edge's design vector per iteration, first and last.
        nudge: [f64; 2] = [0.002, 0.006], allowed SHARE, source "found by experiment";
    }
}

settings! {
    /// How the four binarisation measures are held below their thresholds.
    enum BinarisationMethod {
        /// By the augmented Lagrangian, which lets them be violated for a while.
        Augmented = "augmented",
        /// As constraints of MMA beside the volumes: strictly, at all times.
        Constraints = "constraints",
    }
}
