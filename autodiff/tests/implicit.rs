//! Derivatives of roots that follow from their equations. They are compared with those of unrolled iterations and with
//! difference quotients.

use crate::common::{assert_close, differences, gradients};
use autodiff::implicit::{NoRoot, Residual, root, root_within};
use autodiff::simd::{Lane, Vectorized, kernel};
use autodiff::{
    DoubleDouble, Dual, Function, Real, Tape, Var, gradient, hessian_vector, jacobian,
    jacobian_reverse, lit,
};

/// Systems of equations for several unknowns, with two parameters.
#[derive(Clone, Copy)]
enum Equations {
    /// Three coupled equations. The largest entries of their Jacobian are off the diagonal, so rows must be exchanged.
    Coupled,
    /// As many equations as this, which couple each unknown to its neighbours in a ring.
    Ring(usize),
}

impl Residual for Equations {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        match *self {
            Self::Coupled => vec![
                lit(4.0) * x[0] + x[1] * x[1] * p[0] - p[1],
                lit(5.0) * x[2] + x[0] * x[0] - p[0] * p[1],
                lit(3.0) * x[1] + x[1] * x[1] * x[1] + x[2] * p[1] - lit(1.5) - p[0] * p[0],
            ],
            Self::Ring(n) => {
                let equation = |i: usize| {
                    let (before, after) = (x[(i + n - 1) % n], x[(i + 1) % n]);
                    lit(4.0) * x[i] + p[0] * after - p[1] * before - R::lit(i as f64)
                };
                (0..n).map(equation).collect()
            }
        }
    }
}

impl Equations {
    /// The root, by the iterations of a contraction.
    fn iterated<R: Real>(self, p: &[R]) -> Vec<R> {
        // For each equation, the unknown that its residual changes, and the factor of this change.
        let contraction = match self {
            Self::Coupled => vec![(0, 0.25), (2, 0.2), (1, 0.125)],
            Self::Ring(n) => (0..n).map(|i| (i, 0.25)).collect(),
        };
        let mut x = vec![R::zero(); contraction.len()];
        for _ in 0..200 {
            let residual = self.eval(&x, p);
            for (&(place, by), f) in contraction.iter().zip(residual) {
                x[place] -= R::lit(by) * f;
            }
        }
        x
    }

    /// The root, whose derivatives follow from the equations.
    fn unknowns<R: Real>(self, p: &[R]) -> Vec<R> {
        let held: Vec<R> = p.iter().map(|p| p.detach()).collect();
        root(self, &self.iterated(&held), p).expect("a regular root")
    }
}

/// A scalar that combines the root of the coupled equations and the parameters. If `unrolled` is true, its
/// derivatives are those of the iterations.
struct Combined {
    unrolled: bool,
}

impl Function for Combined {
    fn eval<R: Real>(&self, p: &[R]) -> R {
        let x = match self.unrolled {
            true => Equations::Coupled.iterated(p),
            false => Equations::Coupled.unknowns(p),
        };
        x[0] * x[0] * x[1] + x[2] * p[0]
    }
}

const IMPLICIT: Combined = Combined { unrolled: false };
const UNROLLED: Combined = Combined { unrolled: true };

const POINT: [f64; 2] = [0.6, 1.1];

/// The rounding error of about fifty operations on numbers of order one.
const ROUNDING: f64 = 1e-14;

fn assert_same_jacobians(equations: Equations, tolerance: f64) {
    let expected = jacobian(|p| equations.iterated(p), &POINT).into_vec();
    let forward = jacobian(|p| equations.unknowns(p), &POINT).into_vec();
    assert_close(&forward, &expected, tolerance);
    let reverse = jacobian_reverse(|p| equations.unknowns(p), &POINT).into_vec();
    assert_close(&reverse, &expected, tolerance);
}

/// Implicit and unrolled Jacobians must agree in forward and in reverse mode. With many unknowns, the Jacobian of the
/// equations takes several passes, and the last pass is not full.
#[test]
fn jacobians_are_those_of_the_iterations() {
    assert_same_jacobians(Equations::Coupled, ROUNDING);
    for n in [1, 4, 5, 8, 11] {
        // The tolerance is for sums of `n` terms.
        assert_same_jacobians(Equations::Ring(n), n as f64 * ROUNDING);
    }
}

#[test]
fn gradients_agree_with_differences_in_every_mode_and_nesting() {
    let value = |p: &[f64]| vec![UNROLLED.eval(p)];
    let slopes = [0, 1].map(|i| differences(value, &POINT, i, f64::EPSILON.cbrt())[0]);
    for (_, gradient) in gradients(&IMPLICIT, &POINT) {
        // The truncation error is h^2 and the rounding error is eps / h. Both are about 4e-11.
        assert_close(&gradient, &slopes, 1e-9);
    }
}

/// Products of the gradient with a direction, in duals along another direction, give second and third derivatives.
fn second_and_third(function: &impl Function) -> [Vec<f64>; 2] {
    let p = POINT.map(|p| Dual::<f64, 1>::variable(p, 0));
    let direction = [1.0, -0.5].map(Dual::constant);
    let (_, product) = hessian_vector(|p| function.eval(p), &p, &direction);
    let third = product.iter().map(|h| h.tangent[0]).collect();
    [product.iter().map(|h| h.value).collect(), third]
}

#[test]
fn second_and_third_derivatives_need_nothing_more() {
    let [second, third] = second_and_third(&IMPLICIT);
    let expected = second_and_third(&UNROLLED);
    assert_close(&second, &expected[0], ROUNDING);
    assert_close(&third, &expected[1], 10.0 * ROUNDING);
}

#[test]
fn wide_numbers_give_wide_derivatives() {
    let p = POINT.map(DoubleDouble::from);
    let slopes = gradient(|p| IMPLICIT.eval(p), &p);
    // The tolerance is for about fifty operations in double-double.
    assert_close(&slopes, &gradient(|p| UNROLLED.eval(p), &p), 1e-29);
}

#[test]
fn each_unknown_of_a_root_is_one_entry_of_the_tape() {
    let mut tape = Tape::new();
    let x = tape.record(&POINT, |p| Equations::Coupled.unknowns(p));
    assert_eq!(tape.len(), 5, "two parameters, three unknowns");
    let values: Vec<f64> = x.iter().map(|x| x.value()).collect();
    assert_eq!(values, Equations::Coupled.iterated(&POINT));
    // Constant parameters pass no derivative and record nothing.
    let constant = [Var::constant(1.0); 2];
    assert!(Equations::Coupled.unknowns(&constant)[0].is_constant());
}

/// Systems of two equations with one parameter.
#[derive(Clone)]
enum Pair {
    /// The second equation has a double root.
    Double,
    /// The units of the equations and of the unknowns.
    InUnits([f64; 4]),
    /// The second equation is the first one in another unit.
    Twice(f64),
}

impl Residual for Pair {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        match *self {
            Self::Double => vec![x[0] - p[0], (x[1] - x[0]) * (x[1] - p[0])],
            Self::InUnits(units) => {
                let [e, f, a, b] = units.map(R::lit);
                let (x, y) = (a * x[0], b * x[1]);
                vec![e * (x + y - p[0]), f * (x - y)]
            }
            Self::Twice(unit) => {
                let sum = lit(0.1) * x[0] + lit(0.3) * x[1] - p[0];
                vec![sum, R::lit(unit) * sum]
            }
        }
    }
}

#[test]
fn a_singular_root_is_an_error() {
    let error = root(Pair::Double, &[1.0, 1.0], &[1.0]).expect_err("a double root");
    assert_eq!(error, NoRoot::Singular { unknown: 1 });
    assert!(error.to_string().contains("unknown 1 depends"), "{error}");
}

#[test]
fn units_of_equations_and_unknowns_do_not_make_a_root_singular() {
    for size in [1e-200, 1e-16, 1.0, 1e16, 1e200] {
        for ([e, f], [a, b]) in [([1.0, size], [1.0; 2]), ([1.0; 2], [1.0, size])] {
            let in_units = Pair::InUnits([e, f, a, b]);
            let p = [Dual::<f64, 1>::variable(2.0, 0)];
            let x = [1.0, 1.0 / b].map(Dual::constant);
            let root = root(in_units, &x, &p).expect("half of it each");
            let slope = [root[0].tangent[0], root[1].tangent[0] * b];
            assert_close(&slope, &[0.5, 0.5], ROUNDING);
        }
    }
    // Two nearly equal equations stay singular in any units.
    for size in [1e-200, 0.7, 1e200] {
        let error = root(Pair::Twice(size), &[1.0, 1.0], &[0.4]).expect_err("one equation");
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
    assert!(error.to_string().contains("not a root"), "{error}");
    // On a tape, the message has the same numbers.
    let recorded = gradient(
        |p| {
            let x = Var::lits(&[0.8, 0.6 + 1e-4]);
            assert_eq!(
                root(Turned, &x, p).expect_err("far away").to_string(),
                error.to_string()
            );
            p[0]
        },
        &[0.5],
    );
    assert_eq!(recorded, [1.0]);
    assert!(root_within(Turned, &[0.8, 0.6 + 1e-4], &[0.5], 1e-3).is_ok());
    assert!(at([f64::NAN, 0.6]).is_err());
    // Single precision has fewer digits, so the same point is accepted.
    assert!(root(Turned, &[0.8f32, 0.6 + 1e-4], &[0.5]).is_ok());
}

/// The equations `p x0 + x1 = 1` and `x0 - p x1 = p`. If `p` is below 1, rows are exchanged.
#[derive(Clone)]
struct Turned;

impl Residual for Turned {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        vec![p[0] * x[0] + x[1] - R::one(), x[0] - p[0] * x[1] - p[0]]
    }
}

fn turned_slope<R: Real>(p: R) -> R {
    // The solution by Cramer's rule.
    let determinant = p * p + R::one();
    let x = [(p + p) / determinant, (R::one() - p * p) / determinant];
    let moving = [Dual::<R, 1>::variable(p, 0)];
    let x = root(Turned, &x.map(Dual::constant), &moving).expect("a regular matrix");
    x[0].tangent[0] + x[1].tangent[0] * p
}

#[test]
fn lanes_may_disagree_about_pivots() {
    struct InLanes([f64; 16]);
    #[kernel]
    impl Vectorized<f64> for InLanes {
        type Output = Vec<f64>;
        fn run<L: Lane<f64>>(self) -> Vec<f64> {
            let mut slopes = vec![0.0; L::N];
            turned_slope(L::load(&self.0)).store(&mut slopes);
            slopes
        }
    }
    let p: [f64; 16] = std::array::from_fn(|i| 0.1 + 0.35 * ((7 * i) % 16) as f64);
    for (lane, &p) in f64::vectorize(InLanes(p)).iter().zip(&p) {
        // The two slopes come from the same operations, except for fused multiply-adds.
        assert_close(&[*lane], &[turned_slope(p)], ROUNDING);
        // The expected value is the slope of x0 plus p times the slope of x1, by differences.
        let x = |p: &[f64]| vec![2.0 * p[0], 1.0 - p[0] * p[0]];
        let x = |p: &[f64]| x(p).iter().map(|x| x / (p[0] * p[0] + 1.0)).collect();
        let slopes = differences(x, &[p], 0, f64::EPSILON.cbrt());
        // The truncation error is h^2 and the rounding error is eps / h, about 4e-11 each. The derivatives of order 10
        // multiply both.
        assert_close(&[*lane], &[slopes[0] + p * slopes[1]], 1e-8);
    }
}
