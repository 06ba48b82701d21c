//! Small pure functions that are mapped over arrays, with their local derivatives.

use num_traits::Zero;

use crate::dual::Dual;
use crate::real::Real;

/// A pure function of `I` numbers with `O` results: a spring, a contact, a reaction.
///
/// [`Program::map`](crate::Program::map) maps it over whole arrays in SIMD lanes, so it selects and
/// never branches. Its constants are fields of the implementing type. The type must own them, because
/// programs keep the kernel.
///
/// `eval` is all that a kernel has to supply. The derivatives then come from dual numbers, at a cost
/// that grows with the number of inputs: about seven evaluations of the kernel for eight inputs,
/// seventy for fifty. Straight-line code [emitted](crate::emit) from a recording of `eval` costs two to
/// four evaluations for any number of inputs; a kernel overrides `vjp`, `vjp_with_results` or `partials`
/// with a line that calls it.
///
/// **Mark `eval`, and every function of yours that it calls, `#[inline(always)]`.** The instruction set
/// of the lanes is chosen at run time, for the loop around the kernel: a function that is not inlined
/// into that loop is compiled without it, and every operation in it becomes a call. The numbers are
/// the same, some fifty times slower. Closures cannot be marked so: prefer loops.
pub trait Kernel<const I: usize, const O: usize>: Send + 'static {
    /// The results at `x`; mark it `#[inline(always)]`.
    fn eval<R: Real>(&self, x: [R; I]) -> [R; O];

    /// The cotangents of `x`, given those of the results (a VJP).
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; I], y_bar: [R; O]) -> [R; I] {
        self.vjp_by_partials(x, y_bar)
    }

    /// The default of [`vjp`](Kernel::vjp), from [`partials`](Kernel::partials), for kernels that override
    /// it for some cases only.
    #[inline(always)]
    fn vjp_by_partials<R: Real>(&self, x: [R; I], y_bar: [R; O]) -> [R; I] {
        let (_, by_x) = self.partials(x);
        let mut x_bar = [R::zero(); I];
        // Loops, not closures, which might be compiled without the caller's instruction set.
        for o in 0..O {
            for i in 0..I {
                x_bar[i] = R::chain_add(by_x[o][i], y_bar[o], x_bar[i]);
            }
        }
        x_bar
    }

    /// The cotangents of `x`, given those of the results and the results `y` themselves, which need
    /// not be computed again. The reverse sweep of [`Program::map`](crate::Program::map) calls this one.
    #[inline(always)]
    fn vjp_with_results<R: Real>(&self, x: [R; I], _y: [R; O], y_bar: [R; O]) -> [R; I] {
        self.vjp(x, y_bar)
    }

    /// The results, and the Jacobian: one row per result, one column per input.
    #[inline(always)]
    fn partials<R: Real>(&self, x: [R; I]) -> ([R; O], [[R; I]; O]) {
        let mut seeded = [Dual::<R, I>::zero(); I];
        for i in 0..I {
            seeded[i] = Dual::variable(x[i], i);
        }
        let y = self.eval(seeded);
        let (mut values, mut partials) = ([R::zero(); O], [[R::zero(); I]; O]);
        for o in 0..O {
            values[o] = y[o].value;
            partials[o] = y[o].tangent;
        }
        (values, partials)
    }
}
