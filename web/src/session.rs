//! An optimisation in progress, and the robot that came of it.

use crate::view;
use cosmic::codesign::{CoDesign, Delivery, Progress};
use cosmic::design::{Design, Material, Mixture};
use cosmic::error::Error;
use cosmic::policy::Controller;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use cosmic::simulator::{Span, Trajectory};
use serde_json::{Value, json};

type Answer = cosmic::Result<Value>;

/// All that the page works on.
#[derive(Default)]
pub(crate) struct Session {
    work: Option<Work>,
    /// The numbers of the last answer: the mixtures of all edges, then the positions of a rollout.
    pub(crate) numbers: Vec<f32>,
}

struct Work {
    codesign: CoDesign,
    progress: Progress,
    /// The robot that was delivered, after the last iteration.
    delivered: Option<Robot>,
    /// That robot with other materials.
    edited: Option<Robot>,
}

#[derive(Clone)]
struct Robot {
    design: Design<[f64; 3]>,
    /// The design with the mixtures that are simulated.
    projected: Design<Mixture<f64>>,
    controller: Controller<f64>,
}

impl Session {
    /// Begins with a scene, and answers with what there is to draw of the robot before the first iteration.
    pub(crate) fn begin(&mut self, scene: &Scene, seed: u64) -> Answer {
        let codesign = CoDesign::new(scene)?;
        let progress = codesign.begin(seed)?;
        let begun = Work {
            codesign,
            progress,
            delivered: None,
            edited: None,
        };
        let first = begun.present(&mut self.numbers);
        let answer = json!({ "world": view::world(&begun.codesign), "first": first });
        self.work = Some(begun);
        Ok(answer)
    }

    /// One iteration; with the rollout of the robot after it if `shown`.
    pub(crate) fn iterate(&mut self, shown: bool) -> Answer {
        let Self { work, numbers } = self;
        let work = begun(work)?;
        let record = work.codesign.iterate(&mut work.progress);
        let check = work.codesign.step_check(&work.progress);
        check.accept(&work.codesign.scene().physics)?;
        let robot = if shown {
            work.present(numbers)
        } else {
            Value::Null
        };
        let done = work.codesign.is_done(&work.progress);
        Ok(json!({ "record": record, "robot": robot, "done": done }))
    }

    /// Chooses the robot to deliver and measures it.
    pub(crate) fn deliver(&mut self) -> Answer {
        let Self { work, numbers } = self;
        let work = begun(work)?;
        let Delivery {
            design,
            controller,
            iteration,
            spread,
            reliability,
            volume,
            actuator_volume,
            ..
        } = work.codesign.evaluator().deliver(&work.progress);
        let robot = Robot {
            design,
            projected: work.codesign.evaluator().design(&work.progress),
            controller,
        };
        let shown = work.show(&robot, numbers);
        work.delivered = Some(robot);
        work.edited = None;
        Ok(json!({
            "spread": spread,
            "reliability": reliability,
            "volumes": [volume, actuator_volume],
            "iteration": iteration,
            "robot": shown,
        }))
    }

    /// Gives the delivered robot other materials, or its own again.
    pub(crate) fn edit(&mut self, materials: Option<Vec<Material>>) -> Answer {
        let Self { work, numbers } = self;
        let work = begun(work)?;
        let mut robot = work.delivered.clone().ok_or_else(nothing)?;
        let Some(materials) = materials else {
            work.edited = None;
            return Ok(json!({ "robot": work.show(&robot, numbers) }));
        };
        let (found, edges) = (materials.len(), robot.design.edges());
        if found != edges {
            let says = format!("expected {edges} materials, found {found}");
            return Err(Error::Usage(says));
        }
        robot.design = Design::Layout(materials.clone());
        robot.projected = Design::Layout(materials);
        let shown = work.show(&robot, numbers);
        work.edited = Some(robot);
        Ok(json!({ "robot": shown }))
    }

    /// The text of `design.json` for the robot that was delivered, as edited.
    pub(crate) fn design(&mut self) -> Answer {
        let work = begun(&mut self.work)?;
        let robot = work.edited.as_ref().or(work.delivered.as_ref());
        let robot = robot.ok_or_else(nothing)?;
        let lattice = &work.codesign.task().lattice;
        let file = DesignFile::new(
            lattice,
            &robot.design,
            &robot.projected.materials(),
            &robot.controller,
        );
        Ok(file.to_json().into())
    }
}

fn begun(work: &mut Option<Work>) -> cosmic::Result<&mut Work> {
    work.as_mut().ok_or_else(nothing)
}

fn nothing() -> Error {
    Error::Usage("no robot is there yet".to_owned())
}

impl Work {
    /// The robot as it is now, rolled out in the precision of gradients.
    fn present(&self, numbers: &mut Vec<f32>) -> Value {
        let robot = Robot {
            design: self.progress.design.clone(),
            projected: self.codesign.evaluator().design(&self.progress),
            controller: self.progress.controller.clone(),
        };
        let seen = self.codesign.evaluator().watch(&self.progress, self.steps());
        self.answer(&robot, seen.ok_or("its walk diverges".to_owned()), numbers)
    }

    /// A robot, rolled out in double precision.
    fn show(&self, robot: &Robot, numbers: &mut Vec<f32>) -> Value {
        let task = self.codesign.task();
        let (start, span) = (task.lattice.state_at_rest(), Span::from_start(self.steps()));
        let guarded = task.guarded(&robot.projected, &robot.controller, &start, &span);
        let seen = match &guarded.divergence {
            None => Ok(guarded.trajectory),
            Some(divergence) => Err(Error::from(divergence).to_string()),
        };
        self.answer(robot, seen, numbers)
    }

    /// The steps that are drawn, and the last one, which says how far the robot got.
    fn steps(&self) -> Vec<usize> {
        let last = self.codesign.scene().physics.steps;
        let mut steps = view::drawn_steps(&self.codesign);
        if steps.last() != Some(&last) {
            steps.push(last);
        }
        steps
    }

    /// Mixtures and positions go to the numbers; of a rollout that diverges those at rest.
    fn answer(
        &self,
        robot: &Robot,
        seen: Result<Trajectory<f64>, String>,
        numbers: &mut Vec<f32>,
    ) -> Value {
        let task = self.codesign.task();
        numbers.clear();
        let mixtures = robot.projected.mixtures();
        numbers.extend(
            mixtures
                .iter()
                .flat_map(|mixture| mixture.0.map(|share| share as f32)),
        );
        let along = match &seen {
            Ok(trajectory) => {
                let drawn = view::drawn_steps(&self.codesign).len();
                numbers.extend(view::positions(&trajectory.states[..drawn]));
                let ends = [&trajectory.states[0], trajectory.at(trajectory.last_step())];
                let [from, to] = ends.map(|state| task.ground().along(state.x[0]));
                Some(to - from)
            }
            Err(_) => {
                numbers.extend(view::positions(&[task.lattice.state_at_rest()]));
                None
            }
        };
        json!({
            "materials": robot.projected.materials(),
            "along": along,
            "diverged": seen.err(),
        })
    }
}
