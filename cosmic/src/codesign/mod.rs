//! The paper's algorithm 1: structure, material and controller optimised together.
//!
//! [`CoDesign::iterate`] is one iteration. It moves a [`Progress`], which is the whole state of
//! an optimisation, and tells what it did in a [`Record`]; what it draws depends on seed and
//! iteration alone, and it knows no files. [`CoDesign::deliver`] picks and measures the result.
//! [`CoDesign::optimise`] does all of it:
//!
//! ```
//! use cosmic::codesign::CoDesign;
//! use cosmic::scene::Scene;
//!
//! let scene = Scene::parse("tiny", "
//!     [lattice]
//!     columns = 3
//!     rows = 2
//!     [physics]
//!     steps = 64
//!     [schedule]
//!     iterations = 8
//!     attraction_from = 4
//!     snap_at = 6
//!     horizon = [32, 32]
//!     [loss]
//!     window = 16
//! ")?;
//! let mut design_gradients = Vec::new();
//! let delivery = CoDesign::new(&scene)?.optimise(0, |record| {
//!     design_gradients.extend(record.design_gradient[0]);
//! })?;
//! assert_eq!(design_gradients.len(), 3); // The cycle begins d c d c d, and 6 is the snap.
//! assert_eq!(delivery.materials.len(), 11);
//! println!("{:.3} m", delivery.spread.p50);
//! # Ok::<(), cosmic::Error>(())
//! ```

mod average;
mod begin;
mod delivery;
mod passes;
mod polish;
mod progress;
mod reach;
mod robust;
mod schedule;
mod settle;
mod slopes;

pub use delivery::{Delivery, Spread};
pub use progress::{Candidate, MmaDiagnostics, Progress, Record};
pub use reach::Reached;
pub use schedule::Phase;
pub use settle::Settled;

use autodiff::CotangentBound;
use rayon::prelude::*;

use crate::controller::Controller;
use crate::design::{Material, alternatives, attract, dominant, flips, snap};
use crate::error::Result;
use crate::gradient::{Horizon, Task, together};
use crate::lattice::State;
use crate::objective::{AnyLoss, measures, violations};
use crate::optimiser::{Adam, Mma};
use crate::projection::{self, Projection};
use crate::scene::{Pass, Scene};
use crate::simulator::StepCheck;
use schedule::Schedule;

/// Iterations of the co-design from one full rollout to the next. The fine-tuning, whose
/// controllers are candidates for delivery, has one every iteration.
const EVALUATE_EVERY: usize = 10;

/// A scene, ready to be optimised.
pub struct CoDesign {
    scene: Scene,
    task: Task,
    loss: Box<dyn AnyLoss>,
    /// Whether it is another than the scene's.
    own_loss: bool,
    start: State<f64>,
    /// The design's optimiser, for each projection.
    mma: [Mma; 2],
    adam: Adam,
    /// The last mixture whose time step was checked: a frozen layout is checked once.
    checked: Option<(Vec<[f64; 3]>, StepCheck)>,
}

impl CoDesign {
    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What is simulated.
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// Whether robots are ranked by how far they get, as by
    /// [`Loss::is_far`](crate::objective::Loss::is_far).
    pub fn is_far(&self) -> bool {
        self.loss.is_far()
    }

    /// Optimises from a seed, showing every iteration's record to `observe`. To stop on the way, to
    /// save and to go on later, move a [`Progress`] by hand or have
    /// [`record::optimise_with`](crate::record::optimise_with) do it in a folder.
    ///
    /// # Errors
    /// As [`begin`](Self::begin), the time step checked after every iteration.
    pub fn optimise(&mut self, seed: u64, mut observe: impl FnMut(&Record)) -> Result<Delivery> {
        let mut progress = self.begin(seed)?;
        while !self.is_done(&progress) {
            observe(&self.iterate(&mut progress));
            self.step_check(&progress).accept(&self.scene.physics)?;
        }
        Ok(self.deliver(&progress))
    }

    /// The time step against the vibrations of the design as it stands, and of robots drawn around it.
    pub fn step_check(&self, progress: &Progress) -> StepCheck {
        let mixture = self.mixture(progress);
        match &self.checked {
            Some((checked, check)) if *checked == mixture => *check,
            _ => {
                let faster = self.scene.robust.faster();
                self.task.step_check(&mixture, &self.start.x, faster)
            }
        }
    }

    /// Whether all iterations are done.
    pub fn is_done(&self, progress: &Progress) -> bool {
        progress.iteration >= self.scene.schedule.iterations
    }

    /// One iteration of algorithm 1.
    pub fn iterate(&mut self, progress: &mut Progress) -> Record {
        let iteration = progress.iteration + 1;
        let scene = self.scene.clone();
        let now = Schedule {
            scene: &scene,
            iteration,
        };
        let mut record = self.blank_record(progress, &now);
        match now.phase() {
            Phase::CoDesign | Phase::Attraction => match now.pass() {
                Pass::Design => self.design_pass(progress, &now, &mut record),
                Pass::Controller => self.controller_pass(progress, (&now, None), &mut record),
            },
            Phase::Snap => self.snap(progress, &now),
            Phase::FineTuning => {
                let reached = self.polish(progress, &now);
                self.controller_pass(progress, (&now, reached), &mut record);
            }
        }
        if now.phase() == Phase::Attraction {
            let (confidence, nudge) = now.attraction();
            let mixture = self.task.mixture(Projection::Performance, &progress.z);
            attract(&mut progress.z, &mixture, confidence, nudge);
        }
        progress.iteration = iteration;
        progress.skipped += record.skipped;
        record.multipliers = progress.lagrangian.multiplier;
        record.penalties = progress.lagrangian.penalty;
        let check = self.step_check(progress);
        self.checked = Some((self.mixture(progress), check));
        record.time_step = Some(check);
        record
    }

    /// Gives every edge one material, within the widened volume bounds.
    fn snap(&self, progress: &mut Progress, now: &Schedule) {
        let mixture = self.task.mixture(Projection::Performance, &progress.z);
        let bounds = now.volume_bounds();
        let snapped = snap(&mixture, &bounds);
        let others = alternatives(&mixture, &snapped, &bounds);
        let others: Vec<_> = others.take(self.scene.schedule.snap_trials).collect();
        let (materials, _) = self.farthest(snapped, others, &progress.controller);
        progress.flips = flips(&mixture, &materials);
        progress.lay_out(materials);
    }

    /// The best of a layout and others by one full rollout each, the first of equals, and what it
    /// reached there. The best of one needs no rollout.
    fn farthest(
        &self,
        layout: Vec<Material>,
        others: impl IntoIterator<Item = Vec<Material>>,
        controller: &Controller<f64>,
    ) -> (Vec<Material>, Option<Reached>) {
        let mut layouts: Vec<_> = std::iter::once(layout).chain(others).collect();
        if layouts.len() == 1 {
            return (layouts.remove(0), None);
        }
        let reached = self.reached(&layouts, controller, &self.task);
        let best = delivery::first_best(reached.iter().map(|r| r.merit));
        (layouts.swap_remove(best), Some(reached[best]))
    }

    /// What several layouts reach with one controller; in parallel, the order kept.
    fn reached(
        &self,
        layouts: &[Vec<Material>],
        controller: &Controller<f64>,
        task: &Task,
    ) -> Vec<Reached> {
        let mixtures: Vec<Vec<_>> = layouts.iter().map(|l| projection::one_hot(l)).collect();
        let side_by_side = |mixtures: &[Vec<_>]| {
            let mixtures: Vec<&[_]> = mixtures.iter().map(Vec::as_slice).collect();
            self.try_many(&mixtures, controller, task)
        };
        let groups = mixtures.par_chunks(together(layouts.len()));
        groups.flat_map_iter(side_by_side).collect()
    }

    /// The mixture that is simulated: of the performance projection, or of the layout (D7).
    fn mixture(&self, progress: &Progress) -> Vec<[f64; 3]> {
        match &progress.materials {
            Some(materials) => projection::one_hot(materials),
            None => self.task.mixture(Projection::Performance, &progress.z),
        }
    }

    /// The layout, and before there is one the material nearest to each edge's mixture.
    pub(crate) fn materials(&self, progress: &Progress) -> Vec<Material> {
        match &progress.materials {
            Some(materials) => materials.clone(),
            None => self.mixture(progress).iter().map(dominant).collect(),
        }
    }

    fn horizon(&self, now: &Schedule) -> Horizon {
        let gradient = &self.scene.gradient;
        let every = gradient.cotangent_every;
        Horizon {
            steps: now.horizon(),
            mode: self.scene.schedule.horizon_mode,
            cotangent_bound: gradient
                .cotangent_bound
                .map(|norm| CotangentBound { norm, every }),
        }
    }

    /// What is known at the start of an iteration.
    fn blank_record(&self, progress: &Progress, now: &Schedule) -> Record {
        let measures = measures(&self.mixture(progress), self.scene.projection.delta);
        let thresholds = now.thresholds(&progress.first_measures);
        let pass = match now.phase() {
            Phase::CoDesign | Phase::Attraction => Some(now.pass()),
            Phase::Snap => None,
            Phase::FineTuning => Some(Pass::Controller),
        };
        Record {
            iteration: now.iteration,
            phase: now.phase(),
            pass,
            displacement: None,
            displacement_horizon: None,
            merit_horizon: None,
            horizon: now.horizon(),
            volume: measures.volume,
            actuator_volume: measures.actuator_volume,
            measures: measures.constrained(),
            violations: violations(measures.constrained(), &thresholds),
            multipliers: [0.0; 4],
            penalties: [0.0; 4],
            design_gradient: [None; 2],
            controller_gradient: None,
            mma: [None, None],
            skipped: 0,
            time_step: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::CoDesign;
    use crate::design::flips;
    use crate::projection::one_hot;
    use crate::scene::{LossKind, Scene};

    /// A small robot that moves from the first, with room for other layouts, and the beginning of
    /// its schedule.
    pub(super) const LIVELY: &str = "
        [lattice]
        columns = 3
        rows = 3
        drop = 0.05
        [physics]
        steps = 256
        [controller]
        gain = [6.0, 6.0]
        [volume]
        widening = 0.2
        widening_over = [1, 2]
        [loss]
        window = 32
        [schedule]
        attraction_from = 4
        snap_at = 7
        horizon = [64, 64]
    ";

    /// A robot of two squares for a few steps.
    pub(super) fn tiny() -> Scene {
        let mut scene = Scene::default();
        (scene.lattice.columns, scene.lattice.rows) = (3, 2);
        (scene.physics.steps, scene.controller.hidden) = (24, 3);
        scene.schedule.iterations = 12;
        (scene.schedule.attraction_from, scene.schedule.snap_at) = (8, 11);
        scene.schedule.horizon = [24, 24];
        scene.loss.kind = LossKind::Final;
        scene
    }

    /// How far the snapped robot of a seed gets.
    fn after_the_snap(trials: usize, seed: u64) -> f64 {
        let mut scene = Scene::parse("snapped", &[LIVELY, "iterations = 8"].concat()).unwrap();
        scene.schedule.snap_trials = trials;
        let mut codesign = CoDesign::new(&scene).unwrap();
        let mut progress = codesign.begin(seed).unwrap();
        while progress.iteration + 1 < scene.schedule.snap_at {
            codesign.iterate(&mut progress);
        }
        let soft = codesign.mixture(&progress);
        codesign.iterate(&mut progress);
        let materials = progress.materials.as_ref().unwrap();
        // Those of the layout that was chosen, not of the one that others were tried beside.
        assert_eq!(progress.flips, flips(&soft, materials));
        assert_eq!(codesign.mixture(&progress), one_hot::<f64>(materials));
        codesign.evaluate(&progress).merit
    }

    #[test]
    fn trials_at_the_snap_find_better_robots() {
        let merits = |seed| [0, 8].map(|trials| after_the_snap(trials, seed));
        let pairs: Vec<_> = (0..4).map(merits).collect();
        assert!(
            pairs.iter().all(|[plain, tried]| tried >= plain),
            "{pairs:?}"
        );
        assert!(
            pairs.iter().any(|[plain, tried]| tried > plain),
            "{pairs:?}"
        );
    }
}
