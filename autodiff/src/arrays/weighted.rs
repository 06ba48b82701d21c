//! Arrays weighted entry by entry, and their offsets from the weighted mean.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use smallvec::SmallVec;

use super::array::Array;
use super::operation::LaneOperation;
use super::row::{Bars, Places, Reach, StepValues, add};
use crate::product::fits_registers;
use crate::real::Real;
use crate::simd::{Lane, Unchecked, WIDEST};

/// See [`Program::weighted`](super::Program::weighted). How many arrays it has is known only at run time:
/// instances for each number of arrays would be half a megabyte of code.
pub(crate) struct Weighted {
    weights: Array,
    /// The weighted arrays: first those whose offsets from the mean are weighted, then those that are weighted
    /// themselves.
    weighed: Vec<Array>,
    /// How many of them are offsets from the mean.
    offsets: usize,
    /// Arrays that are appended unchanged.
    others: Vec<Array>,
    /// The weighted arrays and the others as one array, the means, and the sum of the weights; adjacent.
    outputs: [Array; 3],
    /// Whether the arrays carry derivatives, by their id. Empty means all.
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
    fn set_active(&mut self, arrays: &[bool]) {
        self.active = arrays.to_vec();
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        self.reach.check(parameters, row);
        let (starts, len) = (self.weights.starts, self.weights.len);
        let (row, after) = row.split_at_mut(self.outputs[0].start);
        let values = StepValues { parameters, row };
        let weights = values.get(self.weights);
        let mut to = self.outputs[1].start - self.outputs[0].start;
        // SAFETY: all arrays are as long as the weights, and the outputs hold the results of each.
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
    /// With `r = y_bar - (sum of w y_bar - mean_bar) / (sum of w)`, the cotangent of an offset's `x` is `w r` and
    /// that of `w` is `(x - mean) r`.
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
        // SAFETY: the reach was checked; inputs lie before outputs, and no two slices of their bars live at
        // a time.
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

/// The number of partial sums of a sum. It is the same for registers of every width, and so are the bits of
/// the sum.
const PARTS: usize = WIDEST;

/// The numbers of all starts, one after the other and repeated up to the width of a register.
type Each<R> = [R; WIDEST];

/// For each start, the sum of the weights, or of the products of the weights and an array.
///
/// # Safety
/// The array is as long as the weights.
#[inline(always)]
unsafe fn sum<R: Real, L: Lane<R>>(weights: &[R], x: Option<&[R]>, starts: usize) -> Each<R> {
    // SAFETY: the caller's promise.
    unsafe {
        if starts == 1 && const { fits_registers::<R, L>() } {
            // With a constant number of registers the partial sums stay in registers.
            sum_in::<R, L>(weights, x, const { PARTS / L::N }, 1)
        } else {
            sum_in::<R, L>(weights, x, PARTS * starts / L::N, starts)
        }
    }
}

/// [`sum`] with this many registers of partial sums.
///
/// # Safety
/// As for [`sum`].
#[inline(always)]
unsafe fn sum_in<R: Real, L: Lane<R>>(
    weights: &[R],
    x: Option<&[R]>,
    registers: usize,
    starts: usize,
) -> Each<R> {
    let (mut parts, len, mut at) = ([L::zero(); PARTS], weights.len(), 0);
    // SAFETY: the caller's promise, and places end with the arrays.
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

/// Adds the term of `n` entries from place `at` on to a partial sum.
///
/// # Safety
/// Both arrays have these entries, and `n` is at most `N`.
#[inline(always)]
unsafe fn add_term<R: Real, L: Lane<R>>(
    part: &mut L,
    weights: &[R],
    x: Option<&[R]>,
    at: usize,
    n: usize,
) {
    // SAFETY: the caller's promise.
    unsafe {
        let weight = L::load_n(weights, at, n);
        *part = match x {
            Some(x) => weight.fma(L::load_n(x, at, n), *part),
            None => *part + weight,
        };
    }
}

/// The sum of the partial sums of each start.
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

/// A weighted array in the reverse sweep.
struct Weighed<'a, R, L> {
    x: &'a [R],
    /// Zero unless offsets from the mean are weighted, as is the shift.
    mean: L,
    y_bar: &'a [R],
    /// What is subtracted from `y_bar`.
    shift: L,
    x_bar: *mut R,
}

/// A number of each start, repeated up to the width of a register.
#[inline(always)]
fn each<R: Real, L: Lane<R>>(numbers: &[R], starts: usize) -> L {
    if starts == 1 {
        return L::splat(numbers[0]);
    }
    let mut all = [R::zero(); WIDEST];
    for k in 0..L::N {
        all[k] = numbers[k % starts];
    }
    L::load(&all)
}
