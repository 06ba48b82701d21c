//! Small pure functions that are mapped over arrays, and their derivatives.

use num_traits::Zero;

use crate::dual::Dual;
use crate::real::Real;

/// A pure function of `I` numbers with `O` results: a spring, a contact, a reaction.
///
/// [`Program::map`](crate::Program::map) maps a kernel over whole arrays in SIMD lanes, so a kernel selects and
/// never branches. Its constants are fields of the implementing type. The type must own them, because
/// programs keep the kernel.
///
/// A number that all elements share, such as gravity, is a field if it is a constant. If robots of one batch may
/// differ in it, or a derivative by it is needed, it is a [uniform input](Uniforms).
///
/// A kernel only has to implement `eval`. Its derivatives then come from dual numbers. Their cost grows with
/// the number of inputs: about seven evaluations of the kernel for eight inputs, seventy for fifty.
/// Straight-line code that is [emitted](crate::emit) from a recording of `eval` costs two to four evaluations
/// for any number of inputs. To use it, override [`vjp`](Kernel::vjp) with one line that calls it.
///
/// **Mark `eval`, and every function of yours that it calls, `#[inline(always)]`.** The instruction set
/// of the lanes is chosen at run time, for the loop around the kernel. A function that is not inlined
/// into that loop is compiled without it, and every operation in it becomes a call. The results stay the same
/// but take some fifty times as long. Closures cannot be marked, so prefer loops.
pub trait Kernel<const I: usize, const O: usize>: Send + 'static {
    /// The number of uniform inputs, at most [`MOST_UNIFORMS`].
    const UNIFORMS: usize = 0;

    /// Returns the results at `x`. Mark it `#[inline(always)]`.
    fn eval<R: Real>(&self, x: [R; I]) -> [R; O];

    /// Returns the results at `x` with these uniform inputs. If there are any, override this method and
    /// [`vjp_with`](Kernel::vjp_with), and mark both `#[inline(always)]`.
    #[inline(always)]
    fn eval_with<R: Real>(&self, x: [R; I], _uniforms: &Uniforms<R>) -> [R; O] {
        self.eval(x)
    }

    /// Returns the cotangents of the inputs (VJPs), one row for each row of cotangents of the results. This is the
    /// only derivative of a kernel. [`Program::map`](crate::Program::map) and
    /// [`data::jacobians`](crate::data::jacobians) call it.
    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, I, O, M>) -> [[R; I]; M] {
        vjp_by_duals(self, at)
    }

    /// [`vjp`](Kernel::vjp) with these uniform inputs. The cotangents of the uniform inputs come from dual numbers, if
    /// they are needed.
    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, I, O, M>,
        _uniforms: &Uniforms<R>,
    ) -> [[R; I]; M] {
        self.vjp(at)
    }
}

/// The most uniform inputs of a kernel.
pub const MOST_UNIFORMS: usize = 16;

/// The uniform inputs of a kernel, which are numbers that all elements share, followed by zeros.
///
/// ```
/// use autodiff::arrays::{Uniforms, uniforms};
/// use autodiff::{Kernel, Model, Program, Real, Rollout, Var, gradient_of};
///
/// struct Decay;
///
/// impl Kernel<1, 1> for Decay {
///     const UNIFORMS: usize = 1;
///
///     #[inline(always)]
///     fn eval<R: Real>(&self, x: [R; 1]) -> [R; 1] {
///         self.eval_with(x, &uniforms(&[0.5]))
///     }
///
///     #[inline(always)]
///     fn eval_with<R: Real>(&self, [x]: [R; 1], uniforms: &Uniforms<R>) -> [R; 1] {
///         [x - uniforms[0] * x]
///     }
///
///     #[inline(always)]
///     fn vjp_with<R: Real, const M: usize>(
///         &self,
///         at: autodiff::Pullback<R, 1, 1, M>,
///         uniforms: &Uniforms<R>,
///     ) -> [[R; 1]; M] {
///         autodiff::arrays::vjp_by_duals_with(self, at, uniforms)
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
/// assert_eq!(gradient_of(sum, &[0.5]), [-24.0]);
/// ```
pub type Uniforms<R> = [R; MOST_UNIFORMS];

/// Uniform inputs with these constant values.
///
/// # Panics
/// If there are more than [`MOST_UNIFORMS`].
#[inline(always)]
pub fn uniforms<R: Real>(values: &[f64]) -> Uniforms<R> {
    let mut uniforms = [R::zero(); MOST_UNIFORMS];
    for (uniform, &value) in uniforms.iter_mut().zip(checked(values)) {
        *uniform = R::lit(value);
    }
    uniforms
}

/// Checks that a list fits into [`Uniforms`].
#[inline(always)]
pub(crate) fn checked<T>(list: &[T]) -> &[T] {
    assert!(
        list.len() <= MOST_UNIFORMS,
        "a kernel has at most {MOST_UNIFORMS} uniform inputs"
    );
    list
}

/// The arguments of [`Kernel::vjp`].
#[derive(Clone, Copy, Debug)]
pub struct Pullback<R, const I: usize, const O: usize, const M: usize> {
    /// The inputs.
    pub x: [R; I],
    /// The results at `x`. Results that the derivative does not read are not computed.
    pub y: [R; O],
    /// Cotangents of the results. One row gives an adjoint. The rows of the identity give the Jacobian.
    pub y_bar: [[R; O]; M],
}

impl<R: Real, const I: usize, const O: usize, const M: usize> Pullback<R, I, O, M> {
    /// Evaluates the kernel to get the results.
    #[inline(always)]
    pub fn new(kernel: &impl Kernel<I, O>, x: [R; I], y_bar: [[R; O]; M]) -> Self {
        let y = kernel.eval(x);
        Self { x, y, y_bar }
    }
}

/// The default of [`Kernel::vjp`], which uses dual numbers. For kernels that override it only in some cases.
#[inline(always)]
pub fn vjp_by_duals<R, K, const I: usize, const O: usize, const M: usize>(
    kernel: &K,
    at: Pullback<R, I, O, M>,
) -> [[R; I]; M]
where
    R: Real,
    K: Kernel<I, O> + ?Sized,
{
    let y = kernel.eval(seeded(at.x));
    pulled_back(y, at.y_bar)
}

/// [`Kernel::vjp_with`] by dual numbers.
#[inline(always)]
pub fn vjp_by_duals_with<R, K, const I: usize, const O: usize, const M: usize>(
    kernel: &K,
    at: Pullback<R, I, O, M>,
    uniforms: &Uniforms<R>,
) -> [[R; I]; M]
where
    R: Real,
    K: Kernel<I, O> + ?Sized,
{
    let y = kernel.eval_with(seeded(at.x), &constants(*uniforms));
    pulled_back(y, at.y_bar)
}

/// The cotangent of the uniform input number `k`, from one element.
#[inline(always)]
pub(crate) fn by_uniform<R, K, const I: usize, const O: usize>(
    kernel: &K,
    (x, y_bar): ([R; I], [R; O]),
    uniforms: &Uniforms<R>,
    k: usize,
) -> R
where
    R: Real,
    K: Kernel<I, O>,
{
    let mut moving = constants::<R, 1, MOST_UNIFORMS>(*uniforms);
    moving[k].tangent = [R::one()];
    let y = kernel.eval_with(constants(x), &moving);
    let [[bar]] = pulled_back(y, [y_bar]);
    bar
}

/// Duals of constants. Here and below there are loops, because closures might be compiled without the caller's
/// instruction set.
#[inline(always)]
fn constants<R: Real, const N: usize, const L: usize>(x: [R; L]) -> [Dual<R, N>; L] {
    let mut constants = [Dual::zero(); L];
    for i in 0..L {
        constants[i] = Dual::constant(x[i]);
    }
    constants
}

/// Duals of variables, one direction each.
#[inline(always)]
fn seeded<R: Real, const I: usize>(x: [R; I]) -> [Dual<R, I>; I] {
    let mut seeded = [Dual::zero(); I];
    for i in 0..I {
        seeded[i] = Dual::variable(x[i], i);
    }
    seeded
}

/// The rows of cotangents times the tangents of the results.
#[inline(always)]
fn pulled_back<R: Real, const I: usize, const O: usize, const M: usize>(
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
