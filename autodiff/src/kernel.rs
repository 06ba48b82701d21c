//! Small pure functions that are mapped over arrays, and their local adjoints.

use num_traits::Zero;

use crate::forward::Dual;
use crate::real::Real;

/// A pure function of `I` numbers with `O` results: a spring, a contact, a reaction.
///
/// It is mapped over whole arrays by [`Program::map`](crate::Program::map), in SIMD lanes, so it
/// selects and never branches. Its constants are fields of the implementing type, which borrows
/// nothing: programs keep it.
///
/// **`eval`, and every function of yours that it calls, is `#[inline(always)]`.** The lanes' registers
/// belong to an instruction set that is chosen at run time, for the loop around the kernel: a function
/// that is not inlined into that loop is compiled without it, and every operation in it becomes a
/// call. The numbers are the same, some fifty times slower. Closures are not inlined by order: loops
/// are better.
pub trait Kernel<const I: usize, const O: usize>: Send + 'static {
    /// The function; `#[inline(always)]`.
    fn eval<R: Real>(&self, x: [R; I]) -> [R; O];
}

/// The reverse derivative of a [`Kernel`]. `impl Adjoint<I, O> for K {}` is enough: it then runs
/// the kernel on dual numbers, which costs the more the more inputs there are, some seven evaluations
/// for eight and seventy for fifty. Straight-line code [emitted](crate::emit) from a recording may
/// override it, and costs two to four, whatever their number.
pub trait Adjoint<const I: usize, const O: usize>: Kernel<I, O> {
    /// The cotangents of `x`, given those of the results.
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; I], y_bar: [R; O]) -> [R; I] {
        // Loops, not closures: those would not take on the caller's instruction set.
        let mut seeded = [Dual::<R, I>::zero(); I];
        for i in 0..I {
            seeded[i] = Dual::variable(x[i], i);
        }
        let y = self.eval(seeded);
        let mut x_bar = [R::zero(); I];
        for o in 0..O {
            for i in 0..I {
                x_bar[i] = R::chain_add(y[o].tangent[i], y_bar[o], x_bar[i]);
            }
        }
        x_bar
    }

    /// The same, given also the results: what stands there need not be computed again. It is
    /// what the reverse sweep of [`Program::map`](crate::Program::map) calls.
    #[inline(always)]
    fn vjp_with_results<R: Real>(&self, x: [R; I], _y: [R; O], y_bar: [R; O]) -> [R; I] {
        self.vjp(x, y_bar)
    }
}

/// All partials of a [`Kernel`] at once. `impl Partials<I, O> for K {}` is enough: it then runs
/// the kernel on dual numbers. Straight-line code emitted from a recording may override it.
pub trait Partials<const I: usize, const O: usize>: Kernel<I, O> {
    /// The results, and per result its partials by every input.
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
