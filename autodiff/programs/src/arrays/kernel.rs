//! Small pure functions that are mapped over arrays, and their derivatives.

use autodiff::internal::seeded;
use autodiff::{Dual, Real};
use num_traits::Zero;

/// The largest number of uniform inputs that a kernel can have.
pub const MOST_UNIFORMS: usize = 16;

/// For which registers a [`Kernel`] is compiled: the fewer, the sooner. Where it is compiled for none, programs replay a
/// recording of it, which takes several times as long and has the same results, except for rounding. The least comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Compiled {
    /// For none. This suits a kernel whose formula is data, because each of its operations is chosen once, when the kernel is
    /// recorded. [`Kernel::vjp`] is not used.
    Never,
    /// For registers of at most 256 bits; on WebAssembly for none. This suits a kernel that is used seldom.
    Seldom,
    /// For registers of at most 256 bits.
    Narrow,
    /// For registers of every width.
    Fully,
}

impl Compiled {
    /// The lesser of the two.
    #[must_use]
    pub const fn at_most(self, most: Self) -> Self {
        if (self as u8) < (most as u8) {
            self
        } else {
            most
        }
    }

    /// Whether a kernel has registers of 512 bits.
    pub(crate) const fn has_512(self) -> bool {
        matches!(self, Self::Fully)
    }

    /// Whether programs replay a recording of a kernel, in place of compiled code.
    pub(crate) const fn is_replayed(self) -> bool {
        match self {
            Self::Never => true,
            Self::Seldom => cfg!(target_arch = "wasm32"),
            Self::Narrow | Self::Fully => false,
        }
    }
}

/// A pure function of `I` numbers with `O` results, such as a spring, a contact or a chemical reaction.
///
/// [`Program::map`](crate::Program::map) maps a kernel over whole arrays in SIMD lanes. So a kernel must not branch on
/// a number; it selects between two results instead. Its constants are fields of the implementing type. The type must
/// own its data, because programs keep the kernel.
///
/// A number that all elements share, such as gravity, can be a field if it is a constant. It must be a **uniform input**
/// if it may differ between the starts of a batch, or if you need derivatives with respect to it.
///
/// ```
/// use autodiff::{Real, Var, gradient};
/// use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};
///
/// struct Decay;
///
/// #[kernel]
/// impl Kernel<1, 1> for Decay {
///     const UNIFORMS: usize = 1;
///
///     fn eval<R: Real>(&self, [x]: [R; 1], rate: &[R]) -> [R; 1] {
///         [x - rate[0] * x]
///     }
/// }
///
/// #[derive(Clone)]
/// struct Cooling;
///
/// impl Model for Cooling {
///     fn record(&self, program: &mut Program) {
///         let (rate, x) = (program.parameter(1), program.state(3));
///         let [next] = program.map(Decay, [x], &[rate]);
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
///
/// Give the inputs of a larger kernel names by [`Fields`](crate::Fields), so that neither the kernel nor its caller counts
/// positions.
///
/// A kernel only has to implement `eval`. Its derivatives then come from dual numbers, whose cost grows with the number
/// of inputs: about seven evaluations of the kernel for eight inputs, and seventy for fifty. Straight-line code that is
/// [emitted](crate::emit) from a recording of `eval` costs two to four evaluations for any number of inputs. To use it,
/// override [`vjp`](Kernel::vjp) with one line that calls it.
///
/// The attribute [`kernel`](macro@crate::kernel) on the `impl` makes the methods part of the loop around the kernel. Put it
/// also on the functions of yours that they call. An `impl` without it does not compile:
///
/// ```
/// use autodiff::Real;
/// use autodiff_programs::{Kernel, kernel};
///
/// struct Square;
///
/// #[kernel]
/// impl Kernel<1, 1> for Square {
///     fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
///         [x * x]
///     }
/// }
/// ```
///
/// ```compile_fail,E0046
/// use autodiff::Real;
/// use autodiff_programs::Kernel;
///
/// struct Square;
///
/// impl Kernel<1, 1> for Square {
///     fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
///         [x * x]
///     }
/// }
/// ```
pub trait Kernel<const I: usize, const O: usize>: Send + 'static {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// The number of uniform inputs, at most [`MOST_UNIFORMS`](super::MOST_UNIFORMS). All elements share them.
    const UNIFORMS: usize = 0;

    /// For which registers the kernel is compiled.
    const COMPILED: Compiled = Compiled::Fully;

    /// Returns the results at `x`. `uniforms` has [`UNIFORMS`](Self::UNIFORMS) numbers.
    fn eval<R: Real>(&self, x: [R; I], uniforms: &[R]) -> [R; O];

    /// Returns the cotangents of the inputs (VJPs). There is one row for each row of `at.y_bar`, which holds cotangents
    /// of the results. [`Program::map`](crate::Program::map) and [`data::jacobians`](crate::data::jacobians) get all
    /// derivatives of a kernel from this method, except those with respect to uniform inputs: if they are needed, they
    /// come from dual numbers.
    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, I, O, M>) -> [[R; I]; M] {
        vjp_by_duals(self, at)
    }
}

/// The arguments of [`Kernel::vjp`].
#[derive(Clone, Copy, Debug)]
pub struct Pullback<'a, R, const I: usize, const O: usize, const M: usize> {
    /// The inputs.
    pub x: [R; I],
    /// The uniform inputs.
    pub uniforms: &'a [R],
    /// The results at `x`. The compiler removes the computation of results that `vjp` does not read.
    pub y: [R; O],
    /// The cotangents of the results. One row gives an adjoint; the rows of the identity matrix give the Jacobian.
    pub y_bar: [[R; O]; M],
}

impl<'a, R: Real, const I: usize, const O: usize, const M: usize> Pullback<'a, R, I, O, M> {
    /// Evaluates the kernel at `x` to fill in `y`.
    #[inline(always)]
    pub fn new(
        kernel: &impl Kernel<I, O>,
        x: [R; I],
        uniforms: &'a [R],
        y_bar: [[R; O]; M],
    ) -> Self {
        Self {
            x,
            uniforms,
            y: kernel.eval(x, uniforms),
            y_bar,
        }
    }
}

/// The default of [`Kernel::vjp`], which uses dual numbers. Call it in an override that handles only some cases itself.
#[inline(always)]
pub fn vjp_by_duals<R, K, const I: usize, const O: usize, const M: usize>(
    kernel: &K,
    at: Pullback<R, I, O, M>,
) -> [[R; I]; M]
where
    R: Real,
    K: Kernel<I, O> + ?Sized,
{
    let uniforms = constants::<R, I, MOST_UNIFORMS>(&at.uniforms[..K::UNIFORMS]);
    let y = kernel.eval(seeded(at.x), &uniforms[..K::UNIFORMS]);
    pulled_back(y, at.y_bar)
}

// `vjp_by_duals` consists of `seeded` and the next two functions. An override of `Kernel::vjp` calls them itself if a part of its
// results, such as the result of a search, has no derivatives and should be computed without tangents. They use loops, because
// closures might be compiled without the caller's instruction set.

/// Converts numbers to duals with zero tangents. Behind them come zeros up to the length `L`.
#[inline(always)]
pub fn constants<R: Real, const N: usize, const L: usize>(x: &[R]) -> [Dual<R, N>; L] {
    let mut constants = [Dual::zero(); L];
    for i in 0..x.len() {
        constants[i] = Dual::constant(x[i]);
    }
    constants
}

/// Multiplies each row of cotangents by the tangents of the results.
#[inline(always)]
pub fn pulled_back<R: Real, const I: usize, const O: usize, const M: usize>(
    y: [Dual<R, I>; O],
    y_bar: [[R; O]; M],
) -> [[R; I]; M] {
    let mut x_bar = [[R::zero(); I]; M];
    for m in 0..M {
        for o in 0..O {
            for i in 0..I {
                x_bar[m][i] = R::chain_add(y[o].tangent[i], y_bar[m][o], x_bar[m][i]);
            }
        }
    }
    x_bar
}
