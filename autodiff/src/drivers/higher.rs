//! Computes derivatives of the third and of higher orders.

use super::dense::Dense;
use super::gradient::swept;
use super::seed::along;
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::Var;

/// A dual number of a dual number, which carries derivatives up to the second order.
pub type Dual2<R> = Dual<Dual<R, 1>, 1>;

/// Three nested dual numbers, which carry derivatives up to the third order.
pub type Dual3<R> = Dual<Dual2<R>, 1>;

/// Returns the value and the slope of a function of one number, by one forward pass.
///
/// ```
/// use autodiff::{Real, value_and_derivative};
///
/// // Newton's method for `cos(x) = x`.
/// let mut x = 1.0_f64;
/// for _ in 0..5 {
///     let (value, slope) = value_and_derivative(|x| x.cos() - x, x);
///     x -= value / slope;
/// }
/// assert!((x.cos() - x).abs() < 1e-15);
/// ```
#[track_caller]
pub fn value_and_derivative<R: Real>(
    function: impl FnOnce(Dual<R, 1>) -> Dual<R, 1>,
    x: R,
) -> (R, R) {
    let y = function(Dual::variable(x, 0));
    (y.value, y.tangent[0])
}

/// Returns the value and the first three derivatives of a function of one number, by one forward pass. Nested in itself or
/// in another driver, it gives derivatives of higher orders.
///
/// ```
/// use autodiff::{Real, derivatives};
///
/// assert_eq!(derivatives(|x| x.powi(4), 2.0), [16.0, 32.0, 48.0, 48.0]);
///
/// // Halley's method for `cos(x) = x`, which triples the number of correct digits in each step.
/// let mut x = 1.0_f64;
/// for _ in 0..3 {
///     let [value, slope, second, _] = derivatives(|x| x.cos() - x, x);
///     x -= value * slope / (slope * slope - 0.5 * value * second);
/// }
/// assert!((x.cos() - x).abs() < 1e-15);
/// ```
#[track_caller]
pub fn derivatives<R: Real>(function: impl FnOnce(Dual3<R>) -> Dual3<R>, x: R) -> [R; 4] {
    orders(function(moving(x, R::one())))
}

/// Returns the values at `x` and their first three derivatives along `direction`, by one forward pass: the derivatives of
/// `function(x + t direction)` with respect to `t` at 0. The first of them is that of [`jvp`](crate::jvp).
///
/// Chebyshev's method for several equations corrects the step of Newton's method by the second derivative along it:
///
/// ```
/// use autodiff::{Real, derivatives_along, value_and_jacobian_array};
///
/// // The circle `x^2 + y^2 = 1` and the curve `y = x^3`.
/// fn equations<R: Real>(x: &[R]) -> Vec<R> {
///     vec![x[0] * x[0] + x[1] * x[1] - R::one(), x[1] - x[0].powi(3)]
/// }
/// let solved = |[[a, b], [c, d]]: [[f64; 2]; 2], y: &[f64]| {
///     let determinant = a * d - b * c;
///     [(d * y[0] - b * y[1]) / determinant, (a * y[1] - c * y[0]) / determinant]
/// };
///
/// let mut x = [1.0, 0.5];
/// for _ in 0..4 {
///     let (_, jacobian) =
///         value_and_jacobian_array(|x| [0, 1].map(|i| equations(x)[i]), x);
///     let newton = solved(jacobian, &equations(&x)).map(|step| -step);
///     let [_, _, second, _] = derivatives_along(equations, &x, &newton);
///     let correction = solved(jacobian, &second);
///     for i in 0..2 {
///         x[i] += newton[i] - 0.5 * correction[i];
///     }
/// }
/// assert!(equations(&x).iter().all(|rest| rest.abs() < 1e-15));
/// ```
///
/// # Panics
/// If `x` and `direction` differ in length.
#[track_caller]
pub fn derivatives_along<R: Real>(
    function: impl FnOnce(&[Dual3<R>]) -> Vec<Dual3<R>>,
    x: &[R],
    direction: &[R],
) -> [Vec<R>; 4] {
    let moved = along(x, direction).into_iter();
    let moved: Vec<_> = moved.map(|x| moving(x.value, x.tangent[0])).collect();
    let y = function(&moved);
    let order = |k: usize| y.iter().map(|&y| orders(y)[k]).collect();
    [0, 1, 2, 3].map(order)
}

/// Returns `x + t direction` at `t = 0` as a number that carries three derivatives with respect to `t`.
fn moving<R: Real>(x: R, direction: R) -> Dual3<R> {
    let first = |value| Dual {
        value,
        tangent: [direction],
    };
    Dual {
        value: Dual {
            value: first(x),
            tangent: [Dual::constant(direction)],
        },
        tangent: [Dual::constant(Dual::constant(direction))],
    }
}

/// Returns the value of a number and its three derivatives with respect to `t`.
fn orders<R: Real>(y: Dual3<R>) -> [R; 4] {
    let [first, third] = [y.value, y.tangent[0]];
    [
        first.value.value,
        first.value.tangent[0],
        first.tangent[0].tangent[0],
        third.tangent[0].tangent[0],
    ]
}

/// The value of a scalar function and its partial derivatives up to the third order; see [`third_derivatives`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ThirdDerivatives<R> {
    /// The value.
    pub value: R,
    /// The first derivatives, one per argument.
    pub gradient: Vec<R>,
    /// The second derivatives, with one row and one column per argument.
    pub hessian: Dense<R>,
    /// The third derivatives: for each pair of arguments `i <= j`, ordered by `j` and then by `i`, one per argument.
    third: Vec<R>,
}

impl<R: Real> ThirdDerivatives<R> {
    /// Returns the third derivative with respect to three arguments, in any order.
    ///
    /// # Panics
    /// If there is no such argument.
    #[track_caller]
    pub fn third(&self, i: usize, j: usize, k: usize) -> R {
        let n = self.gradient.len();
        let mut sorted = [i, j, k];
        sorted.sort_unstable();
        let [first, second, last] = sorted;
        assert!(
            last < n,
            "argument {last} is out of range: the function has {n} arguments"
        );
        self.third[pair(first, second) * n + last]
    }
}

/// The index of a pair of arguments `i <= j`.
fn pair(i: usize, j: usize) -> usize {
    j * (j + 1) / 2 + i
}

/// Returns the value of a scalar function at `x` and all partial derivatives up to the third order, by forward over
/// forward over reverse mode. For `n` arguments this takes `n (n + 1) / 2` gradients of dual numbers.
///
/// ```
/// use autodiff::{Real, third_derivatives};
///
/// /// The free energy of a van der Waals gas in reduced units, of temperature and volume. Its negative derivative with
/// /// respect to the volume is the pressure.
/// fn free_energy<R: Real>(x: &[R]) -> R {
///     let (t, v) = (x[0], x[1]);
///     -(t * (v - R::one()).ln()) - v.recip()
/// }
///
/// // At the critical point, the first two derivatives of the pressure are 0.
/// let (t, v) = (0, 1);
/// let at = third_derivatives(free_energy, &[8.0 / 27.0, 3.0]);
/// assert!((-at.gradient[v] - 1.0 / 27.0_f64).abs() < 1e-16);
/// assert!(at.hessian[v][v].abs() < 1e-16 && at.third(v, v, v).abs() < 1e-16);
/// assert_eq!((at.hessian[t][v], at.third(v, t, v)), (-0.5, 0.25));
/// ```
#[track_caller]
pub fn third_derivatives<R: Real>(
    function: impl Fn(&[Var<Dual2<R>>]) -> Var<Dual2<R>>,
    x: &[R],
) -> ThirdDerivatives<R> {
    all_passes(&function, x)
}

/// A variable that carries two derivatives.
type Moving<R> = Var<Dual2<R>>;

/// Implements [`third_derivatives`] for a function behind a reference, so that it is compiled once per number type.
#[track_caller]
fn all_passes<R: Real>(
    function: &dyn Fn(&[Moving<R>]) -> Moving<R>,
    x: &[R],
) -> ThirdDerivatives<R> {
    let (n, mut value) = (x.len(), R::zero());
    let (mut gradient, mut hessian) = (vec![R::zero(); n], vec![R::zero(); n * n]);
    let mut third = Vec::with_capacity(n * pair(0, n));
    for j in 0..n.max(1) {
        for i in 0..=j {
            let take = &mut |slopes: &[Dual2<R>]| {
                for (k, slope) in slopes.iter().enumerate() {
                    gradient[k] = slope.value.value;
                    // Both triangles get the same number.
                    if i == j && k <= j {
                        hessian[j * n + k] = slope.value.tangent[0];
                        hessian[k * n + j] = slope.value.tangent[0];
                    }
                    third.push(slope.tangent[0].tangent[0]);
                }
            };
            value = swept(Box::new(function), &nested(x, i, j), take)
                .value
                .value;
        }
    }
    ThirdDerivatives {
        value,
        gradient,
        hessian: Dense::new(n, n, hessian),
        third,
    }
}

/// Returns `x` as nested dual numbers. Argument `i` moves the inner ones, argument `j` the outer ones.
fn nested<R: Real>(x: &[R], i: usize, j: usize) -> Vec<Dual2<R>> {
    let mut nested: Vec<Dual2<R>> = x
        .iter()
        .map(|&x| Dual::constant(Dual::constant(x)))
        .collect();
    if !x.is_empty() {
        nested[i].value.tangent[0] = R::one();
        nested[j].tangent[0].value = R::one();
    }
    nested
}
