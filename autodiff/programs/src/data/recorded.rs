//! A function whose recording is replayed at many points.

use std::fmt;
use std::sync::Arc;

use autodiff::{Function, Fused, Real};

use crate::record::replay::{Plan, PointInputs, Points, Replayed, Wanted};

/// A function that is recorded once, without values. The recording is then replayed at any number of points, forward
/// for the values and backward for the gradients, several points at a time in SIMD lanes.
///
/// One recording serves all points, so the function must not branch on values. Recording fails if it asks for the
/// primal of a number.
///
/// ```
/// use autodiff_programs::data::Recorded;
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
/// let many = recorded.values_and_gradients(&[[0.0, 0.0], [1.0, 2.0], [2.0, 4.0]]);
/// assert_eq!(many[2], (1.0, vec![2.0, 0.0]));
/// # Ok::<(), autodiff_programs::data::NeedsValues>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recorded {
    arguments: usize,
    plan: Arc<Plan>,
}

/// The error that a function cannot be recorded without values, because it needs them. Such a function calls
/// [`primal`](autodiff::Real::primal), `is_zero`, [`Mask::any`](autodiff::Mask::any), [`all`](autodiff::Mask::all), or a
/// [fused](autodiff::Real::fused) function, which has its own derivative.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct NeedsValues {}

impl fmt::Display for NeedsValues {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(
            "the function cannot be recorded once for all points, because it calls `primal`, `is_zero`, \
             `Mask::any`, `Mask::all` or a fused function; differentiate it at each point with `gradient`",
        )
    }
}

impl std::error::Error for NeedsValues {}

impl Recorded {
    /// Records a function with this number of arguments.
    ///
    /// # Errors
    /// If the function asks for values.
    pub fn new(function: &impl Function, arguments: usize) -> Result<Self, NeedsValues> {
        let plan = Plan::record([arguments, 0], |x, _| vec![function.eval(x)]);
        Ok(Self {
            arguments,
            plan: plan.ok_or(NeedsValues {})?.into(),
        })
    }

    #[track_caller]
    fn check(&self, numbers: usize) {
        let arguments = self.arguments;
        assert!(
            numbers == arguments,
            "a point has {numbers} numbers, but the function has {arguments} arguments"
        );
    }

    /// Returns the value and the gradient at each point. At a single point, [`gradient`](autodiff::gradient) is faster.
    ///
    /// # Panics
    /// If a point does not have one number per argument.
    #[track_caller]
    pub fn values_and_gradients<R: Real>(&self, points: &[impl AsRef<[R]>]) -> Vec<(R, Vec<R>)> {
        let mut columns = vec![Vec::with_capacity(points.len()); self.arguments];
        for point in points {
            let point = point.as_ref();
            self.check(point.len());
            for (column, &number) in columns.iter_mut().zip(point) {
                column.push(number);
            }
        }
        let columns: Vec<&[R]> = columns.iter().map(Vec::as_slice).collect();
        let replayed = replayed(&self.plan, &columns, Wanted::ByInputs(None));
        let gradient = |k: usize| replayed.by_inputs.iter().map(|bars| bars[k]).collect();
        let values = replayed.results[0].iter().enumerate();
        values.map(|(k, &value)| (value, gradient(k))).collect()
    }

    /// Returns the sum of the function's values at many points. On the reverse tape the whole sum is one entry. Here
    /// the points are variables with derivatives; in a [`Sum`](super::Sum) they are constant data. `columns[i]` holds
    /// argument `i` of every point.
    ///
    /// ```
    /// use autodiff_programs::data::Recorded;
    /// use autodiff::{Function, Real, gradient};
    ///
    /// struct Exponential;
    /// impl Function for Exponential {
    ///     fn eval<R: Real>(&self, x: &[R]) -> R {
    ///         x[0].exp()
    ///     }
    /// }
    ///
    /// let exponential = Recorded::new(&Exponential, 1)?;
    /// let softmax = gradient(|x| exponential.total(&[x]).ln(), &[0.0, 0.0, 2f64.ln()]);
    /// assert_eq!(softmax, [0.25, 0.25, 0.5]);
    /// # Ok::<(), autodiff_programs::data::NeedsValues>(())
    /// ```
    ///
    /// # Panics
    /// If there is not one column per argument, or the columns differ in length.
    #[track_caller]
    pub fn total<R: Real>(&self, columns: &[&[R]]) -> R {
        let (given, arguments) = (columns.len(), self.arguments);
        assert!(
            given == arguments,
            "`total` was given {given} columns, but the function has {arguments} arguments"
        );
        let one_length = columns
            .iter()
            .all(|column| column.len() == columns[0].len());
        assert!(
            one_length,
            "the columns of `total` must all have the same length"
        );
        R::fused(Total(self.plan.clone()), columns)[0]
    }
}

fn replayed<R: Real>(plan: &Plan, columns: &[&[R]], wanted: Wanted<R>) -> Replayed<R> {
    let points = Points {
        plan,
        shared: &[],
        count: columns.first().map_or(0, |column| column.len()),
        inputs: PointInputs::Numbers(columns),
        wanted,
    };
    points.replay()
}

/// The fused function behind [`Recorded::total`]. Its input slices are the columns.
struct Total(Arc<Plan>);

impl Total {
    /// Returns the sum and, if wanted, its gradient with respect to each column.
    fn run<R: Real>(&self, columns: &[&[R]], wanted: Wanted<R>) -> (Vec<R>, Vec<Vec<R>>) {
        let replayed = replayed(&self.0, columns, wanted);
        let mut parts = Vec::new();
        for terms in replayed.results[0].chunks(128) {
            // Sixteen independent sums, so that one addition need not wait for the result of the one before.
            let mut sums = [R::zero(); 16];
            for terms in terms.chunks(sums.len()) {
                for (sum, &term) in sums.iter_mut().zip(terms) {
                    *sum += term;
                }
            }
            parts.push(R::sum_of(&sums));
        }
        (vec![R::sum_of(&parts)], replayed.by_inputs)
    }
}

impl Fused for Total {
    const SOURCES: &str = crate::SOURCES;
    type Saved<R: Real> = Vec<Vec<R>>;

    fn eval<R: Real>(&self, columns: &[&[R]]) -> Vec<R> {
        self.run(columns, Wanted::Results).0
    }

    fn record<R: Real>(&self, columns: &[&[R]]) -> (Vec<R>, Vec<Vec<R>>) {
        self.run(columns, Wanted::ByInputs(None))
    }

    fn reverse<R: Real>(
        &self,
        by_columns: &mut Vec<Vec<R>>,
        y_bar: &[R],
        _: &[bool],
    ) -> Vec<Vec<R>> {
        let chain = |&partial: &R| R::chain(partial, y_bar[0]);
        let bars = by_columns
            .iter()
            .map(|partials| partials.iter().map(chain).collect());
        bars.collect()
    }
}
