//! Weighted arrays: each element is multiplied by its weight. Some arrays are centred first: their weighted mean is
//! subtracted.
//!
//! One operation for all of this pays: made of kernels, gathers and a dense layer of ones, it makes the gradient of a
//! net of 36 nodes that a network drives take 1.2 times as long.

use std::slice::ChunksExact;

use autodiff::Real;
use autodiff::simd::Lane;
use autodiff_programs::operations::{ArrayOperation, Forward, Reverse, each};
use autodiff_programs::{Array, Program};

use crate::kernel;

/// Records the product of arrays with `weights`, element by element. The arrays of `offsets` are first centred: their
/// weighted mean is subtracted. Returns two arrays:
/// - one that joins the weighted arrays of `offsets`, the weighted arrays of `values`, and `others` unchanged,
/// - the weighted means of the arrays of `offsets`, one after the other.
///
/// The mean is `sum w x / sum w`, so elements with weight 0 do not count. The mean is NaN if all weights are 0.
pub(crate) fn weighted(
    program: &mut Program,
    weights: Array,
    [offsets, values, others]: [&[Array]; 3],
) -> [Array; 2] {
    let weighed = offsets.len() + values.len();
    let appended: usize = others.iter().map(|array| array.len()).sum();
    let operation = Weighted {
        offsets: offsets.len(),
        weighed,
    };
    let inputs = [&[weights], offsets, values, others].concat();
    let lens = [weighed * weights.len() + appended, offsets.len(), 1];
    let outputs = program.operation(operation, &inputs, &lens);
    [outputs[0], outputs[1]]
}

/// The operation of `weighted`. Its inputs are the weights, the arrays that are multiplied by them, and the others. Its
/// outputs are these arrays, the means, and the sum of the weights.
///
/// The number of arrays is a run-time value: compiling one instance for each number of arrays would need half a megabyte of
/// code.
#[derive(Clone, Copy, Debug)]
pub struct Weighted {
    /// The number of centred arrays, which come first.
    pub offsets: usize,
    /// The number of arrays that are multiplied by the weights.
    pub weighed: usize,
}

#[kernel]
impl ArrayOperation for Weighted {
    fn forward<R: Real, L: Lane<R>>(&self, Forward { x, y, .. }: Forward<R>) {
        let (weights, starts) = (x.get(0), x.starts());
        let len = weights.len();
        let (mut rest, means) = y.split_at_mut(y.len() - (self.offsets + 1) * starts);
        let total = sum::<R, L>(weights, None, starts);
        for c in 0..self.weighed {
            let (numbers, mut mean) = (x.get(1 + c), L::zero());
            if c < self.offsets {
                let products = sum::<R, L>(weights, Some(numbers), starts);
                mean = L::load(&products) / L::load(&total);
                mean.store_up_to(&mut means[c * starts..][..starts]);
            }
            let (to, others) = rest.split_at_mut(len);
            weigh(to, weights, numbers, mean);
            rest = others;
        }
        means[self.offsets * starts..].copy_from_slice(&total[..starts]);
        for k in 1 + self.weighed..x.count() {
            let (to, others) = rest.split_at_mut(x.get(k).len());
            to.copy_from_slice(x.get(k));
            rest = others;
        }
    }

    /// The reverse of a centred array `x` with the weights `w`. With `r = y_bar - (sum of w y_bar - mean_bar) / (sum of
    /// w)`, the cotangent of `x` is `w r`, and `(x - mean) r` is added to the cotangent of `w`.
    fn reverse<R: Real, L: Lane<R>>(&self, step: Reverse<R>) {
        let Reverse { x, y, y_bar, .. } = step;
        let (mut x_bar, of_weights) = (step.x_bar, step.scratch);
        let (weights, starts) = (x.get(0), x.starts());
        let (len, first) = (weights.len(), y.len() - (self.offsets + 1) * starts);
        let total: L = each(&y[first + self.offsets * starts..], starts);
        of_weights.clear();
        of_weights.resize(len, R::zero());
        for c in 0..self.weighed {
            let (numbers, y_bar_of) = (x.get(1 + c), &y_bar[c * len..][..len]);
            let (mut mean, mut shift) = (L::zero(), L::zero());
            if c < self.offsets {
                mean = each(&y[first + c * starts..][..starts], starts);
                let mean_bar: L = each(&y_bar[first + c * starts..][..starts], starts);
                let product = sum::<R, L>(weights, Some(y_bar_of), starts);
                shift = (L::load(&product) - mean_bar) / total;
            }
            if let Some(bar) = x_bar.get_mut(1 + c) {
                add_weighed(bar, weights, y_bar_of, shift);
            }
            add_products(of_weights, y_bar_of, shift, numbers, mean);
        }
        if let Some(bar) = x_bar.get_mut(0) {
            add::<R, L>(bar, of_weights);
        }
        let mut from = self.weighed * len;
        for k in 1 + self.weighed..x.count() {
            let end = from + x.get(k).len();
            if let Some(bar) = x_bar.get_mut(k) {
                add::<R, L>(bar, &y_bar[from..end]);
            }
            from = end;
        }
    }
}

// The loops below take whole registers, and then the rest: so they need no bounds checks.

/// Writes `weights * (x - mean)`.
#[kernel]
fn weigh<R: Real, L: Lane<R>>(to: &mut [R], weights: &[R], x: &[R], mean: L) {
    let (mut to, w, x) = (
        to.chunks_exact_mut(L::N),
        whole::<R, L>(weights),
        whole::<R, L>(x),
    );
    for ((to, w), x) in to.by_ref().zip(w.clone()).zip(x.clone()) {
        (L::load(w) * (L::load(x) - mean)).store(to);
    }
    let to = to.into_remainder();
    if !to.is_empty() {
        let offset = L::load_part(x.remainder()) - mean;
        (L::load_part(w.remainder()) * offset).store_part(to);
    }
}

/// Adds `weights * (bars - shift)`.
#[kernel]
fn add_weighed<R: Real, L: Lane<R>>(to: &mut [R], weights: &[R], bars: &[R], shift: L) {
    let (mut to, w) = (to.chunks_exact_mut(L::N), whole::<R, L>(weights));
    let bars = whole::<R, L>(bars);
    for ((to, w), bar) in to.by_ref().zip(w.clone()).zip(bars.clone()) {
        (L::load(to) + L::load(w) * (L::load(bar) - shift)).store(to);
    }
    let to = to.into_remainder();
    if !to.is_empty() {
        let rest = L::load_part(bars.remainder()) - shift;
        (L::load_part(to) + L::load_part(w.remainder()) * rest).store_part(to);
    }
}

/// Adds `(bars - shift) * (x - mean)`, rounded once.
#[kernel]
fn add_products<R: Real, L: Lane<R>>(to: &mut [R], bars: &[R], shift: L, x: &[R], mean: L) {
    let (mut to, x) = (to.chunks_exact_mut(L::N), whole::<R, L>(x));
    let bars = whole::<R, L>(bars);
    for ((to, bar), x) in to.by_ref().zip(bars.clone()).zip(x.clone()) {
        let (rest, offset) = (L::load(bar) - shift, L::load(x) - mean);
        rest.fma(offset, L::load(to)).store(to);
    }
    let to = to.into_remainder();
    if !to.is_empty() {
        let rest = L::load_part(bars.remainder()) - shift;
        let offset = L::load_part(x.remainder()) - mean;
        rest.fma(offset, L::load_part(to)).store_part(to);
    }
}

/// Adds numbers to others.
#[kernel]
fn add<R: Real, L: Lane<R>>(to: &mut [R], numbers: &[R]) {
    let (mut to, numbers) = (to.chunks_exact_mut(L::N), whole::<R, L>(numbers));
    for (to, number) in to.by_ref().zip(numbers.clone()) {
        (L::load(to) + L::load(number)).store(to);
    }
    let to = to.into_remainder();
    if !to.is_empty() {
        (L::load_part(to) + L::load_part(numbers.remainder())).store_part(to);
    }
}

/// The whole registers of a list.
#[kernel]
fn whole<R: Real, L: Lane<R>>(numbers: &[R]) -> ChunksExact<'_, R> {
    numbers.chunks_exact(L::N)
}

/// The number of partial sums of each sum: the lanes of the widest register. It is the same for all register widths, so that
/// the sums have the same bits for all of them.
const PARTS: usize = 16;

/// A register of numbers that repeat: one number for each start (initial state).
type Each<R> = [R; PARTS];

/// For each start, returns the sum of `weights`, or of the products of `weights` and `x`.
#[kernel]
fn sum<R: Real, L: Lane<R>>(weights: &[R], x: Option<&[R]>, starts: usize) -> Each<R> {
    // If the number of registers is a constant, the partial sums stay in registers, unless the numbers are too large.
    if starts == 1 && const { L::N > 1 || size_of::<R>() <= size_of::<f64>() } {
        sum_in::<R, L>(weights, x, const { PARTS / L::N }, 1)
    } else if starts == 2 && const { L::N > 1 } {
        sum_in::<R, L>(weights, x, const { 2 * PARTS / L::N }, 2)
    } else {
        sum_in::<R, L>(weights, x, PARTS * starts / L::N, starts)
    }
}

/// Computes [`sum`] with `registers` registers of partial sums.
#[kernel]
fn sum_in<R: Real, L: Lane<R>>(
    weights: &[R],
    x: Option<&[R]>,
    registers: usize,
    starts: usize,
) -> Each<R> {
    let mut parts = [L::zero(); PARTS];
    let all = weights.chunks_exact(registers * L::N);
    let rest = all.remainder();
    match x {
        Some(x) => {
            let x = x.chunks_exact(registers * L::N);
            for (weights, x) in all.zip(x.clone()) {
                for k in 0..registers {
                    let (weight, x) = (&weights[k * L::N..], &x[k * L::N..]);
                    parts[k] = L::load(weight).fma(L::load(x), parts[k]);
                }
            }
            let pairs = rest.chunks(L::N).zip(x.remainder().chunks(L::N));
            for (part, (weight, x)) in parts.iter_mut().zip(pairs) {
                *part = L::load_up_to(weight).fma(L::load_up_to(x), *part);
            }
        }
        None => {
            for weights in all {
                for k in 0..registers {
                    parts[k] += L::load(&weights[k * L::N..]);
                }
            }
            for (part, weight) in parts.iter_mut().zip(rest.chunks(L::N)) {
                *part += L::load_up_to(weight);
            }
        }
    }
    folded(&mut parts, registers, starts)
}

/// Adds up the partial sums of each start.
#[kernel]
fn folded<R: Real, L: Lane<R>>(parts: &mut [L; PARTS], registers: usize, starts: usize) -> Each<R> {
    let mut n = registers;
    while n > 1 {
        n /= 2;
        for k in 0..n {
            let other = parts[k + n];
            parts[k] += other;
        }
    }
    let mut sums = [R::zero(); PARTS];
    parts[0].store(&mut sums);
    let mut n = L::N;
    while n > starts {
        n /= 2;
        for k in 0..n {
            let other = sums[k + n];
            sums[k] += other;
        }
    }
    for k in starts..L::N {
        sums[k] = sums[k - starts];
    }
    sums
}
