//! The problem that a driver solves.

use crate::error::{OptimiserError, check, check_length, require};

/// A function from the variables to a list of numbers.
type Functions<'a> = Box<dyn FnMut(&[f64]) -> Vec<f64> + 'a>;

/// An optimisation problem: minimise the objective `f_0(x)` subject to the constraints `f_i(x) <= 0` for `i` from 1 to
/// `m`, and to `lower <= x <= upper`.
///
/// Messages and results count constraints and variables from 0: `constraint 0` is `f_1`. Its value should not be far
/// from 1 in size, because tolerances are in the units of the constraints.
pub struct Problem<'a> {
    pub(crate) lower: Vec<f64>,
    pub(crate) upper: Vec<f64>,
    pub(crate) equalities: usize,
    values: Functions<'a>,
    gradients: Functions<'a>,
    /// The number of values that the first evaluation returned.
    functions: Option<usize>,
    /// How often `values` and `gradients` were called.
    pub(crate) evaluations: [usize; 2],
}

impl<'a> Problem<'a> {
    /// Makes a problem with inequality constraints.
    ///
    /// `values` returns `f_0` to `f_m` at a point. `gradients` returns their derivatives at a point in one list: first
    /// the derivatives of `f_0` by each variable, then those of `f_1`, and so on. For a function `f` that is generic
    /// over the number type of the crate `autodiff`, this is `|x| autodiff::jacobian(f, x).into_vec()`.
    ///
    /// If the two closures share work, such as the solution of a linear system, keep it between the calls: a driver
    /// asks for gradients only at the last point for which it asked for values.
    pub fn new(
        lower: &[f64],
        upper: &[f64],
        values: impl FnMut(&[f64]) -> Vec<f64> + 'a,
        gradients: impl FnMut(&[f64]) -> Vec<f64> + 'a,
    ) -> Self {
        Problem {
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            equalities: 0,
            values: Box::new(values),
            gradients: Box::new(gradients),
            functions: None,
            evaluations: [0; 2],
        }
    }

    /// Makes the first `count` constraints equalities, `f_i(x) = 0`. Only [`augmented::minimise`](crate::augmented::minimise)
    /// takes them.
    #[must_use]
    pub fn with_equalities(mut self, count: usize) -> Self {
        self.equalities = count;
        self
    }

    /// Refuses bounds that cross and a start that does not fit them. Prepares for a new run.
    pub(crate) fn begin(&mut self, start: &[f64]) -> Result<(), OptimiserError> {
        self.functions = None;
        self.evaluations = [0; 2];
        let count = self.lower.len();
        require(count > 0, || "the problem has no variables".into())?;
        check_length("upper bounds", &self.upper, count)?;
        check("start", start, count)?;
        for (j, (&lower, &upper)) in self.lower.iter().zip(&self.upper).enumerate() {
            require(lower <= upper, || {
                format!(
                    "variable {j}: the lower bound is {lower} and the upper bound {upper}; they must not cross"
                )
            })?;
            require(lower <= start[j] && start[j] <= upper, || {
                format!(
                    "start: variable {j} is {}; it must be within its bounds {lower} to {upper}",
                    start[j]
                )
            })?;
        }
        Ok(())
    }

    /// The values of all functions.
    pub(crate) fn values(&mut self, point: &[f64]) -> Result<Vec<f64>, OptimiserError> {
        self.evaluations[0] += 1;
        let values = (self.values)(point);
        let functions = *self.functions.get_or_insert(values.len());
        check_length("values", &values, functions)?;
        let least = 1 + self.equalities;
        require(values.len() >= least, || {
            let found = values.len();
            format!(
                "values: expected an objective and {} equalities or more, found {found} entries",
                least - 1
            )
        })?;
        all_finite(&values, point, name)?;
        Ok(values)
    }

    /// The gradient of each function.
    pub(crate) fn gradients(&mut self, point: &[f64]) -> Result<Vec<Vec<f64>>, OptimiserError> {
        self.evaluations[1] += 1;
        let entries = (self.gradients)(point);
        let count = point.len();
        check_length("gradients", &entries, self.functions.unwrap_or(1) * count)?;
        all_finite(&entries, point, |k| {
            format!(
                "derivative of the {} by variable {}",
                name(k / count),
                k % count
            )
        })?;
        Ok(entries.chunks_exact(count).map(<[f64]>::to_vec).collect())
    }
}

fn name(function: usize) -> String {
    match function {
        0 => "objective".into(),
        _ => format!("constraint {}", function - 1),
    }
}

/// Refuses numbers that are infinite or NaN.
fn all_finite(
    numbers: &[f64],
    point: &[f64],
    name: impl Fn(usize) -> String,
) -> Result<(), OptimiserError> {
    match numbers.iter().position(|number| !number.is_finite()) {
        None => Ok(()),
        Some(k) => Err(OptimiserError::NotFinite {
            what: name(k),
            value: numbers[k],
            point: point.to_vec(),
        }),
    }
}
