//! An optimisation in progress, and the robot that came of it.

use crate::view;
use cosmic::codesign::{CoDesign, Delivery, Progress};
use cosmic::controller::Controller;
use cosmic::design::{Material, Structure, one_hot};
use cosmic::error::{Error, Result};
use cosmic::record::DesignFile;
use cosmic::scene::Scene;
use cosmic::simulator::Span;
use serde_json::{Value, json};

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
    /// The robot of the last answer, after the last iteration.
    finished: Option<Robot>,
}

struct Robot {
    z: Vec<[f64; 3]>,
    materials: Vec<Material>,
    controller: Controller<f64>,
}

impl Session {
    /// Begins with a scene, and answers with what there is to draw of the robot before the first iteration.
    pub(crate) fn begin(&mut self, scene: &Scene, seed: u64) -> Result<Value> {
        let codesign = CoDesign::new(scene)?;
        let progress = codesign.begin(seed)?;
        let begun = Work {
            codesign,
            progress,
            finished: None,
        };
        let first = begun.present(&mut self.numbers);
        let answer = json!({ "world": view::world(&begun.codesign), "first": first });
        self.work = Some(begun);
        Ok(answer)
    }

    /// One iteration; with the rollout of the robot after it if `shown`.
    pub(crate) fn iterate(&mut self, shown: bool) -> Result<Value> {
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
    pub(crate) fn deliver(&mut self) -> Result<Value> {
        let Self { work, numbers } = self;
        let work = begun(work)?;
        let delivery = work.codesign.deliver(&work.progress);
        let (spread, along) = (delivery.spread, delivery.along);
        let iteration = delivery.iteration;
        let Delivery {
            z,
            materials,
            controller,
            volumes,
            displacement,
            ..
        } = delivery;
        let mixture = work.codesign.mixture(&work.progress);
        let robot = Robot {
            z,
            materials,
            controller,
        };
        let shown = work.show(&mixture, &robot, numbers);
        work.finished = Some(robot);
        Ok(json!({
            "spread": spread,
            "along": along,
            "displacement": displacement,
            "volumes": volumes,
            "iteration": iteration,
            "robot": shown,
        }))
    }

    /// Gives the delivered robot other materials.
    pub(crate) fn edit(&mut self, materials: Vec<Material>) -> Result<Value> {
        let Self { work, numbers } = self;
        let work = begun(work)?;
        let edges = work.codesign.task().lattice.edges.len();
        if materials.len() != edges {
            let found = materials.len();
            return Err(Error::Usage(format!(
                "expected {edges} materials, found {found}"
            )));
        }
        let mut robot = work.finished.take().ok_or_else(nothing)?;
        robot.z = one_hot(&materials);
        robot.materials = materials;
        let shown = work.show(&robot.z, &robot, numbers);
        work.finished = Some(robot);
        Ok(json!({ "robot": shown }))
    }

    /// The text of `design.json` for the robot that was delivered, as edited.
    pub(crate) fn design(&mut self) -> Result<Value> {
        let work = begun(&mut self.work)?;
        let robot = work.finished.as_ref().ok_or_else(nothing)?;
        let lattice = &work.codesign.task().lattice;
        let file = DesignFile::new(lattice, &robot.z, &robot.materials, &robot.controller);
        Ok(file.to_json().into())
    }
}

fn begun(work: &mut Option<Work>) -> Result<&mut Work> {
    work.as_mut().ok_or_else(nothing)
}

fn nothing() -> Error {
    Error::Usage("no robot is there yet".to_owned())
}

impl Work {
    /// The robot as it is now.
    fn present(&self, numbers: &mut Vec<f32>) -> Value {
        let mixture = self.codesign.mixture(&self.progress);
        let robot = Robot {
            z: Vec::new(),
            materials: self.codesign.materials(&self.progress),
            controller: self.progress.controller.clone(),
        };
        self.show(&mixture, &robot, numbers)
    }

    /// Rolls a robot out. Mixtures and positions go to the numbers.
    fn show(&self, mixture: &[[f64; 3]], robot: &Robot, numbers: &mut Vec<f32>) -> Value {
        let task = self.codesign.task();
        let start = task.lattice.state_at_rest();
        let last = self.codesign.scene().physics.steps;
        let mut steps = view::drawn_steps(&self.codesign);
        let frames = steps.len();
        if steps.last() != Some(&last) {
            steps.push(last);
        }
        let span = Span::from_start(steps);
        let guarded = task.guarded(mixture, &robot.controller, &start, &span);
        let mut trajectory = guarded.trajectory;
        let end = trajectory.at(last).x[0];
        let moved = [0, 1].map(|k| end[k] - start.x[0][k]);
        trajectory.states.truncate(frames);
        numbers.clear();
        numbers.extend(mixture.as_flattened().iter().map(|&share| share as f32));
        numbers.extend(view::positions(&trajectory));
        let along = task.ground().vector_to_ground(moved)[0];
        let diverged = guarded.divergence.as_ref();
        json!({
            "materials": robot.materials,
            "along": diverged.is_none().then_some(along),
            "diverged": diverged.map(|divergence| Error::from(divergence).to_string()),
            "structure": Structure::new(&task.lattice, &robot.materials),
        })
    }
}
