//! An optimisation in progress, and the robot that it delivers.

use crate::{packed, view};
use cosmic::codesign::{CoDesign, Delivery, Progress};
use cosmic::design::{Design, Material, Mixture};
use cosmic::error::Error;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::policy::{Controller, Goals};
use cosmic::record::DesignFile;
use cosmic::scene::{GoalKind, PhysicsSettings, Scene};
use cosmic::simulator::{Simulator, Span, Trajectory};
use cosmic::task::Task;
use cosmic::verdict::Measured;
use serde_json::{Value, json};

type Answer = cosmic::Result<Value>;

/// The state that the library keeps between the requests of the page: the optimisation, once it has begun.
#[derive(Default)]
pub(crate) struct Session(Option<Work>);

struct Work {
    codesign: CoDesign,
    progress: Progress,
    /// The robot that the optimisation has delivered; `None` before its end.
    delivered: Option<Robot>,
    /// The delivered robot with the materials that the user has edited, if any.
    edited: Option<Robot>,
    /// The world in which the user lets the finished robot walk on; `None` in the world of the scene.
    elsewhere: Option<Task>,
    /// The walk that was shown last; `None` if it diverged.
    walk: Option<Walk>,
}

/// A walk that can go on from any of its frames.
struct Walk {
    robot: Robot,
    /// The number of steps on the clock at the start of the walk.
    first: usize,
    /// The states in the frames.
    frames: Vec<State<f64>>,
}

#[derive(Clone)]
struct Robot {
    design: Design<[f64; 3]>,
    /// The design after the projection. It contains the mixtures that are simulated.
    projected: Design<Mixture<f64>>,
    controller: Controller<f64>,
}

impl Session {
    /// Begins a design in a scene. Returns the world and the robot before the first iteration.
    pub(crate) fn begin(&mut self, scene: &Scene, seed: u64) -> Answer {
        let codesign = CoDesign::new(scene)?;
        let progress = codesign.begin(seed)?;
        let mut begun = Work::of(codesign, progress);
        let first = begun.present();
        let answer = json!({ "world": begun.world(), "first": first });
        self.0 = Some(begun);
        Ok(answer)
    }

    /// Does one iteration. If `shown`, the answer includes the robot with its rollout.
    pub(crate) fn iterate(&mut self, shown: bool) -> Answer {
        let work = self.work()?;
        let record = work.codesign.iterate(&mut work.progress);
        let check = work.codesign.step_check(&work.progress);
        check.accept(&work.codesign.scene().physics)?;
        let robot = if shown { work.present() } else { Value::Null };
        let done = work.codesign.is_done(&work.progress);
        Ok(json!({ "record": record, "robot": robot, "done": done }))
    }

    /// Chooses the robot to deliver and measures it.
    pub(crate) fn deliver(&mut self) -> Answer {
        let work = self.work()?;
        let delivery = work.codesign.evaluator().deliver(&work.progress);
        let (scene, lattice) = (work.codesign.scene(), &work.codesign.task().lattice);
        let verdict = Measured::of_delivery(&delivery, scene, lattice).verdict();
        let Delivery {
            design,
            controller,
            iteration,
            spread,
            reliability,
            volume,
            actuator_volume,
            ..
        } = delivery;
        let robot = Robot {
            design,
            projected: work.codesign.evaluator().design(&work.progress),
            controller,
        };
        let shown = work.show(&robot);
        work.delivered = Some(robot);
        work.edited = None;
        Ok(json!({
            "spread": spread,
            "reliability": reliability,
            "verdict": verdict.clauses(),
            "volumes": [volume, actuator_volume],
            "iteration": iteration,
            "robot": shown,
        }))
    }

    /// Gives the delivered robot other materials. `None` restores those of the design.
    pub(crate) fn edit(&mut self, materials: Option<Vec<Material>>) -> Answer {
        let work = self.work()?;
        let mut robot = work.delivered.clone().ok_or_else(nothing)?;
        let Some(materials) = materials else {
            work.edited = None;
            return Ok(json!({ "robot": work.show(&robot) }));
        };
        let (found, edges) = (materials.len(), robot.design.edges());
        if found != edges {
            let says = format!("expected {edges} materials, found {found}");
            return Err(Error::Usage(says));
        }
        robot.design = Design::Layout(materials.clone());
        robot.projected = Design::Layout(materials);
        let shown = work.show(&robot);
        work.edited = Some(robot);
        Ok(json!({ "robot": shown }))
    }

    /// Lets the robot that was shown last walk on to a goal, from a frame of its walk. Its clock goes on, too. `along` is
    /// the place of the goal along the ground (m), counted from the payload at the start.
    pub(crate) fn tell(&mut self, along: f64, frame: usize) -> Answer {
        let work = self.work()?;
        if work.codesign.scene().controller.goals != GoalKind::Given {
            let says = "only robots with given goals can be told where to go: the scene needs `controller.goals = \"given\"`";
            return Err(Error::Usage(says.to_owned()));
        }
        let (robot, first, start) = work.moment(frame)?;
        Ok(work.go_on(robot, first, &start, along))
    }

    /// Lets the robot that was shown last walk on from a frame of its walk, after a push. `velocity` is added to the
    /// velocity of every node, m/s.
    pub(crate) fn push(&mut self, velocity: [f64; 2], frame: usize) -> Answer {
        let work = self.work()?;
        let (robot, first, mut start) = work.moment(frame)?;
        for v in &mut start.v {
            *v += Vector::new(velocity);
        }
        let task = work.later(first);
        Ok(json!({ "robot": work.walk_on(robot, first, &start, &task).0 }))
    }

    /// Lets the robot that was shown last walk on from a frame of its walk in a world where some settings of the physics
    /// are others, such as gravity and ground. Later goals and pushes happen in that world.
    pub(crate) fn visit(&mut self, settings: &[String], frame: usize) -> Answer {
        let work = self.work()?;
        let (robot, first, mut start) = work.moment(frame)?;
        let there = work.task_with(settings)?;
        let solid = solid_nodes(&robot, &there);
        let lift = clearance(&start, &solid, work.task()) - clearance(&start, &solid, &there);
        for x in &mut start.x {
            *x += Vector::upright(0.0, lift);
        }
        work.elsewhere = Some(there);
        let task = work.later(first);
        let shown = work.walk_on(robot, first, &start, &task).0;
        Ok(json!({ "world": work.world(), "robot": shown }))
    }

    /// Judges the finished robot with its edits, from one walk in the world of the scene.
    pub(crate) fn judge(&mut self) -> Answer {
        let work = self.work()?;
        let robot = work.finished()?;
        let evaluator = work.codesign.evaluator();
        let seen = evaluator.observe(&robot.projected, &robot.controller);
        let (scene, lattice) = (work.codesign.scene(), &work.codesign.task().lattice);
        let measured = Measured::of_rollout(&seen, scene, lattice, evaluator.is_far());
        Ok(json!({ "verdict": measured.verdict().clauses() }))
    }

    /// Packs the robot that was delivered, with its edits, into bytes for a link.
    pub(crate) fn share(&mut self) -> Answer {
        let work = self.work()?;
        let robot = work.finished()?;
        let task = work.codesign.task();
        let bytes = packed::pack(
            &work.codesign.scene().controller,
            &task.lattice,
            &task.ground(),
            &robot.projected.materials(),
            &robot.controller,
        )?;
        Ok(json!({ "bytes": bytes }))
    }

    /// Opens a packed robot of a scene. Returns the world, and the robot with its walk.
    pub(crate) fn open(&mut self, scene: Scene, bytes: &[u8]) -> Answer {
        let codesign = CoDesign::new(&packed::scene_of(scene, bytes)?)?;
        let settings = &codesign.scene().controller;
        let (materials, controller) = packed::unpack(settings, &codesign.task().lattice, bytes)?;
        let progress = codesign.begin(0)?;
        let mut begun = Work::of(codesign, progress);
        let robot = Robot {
            design: Design::Layout(materials.clone()),
            projected: Design::Layout(materials),
            controller,
        };
        let shown = begun.show(&robot);
        begun.delivered = Some(robot);
        let answer = json!({ "world": begun.world(), "robot": shown });
        self.0 = Some(begun);
        Ok(answer)
    }

    /// Returns the text of `design.json` for the delivered robot, including edits.
    pub(crate) fn design(&mut self) -> Answer {
        let work = self.work()?;
        let robot = work.finished()?;
        let lattice = &work.codesign.task().lattice;
        let file = DesignFile::new(
            lattice,
            &robot.design,
            &robot.projected.materials(),
            &robot.controller,
        );
        Ok(file.to_json().into())
    }

    fn work(&mut self) -> cosmic::Result<&mut Work> {
        self.0.as_mut().ok_or_else(nothing)
    }
}

fn nothing() -> Error {
    Error::Usage("there is no robot yet; send the request `begin` first".to_owned())
}

impl Work {
    /// A design in progress, before a robot has been shown.
    fn of(codesign: CoDesign, progress: Progress) -> Self {
        Self {
            codesign,
            progress,
            delivered: None,
            edited: None,
            elsewhere: None,
            walk: None,
        }
    }

    /// The task in the world in which the robot walks.
    fn task(&self) -> &Task {
        let own = self.codesign.task();
        self.elsewhere.as_ref().unwrap_or(own)
    }

    /// Returns the lattice and the world in which the robot walks, for an answer.
    fn world(&self) -> Value {
        view::world(self.task(), self.codesign.scene().schedule.iterations)
    }

    /// The finished robot with its edits.
    fn finished(&self) -> cosmic::Result<&Robot> {
        let robot = self.edited.as_ref().or(self.delivered.as_ref());
        robot.ok_or_else(nothing)
    }

    /// Returns the task in a world where some settings of the physics are others. Duration and time step stay.
    fn task_with(&self, settings: &[String]) -> cosmic::Result<Task> {
        let (own, scene) = (self.codesign.task(), self.codesign.scene());
        let physics = PhysicsSettings {
            steps: own.physics.steps,
            dt: own.physics.dt,
            ..scene.clone().set(settings)?.physics
        };
        let task = Task::new(
            own.lattice.clone(),
            &physics,
            &scene.controller,
            &own.materials,
            &own.sharpness,
        );
        Ok(task
            .with_one_piece(scene.design.one_piece)
            .with_moved(scene.objective.body))
    }

    /// Returns the robot that was shown last, the steps on its clock in a frame of its walk, and its state there.
    fn moment(&self, frame: usize) -> cosmic::Result<(Robot, usize, State<f64>)> {
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

    /// Returns the task with a clock that ends with the steps of the scene, but begins after `first` steps.
    fn later(&self, first: usize) -> Task {
        let (scene, mut task) = (self.codesign.scene(), self.task().clone());
        let mut physics = task.physics.clone();
        physics.steps += first;
        task.simulator = Simulator::new(&task.lattice, &physics, &scene.controller);
        task
    }

    /// Returns a robot and its rollout from the state `start`, in which the clock has done `first` steps.
    fn walk_on(
        &mut self,
        robot: Robot,
        first: usize,
        start: &State<f64>,
        task: &Task,
    ) -> (Value, Option<Vector<f64>>) {
        let span = Span {
            first,
            ..Span::from_start(self.steps())
        };
        let seen = rollout(task, &robot, start, &span);
        let end = seen
            .as_ref()
            .ok()
            .map(|seen| seen.position(seen.last_step()));
        (self.answer(&robot, first, seen), end)
    }

    /// Returns the robot after the last iteration and its rollout, in the precision in which gradients are computed.
    fn present(&mut self) -> Value {
        self.elsewhere = None;
        let robot = Robot {
            design: self.progress.design.clone(),
            projected: self.codesign.evaluator().design(&self.progress),
            controller: self.progress.controller.clone(),
        };
        let seen = self
            .codesign
            .evaluator()
            .watch(&self.progress, self.steps());
        self.answer(&robot, 0, seen.ok_or("its walk diverges".to_owned()))
    }

    /// Returns a robot and its rollout in double precision, in the world of the scene.
    fn show(&mut self, robot: &Robot) -> Value {
        self.elsewhere = None;
        let task = self.codesign.task();
        let (start, span) = (task.lattice.state_at_rest(), Span::from_start(self.steps()));
        let seen = rollout(task, robot, &start, &span);
        self.answer(robot, 0, seen)
    }

    /// Returns a robot and its rollout from the state `start` to a goal `along` metres from the payload at the start of the
    /// first walk. The clock has done `first` steps in the state `start`.
    fn go_on(&mut self, robot: Robot, first: usize, start: &State<f64>, along: f64) -> Value {
        let mut task = self.later(first);
        let rest = task.lattice.state_at_rest();
        let ground = task.ground();
        let goal = task.lattice.payload_point(&rest, &ground) + Vector::upright(along, 0.0);
        task.simulator = task.simulator.with_goals(&Goals::at(goal));
        let (robot, end) = self.walk_on(robot, first, start, &task);
        let left = end.map(|end| (goal.forward() - ground.along(end)).abs());
        json!({ "robot": robot, "left": left })
    }

    /// Returns the steps whose states are needed: those that are drawn, and the last one for the displacement.
    fn steps(&self) -> Vec<usize> {
        let last = self.codesign.scene().physics.steps;
        let mut steps = view::drawn_steps(&self.codesign);
        if steps.last() != Some(&last) {
            steps.push(last);
        }
        steps
    }

    /// Returns the data of a robot for an answer: its design, and its rollout or the reason why there is none. Keeps the
    /// rollout, so that the robot can walk on. It began after `first` steps of the clock.
    fn answer(
        &mut self,
        robot: &Robot,
        first: usize,
        seen: Result<Trajectory<f64>, String>,
    ) -> Value {
        let ground = self.task().ground();
        let along = |seen: &Trajectory<f64>| {
            let from = seen.states[0].x[seen.marker.payload];
            ground.along(seen.position(seen.last_step())) - ground.along(from)
        };
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
            "along": seen.as_ref().ok().map(along),
            "diverged": seen.err(),
        })
    }
}

/// Returns the nodes that have a solid bar; all nodes if there is no solid bar.
fn solid_nodes(robot: &Robot, task: &Task) -> Vec<usize> {
    let materials = robot.projected.materials();
    let bars = task.lattice.edges.iter().zip(&materials);
    let solid = bars.filter(|(_, material)| material.is_solid());
    let nodes: Vec<usize> = solid.flat_map(|(edge, _)| *edge).collect();
    if nodes.is_empty() {
        return (0..task.lattice.positions.len()).collect();
    }
    nodes
}

/// Returns the height of the lowest of these nodes above the terrain, in metres.
fn clearance(state: &State<f64>, nodes: &[usize], task: &Task) -> f64 {
    let (ground, profile) = (task.ground(), task.physics.ground.resolved());
    let above = |x: Vector<f64>| x.up() - profile.height_in_world(&ground, x.forward());
    let heights = nodes.iter().map(|&node| above(state.x[node]));
    heights.fold(f64::INFINITY, f64::min)
}

/// Simulates a robot and checks every state. Returns its states, or the reason why it diverged.
fn rollout(
    task: &Task,
    robot: &Robot,
    start: &State<f64>,
    span: &Span,
) -> Result<Trajectory<f64>, String> {
    let guarded = task.guarded(&robot.projected, &robot.controller, start, span);
    match &guarded.divergence {
        None => Ok(guarded.trajectory),
        Some(divergence) => Err(Error::from(divergence).to_string()),
    }
}
