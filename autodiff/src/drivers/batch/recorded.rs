//! A function that is recorded once for all points.

use std::fmt;

use super::plan::Plan;
use super::replay::{Replay, WIDE};
use crate::drivers::Function;
use crate::real::Real;
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
            plan: Plan::new(&recording.ops, result.0),
        })
    }

    /// The value and the gradient at a point.
    ///
    /// # Panics
    /// If the point has not as many numbers as the function has arguments.
    pub fn value_and_gradient<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        self.expect(x.len());
        let (values, gradients) = self.at(1, x.to_vec()).replay::<R, 1>();
        (values[0], gradients)
    }

    /// The values and gradients at many points.
    ///
    /// # Panics
    /// If a point has not as many numbers as the function has arguments.
    pub fn values_and_gradients<R: Real>(&self, points: &[impl AsRef<[R]>]) -> Vec<(R, Vec<R>)> {
        let mut numbers = Vec::with_capacity(points.len() * self.arguments);
        for point in points {
            let point = point.as_ref();
            self.expect(point.len());
            numbers.extend_from_slice(point);
        }
        let (values, gradients) = R::vectorize(self.at(points.len(), numbers));
        let gradient = |k: usize| gradients[k * self.arguments..][..self.arguments].to_vec();
        let both = values.into_iter().enumerate();
        both.map(|(k, value)| (value, gradient(k))).collect()
    }

    /// The work at `count` points, whose numbers follow one another.
    fn at<R: Real>(&self, count: usize, numbers: Vec<R>) -> Points<'_, R> {
        Points {
            of: self,
            count,
            numbers,
        }
    }

    fn expect(&self, len: usize) {
        let arguments = self.arguments;
        assert!(
            len == arguments,
            "{len} numbers for a function of {arguments} arguments"
        );
    }
}

/// Not generic over how a caller holds points: the replay is a lot of code.
struct Points<'a, R> {
    of: &'a Recorded,
    count: usize,
    numbers: Vec<R>,
}

impl<R: Real> Vectorized<R> for Points<'_, R> {
    type Output = (Vec<R>, Vec<R>);
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> Self::Output {
        self.replay::<L, WIDE>()
    }
}

impl<R: Real> Points<'_, R> {
    /// The values, and the gradients one after the other, with `W` registers for each number.
    #[inline(always)]
    fn replay<L: Lane<R>, const W: usize>(self) -> (Vec<R>, Vec<R>) {
        let Recorded {
            arguments,
            ref plan,
        } = *self.of;
        let mut replay = Replay::<R, L, W>::new(plan, 0, &[]);
        let mut values = Vec::with_capacity(self.count);
        let mut gradients = vec![R::zero(); self.numbers.len()];
        let mut lanes = [R::zero(); WIDEST];
        for first in (0..self.count).step_by(W * L::N) {
            for input in 0..arguments {
                let mut block = [L::zero(); W];
                for w in 0..W {
                    for lane in 0..L::N {
                        // Past the last point it is repeated.
                        let point = (first + w * L::N + lane).min(self.count - 1);
                        lanes[lane] = self.numbers[point * arguments + input];
                    }
                    block[w] = L::load(&lanes);
                }
                replay.set_input(input, block);
            }
            let value = replay.forward();
            replay.reverse([L::one(); W]);
            for w in 0..W {
                value[w].store(&mut lanes);
                let left = self.count.saturating_sub(first + w * L::N);
                values.extend_from_slice(&lanes[..L::N.min(left)]);
            }
            for input in 0..arguments {
                let bar = replay.take_input_bar(input);
                for w in 0..W {
                    bar[w].store(&mut lanes);
                    for lane in 0..L::N {
                        let point = first + w * L::N + lane;
                        if point < self.count {
                            gradients[point * arguments + input] = lanes[lane];
                        }
                    }
                }
            }
        }
        (values, gradients)
    }
}
