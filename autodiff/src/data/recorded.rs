//! A function that is recorded once for all points.

use std::fmt;
use std::sync::Arc;

use crate::drivers::Function;
use crate::real::Real;
use crate::record::replay::{Inputs, Plan, Points, Wanted};

/// A function recorded once, without values, and replayed forward and back at any number of points, in
/// lanes over the points.
///
/// Code without values cannot take another branch at another point: what it would need for that, the
/// primal of a number, is refused when it is recorded.
///
/// ```
/// use autodiff::data::Recorded;
/// use autodiff::{Function, Real, lit};
///
/// struct Rosenbrock;
/// impl Function for Rosenbrock {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         lit(100.0) * (x[1] - x[0] * x[0]).powi(2) + (lit(1.0) - x[0]).powi(2)
///     }
/// }
///
/// let recorded = Recorded::new(&Rosenbrock, 2)?;
/// assert_eq!(recorded.value_and_gradient(&[1.0, 1.0]), (0.0, vec![0.0, 0.0]));
/// let many = recorded.values_and_gradients(&[[0.0, 0.0], [1.0, 2.0], [2.0, 4.0]]);
/// assert_eq!(many[2], (1.0, vec![2.0, 0.0]));
/// # Ok::<(), autodiff::data::NeedsValues>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recorded {
    arguments: usize,
    plan: Arc<Plan>,
}

/// The function asks for values, and so cannot be recorded without them: by
/// [`primal`](crate::Real::primal), by `is_zero`, by [`Mask::any`](crate::Mask::any) or
/// [`all`](crate::Mask::all), or in a [fused](crate::Real::fused) function, whose derivative is its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NeedsValues {}

impl fmt::Display for NeedsValues {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(
            "the function asks for values, by primal, is_zero, any or all, or calls a fused function: \
             its recording could not stand for other points",
        )
    }
}

impl std::error::Error for NeedsValues {}

impl Recorded {
    /// Records a function of so many arguments.
    ///
    /// # Errors
    /// If it asks for values.
    pub fn new(function: &impl Function, arguments: usize) -> Result<Self, NeedsValues> {
        let plan = Plan::record([arguments, 0], |x, _| vec![function.eval(x)]);
        Ok(Self {
            arguments,
            plan: plan.ok_or(NeedsValues {})?.into(),
        })
    }

    /// The value and the gradient at a point.
    ///
    /// # Panics
    /// If the point has not as many numbers as the function has arguments.
    pub fn value_and_gradient<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        let mut both = self.values_and_gradients(&[x]);
        both.remove(0)
    }

    /// The values and gradients at many points.
    ///
    /// # Panics
    /// If a point has not as many numbers as the function has arguments.
    pub fn values_and_gradients<R: Real>(&self, points: &[impl AsRef<[R]>]) -> Vec<(R, Vec<R>)> {
        let mut columns = vec![Vec::with_capacity(points.len()); self.arguments];
        for point in points {
            let (point, arguments) = (point.as_ref(), self.arguments);
            assert!(
                point.len() == arguments,
                "{} numbers for a function of {arguments} arguments",
                point.len()
            );
            for (column, &number) in columns.iter_mut().zip(point) {
                column.push(number);
            }
        }
        let replayed = Points {
            plan: &self.plan,
            shared: &[],
            count: points.len(),
            inputs: Inputs::Numbers(&columns),
            wanted: Wanted::ByInputs(None),
        }
        .replay();
        let gradient = |k: usize| replayed.by_inputs.iter().map(|bars| bars[k]).collect();
        let values = replayed.results[0].iter().enumerate();
        values.map(|(k, &value)| (value, gradient(k))).collect()
    }
}
