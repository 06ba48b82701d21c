//! The cost of a step on this machine, in processor time of one thread.

use std::hint::black_box;

use autodiff::{CotangentBound, Memory, Model, Program, Real, Rollout};

use super::clock::least_times;
use super::probe::{Probe, relative_error};
use cosmic::case::Case;
use cosmic::design::{Design, LayoutRules, Mixture, VolumeBounds, snap};
use cosmic::inputs::{Block, CONTROLLER, DESIGN, Inputs};
use cosmic::lattice::State;
use cosmic::objective::{Displacement, Loss};
use cosmic::policy::Controller;
use cosmic::projection::Projection;
use cosmic::scene::{GradientSettings, LossSettings, Scene, VolumeSettings};
use cosmic::simulator::Span;
use cosmic::task::Horizon;
use serde::Serialize;

/// Steps of a measured rollout, unless the case has fewer.
pub const MEASURED_STEPS: usize = 4096;
/// Repeats of each measurement; the shortest time counts, because it is the least disturbed one.
const REPEATS: usize = 25;
/// Starts that are run together.
const STARTS: usize = 8;

/// The costs of steps, and the loss of accuracy in f32.
#[derive(Clone, Debug, PartialEq)]
pub struct Speed {
    /// Steps of the measured rollouts.
    pub steps: usize,
    /// The measured works with their times in microseconds per step of one robot.
    pub times: Vec<(String, f64)>,
    /// The errors of gradients in f32 over the scene's first and last horizon.
    pub single_errors: [GradientError; 2],
}

/// The error of a gradient in f32 relative to the length of the gradient in f64. Both have the scene's
/// bound on the cotangent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GradientError {
    /// Steps of the horizon.
    pub steps: usize,
    /// By the design vectors.
    pub design: f64,
    /// By the controller's weights.
    pub controller: f64,
}

impl Speed {
    /// The time of a work in microseconds per step of one robot.
    ///
    /// # Panics
    /// If no work has this name.
    pub fn time(&self, work: &str) -> f64 {
        let found = self.times.iter().find(|(name, _)| name == work);
        found
            .unwrap_or_else(|| panic!("no work is called {work}"))
            .1
    }

    /// Adds a rollout, and its values with a gradient by the design and by the controller.
    fn add_set(&mut self, set: &str, times: [f64; 3]) {
        let by = |block: &str| format!("{set}value_and_{block}_gradient");
        let works = [format!("{set}rollout"), by("design"), by("controller")];
        self.times.extend(works.into_iter().zip(times));
    }
}

/// Measures a case with a scene's loss: the case itself, a layout of its dominant materials within the
/// scene's volume bounds, and eight starts that run together. The plan of the rollout and its sine table,
/// which are made once, are left out.
pub fn measure(case: &Case, scene: &Scene) -> Speed {
    let layout = layout(case, &scene.volume);
    let [subject, one_hot] = [case, &layout].map(|case| Subject::new(case, &scene.loss));
    let steps = subject.steps();
    let mut speed = Speed {
        steps,
        times: Vec::new(),
        single_errors: (scene.schedule.horizon)
            .map(|steps| subject.single_error(steps, &scene.gradient)),
    };
    let matvecs = TwoMatvecs::new(case);
    // In turns with the yardstick: a disturbance of the machine affects both.
    let [rollout, by_design, by_controller] = subject.works::<f64>();
    let yardstick = work(|| matvecs.run(steps));
    let [two_matvecs, double @ ..] =
        microseconds(steps, [yardstick, rollout, by_design, by_controller]);
    speed.add_set("", double);
    // One set after the other: a change of number type or size frees the memory of the rows.
    speed.add_set("f32_", microseconds(steps, subject.works::<f32>()));
    speed.add_set("one_hot_", microseconds(steps, one_hot.works::<f64>()));
    speed.add_set("one_hot_f32_", microseconds(steps, one_hot.works::<f32>()));
    let eight = microseconds(STARTS * steps, subject.works_of_eight());
    speed.add_set("eight_starts_", eight);
    let [two_designs] = microseconds(2 * steps, [work(|| subject.two_gradients())]);
    for (name, time) in [
        ("one_of_two_designs", two_designs),
        ("two_matvecs", two_matvecs),
    ] {
        speed.times.push((name.to_owned(), time));
    }
    speed
}

/// A piece of work to be measured.
type Work<'a> = Box<dyn Fn() + 'a>;

fn work<'a, T>(run: impl Fn() -> T + 'a) -> Work<'a> {
    Box::new(move || drop(black_box(run())))
}

/// The shortest time of each work in microseconds per step. The works take turns.
fn microseconds<const N: usize>(steps: usize, works: [Work; N]) -> [f64; N] {
    let times = least_times(REPEATS, &works, |work| work());
    std::array::from_fn(|k| times[k] * 1e6 / steps as f64)
}

/// The case with one material per edge, as the hard snap gives it. If all mixtures are alike, a single
/// material dominates everywhere; the volume bounds ensure that there are actuators.
fn layout(case: &Case, volume: &VolumeSettings) -> Case {
    let bounds = VolumeBounds::widened(volume, 0.0);
    let rules = LayoutRules::new(&case.lattice, &case.rules);
    let snapped = snap(&case.own_design().mixtures(), &bounds, &rules);
    Case {
        design: Design::Layout(snapped),
        ..case.clone()
    }
}

/// A benchmark case: a rollout and its gradients.
#[derive(Clone)]
pub struct Subject<'a> {
    probe: Probe<'a>,
    /// Starts near the case's own.
    starts: Vec<State<f64>>,
    loss: Displacement,
    horizon: Horizon,
}

impl<'a> Subject<'a> {
    /// Plans rollouts of a case: [`MEASURED_STEPS`] steps, or as many as it has, but at least one.
    pub fn new(case: &'a Case, loss: &LossSettings) -> Self {
        let mut moving = case.clone();
        moving.physics.steps = case.physics.steps.max(1);
        let mut probe = Probe::new(case);
        probe.task = moving.task();
        Self {
            starts: probe.moved_starts(STARTS),
            loss: Displacement {
                ground: probe.task.ground(),
                settings: loss.clone(),
            },
            horizon: Horizon::head(MEASURED_STEPS.min(moving.physics.steps)),
            probe,
        }
    }

    /// This case with a budget for what a gradient keeps of the steps of its rollout.
    #[must_use]
    pub fn with_memory(&self, memory: Memory) -> Self {
        let mut other = self.clone();
        other.probe.task = other.probe.task.with_memory(memory);
        other
    }

    /// Steps of a rollout.
    pub fn steps(&self) -> usize {
        self.horizon.steps
    }

    /// The loss of a plain rollout.
    pub fn rollout<R: Real>(&self) -> R {
        let Probe { case, task, .. } = &self.probe;
        let inputs = self.probe.inputs.lift::<R>();
        let design = case.projected(case.projection, &inputs.z);
        let seen = task.rollout(&design, &inputs.controller, &inputs.start, &self.span());
        self.loss.loss(&seen)
    }

    /// The steps and nodes that the loss observes.
    fn span(&self) -> Span {
        Span {
            nodes: self.loss.nodes(),
            ..Span::from_start(self.loss.observed(self.horizon.steps))
        }
    }

    /// The loss and its gradient by some blocks of the inputs, such as
    /// [`DESIGN`] or [`CONTROLLER`]. The design gradient of a layout is the one by its mixtures.
    pub fn gradient<R: Real>(&self, blocks: &[Block]) -> (R, Vec<R>) {
        self.gradient_over(blocks, &self.horizon)
    }

    fn gradient_over<R: Real>(&self, blocks: &[Block], horizon: &Horizon) -> (R, Vec<R>) {
        self.probe.reverse(blocks, |inputs| {
            (self.probe.task).loss(&self.design(blocks, inputs), inputs, &self.loss, horizon)
        })
    }

    /// The losses in the performance and in the stability projection, each with its gradient by the
    /// design vectors, side by side as an optimisation computes them on one thread.
    pub fn two_gradients(&self) -> [(f64, Vec<f64>); 2] {
        let Probe {
            case, task, inputs, ..
        } = &self.probe;
        inputs.differentiate_copies(DESIGN, |copies: &[_; 2]| {
            let projections = [Projection::Performance, Projection::Stability];
            let design = |k: usize| case.projected(projections[k], &copies[k].z);
            let designs = [design(0), design(1)];
            let losses = task.losses(&designs, &copies[0], &self.loss, &self.horizon);
            [losses[0], losses[1]]
        })
    }

    fn mean_loss<R: Real>(&self, design: &Design<Mixture<R>>, controller: &Controller<R>) -> R {
        let span = self.span();
        let starts: Vec<State<R>> = self.starts.iter().map(|start| start.map(R::lit)).collect();
        let all = (self.probe.task).rollout_many(&[design], controller, &starts, &span);
        let losses: Vec<R> = all.iter().map(|seen| self.loss.loss(seen)).collect();
        R::sum_of(&losses) * R::lit(1.0 / STARTS as f64)
    }

    /// The design to differentiate by some blocks. The design vectors of a layout are its mixtures.
    fn design<R: Real>(&self, blocks: &[Block], inputs: &Inputs<R>) -> Design<Mixture<R>> {
        let case = self.probe.case;
        match case.design {
            Design::Layout(_) if blocks.contains(&Block::Z) => Design::of_shares(&inputs.z),
            _ => case.projected(case.projection, &inputs.z),
        }
    }

    /// The rollout, and its gradients by design and controller.
    fn works<R: Real>(&self) -> [Work<'_>; 3] {
        [
            work(|| self.rollout::<R>()),
            work(|| self.gradient::<R>(DESIGN)),
            work(|| self.gradient::<R>(CONTROLLER)),
        ]
    }

    /// The mean loss of eight starts that run together, and its gradients by design and controller.
    fn works_of_eight(&self) -> [Work<'_>; 3] {
        let gradient = |blocks: &[Block]| {
            self.probe.reverse::<f64>(blocks, |inputs| {
                self.mean_loss(&self.design(blocks, inputs), &inputs.controller)
            })
        };
        let Probe { case, inputs, .. } = &self.probe;
        [
            work(|| {
                let design = case.projected(case.projection, &inputs.z);
                self.mean_loss(&design, &inputs.controller)
            }),
            work(move || gradient(DESIGN)),
            work(move || gradient(CONTROLLER)),
        ]
    }

    /// The error of gradients in f32 over a horizon.
    fn single_error(&self, steps: usize, settings: &GradientSettings) -> GradientError {
        let horizon = Horizon {
            steps: steps.min(self.probe.case.physics.steps),
            cotangent_bound: settings.cotangent_bound.map(|norm| CotangentBound {
                norm,
                every: settings.cotangent_every,
            }),
            ..self.horizon
        };
        let error = |blocks| {
            let (_, double) = self.gradient_over::<f64>(blocks, &horizon);
            let (_, single) = self.gradient_over::<f32>(blocks, &horizon);
            let single: Vec<f64> = single.into_iter().map(f64::from).collect();
            relative_error(&single, &double)
        };
        GradientError {
            steps: horizon.steps,
            design: error(DESIGN),
            controller: error(CONTROLLER),
        }
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
    /// The mat-vecs of a case's controller.
    pub fn new(case: &Case) -> Self {
        Self {
            inputs: 4 * case.lattice.nodes(),
            hidden: case.observation.hidden,
            edges: case.lattice.edges.len(),
        }
    }

    /// Computes them `steps` times; returns the input vector.
    pub fn run(self, steps: usize) -> Vec<f64> {
        let (inputs, hidden, edges) = (self.inputs, self.hidden, self.edges);
        let rollout = Rollout::new(self, steps);
        let numbers = |count: usize| vec![0.1; count];
        let parameters = [hidden * inputs, hidden, edges * hidden, edges].map(numbers);
        rollout.run(&numbers(inputs), &parameters.each_ref().map(Vec::as_slice))
    }
}

impl Model for TwoMatvecs {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let (first, biases) = (p.matrix(self.hidden, self.inputs), p.parameter(self.hidden));
        let (second, outputs) = (p.matrix(self.edges, self.hidden), p.parameter(self.edges));
        let x = p.state(self.inputs);
        let hidden = p.dense(first, &[x], biases);
        p.dense(second, &[hidden], outputs);
        p.advance(x, x);
    }
}

#[cfg(test)]
mod tests {
    use super::Subject;
    use crate::verify::probe::small;
    use cosmic::scene::Scene;

    #[test]
    fn gradients_in_f32_are_roundings_away_from_those_in_f64() {
        let (case, scene) = (small([2, 2], |_| ()), Scene::paper());
        let subject = Subject::new(&case, &scene.loss);
        let error = subject.single_error(64, &scene.gradient);
        for share in [error.design, error.controller] {
            // Some ten roundings of 6e-8 a step. A gradient in f64 by mistake would be equal.
            assert!(share > 0.0 && share < 1e-4, "{share}");
        }
    }
}
