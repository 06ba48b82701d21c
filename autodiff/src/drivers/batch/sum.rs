//! A sum over data, and its gradient by the parameters that all data share.

use std::sync::Arc;

use super::plan::Plan;
use super::replay::{Replay, WIDE};
use crate::drivers::value_and_gradient_of;
use crate::real::{Fused, Real};
use crate::record::recording::{Recording, record};
use crate::record::symbol::Symbol;
use crate::reverse::Var;
use crate::simd::{Lane, Vectorized, WIDEST};

/// A function of parameters that all data share and of one datum: a term of a [`Sum`]. It must own what
/// else it needs, or share it by an `Arc`, because the tape keeps it.
pub trait Summand: Clone + Send + Sync + 'static {
    /// How many numbers of working memory [`eval`](Self::eval) needs.
    fn scratch(&self) -> usize {
        0
    }

    /// The term for one datum. `scratch` holds any values, and must be written before it is read. Mark
    /// implementations `#[inline(always)]`: only then are they compiled for the lanes' instruction set.
    fn eval<R: Real>(&self, shared: &[R], datum: &[R], scratch: &mut [R]) -> R;
}

/// The sum of a [`Summand`] over data.
///
/// Plain numbers are evaluated in lanes, one datum in each. On the reverse tape the whole sum is one
/// fused entry: the summand is recorded once, without values, and replayed forward and back over blocks
/// of data in lanes. A summand that calls fused functions ([`Real::fused`], [`Mask::any`] or `is_zero`
/// likewise) cannot be recorded so, and takes an ordinary tape, datum by datum, which is much slower.
///
/// [`Mask::any`]: crate::Mask::any
///
/// A network's layers are found in the record: dot products of rows of parameters with the same other numbers,
/// [`R::dot(row, x)`](Real::dot) for one row after the other, whatever happens to each product in between.
/// They are computed as products of matrices over a block of data. Rows of one length, evenly spaced, make
/// a layer; `x` may be in a few evenly spaced parts. The rule that a zero cotangent passes zero holds
/// here too. A mini-batch that is a matrix already can go through [`dense_batch`](crate::fused::dense_batch).
///
/// ```
/// use autodiff::batch::{Sum, Summand};
/// use autodiff::{Real, gradient_of};
///
/// /// The squared distance of a line from a point.
/// #[derive(Clone)]
/// struct Misfit;
/// impl Summand for Misfit {
///     #[inline(always)]
///     fn eval<R: Real>(&self, line: &[R], point: &[R], _: &mut [R]) -> R {
///         let gap = line[0] + line[1] * point[0] - point[1];
///         gap * gap
///     }
/// }
///
/// let points = Sum::new(Misfit, &[[0.0, 1.0], [1.0, 3.0], [2.0, 2.0]]);
/// assert_eq!(points.run(&[1.0, 1.0]), 2.0);
/// assert_eq!(gradient_of(|line| points.run(line), &[1.0, 1.0]), [0.0, 2.0]);
/// ```
#[derive(Clone, Debug)]
pub struct Sum<S> {
    summand: S,
    data: Data,
}

/// What a sum has besides its summand. A gradient needs no more once the summand is recorded, and is
/// compiled once, whatever the summands.
#[derive(Clone, Debug)]
struct Data {
    count: usize,
    /// The data by columns: for each number of a datum, that number of all data, the last repeated to
    /// fill whole blocks.
    columns: Arc<[Vec<f64>]>,
}

impl<S: Summand> Sum<S> {
    /// A sum over data, which all have the same length.
    ///
    /// # Panics
    /// If the data differ in length.
    pub fn new(summand: S, data: &[impl AsRef<[f64]>]) -> Self {
        let width = data.first().map_or(0, |datum| datum.as_ref().len());
        let mut columns = vec![Vec::with_capacity(data.len() + WIDE * WIDEST); width];
        for datum in data {
            let datum = datum.as_ref();
            assert_eq!(datum.len(), width, "the data of a sum differ in length");
            for (column, &number) in columns.iter_mut().zip(datum) {
                column.push(number);
            }
        }
        for column in &mut columns {
            let last = column[data.len() - 1];
            column.resize(data.len().next_multiple_of(WIDE * WIDEST), last);
        }
        let data = Data {
            count: data.len(),
            columns: columns.into(),
        };
        Self { summand, data }
    }

    /// The sum, given the shared parameters.
    pub fn run<R: Real>(&self, shared: &[R]) -> R {
        R::fused(self.clone(), &[shared])[0]
    }

    /// The term of a datum, with fresh working memory.
    fn term<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let mut scratch = vec![R::zero(); self.summand.scratch()];
        self.summand.eval(shared, datum, &mut scratch)
    }

    /// The sum and its gradient, datum by datum over an ordinary tape.
    fn by_tape<R: Real>(&self, shared: &[R]) -> (R, Vec<R>) {
        let mut total = R::zero();
        let mut gradient = vec![R::zero(); shared.len()];
        for i in 0..self.data.count {
            let datum: Vec<Var<R>> = self.data.columns.iter().map(|c| Var::lit(c[i])).collect();
            let (term, bars) = value_and_gradient_of(|shared| self.term(shared, &datum), shared);
            total += term;
            for (sum, bar) in gradient.iter_mut().zip(bars) {
                *sum += bar;
            }
        }
        (total, gradient)
    }
}

/// A register of a column, from the datum `first` on.
#[inline(always)]
fn load<R: Real, L: Lane<R>>(column: &[f64], first: usize) -> L {
    let mut lanes = [R::zero(); WIDEST];
    for lane in 0..L::N {
        lanes[lane] = R::lit(column[first + lane]);
    }
    L::load(&lanes)
}

impl<S: Summand> Fused for Sum<S> {
    type Saved<R: Real> = Vec<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        vec![R::vectorize(Value {
            sum: self,
            shared: inputs[0],
        })]
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Vec<R>) {
        let shared = inputs[0];
        if self.data.count == 0 {
            // Without a datum its length is not known, and the summand cannot be recorded.
            return (vec![R::zero()], vec![R::zero(); shared.len()]);
        }
        let width = self.data.columns.len();
        let (result, recording) = record(Recording::default(), || {
            let datum: Vec<Symbol> = (0..width).map(Symbol::input).collect();
            let shared: Vec<Symbol> = (0..shared.len()).map(Symbol::shared).collect();
            self.term(&shared, &datum)
        });
        let (value, gradient) = if recording.unfit {
            self.by_tape(shared)
        } else {
            R::vectorize(ValueAndGradient {
                data: &self.data,
                plan: &Plan::new(&recording.ops, result.0),
                shared,
            })
        };
        (vec![value], gradient)
    }

    fn reverse<R: Real>(&self, gradient: &mut Vec<R>, y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        let chain = |&partial| R::chain(partial, y_bar[0]);
        vec![gradient.iter().map(chain).collect()]
    }
}

struct Value<'a, S, R> {
    sum: &'a Sum<S>,
    shared: &'a [R],
}

impl<R: Real, S: Summand> Vectorized<R> for Value<'_, S, R> {
    type Output = R;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> R {
        let Sum { summand, data } = self.sum;
        let Data { count, columns, .. } = data;
        let mut shared = Vec::with_capacity(self.shared.len());
        for &number in self.shared {
            shared.push(L::splat(number));
        }
        let mut datum = vec![L::zero(); columns.len()];
        let mut scratch = vec![L::zero(); summand.scratch()];
        let (mut total, mut terms) = (R::zero(), [R::zero(); WIDEST]);
        for first in (0..*count).step_by(L::N) {
            for (number, column) in datum.iter_mut().zip(&columns[..]) {
                *number = load(column, first);
            }
            summand
                .eval(&shared, &datum, &mut scratch)
                .store(&mut terms);
            for &term in &terms[..L::N.min(count - first)] {
                total += term;
            }
        }
        total
    }
}

struct ValueAndGradient<'a, R> {
    data: &'a Data,
    plan: &'a Plan,
    shared: &'a [R],
}

impl<R: Real> Vectorized<R> for ValueAndGradient<'_, R> {
    type Output = (R, Vec<R>);
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> (R, Vec<R>) {
        if self.data.count <= L::N {
            self.replay::<L, 1>()
        } else {
            self.replay::<L, WIDE>()
        }
    }
}

impl<R: Real> ValueAndGradient<'_, R> {
    /// With `W` registers for each number.
    #[inline(always)]
    fn replay<L: Lane<R>, const W: usize>(self) -> (R, Vec<R>) {
        let Data { count, columns, .. } = self.data;
        let mut replay = Replay::<R, L, W>::new(self.plan, columns.len(), self.shared);
        let mut total = R::zero();
        for first in (0..*count).step_by(W * L::N) {
            for (input, column) in columns.iter().enumerate() {
                let mut block = [L::zero(); W];
                for w in 0..W {
                    block[w] = load(column, first + w * L::N);
                }
                replay.set_input(input, block);
            }
            let terms = replay.forward();
            let mut bars = terms;
            for w in 0..W {
                // Past the last datum there are copies of it, which do not count.
                let counted = count.saturating_sub(first + w * L::N).min(L::N);
                let mut lanes = [R::zero(); WIDEST];
                terms[w].store(&mut lanes);
                for lane in 0..counted {
                    total += lanes[lane];
                }
                for (lane, bar) in lanes.iter_mut().enumerate() {
                    *bar = if lane < counted { R::one() } else { R::zero() };
                }
                bars[w] = L::load(&lanes);
            }
            replay.reverse(bars);
        }
        (total, replay.into_gradient())
    }
}
