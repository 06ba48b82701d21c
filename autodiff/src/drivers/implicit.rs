//! Computes the derivatives of a root from its equations, without differentiating the iterations that found it.
//!
//! Where `F(x, p) = 0` defines `x` as a function of `p`, the implicit function theorem gives the derivative of `x` from
//! the Jacobians of `F` at the root: `x_dot = -F_x^-1 F_p p_dot`, and in reverse `p_bar = -F_p^T F_x^-T x_bar`. It does
//! not matter how `x` was found: the solver may iterate, branch and stop as it likes, on plain numbers. The
//! alternative, differentiating the solver, would repeat every iteration. And if the solver stopped early, the result
//! would be the derivative of the last iterate, not of the root.

use std::fmt;

use super::jacobian::{joined_columns, vjp};
use super::lu::Lu;
use super::seed::{CHUNK, variables_from};
use crate::constant::printed;
use crate::dual::Dual;
use crate::math::rounding::epsilon;
use crate::real::{Fused, Mask, Real};
use crate::reverse::Var;

/// A system of equations `F(x, p) = 0` for the unknowns `x`, with as many equations as unknowns and with parameters
/// `p`. The tape keeps the residual, so the residual must own its data or share them through an `Arc`.
///
/// Often the equations say that the gradient of an energy is zero. Then let `eval` compute that gradient. In its
/// closure, make the parameters [constants](Var::constant):
///
/// ```
/// use autodiff::implicit::{Residual, root};
/// use autodiff::{Real, Var, gradient};
///
/// /// The equilibrium where `x^4 / 4 + x^2 / 2 - load x` is smallest.
/// #[derive(Clone)]
/// struct Equilibrium;
/// impl Residual for Equilibrium {
///     fn eval<R: Real>(&self, x: &[R], load: &[R]) -> Vec<R> {
///         let load = Var::constant(load[0]);
///         gradient(|x| 0.25 * x[0].powi(4) + 0.5 * x[0] * x[0] - load * x[0], x)
///     }
/// }
///
/// // x^3 + x = load.
/// let by_load = gradient(|load| root(Equilibrium, &[Var::lit(1.0)], load).unwrap()[0], &[2.0]);
/// assert_eq!(by_load, [0.25]);
/// ```
pub trait Residual: Clone + Send + 'static {
    /// Returns `F(x, p)`, with as many entries as `x`. All are zero where `x` is the solution at `p`.
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R>;
}

/// The reason why [`root`] rejected a point.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoRoot {
    /// The Jacobian of the equations with respect to the unknowns is singular. So the unknowns `x` are not a function
    /// of the parameters `p` there.
    Singular {
        /// The first unknown whose column of the Jacobian depends linearly on earlier columns, to within rounding, or
        /// contains NaN.
        unknown: usize,
    },
    /// The point is not a root: the residual is too far from zero.
    Far {
        /// The first unknown whose value is too far from the root.
        unknown: usize,
        /// The estimated distance of this unknown from the root, as text. It is the unknown's change in a step of
        /// Newton's method.
        step: String,
        /// The largest allowed distance, as text.
        allowed: String,
    },
}

impl fmt::Display for NoRoot {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Singular { unknown } => write!(
                formatter,
                "the residual's Jacobian is singular: its column for unknown {unknown} depends on \
                 earlier columns or is NaN, so the root is not a function of the parameters"
            ),
            Self::Far {
                unknown,
                step,
                allowed,
            } => write!(
                formatter,
                "the point is not a root: unknown {unknown} is {step} away from the root, but at most {allowed} is \
                 allowed; solve more accurately, or set a larger tolerance with `root_within`"
            ),
        }
    }
}

impl std::error::Error for NoRoot {}

/// Makes a root depend on the parameters `p`. `x` is the root of `residual` that a solver found for the primal of `p`.
/// The result has the value `x` and the root's derivatives with respect to `p`, which follow from the equations. This
/// holds in every mode and nesting. If `x` is not exact, the derivatives have an error of the same order. Derivatives
/// that `x` itself carries are ignored, so run the solver on [primals](Real::primal), or on [detached](Real::detach)
/// parameters, which cost nothing on the tape.
///
/// ```
/// use autodiff::implicit::{Residual, root};
/// use autodiff::{Real, gradient};
///
/// /// `x + p x^5 = 1`.
/// #[derive(Clone)]
/// struct Quintic;
/// impl Residual for Quintic {
///     fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
///         vec![x[0] + p[0] * x[0].powi(5) - R::one()]
///     }
/// }
///
/// /// Any solver on plain floats.
/// fn bisected(f: impl Fn(f64) -> f64) -> f64 {
///     let (mut low, mut high) = (0.0, 1.0);
///     for _ in 0..60 {
///         let middle = 0.5 * (low + high);
///         if f(middle) < 0.0 { low = middle } else { high = middle }
///     }
///     low
/// }
///
/// fn solution<R: Real>(p: &[R]) -> R {
///     let held = p[0].primal();
///     let x = bisected(|x| Quintic.eval(&[x], &[held])[0]);
///     root(Quintic, &R::lits(&[x]), p).expect("a residual that increases")[0]
/// }
///
/// let difference = (solution(&[2.0 + 1e-5]) - solution(&[2.0 - 1e-5])) / 2e-5;
/// assert!((gradient(solution, &[2.0])[0] - difference).abs() < 1e-9);
/// ```
///
/// # Errors
/// [`NoRoot::Singular`] if the Jacobian with respect to the unknowns is singular or NaN at `x`. [`NoRoot::Far`] if a
/// step of Newton's method from `x` is longer than `(1 + max |x|)` times the cubic root of the type's epsilon, 6e-6
/// in f64.
///
/// # Panics
/// If the residual does not have as many entries as `x`.
#[track_caller]
pub fn root<R: Real>(residual: impl Residual, x: &[R], p: &[R]) -> Result<Vec<R>, NoRoot> {
    root_within(residual, x, p, epsilon::<R>().cbrt())
}

/// Like [`root`], but with the given tolerance: the longest allowed step of Newton's method from `x`, relative to `1 +
/// max |x|`.
///
/// # Errors
/// Like [`root`].
///
/// # Panics
/// Like [`root`].
#[track_caller]
pub fn root_within<R: Real>(
    residual: impl Residual,
    x: &[R],
    p: &[R],
    tolerance: R,
) -> Result<Vec<R>, NoRoot> {
    let [x, held] = [x, p].map(|numbers| numbers.iter().map(|n| n.detach()).collect::<Vec<R>>());
    let root = Root(residual);
    let factors = root.factors(&x, &held)?;
    let residual = root.0.eval(&x, &held);
    assert_eq!(
        residual.len(),
        x.len(),
        "a residual must have as many entries as there are unknowns"
    );
    near(&x, residual, &factors, tolerance)?;
    Ok(R::fused(root, &[&x, p]))
}

/// Returns an error if a step of Newton's method would move the point further than allowed.
fn near<R: Real>(x: &[R], mut steps: Vec<R>, factors: &Lu<R>, tolerance: R) -> Result<(), NoRoot> {
    factors.solve(&mut steps);
    let largest = x.iter().fold(R::zero(), |largest, x| largest.max(x.abs()));
    let allowed = tolerance.detach() * (R::one() + largest);
    for (unknown, step) in steps.into_iter().map(Real::abs).enumerate() {
        if !step.less_equal(allowed).all() {
            let [step, allowed] = [step, allowed].map(printed);
            return Err(NoRoot::Far {
                unknown,
                step,
                allowed,
            });
        }
    }
    Ok(())
}

/// The type of a residual as a function of numbers that carry several tangents.
type Residuals<'f, R> = dyn Fn(&[Dual<R, CHUNK>]) -> Vec<Dual<R, CHUNK>> + 'f;

/// Returns the LU factors of the Jacobian with respect to the unknowns.
#[track_caller]
fn factors<R: Real>(residual: &Residuals<R>, x: &[R]) -> Result<Lu<R>, NoRoot> {
    let passes = (0..x.len()).step_by(CHUNK);
    let mut passes = passes.map(|first| residual(&variables_from(x, first)));
    let columns = joined_columns(&mut passes, x.len());
    assert_eq!(
        columns.rows(),
        x.len(),
        "a residual must have as many entries as there are unknowns"
    );
    Lu::new(columns.iter().map(<[R]>::to_vec).collect())
        .map_err(|unknown| NoRoot::Singular { unknown })
}

fn constants<R: Real, const N: usize>(numbers: &[R]) -> Vec<Dual<R, N>> {
    numbers.iter().copied().map(Dual::constant).collect()
}

/// Sets the tangents of the root `x`. They follow from the tangents of the residual, which was evaluated with `x` as a
/// constant.
fn moved<R: Real, const N: usize>(x: &mut [Dual<R, N>], residual: &[Dual<R, N>], factors: &Lu<R>) {
    for i in 0..N {
        let mut x_dot: Vec<R> = residual.iter().map(|f| -f.tangent[i]).collect();
        factors.solve(&mut x_dot);
        for (x, x_dot) in x.iter_mut().zip(x_dot) {
            x.tangent[i] = x_dot;
        }
    }
}

/// The fused function that returns the root. Its input slices are `x`, which passes no derivative, and `p`.
///
/// In nested derivatives, each mode removes its own layer of derivatives and evaluates the root on the inner numbers.
/// The inner root and the inner Jacobians carry the derivatives of the inner modes, so nested derivatives are correct.
struct Root<F>(F);

/// The numbers that the reverse sweep needs: the root, and the parameters it was found for.
struct RootAtPoint<R> {
    x: Vec<R>,
    p: Vec<R>,
}

impl<F: Residual> Root<F> {
    /// Returns the root in the inner number type `R`.
    fn inner<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        R::fused(Root(self.0.clone()), &[x, p])
    }

    #[track_caller]
    fn factors<R: Real>(&self, x: &[R], p: &[R]) -> Result<Lu<R>, NoRoot> {
        let p = constants(p);
        factors(&|x| self.0.eval(x, &p), x)
    }

    /// Returns the factors of a matrix that `root` has already factored. If it is singular now, rounding errors are the
    /// only possible reason.
    #[track_caller]
    fn known_factors<R: Real>(&self, x: &[R], p: &[R]) -> Lu<R> {
        match self.factors(x, p) {
            Ok(factors) => factors,
            Err(singular) => panic!("{singular}"),
        }
    }
}

impl<F: Residual> Fused for Root<F> {
    type Saved<R: Real> = RootAtPoint<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        inputs[0].to_vec()
    }

    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        let [x, p] = [inputs[0], inputs[1]].map(|s| s.iter().map(|n| n.value).collect::<Vec<R>>());
        let x = self.inner(&x, &p);
        let mut dual = constants(&x);
        let residual = self.0.eval(&dual, inputs[1]);
        moved(&mut dual, &residual, &self.known_factors(&x, &p));
        dual
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, RootAtPoint<R>) {
        let x = self.inner(inputs[0], inputs[1]);
        let p = inputs[1].to_vec();
        (x.clone(), RootAtPoint { x, p })
    }

    fn reverse<R: Real>(&self, saved: &mut RootAtPoint<R>, y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        let RootAtPoint { x, p } = saved;
        let mut multipliers: Vec<R> = y_bar.iter().map(|&bar| -bar).collect();
        self.known_factors(x, p).solve_transposed(&mut multipliers);
        let x: Vec<Var<R>> = x.iter().copied().map(Var::constant).collect();
        let (_, p_bar) = vjp(|p| self.0.eval(&x, p), p, &multipliers);
        vec![Vec::new(), p_bar]
    }
}
