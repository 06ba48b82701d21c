//! The uniform inputs of kernels: numbers that all elements share. An operation loads these numbers once.

use autodiff::Real;
use autodiff::simd::Lane;

use super::array::Array;
use super::kernel::{Kernel, MOST_UNIFORMS, Pullback};
use super::row::{StepValues, each};

/// A [`Kernel`] whose uniform inputs have constant values, so that it has none.
#[derive(Clone, Debug)]
pub struct Fixed<K> {
    /// The kernel.
    pub kernel: K,
    /// The values of the uniform inputs.
    pub uniforms: Vec<f64>,
}

impl<K: Kernel<I, O>, const I: usize, const O: usize> Kernel<I, O> for Fixed<K> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; I], _: &[R]) -> [R; O] {
        let uniforms = constant_uniforms(&self.uniforms);
        self.kernel.eval(x, &uniforms[..K::UNIFORMS])
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, I, O, M>) -> [[R; I]; M] {
        let uniforms = constant_uniforms(&self.uniforms);
        let uniforms = &uniforms[..K::UNIFORMS];
        self.kernel.vjp(Pullback { uniforms, ..at })
    }
}

#[inline(always)]
#[track_caller]
fn constant_uniforms<R: Real>(values: &[f64]) -> [R; MOST_UNIFORMS] {
    assert_uniforms(values.len());
    let mut uniforms = [R::zero(); MOST_UNIFORMS];
    for (uniform, &value) in uniforms.iter_mut().zip(values) {
        *uniform = R::lit(value);
    }
    uniforms
}

/// # Panics
/// If a kernel cannot have so many uniform inputs.
#[inline(always)]
#[track_caller]
pub(crate) fn assert_uniforms(count: usize) {
    assert!(
        count <= MOST_UNIFORMS,
        "a kernel can have at most {MOST_UNIFORMS} uniform inputs"
    );
}

/// The uniform inputs of an operation: arrays with one number for each start.
pub(super) struct UniformInputs(Vec<Array>);

impl UniformInputs {
    pub(super) fn new(arrays: &[Array]) -> Self {
        Self(arrays.to_vec())
    }

    /// Loads each uniform input into a register, in which the numbers of all starts repeat. `count` is the kernel's
    /// constant [`Kernel::UNIFORMS`]. If there are more starts than lanes, the register has those of the first starts.
    #[inline(always)]
    pub(super) fn load<R: Real, L: Lane<R>>(
        &self,
        count: usize,
        values: StepValues<R>,
    ) -> [L; MOST_UNIFORMS] {
        let mut uniforms = [L::zero(); MOST_UNIFORMS];
        for k in 0..count {
            let numbers = values.get(self.0[k]);
            uniforms[k] = each(numbers, numbers.len());
        }
        uniforms
    }

    /// Loads the uniform inputs for the register of elements that begins with element `first`, if there are more starts
    /// than lanes. This happens for a kernel that is not [fully](super::Compiled::Fully) compiled: the registers of the
    /// other operations are wider, and have a lane for each start. `uniforms` are from [`load`](Self::load).
    #[inline(always)]
    pub(super) fn turn<R: Real, L: Lane<R>>(
        &self,
        uniforms: &mut [L],
        values: StepValues<R>,
        first: usize,
    ) {
        let starts = self.0.first().map_or(1, |array| array.len);
        if starts > L::N {
            for (uniform, &array) in uniforms.iter_mut().zip(&self.0) {
                *uniform = L::load(&values.get(array)[first % starts..]);
            }
        }
    }
}
