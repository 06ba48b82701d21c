//! A kernel mapped over arrays.
#![allow(unsafe_code)] // Unchecked loads: see `Lane::load_at`.

use super::{Array, Operation};
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
    fn inputs(&self) -> Vec<Array> {
        self.inputs.to_vec()
    }
    fn outputs(&self) -> Vec<Array> {
        self.outputs.to_vec()
    }
    fn reverse_reads(&self) -> Vec<Array> {
        self.inputs.to_vec()
    }
    fn forward(&mut self, values: &mut [R]) {
        R::vectorize(Forward { map: self, values });
    }
    fn reverse(&mut self, values: &[R], bars: &mut [R]) {
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

/// Panics unless the arrays lie in the arena and are as long as the first.
fn check(arena: usize, arrays: &[Array], len: usize) {
    let fits = |a: &Array| a.len == len && a.range().end <= arena;
    assert!(arrays.iter().all(fits), "an array lies outside its arena");
}

/// A lane of an array from its `i`th entry on: a `WHOLE` one, or what is left.
///
/// # Safety
/// The array lies in the arena and, for a whole lane, has `i + N` entries.
#[inline(always)]
unsafe fn load<R: Real, L: Lane<R>, const WHOLE: bool>(arena: &[R], a: Array, i: usize) -> L {
    // SAFETY: the caller's promise.
    if WHOLE {
        unsafe { L::load_at(arena, a.start + i) }
    } else {
        L::load_up_to(&arena[a.from(i)])
    }
}

/// The counterpart of [`load`].
///
/// # Safety
/// As there.
#[inline(always)]
unsafe fn store<R: Real, L: Lane<R>, const WHOLE: bool>(
    arena: &mut [R],
    (a, i): (Array, usize),
    value: L,
) {
    // SAFETY: the caller's promise.
    if WHOLE {
        unsafe { value.store_at(arena, a.start + i) }
    } else {
        value.store_up_to(&mut arena[a.from(i)]);
    }
}

struct Forward<'a, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    values: &'a mut [R],
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Forward<'_, K, R, I, O> {
    /// # Safety
    /// As for [`load`], for all arrays of the map.
    #[inline(always)]
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize) {
        let Map {
            kernel,
            inputs,
            outputs,
            ..
        } = self.map;
        let mut x = [L::zero(); I];
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { load::<R, L, WHOLE>(self.values, inputs[k], i) };
        }
        let y = kernel.eval(x);
        for k in 0..O {
            unsafe { store::<R, L, WHOLE>(self.values, (outputs[k], i), y[k]) };
        }
    }
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Vectorized<R>
    for Forward<'_, K, R, I, O>
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let len = self.map.inputs[0].len;
        check(self.values.len(), &self.map.inputs, len);
        check(self.values.len(), &self.map.outputs, len);
        let mut i = 0;
        // SAFETY: the arrays were checked, and whole lanes end within them.
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

struct Reverse<'a, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    values: &'a [R],
    bars: &'a mut [R],
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Reverse<'_, K, R, I, O> {
    /// # Safety
    /// As for [`load`], for all arrays of the map.
    #[inline(always)]
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize) {
        let Map {
            kernel,
            inputs,
            outputs,
            active,
        } = self.map;
        let (mut x, mut y_bar) = ([L::zero(); I], [L::zero(); O]);
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { load::<R, L, WHOLE>(self.values, inputs[k], i) };
        }
        for k in 0..O {
            y_bar[k] = unsafe { load::<R, L, WHOLE>(self.bars, outputs[k], i) };
        }
        let x_bar = kernel.vjp(x, y_bar);
        for k in 0..I {
            if active[k] {
                unsafe {
                    let bar: L = load::<R, L, WHOLE>(self.bars, inputs[k], i);
                    store::<R, L, WHOLE>(self.bars, (inputs[k], i), bar + x_bar[k]);
                }
            }
        }
    }
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Vectorized<R>
    for Reverse<'_, K, R, I, O>
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        let len = self.map.inputs[0].len;
        for arena in [self.values.len(), self.bars.len()] {
            check(arena, &self.map.inputs, len);
            check(arena, &self.map.outputs, len);
        }
        let mut i = 0;
        // SAFETY: the arrays were checked, and whole lanes end within them.
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
