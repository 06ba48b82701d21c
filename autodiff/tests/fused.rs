//! Functions that the tape records as one call, and custom rules, must agree with the same functions written out in scalar
//! operations.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::common::{Sym, assert_close, assert_gradient, formula, gradients, hessian_rows};
use autodiff::custom::{Rule, apply};
use autodiff::fused::{dense, dense_batch};
use autodiff::implicit::{Residual, root};
use autodiff::{Dual, Function, Fused, Real, Tape, Var, gradient};

/// The largest difference between sums that add the same terms of order 1 in a different order.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

fn assert_same_derivatives(a: &impl Function, b: &impl Function, x: &[f64]) {
    assert_close(&[a.eval(x)], &[b.eval(x)], ROUNDING);
    for ((_, a), (_, b)) in gradients(a, x).iter().zip(gradients(b, x)) {
        assert_close(a, &b, ROUNDING);
    }
    for (a, b) in hessian_rows(a, x).iter().zip(hessian_rows(b, x)) {
        assert_close(a, &b, ROUNDING);
    }
}

const POINT: [f64; 4] = [0.3, -1.2, 0.7, 2.0];

/// The tested function is `tanh(x . (x, constants))` and a sum. The dot product contains a variable twice, constants
/// among variables, and a zero constant.
#[test]
fn dot_and_sum_equal_their_written_out_forms() {
    let of = |fused: bool| {
        formula(4, |x| {
            let other = [x[1], Sym::lit(0.5), x[1], Sym::lit(0.0)];
            let (dot, sum) = if fused {
                (Sym::dot(x, &other), Sym::sum_of(&other))
            } else {
                let terms = x.iter().zip(&other).map(|(&a, &b)| a * b);
                (terms.sum(), other.iter().sum())
            };
            dot.tanh() * sum
        })
    };
    assert_same_derivatives(&of(true), &of(false), &POINT);
}

#[test]
fn empty_slices_sum_to_a_constant_zero() {
    let zeros: [Var<f64>; 2] =
        Tape::new().record(&[1.0], |_| [Var::sum_of(&[]), Var::dot(&[], &[0.0; 0])]);
    assert!(
        zeros
            .iter()
            .all(|zero| zero.is_constant() && zero.value() == 0.0)
    );
}

/// A fused function that multiplies `x` by a matrix. It counts the calls of its reverse rule.
struct MatVec {
    reversed: Arc<AtomicUsize>,
}

fn transposed_product<R: Real>(m: &[R], y_bar: &[R], columns: usize) -> Vec<R> {
    let column =
        |j: usize| (0..y_bar.len()).fold(R::zero(), |sum, i| m[i * columns + j].fma(y_bar[i], sum));
    (0..columns).map(column).collect()
}

impl Fused for MatVec {
    type Saved<R: Real> = (Vec<R>, Vec<R>);

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        let (m, x) = (inputs[0], inputs[1]);
        m.chunks_exact(x.len()).map(|row| R::dot(row, x)).collect()
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Self::Saved<R>) {
        (self.eval(inputs), (inputs[0].to_vec(), inputs[1].to_vec()))
    }

    fn reverse<R: Real>(
        &self,
        saved: &mut Self::Saved<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        self.reversed.fetch_add(1, Ordering::Relaxed);
        let (m, x) = saved;
        let outer = y_bar
            .iter()
            .flat_map(|&y_bar| x.iter().map(move |&x| y_bar * x));
        let m_bar = if wanted[0] {
            outer.collect()
        } else {
            Vec::new()
        };
        let x_bar = if wanted[1] {
            transposed_product(m, y_bar, x.len())
        } else {
            Vec::new()
        };
        vec![m_bar, x_bar]
    }
}

/// The function `sin(y_1) y_2` with `y = M x`. The matrix consists of variables or of constants. The output `y_0` is
/// unused; this must not keep the reverse rule from running for the other outputs.
struct Network {
    constant_matrix: bool,
}

impl Network {
    fn matrix<R: Real>(&self, x: &[R]) -> [R; 6] {
        let m = [x[0], x[1] * x[2], R::lit(2.0), x[3], R::one(), x[0]];
        if self.constant_matrix {
            m.map(R::detach)
        } else {
            m
        }
    }
}

impl Function for Network {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let reversed = Arc::new(AtomicUsize::new(0));
        let product = R::fused(MatVec { reversed }, &[&self.matrix(x), &x[1..3]]);
        product[1].sin() * product[2]
    }
}

#[test]
fn a_fused_function_equals_its_written_out_form() {
    for constant_matrix in [false, true] {
        let network = Network { constant_matrix };
        let plain = formula(4, |x| {
            let m = network.matrix(x);
            let row = |i: usize| m[2 * i] * x[1] + m[2 * i + 1] * x[2];
            row(1).sin() * row(2)
        });
        assert_same_derivatives(&network, &plain, &POINT);
    }
}

#[test]
fn a_fused_entry_without_cotangent_is_not_reversed() {
    let reversed = Arc::new(AtomicUsize::new(0));
    let function = MatVec {
        reversed: reversed.clone(),
    };
    let mut tape = Tape::new();
    let y = tape.record(&[1.0, 2.0], |x| {
        let unused = Var::fused(function, &[&[Var::lit(3.0); 4], x]);
        [x[0] * x[1], unused[0]]
    });
    assert_eq!(tape.pullback(&y[..1], &[1.0]), [2.0, 1.0]);
    assert_eq!(reversed.load(Ordering::Relaxed), 0);
    assert_eq!(tape.pullback(&y[1..], &[1.0]), [3.0, 3.0]);
    assert_eq!(reversed.load(Ordering::Relaxed), 1);
}

/// A thread keeps the memory of its last tape for reuse. Everything that a function on the tape owns must still be
/// dropped.
#[test]
fn what_a_function_owns_is_given_back() {
    let reversed = Arc::new(AtomicUsize::new(0));
    let product = |x: &[Var<f64>]| {
        let function = MatVec {
            reversed: reversed.clone(),
        };
        Var::fused(function, &[&x[..1], &x[1..]])[0]
    };
    assert_eq!(gradient(product, &[2.0, 3.0]), [3.0, 2.0]);
    assert_eq!(Arc::strong_count(&reversed), 1);
}

/// A fused function that returns its input and bounds the cotangent in the reverse sweep.
struct Bounded(f64);

impl Fused for Bounded {
    type Saved<R: Real> = ();

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        inputs[0].to_vec()
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, ()) {
        (self.eval(inputs), ())
    }

    fn reverse<R: Real>(&self, (): &mut (), y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        let (zero, one) = (R::zero(), R::one());
        let norm = R::dot(y_bar, y_bar).sqrt();
        let scale = R::select(norm.less_equal(zero), one, (R::lit(self.0) / norm).min(one));
        vec![y_bar.iter().map(|&y_bar| y_bar * scale).collect()]
    }
}

#[test]
fn a_reverse_rule_may_bound_the_cotangent() {
    let through = |bound| {
        gradient(
            |x| {
                let y = Var::fused(Bounded(bound), &[x]);
                Var::lit(3.0) * y[0] + Var::lit(4.0) * y[1]
            },
            &[1.0, 1.0],
        )
    };
    assert_eq!(through(10.0), [3.0, 4.0]);
    // The norm of the cotangent (3, 4) is 5, so a bound of 2.5 halves it exactly.
    assert_eq!(through(2.5), [1.5, 2.0]);
}

/// The function `ln(e^a + e^b)` as a rule with given partials.
#[derive(Clone)]
struct LogSumExp;

impl Rule for LogSumExp {
    fn value<R: Real>(&self, x: &[R]) -> R {
        R::sum_of(&x.iter().map(|x| x.exp()).collect::<Vec<_>>()).ln()
    }

    fn partials<R: Real>(&self, x: &[R], value: R) -> Vec<R> {
        x.iter().map(|&x| (x - value).exp()).collect()
    }
}

struct Softest;

impl Function for Softest {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let scaled: Vec<R> = x.iter().map(|&x| x * R::lit(0.5)).collect();
        let value = apply(LogSumExp, &scaled);
        value * value
    }
}

#[test]
fn a_rule_gives_all_modes_and_their_nestings() {
    let plain = formula(4, |x| {
        let scaled: Vec<Sym> = x.iter().map(|&x| x * Sym::lit(0.5)).collect();
        let value = LogSumExp.value(&scaled);
        value * value
    });
    assert_same_derivatives(&Softest, &plain, &POINT);
    let mut tape = Tape::new();
    tape.record(&POINT, |x| apply(LogSumExp, x));
    assert_eq!(tape.len(), POINT.len() + 1, "a rule is one entry");
}

#[test]
fn a_rule_meets_zero_cotangents_as_functions_do() {
    /// The square root as a custom rule.
    #[derive(Clone)]
    struct Root;
    impl Rule for Root {
        fn value<R: Real>(&self, x: &[R]) -> R {
            x[0].sqrt()
        }
        fn partials<R: Real>(&self, _: &[R], value: R) -> Vec<R> {
            vec![R::lit(0.5) / value]
        }
    }
    struct Dropped;
    impl Function for Dropped {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            R::select(R::zero().less(x[0]), apply(Root, &x[..1]), x[1])
        }
    }
    assert_gradient(&Dropped, &[0.0, 1.0], &[0.0, 1.0]);
}

/// A function that takes weights, inputs and biases, and returns the outputs of a layer.
type Layer<R> = fn(&[R], &[R], &[R]) -> Vec<R>;

/// Two layers of a network on `x`, whose weights also depend on `x`.
fn layers<R: Real>(x: &[R], layer: Layer<R>) -> R {
    let constants: Vec<R> = (0..8).map(|k| R::lit(0.3 * f64::from(k) - 1.0)).collect();
    let hidden = layer(&constants, x, &[x[0], R::lit(0.2)]);
    let hidden: Vec<R> = hidden.into_iter().map(R::tanh).collect();
    let out = layer(&[x[1], x[2], x[1], R::one()], &hidden, &[R::zero(), x[3]]);
    out[0] * out[1]
}

struct Layers;

impl Function for Layers {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        layers(x, dense)
    }
}

#[test]
fn a_dense_layer_equals_its_written_out_form() {
    let written_out: Layer<Sym> = |weights, x, biases| {
        let row = |(row, &bias): (&[Sym], &Sym)| {
            row.iter().zip(x).map(|(&w, &x)| w * x).sum::<Sym>() + bias
        };
        weights.chunks_exact(x.len()).zip(biases).map(row).collect()
    };
    let plain = formula(4, |x| layers(x, written_out));
    assert_same_derivatives(&Layers, &plain, &POINT);
    assert_eq!(dense::<f64>(&[], &[], &[2.0, 3.0]), [2.0, 3.0]);
}

/// A rule for the root of `y^3 + y = x`. It is found by bisection, which is not differentiated. The partial follows
/// from the equation.
#[derive(Clone)]
struct Bisected;

impl Rule for Bisected {
    fn value<R: Real>(&self, x: &[R]) -> R {
        let (mut low, mut high) = (R::lit(-8.0), R::lit(8.0));
        for _ in 0..60 {
            let middle = R::lit(0.5) * (low + high);
            let below = (middle * middle * middle + middle).less(x[0]);
            low = R::select(below, middle, low);
            high = R::select(below, high, middle);
        }
        low
    }
    fn partials<R: Real>(&self, _: &[R], value: R) -> Vec<R> {
        vec![(R::one() + R::lit(3.0) * value * value).recip()]
    }
}

/// The same root by [`root`], as a function to differentiate.
#[derive(Clone)]
struct Solved;

impl Residual for Solved {
    fn eval<R: Real>(&self, y: &[R], x: &[R]) -> Vec<R> {
        vec![y[0] * y[0] * y[0] + y[0] - x[0]]
    }
}

struct Rooted;

impl Function for Rooted {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let y = apply(Bisected, &x[..1]);
        y * x[1] + y * x[2].sin()
    }
}

#[test]
fn the_value_of_a_rule_has_the_rule_s_derivative_in_nestings_too() {
    // Newton's method, whose iterations are differentiated.
    let iterated = formula(4, |x| {
        let [one, three] = [1.0, 3.0].map(Sym::lit);
        let newton = |y: Sym, _| y - (y * y * y + y - x[0]) / (three * y * y + one);
        let y = (0..20).fold(one, newton);
        y * x[1] + y * x[2].sin()
    });
    assert_same_derivatives(&Rooted, &iterated, &POINT);
}

/// A number that is constant on an inner tape may be a variable of the outer mode. Then it must keep its outer
/// derivative.
#[test]
fn constants_of_an_inner_tape_keep_their_outer_derivative() {
    /// Returns `d/dw (w y(p))`, computed on an inner tape on which `p` is a constant.
    fn inner<R: Real>(p: R, rule: bool) -> R {
        let of = |w: &[Var<R>]| {
            let p = [Var::constant(p)];
            let y = if rule {
                apply(Bisected, &p)
            } else {
                let start = Bisected.value(&[p[0].detach()]);
                root(Solved, &[start], &p).expect("an increasing residual")[0]
            };
            w[0] * y
        };
        gradient(of, &[R::one()])[0]
    }
    let y = Bisected.value(&[2.7]);
    let slope = Bisected.partials(&[2.7], y)[0];
    for rule in [true, false] {
        let dual = inner(Dual::<f64, 1>::variable(2.7, 0), rule);
        let taped = gradient(|p| inner(p[0], rule), &[2.7])[0];
        for by_p in [dual.tangent[0], taped] {
            assert!((by_p - slope).abs() < 1e-13, "{rule}: {by_p}, {slope}");
        }
    }
}

/// A function that returns the sum of squares of a layer's results for a batch of vectors.
struct Batch(usize);

fn batch_parts<R>(x: &[R], vectors: usize) -> [&[R]; 3] {
    [&x[..6], &x[6..8], &x[8..][..3 * vectors]]
}

impl Function for Batch {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [weights, biases, x] = batch_parts(x, self.0);
        let y = dense_batch(weights, x, biases);
        R::dot(&y, &y)
    }
}

#[test]
fn a_batch_is_its_vectors_one_by_one() {
    let x: Vec<f64> = (0..8 + 3 * 9).map(|i| (0.7 * f64::from(i)).sin()).collect();
    for vectors in [0, 1, 3, 9] {
        let single = formula(x.len(), |x| {
            let [weights, biases, x] = batch_parts(x, vectors);
            let row = |x: &[Sym], row: usize| Sym::dot(&weights[3 * row..][..3], x) + biases[row];
            let y = x.chunks_exact(3).flat_map(|x| [0, 1].map(|i| row(x, i)));
            let y: Vec<Sym> = y.collect();
            Sym::dot(&y, &y)
        });
        assert_same_derivatives(&Batch(vectors), &single, &x);
    }
}

/// Wherever an infinite number is in a batch, and whichever vector it belongs to, it must meet no zero cotangent.
#[test]
fn an_infinite_number_of_a_batch_meets_no_zero_cotangent() {
    const COLUMNS: usize = 20;
    for at in 0..3 * COLUMNS {
        let mut x = [Var::lit(1.0); 3 * COLUMNS];
        x[at] = Var::lit(f64::INFINITY);
        let other = (at / COLUMNS + 1) % 3;
        let layer = |weights: &[Var<f64>]| dense_batch(weights, &x, &[Var::lit(0.0)])[other];
        assert_eq!(gradient(layer, &[2.0; COLUMNS]), [1.0; COLUMNS], "{at}");
    }
}
