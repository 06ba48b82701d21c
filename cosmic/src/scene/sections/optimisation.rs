//! Settings of the optimisation: schedule, both optimisers, gradient, loss, and choice of the result.

use crate::scene::Scene;
use autodiff_programs::Memory;

use crate::settings;
use crate::settings::{DEVIATION, ITERATIONS, POSITIVE, SHARE, STEPS, within};

settings! {
    /// What each iteration does.
    struct ScheduleSettings {
        /// Number of iterations.
        iterations: usize = 300, allowed within(1.0, 1e5), auto "75 with a `window`, 300 without",
            source "paper: 300, and 200 for the baseline";
        /// Number of steps that carry the gradient, from the start of a rollout: the first number is for the start of the run,
        /// the second for its end.
        horizon: [usize; 2] = [2048, 4096], allowed STEPS, auto "a quarter and a half of `physics.steps`; for given goals, a half and all of the time of one goal", source "paper: 2048 to 4096";
        /// First and last iteration in which the horizon grows.
        horizon_over: [usize; 2] = [80, 150], allowed ITERATIONS, auto "80 and 150 for 300 iterations, and in proportion",
            read "with two horizons that differ" if |s: &Scene| s.schedule.horizon[0] != s.schedule.horizon[1],
            source "paper: 80 to 150";
        /// First iteration in which edges are attracted to a single material.
        attraction_from: usize = 170, allowed ITERATIONS, auto "17/24 of `snap_at`",
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 170";
        /// Iteration of the hard snap; 0 for a "layout" start, which has no snap.
        snap_at: usize = 240, allowed ITERATIONS,
            auto "four fifths of `iterations`; 1 with a `window`; 0 for a \"layout\" start", source "paper: 240";
        /// Number of trials at the snap. Each gives another material to one of the least confident edges.
        snap_trials: usize = 20, allowed within(0.0, 1e4),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
        /// Number of trials in every third iteration after the snap. Each gives another material to one of the edges for which
        /// the gradient promises most: the gradient over the next window, or without windows over the horizon.
        polish_trials: usize = 16, allowed within(0.0, 1e4),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
        /// Share of the stability projection's update in a design pass.
        stability_share: f64 = 1.0 / 3.0, allowed SHARE,
            read "if the initial design is not a layout" if Scene::designs,
            source "found by experiment";
        /// Length of the last part of the fine-tuning, as a share of it. This part continues from the best controller and takes
        /// back updates that lose distance.
        settle: f64 = 0.25, allowed SHARE,
            read "without a `window`" if |s: &Scene| !s.learns_in_windows(), source "paper: 0";
        /// Time of a window: after the snap the controller learns from several robots that walk side by side, after each
        /// window. "off": it learns over the horizon, from the start.
        window: Option<f64> = None, allowed POSITIVE, unit "s", auto "1.024 s times the time scale; off in space and for goals or losses of one's own",
            read "with a loss of `task` and goals that are fixed" if Scene::can_be_cut, source "paper: off";
    }
}

settings! {
    /// Adam, for the controller's weights.
    struct AdamSettings {
        /// Learning rate while design and controller are both updated.
        rate: f64 = 0.003, allowed within(0.0, 10.0),
            auto "0.004 times the care to the power `p`, where `p` is the time of a rollout divided by 16.384 s and by the time \
                  scale, but at most 1",
            read "if the initial design is not a layout" if Scene::designs,
            source "found by experiment";
        /// Learning rate at the start of the fine-tuning, when only the controller is updated. It falls linearly to a
        /// tenth; once the fine-tuning settles, to zero.
        fine_rate: f64 = 0.003, allowed within(0.0, 10.0), auto "3/4 of the rate that `rate` has with auto", source "found by experiment";
    }
}

settings! {
    /// Bounds on gradients.
    struct GradientSettings {
        /// Weight of the earlier design gradients in the running mean that moves the design.
        design_memory: f64 = 0.8, allowed DEVIATION,
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
        /// Bound on the norm of the state's cotangent in the reverse sweep.
        cotangent_bound: Option<f64> = Some(3.0), allowed POSITIVE,
            source "found by experiment; paper: off";
        /// Memory of a thread for the states of rollouts, which a gradient needs; "off": no limit. If it is too small for all
        /// states, some steps are computed twice. The gradient is the same.
        memory: Option<f64> = None, allowed POSITIVE, unit "MB", source "paper silent";
        /// Number type of the rollouts during the optimisation. Medians over perturbed starts are always computed in f64: they
        /// decide which controller is delivered, and are the results.
        precision: GradientPrecision = GradientPrecision::F64, source "paper silent";
    }
}

impl GradientSettings {
    /// Number of steps from one check of the cotangent to the next (found by experiment).
    pub const COTANGENT_EVERY: usize = 16;

    /// The setting `memory` as the memory budget of a simulator.
    pub fn budget(&self) -> Memory {
        let bytes = |megabytes: f64| Memory::Bytes((megabytes * 1e6) as usize);
        self.memory.map_or(Memory::All, bytes)
    }
}

settings! {
    /// The number type of a rollout.
    enum GradientPrecision {
        /// Sixteen digits.
        F64 = "f64",
        /// Seven digits, but faster.
        F32 = "f32",
    }
}

settings! {
    /// The displacement loss for gradients. Reports state the final displacement.
    struct LossSettings {
        /// What the loss measures: the payload's position at the horizon's end, or its mean over the last steps.
        kind: LossKind = LossKind::Mean, source "found by experiment; paper: final";
        /// Number of steps at the horizon's end that the mean covers.
        window: usize = 2048, allowed STEPS, auto "a quarter of `physics.steps`, but not above the first horizon",
            read "with the kind `mean`" if |s: &Scene| s.loss.kind == LossKind::Mean,
            source "found by experiment";
        /// Steps from one position in the mean to the next.
        every: usize = 16, allowed STEPS, auto "the window divided by 128",
            read "with the kind `mean`" if Scene::sees_several_states,
            source "found by experiment";
    }
}

settings! {
    /// The steps of the horizon in which the payload's position counts.
    enum LossKind {
        /// At the last step (the paper's objective).
        Final = "final",
        /// On average over the last steps.
        Mean = "mean",
    }
}

settings! {
    /// The choice of the controller that is delivered, and the measurement of designs.
    struct SelectionSettings {
        /// The controller that is delivered: the last one, the one with the best median over perturbed starts, or the one with
        /// the best robust displacement, which is the 10 % quantile over robots that vary a little.
        kind: SelectionKind = SelectionKind::Median, source "found by experiment; paper: last";
    }
}

settings! {
    /// The choice of the result.
    enum SelectionKind {
        /// The last one (the paper's algorithm).
        Last = "last",
        /// The candidate with the best median over perturbed starts.
        Median = "median",
        /// The candidate with the best robust displacement: the 10 % quantile over robots that vary a little. Their
        /// starts vary by 1 % of a spacing, their friction and the stiffness of their edges by 5 %.
        Robust = "robust",
    }
}

impl SelectionSettings {
    /// Number of rollouts from perturbed starts for each median, and of varied robots for each robust displacement
    /// (found by experiment).
    pub const PERTURBED_ROLLOUTS: usize = 8;

    /// Number of rollouts for each of the quantiles in a final summary. The 10 % quantile of eight rollouts is little more
    /// than the least of them, and differs much from draw to draw.
    pub const FINAL_ROLLOUTS: usize = 24;

    /// Distance by which each coordinate of a perturbed start is moved, in units of ten spacings (found by experiment).
    pub const PERTURBATION: f64 = 1e-9;
}
