//! The uniform inputs of a mapped kernel. They are loaded once for each operation, and their cotangents are only
//! computed if they are needed.
#![allow(unsafe_code)] // Cotangents are added through pointers: see `Places`.

use super::array::Array;
use super::kernel::{Kernel, MOST_UNIFORMS, Uniforms, by_uniform, checked};
use super::row::{Bars, Places, Reach, StepValues};
use crate::real::Real;
use crate::simd::{Lane, WIDEST};

/// Arrays of one number for each start.
pub(super) struct UniformInputs {
    arrays: Vec<Array>,
    /// The indices of the inputs that carry derivatives.
    active: Vec<usize>,
    reach: Reach,
}

impl UniformInputs {
    /// # Panics
    /// If the kernel does not have as many uniform inputs.
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

    /// A register of each input: the numbers of all starts, repeated.
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

    /// The sums of cotangents.
    pub(super) fn sums<'a, R: Real>(&'a self, bars: &mut Bars<R>) -> UniformSums<'a, R> {
        self.reach.check(bars.parameters, bars.row);
        let places = Places::new(bars);
        UniformSums {
            uniform: self,
            places,
        }
    }
}

/// The sums of the cotangents of uniform inputs.
#[derive(Clone, Copy)]
pub(super) struct UniformSums<'a, R> {
    uniform: &'a UniformInputs,
    places: Places<R>,
}

impl<R: Real> UniformSums<'_, R> {
    /// Adds the contributions of the elements of a register whose bits are set. Elements are added one by one, so that
    /// the sum has the same bits for all widths of registers.
    ///
    /// # Safety
    /// Nothing else accesses the cotangents at the same time.
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
