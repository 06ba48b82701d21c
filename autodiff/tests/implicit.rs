//! Derivatives of roots that follow from their equations. They are compared with those of unrolled iterations and with
//! difference quotients.

use crate::common::{Sym, assert_close, differences, formulas, gradients};
use autodiff::implicit::{NoRoot, Residual, root, root_within};
use autodiff::simd::{Lane, Vectorized};
use autodiff::{
    DoubleDouble, Dual, Function, Real, Tape, Var, gradient, hessian_vector, jacobian,
    jacobian_reverse, kernel,
};

/// Polynomial equations. Each equation is a list of terms: a factor, and the numbers to multiply it by, counted from
/// the first unknown to the last parameter. They are data, because each mode would compile written-out equations.
#[derive(Clone)]
struct Polynomials(Vec<Vec<(f64, Vec<usize>)>>);

impl Residual for Polynomials {
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        let all = [x, p].concat();
        let mut residual = vec![R::zero(); self.0.len()];
        for (sum, terms) in residual.iter_mut().zip(&self.0) {
            for (factor, numbers) in terms {
                *sum += numbers
                    .iter()
                    .fold(R::lit(*factor), |term, &k| term * all[k]);
            }
        }
        residual
    }
}

/// Returns three coupled equations. The largest entries of their Jacobian are off the diagonal, so rows must be
/// exchanged.
fn coupled() -> Polynomials {
    let [x, y, z, p, q] = [0, 1, 2, 3, 4];
    Polynomials(vec![
        vec![(4.0, vec![x]), (1.0, vec![y, y, p]), (-1.0, vec![q])],
        vec![(5.0, vec![z]), (1.0, vec![x, x]), (-1.0, vec![p, q])],
        vec![
            (3.0, vec![y]),
            (1.0, vec![y, y, y]),
            (1.0, vec![z, q]),
            (-1.5, vec![]),
            (-1.0, vec![p, p]),
        ],
    ])
}

/// Returns `n` equations that couple each unknown to its neighbours in a ring.
fn ring(n: usize) -> Polynomials {
    let equation = |i: usize| {
        let (before, after) = ((i + n - 1) % n, (i + 1) % n);
        vec![
            (4.0, vec![i]),
            (1.0, vec![n, after]),
            (-1.0, vec![n + 1, before]),
            (-(i as f64), vec![]),
        ]
    };
    Polynomials((0..n).map(equation).collect())
}

/// The root of a system of equations. If `implicit` is true, its derivatives follow from the equations. Otherwise it is
/// found by a contraction in the number type of `p`, whose iterations are differentiated.
#[derive(Clone)]
struct Solution {
    equations: Polynomials,
    /// For each equation, the unknown that the contraction changes by its residual, and the factor of this change.
    contraction: Vec<(usize, f64)>,
    implicit: bool,
}

impl Solution {
    fn both(equations: Polynomials, contraction: &[(usize, f64)]) -> [Self; 2] {
        [true, false].map(|implicit| Self {
            equations: equations.clone(),
            contraction: contraction.to_vec(),
            implicit,
        })
    }

    fn iterated<R: Real>(&self, p: &[R]) -> Vec<R> {
        let mut x = vec![R::zero(); self.contraction.len()];
        for _ in 0..200 {
            let residual = self.equations.eval(&x, p);
            for (&(place, by), f) in self.contraction.iter().zip(residual) {
                x[place] -= R::lit(by) * f;
            }
        }
        x
    }

    fn unknowns<R: Real>(&self, p: &[R]) -> Vec<R> {
        if !self.implicit {
            return self.iterated(p);
        }
        let held: Vec<R> = p.iter().map(|p| p.detach()).collect();
        root(self.equations.clone(), &self.iterated(&held), p).expect("a regular root")
    }
}

/// Combines the root and the parameters into a scalar.
impl Function for Solution {
    fn eval<R: Real>(&self, p: &[R]) -> R {
        let x = self.unknowns(p);
        x[0] * x[0] * x[1] + x[2] * p[0]
    }
}

/// Returns the solution of [`coupled`] twice: with implicit derivatives, and with unrolled iterations.
fn both() -> [Solution; 2] {
    Solution::both(coupled(), &[(0, 0.25), (2, 0.2), (1, 0.125)])
}

const POINT: [f64; 2] = [0.6, 1.1];

/// The rounding error of about fifty operations on numbers of order one.
const ROUNDING: f64 = 1e-14;

fn assert_same_jacobians([implicit, unrolled]: [Solution; 2], tolerance: f64) {
    let expected = jacobian(|p| unrolled.unknowns(p), &POINT).into_vec();
    let forward = jacobian(|p| implicit.unknowns(p), &POINT).into_vec();
    assert_close(&forward, &expected, tolerance);
    let reverse = jacobian_reverse(|p| implicit.unknowns(p), &POINT).into_vec();
    assert_close(&reverse, &expected, tolerance);
}

/// Implicit and unrolled Jacobians must agree in forward and in reverse mode. With many unknowns, the Jacobian of the
/// equations takes several passes, and the last pass is not full.
#[test]
fn jacobians_are_those_of_the_iterations() {
    assert_same_jacobians(both(), ROUNDING);
    for n in [1, 4, 5, 8, 11] {
        let contraction: Vec<_> = (0..n).map(|i| (i, 0.25)).collect();
        // The tolerance is for sums of `n` terms.
        let tolerance = n as f64 * ROUNDING;
        assert_same_jacobians(Solution::both(ring(n), &contraction), tolerance);
    }
}

#[test]
fn gradients_agree_with_differences_in_every_mode_and_nesting() {
    let [implicit, unrolled] = both();
    let value = |p: &[f64]| vec![unrolled.eval(p)];
    let slopes = [0, 1].map(|i| differences(value, &POINT, i, f64::EPSILON.cbrt())[0]);
    for (_, gradient) in gradients(&implicit, &POINT) {
        // The truncation error is h^2 and the rounding error is eps / h. Both are about 4e-11.
        assert_close(&gradient, &slopes, 1e-9);
    }
}

#[test]
fn second_and_third_derivatives_need_nothing_more() {
    // Products of the gradient with a direction, in duals along another direction, give second and third derivatives.
    let of = |solution: Solution| -> [Vec<f64>; 2] {
        let p = POINT.map(|p| Dual::<f64, 1>::variable(p, 0));
        let direction = [1.0, -0.5].map(Dual::constant);
        let (_, product) = hessian_vector(|p| solution.eval(p), &p, &direction);
        [
            product.iter().map(|h| h.value).collect(),
            product.iter().map(|h| h.tangent[0]).collect(),
        ]
    };
    let [implicit, unrolled] = both().map(of);
    assert_close(&implicit[0], &unrolled[0], ROUNDING);
    assert_close(&implicit[1], &unrolled[1], 10.0 * ROUNDING);
}

#[test]
fn wide_numbers_give_wide_derivatives() {
    let p = POINT.map(DoubleDouble::from);
    let [implicit, unrolled] = both().map(|solution| {
        let rows = jacobian(|p| solution.unknowns(p), &p).into_vec();
        [gradient(|p| solution.eval(p), &p), rows].concat()
    });
    // The tolerance is for about fifty operations in double-double.
    assert_close(&implicit, &unrolled, 1e-29);
}

#[test]
fn the_tape_takes_the_root_as_one_entry() {
    let [implicit, unrolled] = both();
    let mut tape = Tape::new();
    let x = tape.record(&POINT, |p| implicit.unknowns(p));
    assert_eq!(tape.len(), 5, "two parameters, three unknowns");
    let values: Vec<f64> = x.iter().map(|x| x.value()).collect();
    assert_eq!(values, unrolled.unknowns(&POINT));
    // Constant parameters pass no derivative and record nothing.
    let constant = [Var::constant(1.0); 2];
    assert!(implicit.unknowns(&constant)[0].is_constant());
}

#[test]
fn a_singular_root_is_an_error() {
    let double = formulas(3, |x| vec![x[0] - x[2], (x[1] - x[0]) * (x[1] - x[2])]);
    let error = root(double, &[1.0, 1.0], &[1.0]).expect_err("a double root");
    assert_eq!(error, NoRoot::Singular { unknown: 1 });
    assert!(error.to_string().contains("unknown 1 depends"), "{error}");
}

#[test]
fn units_of_equations_and_unknowns_do_not_make_a_root_singular() {
    for size in [1e-200, 1e-16, 1.0, 1e16, 1e200] {
        for ([e, f], [a, b]) in [([1.0, size], [1.0; 2]), ([1.0; 2], [1.0, size])] {
            let in_units = formulas(3, |all| {
                let [e, f, a, b] = [e, f, a, b].map(Sym::lit);
                let (x, y) = (a * all[0], b * all[1]);
                vec![e * (x + y - all[2]), f * (x - y)]
            });
            let p = [Dual::<f64, 1>::variable(2.0, 0)];
            let x = [1.0, 1.0 / b].map(Dual::constant);
            let root = root(in_units, &x, &p).expect("half of it each");
            let slope = [root[0].tangent[0], root[1].tangent[0] * b];
            assert_close(&slope, &[0.5, 0.5], ROUNDING);
        }
    }
    // Two nearly equal equations stay singular in any units.
    for size in [1e-200, 0.7, 1e200] {
        let twice = formulas(3, |x| {
            let sum = Sym::lit(0.1) * x[0] + Sym::lit(0.3) * x[1] - x[2];
            vec![sum, Sym::lit(size) * sum]
        });
        let error = root(twice, &[1.0, 1.0], &[0.4]).expect_err("one equation");
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
