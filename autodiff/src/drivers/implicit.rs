//! Derivatives of a root, without differentiating the iterations that found it.
//!
//! Where `F(x, p) = 0` defines `x` as a function of `p`, the implicit function theorem gives its
//! derivative from the Jacobians of `F` at the root: `x_dot = -F_x^-1 F_p p_dot`, and in reverse
//! `p_bar = -F_p^T F_x^-T x_bar`. How `x` was found plays no part, so the solver may iterate,
//! branch and stop as it likes, on plain numbers. Differentiating through the solver instead would cost
//! every iteration once more, and, if it stopped early, give the derivative of its last iterate.

use std::fmt;

use super::jacobian::joined_columns;
use super::lu::Lu;
use super::seed::{CHUNK, seeded};
use crate::dual::Dual;
use crate::math::rounding::epsilon;
use crate::real::{Fused, Mask, Real};
use crate::reverse::{Tape, Var};

/// As many equations as unknowns, with parameters. It must own its data, or share them by an `Arc`,
/// because the tape keeps it.
///
/// The equations of an equilibrium are the gradient of an energy, and can be written so; parameters
/// enter the inner gradient as [constants](Var::constant):
///
/// ```
/// use autodiff::implicit::{Residual, root};
/// use autodiff::{Real, Var, gradient_of};
///
/// /// Where `x^4 / 4 + x^2 / 2 - load x` is least.
/// #[derive(Clone)]
/// struct Equilibrium;
/// impl Residual for Equilibrium {
///     fn eval<R: Real>(&self, x: &[R], load: &[R]) -> Vec<R> {
///         let load = Var::constant(load[0]);
///         gradient_of(|x| 0.25 * x[0].powi(4) + 0.5 * x[0] * x[0] - load * x[0], x)
///     }
/// }
///
/// // x^3 + x = load.
/// let by_load = gradient_of(|load| root(Equilibrium, &[Var::lit(1.0)], load).unwrap()[0], &[2.0]);
/// assert_eq!(by_load, [0.25]);
/// ```
pub trait Residual: Clone + Send + 'static {
    /// `F(x, p)`, one entry per entry of `x`; zero where `x` is the solution at `p`.
    fn eval<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R>;
}

/// Why [`root`] makes nothing of a point.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoRoot {
    /// The Jacobian of the residual by the unknowns has no inverse: `x` is no function of `p` there.
    Singular {
        /// The first unknown whose column depends on those before it, to within rounding, or is not a
        /// number.
        unknown: usize,
    },
    /// The residual is not zero.
    Far {
        /// The first unknown that is too far from the root.
        unknown: usize,
        /// Its distance from the root, by a step of Newton's method, as the number type prints it.
        step: String,
        /// The distance that is allowed.
        allowed: String,
    },
}

impl fmt::Display for NoRoot {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Singular { unknown } => write!(
                formatter,
                "the residual's Jacobian is singular: its column for unknown {unknown} depends on \
                 those before it or is not a number, so the root is no function of the parameters"
            ),
            Self::Far {
                unknown,
                step,
                allowed,
            } => write!(
                formatter,
                "the point is no root: unknown {unknown} is {step} away from it, where {allowed} is \
                 allowed; solve more accurately, or allow more by `root_within`"
            ),
        }
    }
}

impl std::error::Error for NoRoot {}

/// Makes the root `x` of `residual`, found for the primal of `p`, a function of `p`: its value is `x`
/// itself, its derivatives follow from the equations, in every mode and nesting. Derivatives that `x`
/// carries are ignored, so run the solver on [primals](Real::primal), or on
/// [detached](Real::detach) parameters, which cost nothing on the tape. The derivatives are off by the order of the error of `x`.
///
/// ```
/// use autodiff::implicit::{Residual, root};
/// use autodiff::{Function, Real, gradient};
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
/// /// Anyone's solver, of plain floats.
/// fn bisected(f: impl Fn(f64) -> f64) -> f64 {
///     let (mut low, mut high) = (0.0, 1.0);
///     for _ in 0..60 {
///         let middle = 0.5 * (low + high);
///         if f(middle) < 0.0 { low = middle } else { high = middle }
///     }
///     low
/// }
///
/// struct Solution;
/// impl Function for Solution {
///     fn eval<R: Real>(&self, p: &[R]) -> R {
///         let held = p[0].primal();
///         let x = bisected(|x| Quintic.eval(&[x], &[held])[0]);
///         root(Quintic, &R::lits(&[x]), p).expect("a residual that increases")[0]
///     }
/// }
///
/// let difference = (Solution.eval(&[2.0 + 1e-5]) - Solution.eval(&[2.0 - 1e-5])) / 2e-5;
/// assert!((gradient(&Solution, &[2.0])[0] - difference).abs() < 1e-9);
/// ```
///
/// # Errors
/// If the Jacobian by the unknowns is singular at the root, or not a number; if `x` is no root: if a step
/// of Newton's method from it is longer than `(1 + max |x|)` times the cubic root of the type's epsilon,
/// 6e-6 in f64.
///
/// # Panics
/// If the residual has not as many entries as `x`.
pub fn root<R: Real>(residual: impl Residual, x: &[R], p: &[R]) -> Result<Vec<R>, NoRoot> {
    root_within(residual, x, p, epsilon::<R>().cbrt())
}

/// [`root`] with a tolerance of the caller's: how long a step of Newton's method from `x` may be, as a
/// share of `1 + max |x|`.
///
/// # Errors
/// As [`root`].
///
/// # Panics
/// As [`root`].
pub fn root_within<R: Real>(
    residual: impl Residual,
    x: &[R],
    p: &[R],
    tolerance: R,
) -> Result<Vec<R>, NoRoot> {
    let [x, held] = [x, p].map(|numbers| numbers.iter().map(|n| n.detach()).collect::<Vec<R>>());
    let factors = factors(&residual, &x, &held)?;
    let mut steps = residual.eval(&x, &held);
    factors.solve(&mut steps);
    let largest = x.iter().fold(R::zero(), |largest, x| largest.max(x.abs()));
    let allowed = tolerance.detach() * (R::one() + largest);
    for (unknown, step) in steps.into_iter().map(Real::abs).enumerate() {
        if !step.less_equal(allowed).all() {
            let [step, allowed] = [step, allowed].map(|number| format!("{number:?}"));
            return Err(NoRoot::Far {
                unknown,
                step,
                allowed,
            });
        }
    }
    Ok(R::fused(Root(residual), &[&x, p]))
}

/// The factors of the Jacobian by the unknowns.
fn factors<R: Real>(residual: &impl Residual, x: &[R], p: &[R]) -> Result<Lu<R>, NoRoot> {
    let p = constants(p);
    let pass = |first| {
        let f = residual.eval(&seeded(x, first), &p);
        assert_eq!(
            f.len(),
            x.len(),
            "a residual has as many entries as there are unknowns"
        );
        f
    };
    let passes = (0..x.len()).step_by(CHUNK).map(pass);
    let columns = joined_columns(passes, x.len(), Some(x.len()));
    Lu::new(columns.iter().map(<[R]>::to_vec).collect())
        .map_err(|unknown| NoRoot::Singular { unknown })
}

fn constants<R: Real, const N: usize>(numbers: &[R]) -> Vec<Dual<R, N>> {
    numbers.iter().copied().map(Dual::constant).collect()
}

/// The root as a function of the slices `x`, through which no derivative passes, and `p`.
///
/// Each mode peels one layer off its numbers and asks for the root in the numbers inside. That
/// one carries all inner derivatives, and so do the Jacobians taken there: this is why nested
/// derivatives come out right.
struct Root<F>(F);

/// The numbers that the reverse sweep needs: the root, and the parameters it was found for.
struct RootAtPoint<R> {
    x: Vec<R>,
    p: Vec<R>,
}

impl<F: Residual> Root<F> {
    /// The root in the numbers one layer further in.
    fn inner<R: Real>(&self, x: &[R], p: &[R]) -> Vec<R> {
        R::fused(Root(self.0.clone()), &[x, p])
    }

    /// `root` has factored this matrix before: only different rounding can make it singular now.
    fn factors<R: Real>(&self, x: &[R], p: &[R]) -> Lu<R> {
        factors(&self.0, x, p).unwrap_or_else(|singular| panic!("{singular}"))
    }
}

impl<F: Residual> Fused for Root<F> {
    type Saved<R: Real> = RootAtPoint<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        inputs[0].to_vec()
    }

    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        let [x, p] = [inputs[0], inputs[1]].map(|s| s.iter().map(|n| n.value).collect::<Vec<R>>());
        let mut x = constants(&self.inner(&x, &p));
        let moved = self.0.eval(&x, inputs[1]);
        let values: Vec<R> = x.iter().map(|x| x.value).collect();
        let factors = self.factors(&values, &p);
        for i in 0..N {
            let mut x_dot: Vec<R> = moved.iter().map(|f| -f.tangent[i]).collect();
            factors.solve(&mut x_dot);
            for (x, x_dot) in x.iter_mut().zip(x_dot) {
                x.tangent[i] = x_dot;
            }
        }
        x
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, RootAtPoint<R>) {
        let x = self.inner(inputs[0], inputs[1]);
        let p = inputs[1].to_vec();
        (x.clone(), RootAtPoint { x, p })
    }

    fn reverse<R: Real>(&self, saved: &mut RootAtPoint<R>, y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        let RootAtPoint { x, p } = saved;
        let mut multipliers: Vec<R> = y_bar.iter().map(|&bar| -bar).collect();
        self.factors(x, p).solve_transposed(&mut multipliers);
        let mut tape = Tape::new();
        let f = tape.record(p, |p| {
            let x: Vec<Var<R>> = x.iter().copied().map(Var::constant).collect();
            self.0.eval(&x, p)
        });
        vec![Vec::new(), tape.pullback(&f, &multipliers).to_vec()]
    }
}
