//! Derivatives of roots that follow from their equations. They are compared with those of unrolled iterations and with
//! difference quotients.

use crate::common::{Formula, Sym, assert_close, differences, formula, formulas, gradients};
use autodiff::implicit::{NoRoot, Residual, root, root_within};
use autodiff::simd::{Lane, Vectorized};
use autodiff::{
    DoubleDouble, Dual, Function, Real, Tape, Var, gradient, hessian_vector, jacobian,
    jacobian_reverse, kernel,
};

/// A system of equations, and the iterations of a contraction that find its root. Both are formulas, because each mode
/// would compile written-out equations.
#[derive(Clone)]
struct Solution {
    equations: Formula,
    iterated: Formula,
}

impl Solution {
    /// `contraction` has for each equation the unknown that its residual changes, and the factor of this change.
    fn new(
        parameters: usize,
        equations: impl Fn(&[Sym]) -> Vec<Sym>,
        contraction: &[(usize, f64)],
    ) -> Self {
        let unknowns = contraction.len();
        let iterated = formulas(parameters, |p| {
            let mut x = vec![Sym::lit(0.0); unknowns];
            for _ in 0..200 {
                let residual = equations(&[&x, p].concat());
                for (&(place, by), f) in contraction.iter().zip(residual) {
                    x[place] -= Sym::lit(by) * f;
                }
            }
            x
        });
        Self {
            equations: formulas(unknowns + parameters, equations),
            iterated,
        }
    }

    /// The root, whose derivatives follow from the equations.
    fn unknowns<R: Real>(&self, p: &[R]) -> Vec<R> {
        let held: Vec<R> = p.iter().map(|p| p.detach()).collect();
        root(self.equations.clone(), &self.iterated.values(&held), p).expect("a regular root")
    }
}

/// Combines the root and the parameters into a scalar.
fn combined<R: Real>(x: &[R], p: &[R]) -> R {
    x[0] * x[0] * x[1] + x[2] * p[0]
}

impl Function for Solution {
    fn eval<R: Real>(&self, p: &[R]) -> R {
        combined(&self.unknowns(p), p)
    }
}

/// Returns three coupled equations. The largest entries of their Jacobian are off the diagonal, so rows must be
/// exchanged.
fn coupled() -> Solution {
    let equations = |all: &[Sym]| {
        let [x, y, z, p, q] = [0, 1, 2, 3, 4].map(|k| all[k]);
        let [three, four, five] = [3.0, 4.0, 5.0].map(Sym::lit);
        vec![
            four * x + y * y * p - q,
            five * z + x * x - p * q,
            three * y + y * y * y + z * q - Sym::lit(1.5) - p * p,
        ]
    };
    Solution::new(2, equations, &[(0, 0.25), (2, 0.2), (1, 0.125)])
}

/// Returns `n` equations that couple each unknown to its neighbours in a ring.
fn ring(n: usize) -> Solution {
    let equations = move |x: &[Sym]| {
        let equation = |i: usize| {
            let (before, after) = (x[(i + n - 1) % n], x[(i + 1) % n]);
            Sym::lit(4.0) * x[i] + x[n] * after - x[n + 1] * before - Sym::lit(i as f64)
        };
        (0..n).map(equation).collect()
    };
    let contraction: Vec<_> = (0..n).map(|i| (i, 0.25)).collect();
    Solution::new(2, equations, &contraction)
}

const POINT: [f64; 2] = [0.6, 1.1];

/// The rounding error of about fifty operations on numbers of order one.
const ROUNDING: f64 = 1e-14;

fn assert_same_jacobians(solution: Solution, tolerance: f64) {
    let expected = jacobian(|p| solution.iterated.values(p), &POINT).into_vec();
    let forward = jacobian(|p| solution.unknowns(p), &POINT).into_vec();
    assert_close(&forward, &expected, tolerance);
    let reverse = jacobian_reverse(|p| solution.unknowns(p), &POINT).into_vec();
    assert_close(&reverse, &expected, tolerance);
}

/// Implicit and unrolled Jacobians must agree in forward and in reverse mode. With many unknowns, the Jacobian of the
/// equations takes several passes, and the last pass is not full.
#[test]
fn jacobians_are_those_of_the_iterations() {
    assert_same_jacobians(coupled(), ROUNDING);
    for n in [1, 4, 5, 8, 11] {
        // The tolerance is for sums of `n` terms.
        assert_same_jacobians(ring(n), n as f64 * ROUNDING);
    }
}

/// Returns a system of equations, and the same function with unrolled iterations.
fn both() -> (Solution, Formula) {
    let implicit = coupled();
    let unrolled = formula(2, |p| combined(&implicit.iterated.values(p), p));
    (implicit, unrolled)
}

#[test]
fn gradients_agree_with_differences_in_every_mode_and_nesting() {
    let (implicit, unrolled) = both();
    let value = |p: &[f64]| unrolled.values(p);
    let slopes = [0, 1].map(|i| differences(value, &POINT, i, f64::EPSILON.cbrt())[0]);
    for (_, gradient) in gradients(&implicit, &POINT) {
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
    let (implicit, unrolled) = both();
    let [second, third] = second_and_third(&implicit);
    let expected = second_and_third(&unrolled);
    assert_close(&second, &expected[0], ROUNDING);
    assert_close(&third, &expected[1], 10.0 * ROUNDING);
}

#[test]
fn wide_numbers_give_wide_derivatives() {
    let ((implicit, unrolled), p) = (both(), POINT.map(DoubleDouble::from));
    let slopes = gradient(|p| implicit.eval(p), &p);
    // The tolerance is for about fifty operations in double-double.
    assert_close(&slopes, &gradient(|p| unrolled.values(p)[0], &p), 1e-29);
}

#[test]
fn the_tape_takes_the_root_as_one_entry() {
    let implicit = coupled();
    let mut tape = Tape::new();
    let x = tape.record(&POINT, |p| implicit.unknowns(p));
    assert_eq!(tape.len(), 5, "two parameters, three unknowns");
    let values: Vec<f64> = x.iter().map(|x| x.value()).collect();
    assert_eq!(values, implicit.iterated.values(&POINT));
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
