//! Measures the cost of a step on this machine, in processor time of one thread.

use std::hint::black_box;

use autodiff::{Memory, Model, Program, Real, Rollout};

use super::clock::least_times;
use super::probe::Probe;
use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::inputs::{Block, CONTROLLER, DESIGN, Inputs};
use cosmic::objective::{Displacement, Loss};
use cosmic::projection::Projection;
use cosmic::scene::LossSettings;
use cosmic::simulator::Span;
use cosmic::task::Horizon;
use serde::Serialize;

/// The number of steps of a measured rollout, unless the case has fewer.
pub const MEASURED_STEPS: usize = 4096;
/// The number of repeats of each measurement. The shortest time counts, because it is the least disturbed one.
const REPEATS: usize = 25;

/// The processor times of a step in microseconds, for several computations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speed {
    /// The number of steps of the measured rollouts.
    pub steps: usize,
    /// The time per step of a rollout without a gradient.
    pub rollout: f64,
    /// The time per step of the loss and its gradient with respect to the design vectors.
    pub value_and_design_gradient: f64,
    /// The time per step of the loss and its gradient with respect to the controller's weights.
    pub value_and_controller_gradient: f64,
    /// The time per step of the controller's two matrix-vector products alone, for comparison.
    pub two_matvecs: f64,
}

/// Measures the times of a case with the loss `loss`. Preparations that a rollout makes only once, such as the table of
/// sines, are not included.
pub fn measure(case: &Case, loss: &LossSettings) -> Speed {
    let (subject, matvecs) = (Subject::new(case, loss), TwoMatvecs::new(case));
    let steps = subject.steps();
    // The measurements take turns, so that a disturbance of the machine affects all of them.
    let works: [&dyn Fn(); 4] = [
        &|| _ = black_box(subject.rollout::<f64>()),
        &|| _ = black_box(subject.gradient::<f64>(DESIGN)),
        &|| _ = black_box(subject.gradient::<f64>(CONTROLLER)),
        &|| _ = black_box(matvecs.run(steps)),
    ];
    let times = least_times(REPEATS, &works, |work| work());
    let time = |k: usize| times[k] * 1e6 / steps as f64;
    Speed {
        steps,
        rollout: time(0),
        value_and_design_gradient: time(1),
        value_and_controller_gradient: time(2),
        two_matvecs: time(3),
    }
}

/// A case prepared for benchmarks: a rollout and its gradients.
#[derive(Clone)]
pub struct Subject<'a> {
    probe: Probe<'a>,
    loss: Displacement,
    horizon: Horizon,
}

impl<'a> Subject<'a> {
    /// Prepares rollouts of a case. They have [`MEASURED_STEPS`] steps, or fewer if the case has fewer, but at least
    /// one.
    pub fn new(case: &'a Case, loss: &LossSettings) -> Self {
        let mut moving = case.clone();
        moving.physics.steps = case.physics.steps.max(1);
        let mut probe = Probe::new(case);
        probe.task = moving.task();
        Self {
            loss: Displacement {
                ground: probe.task.ground(),
                settings: loss.clone(),
            },
            horizon: Horizon::of_steps(MEASURED_STEPS.min(moving.physics.steps)),
            probe,
        }
    }

    /// Returns this case with another memory budget for gradients.
    #[must_use]
    pub fn with_memory(&self, memory: Memory) -> Self {
        let mut other = self.clone();
        other.probe.task = other.probe.task.with_memory(memory);
        other
    }

    /// The number of steps of a measured rollout.
    pub fn steps(&self) -> usize {
        self.horizon.steps
    }

    /// Computes the loss without its gradient.
    pub fn rollout<R: Real>(&self) -> R {
        let Probe { case, task, .. } = &self.probe;
        let inputs = self.probe.inputs.lift::<R>();
        let design = case.projected(case.projection, &inputs.z);
        let seen = task.rollout(&design, &inputs.controller, &inputs.start, &self.span());
        self.loss.loss(&seen)
    }

    /// The steps of the rollout, and the states and nodes that the loss observes.
    fn span(&self) -> Span {
        Span {
            nodes: self.loss.nodes().max(self.probe.case.body().marker.nodes()),
            ..Span::from_start(self.loss.observed(self.horizon.steps))
        }
    }

    /// Computes the loss and its gradient with respect to some blocks of the inputs, such as [`DESIGN`] or
    /// [`CONTROLLER`]. A layout has no design vectors; instead, the gradient is with respect to its mixtures.
    pub fn gradient<R: Real>(&self, blocks: &[Block]) -> (R, Vec<R>) {
        self.probe.reverse(blocks, |inputs| {
            let design = self.design(blocks, inputs);
            (self.probe.task).loss(&design, inputs, &self.loss, &self.horizon)
        })
    }

    /// Computes the loss in the performance projection and in the stability projection, each with its gradient with
    /// respect to the design vectors. The two are computed together, as in an optimisation on one thread.
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

    /// Returns the design for a rollout that is differentiated with respect to some blocks. A layout has no design
    /// vectors, so its mixtures are used instead.
    fn design<R: Real>(&self, blocks: &[Block], inputs: &Inputs<R>) -> Design<Mixture<R>> {
        let case = self.probe.case;
        match case.design {
            Design::Layout(_) if blocks.contains(&Block::Z) => Design::of_shares(&inputs.z),
            _ => case.projected(case.projection, &inputs.z),
        }
    }
}

/// The two products `W2 (W1 x)` with the shapes of a controller: from all positions and velocities to hidden units, and
/// from there to edges.
#[derive(Clone, Copy, Debug)]
pub struct TwoMatvecs {
    inputs: usize,
    hidden: usize,
    edges: usize,
}

impl TwoMatvecs {
    /// Prepares the two matrix-vector products with the shapes of a case's controller.
    pub fn new(case: &Case) -> Self {
        Self {
            inputs: 4 * case.lattice.nodes(),
            hidden: case.observation.hidden,
            edges: case.lattice.edges.len(),
        }
    }

    /// Computes the two matrix-vector products `steps` times. Returns the input vector.
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
