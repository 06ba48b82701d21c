//! Settings of the design vectors: projections, start, requirements on layouts, volume bounds, binarisation.

use crate::scene::Scene;
use crate::settings;
use crate::settings::{ITERATIONS, SHARE, within};

settings! {
    /// The softmax projections from design vectors to mixtures.
    struct ProjectionSettings {
        /// Number that is subtracted from one entry of each design vector: that of the solid material which the edge does
        /// not have in the layout "filled". 1 fixes the solid materials, so that only the topology is designed.
        hold_materials: f64 = 0.0, allowed within(0.0, 10.0),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0, in its ablation a small constant";
    } of cases {
        /// Sharpness of the performance projection.
        beta: f64 = 20.0, source "paper, table 2";
        /// Sharpness of the stability projection's value.
        beta_stability: f64 = 500.0, source "paper, table 2";
        /// Sharpness of the stability projection's straight-through derivative.
        beta_straight_through: f64 = 20.0, source "paper, table 2";
        /// Small number added to the mean of two shares in the overlap measures, so that they never divide zero by
        /// zero.
        delta: f64 = 1e-6, source "D6";
    }
}

settings! {
    /// The design at the start of the optimisation.
    struct StartSettings {
        /// Mixture of the edges at the start. With "layout" it is one-hot, and only the controller is trained.
        kind: StartKind = StartKind::Stability, source "paper, design b";
        /// Share of void: with "three_legged" in the edges that are void in the layout, with "filled" in all edges.
        void: f64 = 0.6, allowed within(0.001, 0.999),
            read "with the starts `three_legged` and `filled`" if |s: &Scene| [StartKind::ThreeLegged, StartKind::Filled].contains(&s.start.kind),
            source "paper silent";
        /// Layout for "three_legged" and "layout".
        layout: Layout = Layout::Short,
            read "with the starts `three_legged` and `layout`" if |s: &Scene| [StartKind::ThreeLegged, StartKind::Layout].contains(&s.start.kind),
            source "paper: tall";
        /// Mean amount that is added to the shares of void. It grows from one side of the lattice to the opposite side; the
        /// seed draws the side.
        tilt: f64 = 0.0, allowed within(0.0, 0.5), source "paper: 0";
    }
}

settings! {
    /// The mixtures of the edges at the start.
    enum StartKind {
        /// A third of each material everywhere (the paper's design d).
        Uniform = "uniform",
        /// More void the higher an edge lies (design b).
        Stability = "stability",
        /// More void where a three-legged layout is void (design c).
        ThreeLegged = "three_legged",
        /// Little void everywhere, and equal shares of both solid materials (the paper's ablation).
        Filled = "filled",
        /// A one-hot layout, which does not change: only the controller is trained (design a).
        Layout = "layout",
    }
}

settings! {
    /// A hand-made layout: two with three legs, for the 6x6 lattice and within the volume budget, and one that fills
    /// any lattice.
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
    /// Requirements on layouts in addition to the bounds on their volumes. A bar is an edge of solid material.
    struct DesignSettings {
        /// Whether all bars must be connected with the payload. Nodes without a bar are then not observed.
        one_piece: bool = true, source "paper: false";
        /// Whether a bar may have an end where there is no other bar.
        free_ends: bool = true,
            read "if the initial design is not a layout" if Scene::designs,
            source "paper silent";
        /// Whether bars may cross.
        crossings: bool = true,
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: true";
        /// Number of nodes in the lowest row that must have a bar, at least.
        feet: usize = 0, allowed within(0.0, 1e4),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
    }
}

settings! {
    /// Bounds on the volume fractions. During a run each bound becomes wider by 0.03.
    struct VolumeSettings {
        /// Smallest and largest share of solid edges, which are skeleton or actuator.
        solid: [f64; 2] = [0.50, 0.50], allowed SHARE,
            auto "`[0.5, 0.5]`; `[0.9, 1]` if the nodes weigh more than the bars of a half-full lattice, and for a truss with \
                  fewer than three edges per node; otherwise, if the payload weighs more than a third of these bars, on slopes \
                  from 5 degrees on, and for a truss of which half the edges cannot be stiff: from 1.2 times the share that a \
                  stiff frame needs, at most 0.9, to 0.1 more",
            source "paper, table 2";
        /// Smallest and largest share of actuator edges.
        actuator: [f64; 2] = [0.20, 0.22], allowed SHARE,
            auto "`[0.2, 0.22]`; `[0.2, 1]` if the nodes weigh more than the bars of a half-full lattice; `[0.35, 0.45]` if \
                  `solid` follows from what a stiff frame needs",
            source "paper, table 2";
    }
}

impl VolumeSettings {
    /// Amount by which each bound is wider at the end (paper: 0.03).
    pub const WIDENING: f64 = 0.03;
}

settings! {
    /// The augmented Lagrangian of the four binarisation measures, and the attraction of edges to a single material.
    struct BinarisationSettings {
        /// How the measures are held below their thresholds: by terms of the objective, or by constraints.
        method: BinarisationMethod = BinarisationMethod::Augmented, source "paper: augmented";
        /// First and last iteration in which the thresholds of the measures fall, from the first values of the measures to
        /// 0.03.
        threshold_over: [usize; 2] = [20, 180], allowed ITERATIONS,
            auto "20 and 100 for 300 iterations, and in proportion", source "found by experiment";
    }
}

impl BinarisationSettings {
    /// Final threshold of each measure. The thresholds begin at the first values of the measures (found by experiment).
    pub const THRESHOLD: f64 = 0.03;

    /// Penalty weight at the start (paper, table 2).
    pub const PENALTY: f64 = 0.3;
}

settings! {
    /// How the four binarisation measures are held below their thresholds.
    enum BinarisationMethod {
        /// By the augmented Lagrangian, which allows violations for a while.
        Augmented = "augmented",
        /// By constraints of MMA in addition to those on the volumes: strictly in every iteration.
        Constraints = "constraints",
    }
}
