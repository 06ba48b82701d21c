//! A sum over data, and its gradient with respect to the parameters that all data share.

use std::sync::{Arc, Mutex, PoisonError};

use autodiff::internal::SumByParts;
use autodiff::{Fused, Real, Var, value_and_gradient};

use crate::record::replay::{Plan, PointInputs, Points, Wanted};

/// The function that a [`Sum`] adds up. It takes the parameters that all data share, and one datum.
pub trait Summand: Send + Sync + 'static {
    /// Returns the term of one datum.
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R;
}

/// The sum of a [`Summand`] over data.
///
/// The summand is recorded once, without values. The recording is replayed over blocks of data, one datum in each SIMD
/// lane, for the value and for the gradient. On the reverse tape the whole sum is one fused entry. A summand that calls
/// [`Real::fused`], [`Mask::any`], [`Mask::all`], [`Real::primal`] or `is_zero` cannot be recorded without values. It
/// runs on an ordinary tape, datum by datum, which is much slower.
///
/// [`Mask::any`]: autodiff::Mask::any
/// [`Mask::all`]: autodiff::Mask::all
///
/// Layers of a network run faster. The recording is searched for them: a layer calls [`R::dot(row, x)`](Real::dot) for
/// several rows of parameters and the same numbers `x`, and is computed as a matrix product over a block of data. All
/// rows must have the same length and be evenly spaced in the parameters. `x` may consist of a few evenly spaced parts.
/// The code may use each product before it computes the next one. As elsewhere, a zero cotangent passes zero, even
/// through an infinite partial. For a mini-batch that is already a matrix, use
/// [`dense_batch`](autodiff::fused::dense_batch).
///
/// ```
/// use autodiff_programs::data::{Sum, Summand};
/// use autodiff::{Real, gradient};
///
/// /// The squared distance of a line from a point.
/// struct Misfit;
/// impl Summand for Misfit {
///     fn eval<R: Real>(&self, line: &[R], point: &[R]) -> R {
///         let gap = line[0] + line[1] * point[0] - point[1];
///         gap * gap
///     }
/// }
///
/// let points = Sum::new(Misfit, &[[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]]);
/// assert_eq!(points.run(&[1.0, 1.0]), 2.0);
/// assert_eq!(gradient(|line| points.run(line), &[1.0, 1.0]), [0.0, 2.0]);
/// ```
#[derive(Debug)]
pub struct Sum<S>(Arc<Terms<S>>);

impl<S> Clone for Sum<S> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

#[derive(Debug)]
struct Terms<S> {
    summand: S,
    count: usize,
    /// Column `i` has the `i`-th number of every datum.
    columns: Vec<Vec<f64>>,
    recorded: Mutex<Option<SummandPlan>>,
}

/// The plan for replaying the summand, with the number of shared parameters for which it was made. The plan is `None`
/// if the summand cannot be recorded.
#[derive(Clone, Debug)]
struct SummandPlan {
    shared: usize,
    plan: Option<Arc<Plan>>,
}

impl<S: Summand> Sum<S> {
    /// Creates a sum over data, which must all have the same length.
    ///
    /// # Panics
    /// If the data differ in length.
    #[track_caller]
    pub fn new(summand: S, data: &[impl AsRef<[f64]>]) -> Self {
        let width = data.first().map_or(0, |datum| datum.as_ref().len());
        let mut columns = vec![Vec::with_capacity(data.len()); width];
        for datum in data {
            let datum = datum.as_ref();
            assert_eq!(
                datum.len(),
                width,
                "the data of a `Sum` must all have the same length"
            );
            for (column, &number) in columns.iter_mut().zip(datum) {
                column.push(number);
            }
        }
        Self(Arc::new(Terms {
            summand,
            count: data.len(),
            columns,
            recorded: Mutex::new(None),
        }))
    }

    /// Returns the sum, given the shared parameters.
    #[track_caller]
    pub fn run<R: Real>(&self, shared: &[R]) -> R {
        R::fused(self.clone(), &[shared])[0]
    }

    /// Returns the plan for replaying the summand. The summand is recorded again only if the number of shared
    /// parameters has changed.
    fn plan(&self, shared: usize) -> Option<Arc<Plan>> {
        let terms = &*self.0;
        let recorded = || {
            terms
                .recorded
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
        };
        if let Some(recorded) = &*recorded()
            && recorded.shared == shared
        {
            return recorded.plan.clone();
        }
        let plan = Plan::record([terms.columns.len(), shared], |datum, shared| {
            vec![terms.summand.eval(shared, datum)]
        });
        let plan = plan.map(Arc::new);
        *recorded() = Some(SummandPlan {
            shared,
            plan: plan.clone(),
        });
        plan
    }

    /// Returns the sum and, if wanted, its gradient.
    fn total<R: Real>(&self, shared: &[R], wanted: Wanted<R>) -> (R, Vec<R>) {
        let Terms { count, columns, .. } = &*self.0;
        if *count == 0 {
            // The length of a datum is unknown if there is no datum, so the summand cannot be recorded.
            return (R::zero(), vec![R::zero(); shared.len()]);
        }
        let Some(plan) = self.plan(shared.len()) else {
            return self.by_tape(shared);
        };
        let points = Points {
            plan: &plan,
            shared,
            count: *count,
            inputs: PointInputs::Data(columns),
            wanted,
        };
        let replayed = points.replay();
        (R::sum_of(&replayed.results[0]), replayed.by_shared)
    }

    /// Returns the sum and its gradient without a recording of the summand: each datum runs on an ordinary tape.
    fn by_tape<R: Real>(&self, shared: &[R]) -> (R, Vec<R>) {
        let mut terms = Vec::new();
        let mut gradient = SumByParts::new(shared.len());
        let Terms {
            summand,
            count,
            columns,
            ..
        } = &*self.0;
        for i in 0..*count {
            let datum: Vec<Var<R>> = columns.iter().map(|c| Var::lit(c[i])).collect();
            let (term, bars) = value_and_gradient(|shared| summand.eval(shared, &datum), shared);
            terms.push(term);
            gradient.add(&bars);
        }
        (R::sum_of(&terms), gradient.total())
    }
}

impl<S: Summand> Fused for Sum<S> {
    const SOURCES: &str = crate::SOURCES;
    type Saved<R: Real> = Vec<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        vec![self.total(inputs[0], Wanted::Results).0]
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Vec<R>) {
        let (total, gradient) = self.total(inputs[0], Wanted::ByShared);
        (vec![total], gradient)
    }

    fn reverse<R: Real>(&self, gradient: &mut Vec<R>, y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        let chain = |&partial| R::chain(partial, y_bar[0]);
        vec![gradient.iter().map(chain).collect()]
    }
}
