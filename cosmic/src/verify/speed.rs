//! What a step costs on this machine, in processor time of one thread.

use std::hint::black_box;
use std::time::Duration;

use autodiff::{Memory, Model, Program, Real, Rollout};
use cpu_time::ThreadTime;

use super::probe::Probe;
use crate::case::Case;
use crate::controller::Controller;
use crate::gradient::{CONTROLLER, DESIGN, Horizon, Inputs, Task};
use crate::lattice::State;
use crate::objective::{Displacement, Loss};
use crate::scene::{HorizonMode, LossSettings};
use crate::simulator::Span;

/// Steps of a measured rollout, where the case has as many.
pub const MEASURED_STEPS: usize = 4096;
/// Times that each measurement is taken; the least counts, as the one least disturbed.
const REPEATS: usize = 25;
/// Starts that are run together.
const STARTS: usize = 8;
/// How far they are moved apart, m.
const MOVED: f64 = 1e-9;

/// Microseconds per step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speed {
    /// Steps of the measured rollouts.
    pub steps: usize,
    /// A plain rollout in f64, with its loss.
    pub rollout: f64,
    /// The loss and its gradient by the design vectors.
    pub value_and_design_gradient: f64,
    /// The loss and its gradient by the controller's weights.
    pub value_and_controller_gradient: f64,
    /// The yardstick: nothing but the controller's two matrices times vectors.
    pub two_matvecs: f64,
    /// Per step and evaluation: a plain rollout, one of eight from starts of their own that run
    /// together.
    pub eight_starts: f64,
    /// The mean loss of the eight and its gradient by the design vectors, per step and evaluation.
    pub eight_starts_and_design_gradient: f64,
    /// That by the controller's weights, per step and evaluation.
    pub eight_starts_and_controller_gradient: f64,
}

/// Measures a case with a loss. What is done at once, the plan of the rollout and its sine table,
/// is left out.
pub fn measure(case: &Case, loss: &LossSettings) -> Speed {
    let subject = Subject::new(case, loss);
    let steps = subject.steps();
    let matvecs = TwoMatvecs::new(case);
    let mut least = [Duration::MAX; 7];
    for _ in 0..REPEATS {
        // In turns: what disturbs the machine disturbs all of them.
        let times = [
            timed(|| subject.rollout()),
            timed(|| subject.gradient(DESIGN)),
            timed(|| subject.gradient(CONTROLLER)),
            timed(|| matvecs.run(steps)),
            timed(|| subject.rollouts()),
            timed(|| subject.mean_gradient(DESIGN)),
            timed(|| subject.mean_gradient(CONTROLLER)),
        ];
        for (least, time) in least.iter_mut().zip(times) {
            *least = time.min(*least);
        }
    }
    let least = least.map(|time| time.as_secs_f64() * 1e6 / steps as f64);
    let [rollout, design, controller, two_matvecs, eight @ ..] = least;
    let [eight_starts, eight_design, eight_controller] = eight.map(|time| time / STARTS as f64);
    Speed {
        steps,
        rollout,
        value_and_design_gradient: design,
        value_and_controller_gradient: controller,
        two_matvecs,
        eight_starts,
        eight_starts_and_design_gradient: eight_design,
        eight_starts_and_controller_gradient: eight_controller,
    }
}

pub(super) fn timed<T>(work: impl FnOnce() -> T) -> Duration {
    let start = ThreadTime::now();
    black_box(work());
    start.elapsed()
}

/// The most memory that this process has held so far, in bytes, where the system says.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}

/// What is measured: the rollout of a case, and its gradients.
pub struct Subject<'a> {
    case: &'a Case,
    task: Task,
    inputs: Inputs<f64>,
    /// Starts near the case's own.
    starts: Vec<State<f64>>,
    loss: Displacement,
    horizon: Horizon,
}

impl<'a> Subject<'a> {
    /// Plans rollouts of a case: [`MEASURED_STEPS`] steps, or as many as it has.
    pub fn new(case: &'a Case, loss: &LossSettings) -> Self {
        let task = case.task();
        Self {
            case,
            inputs: case.inputs(),
            starts: Probe::new(case).moved_starts(STARTS, MOVED),
            loss: Displacement {
                ground: task.ground(),
                settings: loss.clone(),
            },
            horizon: Horizon {
                steps: MEASURED_STEPS.min(case.physics.steps).max(1),
                mode: HorizonMode::Head,
                cotangent_bound: None,
            },
            task,
        }
    }

    /// Steps of a rollout.
    pub fn steps(&self) -> usize {
        self.horizon.steps
    }

    /// A plain rollout: its loss.
    pub fn rollout(&self) -> f64 {
        let mixture = self.case.mixture(self.case.projection, &self.inputs.z);
        let span = Span::from_start(self.loss.observed(self.horizon.steps));
        let robot = (&self.inputs.controller, &self.inputs.start);
        self.loss.loss(&self.task.rollout(&mixture, robot, &span))
    }

    /// Eight plain rollouts from other starts: their mean loss.
    pub fn rollouts(&self) -> f64 {
        let mixture = self.case.mixture(self.case.projection, &self.inputs.z);
        self.mean_loss(&mixture, &self.inputs.controller)
    }

    /// The loss and its gradient by some blocks of the inputs, such as
    /// [`DESIGN`] or [`CONTROLLER`]. The design vectors of a frozen layout are its mixture.
    pub fn gradient(&self, blocks: [bool; 7]) -> (f64, Vec<f64>) {
        self.inputs.differentiate(blocks, |inputs| {
            let robot = (&inputs.controller, &inputs.start);
            let task = (&self.loss, &self.horizon);
            self.task.loss(&self.mixture(inputs), robot, task).0
        })
    }

    /// The same for the mean loss of eight rollouts from other starts.
    pub fn mean_gradient(&self, blocks: [bool; 7]) -> (f64, Vec<f64>) {
        self.inputs.differentiate(blocks, |inputs| {
            self.mean_loss(&self.mixture(inputs), &inputs.controller)
        })
    }

    fn mixture<R: Real>(&self, inputs: &Inputs<R>) -> Vec<[R; 3]> {
        match self.case.frozen {
            Some(_) => inputs.z.clone(),
            None => self.case.mixture(self.case.projection, &inputs.z),
        }
    }

    fn mean_loss<R: Real>(&self, mixture: &[[R; 3]], controller: &Controller<R>) -> R {
        let span = Span::from_start(self.loss.observed(self.horizon.steps));
        let starts: Vec<State<R>> = self.starts.iter().map(|start| start.map(R::lit)).collect();
        let starts: Vec<&State<R>> = starts.iter().collect();
        let all = self
            .task
            .rollout_many(mixture, (controller, &starts), &span);
        let losses: Vec<R> = all.iter().map(|seen| self.loss.loss(seen)).collect();
        R::sum(&losses) * R::lit(1.0 / STARTS as f64)
    }
}

/// `W2 (W1 x)`, of the shapes that a controller runs with: all positions and velocities to
/// hidden units to edges.
#[derive(Clone, Copy, Debug)]
pub struct TwoMatvecs {
    inputs: usize,
    hidden: usize,
    edges: usize,
}

impl TwoMatvecs {
    /// Of the shapes of a case.
    pub fn new(case: &Case) -> Self {
        Self {
            inputs: 4 * case.lattice.nodes(),
            hidden: case.controller.hidden,
            edges: case.lattice.edges.len(),
        }
    }

    /// Computes them so many times; returns the vector that was put in.
    pub fn run(self, steps: usize) -> Vec<f64> {
        let Self {
            inputs,
            hidden,
            edges,
        } = self;
        let rollout = Rollout {
            model: self,
            steps,
            inputs: [].into(),
            observed: vec![steps],
            cotangent_bound: None,
            memory: Memory::All,
        };
        let numbers = |count: usize| vec![0.1; count];
        let parameters = [hidden * inputs, hidden, edges * hidden, edges].map(numbers);
        rollout.run(&numbers(inputs), &parameters.each_ref().map(Vec::as_slice))
    }
}

impl Model for TwoMatvecs {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (w1, b1) = (p.matrix(self.hidden, self.inputs), p.parameter(self.hidden));
        let (w2, b2) = (p.matrix(self.edges, self.hidden), p.parameter(self.edges));
        let x = p.state(self.inputs);
        let hidden = p.dense(w1, &[x], b1);
        p.dense(w2, &[hidden], b2);
        p.advance(x, x);
    }
}

#[cfg(test)]
mod tests {
    use super::{measure, peak_memory};
    use crate::case::Case;
    use crate::scene::Scene;

    #[test]
    fn every_figure_is_a_time() {
        let mut scene = Scene::default();
        (scene.lattice.columns, scene.lattice.rows) = (2, 2);
        scene.physics.steps = 64;
        let case = Case::of_scene(&scene, 0).unwrap();
        let speed = measure(&case, &scene.loss);
        assert_eq!(speed.steps, 64);
        let least = speed.rollout.min(speed.two_matvecs);
        assert!(least > 0.0 && speed.value_and_design_gradient > speed.rollout);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn memory_is_known_on_linux() {
        assert!(peak_memory().unwrap() > 1 << 16);
    }
}
