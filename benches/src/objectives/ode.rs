//! The ODE `y_0' = x_0`, `y_i' = x_i y_(i-1)` with `y = 0` at the start. It is solved by the classical Runge-Kutta
//! method, in a rollout.

use autodiff::{Function, Real, gradient};
use autodiff_programs::{Array, Kernel, Memory, Model, Program, Rollout};
use cosmic::kernel;
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Error, Prepared, read, require, work};

#[derive(Deserialize)]
struct Input {
    x: Vec<f64>,
    s: usize,
}

/// The time at which the solution ends.
const END: f64 = 2.0;

/// The memory budget of a rollout in bytes. It fits roughly into the caches of a processor.
const MEMORY: usize = 1 << 24;

/// A kernel that computes a slope, and the state after following this slope for the given time.
struct Stage(f64);
/// A kernel that computes the last slope, and the state after following the weighted mean of all four slopes.
struct Last(f64);

#[kernel]
impl Kernel<3, 2> for Stage {
    fn eval<R: Real>(&self, [x, before, y]: [R; 3], _: &[R]) -> [R; 2] {
        let slope = x * before;
        [slope, slope.fma(R::lit(self.0), y)]
    }
}

#[kernel]
impl Kernel<6, 1> for Last {
    fn eval<R: Real>(&self, [x, before, y, k1, k2, k3]: [R; 6], _: &[R]) -> [R; 1] {
        let sum = R::lit(2.0).fma(k2 + k3, x.fma(before, k1));
        [sum.fma(R::lit(self.0 / 6.0), y)]
    }
}

/// The model of one Runge-Kutta step. The state is a chain of numbers, the first of which is constant.
#[derive(Clone)]
struct Chain {
    len: usize,
    dt: f64,
}

impl Model for Chain {
    fn record(&self, program: &mut Program) {
        let x = program.parameter(self.len);
        let y = program.state(self.len);
        let before: Vec<_> = (0..self.len).map(|i| i.checked_sub(1)).collect();
        let stage = |program: &mut Program, at: Array, time: f64| {
            let before = program.gather(at, &before);
            program.map(Stage(time), [x, before, y], &[])
        };
        let [k1, at] = stage(program, y, 0.5 * self.dt);
        let [k2, at] = stage(program, at, 0.5 * self.dt);
        let [k3, at] = stage(program, at, self.dt);
        let before = program.gather(at, &before);
        let [next] = program.map(Last(self.dt), [x, before, y, k1, k2, k3], &[]);
        program.advance(y, next);
    }
}

struct Solution {
    steps: usize,
}

impl Solution {
    /// Returns the chosen entries of `y` at the end time, or all entries if `entries` is `None`. The state starts with
    /// a constant 1 before `y_0`, so that the slope of `y_0` has the same form as the other slopes.
    fn end<R: Real>(&self, x: &[R], entries: Option<Vec<usize>>) -> Vec<R> {
        let chain = Chain {
            len: x.len() + 1,
            dt: END / self.steps as f64,
        };
        let mut start = vec![R::zero(); chain.len];
        start[0] = R::one();
        let rollout = Rollout {
            entries,
            memory: Memory::Bytes(MEMORY),
            ..Rollout::new(chain, self.steps)
        };
        rollout.run(&start, &[&[&[R::zero()], x].concat()])
    }
}

/// The function of `x` that returns the last entry of `y`.
impl Function for Solution {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.end(x, Some(vec![x.len()]))[0]
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { x, s: steps } = read(input)?;
    require(
        !x.is_empty() && steps > 0,
        "`x` must not be empty, and `s` must be 1 or more",
    )?;
    let solution = Solution { steps };
    match function {
        "primal" => work(move || solution.end(&x, None).split_off(1)),
        "gradient" => work(move || gradient(|x| solution.eval(x), &x)),
        _ => Error::function(function),
    }
}
