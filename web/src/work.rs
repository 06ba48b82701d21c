//! The work of a session: a design in progress, or a finished robot, with its walk and its measurements.

use crate::{packed, view};
use cosmic::design::{Design, Material, Mixture};
use cosmic::error::Error;
use cosmic::geometry::{Ground, Vector};
use cosmic::judge::{Delivery, Measurements, Measuring};
use cosmic::lattice::State;
use cosmic::outcome::Summary;
use cosmic::policy::{Controller, Goals};
use cosmic::scene::{ControllerSettings, GoalKind, PhysicsSettings, Scene, SelectionSettings};
use cosmic::search::{CoDesign, Progress};
use cosmic::walk;
use cosmic::world::{Span, Trajectory, World};
use serde_json::{Value, json};
use std::cell::Cell;

/// A design in progress, and its robot once it is finished.
pub(crate) struct Work {
    pub(crate) codesign: CoDesign,
    pub(crate) progress: Progress,
    /// The robot that the optimisation has delivered; `None` before its end.
    pub(crate) delivered: Option<PageRobot>,
    /// The controller of the delivered robot before it was packed. It also has weights for void edges, which become
    /// solid if the user edits them.
    pub(crate) whole: Option<Whole>,
    /// The delivered robot with the materials that the user has edited, if any.
    pub(crate) edited: Option<PageRobot>,
    /// What is measured of the finished robot so far.
    pub(crate) measurements: Measurements,
    /// The world in which the user lets the finished robot walk on; `None` in the world of the scene.
    pub(crate) elsewhere: Option<World>,
    /// The walk that was shown last; `None` if it diverged.
    pub(crate) walk: Option<Walk>,
}

/// A walk that can go on from any of its frames.
pub(crate) struct Walk {
    pub(crate) robot: PageRobot,
    /// The number of steps on the clock at the start of the walk.
    pub(crate) first: usize,
    /// The states in the frames.
    pub(crate) frames: Vec<State<f64>>,
}

#[derive(Clone)]
pub(crate) struct PageRobot {
    pub(crate) design: Design<[f64; 3]>,
    /// The design after the projection. It contains the mixtures that are simulated.
    pub(crate) projected: Design<Mixture<f64>>,
    pub(crate) controller: Controller<f64>,
    /// The robot in a link; `None` if it does not fit into one. The robot of the link has the same bits.
    pub(crate) bytes: Option<Vec<u8>>,
}

/// A controller, and the settings for which it was designed.
#[derive(Clone)]
pub(crate) struct Whole {
    pub(crate) settings: ControllerSettings,
    pub(crate) controller: Controller<f64>,
}

/// The work on a packed robot.
pub(crate) struct Packed {
    pub(crate) work: Work,
    /// The controllers among which the delivery chooses: packed in a robot, and whole.
    pub(crate) entrants: Vec<(PageRobot, Whole)>,
}

/// The seed of the starts from which a finished robot is measured. It does not depend on the seed of the design, so
/// that the robot of a link is measured like the robot that was designed.
pub(crate) const MEASURED: u64 = 0;

pub(crate) fn nothing() -> Error {
    Error::Usage("there is no robot yet; send the request `begin` first".to_owned())
}

impl Work {
    /// A design in progress, before a robot has been shown.
    pub(crate) fn of(codesign: CoDesign, progress: Progress) -> Self {
        Self {
            codesign,
            progress,
            delivered: None,
            whole: None,
            edited: None,
            measurements: Measurements::default(),
            elsewhere: None,
            walk: None,
        }
    }

    /// The work on the packed robot `bytes` of a scene, before the robot is unpacked.
    pub(crate) fn open_loop(scene: &Scene, bytes: &[u8]) -> cosmic::Result<Self> {
        let codesign = CoDesign::new(&packed::scene_of(scene.clone(), bytes)?)?;
        let progress = codesign.begin(MEASURED)?;
        Ok(Self::of(codesign, progress))
    }

    /// Returns this work with its robot as a link holds it; `None` if the robot does not fit into a link.
    pub(crate) fn packed(&self) -> cosmic::Result<Option<Packed>> {
        let Design::Layout(materials) = &self.progress.design else {
            return Ok(None);
        };
        let settings = &self.codesign.scene().controller;
        let entrants = self.codesign.entrants(&self.progress);
        let whole = |controller: &Controller<f64>| Whole {
            settings: settings.clone(),
            controller: controller.clone(),
        };
        let wholes: Vec<Whole> = entrants
            .iter()
            .map(|entrant| whole(&entrant.controller))
            .collect();
        let bytes = wholes.iter().map(|whole| self.pack(whole, materials));
        let Ok(bytes) = bytes.collect::<cosmic::Result<Vec<_>>>() else {
            return Ok(None);
        };
        let mut work = Self::open_loop(self.codesign.scene(), &bytes[0])?;
        let robots = bytes.into_iter().map(|bytes| work.unpack(bytes));
        let robots = robots.collect::<cosmic::Result<Vec<PageRobot>>>()?;
        let progress = &mut work.progress;
        progress.design = robots[0].design.clone();
        // The controller of the last iteration is the first entrant, and must be the last one here.
        for (robot, entrant) in robots.iter().zip(&entrants).rev() {
            progress.iteration = entrant.iteration;
            progress.controller = robot.controller.clone();
            let merit = work.codesign.evaluate(progress).merit;
            progress.note_candidate(merit);
        }
        let entrants = robots.into_iter().zip(wholes).collect();
        Ok(Some(Packed { work, entrants }))
    }

    pub(crate) fn pack(&self, whole: &Whole, materials: &[Material]) -> cosmic::Result<Vec<u8>> {
        let (world, controller) = (self.codesign.world(), &whole.controller);
        packed::pack(
            &whole.settings,
            world.lattice(),
            &world.ground(),
            materials,
            controller,
        )
    }

    /// The robot of a link to the scene of this work.
    pub(crate) fn unpack(&self, bytes: Vec<u8>) -> cosmic::Result<PageRobot> {
        let settings = &self.codesign.scene().controller;
        let (materials, controller) =
            packed::unpack(settings, self.codesign.world().lattice(), &bytes)?;
        Ok(PageRobot {
            design: Design::Layout(materials.clone()),
            projected: Design::Layout(materials),
            controller,
            bytes: Some(bytes),
        })
    }

    /// Chooses the robot to deliver and measures it. Every quantile is over eight rollouts, a third of those of the program,
    /// so that nobody waits.
    pub(crate) fn deliver(&self, progress: &Progress) -> Delivery {
        let mut eight = Measuring::over(SelectionSettings::PERTURBED_ROLLOUTS);
        let delivery = self.codesign.deliver_unless(progress, &mut eight);
        delivery.expect("nothing stops these measurements")
    }

    /// Does one more of the measurements of the finished robot, which takes seconds for a robot of real parts. Returns all of
    /// them for an answer, `None` if some are left.
    pub(crate) fn judge_further(&mut self) -> cosmic::Result<Option<Value>> {
        let robot = self.finished()?;
        let progress = Progress {
            seed: MEASURED,
            design: robot.design.clone(),
            controller: robot.controller.clone(),
            candidates: Vec::new(),
            ..self.progress.clone()
        };
        let is_enough = Cell::new(false);
        let mut measuring = Measuring {
            rollouts: SelectionSettings::PERTURBED_ROLLOUTS,
            known: std::mem::take(&mut self.measurements),
            is_stopped: &|| is_enough.get(),
            keep: Some(&mut |_: &Measurements| is_enough.set(true)),
        };
        let delivery = self.codesign.deliver_unless(&progress, &mut measuring);
        self.measurements = measuring.known;
        Ok(delivery.map(|delivery| self.measured(&progress, &delivery)))
    }

    /// The measurements of a finished robot for an answer: the distance to quote (`null` if goals are given), whether it
    /// is reliable, and the verdict.
    pub(crate) fn measured(&self, progress: &Progress, delivery: &Delivery) -> Value {
        let (scene, lattice) = (self.codesign.scene(), self.codesign.world().lattice());
        let summary = Summary::new(scene, progress, delivery);
        let verdict = summary.measured(scene, lattice).verdict();
        let has_distance = scene.controller.goals != GoalKind::Given;
        json!({
            "distance": has_distance.then_some(delivery.robust),
            "reliability": delivery.reliability,
            "verdict": verdict.clauses(),
        })
    }

    /// The world in which the robot walks.
    pub(crate) fn world(&self) -> &World {
        let own = self.codesign.world();
        self.elsewhere.as_ref().unwrap_or(own)
    }

    /// Returns the lattice and the world in which the robot walks, for an answer.
    pub(crate) fn view(&self) -> Value {
        view::world(self.world(), self.codesign.scene().schedule.iterations)
    }

    /// The finished robot with its edits.
    pub(crate) fn finished(&self) -> cosmic::Result<&PageRobot> {
        let robot = self.edited.as_ref().or(self.delivered.as_ref());
        robot.ok_or_else(nothing)
    }

    /// Returns a world where some settings of the physics are others. Duration and time step stay.
    pub(crate) fn world_with(&self, settings: &[String]) -> cosmic::Result<World> {
        let (own, scene) = (self.codesign.world(), self.codesign.scene());
        let physics = PhysicsSettings {
            steps: own.physics().steps,
            dt: own.physics().dt,
            ..scene.set(settings)?.physics
        };
        Ok(own.with_physics(&physics, &scene.controller))
    }

    /// Returns the robot that was shown last, the steps on its clock in a frame of its walk, and its state there.
    pub(crate) fn moment(&self, frame: usize) -> cosmic::Result<(PageRobot, usize, State<f64>)> {
        let refused = |says: String| Err(Error::Usage(says));
        let Some(walk) = &self.walk else {
            return refused("the walk of the robot diverges, so it cannot go on".to_owned());
        };
        let Some(start) = walk.frames.get(frame).cloned() else {
            let frames = walk.frames.len();
            return refused(format!("`frame` is {frame}; the walk has {frames} frames"));
        };
        let first = walk.first + frame * view::every(&self.codesign);
        Ok((walk.robot.clone(), first, start))
    }

    /// Returns a robot and its rollout from the state `start`, in which the clock has done `first` steps. The clock ends with
    /// the steps of the scene after the start. `goal` is the robot's goal if goals are given. Also returns the place at the
    /// end, unless the robot diverges.
    pub(crate) fn walk_on(
        &mut self,
        robot: PageRobot,
        first: usize,
        start: &State<f64>,
        goal: Option<Vector<f64>>,
    ) -> (Value, Option<Vector<f64>>) {
        let mut physics = self.world().physics().clone();
        physics.steps += first;
        let world = (self.world()).with_physics(&physics, &self.codesign.scene().controller);
        let span = Span {
            first,
            ..Span::from_start(self.steps())
        };
        let seen = rollout(&world, &robot, start, goal, &span);
        let end = seen.as_ref().ok();
        let end = end.map(|seen| seen.position(seen.last_step()));
        (self.answer(&robot, first, seen), end)
    }

    /// Returns the robot after the last iteration and its rollout, in the precision in which gradients are computed.
    pub(crate) fn present(&mut self) -> Value {
        self.elsewhere = None;
        let robot = PageRobot {
            design: self.progress.design.clone(),
            projected: self.codesign.design(&self.progress),
            controller: self.progress.controller.clone(),
            bytes: None,
        };
        let seen = self.codesign.watch(&self.progress, self.steps());
        self.answer(&robot, 0, seen.ok_or("its walk diverges".to_owned()))
    }

    /// Returns a robot and its rollout in double precision, in the world of the scene.
    pub(crate) fn show(&mut self, robot: &PageRobot) -> Value {
        self.elsewhere = None;
        self.measurements = Measurements::default();
        let world = self.codesign.world();
        let (start, span) = (
            world.lattice().state_at_rest(),
            Span::from_start(self.steps()),
        );
        let seen = rollout(world, robot, &start, None, &span);
        self.answer(robot, 0, seen)
    }

    /// Returns a robot and its rollout from the state `start` to a goal. `along` and `across` (m) count from the payload at the
    /// start of the first walk; a planar robot ignores `across`. The clock has done `first` steps in the state `start`.
    pub(crate) fn go_on(
        &mut self,
        robot: PageRobot,
        first: usize,
        start: &State<f64>,
        [along, across]: [f64; 2],
    ) -> Value {
        let (lattice, ground) = (self.world().lattice(), self.world().ground());
        let (rest, dimension) = (lattice.state_at_rest(), lattice.dimension);
        let way = dimension.onto(Vector::new([along, across, 0.0]));
        let goal = lattice.payload_point(&rest, &ground) + way;
        let (robot, end) = self.walk_on(robot, first, start, Some(goal));
        let off = |end| goal - ground.vector_to_ground(end);
        let left = end.map(|end| dimension.norm_along(off(end)));
        json!({ "robot": robot, "left": left })
    }

    /// Returns the steps whose states are needed: those that are drawn, and the last one for the displacement.
    pub(crate) fn steps(&self) -> Vec<usize> {
        let last = self.codesign.scene().physics.steps;
        let mut steps = view::drawn_steps(&self.codesign);
        if steps.last() != Some(&last) {
            steps.push(last);
        }
        steps
    }

    /// Returns the data of a robot for an answer: its design, and its rollout or the reason why there is none. Keeps the
    /// rollout, so that the robot can walk on. It began after `first` steps of the clock.
    pub(crate) fn answer(
        &mut self,
        robot: &PageRobot,
        first: usize,
        seen: Result<Trajectory<f64>, String>,
    ) -> Value {
        let ground = self.world().ground();
        let thousandths = |share: f64| (1e3 * share).round() as i64;
        let mixtures = robot.projected.mixtures();
        let mixtures = mixtures.iter().map(|mixture| mixture.0.map(thousandths));
        self.walk = seen.as_ref().ok().map(|seen| Walk {
            robot: robot.clone(),
            first,
            frames: seen.states[..view::drawn_steps(&self.codesign).len()].to_vec(),
        });
        json!({
            "materials": robot.projected.materials(),
            "mixtures": mixtures.collect::<Vec<_>>(),
            "walk": seen.as_ref().ok().map(|seen| view::walk(&self.codesign, seen)),
            "along": seen.as_ref().ok().map(|seen| along(seen, &ground)),
            "diverged": seen.err(),
        })
    }
}

/// How far the payload gets in a rollout, m along the ground.
pub(crate) fn along(seen: &Trajectory<f64>, ground: &Ground) -> f64 {
    let from = seen.states[0].x[seen.marker.payload];
    ground.along(seen.position(seen.last_step())) - ground.along(from)
}

/// Returns the nodes that have a solid bar; all nodes if there is no solid bar.
pub(crate) fn solid_nodes(robot: &PageRobot, world: &World) -> Vec<usize> {
    let materials = robot.projected.materials();
    let bars = world.lattice().edges.iter().zip(&materials);
    let solid = bars.filter(|(_, material)| material.is_solid());
    let nodes: Vec<usize> = solid.flat_map(|(edge, _)| *edge).collect();
    if nodes.is_empty() {
        return (0..world.lattice().positions.len()).collect();
    }
    nodes
}

/// Returns the height of the lowest of these nodes above the terrain, in metres.
pub(crate) fn clearance(state: &State<f64>, nodes: &[usize], world: &World) -> f64 {
    let (ground, profile) = (world.ground(), world.physics().ground.resolved());
    let above = |x: Vector<f64>| x.up() - profile.height_in_world(&ground, x.forward());
    let heights = nodes.iter().map(|&node| above(state.x[node]));
    heights.fold(f64::INFINITY, f64::min)
}

/// Simulates a robot and checks every state. Returns its states, or the reason why it diverged.
fn rollout(
    world: &World,
    robot: &PageRobot,
    start: &State<f64>,
    goal: Option<Vector<f64>>,
    span: &Span,
) -> Result<Trajectory<f64>, String> {
    let mut walker = world.robot(
        world.body(&robot.projected),
        robot.controller.clone(),
        start,
    );
    if let Some(goal) = goal {
        walker = walker.with_goals(Goals::at(goal));
    }
    let guarded = walk::guarded(world, &walker, span);
    match &guarded.divergence {
        None => Ok(guarded.trajectory),
        Some(divergence) => Err(Error::from(divergence).to_string()),
    }
}
