//! A kernel mapped over arrays.
#![allow(unsafe_code)] // Unchecked loads: see `Lane::load_at`.

use super::row::Frame;
use super::{Array, Bars, Operation};
use crate::kernel::Adjoint;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

pub(super) struct Map<K, const I: usize, const O: usize> {
    kernel: K,
    inputs: [Array; I],
    outputs: [Array; O],
    active: [bool; I],
}

impl<K, const I: usize, const O: usize> Map<K, I, O> {
    pub(super) fn new(kernel: K, inputs: [Array; I], outputs: [Array; O]) -> Self {
        Self {
            kernel,
            inputs,
            outputs,
            active: [true; I],
        }
    }
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Operation<R> for Map<K, I, O> {
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
    fn reverse(&mut self, values: Frame<R>, bars: &mut Bars<R>) {
        R::vectorize(Reverse {
            map: self,
            values,
            bars,
        });
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.active = self.inputs.map(|a| arrays[a.id]);
    }
}

/// A lane of an array from its `i`th entry on: a `WHOLE` one, or what is left.
///
/// # Safety
/// The array lies in its part and, for a whole lane, has `i + N` entries.
#[inline(always)]
unsafe fn load<R: Real, L: Lane<R>, const WHOLE: bool>(part: &[R], a: Array, i: usize) -> L {
    // SAFETY: the caller's promise.
    if WHOLE {
        unsafe { L::load_at(part, a.start + i) }
    } else {
        L::load_up_to(&part[a.start + i..a.start + a.len])
    }
}

/// The counterpart of [`load`].
///
/// # Safety
/// As there.
#[inline(always)]
unsafe fn store<R: Real, L: Lane<R>, const WHOLE: bool>(
    part: &mut [R],
    (a, i): (Array, usize),
    value: L,
) {
    // SAFETY: the caller's promise.
    if WHOLE {
        unsafe { value.store_at(part, a.start + i) }
    } else {
        value.store_up_to(&mut part[a.start + i..a.start + a.len]);
    }
}

/// Work on the lanes of a map's arrays.
trait Lanes<R> {
    /// The lane from the `i`th entries on.
    ///
    /// # Safety
    /// As for [`load`], for all arrays of the map.
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize);

    /// All lanes of arrays of a length.
    ///
    /// # Safety
    /// All arrays of the map lie in their parts and have this length.
    #[inline(always)]
    unsafe fn lanes<L: Lane<R>>(&mut self, len: usize) {
        let mut i = 0;
        // SAFETY: whole lanes end within the arrays.
        unsafe {
            while i + L::N <= len {
                self.lane::<L, true>(i);
                i += L::N;
            }
            if i < len {
                self.lane::<L, false>(i);
            }
        }
    }
}

struct Forward<'a, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    parameters: &'a [R],
    row: &'a mut [R],
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Lanes<R>
    for Forward<'_, K, R, I, O>
{
    #[inline(always)]
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize) {
        let Map {
            kernel,
            inputs,
            outputs,
            ..
        } = self.map;
        let values = Frame {
            parameters: self.parameters,
            row: self.row,
        };
        let mut x = [L::zero(); I];
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { load::<R, L, WHOLE>(values.part(inputs[k]), inputs[k], i) };
        }
        let y = kernel.eval(x);
        for k in 0..O {
            unsafe { store::<R, L, WHOLE>(self.row, (outputs[k], i), y[k]) };
        }
    }
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Vectorized<R>
    for Forward<'_, K, R, I, O>
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let Map {
            inputs, outputs, ..
        } = self.map;
        let len = inputs[0].len;
        check([self.parameters, self.row], inputs, len);
        check([self.parameters, self.row], outputs, len);
        // SAFETY: the arrays were checked.
        unsafe { self.lanes::<L>(len) }
    }
}

/// Panics unless the arrays lie in their parts and are as long as the first.
#[inline(always)]
fn check<R: Real>([parameters, row]: [&[R]; 2], arrays: &[Array], len: usize) {
    let values = Frame { parameters, row };
    for &a in arrays {
        assert!(
            a.len == len && a.start + len <= values.part(a).len(),
            "an array lies outside its part"
        );
    }
}

struct Reverse<'a, 'b, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    values: Frame<'a, R>,
    bars: &'a mut Bars<'b, R>,
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Lanes<R>
    for Reverse<'_, '_, K, R, I, O>
{
    #[inline(always)]
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize) {
        let Map {
            kernel,
            inputs,
            outputs,
            active,
        } = self.map;
        let (mut x, mut y, mut y_bar) = ([L::zero(); I], [L::zero(); O], [L::zero(); O]);
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { load::<R, L, WHOLE>(self.values.part(inputs[k]), inputs[k], i) };
        }
        for k in 0..O {
            y[k] = unsafe { load::<R, L, WHOLE>(self.values.row, outputs[k], i) };
            y_bar[k] = unsafe { load::<R, L, WHOLE>(self.bars.row, outputs[k], i) };
        }
        let x_bar = kernel.vjp_with_results(x, y, y_bar);
        for k in 0..I {
            if active[k] {
                let part = self.bars.part_mut(inputs[k]);
                unsafe {
                    let bar: L = load::<R, L, WHOLE>(part, inputs[k], i);
                    store::<R, L, WHOLE>(part, (inputs[k], i), bar + x_bar[k]);
                }
            }
        }
    }
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Vectorized<R>
    for Reverse<'_, '_, K, R, I, O>
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let Map {
            inputs, outputs, ..
        } = self.map;
        let len = inputs[0].len;
        let Frame { parameters, row } = self.values;
        check([parameters, row], inputs, len);
        check([parameters, row], outputs, len);
        let bars = [&*self.bars.parameters, &*self.bars.row];
        check(bars, inputs, len);
        check(bars, outputs, len);
        // SAFETY: the arrays were checked.
        unsafe { self.lanes::<L>(len) }
    }
}
