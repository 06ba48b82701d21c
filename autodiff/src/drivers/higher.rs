//! Computes derivatives of the third and of higher orders.

use super::dense::Dense;
use super::gradient::swept;
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::Var;

/// A dual number of a dual number, which carries derivatives up to the second order.
pub type Dual2<R> = Dual<Dual<R, 1>, 1>;

/// Three nested dual numbers, which carry derivatives up to the third order.
pub type Dual3<R> = Dual<Dual2<R>, 1>;

/// Nested dual numbers along one direction, as [`derivatives`] needs them: [`Dual2`], [`Dual3`] or deeper nestings.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a nesting of dual numbers with one direction each",
    note = "use `Dual2<f64>` for two derivatives, `Dual3<f64>` for three, and `Dual<Dual3<f64>, 1>` for four"
)]
pub trait Nested: Real {
    /// The number type inside all dual numbers.
    type Base: Real;
    /// The number of nested dual numbers, which is the highest order of the derivatives.
    const ORDER: usize;

    /// Makes the variable with respect to which all nested dual numbers differentiate.
    fn variable_at(x: Self::Base) -> Self;

    /// Returns the derivative of this order. Order 0 is the value.
    ///
    /// # Panics
    /// If `order` is larger than [`ORDER`](Nested::ORDER).
    #[track_caller]
    fn derivative(self, order: usize) -> Self::Base;
}

impl<D: Nested> Nested for Dual<D, 1> {
    type Base = D::Base;
    const ORDER: usize = D::ORDER + 1;

    fn variable_at(x: D::Base) -> Self {
        Dual::variable(D::variable_at(x), 0)
    }

    #[track_caller]
    fn derivative(self, order: usize) -> D::Base {
        match order {
            0 => self.value.derivative(0),
            _ => self.tangent[0].derivative(order - 1),
        }
    }
}

/// Implements [`Nested`] for a number type that is not a dual number.
macro_rules! innermost {
    ($([$($generics:tt)*] $number:ty),*) => {
        $(
            impl<$($generics)*> Nested for $number {
                type Base = Self;
                const ORDER: usize = 0;
                fn variable_at(x: Self) -> Self {
                    x
                }
                #[track_caller]
                fn derivative(self, order: usize) -> Self {
                    assert!(
                        order == 0,
                        "the order of a derivative must be at most the number of nested dual numbers"
                    );
                    self
                }
            }
        )*
    };
}
innermost! { [] f64, [] f32, [R: Real] Var<R> }

/// Returns the value and all derivatives of a function of one number, up to the order of the nested dual numbers that
/// the function takes. The cost doubles with each order.
///
/// ```
/// use autodiff::{Dual3, Real, derivatives};
///
/// let [value, first, second, third] = derivatives(|x: Dual3<f64>| x.powi(4), 2.0);
/// assert_eq!([value, first, second, third], [16.0, 32.0, 48.0, 48.0]);
/// ```
///
/// The array has one number per order, from 0 on. Another length does not compile.
#[track_caller]
pub fn derivatives<D: Nested, const N: usize>(
    function: impl FnOnce(D) -> D,
    x: D::Base,
) -> [D::Base; N] {
    const {
        assert!(
            N == D::ORDER + 1,
            "`derivatives` returns the value and one derivative per nested dual number"
        );
    }
    let y = function(D::variable_at(x));
    std::array::from_fn(|order| y.derivative(order))
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
            value = swept(Box::new(function), &seeded(x, i, j), take)
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
fn seeded<R: Real>(x: &[R], i: usize, j: usize) -> Vec<Dual2<R>> {
    let mut seeded: Vec<Dual2<R>> = x
        .iter()
        .map(|&x| Dual::constant(Dual::constant(x)))
        .collect();
    if !x.is_empty() {
        seeded[i].value.tangent[0] = R::one();
        seeded[j].tangent[0].value = R::one();
    }
    seeded
}
