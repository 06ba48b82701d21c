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

/// The lane of an array from its `i`th entry on: a `WHOLE` one, or what is left.
///
/// # Safety
/// The array has `i + N` entries, or at least `i` and not as many.
#[inline(always)]
unsafe fn load<R: Real, L: Lane<R>, const WHOLE: bool>(array: &[R], i: usize) -> L {
    // SAFETY: the caller's promise.
    unsafe {
        match WHOLE {
            true => L::load_at(array, i),
            false => L::load_part(array.get_unchecked(i..)),
        }
    }
}

/// The counterpart of [`load`].
///
/// # Safety
/// As there.
#[inline(always)]
unsafe fn store<R: Real, L: Lane<R>, const WHOLE: bool>(array: &mut [R], i: usize, value: L) {
    // SAFETY: the caller's promise.
    unsafe {
        match WHOLE {
            true => value.store_at(array, i),
            false => value.store_part(array.get_unchecked_mut(i..)),
        }
    }
}

/// Work on the lanes of arrays of one length.
trait Lanes<R> {
    /// The lane from the `i`th entries on.
    ///
    /// # Safety
    /// As for [`load`], for all arrays.
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize);

    /// All lanes.
    ///
    /// # Safety
    /// All arrays have this length.
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

struct ForwardLanes<'a, K, R, const I: usize, const O: usize> {
    kernel: &'a K,
    x: [&'a [R]; I],
    y: [&'a mut [R]; O],
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Lanes<R>
    for ForwardLanes<'_, K, R, I, O>
{
    #[inline(always)]
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize) {
        let mut x = [L::zero(); I];
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { load::<R, L, WHOLE>(self.x[k], i) };
        }
        let y = self.kernel.eval(x);
        for k in 0..O {
            unsafe { store::<R, L, WHOLE>(self.y[k], i, y[k]) };
        }
    }
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Vectorized<R>
    for Forward<'_, K, R, I, O>
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Map {
            kernel,
            inputs,
            outputs,
            ..
        } = self.map;
        let (row, after) = self.row.split_at_mut(outputs[0].start);
        let values = Frame {
            parameters: self.parameters,
            row,
        };
        let len = outputs[0].len;
        let mut lanes = ForwardLanes {
            kernel,
            x: inputs.map(|input| &values.get(input)[..len]),
            y: [(); O].map(|()| &mut [][..]),
        };
        for (y, output) in lanes.y.iter_mut().zip(after.chunks_exact_mut(len)) {
            *y = output;
        }
        // SAFETY: the slices have this length.
        unsafe { lanes.lanes::<L>(len) }
    }
}

struct Reverse<'a, 'b, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    values: Frame<'a, R>,
    bars: &'a mut Bars<'b, R>,
}

struct ReverseLanes<'a, K, R, const I: usize, const O: usize> {
    kernel: &'a K,
    x: [&'a [R]; I],
    y_bar: [&'a [R]; O],
    /// Where the cotangents of the inputs lie, and from where on, of those that are wanted.
    bars: [&'a mut [R]; 2],
    wanted: [Option<(usize, usize)>; I],
    len: usize,
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Lanes<R>
    for ReverseLanes<'_, K, R, I, O>
{
    #[inline(always)]
    unsafe fn lane<L: Lane<R>, const WHOLE: bool>(&mut self, i: usize) {
        let (mut x, mut y_bar) = ([L::zero(); I], [L::zero(); O]);
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { load::<R, L, WHOLE>(self.x[k], i) };
        }
        for k in 0..O {
            y_bar[k] = unsafe { load::<R, L, WHOLE>(self.y_bar[k], i) };
        }
        let x_bar = self.kernel.vjp(x, y_bar);
        for k in 0..I {
            if let Some((part, start)) = self.wanted[k] {
                // SAFETY: what is wanted was checked to lie in its part.
                unsafe {
                    let bar = self.bars[part].get_unchecked_mut(start..start + self.len);
                    let sum = load::<R, L, WHOLE>(bar, i) + x_bar[k];
                    store::<R, L, WHOLE>(bar, i, sum);
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
    fn run<L: Lane<R>>(self) {
        let Map {
            kernel,
            inputs,
            outputs,
            active,
        } = self.map;
        let len = outputs[0].len;
        let (row, after) = self.bars.row.split_at_mut(outputs[0].start);
        let mut lanes = ReverseLanes {
            kernel,
            x: inputs.map(|input| &self.values.get(input)[..len]),
            y_bar: [&[]; O],
            bars: [row, self.bars.parameters],
            wanted: [None; I],
            len,
        };
        for (y_bar, output) in lanes.y_bar.iter_mut().zip(after.chunks_exact(len)) {
            *y_bar = output;
        }
        for k in 0..I {
            let (part, start) = (usize::from(inputs[k].parameter), inputs[k].start);
            let fits = start + len <= lanes.bars[part].len();
            assert!(fits, "an array lies outside its part");
            lanes.wanted[k] = active[k].then_some((part, start));
        }
        // SAFETY: the slices have this length.
        unsafe { lanes.lanes::<L>(len) }
    }
}
