//! [`CoDesign`], an optimisation that is ready to begin, and its state before the first iteration ([`Progress`]).

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::progress::Progress;
use super::schedule::Schedule;
use super::windows::{Walkers, Window};
use crate::design::{Design, LayoutRules, Material, Mixture, start};
use crate::error::{Error, Result};
use crate::judge::{Evaluator, Measurements};
use crate::objective::{AnyLoss, AugmentedLagrangian, Loss, measures, of_scene};
use crate::optimiser::{Adam, Mma, MmaSettings};
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::{BinarisationSettings, Scene};
use crate::world::{StepCheck, World};

/// Largest change of a design variable in an update of MMA, as a share of its range (found by experiment).
const MOVE_LIMIT: f64 = 0.02;

/// Distance of the first asymptotes of MMA, as a share of the range (found by experiment).
const FIRST_ASYMPTOTES: f64 = 0.05;

/// The settings of the optimiser of the design: all others are Svanberg's.
fn method() -> MmaSettings {
    MmaSettings {
        move_limit: MOVE_LIMIT,
        asyinit: FIRST_ASYMPTOTES,
        ..MmaSettings::default()
    }
}

/// The optimisation of a scene, ready to begin.
pub struct CoDesign {
    pub(super) evaluator: Evaluator,
    /// True if the caller supplied a loss, which replaces the scene's objective.
    own_loss: bool,
    /// The optimiser of the design. [`Progress::mma`] holds its state, one for each projection.
    pub(super) mma: Mma,
    pub(super) adam: Adam,
    /// The window in which controllers learn after the snap; `None` if they learn over the horizon.
    pub(super) window: Option<Window>,
    pub(super) rules: LayoutRules,
    /// The last design whose time step was checked, with the result of the check. It is kept so that a layout, which
    /// rarely changes, is not checked again in every iteration.
    pub(super) checked: Option<(Design<Mixture<f64>>, StepCheck)>,
}

impl CoDesign {
    /// Prepares the optimisation of a scene.
    ///
    /// # Errors
    /// The errors of [`Scene::check`].
    pub fn new(scene: &Scene) -> Result<Self> {
        let codesign = Self::of_loss(scene, of_scene(scene))?;
        Ok(Self {
            own_loss: false,
            window: Window::of_scene(&codesign.evaluator),
            ..codesign
        })
    }

    /// Prepares the optimisation of a scene for the caller's loss instead of the scene's objective.
    ///
    /// Robots are ranked by minus the loss, or by their displacement if [`Loss::is_far`] is true.
    ///
    /// ```
    /// use autodiff::Real;
    /// use cosmic::{objective::Loss, scene::Scene, search::CoDesign, world::Trajectory};
    ///
    /// /// The square of the last node's speed: a robot that stands still.
    /// struct Rest;
    ///
    /// impl Loss for Rest {
    ///     fn observed(&self, steps: usize) -> Vec<usize> {
    ///         vec![steps - 8, steps]
    ///     }
    ///     fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
    ///         let speeds = trajectory.states.iter().map(|s| s.v[5].dot(s.v[5]));
    ///         R::sum_of(&speeds.collect::<Vec<_>>()) * R::lit(0.5)
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
    /// let merit = delivery.merit.expect("the delivery for a custom loss has a merit");
    /// assert!(merit.p50 < 0.0); // Minus the loss.
    /// # Ok::<(), cosmic::Error>(())
    /// ```
    ///
    /// # Errors
    /// Like [`new`](Self::new); [`Error::Usage`] if the loss observes no node, or if, for some horizon of the schedule,
    /// the steps that it observes do not ascend or do not end with the last step.
    pub fn with_loss(scene: &Scene, loss: impl Loss + 'static) -> Result<Self> {
        Self::of_loss(scene, Arc::new(loss))
    }

    fn of_loss(scene: &Scene, loss: Arc<dyn AnyLoss>) -> Result<Self> {
        let evaluator = Evaluator::new(scene, loss)?;
        check_loss(&*evaluator.loss, scene)?;
        let lattice = evaluator.world.lattice();
        let variables = 3 * lattice.edges.len();
        let (lower, upper) = (vec![0.0; variables], vec![1.0; variables]);
        let mma = Mma::new(method(), &lower, &upper).expect("these settings suit the method");
        Ok(Self {
            own_loss: true,
            mma,
            adam: Adam::default(),
            window: None,
            rules: LayoutRules::new(lattice, &scene.design),
            checked: None,
            evaluator,
        })
    }

    /// Sets the flag with which another thread stops all rollouts, so that an iteration ends soon. The result of an
    /// iteration during which the flag was set is meaningless.
    pub fn stop_by(&mut self, stop: Option<Arc<AtomicBool>>) {
        self.evaluator.rollouts.stop = stop;
    }

    /// Begins an optimisation: returns the state before the first iteration. Its design is the initial design of the
    /// scene (`[start]`); its controller is drawn at random from the seed.
    ///
    /// # Errors
    /// [`Error::Usage`] if the initial design is a layout for another lattice; [`Error::UnstableStep`] if the time
    /// step is unstable for the initial design and the scene does not allow that.
    pub fn begin(&self, seed: u64) -> Result<Progress> {
        let progress = self.first(seed)?;
        self.step_check(&progress).accept(&self.scene().physics)?;
        Ok(progress)
    }

    /// Like [`begin`](Self::begin), but begins with a given robot instead of the scene's initial design.
    ///
    /// If the design is a layout, the optimisation begins after the snap, so only the fine-tuning remains. If the scene
    /// requires a design in one piece, bars of the layout that are not connected to the payload are removed. If the
    /// design is undecided, it goes through the whole schedule.
    ///
    /// # Errors
    /// [`Error::Misfit`] for a robot of another lattice or with another number of hidden units; [`Error::Usage`]
    /// for design vectors outside 0 to 1, for weights that are not finite, and for an undecided design in a scene
    /// without a snap; otherwise the errors of [`begin`](Self::begin).
    pub fn begin_with(
        &self,
        seed: u64,
        design: Design<[f64; 3]>,
        controller: Controller<f64>,
    ) -> Result<Progress> {
        let snap_at = self.scene().schedule.snap_at;
        let (design, entered) = match design {
            Design::Layout(layout) => {
                let whole = self.rules.without_loose_bars(&layout);
                (Design::Layout(whole), snap_at)
            }
            Design::Undecided(_) if snap_at == 0 => {
                return Err(Error::Usage(
                    "the initial design is not yet a layout (some edges are undecided), but this scene never \
                     decides them (`schedule.snap_at` = 0); begin with a layout, or set `schedule.snap_at`"
                        .into(),
                ));
            }
            undecided => (undecided, 0),
        };
        self.check_vectors(&design.vectors())?;
        if !controller.numbers().iter().all(|weight| weight.is_finite()) {
            return Err(Error::Usage(
                "the initial controller has weights that are NaN or infinite; all weights must be finite".into(),
            ));
        }
        if entered >= self.scene().schedule.iterations {
            return Err(Error::Usage(format!(
                "the initial design is already a layout, so that only fine-tuning remains, but the scene ends with \
                 its snap (iteration {snap_at}) and has no fine-tuning; raise `schedule.iterations`"
            )));
        }
        let first = self.first(seed)?;
        let progress = Progress {
            entered: Some(entered),
            iteration: entered,
            ..self.progress(seed, design, controller)
        };
        progress.fits(&first, "the robot to begin with")?;
        self.step_check(&progress).accept(&self.scene().physics)?;
        Ok(progress)
    }

    /// Refuses design vectors outside 0 to 1, and designs that contradict the rules of the lattice.
    fn check_vectors(&self, z: &[[f64; 3]]) -> Result<()> {
        let refuse = |says: String| Err(Error::Usage(format!("the initial design: {says}")));
        let rules = &self.world().lattice().rules;
        for (edge, z) in z.iter().enumerate() {
            if z.iter().any(|z| !(0.0..=1.0).contains(z)) {
                return refuse(format!(
                    "`z[{edge}]` is {z:?}; expected numbers from 0 to 1"
                ));
            }
            let material = Material::dominant(z);
            let allowed = rules.allowed(edge);
            if material.one_hot() == *z && !material.of(&allowed) {
                let rule = match allowed {
                    [true, ..] => "void",
                    [_, true, true] => "solid",
                    [_, true, _] => "skeleton",
                    _ => "an actuator",
                };
                let is = match material {
                    Material::Void => "void",
                    _ if rule == "void" => "solid",
                    Material::Skeleton => "skeleton",
                    Material::Actuator => "an actuator",
                };
                return refuse(format!(
                    "edge {edge} is {is}, but the lattice requires it to be {rule}"
                ));
            }
        }
        for tie in &rules.tie {
            if let Some(edge) = tie.iter().find(|&&edge| z.get(edge) != z.get(tie[0])) {
                let first = tie[0];
                return refuse(format!(
                    "edges {first} and {edge} are tied, but their `z` differ; they must be equal"
                ));
            }
        }
        Ok(())
    }

    /// Like [`begin`](Self::begin), but without the check of the time step.
    pub(crate) fn first(&self, seed: u64) -> Result<Progress> {
        let controller = Controller::xavier(&self.scene().controller, self.world().lattice(), seed);
        Ok(self.progress(seed, self.start_of(seed)?, controller))
    }

    /// The initial design of the scene. The seed has an effect only if the scene draws the design at random.
    fn start_of(&self, seed: u64) -> Result<Design<[f64; 3]>> {
        let beta = self.scene().projection.beta;
        start(&self.scene().start, self.world().lattice(), beta, seed)
    }

    /// The state, before the first iteration, of an optimisation that begins with a given design and controller.
    fn progress(
        &self,
        seed: u64,
        design: Design<[f64; 3]>,
        controller: Controller<f64>,
    ) -> Progress {
        let z = design.vectors();
        let mixtures = self
            .world()
            .projector()
            .mixtures(Projection::Performance, &z);
        let first_measures = measures(&mixtures, self.scene().projection.delta).constrained();
        Progress {
            seed,
            entered: None,
            own_loss: self.own_loss,
            iteration: 0,
            mma: [(); 2].map(|()| self.mma.init(z.as_flattened())),
            adam: self.adam.init(controller.weights()),
            lagrangian: AugmentedLagrangian::new(BinarisationSettings::PENALTY),
            first_measures,
            violations: [0.0; 4],
            flips: 0,
            skipped: 0,
            flat: 0,
            candidates: Vec::new(),
            design_mean: [Vec::new(), Vec::new()],
            settled: None,
            walkers: Walkers::default(),
            contenders: Vec::new(),
            measurements: Measurements::default(),
            design,
            controller,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.evaluator.scene
    }

    /// The world of the scene.
    pub fn world(&self) -> &World {
        &self.evaluator.world
    }

    /// The evaluator of robots.
    pub fn evaluator(&self) -> &Evaluator {
        &self.evaluator
    }

    /// Compares the time step with the vibrations of the current design. Random variations of the robot, which domain
    /// randomisation may draw, are included.
    pub fn step_check(&self, progress: &Progress) -> StepCheck {
        let design = self.design(progress);
        match &self.checked {
            Some((checked, check)) if *checked == design => *check,
            _ => self.evaluator.step_check_of(&design),
        }
    }

    /// Like [`step_check`](Self::step_check), but for the initial design that belongs to a seed.
    pub(super) fn step_check_at_start(&self, seed: u64) -> Result<StepCheck> {
        let start = self.start_of(seed)?;
        let design = self
            .world()
            .projector()
            .projected(Projection::Performance, &start);
        Ok(self.evaluator.step_check_of(&design))
    }
}

/// Refuses a loss that observes no node, and a loss whose observed steps do not ascend or do not end with the last
/// step.
fn check_loss(loss: &dyn AnyLoss, scene: &Scene) -> Result<()> {
    let horizon = |iteration| Schedule { scene, iteration }.horizon();
    let mut lengths: Vec<_> = (1..=scene.schedule.iterations).map(horizon).collect();
    lengths.push(scene.physics.steps);
    lengths.dedup();
    for steps in lengths {
        let observed = loss.observed(steps);
        if !observed.is_sorted() || observed.last() != Some(&steps) {
            return Err(Error::Usage(format!(
                "in a rollout of {steps} steps the loss observes {observed:?}; expected steps that ascend \
                 and end with {steps}"
            )));
        }
    }
    if loss.nodes() == 0 {
        return Err(Error::Usage(
            "the loss observes no node; it must observe at least one".into(),
        ));
    }
    Ok(())
}
