//! A function that is recorded once for all points.

use std::fmt;

use super::plan::Plan;
use super::replay::{Replay, WIDE};
use crate::drivers::Function;
use crate::real::Real;
use crate::record::operation::Place;
use crate::record::recording::{Recording, record};
use crate::record::symbol::Symbol;
use crate::simd::{Lane, Vectorized, WIDEST};

/// A function recorded once, without values, and replayed forward and back at any number of points, in
/// lanes over the points.
///
/// Code without values cannot take another branch at another point: what it would need for that, the
/// primal of a number, is refused when it is recorded.
///
/// ```
/// use autodiff::batch::Recorded;
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
/// # Ok::<(), autodiff::batch::NeedsValues>(())
/// ```
#[derive(Clone, Debug)]
pub struct Recorded {
    arguments: usize,
    plan: Plan,
    result: Place,
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
        let (result, recording) = record(Recording::default(), || {
            let x: Vec<Symbol> = (0..arguments).map(Symbol::input).collect();
            function.eval(&x)
        });
        if recording.unfit {
            return Err(NeedsValues {});
        }
        Ok(Self {
            arguments,
            plan: Plan::new(&recording.ops),
            result: result.0,
        })
    }

    /// The value and the gradient at a point.
    ///
    /// # Panics
    /// If the point has not as many numbers as the function has arguments.
    pub fn value_and_gradient<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        let points = [x];
        let mut both = Points {
            of: self,
            points: &points,
        }
        .replay::<R, R, 1>();
        both.remove(0)
    }

    /// The values and gradients at many points.
    ///
    /// # Panics
    /// If a point has not as many numbers as the function has arguments.
    pub fn values_and_gradients<R: Real>(&self, points: &[impl AsRef<[R]>]) -> Vec<(R, Vec<R>)> {
        R::vectorize(Points { of: self, points })
    }
}

struct Points<'a, P> {
    of: &'a Recorded,
    points: &'a [P],
}

impl<R: Real, P: AsRef<[R]>> Vectorized<R> for Points<'_, P> {
    type Output = Vec<(R, Vec<R>)>;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> Self::Output {
        if self.points.len() <= L::N {
            self.replay::<R, L, 1>()
        } else {
            self.replay::<R, L, WIDE>()
        }
    }
}

impl<P> Points<'_, P> {
    /// With `W` registers for each number.
    #[inline(always)]
    fn replay<R: Real, L: Lane<R>, const W: usize>(self) -> Vec<(R, Vec<R>)>
    where
        P: AsRef<[R]>,
    {
        let Recorded {
            arguments,
            ref plan,
            result,
        } = *self.of;
        let mut replay = Replay::<R, L, W>::new(plan, 0, &[]);
        let mut both = Vec::with_capacity(self.points.len());
        for points in self.points.chunks(W * L::N) {
            for point in points {
                let len = point.as_ref().len();
                assert!(
                    len == arguments,
                    "{len} numbers for a function of {arguments} arguments"
                );
            }
            for input in 0..arguments {
                // Past the last point it is repeated.
                let at = |k: usize| points[k.min(points.len() - 1)].as_ref()[input];
                let mut block = [L::zero(); W];
                let mut lanes = [R::zero(); WIDEST];
                for w in 0..W {
                    for lane in 0..L::N {
                        lanes[lane] = at(w * L::N + lane);
                    }
                    block[w] = L::load(&lanes);
                }
                replay.set_input(input, block);
            }
            let values = replay.forward(result);
            replay.reverse(result, [L::one(); W]);
            let first = both.len();
            let numbers = lanes_of::<R, L, W>(values);
            both.extend(
                numbers
                    .take(points.len())
                    .map(|y| (y, Vec::with_capacity(arguments))),
            );
            for input in 0..arguments {
                let bars = lanes_of::<R, L, W>(replay.take_input_bar(input));
                for ((_, gradient), bar) in both[first..].iter_mut().zip(bars) {
                    gradient.push(bar);
                }
            }
        }
        both
    }
}

/// The numbers of a block, point by point.
#[inline(always)]
fn lanes_of<R: Real, L: Lane<R>, const W: usize>(block: [L; W]) -> impl Iterator<Item = R> {
    let mut numbers = Vec::with_capacity(W * L::N);
    let mut lanes = [R::zero(); WIDEST];
    for w in 0..W {
        block[w].store(&mut lanes);
        numbers.extend_from_slice(&lanes[..L::N]);
    }
    numbers.into_iter()
}
