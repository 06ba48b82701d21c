//! Settings of the optimisation: schedule, both optimisers, gradient, loss, and choice of the result.

use super::Scene;
use autodiff::Memory;

use super::pass::Pass;
use crate::settings;
use crate::settings::{DEVIATION, ITERATIONS, POSITIVE, SHARE, STEPS, above, within};

settings! {
    /// What each iteration does.
    struct ScheduleSettings {
        /// Number of iterations.
        iterations: usize = 300, allowed within(1.0, 1e5),
            source "paper: 300, and 200 for the baseline";
        /// Number of steps that carry the gradient, at the start and at the end of the run.
        horizon: [usize; 2] = [2048, 4096], allowed STEPS, auto "a quarter and a half of `physics.steps`; for given goals, a half and all of the time of one goal", source "paper: 2048 to 4096";
        /// First and last iteration in which the horizon grows.
        horizon_over: [usize; 2] = [80, 150], allowed ITERATIONS, auto "80 and 150 for 300 iterations, and in proportion",
            read "with two horizons that differ" if |s: &Scene| s.schedule.horizon[0] != s.schedule.horizon[1],
            source "paper: 80 to 150";
        /// Which steps carry the gradient: the first ones, or the last ones of a whole rollout.
        horizon_mode: HorizonMode = HorizonMode::Head, source "D11";
        /// First iteration in which edges are attracted to a single material.
        attraction_from: usize = 170, allowed ITERATIONS, auto "17/24 of `snap_at`",
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 170";
        /// Iteration of the hard snap; 0 for a "layout" start, which has no snap.
        snap_at: usize = 240, allowed ITERATIONS,
            auto "four fifths of `iterations`; 0 for a \"layout\" start", source "paper: 240";
        /// Number of trials at the snap. Each trial changes the material of one of the edges with the least confidence
        /// and takes a full rollout. The best layout is kept.
        snap_trials: usize = 20, allowed within(0.0, 1e4),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
        /// Number of trials in each polish after the snap. Each trial changes the material of the edge for which the
        /// gradient promises most. All trials take a short rollout, and the best quarter a full one. The best layout is
        /// kept.
        polish_trials: usize = 16, allowed within(0.0, 1e4),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
        /// Iterations from one polish to the next. The first polish is right after the snap. No polish happens while
        /// the fine-tuning settles.
        polish_every: usize = 3, allowed within(1.0, 1e5),
            read "with `polish_trials` above 0" if |s: &Scene| s.schedule.polish_trials > 0 && s.designs(),
            source "paper silent";
        /// Sequence of passes, which repeats: d updates the design, c the controller.
        cycle: Vec<Pass> = passes("dcdcddcdcd"), allowed within(1.0, 1e3),
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: three to two";
        /// Share of the stability projection's update in a design pass.
        stability_share: f64 = 1.0 / 3.0, allowed SHARE,
            read "if the initial design is not a layout" if Scene::designs,
            source "found by experiment";
        /// Share of the fine-tuning, at its end, that continues from the best controller and takes back updates that
        /// lose distance.
        settle: f64 = 0.25, allowed SHARE, source "paper: 0";
    }
}

settings! {
    /// Which steps of a rollout carry the gradient (D11).
    enum HorizonMode {
        /// The first steps: the rollout ends after the horizon, with the loss at its end.
        Head = "head",
        /// The last steps: the whole rollout is simulated, and only its last steps carry the gradient.
        Tail = "tail",
    }
}

settings! {
    /// The method of moving asymptotes, for the design vectors.
    struct MmaSettings {
        /// Largest change of a variable in an update, as a share of its range.
        move_limit: f64 = 0.02, allowed above(0.0, 1.0), source "found by experiment";
        /// Distance of the first asymptotes, as a share of the range.
        asyinit: f64 = 0.05, allowed above(0.0, 10.0), source "found by experiment";
        /// Factor on the distance of the asymptotes if a variable keeps its direction.
        asyincr: f64 = 1.2, allowed within(1.0, 10.0), source "Svanberg";
        /// Factor on the distance of the asymptotes if a variable changes its direction.
        asydecr: f64 = 0.7, allowed above(0.0, 1.0), source "Svanberg";
        /// Least distance of the asymptotes, as a share of the range.
        asymin: f64 = 0.01, allowed above(0.0, 100.0), source "Svanberg";
        /// Largest distance of the asymptotes, as a share of the range.
        asymax: f64 = 10.0, allowed above(0.0, 1e3), source "Svanberg";
        /// Share of the distance to an asymptote that a variable keeps from it.
        albefa: f64 = 0.1, allowed within(0.01, 0.99), source "Svanberg";
        /// Curvature added to every term of the approximation.
        raa0: f64 = 1e-5, allowed POSITIVE, source "Svanberg";
        /// Linear cost of the elastic variables.
        c: f64 = 1000.0, allowed POSITIVE, source "Svanberg";
        /// Quadratic cost of the elastic variables.
        d: f64 = 1.0, allowed POSITIVE, source "Svanberg";
        /// Factor on the volume inequalities in MMA.
        volume_row_scale: f64 = 10.0, allowed POSITIVE, source "found by experiment";
    }
}

impl MmaSettings {
    /// The settings that the optimiser itself reads.
    pub(crate) fn method(&self) -> cosmic_optimiser::MmaSettings {
        cosmic_optimiser::MmaSettings {
            move_limit: self.move_limit,
            asyinit: self.asyinit,
            asyincr: self.asyincr,
            asydecr: self.asydecr,
            asymin: self.asymin,
            asymax: self.asymax,
            albefa: self.albefa,
            raa0: self.raa0,
            c: self.c,
            d: self.d,
        }
    }
}

settings! {
    /// Adam, for the controller's weights.
    struct AdamSettings {
        /// Learning rate while design and controller are both updated.
        rate: f64 = 0.003, allowed within(0.0, 10.0),
            auto "0.004 times the care to the power `T / 16.384 s` divided by the time scale, at most 1, where `T` is the \
                  time of a rollout",
            read "if the initial design is not a layout" if Scene::designs,
            source "found by experiment";
        /// Learning rate at the start of the fine-tuning, when only the controller is updated.
        fine_rate: f64 = 0.003, allowed within(0.0, 10.0), auto "3/4 of the rate that `rate` has with auto", source "found by experiment";
        /// Ratio of the learning rate at the end of the fine-tuning to the rate at its start. The rate falls linearly.
        /// Once the fine-tuning settles, it falls to zero.
        fine_decay: f64 = 0.1, allowed SHARE, source "found by experiment";
        /// Decay of the first and the second moment.
        betas: [f64; 2] = [0.9, 0.999], allowed within(0.0, 0.999999), source "Kingma and Ba";
        /// Keeps the update from dividing by zero.
        epsilon: f64 = 1e-8, allowed within(1e-30, 1.0), source "Kingma and Ba";
        /// Bound on the norm of the whole controller gradient, or "off". The derivative by the tempo of a learned clock
        /// is bounded by itself, to a third of this bound.
        gradient_norm: Option<f64> = Some(1.0), allowed POSITIVE, source "found by experiment";
    }
}

settings! {
    /// Bounds on gradients.
    struct GradientSettings {
        /// Bound on the norm of the displacement's design gradient, or "off".
        design_norm: Option<f64> = Some(0.3), allowed POSITIVE,
            read "if the initial design is not a layout" if Scene::designs,
            source "found by experiment";
        /// Weight of the earlier design gradients in the running mean that moves the design. Each gradient is bounded
        /// before it enters the mean. 0 uses only the newest gradient.
        design_memory: f64 = 0.8, allowed DEVIATION,
            read "if the initial design is not a layout" if Scene::designs,
            source "paper: 0";
        /// Bound on the norm of the state's cotangent in the reverse sweep, or "off".
        cotangent_bound: Option<f64> = Some(3.0), allowed POSITIVE,
            source "found by experiment; paper: off";
        /// Number of steps from one check of the cotangent to the next.
        cotangent_every: usize = 16, allowed STEPS,
            read "with a `cotangent_bound`" if |s: &Scene| s.gradient.cotangent_bound.is_some(),
            source "found by experiment";
        /// Memory for the states that a gradient keeps of its rollout, or of all rollouts that a thread runs together;
        /// "off" for no limit. If the memory is too small, some steps are computed again. The gradient does not depend
        /// on it.
        memory: Option<f64> = None, allowed POSITIVE, unit "MB", source "paper silent";
        /// Number type of the rollouts during the optimisation: for gradients, for trials of other materials, and for
        /// the full rollout of an iteration. Medians over perturbed starts, which choose controllers and are the
        /// results, are always in f64.
        precision: GradientPrecision = GradientPrecision::F64, source "paper silent";
    }
}

impl GradientSettings {
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
        /// Payload's position at the horizon's end, or its mean over the last steps.
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
        /// The last controller, the one with the best median over perturbed starts, or the one with the best robust
        /// displacement. For an unreliable robot, the 10 % quantile replaces the median.
        kind: SelectionKind = SelectionKind::Median, source "found by experiment; paper: last";
        /// Number of controllers whose medians are compared: those with the best single rollouts.
        candidates: usize = 6, allowed within(1.0, 1e4),
            read "unless the kind is `last`" if |s: &Scene| s.selection.kind != SelectionKind::Last,
            source "found by experiment";
        /// Number of rollouts from perturbed starts for each median, and of varied robots for each robust displacement.
        perturbed_rollouts: usize = 8, allowed within(8.0, 1e4), source "found by experiment";
        /// Distance by which each coordinate of a perturbed start is moved. It counts as `lattice.units` says: for
        /// `relative` in ten spacings, for `absolute` in metres.
        perturbation: f64 = 1e-9, allowed within(0.0, 1e-3), source "found by experiment";
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

/// The passes that these letters stand for. Every letter must be valid.
fn passes(letters: &str) -> Vec<Pass> {
    super::pass::cycle(letters).unwrap_or_default()
}
