//! Replays a recorded function at many points.

use autodiff::Real;
use autodiff::internal::{WIDEST, of_floats, replaying};
use autodiff::simd::{Lane, Vectorized};

use super::block::Block;
use super::plan::Plan;
use super::sweep::{Replay, WIDE};

/// A recorded function, the points at which to replay it, and what to compute.
pub(crate) struct Points<'a, R> {
    pub(crate) plan: &'a Plan,
    /// The arguments that all points share.
    pub(crate) shared: &'a [R],
    pub(crate) count: usize,
    pub(crate) inputs: PointInputs<'a, R>,
    pub(crate) wanted: Wanted<'a, R>,
}

/// The values of the inputs: for each input, a list of its values at all points.
#[derive(Clone, Copy)]
pub(crate) enum PointInputs<'a, R> {
    Data(&'a [Vec<f64>]),
    Numbers(&'a [&'a [R]]),
}

/// What a replay computes in addition to the results of the function.
#[derive(Clone, Copy)]
pub(crate) enum Wanted<'a, R> {
    /// Nothing in addition: only the results.
    Results,
    /// The gradient, with respect to the shared arguments, of the sum of the first result over all points.
    ByShared,
    /// The cotangents of the inputs at each point, given the cotangents of the results at each point. `None` gives the
    /// first result the cotangent 1, so that the output is the gradient of the first result.
    ByInputs(Option<&'a [Vec<R>]>),
}

/// The output of a replay. Fields that were not wanted are empty.
pub(crate) struct Replayed<R> {
    /// For each result, its values at all points.
    pub(crate) results: Vec<Vec<R>>,
    pub(crate) by_shared: Vec<R>,
    /// For each input, its cotangents at all points.
    pub(crate) by_inputs: Vec<Vec<R>>,
}

impl<'a, R: Real> Points<'a, R> {
    /// Runs the replay. This crate compiles it for floats, once for all crates that replay.
    pub(crate) fn replay(self) -> Replayed<R> {
        if const { !R::IS_FLOAT } {
            let _replaying = replaying();
            return R::vectorize(self);
        }
        type Replay<R> = fn(Points<R>) -> Replayed<R>;
        let replay: Replay<R> =
            of_floats(replay_double as Replay<f64>, replay_single as Replay<f32>);
        replay(self)
    }

    fn width(&self) -> usize {
        match self.inputs {
            PointInputs::Data(columns) => columns.len(),
            PointInputs::Numbers(columns) => columns.len(),
        }
    }
}

#[inline(never)]
fn replay_double(points: Points<f64>) -> Replayed<f64> {
    f64::vectorize(points)
}

#[inline(never)]
fn replay_single(points: Points<f32>) -> Replayed<f32> {
    f32::vectorize(points)
}

impl<R: Real> Vectorized<R> for Points<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = Replayed<R>;
    const HAS_512: bool = false;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> Replayed<R> {
        // Number types without SIMD registers gain little from blocks, and another copy of the code would be compiled
        // for each.
        if const { L::N > 1 } && self.count > L::N {
            self.in_blocks::<L, WIDE>()
        } else {
            self.in_blocks::<L, 1>()
        }
    }
}

impl<R: Real> Points<'_, R> {
    /// Runs the replay with blocks of `W` registers.
    #[inline(always)]
    fn in_blocks<L: Lane<R>, const W: usize>(self) -> Replayed<R> {
        let (count, width) = (self.count, self.width());
        let by_inputs = matches!(self.wanted, Wanted::ByInputs(_));
        let passive = if by_inputs { 0 } else { width };
        let differentiates = !matches!(self.wanted, Wanted::Results);
        let mut replay = Replay::<R, L, W>::new(self.plan, passive, self.shared, differentiates);
        let mut replayed = Replayed {
            results: columns(self.plan.results.len(), count),
            by_shared: Vec::new(),
            by_inputs: columns(width - passive, count),
        };
        for (block, first) in (0..count).step_by(W * L::N).enumerate() {
            if block > 0 && block % (128 / W) == 0 && differentiates {
                replay.settle();
            }
            for input in 0..width {
                let mut block = [L::zero(); W];
                for w in 0..W {
                    block[w] = self.input(input, first + w * L::N);
                }
                replay.set_input(input, block);
            }
            replay.forward();
            for (k, result) in replayed.results.iter_mut().enumerate() {
                append(result, replay.result(k), count);
            }
            match self.wanted {
                Wanted::Results => continue,
                Wanted::ByInputs(Some(bars)) => {
                    for (k, bars) in bars.iter().enumerate() {
                        replay.seed(k, numbers_from(bars, first));
                    }
                }
                Wanted::ByShared | Wanted::ByInputs(None) => replay.seed(0, ones(count - first)),
            }
            replay.reverse();
            for (input, bars) in replayed.by_inputs.iter_mut().enumerate() {
                append(bars, replay.take_input_bar(input), count);
            }
        }
        replayed.by_shared = replay.into_gradient();
        replayed
    }

    /// Loads an input at a register of points, beginning with point `first`. Lanes past the last point repeat its
    /// value.
    #[inline(always)]
    fn input<L: Lane<R>>(&self, input: usize, first: usize) -> L {
        let (last, is_whole) = (self.count - 1, first + L::N <= self.count);
        match self.inputs {
            PointInputs::Data(columns) if L::N == 1 => L::lit(columns[input][first]),
            PointInputs::Data(columns) => {
                let (column, mut lanes) = (&columns[input], [R::zero(); WIDEST]);
                if is_whole {
                    for (lane, &number) in lanes.iter_mut().zip(&column[first..first + L::N]) {
                        *lane = R::lit(number);
                    }
                } else {
                    for lane in 0..L::N {
                        lanes[lane] = R::lit(column[(first + lane).min(last)]);
                    }
                }
                L::load(&lanes)
            }
            PointInputs::Numbers(columns) if is_whole => L::load(&columns[input][first..]),
            PointInputs::Numbers(columns) => {
                let mut lanes = [R::zero(); WIDEST];
                for lane in 0..L::N {
                    lanes[lane] = columns[input][(first + lane).min(last)];
                }
                L::load(&lanes)
            }
        }
    }
}

/// Returns empty columns, each with room for `count` numbers.
fn columns<R>(columns: usize, count: usize) -> Vec<Vec<R>> {
    (0..columns).map(|_| Vec::with_capacity(count)).collect()
}

/// Appends the numbers of a block to a column, up to a length of `count`.
#[inline(always)]
fn append<R: Real, L: Lane<R>, const W: usize>(to: &mut Vec<R>, block: Block<L, W>, count: usize) {
    for w in 0..W {
        let from = to.len();
        to.resize(count.min(from + L::N), R::zero());
        block[w].store_up_to(&mut to[from..]);
    }
}

/// Loads a block from index `first` on. Lanes past the end are zero.
#[inline(always)]
fn numbers_from<R: Real, L: Lane<R>, const W: usize>(numbers: &[R], first: usize) -> Block<L, W> {
    let mut block = [L::zero(); W];
    for w in 0..W {
        block[w] = L::load_up_to(&numbers[numbers.len().min(first + w * L::N)..]);
    }
    block
}

/// Returns a block whose first `count` lanes are one. The others are zero.
#[inline(always)]
fn ones<R: Real, L: Lane<R>, const W: usize>(count: usize) -> Block<L, W> {
    let mut block = [L::one(); W];
    for w in 0..W {
        let counted = count.saturating_sub(w * L::N);
        if counted < L::N {
            block[w] = L::select(L::mask((1 << counted) - 1), L::one(), L::zero());
        }
    }
    block
}
