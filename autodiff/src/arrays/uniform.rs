//! The uniform inputs of a mapped kernel: loaded once per operation, summed up only on demand.
#![allow(unsafe_code)] // Cotangents are added through pointers: see `Places`.

use super::array::Array;
use super::kernel::{Kernel, MOST_UNIFORMS, Uniforms, by_uniform, checked};
use super::row::{Bars, Places, Reach, StepValues};
use crate::real::Real;
use crate::simd::{Lane, WIDEST};

/// Arrays of one number for each start.
pub(super) struct UniformInputs {
    arrays: Vec<Array>,
    /// The numbers of those that carry derivatives.
    active: Vec<usize>,
    reach: Reach,
}

impl UniformInputs {
    /// # Panics
    /// Unless the kernel has as many uniform inputs.
    pub(super) fn new<K: Kernel<I, O>, const I: usize, const O: usize>(arrays: &[Array]) -> Self {
        assert_eq!(
            checked(arrays).len(),
            K::UNIFORMS,
            "a kernel has another number of uniform inputs"
        );
        Self {
            arrays: arrays.to_vec(),
            active: (0..arrays.len()).collect(),
            reach: Reach::new(arrays.iter().map(|&array| (array, array.len))),
        }
    }

    pub(super) fn set_active(&mut self, arrays: &[bool]) {
        let is_active = |k: &usize| arrays[self.arrays[*k].id];
        self.active = (0..self.arrays.len()).filter(is_active).collect();
    }

    /// A register of each: the numbers of all starts, repeated.
    #[inline(always)]
    pub(super) fn load<R: Real, L: Lane<R>>(&self, values: StepValues<R>) -> Uniforms<L> {
        let mut uniforms = [L::zero(); MOST_UNIFORMS];
        for (uniform, &array) in uniforms.iter_mut().zip(&self.arrays) {
            let numbers = values.get(array);
            *uniform = match numbers.len() {
                1 => L::splat(numbers[0]),
                starts if starts == L::N => L::load(numbers),
                starts => {
                    let mut lanes = [R::zero(); WIDEST];
                    for k in 0..L::N {
                        lanes[k] = numbers[k % starts];
                    }
                    L::load(&lanes)
                }
            };
        }
        uniforms
    }

    /// Where cotangents are added.
    pub(super) fn sums<'a, R: Real>(&'a self, bars: &mut Bars<R>) -> UniformSums<'a, R> {
        self.reach.check(bars.parameters, bars.row);
        let places = Places::new(bars);
        UniformSums {
            uniform: self,
            places,
        }
    }
}

/// The cotangents of uniform inputs.
#[derive(Clone, Copy)]
pub(super) struct UniformSums<'a, R> {
    uniform: &'a UniformInputs,
    places: Places<R>,
}

impl<R: Real> UniformSums<'_, R> {
    /// Adds what a register of elements contributes, if a bit is set for it: element by element, so that the sum
    /// has the same bits for all widths of registers.
    ///
    /// # Safety
    /// Nothing else accesses the bars meanwhile.
    #[inline(always)]
    pub(super) unsafe fn add<L, K, const I: usize, const O: usize>(
        self,
        kernel: &K,
        at: ([L; I], [L; O]),
        uniforms: &Uniforms<L>,
        (first, bits): (usize, u16),
    ) where
        L: Lane<R>,
        K: Kernel<I, O>,
    {
        if K::UNIFORMS == 0 {
            return;
        }
        for &k in &self.uniform.active {
            let array = self.uniform.arrays[k];
            let mut lanes = [R::zero(); WIDEST];
            by_uniform(kernel, at, uniforms, k).store(&mut lanes);
            for lane in 0..L::N {
                if bits >> lane & 1 == 1 {
                    // SAFETY: the reach was checked; the caller's promise.
                    unsafe {
                        *self.places.of(array).add((first + lane) % array.len) += lanes[lane]
                    };
                }
            }
        }
    }
}
