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

/// Work on the lanes of arrays of one length.
trait Lanes<R> {
    /// The lane of so many entries, the second number, from the first number on.
    ///
    /// # Safety
    /// All arrays have these entries, which are no more than `N`.
    unsafe fn lane<L: Lane<R>>(&mut self, at: (usize, usize));

    /// All lanes.
    ///
    /// # Safety
    /// All arrays have this length.
    #[inline(always)]
    unsafe fn lanes<L: Lane<R>>(&mut self, len: usize) {
        let mut i = 0;
        // SAFETY: the lanes end within the arrays.
        unsafe {
            while i + L::N <= len {
                self.lane::<L>((i, L::N));
                i += L::N;
            }
            if i < len {
                self.lane::<L>((i, len - i));
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
    unsafe fn lane<L: Lane<R>>(&mut self, at: (usize, usize)) {
        let mut x = [L::zero(); I];
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { L::load_n(self.x[k], at) };
        }
        let y = self.kernel.eval(x);
        for k in 0..O {
            unsafe { y[k].store_n(self.y[k], at) };
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
    y: [&'a [R]; O],
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
    unsafe fn lane<L: Lane<R>>(&mut self, at: (usize, usize)) {
        let (mut x, mut y, mut y_bar) = ([L::zero(); I], [L::zero(); O], [L::zero(); O]);
        for k in 0..I {
            // SAFETY: the caller's promise, here and below.
            x[k] = unsafe { L::load_n(self.x[k], at) };
        }
        for k in 0..O {
            y[k] = unsafe { L::load_n(self.y[k], at) };
            y_bar[k] = unsafe { L::load_n(self.y_bar[k], at) };
        }
        let x_bar = self.kernel.vjp_with_results(x, y, y_bar);
        for k in 0..I {
            if let Some((part, start)) = self.wanted[k] {
                // SAFETY: what is wanted was checked to lie in its part.
                unsafe {
                    let bar = self.bars[part].get_unchecked_mut(start..start + self.len);
                    let sum = L::load_n(bar, at) + x_bar[k];
                    sum.store_n(bar, at);
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
            y: outputs.map(|output| &self.values.get(output)[..len]),
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
