//! Weighted arrays and offsets in a program must agree with the same numbers computed in plain code.

use crate::steps::{Step, Turn, assert_as_alone, assert_same};
use autodiff::{Given, Kernel, Model, Program, Real, Rollout};

/// A model that uses the weighted means. Two arrays are weighted as offsets and one as values, and there is an input.
#[derive(Clone)]
struct Weighing {
    len: usize,
}

impl Model for Weighing {
    fn record(&self, p: &mut Program) {
        let n = self.len;
        let weights = p.parameter(n);
        let [x, y, v] = [(); 3].map(|()| p.state(n));
        let input = p.input(1);
        let [all, means] = p.weighted(weights, &[x, y], &[v], &[input]);
        let part = |k: usize| -> Vec<_> { (0..n).map(|i| Some(k * n + i)).collect() };
        let [dx, dy, dv] = [0, 1, 2].map(|k| p.gather(all, &part(k)));
        let pushed = p.gather(all, &vec![Some(3 * n); n]);
        let [mx, my] = [0, 1].map(|k| p.gather(means, &vec![Some(k); n]));
        for (state, [a, b]) in [(x, [dx, mx]), (y, [dy, my]), (v, [dv, pushed])] {
            let [next] = p.map(Turn, [a, b], &[]);
            p.advance(state, next);
        }
    }
}

/// Maps any number to a weight above 0.
fn weight<R: Real>(x: R) -> R {
    x * x + R::lit(0.2)
}

impl Step for Weighing {
    fn shapes(&self) -> Vec<usize> {
        vec![3 * self.len, self.len]
    }
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        vec![given[0].iter().map(|&x| weight(x)).collect()]
    }
    fn inputs(&self) -> Vec<f64> {
        vec![0.3]
    }
    fn written_out<R: Real>(&self, state: &[R], given: &[&[R]]) -> Vec<R> {
        let weights = self.parameters(given).remove(0);
        let total = R::sum_of(&weights);
        let turn = |a, b| Kernel::eval(&Turn, [a, b], &[])[0];
        let mut next = Vec::new();
        for x in state.chunks_exact(self.len).take(2) {
            let mean = R::dot(x, &weights) / total;
            let entries = x.iter().zip(&weights);
            next.extend(entries.map(|(&x, &w)| turn(w * (x - mean), mean)));
        }
        let values = state[2 * self.len..].iter().zip(&weights);
        next.extend(values.map(|(&v, &w)| turn(w * v, R::lit(0.3))));
        next
    }
}

/// Lengths that fill less than a register, whole registers, or whole registers and a part.
const LENGTHS: [usize; 4] = if cfg!(miri) {
    [1, 3, 8, 17]
} else {
    [1, 3, 16, 37]
};

#[test]
fn weighted_arrays_are_as_written_out() {
    for len in LENGTHS {
        assert_same(Weighing { len });
    }
}

/// Starts that have their own weights must give the values and gradients of single rollouts, bit by bit.
#[test]
fn starts_with_their_own_weights_run_together() {
    for len in LENGTHS {
        let rollout = Rollout {
            inputs: vec![0.3; 3].into(),
            ..Rollout::new(Weighing { len }, 3)
        };
        let numbers = |count: usize, by: f64| -> Vec<f64> {
            (0..count).map(|i| (by * i as f64 + by).sin()).collect()
        };
        let robot = |k: usize| {
            let weights = numbers(len, 1.1 + k as f64).into_iter().map(weight);
            let state = numbers(3 * len, 0.7 + k as f64);
            state.into_iter().chain(weights).collect()
        };
        let robots: Vec<Vec<f64>> = (0..11).map(robot).collect();
        assert_as_alone(&robots, |robots| {
            let parts = robots.iter().map(|robot| robot.split_at(3 * len));
            let (starts, weights): (Vec<_>, Vec<_>) = parts.unzip();
            rollout.run_batch(&starts, &[Given::Each(&weights)])
        });
    }
}
