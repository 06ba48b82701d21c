//! The one table behind reading, checking and writing scenes: every key, its range and its place.
//!
//! Defaults live in the structs' `Default`; what a user reads about a key is its field's own
//! documentation.

use super::Scene;
use super::field::{Field, Limits, Section, Slot, above, within};
use Slot::{Bound, Choice, Count, Counts, Cycle, Flag, Number, Numbers};

/// What may stand at a key of a scene, such as `physics.dt`, in place of a number; `None` where
/// that number may.
///
/// # Panics
/// If no scene has the key.
pub(crate) fn allowed_instead(key: &str, number: f64) -> Option<String> {
    let is_asked = |section: &str, field: &Field| {
        key.strip_prefix(section)
            .and_then(|key| key.strip_prefix('.'))
            == Some(field.key)
    };
    let field = SECTIONS.iter().find_map(|section| {
        let mut fields = section.fields.iter();
        fields.find(|field| is_asked(section.name, field))
    });
    let Field { limits, slot, .. } = field.expect("a key of the table");
    (!limits.contain(number)).then(|| slot(&mut Scene::default()).allowed(limits))
}

const fn field(key: &'static str, limits: Limits, slot: fn(&mut Scene) -> Slot<'_>) -> Field {
    Field { key, limits, slot }
}

const fn section(name: &'static str, settings: &'static str, fields: &'static [Field]) -> Section {
    Section {
        name,
        settings,
        fields,
    }
}

/// Numbers of an iteration; 0 is before the first one.
const ITERATIONS: Limits = within(0.0, 1e5);
/// Lengths of rollouts and of parts of them.
const STEPS: Limits = within(1.0, 1e6);
/// Factors and costs that have no natural bound.
const POSITIVE: Limits = above(0.0, 1e6);
/// Shares of a whole.
const SHARE: Limits = within(0.0, 1.0);
/// Shares by which a positive number is off and stays positive.
const DEVIATION: Limits = within(0.0, 0.99);
const NONE: Limits = Limits::NONE;

/// Every section of a scene, in the order in which it is written.
pub(super) static SECTIONS: &[Section] = &[
    section("lattice", "LatticeSettings", LATTICE),
    section("physics", "PhysicsSettings", PHYSICS),
    section("materials", "MaterialSettings", MATERIALS),
    section("projection", "ProjectionSettings", PROJECTION),
    section("controller", "ControllerSettings", CONTROLLER),
    section("start", "StartSettings", START),
    section("volume", "VolumeSettings", VOLUME),
    section("schedule", "ScheduleSettings", SCHEDULE),
    section("binarisation", "BinarisationSettings", BINARISATION),
    section("mma", "MmaSettings", MMA),
    section("adam", "AdamSettings", ADAM),
    section("gradient", "GradientSettings", GRADIENT),
    section("loss", "LossSettings", LOSS),
    section("selection", "SelectionSettings", SELECTION),
    section("objective", "ObjectiveSettings", OBJECTIVE),
    section("robust", "RobustSettings", ROBUST),
    section("search", "SearchSettings", SEARCH),
];

const LATTICE: &[Field] = &[
    field("columns", within(2.0, 64.0), |s| {
        Count(&mut s.lattice.columns)
    }),
    field("rows", within(2.0, 64.0), |s| Count(&mut s.lattice.rows)),
    field("spacing", within(1e-3, 100.0), |s| {
        Number(&mut s.lattice.spacing)
    }),
    field("origin_x", within(-1e3, 1e3), |s| {
        Number(&mut s.lattice.origin_x)
    }),
    field("drop", within(-10.0, 100.0), |s| {
        Number(&mut s.lattice.drop)
    }),
];

const PHYSICS: &[Field] = &[
    field("dt", within(1e-9, 1.0), |s| Number(&mut s.physics.dt)),
    field("steps", STEPS, |s| Count(&mut s.physics.steps)),
    field("integrator", NONE, |s| Choice(&mut s.physics.integrator)),
    field("substeps", within(1.0, 64.0), |s| {
        Count(&mut s.physics.substeps)
    }),
    field("gravity", within(-1e3, 1e3), |s| {
        Number(&mut s.physics.gravity)
    }),
    field("damping", within(0.0, 1e4), |s| {
        Number(&mut s.physics.damping)
    }),
    field("node_mass", within(1e-9, 1e3), |s| {
        Number(&mut s.physics.node_mass)
    }),
    field("payload_mass", within(0.0, 1e3), |s| {
        Number(&mut s.physics.payload_mass)
    }),
    field("ground_height", within(-1e3, 1e3), |s| {
        Number(&mut s.physics.ground_height)
    }),
    field("incline_deg", within(-80.0, 80.0), |s| {
        Number(&mut s.physics.incline_deg)
    }),
    field("contact", NONE, |s| Choice(&mut s.physics.contact)),
    field("friction", within(0.0, 1e3), |s| {
        Number(&mut s.physics.friction)
    }),
    field("stiffening", within(0.0, 1e6), |s| {
        Number(&mut s.physics.stiffening)
    }),
    field("bending_radius", within(0.0, 1.0), |s| {
        Number(&mut s.physics.bending_radius)
    }),
    field("void_edges", NONE, |s| Choice(&mut s.physics.void_edges)),
    field("unstable_step", NONE, |s| {
        Choice(&mut s.physics.unstable_step)
    }),
];

const MATERIALS: &[Field] = &[
    field("stiffness", within(0.0, 1e9), |s| {
        Numbers(&mut s.materials.stiffness)
    }),
    field("density", within(0.0, 1e6), |s| {
        Numbers(&mut s.materials.density)
    }),
    field("max_strain", within(0.0, 0.99), |s| {
        Numbers(&mut s.materials.max_strain)
    }),
    field("penalisation", within(1.0, 10.0), |s| {
        Count(&mut s.materials.penalisation)
    }),
];

const PROJECTION: &[Field] = &[
    field("beta", above(0.0, 1e4), |s| Number(&mut s.projection.beta)),
    field("beta_stability", above(0.0, 1e4), |s| {
        Number(&mut s.projection.beta_stability)
    }),
    field("beta_straight_through", above(0.0, 1e4), |s| {
        Number(&mut s.projection.beta_straight_through)
    }),
    field("delta", within(1e-15, 1.0), |s| {
        Number(&mut s.projection.delta)
    }),
    field("hold_materials", within(0.0, 10.0), |s| {
        Number(&mut s.projection.hold_materials)
    }),
];

const CONTROLLER: &[Field] = &[
    field("hidden", within(1.0, 4096.0), |s| {
        Count(&mut s.controller.hidden)
    }),
    field("clocks", within(1.0, 1024.0), |s| {
        Count(&mut s.controller.clocks)
    }),
    field("omega", within(0.0, 1e4), |s| {
        Number(&mut s.controller.omega)
    }),
    field("goal", within(-1e6, 1e6), |s| {
        Numbers(&mut s.controller.goal)
    }),
    field("goal_scale", within(0.0, 1e6), |s| {
        Number(&mut s.controller.goal_scale)
    }),
    field("goal_relative", NONE, |s| {
        Flag(&mut s.controller.goal_relative)
    }),
    field("two_goals", NONE, |s| Flag(&mut s.controller.two_goals)),
    field("offset_scale", within(0.0, 1e6), |s| {
        Number(&mut s.controller.offset_scale)
    }),
    field("velocity_scale", within(0.0, 1e6), |s| {
        Number(&mut s.controller.velocity_scale)
    }),
    field("gain", within(0.0, 1e3), |s| {
        Numbers(&mut s.controller.gain)
    }),
];

const START: &[Field] = &[
    field("kind", NONE, |s| Choice(&mut s.start.kind)),
    field("void_shift", within(-0.33, 0.66), |s| {
        Number(&mut s.start.void_shift)
    }),
    field("void", within(0.001, 0.999), |s| Number(&mut s.start.void)),
    field("layout", NONE, |s| Choice(&mut s.start.layout)),
    field("tilt", within(0.0, 0.5), |s| Number(&mut s.start.tilt)),
];

const VOLUME: &[Field] = &[
    field("solid", SHARE, |s| Numbers(&mut s.volume.solid)),
    field("actuator", SHARE, |s| Numbers(&mut s.volume.actuator)),
    field("widening", SHARE, |s| Number(&mut s.volume.widening)),
    field("widening_over", ITERATIONS, |s| {
        Counts(&mut s.volume.widening_over)
    }),
];

const SCHEDULE: &[Field] = &[
    field("iterations", within(1.0, 1e5), |s| {
        Count(&mut s.schedule.iterations)
    }),
    field("horizon", STEPS, |s| Counts(&mut s.schedule.horizon)),
    field("horizon_over", ITERATIONS, |s| {
        Counts(&mut s.schedule.horizon_over)
    }),
    field("horizon_mode", NONE, |s| {
        Choice(&mut s.schedule.horizon_mode)
    }),
    field("attraction_from", ITERATIONS, |s| {
        Count(&mut s.schedule.attraction_from)
    }),
    field("snap_at", ITERATIONS, |s| Count(&mut s.schedule.snap_at)),
    field("snap_trials", within(0.0, 1e4), |s| {
        Count(&mut s.schedule.snap_trials)
    }),
    field("polish_trials", within(0.0, 1e4), |s| {
        Count(&mut s.schedule.polish_trials)
    }),
    field("polish_every", within(1.0, 1e5), |s| {
        Count(&mut s.schedule.polish_every)
    }),
    field("cycle", within(1.0, 1e3), |s| Cycle(&mut s.schedule.cycle)),
    field("stability_share", SHARE, |s| {
        Number(&mut s.schedule.stability_share)
    }),
    field("settle", SHARE, |s| Number(&mut s.schedule.settle)),
];

const BINARISATION: &[Field] = &[
    field("method", NONE, |s| Choice(&mut s.binarisation.method)),
    field("threshold", SHARE, |s| {
        Number(&mut s.binarisation.threshold)
    }),
    field("threshold_over", ITERATIONS, |s| {
        Counts(&mut s.binarisation.threshold_over)
    }),
    field("penalty", within(0.0, 1e6), |s| {
        Number(&mut s.binarisation.penalty)
    }),
    field("penalty_growth", within(1.0, 10.0), |s| {
        Number(&mut s.binarisation.penalty_growth)
    }),
    field("confidence", SHARE, |s| {
        Numbers(&mut s.binarisation.confidence)
    }),
    field("nudge", SHARE, |s| Numbers(&mut s.binarisation.nudge)),
];

const MMA: &[Field] = &[
    field("move_limit", above(0.0, 1.0), |s| {
        Number(&mut s.mma.move_limit)
    }),
    field("asyinit", above(0.0, 10.0), |s| Number(&mut s.mma.asyinit)),
    field("asyincr", within(1.0, 10.0), |s| Number(&mut s.mma.asyincr)),
    field("asydecr", above(0.0, 1.0), |s| Number(&mut s.mma.asydecr)),
    field("asymin", above(0.0, 100.0), |s| Number(&mut s.mma.asymin)),
    field("asymax", above(0.0, 1e3), |s| Number(&mut s.mma.asymax)),
    field("albefa", within(0.01, 0.99), |s| Number(&mut s.mma.albefa)),
    field("raa0", POSITIVE, |s| Number(&mut s.mma.raa0)),
    field("c", POSITIVE, |s| Number(&mut s.mma.c)),
    field("d", POSITIVE, |s| Number(&mut s.mma.d)),
    field("volume_row_scale", POSITIVE, |s| {
        Number(&mut s.mma.volume_row_scale)
    }),
];

const ADAM: &[Field] = &[
    field("rate", within(0.0, 10.0), |s| Number(&mut s.adam.rate)),
    field("fine_rate", within(0.0, 10.0), |s| {
        Number(&mut s.adam.fine_rate)
    }),
    field("fine_decay", SHARE, |s| Number(&mut s.adam.fine_decay)),
    field("betas", within(0.0, 0.999999), |s| {
        Numbers(&mut s.adam.betas)
    }),
    field("epsilon", within(1e-30, 1.0), |s| {
        Number(&mut s.adam.epsilon)
    }),
    field("gradient_norm", POSITIVE, |s| {
        Bound(&mut s.adam.gradient_norm)
    }),
];

const GRADIENT: &[Field] = &[
    field("design_norm", POSITIVE, |s| {
        Bound(&mut s.gradient.design_norm)
    }),
    field("design_memory", DEVIATION, |s| {
        Number(&mut s.gradient.design_memory)
    }),
    field("cotangent_bound", POSITIVE, |s| {
        Bound(&mut s.gradient.cotangent_bound)
    }),
    field("cotangent_every", STEPS, |s| {
        Count(&mut s.gradient.cotangent_every)
    }),
    field("precision", NONE, |s| Choice(&mut s.gradient.precision)),
];

const LOSS: &[Field] = &[
    field("kind", NONE, |s| Choice(&mut s.loss.kind)),
    field("window", STEPS, |s| Count(&mut s.loss.window)),
    field("every", STEPS, |s| Count(&mut s.loss.every)),
];

const SELECTION: &[Field] = &[
    field("kind", NONE, |s| Choice(&mut s.selection.kind)),
    field("candidates", within(1.0, 1e4), |s| {
        Count(&mut s.selection.candidates)
    }),
    field("perturbed_rollouts", within(8.0, 1e4), |s| {
        Count(&mut s.selection.perturbed_rollouts)
    }),
    field("perturbation", within(0.0, 1e-3), |s| {
        Number(&mut s.selection.perturbation)
    }),
];

const OBJECTIVE: &[Field] = &[
    field("task", NONE, |s| Choice(&mut s.objective.task)),
    field("target", within(-1e3, 1e3), |s| {
        Number(&mut s.objective.target)
    }),
    field("settle", within(0.0, 1e3), |s| {
        Number(&mut s.objective.settle)
    }),
    field("energy_price", within(0.0, 1e6), |s| {
        Number(&mut s.objective.energy_price)
    }),
];

const ROBUST: &[Field] = &[
    field("samples", within(0.0, 1e4), |s| {
        Count(&mut s.robust.samples)
    }),
    field("start", within(0.0, 1.0), |s| Number(&mut s.robust.start)),
    field("friction", DEVIATION, |s| Number(&mut s.robust.friction)),
    field("stiffness", DEVIATION, |s| Number(&mut s.robust.stiffness)),
    field("mass", DEVIATION, |s| Number(&mut s.robust.mass)),
];

const SEARCH: &[Field] = &[
    field("rungs", within(1.0, 1e5), |s| Counts(&mut s.search.rungs)),
    field("keep", SHARE, |s| Numbers(&mut s.search.keep)),
    field("window", within(1.0, 1e5), |s| Count(&mut s.search.window)),
];
