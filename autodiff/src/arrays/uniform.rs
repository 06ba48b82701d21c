//! Kernels with uniform inputs: numbers that all elements share. An operation loads these numbers once. It computes
//! their cotangents only if they are needed.

use super::array::Array;
use super::kernel::{Kernel, Pullback, constants, pulled_back, seeded};
use super::row::{Bars, StepValues};
use crate::real::Real;
use crate::simd::{Lane, WIDEST};

/// The largest number of uniform inputs that a kernel can have.
pub const MOST_UNIFORMS: usize = 16;

/// The uniform inputs of a kernel, followed by zeros up to the length [`MOST_UNIFORMS`].
pub type Uniforms<R> = [R; MOST_UNIFORMS];

/// A [`Kernel`] with uniform inputs: numbers that all elements share, such as gravity. A rollout can be differentiated
/// with respect to them, and the starts of a batch may have different values.
///
/// Every [`Kernel`] is a `UniformKernel` without uniform inputs.
///
/// ```
/// use autodiff::arrays::{UniformKernel, Uniforms};
/// use autodiff::{Model, Program, Real, Rollout, Var, gradient, kernel};
///
/// struct Decay;
///
/// #[kernel]
/// impl UniformKernel<1, 1> for Decay {
///     const UNIFORMS: usize = 1;
///
///     fn eval_with<R: Real>(&self, [x]: [R; 1], uniforms: &Uniforms<R>) -> [R; 1] {
///         [x - uniforms[0] * x]
///     }
/// }
///
/// #[derive(Clone)]
/// struct Cooling;
///
/// impl Model for Cooling {
///     fn record<R: Real>(&self, program: &mut Program<R>) {
///         let (rate, x) = (program.parameter(1), program.state(3));
///         let [next] = program.map_with(Decay, [x], &[rate]);
///         program.advance(x, next);
///     }
/// }
///
/// let (cooling, start) = (Rollout::new(Cooling, 2), [4.0, 8.0, 12.0]);
/// assert_eq!(cooling.run(&start, &[&[0.5]]), [1.0, 2.0, 3.0]);
/// let sum = |rate: &[Var<f64>]| cooling.run(&start.map(Var::lit), &[rate]).iter().sum();
/// // The sum is 24 (1 - rate)^2.
/// assert_eq!(gradient(sum, &[0.5]), [-24.0]);
/// ```
pub trait UniformKernel<const I: usize, const O: usize>: Send + 'static {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// The number of uniform inputs, at most [`MOST_UNIFORMS`].
    const UNIFORMS: usize;

    /// Returns the results at `x`. Only the first [`UNIFORMS`](Self::UNIFORMS) numbers of `uniforms` are inputs.
    fn eval_with<R: Real>(&self, x: [R; I], uniforms: &Uniforms<R>) -> [R; O];

    /// Returns the cotangents of `x`, like [`Kernel::vjp`]. The cotangents of the uniform inputs, if they are needed,
    /// always come from dual numbers.
    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, I, O, M>,
        uniforms: &Uniforms<R>,
    ) -> [[R; I]; M] {
        vjp_by_duals_with(self, at, uniforms)
    }
}

impl<K: Kernel<I, O>, const I: usize, const O: usize> UniformKernel<I, O> for K {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    const UNIFORMS: usize = 0;

    #[inline(always)]
    fn eval_with<R: Real>(&self, x: [R; I], _: &Uniforms<R>) -> [R; O] {
        self.eval(x)
    }

    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, I, O, M>,
        _: &Uniforms<R>,
    ) -> [[R; I]; M] {
        self.vjp(at)
    }
}

/// A [`UniformKernel`] whose uniform inputs have constant values. It is a [`Kernel`].
#[derive(Clone, Debug)]
pub struct Fixed<K> {
    /// The kernel.
    pub kernel: K,
    /// The values of the uniform inputs.
    pub uniforms: Vec<f64>,
}

impl<K: UniformKernel<I, O>, const I: usize, const O: usize> Kernel<I, O> for Fixed<K> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; I]) -> [R; O] {
        self.kernel.eval_with(x, &constant_uniforms(&self.uniforms))
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, I, O, M>) -> [[R; I]; M] {
        let uniforms = constant_uniforms(&self.uniforms);
        self.kernel.vjp_with(at, &uniforms)
    }
}

#[inline(always)]
#[track_caller]
fn constant_uniforms<R: Real>(values: &[f64]) -> Uniforms<R> {
    let mut uniforms = [R::zero(); MOST_UNIFORMS];
    for (uniform, &value) in uniforms.iter_mut().zip(checked(values)) {
        *uniform = R::lit(value);
    }
    uniforms
}

/// Returns the list. Panics if it does not fit into [`Uniforms`].
#[inline(always)]
#[track_caller]
pub(crate) fn checked<T>(list: &[T]) -> &[T] {
    assert!(
        list.len() <= MOST_UNIFORMS,
        "a kernel can have at most {MOST_UNIFORMS} uniform inputs"
    );
    list
}

/// The default of [`UniformKernel::vjp_with`], which uses dual numbers.
#[inline(always)]
pub fn vjp_by_duals_with<R, K, const I: usize, const O: usize, const M: usize>(
    kernel: &K,
    at: Pullback<R, I, O, M>,
    uniforms: &Uniforms<R>,
) -> [[R; I]; M]
where
    R: Real,
    K: UniformKernel<I, O> + ?Sized,
{
    let y = kernel.eval_with(seeded(at.x), &constants(*uniforms));
    pulled_back(y, at.y_bar)
}

/// Returns the contribution of one element to the cotangent of uniform input `k`.
#[inline(always)]
fn by_uniform<R, K, const I: usize, const O: usize>(
    kernel: &K,
    (x, y_bar): ([R; I], [R; O]),
    uniforms: &Uniforms<R>,
    k: usize,
) -> R
where
    R: Real,
    K: UniformKernel<I, O>,
{
    let mut moving = constants::<R, 1, MOST_UNIFORMS>(*uniforms);
    moving[k].tangent = [R::one()];
    let y = kernel.eval_with(constants(x), &moving);
    let [[bar]] = pulled_back(y, [y_bar]);
    bar
}

/// The uniform inputs of an operation: arrays with one number for each start.
pub(super) struct UniformInputs {
    arrays: Vec<Array>,
    /// The indices of the uniform inputs that carry derivatives.
    active: Vec<usize>,
}

impl UniformInputs {
    /// `count` is the kernel's constant [`UniformKernel::UNIFORMS`].
    ///
    /// # Panics
    /// If this is not the number of arrays.
    #[track_caller]
    pub(super) fn new(arrays: &[Array], count: usize) -> Self {
        assert_eq!(
            checked(arrays).len(),
            count,
            "the number of uniform arrays must be the kernel's `UNIFORMS`"
        );
        Self {
            arrays: arrays.to_vec(),
            active: (0..arrays.len()).collect(),
        }
    }

    pub(super) fn set_active(&mut self, arrays: &[bool]) {
        let is_active = |k: &usize| arrays[self.arrays[*k].id];
        self.active = (0..self.arrays.len()).filter(is_active).collect();
    }

    /// Loads each uniform input into a register, in which the numbers of all starts repeat. `count` is the kernel's
    /// constant [`UniformKernel::UNIFORMS`].
    #[inline(always)]
    pub(super) fn load<R: Real, L: Lane<R>>(
        &self,
        count: usize,
        values: StepValues<R>,
    ) -> Uniforms<L> {
        let mut uniforms = [L::zero(); MOST_UNIFORMS];
        for k in 0..count {
            let numbers = values.get(self.arrays[k]);
            uniforms[k] = match numbers.len() {
                1 => L::splat(numbers[0]),
                starts if starts == L::N => L::load(numbers),
                starts => {
                    let mut lanes = [R::zero(); WIDEST];
                    for i in 0..L::N {
                        lanes[i] = numbers[i % starts];
                    }
                    L::load(&lanes)
                }
            };
        }
        uniforms
    }

    /// Adds the cotangents of the uniform inputs that carry derivatives, one element at a time. `at` returns an
    /// element's index, its inputs and the cotangents of its results. This does not use SIMD lanes: it is rarely
    /// needed, and every kernel would have to be compiled once more for every register width.
    #[inline(never)]
    pub(super) fn add_bars<R, K, E, const I: usize, const O: usize>(
        &self,
        kernel: &K,
        values: StepValues<R>,
        bars: &mut Bars<R>,
        elements: impl Iterator<Item = E>,
        at: impl Fn(&Bars<R>, E) -> (usize, [R; I], [R; O]),
    ) where
        R: Real,
        K: UniformKernel<I, O>,
    {
        if self.active.is_empty() {
            return;
        }
        for element in elements {
            let (place, x, y_bar) = at(bars, element);
            let mut uniforms = [R::zero(); MOST_UNIFORMS];
            for (uniform, &array) in uniforms.iter_mut().zip(&self.arrays) {
                *uniform = values.get(array)[place % array.len];
            }
            for &k in &self.active {
                let array = self.arrays[k];
                let bar = by_uniform(kernel, (x, y_bar), &uniforms, k);
                bars.get_mut(array)[place % array.len] += bar;
            }
        }
    }
}
