//! Computes the gradient of a case's displacement with respect to design and controller, by every method.

use autodiff::{DoubleDouble, Dual, Real, Var};
use rand::RngExt;
use rayon::prelude::*;

use crate::verify::probe::{Probe, dot, norm};
use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::inputs::{Block, CONTROLLER, DESIGN, Inputs};
use cosmic::random::{Purpose, stream};
use cosmic::simulator::{Simulator, Span};

/// The number of directions along which slopes are compared.
pub(super) const DIRECTIONS: usize = 8;

/// The slopes of a function along all directions, one slope per direction.
pub(super) type Slopes = [f64; DIRECTIONS];

/// A case, and random directions in the space of its inputs. The inputs are the design vectors and the controller's
/// weights; if the design is a layout, only the weights.
pub(super) struct Subject<'a> {
    pub(super) probe: Probe<'a>,
    blocks: Vec<Block>,
    /// The directions, as vectors of length 1.
    directions: [Vec<f64>; DIRECTIONS],
}

impl<'a> Subject<'a> {
    pub(super) fn new(case: &'a Case) -> Self {
        let blocks = match case.design {
            Design::Undecided(_) => [DESIGN, CONTROLLER].concat(),
            Design::Layout(_) => CONTROLLER.to_vec(),
        };
        let probe = Probe::new(case);
        let count = probe.inputs.get(&blocks).len();
        let mut stream = stream(1, Purpose::Verification);
        let directions = [(); DIRECTIONS].map(|()| {
            let mut draw = || 2.0 * stream.random::<f64>() - 1.0;
            let raw: Vec<f64> = (0..count).map(|_| draw()).collect();
            raw.iter().map(|d| d / norm(&raw)).collect()
        });
        Self {
            probe,
            blocks,
            directions,
        }
    }

    /// The number of entries of the gradient.
    pub(super) fn numbers(&self) -> usize {
        self.directions[0].len()
    }

    /// Returns the loss after each number of steps in `steps`, which must ascend. The loss is minus the payload's
    /// position along the ground.
    fn losses<R: Real>(&self, inputs: &Inputs<R>, steps: &[usize]) -> Vec<R> {
        let Probe { case, task, .. } = &self.probe;
        let design = case.projected(case.projection, &inputs.z);
        let span = Span::from_start(steps.to_vec());
        let seen = task.rollout(&design, &inputs.controller, &inputs.start, &span);
        let ground = task.ground();
        let along = |&step: &usize| -ground.along(seen.position(step));
        steps.iter().map(along).collect()
    }

    /// Converts the inputs to another number type. `step` computes each new number from two arguments: the old number,
    /// and the entry of `direction` at the same index.
    fn moved<R: Real>(&self, direction: &[f64], step: impl Fn(f64, f64) -> R) -> Inputs<R> {
        let mut inputs = self.probe.inputs.lift();
        let numbers = self.probe.inputs.get(&self.blocks);
        let pairs = numbers.iter().zip(direction);
        let moved: Vec<R> = pairs.map(|(&x, &d)| step(x, d)).collect();
        inputs.set(&self.blocks, &moved);
        inputs
    }

    /// Computes slopes by central differences with half-width `h`, for each number of steps, on this thread.
    pub(super) fn differences(&self, h: f64, steps: &[usize]) -> Vec<Slopes> {
        let along = |direction: &Vec<f64>| self.differences_along::<f64>(direction, h, steps);
        by_steps(self.directions.iter().map(along).collect())
    }

    /// Computes the true slopes by central differences in double-double, for each number of steps, on all threads.
    pub(super) fn truth(&self, h: f64, steps: &[usize]) -> Vec<Slopes> {
        let along =
            |direction: &Vec<f64>| self.differences_along::<DoubleDouble>(direction, h, steps);
        by_steps(self.directions.par_iter().map(along).collect())
    }

    fn differences_along<R: Real + Into<f64>>(
        &self,
        direction: &[f64],
        h: f64,
        steps: &[usize],
    ) -> Vec<f64> {
        let end = |h: f64| {
            let inputs = self.moved(direction, |x, d| R::lit(x) + R::lit(h) * R::lit(d));
            self.losses(&inputs, steps)
        };
        let ends = end(h).into_iter().zip(end(-h));
        let slopes = ends.map(|(up, down)| (up - down) / R::lit(2.0 * h));
        slopes.map(R::into).collect()
    }

    /// Computes slopes by dual numbers (forward mode), one direction after the other.
    pub(super) fn duals(&self, steps: usize) -> Slopes {
        self.directions.each_ref().map(|direction| {
            let inputs = self.moved(direction, |value, d| Dual {
                value,
                tangent: [d],
            });
            self.losses(&inputs, &[steps])[0].tangent[0]
        })
    }

    /// Computes the gradient as optimisations do: with the rollout driver.
    pub(super) fn driver<R: Real>(&self, steps: usize) -> Vec<R> {
        self.reverse(|inputs| self.losses(inputs, &[steps])[0])
    }

    /// Computes the gradient with a tape that records every operation of the rollout.
    pub(super) fn full_tape(&self, steps: usize) -> Vec<f64> {
        let Probe { case, task, .. } = &self.probe;
        self.reverse(|inputs| {
            let body = task.body(&case.projected(case.projection, &inputs.z));
            let span = Span::from_start(vec![steps]);
            let simulator = Simulator::new(&case.lattice, &case.physics, &case.observation);
            let seen = simulator.rollout_in_full(&body, &inputs.controller, &inputs.start, &span);
            -task.ground().along(seen.position(steps))
        })
    }

    /// Computes the gradient with the rollout driver, but differentiates only the last `carried` steps.
    pub(super) fn truncated(&self, steps: usize, carried: usize) -> Vec<f64> {
        let Probe { case, task, .. } = &self.probe;
        let first = steps - carried;
        let design = case.own_design();
        let head = Span::from_start(vec![first]);
        let reached = task.rollout(&design, &case.controller, &case.start, &head);
        let span = Span {
            first,
            ..Span::from_start(vec![carried])
        };
        self.reverse(|inputs| {
            let design = case.projected(case.projection, &inputs.z);
            let start = reached.states[0].map(Var::constant);
            let mut seen = task.rollout(&design, &inputs.controller, &start, &span);
            if !seen.start.is_empty() {
                seen.start.clone_from(&inputs.start.x);
            }
            -task.ground().along(seen.position(carried))
        })
    }

    fn reverse<R: Real>(&self, loss: impl FnOnce(&Inputs<Var<R>>) -> Var<R>) -> Vec<R> {
        self.probe.reverse(&self.blocks, loss).1
    }

    /// Computes the slopes along all directions from a gradient.
    pub(super) fn along(&self, gradient: &[f64]) -> Slopes {
        (self.directions.each_ref()).map(|direction| dot(direction, gradient))
    }
}

/// Transposes a table of slopes: the input has a list for each direction, the result a list for each number of steps.
fn by_steps(by_direction: Vec<Vec<f64>>) -> Vec<Slopes> {
    let slopes = |k: usize| std::array::from_fn(|d| by_direction[d][k]);
    (0..by_direction[0].len()).map(slopes).collect()
}
