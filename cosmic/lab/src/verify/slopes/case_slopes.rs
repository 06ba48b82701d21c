//! The displacement of a case as a function of design and controller, and all ways to its gradient.

use autodiff::{Dual, Real, Var};
use rand::RngExt;

use crate::verify::probe::{dot, norm};
use cosmic::case::Case;
use cosmic::inputs::{Block, CONTROLLER, DESIGN, Inputs};
use cosmic::objective::Displacement;
use cosmic::random::{Purpose, stream};
use cosmic::scene::HorizonMode;
use cosmic::simulator::{Simulator, Span};
use cosmic::task::{Horizon, Task};

/// Directions along which slopes are compared.
pub(super) const DIRECTIONS: usize = 8;

/// Design vectors and weights; of a frozen layout the weights alone.
pub(super) struct CaseSlopes<'a> {
    case: &'a Case,
    task: Task,
    inputs: Inputs<f64>,
    blocks: Vec<Block>,
    /// Random, of length one.
    pub(super) directions: [Vec<f64>; DIRECTIONS],
}

impl<'a> CaseSlopes<'a> {
    pub(super) fn new(case: &'a Case) -> Self {
        let blocks = match case.frozen {
            None => [DESIGN, CONTROLLER].concat(),
            Some(_) => CONTROLLER.to_vec(),
        };
        let inputs = case.inputs();
        let mut stream = stream(1, Purpose::Verification);
        let count = inputs.get(&blocks).len();
        let directions = [(); DIRECTIONS].map(|()| {
            let mut draw = || 2.0 * stream.random::<f64>() - 1.0;
            let raw: Vec<f64> = (0..count).map(|_| draw()).collect();
            raw.iter().map(|d| d / norm(&raw)).collect()
        });
        Self {
            task: case.task(),
            case,
            inputs,
            blocks,
            directions,
        }
    }

    /// The count of numbers in the gradient.
    pub(super) fn numbers(&self) -> usize {
        self.directions[0].len()
    }

    /// Minus the payload's position along the ground after each of `steps`, which ascend.
    fn losses<R: Real>(&self, inputs: &Inputs<R>, steps: &[usize]) -> Vec<R> {
        let mixture = self.case.mixture(self.case.projection, &inputs.z);
        let (controller, start) = (&inputs.controller, &inputs.start);
        let span = Span::from_start(steps.to_vec());
        let seen = self.task.rollout(&mixture, controller, start, &span);
        let along = |k: usize| self.task.ground().along(seen.states[k].x[0]);
        (0..steps.len()).map(|k| -along(k)).collect()
    }

    /// Slopes along all directions by central differences of this half-width, per step count.
    pub(super) fn differences(&self, h: f64, steps: &[usize]) -> Vec<[f64; DIRECTIONS]> {
        let numbers = self.inputs.get(&self.blocks);
        let moved = |direction: &[f64], h: f64| {
            let pairs = numbers.iter().zip(direction);
            let moved: Vec<f64> = pairs.map(|(x, d)| x + h * d).collect();
            let mut inputs = self.inputs.clone();
            inputs.set(&self.blocks, &moved);
            self.losses(&inputs, steps)
        };
        let by_direction = self.directions.each_ref().map(|direction| {
            let ends = moved(direction, h).into_iter().zip(moved(direction, -h));
            let slopes = ends.map(|(up, down)| (up - down) / (2.0 * h));
            slopes.collect::<Vec<f64>>()
        });
        let slopes = |k: usize| std::array::from_fn(|d| by_direction[d][k]);
        (0..steps.len()).map(slopes).collect()
    }

    /// Slopes along `N` directions, from the `first` on, by duals over a number type, per step
    /// count.
    pub(super) fn duals<R: Real, const N: usize>(
        &self,
        first: usize,
        steps: &[usize],
    ) -> Vec<[R; N]> {
        let numbers = self.inputs.get(&self.blocks);
        let dual = |(i, &x): (usize, &f64)| Dual {
            value: R::lit(x),
            tangent: std::array::from_fn(|k| R::lit(self.directions[first + k][i])),
        };
        let moving: Vec<Dual<R, N>> = numbers.iter().enumerate().map(dual).collect();
        let mut inputs = self.inputs.lift();
        inputs.set(&self.blocks, &moving);
        let losses = self.losses(&inputs, steps);
        losses.iter().map(|loss| loss.tangent).collect()
    }

    /// The gradient by the rollout driver.
    pub(super) fn driver<R: Real>(&self, steps: usize) -> Vec<R> {
        self.reverse(|inputs| self.losses(inputs, &[steps])[0])
    }

    /// The gradient by a tape of every operation.
    pub(super) fn full_tape<R: Real>(&self, steps: usize) -> Vec<R> {
        self.reverse(|inputs| {
            let mixture = self.case.mixture(self.case.projection, &inputs.z);
            let (body, controller) = (self.task.body(&mixture), &inputs.controller);
            let span = Span::from_start(vec![steps]);
            let case = self.case;
            let simulator = Simulator::new(&case.lattice, &case.physics, &case.observation);
            let seen = simulator.rollout_in_full(&body, controller, &inputs.start, &span);
            -self.task.ground().along(seen.states[0].x[0])
        })
    }

    /// The driver's gradient over the last `carried` of the steps.
    pub(super) fn truncated(&self, steps: usize, carried: usize) -> Vec<f64> {
        let mut case = self.case.clone();
        case.physics.steps = steps;
        let task = case.task();
        let horizon = Horizon {
            steps: carried,
            mode: HorizonMode::Tail,
            cotangent_bound: None,
        };
        let loss = Displacement::at_end(task.ground());
        self.reverse(|inputs| {
            let mixture = case.mixture(case.projection, &inputs.z);
            task.loss(&mixture, inputs, &loss, &horizon)
        })
    }

    fn reverse<R: Real>(&self, loss: impl FnOnce(&Inputs<Var<R>>) -> Var<R>) -> Vec<R> {
        self.inputs.lift().differentiate(&self.blocks, loss).1
    }

    /// A gradient's slopes along the directions.
    pub(super) fn along(&self, gradient: &[f64]) -> [f64; DIRECTIONS] {
        (self.directions.each_ref()).map(|direction| dot(direction, gradient))
    }
}
