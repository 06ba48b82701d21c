//! Roots differentiated through their equations, against the iterations and differences.

use crate::common::{assert_close, differences, gradients};
use autodiff::implicit::{NoRoot, Residual, root, root_within};
use autodiff::simd::{Lane, Vectorized};
use autodiff::{
    DoubleDouble, Dual, Function, Real, Tape, Var, VectorFunction, gradient, hessian, jacobian, vjp,
};

/// Three coupled equations that lean on their diagonal, with two parameters.
#[derive(Clone)]
struct Coupled;

impl Residual for Coupled {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        vec![
            R::lit(4.0) * x[0] + (x[1] * p[0]).sin() - p[1],
            // The largest entries of the Jacobian lie off the diagonal: rows must be exchanged.
            x[2] * R::lit(5.0) + x[0] * x[0] - p[0] * p[1],
            x[1] * R::lit(3.0) + x[1].powi(3) + x[2] * p[1] - p[0].exp(),
        ]
    }
}

/// The root, solved by a contraction in the numbers of `p` themselves.
fn iterated<R: Real>(p: &[R]) -> Vec<R> {
    let mut x = vec![R::zero(); 3];
    for _ in 0..200 {
        let f = Coupled.eval(&x, p);
        x[0] -= R::lit(0.25) * f[0];
        x[2] -= R::lit(0.2) * f[1];
        x[1] -= R::lit(0.125) * f[2];
    }
    x
}

/// By the equations, or through all iterations.
#[derive(Clone, Copy)]
struct Solution {
    implicit: bool,
}

impl VectorFunction for Solution {
    fn eval<R: Real>(&self, p: &[R]) -> Vec<R> {
        if !self.implicit {
            return iterated(p);
        }
        let held: Vec<R> = p.iter().map(|p| p.detach()).collect();
        root(Coupled, &iterated(&held), p).expect("a regular root")
    }
}

/// A scalar of the root and the parameters.
impl Function for Solution {
    fn eval<R: Real>(&self, p: &[R]) -> R {
        let x = VectorFunction::eval(self, p);
        (x[0] * x[1]).exp() + x[2] * p[0]
    }
}

const POINT: [f64; 2] = [0.6, 1.1];
const IMPLICIT: Solution = Solution { implicit: true };
const UNROLLED: Solution = Solution { implicit: false };

/// Rounding of some fifty operations on numbers of order one.
const ROUNDING: f64 = 1e-14;

#[test]
fn jacobians_are_those_of_the_iterations() {
    let unrolled = jacobian(&UNROLLED, &POINT).into_vec();
    assert_close(&jacobian(&IMPLICIT, &POINT).into_vec(), &unrolled, ROUNDING);
    let weights = [0.3, -1.0, 2.0];
    let (_, p_bar) = vjp(&IMPLICIT, &POINT, &weights);
    assert_close(&p_bar, &vjp(&UNROLLED, &POINT, &weights).1, ROUNDING);
}

#[test]
fn gradients_agree_with_differences_in_every_mode_and_nesting() {
    let value = |p: &[f64]| vec![Function::eval(&UNROLLED, p)];
    let slopes = [0, 1].map(|i| differences(value, &POINT, i, f64::EPSILON.cbrt())[0]);
    for (_, gradient) in gradients(&IMPLICIT, &POINT) {
        // Truncation h^2 and rounding eps / h, 4e-11 each.
        assert_close(&gradient, &slopes, 1e-9);
    }
}

#[test]
fn second_and_third_derivatives_need_nothing_more() {
    let unrolled = hessian(&UNROLLED, &POINT).into_vec();
    assert_close(&hessian(&IMPLICIT, &POINT).into_vec(), &unrolled, ROUNDING);

    let third = |solution: &Solution| {
        let p = POINT.map(|p| Dual::<f64, 1>::variable(p, 0));
        let rows = hessian(solution, &p).into_vec();
        rows.iter().map(|h| h.tangent[0]).collect::<Vec<f64>>()
    };
    assert_close(&third(&IMPLICIT), &third(&UNROLLED), 10.0 * ROUNDING);
}

/// So many equations, each of an unknown and its neighbours in a ring.
#[derive(Clone, Copy)]
struct Ring {
    unknowns: usize,
    implicit: bool,
}

impl Residual for Ring {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        let n = self.unknowns;
        let entry = |i: usize| {
            let (before, after) = (x[(i + n - 1) % n], x[(i + 1) % n]);
            R::lit(4.0) * x[i] + p[0] * after.sin() - p[1] * before - R::lit(i as f64)
        };
        (0..n).map(entry).collect()
    }
}

impl VectorFunction for Ring {
    fn eval<R: Real>(&self, p: &[R]) -> Vec<R> {
        let iterated = |p: &[R]| {
            (0..200).fold(vec![R::zero(); self.unknowns], |x, _| {
                let f = Residual::eval(self, &x, p);
                let moved = x.iter().zip(f).map(|(&x, f)| x - R::lit(0.25) * f);
                moved.collect::<Vec<R>>()
            })
        };
        if !self.implicit {
            return iterated(p);
        }
        let held: Vec<R> = p.iter().map(|p| p.detach()).collect();
        root(*self, &iterated(&held), p).expect("a regular root")
    }
}

/// The Jacobian by the unknowns takes several passes, of which the last is not full.
#[test]
fn there_may_be_many_unknowns() {
    for unknowns in [1, 4, 5, 8, 11] {
        let [implicit, unrolled] = [true, false].map(|implicit| Ring { unknowns, implicit });
        let weights: Vec<f64> = (0..unknowns).map(|i| (i as f64).cos()).collect();
        let by_weights = |ring| vjp(&ring, &POINT, &weights).1;
        // Sums of as many terms.
        let tolerance = unknowns as f64 * ROUNDING;
        assert_close(&by_weights(implicit), &by_weights(unrolled), tolerance);
        let [implicit, unrolled] = [implicit, unrolled].map(|ring| jacobian(&ring, &POINT));
        assert_close(implicit.as_slice(), unrolled.as_slice(), tolerance);
    }
}

#[test]
fn wide_numbers_give_wide_derivatives() {
    let p = POINT.map(DoubleDouble::from);
    // Rounding of double-doubles, as above.
    assert_close(&gradient(&IMPLICIT, &p), &gradient(&UNROLLED, &p), 1e-29);
    let [implicit, unrolled] = [IMPLICIT, UNROLLED].map(|solution| jacobian(&solution, &p));
    assert_close(implicit.as_slice(), unrolled.as_slice(), 1e-29);
}

#[test]
fn the_tape_takes_the_root_as_one_entry() {
    let mut tape = Tape::new();
    let x = tape.record(&POINT, |p| VectorFunction::eval(&IMPLICIT, p));
    assert_eq!(tape.len(), 5, "two parameters, three unknowns");
    let values: Vec<f64> = x.iter().map(|x| x.value()).collect();
    assert_eq!(values, iterated(&POINT));
    // Parameters that are constants pass nothing and record nothing.
    let constant = [Var::constant(1.0); 2];
    assert!(VectorFunction::eval(&IMPLICIT, &constant)[0].is_constant());
}

#[test]
fn a_singular_root_is_an_error() {
    #[derive(Clone)]
    struct Double;
    impl Residual for Double {
        fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
            vec![x[0] - p[0], (x[1] - x[0]) * (x[1] - p[0])]
        }
    }
    let error = root(Double, &[1.0, 1.0], &[1.0]).expect_err("a double root");
    assert_eq!(error, NoRoot::Singular { unknown: 1 });
    assert!(error.to_string().contains("unknown 1 depends"), "{error}");
}

/// Two equations in units of their own, two unknowns too.
#[derive(Clone)]
struct InUnits([f64; 2], [f64; 2]);

impl Residual for InUnits {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        let [[e, f], [a, b]] = [self.0, self.1].map(|units| units.map(R::lit));
        let (x, y) = (a * x[0], b * x[1]);
        vec![e * (x + y - p[0]), f * (x - y)]
    }
}

#[test]
fn neither_units_of_equations_nor_of_unknowns_make_a_root_singular() {
    for size in [1e-200, 1e-16, 1.0, 1e16, 1e200] {
        for (equations, unknowns) in [([1.0, size], [1.0; 2]), ([1.0; 2], [1.0, size])] {
            let residual = InUnits(equations, unknowns);
            let p = [Dual::<f64, 1>::variable(2.0, 0)];
            let x = [1.0, 1.0 / unknowns[1]].map(Dual::constant);
            let root = root(residual, &x, &p).expect("half of it each");
            let slope = [root[0].tangent[0], root[1].tangent[0] * unknowns[1]];
            assert_close(&slope, &[0.5, 0.5], ROUNDING);
        }
    }
    // Nearly the same equation twice stays singular in any units.
    #[derive(Clone)]
    struct Twice(f64);
    impl Residual for Twice {
        fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
            let sum = R::lit(0.1) * x[0] + R::lit(0.3) * x[1] - p[0];
            vec![sum, R::lit(self.0) * sum]
        }
    }
    for size in [1e-200, 0.7, 1e200] {
        let error = root(Twice(size), &[1.0, 1.0], &[0.4]).expect_err("one equation");
        assert_eq!(error, NoRoot::Singular { unknown: 1 });
    }
}

#[test]
fn a_point_that_is_no_root_is_refused() {
    let at = |x: [f64; 2]| root(Turned, &x, &[0.5]);
    let exact = [0.8, 0.6];
    assert!(at(exact).is_ok());
    assert!(at([0.8 + 1e-6, 0.6]).is_ok());
    let error = at([0.8, 0.6 + 1e-4]).expect_err("a tenth of a thousandth away");
    assert!(matches!(error, NoRoot::Far { unknown: 1, .. }), "{error}");
    assert!(error.to_string().contains("no root"), "{error}");
    assert!(root_within(Turned, &[0.8, 0.6 + 1e-4], &[0.5], 1e-3).is_ok());
    assert!(at([f64::NAN, 0.6]).is_err());
    // Singles have fewer digits.
    assert!(root(Turned, &[0.8f32, 0.6 + 1e-4], &[0.5]).is_ok());
}

/// `p x0 + x1 = 1, x0 - p x1 = p`: rows are exchanged where `p` is below 1.
#[derive(Clone)]
struct Turned;

impl Residual for Turned {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        vec![p[0] * x[0] + x[1] - R::one(), x[0] - p[0] * x[1] - p[0]]
    }
}

fn turned_slope<R: Real>(p: R) -> R {
    // By Cramer's rule.
    let determinant = p * p + R::one();
    let x = [(p + p) / determinant, (R::one() - p * p) / determinant];
    let moving = [Dual::<R, 1>::variable(p, 0)];
    let x = root(Turned, &x.map(Dual::constant), &moving).expect("a regular matrix");
    x[0].tangent[0] + x[1].tangent[0] * p
}

#[test]
fn lanes_may_disagree_about_pivots() {
    struct InLanes([f64; 16]);
    impl Vectorized<f64> for InLanes {
        type Output = Vec<f64>;
        #[inline(always)]
        fn run<L: Lane<f64>>(self) -> Vec<f64> {
            let mut slopes = vec![0.0; L::N];
            turned_slope(L::load(&self.0)).store(&mut slopes);
            slopes
        }
    }
    let p: [f64; 16] = std::array::from_fn(|i| 0.1 + 0.35 * ((7 * i) % 16) as f64);
    for (lane, &p) in f64::vectorize(InLanes(p)).iter().zip(&p) {
        // The same operations, but for fused ones.
        assert_close(&[*lane], &[turned_slope(p)], ROUNDING);
        // The slope of x0 plus p times that of x1, by differences.
        let x = |p: &[f64]| vec![2.0 * p[0], 1.0 - p[0] * p[0]];
        let x = |p: &[f64]| x(p).iter().map(|x| x / (p[0] * p[0] + 1.0)).collect();
        let slopes = differences(x, &[p], 0, f64::EPSILON.cbrt());
        // Truncation h^2 and rounding eps / h, 4e-11 each, times derivatives of order 10.
        assert_close(&[*lane], &[slopes[0] + p * slopes[1]], 1e-8);
    }
}
