//! Arrays weighted entry by entry, and their offsets from the weighted mean.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use std::hint::assert_unchecked;

use super::array::Array;
use super::operation::{Forward, Operation, Reverse};
use super::row::{Bars, Places, Reach, StepValues, add};
use crate::real::Real;
use crate::simd::{Lane, Unchecked, Vectorized, WIDEST};

/// See [`Program::weighted`](super::Program::weighted).
pub(crate) struct Weighted<const C: usize, const V: usize> {
    pub(crate) weights: Array,
    /// Arrays whose offsets from the mean are weighted.
    pub(crate) offsets: [Array; C],
    /// Arrays that are weighted.
    pub(crate) values: [Array; V],
    /// Arrays that are appended unchanged.
    pub(crate) others: Vec<Array>,
    /// The weighted arrays and the others as one array, the means, and the sum of the weights; adjacent.
    pub(crate) outputs: [Array; 3],
    active: Active<C, V>,
    reach: Reach,
}

/// Which inputs carry derivatives.
struct Active<const C: usize, const V: usize> {
    weights: [bool; 1],
    offsets: [bool; C],
    values: [bool; V],
    others: Vec<bool>,
}

impl<const C: usize, const V: usize> Weighted<C, V> {
    pub(crate) fn new(
        weights: Array,
        offsets: [Array; C],
        values: [Array; V],
        others: &[Array],
        outputs: [Array; 3],
    ) -> Self {
        let inputs = [weights].into_iter().chain(offsets).chain(values);
        let all = inputs.chain(others.iter().copied()).chain(outputs);
        Self {
            reach: Reach::new(all.map(|array| (array, array.len))),
            active: Active {
                weights: [true],
                offsets: [true; C],
                values: [true; V],
                others: vec![true; others.len()],
            },
            weights,
            offsets,
            values,
            others: others.to_vec(),
            outputs,
        }
    }
}

impl<R: Real, const C: usize, const V: usize> Operation<R> for Weighted<C, V> {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.to_vec()
    }
    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        R::vectorize(Forward {
            map: self,
            parameters,
            row,
        });
    }
    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        R::vectorize(Reverse {
            map: self,
            values,
            bars,
        });
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.active = Active {
            weights: [arrays[self.weights.id]],
            offsets: self.offsets.map(|a| arrays[a.id]),
            values: self.values.map(|a| arrays[a.id]),
            others: self.others.iter().map(|a| arrays[a.id]).collect(),
        };
    }
}

/// Partial sums of a sum. A fixed number of them gives the same bits in registers of any width.
const PARTS: usize = WIDEST;

/// The sums over all entries: of the weights if `TOTAL`, and of the products of weights and each array. A register holds
/// the sums of all starts, one after the other and repeated.
///
/// # Safety
/// All arrays are as long as the weights.
#[inline(always)]
unsafe fn sums<R: Real, L: Lane<R>, const C: usize, const TOTAL: bool>(
    weights: &[R],
    x: [&[R]; C],
    starts: usize,
) -> (L, [L; C]) {
    // SAFETY: the caller's promise.
    unsafe {
        if starts == 1 {
            // A constant number of registers, which stay in registers.
            sums_in::<R, L, C, TOTAL>(weights, x, const { PARTS / L::N }, 1)
        } else {
            sums_in::<R, L, C, TOTAL>(weights, x, PARTS * starts / L::N, starts)
        }
    }
}

/// As [`sums`], with the partial sums in so many registers.
///
/// # Safety
/// As [`sums`].
#[inline(always)]
unsafe fn sums_in<R: Real, L: Lane<R>, const C: usize, const TOTAL: bool>(
    weights: &[R],
    x: [&[R]; C],
    registers: usize,
    starts: usize,
) -> (L, [L; C]) {
    let (mut total, mut products) = ([L::zero(); PARTS], [[L::zero(); PARTS]; C]);
    let (len, mut at) = (weights.len(), 0);
    // SAFETY: the caller's promise, and places end with the arrays.
    unsafe {
        while at + registers * L::N <= len {
            for k in 0..registers {
                let weight = L::load_at(weights, at);
                if TOTAL {
                    total[k] += weight;
                }
                for c in 0..C {
                    products[c][k] = weight.fma(L::load_at(x[c], at), products[c][k]);
                }
                at += L::N;
            }
        }
        for k in 0..registers {
            if at >= len {
                break;
            }
            let n = L::N.min(len - at);
            let weight = L::load_n(weights, at, n);
            if TOTAL {
                total[k] += weight;
            }
            for c in 0..C {
                products[c][k] = weight.fma(L::load_n(x[c], at, n), products[c][k]);
            }
            at += L::N;
        }
    }
    let mut all = [L::zero(); C];
    for c in 0..C {
        all[c] = folded(&mut products[c], registers, starts);
    }
    (folded(&mut total, registers, starts), all)
}

/// The sum of the partial sums of each start, repeated up to the width of the register.
#[inline(always)]
fn folded<R: Real, L: Lane<R>>(parts: &mut [L; PARTS], registers: usize, starts: usize) -> L {
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
    L::load(&sums)
}

/// Writes the number of each start in a register to the places from `at` on.
#[inline(always)]
fn put<R: Real, L: Lane<R>>(numbers: L, to: &mut [R], at: usize, starts: usize) {
    let mut all = [R::zero(); WIDEST];
    numbers.store(&mut all);
    if starts == 1 {
        // Spares a call of `memcpy`.
        to[at] = all[0];
    } else {
        to[at..at + starts].copy_from_slice(&all[..starts]);
    }
}

struct ForwardLanes<'a, R, L, const C: usize, const V: usize> {
    weights: &'a [R],
    x: [&'a [R]; C],
    v: [&'a [R]; V],
    means: [L; C],
    y: &'a mut [R],
}

impl<R: Real, L: Lane<R>, const C: usize, const V: usize> ForwardLanes<'_, R, L, C, V> {
    /// The results of `n` entries from place `at` on.
    ///
    /// # Safety
    /// All arrays have these entries, and `n` is at most `N`.
    #[inline(always)]
    unsafe fn lane(&mut self, at: usize, n: usize) {
        let len = self.weights.len();
        // SAFETY: the caller's promise.
        unsafe {
            let weight = L::load_n(self.weights, at, n);
            for c in 0..C {
                let offset = L::load_n(self.x[c], at, n) - self.means[c];
                (weight * offset).store_n(self.y, c * len + at, n);
            }
            for c in 0..V {
                let value = weight * L::load_n(self.v[c], at, n);
                value.store_n(self.y, (C + c) * len + at, n);
            }
        }
    }
}

struct ReverseLanes<'a, R, L, const C: usize, const V: usize> {
    weights: &'a [R],
    x: [&'a [R]; C],
    v: [&'a [R]; V],
    means: [L; C],
    shifts: [L; C],
    y_bar: &'a [R],
    w_bar: *mut R,
    x_bar: [*mut R; C],
    v_bar: [*mut R; V],
}

impl<R: Real, L: Lane<R>, const C: usize, const V: usize> ReverseLanes<'_, R, L, C, V> {
    /// Adds to the cotangents of all entries.
    ///
    /// # Safety
    /// As [`lane`](Self::lane), for all entries.
    #[inline(always)]
    unsafe fn all(&mut self) {
        let mut are_active = !self.w_bar.is_null();
        for place in self.x_bar {
            are_active &= !place.is_null();
        }
        for place in self.v_bar {
            are_active &= !place.is_null();
        }
        // SAFETY: the caller's promise; `are_active` was checked.
        unsafe {
            if are_active {
                self.lanes::<true>();
            } else {
                self.lanes::<false>();
            }
        }
    }

    /// # Safety
    /// As [`all`](Self::all); no pointer is null if `ACTIVE`.
    #[inline(always)]
    unsafe fn lanes<const ACTIVE: bool>(&mut self) {
        let (mut at, len) = (0, self.weights.len());
        // SAFETY: the caller's promise.
        unsafe {
            while at + L::N <= len {
                self.lane::<ACTIVE>(at, L::N);
                at += L::N;
            }
            if at < len {
                self.lane::<ACTIVE>(at, len - at);
            }
        }
    }

    /// Adds to the cotangents of `n` entries from place `at` on.
    ///
    /// # Safety
    /// As [`ForwardLanes::lane`]; pointers point to such arrays, which nothing else reads or writes meanwhile. Unless
    /// `ACTIVE`, they may be null.
    #[inline(always)]
    unsafe fn lane<const ACTIVE: bool>(&mut self, at: usize, n: usize) {
        let len = self.weights.len();
        // SAFETY: the caller's promise.
        unsafe {
            if ACTIVE {
                // Spares a branch for every register.
                assert_unchecked(!self.w_bar.is_null());
                for c in 0..C {
                    assert_unchecked(!self.x_bar[c].is_null());
                }
                for c in 0..V {
                    assert_unchecked(!self.v_bar[c].is_null());
                }
            }
            let weight = L::load_n(self.weights, at, n);
            let mut of_weight = L::zero();
            for c in 0..C {
                let rest = L::load_n(self.y_bar, c * len + at, n) - self.shifts[c];
                add(self.x_bar[c], at, n, weight * rest);
                let offset = L::load_n(self.x[c], at, n) - self.means[c];
                of_weight = rest.fma(offset, of_weight);
            }
            for c in 0..V {
                let bar = L::load_n(self.y_bar, (C + c) * len + at, n);
                add(self.v_bar[c], at, n, weight * bar);
                of_weight = bar.fma(L::load_n(self.v[c], at, n), of_weight);
            }
            add(self.w_bar, at, n, of_weight);
        }
    }
}

impl<R: Real, const C: usize, const V: usize> Vectorized<R> for Forward<'_, Weighted<C, V>, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let (map, parameters, row) = (self.map, self.parameters, self.row);
        map.reach.check(parameters, row);
        let (starts, len) = (map.weights.starts, map.weights.len);
        let (row, after) = row.split_at_mut(map.outputs[0].start);
        let values = StepValues { parameters, row };
        let weights = values.get(map.weights);
        let (mut x, mut v) = ([weights; C], [weights; V]);
        // Loops, not closures, which might be compiled without the instruction set of the lanes.
        for c in 0..C {
            x[c] = values.get(map.offsets[c]);
        }
        for c in 0..V {
            v[c] = values.get(map.values[c]);
        }
        // SAFETY: all arrays are as long as the weights, and the outputs hold the results of each.
        unsafe {
            let (total, products) = sums::<R, L, C, true>(weights, x, starts);
            let mut means = [L::zero(); C];
            let mut to = map.outputs[1].start - map.outputs[0].start;
            for c in 0..C {
                means[c] = products[c] / total;
                put(means[c], after, to, starts);
                to += starts;
            }
            put(total, after, to, starts);
            let mut lanes = ForwardLanes {
                weights,
                x,
                v,
                means,
                y: after,
            };
            let mut at = 0;
            while at + L::N <= len {
                lanes.lane(at, L::N);
                at += L::N;
            }
            if at < len {
                lanes.lane(at, len - at);
            }
        }
        let mut to = (C + V) * len;
        for &other in &map.others {
            after[to..to + other.len].copy_from_slice(values.get(other));
            to += other.len;
        }
    }
}

impl<R: Real, const C: usize, const V: usize> Vectorized<R> for Reverse<'_, '_, Weighted<C, V>, R> {
    type Output = ();
    /// With `r = y_bar - (sum of w y_bar - mean_bar) / (sum of w)`, the cotangent of an offset's `x` is `w r` and
    /// that of `w` is `(x - mean) r`.
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self { map, values, bars } = self;
        map.reach.check(values.parameters, values.row);
        map.reach.check(bars.parameters, bars.row);
        let (starts, len) = (map.weights.starts, map.weights.len);
        let begin = map.outputs[0].start;
        let Bars { parameters, row } = bars;
        let (row, after) = row.split_at_mut(begin);
        let mut bars = Bars { parameters, row };
        let weights = values.get(map.weights);
        let (mut x, mut v) = ([weights; C], [weights; V]);
        let mut y_bar = [&after[..len]; C];
        for c in 0..C {
            x[c] = values.get(map.offsets[c]);
            y_bar[c] = &after[c * len..][..len];
        }
        for c in 0..V {
            v[c] = values.get(map.values[c]);
        }
        let places = Places::new(&mut bars);
        let [w_bar] = places.of_active(&[map.weights], &map.active.weights);
        let x_bar = places.of_active(&map.offsets, &map.active.offsets);
        let v_bar = places.of_active(&map.values, &map.active.values);
        let (mut means, mut shifts) = ([L::zero(); C], [L::zero(); C]);
        // SAFETY: the reach was checked; inputs lie before outputs, and no two slices of their bars live at
        // a time.
        unsafe {
            let (_, products) = sums::<R, L, C, false>(weights, y_bar, starts);
            let first = map.outputs[1].start;
            let total = each::<R, L>(&values.row[first + C * starts..], starts);
            for c in 0..C {
                means[c] = each(&values.row[first + c * starts..], starts);
                let mean_bar: L = each(&after[first - begin + c * starts..], starts);
                shifts[c] = (products[c] - mean_bar) / total;
            }
            let mut lanes = ReverseLanes {
                weights,
                x,
                v,
                means,
                shifts,
                y_bar: after,
                w_bar,
                x_bar,
                v_bar,
            };
            lanes.all();
        }
        let mut from = (C + V) * len;
        for (&other, &active) in map.others.iter().zip(&map.active.others) {
            if active {
                let to = bars.get_mut(other).iter_mut();
                to.zip(&after[from..]).for_each(|(to, &bar)| *to += bar);
            }
            from += other.len;
        }
    }
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
