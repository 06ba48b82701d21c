//! An optimisation that is ready to begin, and the states before its first iteration.

use std::sync::Arc;

use autodiff::CotangentBound;

use super::progress::Progress;
use super::schedule::Schedule;
use crate::design::{LayoutRules, Material, dominant, one_hot, start_vectors};
use crate::error::{Error, Result};
use crate::lattice::{Lattice, State};
use crate::objective::{AnyLoss, AugmentedLagrangian, Loss, measures, of_scene};
use crate::optimiser::{Adam, Mma};
use crate::policy::Controller;
use crate::projection::Projection;
use crate::scene::{Scene, StartKind};
use crate::simulator::StepCheck;
use crate::task::{Horizon, Task};

/// A scene, ready to be optimised.
pub struct CoDesign {
    pub(super) scene: Scene,
    pub(super) task: Task,
    pub(super) loss: Arc<dyn AnyLoss>,
    /// True if the caller supplied the loss in place of the scene's objective.
    pub(super) own_loss: bool,
    pub(super) start: State<f64>,
    /// The design's optimiser; it has a state for each projection.
    pub(super) mma: Mma,
    pub(super) adam: Adam,
    pub(super) rules: LayoutRules,
    /// The last mixture whose time step was checked: a frozen layout is checked once.
    pub(super) checked: Option<(Vec<[f64; 3]>, StepCheck)>,
}

impl CoDesign {
    /// Prepares the optimisation of a scene.
    ///
    /// # Errors
    /// The errors of [`Scene::check`], and where the scene's optimiser settings do not fit one another.
    pub fn new(scene: &Scene) -> Result<Self> {
        Ok(Self {
            own_loss: false,
            ..Self::of_loss(scene, of_scene(scene))?
        })
    }

    /// Prepares the optimisation of a scene for the caller's loss in place of the scene's objective.
    ///
    /// Robots are ranked by minus the loss, or by their displacement if [`Loss::is_far`] is true. In
    /// a scene with two goals, the robot maximises the loss for the second goal.
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
    /// let merit = delivery.merit.expect("it is not ranked by its displacement");
    /// assert!(merit.p50 < 0.0); // Minus the loss.
    /// # Ok::<(), cosmic::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Usage`] if the loss looks at no node, or if, for any horizon
    /// of the schedule, its observed steps do not ascend to the last step.
    pub fn with_loss(scene: &Scene, loss: impl Loss + 'static) -> Result<Self> {
        Self::of_loss(scene, Arc::new(loss))
    }

    fn of_loss(scene: &Scene, loss: Arc<dyn AnyLoss>) -> Result<Self> {
        // A run writes its scene and reads it again: the scene has to be valid as a file.
        scene.check()?;
        check_loss(&*loss, scene)?;
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let variables = 3 * lattice.edges.len();
        let (lower, upper) = (vec![0.0; variables], vec![1.0; variables]);
        let mma = Mma::new(scene.mma.clone(), &lower, &upper)
            .map_err(|error| Error::Usage(format!("the scene's [mma] settings: {error}")))?;
        Ok(Self {
            loss,
            own_loss: true,
            start: lattice.state_at_rest(),
            mma,
            adam: Adam(scene.adam.clone()),
            rules: LayoutRules::new(&lattice, &scene.design),
            task: Task::new(
                lattice,
                &scene.physics,
                &scene.controller,
                &scene.materials,
                &scene.projection,
            )
            .with_memory(scene.gradient.budget())
            .with_one_piece(scene.design.one_piece),
            scene: scene.clone(),
            checked: None,
        })
    }

    /// The state before the first iteration.
    ///
    /// # Errors
    /// If the scene's start is a layout for another lattice; [`Error::UnstableStep`] if the time
    /// step is unstable for the start and the scene does not allow that.
    pub fn begin(&self, seed: u64) -> Result<Progress> {
        let progress = self.first(seed)?;
        self.step_check(&progress).accept(&self.scene.physics)?;
        Ok(progress)
    }

    /// The state before the first iteration of a given robot, in place of the scene's start; without its
    /// loose bars, if the scene asks for one piece. A robot
    /// with one-hot design vectors enters after the snap: only the fine-tuning is left. Any other
    /// robot goes through the whole schedule.
    ///
    /// # Errors
    /// [`Error::Misfit`] for a robot of another lattice or another number of hidden units,
    /// [`Error::Usage`] for design vectors outside 0 to 1, weights that are not finite, and a robot
    /// that is not one-hot in a scene without a snap; otherwise as [`begin`](Self::begin).
    pub fn begin_with(
        &self,
        seed: u64,
        z: Vec<[f64; 3]>,
        controller: Controller<f64>,
    ) -> Result<Progress> {
        let materials: Vec<_> = z.iter().map(dominant).collect();
        let materials = (one_hot(&materials) == z).then_some(materials);
        let whole = materials.map(|layout| self.rules.without_loose_bars(&layout));
        let (z, materials) = match whole {
            Some(layout) => (one_hot(&layout), Some(layout)),
            None => (z, None),
        };
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
                "the design to begin with: `z[{edge}]`: expected numbers from 0 to 1, found {:?}",
                z[edge]
            )));
        }
        self.check_rules(&z)?;
        if !controller.numbers().iter().all(|weight| weight.is_finite()) {
            return Err(Error::Usage(
                "the controller to begin with has weights that are not finite".into(),
            ));
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
            ..self.progress(seed, z, materials, controller)
        };
        progress.fits(&first, "the robot to begin with")?;
        self.step_check(&progress).accept(&self.scene.physics)?;
        Ok(progress)
    }

    /// Refuses design vectors that are against the rules of the lattice's edges.
    fn check_rules(&self, z: &[[f64; 3]]) -> Result<()> {
        let rules = &self.task.lattice.rules;
        let is_one_hot = |z: &[f64; 3]| one_hot(&[dominant(z)]) == [*z];
        let wrong = |&(edge, z): &(usize, &[f64; 3])| {
            is_one_hot(z) && !rules.allow(edge, dominant(z).is_solid())
        };
        let refuse = |says: String| Err(Error::Usage(format!("the design to begin with: {says}")));
        if let Some((edge, z)) = z.iter().enumerate().find(wrong) {
            let (is, rule) = if dominant(z).is_solid() {
                ("solid", "forbids")
            } else {
                ("void", "keeps")
            };
            return refuse(format!("edge {edge} is {is}, and the lattice {rule} it"));
        }
        for tie in &rules.tie {
            let own = |edge: &usize| z.get(*edge);
            if let Some(edge) = tie.iter().find(|edge| own(edge) != own(&tie[0])) {
                return refuse(format!(
                    "edges {} and {edge} are tied, and their `z` differ",
                    tie[0]
                ));
            }
        }
        Ok(())
    }

    /// The state before the first iteration, without the check of the time step.
    pub(crate) fn first(&self, seed: u64) -> Result<Progress> {
        let z = self.start_vectors(seed)?;
        let materials = (self.starts_as_layout()).then(|| z.iter().map(dominant).collect());
        let controller = Controller::xavier(&self.scene.controller, &self.task.lattice, seed);
        Ok(self.progress(seed, z, materials, controller))
    }

    fn start_vectors(&self, seed: u64) -> Result<Vec<[f64; 3]>> {
        let (start, beta) = (&self.scene.start, self.scene.projection.beta);
        start_vectors(start, &self.task.lattice, beta, seed)
    }

    fn starts_as_layout(&self) -> bool {
        self.scene.start.kind == StartKind::Layout
    }

    /// The state of a robot before any iteration.
    fn progress(
        &self,
        seed: u64,
        z: Vec<[f64; 3]>,
        materials: Option<Vec<Material>>,
        controller: Controller<f64>,
    ) -> Progress {
        let mixture = self.task.mixture(Projection::Performance, &z);
        let first_measures = measures(&mixture, self.scene.projection.delta).constrained();
        Progress {
            seed,
            entered: None,
            own_loss: self.own_loss,
            iteration: 0,
            mma: [(); 2].map(|()| self.mma.init(z.as_flattened())),
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

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The simulated task.
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// True if robots are ranked by their displacement, as [`Loss::is_far`] says.
    pub fn is_far(&self) -> bool {
        self.loss.is_far()
    }

    /// Compares the time step with the vibrations of the present design and of the robots that
    /// domain randomisation draws around it.
    pub fn step_check(&self, progress: &Progress) -> StepCheck {
        let mixture = self.mixture(progress);
        match &self.checked {
            Some((checked, check)) if *checked == mixture => *check,
            _ => self.step_check_of(&mixture),
        }
    }

    /// Compares the time step with the vibrations of the design that a seed starts from.
    pub(super) fn step_check_at_start(&self, seed: u64) -> Result<StepCheck> {
        let z = self.start_vectors(seed)?;
        Ok(self.step_check_of(&self.mixture_of(&z, self.starts_as_layout())))
    }

    fn step_check_of(&self, mixture: &[[f64; 3]]) -> StepCheck {
        let faster = self.scene.robust.faster();
        self.task.step_check(mixture, &self.start.x, faster)
    }

    /// The simulated mixture, the shares of void, skeleton and actuator of every edge: that of the layout if
    /// there is one, else the performance projection (D7).
    pub fn mixture(&self, progress: &Progress) -> Vec<[f64; 3]> {
        self.mixture_of(&progress.z, progress.materials.is_some())
    }

    /// The mixture of design vectors. Those of a layout are its mixture.
    fn mixture_of(&self, z: &[[f64; 3]], is_layout: bool) -> Vec<[f64; 3]> {
        if is_layout {
            z.to_vec()
        } else {
            self.task.mixture(Projection::Performance, z)
        }
    }

    /// The layout, or before the snap the dominant material of each edge.
    pub fn materials(&self, progress: &Progress) -> Vec<Material> {
        match &progress.materials {
            Some(materials) => materials.clone(),
            None => self.mixture(progress).iter().map(dominant).collect(),
        }
    }

    /// The steps that carry the gradient in this iteration, and how its cotangents are bounded.
    pub(super) fn horizon(&self, now: &Schedule) -> Horizon {
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
}

/// Refuses a loss that looks at steps that a rollout does not have.
fn check_loss(loss: &dyn AnyLoss, scene: &Scene) -> Result<()> {
    let horizon = |iteration| Schedule { scene, iteration }.horizon();
    let mut lengths: Vec<_> = (1..=scene.schedule.iterations).map(horizon).collect();
    lengths.push(scene.physics.steps);
    lengths.dedup();
    for steps in lengths {
        let observed = loss.observed(steps);
        if !observed.is_sorted() || observed.last() != Some(&steps) {
            return Err(Error::Usage(format!(
                "in a rollout of {steps} steps the loss observes {observed:?}: expected steps that \
                 ascend and end with {steps}"
            )));
        }
    }
    if loss.nodes() == 0 {
        return Err(Error::Usage("the loss looks at no node".into()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use autodiff::Real;

    use super::CoDesign;
    use crate::codesign::tests::{Up, tiny};
    use crate::error::Result;
    use crate::objective::Loss;
    use crate::scene::{GradientPrecision, LossKind, TaskKind};
    use crate::simulator::Trajectory;

    /// A caller's loss gives the same bits as the built-in loss of the same formula, in both
    /// precisions.
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
        // Every length that the horizon takes on the way.
        let mut scene = tiny();
        (scene.schedule.horizon, scene.schedule.horizon_over) = ([12, 24], [1, 5]);
        let astray = Astray(|steps| vec![steps - usize::from(steps == 15)]);
        let refused = CoDesign::with_loss(&scene, astray).err();
        let text = refused.expect("it is refused").to_string();
        assert!(text.contains("a rollout of 15 steps"), "{text}");
    }

    #[test]
    fn a_robot_to_begin_with_has_numbers_and_the_lattice_of_the_scene() {
        let codesign = CoDesign::new(&tiny()).unwrap();
        let progress = codesign.begin(1).unwrap();
        let robot = || (progress.z.clone(), progress.controller.clone());
        let said = |(z, controller)| {
            let refused = codesign.begin_with(1, z, controller).err();
            refused.map(|error| error.to_string())
        };
        assert_eq!(said(robot()), None);
        let (z, mut controller) = robot();
        controller.numbers_mut()[3] = f64::NAN;
        assert!(said((z, controller)).unwrap().contains("not finite"));
        let (mut z, controller) = robot();
        z[2][1] = f64::NAN;
        assert!(said((z, controller)).unwrap().contains("`z[2]`"));
        let (mut z, controller) = robot();
        z.pop();
        assert!(said((z, controller)).unwrap().contains("entries in `z`"));
    }
}
