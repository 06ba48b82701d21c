//! The buffers that a replay computes in.

use autodiff::internal::pool::Pooled;
use autodiff::internal::{SumByParts, pool};
use autodiff::simd::Lane;
use autodiff::{Mask, Real};

use super::block::Block;
use super::plan::{Plan, ReplayedLayer, Step};
use crate::arrays::Aligned;
use crate::record::arithmetic::number;
use crate::record::operation::Op;

/// The buffers of a replay. A thread keeps them for its next replay. Numbers that differ from point to point are called
/// "own", in contrast to shared arguments.
pub(super) struct ReplayBuffers<R, L, const W: usize> {
    /// The shared arguments that operations outside of layers read.
    pub(super) read: Vec<R>,
    /// The cotangents of `read`. Each lane holds a partial sum: the sum over the points that this lane has processed.
    pub(super) read_bars: Vec<L>,
    /// The contribution of layers to the cotangents of all shared arguments.
    pub(super) gradient: Vec<R>,
    /// The sums that [`settle`](Self::settle) has taken out of `read_bars` and `gradient`. `None` before its first call.
    settled: Option<(SumByParts<L>, SumByParts<R>)>,
    /// For each layer, whether all its weights are finite.
    pub(super) finite: Vec<bool>,
    /// The result of each operation at the current block of points.
    pub(super) values: Vec<Block<L, W>>,
    /// The cotangent of each operation's result at the current block of points.
    pub(super) bars: Vec<Block<L, W>>,
    /// The partial derivatives of functions of one number. The forward sweep stores them for the reverse sweep.
    pub(super) partials: Vec<Block<L, W>>,
    /// The own inputs of a layer (`own`), the cotangents of these inputs (`own_bars`), and the results of the layer's
    /// rows (`rows`). All three are stored block by block.
    pub(super) own: Aligned<R>,
    pub(super) own_bars: Aligned<R>,
    pub(super) rows: Aligned<R>,
    /// The own inputs of a layer (those that differ from point to point), stored point by point.
    pub(super) by_point: Aligned<R>,
}

impl<R: Real, L: Lane<R>, const W: usize> ReplayBuffers<R, L, W> {
    /// Takes the buffers of the thread's last replay of this number type and prepares them for a plan.
    #[inline(always)]
    pub(super) fn taken(plan: &Plan, shared: &[R]) -> Box<Self> {
        let mut memory = pool::take::<ReplayBuffers<R, L, W>>().unwrap_or_else(|| {
            Box::new(ReplayBuffers {
                read: Vec::new(),
                read_bars: Vec::new(),
                gradient: Vec::new(),
                settled: None,
                finite: Vec::new(),
                values: Vec::new(),
                bars: Vec::new(),
                partials: Vec::new(),
                own: Aligned::zeros(0),
                own_bars: Aligned::zeros(0),
                rows: Aligned::zeros(0),
                by_point: Aligned::zeros(0),
            })
        });
        memory.read.clear();
        match &plan.read {
            Some(read) => memory.read.extend(read.iter().map(|&at| shared[at])),
            None => memory.read.extend_from_slice(shared),
        }
        memory.read_bars.clear();
        memory.read_bars.resize(memory.read.len(), L::zero());
        memory.gradient.clear();
        memory.gradient.resize(shared.len(), R::zero());
        memory.settled = None;
        memory.finite.clear();
        let finite =
            |layer: &ReplayedLayer| layer.matrix(shared).all_finite([layer.rows, layer.columns]);
        memory.finite.extend(plan.layers.iter().map(finite));
        let (steps, zero) = (plan.steps.len(), [L::zero(); W]);
        memory.bars.clear();
        memory.bars.resize(steps, zero);
        // Every value and partial is written before it is read, so old contents may stay.
        memory.values.resize(steps, zero);
        memory.partials.resize(steps, zero);
        for (place, step) in plan.steps.iter().enumerate() {
            let value = match *step {
                Step::Single(Op::Input(_)) => {
                    memory.partials[place] = zero;
                    continue;
                }
                Step::Single(Op::Constant(bits)) => L::lit(f64::from_bits(bits)),
                Step::Single(Op::Always(holds)) => number(L::Mask::splat(holds)),
                _ => continue,
            };
            memory.values[place] = [value; W];
        }
        memory
    }

    /// Moves the sums over the last points to [`settled`](Self::settled). Adding many numbers to one sum would lose their
    /// last digits, which matters in `f32`.
    #[inline(always)]
    pub(super) fn settle(&mut self) {
        let (shared_bars, all) = (self.read_bars.len(), self.gradient.len());
        let empty = || (SumByParts::new(shared_bars), SumByParts::new(all));
        let (bars, gradient) = self.settled.get_or_insert_with(empty);
        bars.add(&self.read_bars);
        gradient.add(&self.gradient);
        self.read_bars.fill(L::zero());
        self.gradient.fill(R::zero());
    }

    /// Moves the sums over all points back to `read_bars` and `gradient`.
    #[inline(always)]
    pub(super) fn take_settled(&mut self) {
        if self.settled.is_none() {
            return;
        }
        self.settle();
        if let Some((bars, gradient)) = self.settled.take() {
            self.read_bars = bars.total();
            self.gradient = gradient.total();
        }
    }
}

impl<R: Real, L: Lane<R>, const W: usize> Pooled for ReplayBuffers<R, L, W> {
    fn bytes(&self) -> usize {
        let numbers = self.read.capacity() + self.gradient.capacity();
        let blocks = [&self.values, &self.bars, &self.partials].map(Vec::capacity);
        let aligned = [&self.own, &self.own_bars, &self.rows, &self.by_point];
        numbers * size_of::<R>()
            + self.read_bars.capacity() * size_of::<L>()
            + self.finite.capacity()
            + blocks.iter().sum::<usize>() * size_of::<Block<L, W>>()
            + aligned.map(Pooled::bytes).iter().sum::<usize>()
    }
}
