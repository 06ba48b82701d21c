//! A kernel mapped over arrays.

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

struct Forward<'a, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    values: &'a mut [R],
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
        for i in (0..inputs[0].len).step_by(L::N) {
            let x = load_all::<R, L, I>(self.values, inputs, i);
            let y = kernel.eval(x);
            for k in 0..O {
                y[k].store_up_to(&mut self.values[outputs[k].from(i)]);
            }
        }
    }
}

struct Reverse<'a, K, R, const I: usize, const O: usize> {
    map: &'a Map<K, I, O>,
    values: &'a [R],
    bars: &'a mut [R],
}

impl<R: Real, K: Adjoint<I, O>, const I: usize, const O: usize> Vectorized<R>
    for Reverse<'_, K, R, I, O>
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
        for i in (0..inputs[0].len).step_by(L::N) {
            let x = load_all::<R, L, I>(self.values, inputs, i);
            let y_bar = load_all::<R, L, O>(self.bars, outputs, i);
            let x_bar = kernel.vjp(x, y_bar);
            for k in 0..I {
                if active[k] {
                    let bar = &mut self.bars[inputs[k].from(i)];
                    (L::load_up_to(bar) + x_bar[k]).store_up_to(bar);
                }
            }
        }
    }
}

/// A lane of each array; at the end of the arrays a part of one.
#[inline(always)]
fn load_all<R: Real, L: Lane<R>, const N: usize>(
    arena: &[R],
    arrays: &[Array; N],
    i: usize,
) -> [L; N] {
    let mut lanes = [L::zero(); N];
    for k in 0..N {
        lanes[k] = L::load_up_to(&arena[arrays[k].from(i)]);
    }
    lanes
}
