//! Operations that a crate adds to steps must agree with plain code in every number type and mode.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::simd::Lane;
use autodiff::{DoubleDouble, Dual, Function, Mask, Real, gradient};
use autodiff_programs::operations::{ArrayOperation, Forward, Reverse};
use autodiff_programs::{Given, Kernel, Model, Program, Rollout, kernel};

use crate::common::{assert_named, largest_difference};
use crate::steps::{Step, Turn, assert_as_alone, assert_same};

/// The shares of numbers in their weighted sum, and that sum: `y[k] = w[k] x[k] / t` with `t = w[0] x[0] + w[1] x[1] + ...`.
struct Shares;

#[kernel]
impl ArrayOperation for Shares {
    fn forward<R: Real, L: Lane<R>>(&self, Forward { x, y, scratch }: Forward<R>) {
        let (w, numbers, starts) = (x.get(0), x.get(1), x.starts());
        let (shares, total) = y.split_at_mut(numbers.len());
        total.fill(R::zero());
        for at in 0..numbers.len() {
            total[at % starts] += w[at] * numbers[at];
        }
        scratch.resize(L::N, R::zero());
        for k in 0..L::N {
            scratch[k] = total[k % starts];
        }
        for at in (0..numbers.len()).step_by(L::N) {
            let end = numbers.len().min(at + L::N);
            let product = L::load_up_to(&w[at..end]) * L::load_up_to(&numbers[at..end]);
            (product / L::load(scratch)).store_up_to(&mut shares[at..end]);
        }
    }

    fn reverse<R: Real, L: Lane<R>>(&self, step: Reverse<R>) {
        let Reverse { x, y, y_bar, .. } = step;
        let (mut x_bar, of_product) = (step.x_bar, step.scratch);
        let (w, numbers, starts) = (x.get(0), x.get(1), x.starts());
        let len = numbers.len();
        of_product.clear();
        of_product.resize(len, R::zero());
        for s in 0..starts {
            let (total, mut mean) = (y[len + s], R::zero());
            for at in (s..len).step_by(starts) {
                mean += y_bar[at] * y[at];
            }
            for at in (s..len).step_by(starts) {
                of_product[at] = (y_bar[at] - mean) / total + y_bar[len + s];
            }
        }
        for (k, other) in [(0, numbers), (1, w)] {
            if let Some(bar) = x_bar.get_mut(k) {
                for at in 0..len {
                    bar[at] += other[at] * of_product[at];
                }
            }
        }
    }
}

/// A step in which the shares, mixed with the state, are the next state. The second part of the state is the sum.
#[derive(Clone)]
struct Shared(usize);

impl Model for Shared {
    fn record(&self, p: &mut Program) {
        let w = p.parameter(self.0);
        let (x, total) = (p.state(self.0), p.state(1));
        let outputs = p.operation(Shares, &[w, x], &[self.0, 1]);
        let [next] = p.map(Turn, [outputs[0], x], &[]);
        p.advance(x, next);
        p.advance(total, outputs[1]);
    }
}

impl Step for Shared {
    fn shapes(&self) -> Vec<usize> {
        vec![self.0 + 1, self.0]
    }
    fn written_out<R: Real>(&self, _: usize, state: &[R], given: &[&[R]]) -> Vec<R> {
        let (x, w) = (&state[..self.0], given[0]);
        let products: Vec<R> = x.iter().zip(w).map(|(&x, &w)| w * x).collect();
        let total = (products.iter()).fold(R::zero(), |sum, &product| sum + product);
        let shares = products.iter().map(|&product| product / total);
        let next = shares
            .zip(x)
            .map(|(share, &x)| Turn.eval([share, x], &[])[0]);
        next.chain([total]).collect()
    }
}

#[test]
fn added_operations_agree_with_plain_code() {
    // 9 and 21 numbers do not fill registers.
    for len in [1, 9, 21] {
        assert_same(Shared(len));
    }
}

/// The sum of the squares of the state after some steps.
struct Squares;

const LEN: usize = 5;

impl Function for Squares {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (state, w) = x.split_at(LEN + 1);
        let ends = Rollout::new(Shared(LEN), 3).run(state, &[w]);
        ends.into_iter().fold(R::zero(), |sum, x| x.fma(x, sum))
    }
}

fn point() -> Vec<f64> {
    (0..2 * LEN + 1).map(|k| 1.5 + (k as f64).sin()).collect()
}

/// In double-double numbers, too.
#[test]
fn added_operations_agree_with_finite_differences_in_both_modes() {
    let report = check_gradient(&Squares, &point(), &Options::default());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
}

#[test]
fn both_modes_agree_in_wide_numbers() {
    let wide: Vec<DoubleDouble> = point().into_iter().map(DoubleDouble::from).collect();
    let slopes = gradient(|x| Squares.eval(x), &wide);
    let along = |(k, &value): (usize, &DoubleDouble)| Dual {
        value,
        tangent: [DoubleDouble::from((k as f64).cos())],
    };
    let along: Vec<Dual<DoubleDouble, 1>> = wide.iter().enumerate().map(along).collect();
    let slope = along
        .iter()
        .zip(&slopes)
        .fold(DoubleDouble::from(0.0), |sum, (x, &slope)| {
            sum + slope * x.tangent[0]
        });
    // f64 would differ by 1e-16.
    assert!(largest_difference(&[slope], &[Squares.eval(&along).tangent[0]]) < 1e-28);
}

#[test]
fn starts_of_added_operations_run_together() {
    let runs = (0..11).map(|k| point().iter().map(|x| x + 0.1 * f64::from(k)).collect());
    let runs: Vec<Vec<f64>> = runs.collect();
    assert_as_alone(&runs, |runs| {
        let starts: Vec<_> = runs.iter().map(|x| &x[..LEN + 1]).collect();
        let weights: Vec<_> = runs.iter().map(|x| &x[LEN + 1..]).collect();
        Rollout::new(Shared(LEN), 3).run_batch(&starts, &[Given::Each(&weights)])
    });
}

/// The sum of the first input and twice the second, which may be the same array. Where the sum of two numbers is 0, it is not
/// computed: code may ask for values.
struct Thrice;

#[kernel]
impl ArrayOperation for Thrice {
    fn forward<R: Real, L: Lane<R>>(&self, Forward { x, y, .. }: Forward<R>) {
        let [a, b] = [x.get(0), x.get(1)];
        for at in 0..y.len() {
            y[at] = R::zero();
            if !a[at].is_zero() || R::zero().less(b[at].abs()).any() {
                y[at] = a[at] + R::lit(2.0) * b[at];
            }
        }
    }
    fn reverse<R: Real, L: Lane<R>>(&self, step: Reverse<R>) {
        let (y_bar, mut x_bar) = (step.y_bar, step.x_bar);
        for (k, factor) in [(0, 1.0), (1, 2.0)] {
            let Some(bar) = x_bar.get_mut(k) else {
                continue;
            };
            for at in 0..y_bar.len() {
                bar[at] += R::lit(factor) * y_bar[at];
            }
        }
    }
}

#[derive(Clone)]
struct Tripled;

impl Model for Tripled {
    fn record(&self, p: &mut Program) {
        let x = p.state(2);
        let y = p.operation(Thrice, &[x, x], &[2]);
        p.advance(x, y[0]);
    }
}

#[test]
fn an_input_may_come_twice_and_code_may_ask_for_values() {
    let rollout = Rollout::new(Tripled, 2);
    assert_eq!(rollout.run(&[1.0_f32, 0.0], &[]), [9.0, 0.0]);
    assert_eq!(
        gradient(|x| rollout.run(x, &[])[0], &[1.0, 0.0]),
        [9.0, 0.0]
    );
    let dual = |value, tangent| Dual {
        value,
        tangent: [tangent],
    };
    let x = [dual(1.0, 1.0), dual(0.0, 0.0)];
    assert_eq!(rollout.run(&x, &[])[0].tangent, [9.0]);
    // A gradient of duals: the reverse sweep asks too.
    let slopes = gradient(|x| rollout.run(x, &[])[0], &x);
    assert_eq!(slopes[0].value, 9.0);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn wrong_arrays_are_refused() {
    let mut other = Program::default();
    let foreign = other.state(3);
    let p = &mut Program::default();
    let x = p.state(2);
    assert_named(|| p.operation(Thrice, &[x, x], &[])).says("at least one output");
    assert_named(|| p.operation(Thrice, &[foreign, x], &[2])).says("another program");
}
