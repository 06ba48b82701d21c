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
use crate::design::{
    Material, alternatives, attract, dominant, flips, one_hot, snap, start_vectors,
};
use crate::error::{Error, Result};
use crate::gradient::{Horizon, Task, together};
use crate::lattice::{Ground, Lattice, State};
use crate::objective::{AnyLoss, AugmentedLagrangian, Loss, Objective, measures, violations};
use crate::optimiser::{Adam, Mma, MmaParameters, OptimiserError};
use crate::projection::{self, Projection};
use crate::scene::{Pass, Scene, StartKind};
use crate::simulator::StepCheck;
use schedule::Moment;

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
    /// Plans the optimisation of a scene.
    ///
    /// # Errors
    /// Where the scene's optimiser settings do not fit one another.
    pub fn new(scene: &Scene) -> Result<Self> {
        let objective = Objective::new(&scene.objective, &scene.loss, &scene.physics);
        Ok(Self {
            own_loss: false,
            ..Self::with_loss(scene, objective)?
        })
    }

    /// Plans the optimisation of a scene for a loss of one's own in place of the scene's objective.
    ///
    /// Robots are then ranked by minus that loss, unless it [says](Loss::is_far) otherwise. In a
    /// scene with two goals the second is served by the opposite: by what has a large loss.
    ///
    /// ```
    /// use autodiff::Real;
    /// use cosmic::{codesign::CoDesign, objective::Loss, scene::Scene, simulator::Trajectory};
    ///
    /// /// The square of the last node's speed: a robot that stands still.
    /// struct Rest;
    ///
    /// impl Loss for Rest {
    ///     fn observed(&self, steps: usize) -> Vec<usize> {
    ///         vec![steps - 8, steps]
    ///     }
    ///     fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
    ///         let speeds = trajectory.states.iter().map(|s| R::dot(&s.v[5], &s.v[5]));
    ///         R::sum(&speeds.collect::<Vec<_>>()) * R::lit(0.5)
    ///     }
    /// }
    ///
    /// let scene = Scene::parse("tiny", "
    ///     [lattice]
    ///     columns = 3
    ///     rows = 2
    ///     [physics]
    ///     steps = 64
    ///     [schedule]
    ///     iterations = 8
    ///     attraction_from = 4
    ///     snap_at = 6
    ///     horizon = [32, 32]
    ///     [loss]
    ///     window = 16
    /// ")?;
    /// let delivery = CoDesign::with_loss(&scene, Rest)?.optimise(0, |_| ())?;
    /// let merit = delivery.merit.expect("it is not ranked by its displacement");
    /// assert!(merit.p50 < 0.0); // Minus the loss.
    /// # Ok::<(), cosmic::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Usage`] where the loss does not observe steps in ascending
    /// order up to the last, or no node.
    pub fn with_loss(scene: &Scene, loss: impl Loss + 'static) -> Result<Self> {
        check_loss(&loss, scene)?;
        let lattice = Lattice::new(&scene.lattice, &Ground::from(&scene.physics));
        let variables = 3 * lattice.edges.len();
        let mma = || {
            let (lower, upper) = (vec![0.0; variables], vec![1.0; variables]);
            Mma::new(mma_parameters(scene), &lower, &upper).map_err(unusable)
        };
        Ok(Self {
            loss: Box::new(loss),
            own_loss: true,
            start: lattice.state_at_rest(),
            mma: [mma()?, mma()?],
            adam: Adam {
                beta1: scene.adam.betas[0],
                beta2: scene.adam.betas[1],
                epsilon: scene.adam.epsilon,
            },
            task: Task::new(
                lattice,
                (&scene.physics, &scene.controller),
                &scene.materials,
                &scene.projection,
            ),
            scene: scene.clone(),
            checked: None,
        })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// What is simulated.
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// Whether robots are ranked by how far they get, as by [`Loss::is_far`].
    pub fn is_far(&self) -> bool {
        self.loss.is_far()
    }

    /// Optimises from a seed, showing every iteration's record to `observe`. To stop on the way, to
    /// save and to go on later, move a [`Progress`] by hand or have a
    /// [`Run`](crate::record::Run) do it in a folder.
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

    /// The state before the first iteration.
    ///
    /// # Errors
    /// Where the scene's start is drawn for another lattice, and [`Error::UnstableStep`] where the
    /// start vibrates too fast for the time step and the scene does not let that pass.
    pub fn begin(&self, seed: u64) -> Result<Progress> {
        let progress = self.first(seed)?;
        self.step_check(&progress).accept(&self.scene.physics)?;
        Ok(progress)
    }

    /// The state before the first iteration of a robot that is there already, in place of the
    /// scene's start. One whose design vectors are one-hot is decided: it enters after the snap, and
    /// the fine-tuning is what is left to do. Of a robot that the snap is still to decide the whole
    /// schedule is done.
    ///
    /// # Errors
    /// [`Error::Misfit`] for a robot of another lattice or another number of hidden units,
    /// [`Error::Usage`] for design vectors beyond 0 and 1 and for one that is not decided where the
    /// scene has no snap; otherwise as [`begin`](Self::begin).
    pub fn begin_with(
        &self,
        seed: u64,
        (z, controller): (Vec<[f64; 3]>, Controller<f64>),
    ) -> Result<Progress> {
        let materials: Vec<_> = z.iter().map(dominant).collect();
        let materials = (one_hot(&materials) == z).then_some(materials);
        let snap_at = self.scene.schedule.snap_at;
        if materials.is_none() && snap_at == 0 {
            return Err(Error::Usage(
                "the design to begin with is not decided, and the scene has no snap \
                 (`schedule.snap_at` = 0): it trains controllers alone"
                    .into(),
            ));
        }
        if let Some(edge) = z
            .iter()
            .position(|z| z.iter().any(|z| !(0.0..=1.0).contains(z)))
        {
            return Err(Error::Usage(format!(
                "the design to begin with: `z[{edge}]` is {:?}, where numbers from 0 to 1 are allowed",
                z[edge]
            )));
        }
        let entered = if materials.is_some() { snap_at } else { 0 };
        if entered >= self.scene.schedule.iterations {
            return Err(Error::Usage(format!(
                "the design to begin with is decided, and the scene ends with its snap (iteration \
                 {snap_at}): there is no fine-tuning left to do"
            )));
        }
        let first = self.first(seed)?;
        let progress = Progress {
            entered: Some(entered),
            iteration: entered,
            ..self.progress(seed, (z, materials), controller)
        };
        progress.fits(&first, "the robot to begin with")?;
        self.step_check(&progress).accept(&self.scene.physics)?;
        Ok(progress)
    }

    /// The state before the first iteration, whatever its time step.
    pub(crate) fn first(&self, seed: u64) -> Result<Progress> {
        let (scene, lattice) = (&self.scene, &self.task.lattice);
        let z = start_vectors(&scene.start, lattice, scene.projection.beta, seed)?;
        let is_layout = scene.start.kind == StartKind::Layout;
        let materials = is_layout.then(|| z.iter().map(dominant).collect());
        let controller = Controller::xavier(&scene.controller, lattice, seed);
        Ok(self.progress(seed, (z, materials), controller))
    }

    /// The state of a robot before any iteration.
    fn progress(
        &self,
        seed: u64,
        (z, materials): (Vec<[f64; 3]>, Option<Vec<Material>>),
        controller: Controller<f64>,
    ) -> Progress {
        let mixture = self.task.mixture(Projection::Performance, &z);
        let first_measures = measures(&mixture, self.scene.projection.delta).constrained();
        Progress {
            seed,
            entered: None,
            own_loss: self.own_loss,
            iteration: 0,
            mma: [0, 1].map(|k: usize| self.mma[k].init(z.as_flattened())),
            adam: self.adam.init(controller.weights()),
            lagrangian: AugmentedLagrangian::new(self.scene.binarisation.penalty),
            first_measures,
            violations: [0.0; 4],
            flips: 0,
            skipped: 0,
            candidates: Vec::new(),
            design_mean: [Vec::new(), Vec::new()],
            settled: None,
            z,
            materials,
            controller,
        }
    }

    /// The time step against the vibrations of the design as it stands.
    pub fn step_check(&self, progress: &Progress) -> StepCheck {
        let mixture = self.mixture(progress);
        match &self.checked {
            Some((checked, check)) if *checked == mixture => *check,
            _ => self.task.step_check(&mixture, &self.start.x),
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
        let moment = Moment {
            scene: &scene,
            iteration,
        };
        let mut record = self.blank_record(progress, &moment);
        match moment.phase() {
            Phase::CoDesign | Phase::Attraction => match moment.pass() {
                Pass::Design => self.design_pass(progress, &moment, &mut record),
                Pass::Controller => self.controller_pass(progress, (&moment, None), &mut record),
            },
            Phase::Snap => self.snap(progress, &moment),
            Phase::FineTuning => {
                let reached = self.polish(progress, &moment);
                self.controller_pass(progress, (&moment, reached), &mut record);
            }
        }
        if moment.phase() == Phase::Attraction {
            let (confidence, nudge) = moment.attraction();
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
    fn snap(&self, progress: &mut Progress, moment: &Moment) {
        let mixture = self.task.mixture(Projection::Performance, &progress.z);
        let bounds = moment.volume_bounds();
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

    fn horizon(&self, moment: &Moment) -> Horizon {
        let gradient = &self.scene.gradient;
        let every = gradient.cotangent_every;
        Horizon {
            steps: moment.horizon(),
            mode: self.scene.schedule.horizon_mode,
            cotangent_bound: gradient
                .cotangent_bound
                .map(|norm| CotangentBound { norm, every }),
        }
    }

    /// What is known at the start of an iteration.
    fn blank_record(&self, progress: &Progress, moment: &Moment) -> Record {
        let measures = measures(&self.mixture(progress), self.scene.projection.delta);
        let thresholds = moment.thresholds(&progress.first_measures);
        let pass = match moment.phase() {
            Phase::CoDesign | Phase::Attraction => Some(moment.pass()),
            Phase::Snap => None,
            Phase::FineTuning => Some(Pass::Controller),
        };
        Record {
            iteration: moment.iteration,
            phase: moment.phase(),
            pass,
            displacement: None,
            displacement_horizon: None,
            merit_horizon: None,
            horizon: moment.horizon(),
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

/// Whether a loss looks at what a rollout has.
fn check_loss(loss: &impl Loss, scene: &Scene) -> Result<()> {
    let [first, last] = scene.schedule.horizon;
    for steps in [first, last, scene.physics.steps] {
        let observed = loss.observed(steps);
        if !observed.is_sorted() || observed.last() != Some(&steps) {
            return Err(Error::Usage(format!(
                "of a rollout of {steps} steps the loss observes the steps {observed:?}, where \
                 they must ascend and end with {steps}"
            )));
        }
    }
    match loss.nodes() {
        0 => Err(Error::Usage("the loss looks at no node".into())),
        _ => Ok(()),
    }
}

fn mma_parameters(scene: &Scene) -> MmaParameters {
    let mma = &scene.mma;
    MmaParameters {
        move_limit: mma.move_limit,
        asyinit: mma.asyinit,
        asyincr: mma.asyincr,
        asydecr: mma.asydecr,
        asymin: mma.asymin,
        asymax: mma.asymax,
        albefa: mma.albefa,
        raa0: mma.raa0,
        c: mma.c,
        d: mma.d,
    }
}

/// The settings of an optimiser were refused.
fn unusable(error: OptimiserError) -> Error {
    Error::Usage(format!("the scene's [mma] settings: {error}"))
}

#[cfg(test)]
mod tests {
    use autodiff::Real;

    use super::CoDesign;
    use crate::design::flips;
    use crate::error::Result;
    use crate::objective::Loss;
    use crate::projection::one_hot;
    use crate::scene::{GradientPrecision, LossKind, Scene, TaskKind};
    use crate::simulator::Trajectory;

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
    /// Minus the payload's height, as a user would write it; the state after half of the steps
    /// counts too.
    struct Up;

    impl Loss for Up {
        fn observed(&self, steps: usize) -> Vec<usize> {
            vec![steps / 2, steps]
        }

        fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
            let heights: Vec<R> = trajectory.states.iter().map(|s| -s.x[0][1]).collect();
            R::sum(&heights) * R::lit(0.5)
        }
    }

    /// A loss of one's own is optimised as the built-in one that it is the same as: to the bit, in
    /// both precisions.
    #[test]
    fn an_own_loss_is_optimised_as_a_built_in_one() {
        for precision in [GradientPrecision::F64, GradientPrecision::F32] {
            let mut scene = tiny();
            scene.gradient.precision = precision;
            (scene.loss.kind, scene.loss.window, scene.loss.every) = (LossKind::Mean, 24, 12);
            let run = |codesign: Result<CoDesign>| {
                let mut records = Vec::new();
                let mut codesign = codesign.unwrap();
                let delivery = codesign.optimise(1, |record| records.push(record.clone()));
                (records, delivery.unwrap())
            };
            let own = run(CoDesign::with_loss(&scene, Up));
            assert_ne!(run(CoDesign::new(&scene)), own);
            scene.objective.task = TaskKind::Climb;
            assert_eq!(run(CoDesign::new(&scene)), own);
        }
    }

    #[test]
    fn a_loss_that_does_not_look_at_the_end_is_refused() {
        struct Astray(fn(usize) -> Vec<usize>);
        impl Loss for Astray {
            fn observed(&self, steps: usize) -> Vec<usize> {
                (self.0)(steps)
            }

            fn loss<R: Real>(&self, _: &Trajectory<R>) -> R {
                R::one()
            }
        }
        let said = |observed| {
            let refused = CoDesign::with_loss(&tiny(), Astray(observed)).err();
            refused.expect("it is refused").to_string()
        };
        let text = said(|steps| vec![steps - 1]);
        assert!(
            text.contains("[23]") && text.contains("end with 24"),
            "{text}"
        );
        assert!(said(|steps| vec![steps, 0, steps]).contains("[24, 0, 24]"));
        assert!(said(|_| Vec::new()).contains("[]"));
    }
}
