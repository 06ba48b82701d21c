//! Weighted arrays: each element is multiplied by its weight. Some arrays are centred first: their weighted mean is
//! subtracted.
//!
//! One operation for all of this pays: made of kernels, gathers and a dense layer of ones, it makes the gradient of a
//! net of 36 nodes that a network drives take 1.2 times as long.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use autodiff::Real;
use autodiff::internal::{Unchecked, WIDEST, fits_registers};
use autodiff::simd::Lane;
use smallvec::SmallVec;

use super::array::Array;
use super::operation::LaneOperation;
use super::row::{Bars, Places, Reach, StepValues, add};

/// Implements [`Program::weighted`](super::Program::weighted). The number of arrays is a run-time value: compiling one
/// instance for each number of arrays would need half a megabyte of code.
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
pub struct Weighted {
    pub weights: Array,
    /// The arrays that are multiplied by the weights. The arrays that are centred come first.
    pub weighed: Vec<Array>,
    /// The number of centred arrays.
    pub offsets: usize,
    /// Arrays that are appended to the result unchanged.
    pub others: Vec<Array>,
    /// Three adjacent arrays. The first consists of the weighted arrays, followed by `others`. The second has the
    /// means, the third the sum of the weights.
    pub outputs: [Array; 3],
    /// For each array id, whether the array carries derivatives. If the list is empty, all arrays do.
    active: Vec<bool>,
    reach: Reach,
}

impl Weighted {
    pub(crate) fn new(
        weights: Array,
        [offsets, values]: [&[Array]; 2],
        others: &[Array],
        outputs: [Array; 3],
    ) -> Self {
        let weighed = [offsets, values].concat();
        let all = [&[weights][..], &weighed, others, &outputs].concat();
        Self {
            reach: Reach::new(all.into_iter().map(|array| (array, array.len))),
            active: Vec::new(),
            weights,
            weighed,
            offsets: offsets.len(),
            others: others.to_vec(),
            outputs,
        }
    }

    fn is_active(&self, array: Array) -> bool {
        self.active.get(array.id).copied().unwrap_or(true)
    }
}

impl<R: Real> LaneOperation<R> for Weighted {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.to_vec()
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        self.active = arrays.to_vec();
        true
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        self.reach.check(parameters, row);
        let (starts, len) = (self.weights.starts, self.weights.len);
        let (row, after) = row.split_at_mut(self.outputs[0].start);
        let values = StepValues { parameters, row };
        let weights = values.get(self.weights);
        let mut to = self.outputs[1].start - self.outputs[0].start;
        // SAFETY: all arrays are as long as the weights, and the outputs have room for the results of each.
        unsafe {
            let total = sum::<R, L>(weights, None, starts);
            for (c, &array) in self.weighed.iter().enumerate() {
                let (x, mut mean) = (values.get(array), L::zero());
                if c < self.offsets {
                    mean = L::load(&sum::<R, L>(weights, Some(x), starts)) / L::load(&total);
                    mean.store_n(after, to, starts.min(L::N));
                    to += starts;
                }
                for at in (0..len).step_by(L::N) {
                    let n = L::N.min(len - at);
                    let offset = L::load_n(x, at, n) - mean;
                    let weighed = L::load_n(weights, at, n) * offset;
                    weighed.store_n(after, c * len + at, n);
                }
            }
            after[to..to + starts].copy_from_slice(&total[..starts]);
        }
        let mut to = self.weighed.len() * len;
        for &other in &self.others {
            after[to..to + other.len].copy_from_slice(values.get(other));
            to += other.len;
        }
    }
    /// The reverse of a centred array `x` with the weights `w`. With `r = y_bar - (sum of w y_bar - mean_bar) / (sum of
    /// w)`, the cotangent of `x` is `w r`, and `(x - mean) r` is added to the cotangent of `w`.
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>) {
        self.reach.check(values.parameters, values.row);
        self.reach.check(bars.parameters, bars.row);
        let (starts, len) = (self.weights.starts, self.weights.len);
        let (begin, first) = (self.outputs[0].start, self.outputs[1].start);
        let Bars { parameters, row } = bars;
        let (row, after) = row.split_at_mut(begin);
        let mut bars = Bars { parameters, row };
        let weights = values.get(self.weights);
        let places = Places::new(&mut bars);
        let place = |array| match self.is_active(array) {
            true => places.of(array),
            false => std::ptr::null_mut(),
        };
        let means = &values.row[first..];
        let total = each::<R, L>(&means[self.offsets * starts..], starts);
        let mut all = SmallVec::<[Weighed<R, L>; 6]>::new();
        // SAFETY: `reach` was checked; inputs lie before outputs, and only one slice of cotangents exists at a time.
        unsafe {
            for (c, &array) in self.weighed.iter().enumerate() {
                let y_bar = &after[c * len..][..len];
                let (mut mean, mut shift) = (L::zero(), L::zero());
                if c < self.offsets {
                    mean = each(&means[c * starts..], starts);
                    let mean_bar: L = each(&after[first - begin + c * starts..], starts);
                    let product = sum::<R, L>(weights, Some(y_bar), starts);
                    shift = (L::load(&product) - mean_bar) / total;
                }
                all.push(Weighed {
                    x: values.get(array),
                    mean,
                    y_bar,
                    shift,
                    x_bar: place(array),
                });
            }
            let w_bar = place(self.weights);
            for at in (0..len).step_by(L::N) {
                let n = L::N.min(len - at);
                let weight = L::load_n(weights, at, n);
                let mut of_weight = L::zero();
                for array in &all {
                    let rest = L::load_n(array.y_bar, at, n) - array.shift;
                    add(array.x_bar, at, n, weight * rest);
                    let offset = L::load_n(array.x, at, n) - array.mean;
                    of_weight = rest.fma(offset, of_weight);
                }
                add(w_bar, at, n, of_weight);
            }
        }
        let mut from = self.weighed.len() * len;
        for &other in &self.others {
            if self.is_active(other) {
                let to = bars.get_mut(other).iter_mut();
                to.zip(&after[from..]).for_each(|(to, &bar)| *to += bar);
            }
            from += other.len;
        }
    }
}

/// The number of partial sums of each sum. It is the same for all register widths, so that the sums have the same bits
/// for all of them.
const PARTS: usize = WIDEST;

/// A register of numbers that repeat: one number for each start (initial state).
pub(super) type Each<R> = [R; WIDEST];

/// For each start, returns the sum of `weights`, or of the products of `weights` and `x`.
///
/// # Safety
/// `x` must be as long as the weights.
#[inline(always)]
pub(super) unsafe fn sum<R: Real, L: Lane<R>>(
    weights: &[R],
    x: Option<&[R]>,
    starts: usize,
) -> Each<R> {
    // SAFETY: guaranteed by the caller.
    unsafe {
        // If the number of registers is a constant, the partial sums stay in registers.
        if starts == 1 && const { fits_registers::<R, L>() } {
            sum_in::<R, L>(weights, x, const { PARTS / L::N }, 1)
        } else if starts == 2 && const { L::N > 1 } {
            sum_in::<R, L>(weights, x, const { 2 * PARTS / L::N }, 2)
        } else {
            sum_in::<R, L>(weights, x, PARTS * starts / L::N, starts)
        }
    }
}

/// Computes [`sum`] with `registers` registers of partial sums.
///
/// # Safety
/// `x` must be as long as the weights.
#[inline(always)]
unsafe fn sum_in<R: Real, L: Lane<R>>(
    weights: &[R],
    x: Option<&[R]>,
    registers: usize,
    starts: usize,
) -> Each<R> {
    let (mut parts, len, mut at) = ([L::zero(); PARTS], weights.len(), 0);
    // SAFETY: guaranteed by the caller; all indices are below `len`.
    unsafe {
        while at + registers * L::N <= len {
            for k in 0..registers {
                add_term(&mut parts[k], weights, x, at, L::N);
                at += L::N;
            }
        }
        for k in 0..registers {
            if at < len {
                add_term(&mut parts[k], weights, x, at, L::N.min(len - at));
                at += L::N;
            }
        }
    }
    folded(&mut parts, registers, starts)
}

/// Adds the terms of the `n` elements from index `at` on to a partial sum.
///
/// # Safety
/// Both arrays must have these elements, and `n` must be at most `N`.
#[inline(always)]
unsafe fn add_term<R: Real, L: Lane<R>>(
    part: &mut L,
    weights: &[R],
    x: Option<&[R]>,
    at: usize,
    n: usize,
) {
    // SAFETY: guaranteed by the caller.
    unsafe {
        let weight = L::load_n(weights, at, n);
        *part = match x {
            Some(x) => weight.fma(L::load_n(x, at, n), *part),
            None => *part + weight,
        };
    }
}

/// Adds up the partial sums of each start.
#[inline(always)]
fn folded<R: Real, L: Lane<R>>(parts: &mut [L; PARTS], registers: usize, starts: usize) -> Each<R> {
    let mut n = registers;
    while n > 1 {
        n /= 2;
        for k in 0..n {
            let other = parts[k + n];
            parts[k] += other;
        }
    }
    let mut sums = [R::zero(); WIDEST];
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

/// Data for the reverse sweep of one array that is multiplied by the weights.
struct Weighed<'a, R, L> {
    x: &'a [R],
    /// The weighted mean that was subtracted from the array; zero for arrays that are not centred.
    mean: L,
    y_bar: &'a [R],
    /// The number that is subtracted from `y_bar`; zero for arrays that are not centred.
    shift: L,
    x_bar: *mut R,
}

/// Loads one number for each start (initial state). The numbers repeat, to fill a register.
#[inline(always)]
pub(super) fn each<R: Real, L: Lane<R>>(numbers: &[R], starts: usize) -> L {
    if starts == 1 {
        return L::splat(numbers[0]);
    }
    if starts == L::N {
        return L::load(numbers);
    }
    if starts == 2 {
        return L::splat(numbers[0]).zip(L::splat(numbers[1]))[0];
    }
    let mut all = [R::zero(); WIDEST];
    for k in 0..L::N {
        all[k] = numbers[k % starts];
    }
    L::load(&all)
}
