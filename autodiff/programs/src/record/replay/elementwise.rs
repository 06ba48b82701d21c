//! Longer functions of one or two numbers, computed register by register in memory.
//!
//! Such a function takes many instructions. If it were inlined for every register of a block, and again for other block
//! lengths, most of the code would be copies of these functions.

use autodiff::Real;
use autodiff::simd::{Lane, Vectorized};

use super::block::{Block, load, store};
use crate::arrays::Aligned;
use crate::record::arithmetic::{binary, binary_value, unary, unary_value};
use crate::record::operation::{Binary, Unary};

#[derive(Clone, Copy)]
pub(super) enum Function {
    /// A function of one number, without its partial.
    UnaryValue(Unary),
    Unary(Unary),
    /// A function of two numbers, without its partials.
    BinaryValue(Binary),
    Binary(Binary),
}

/// A function of numbers in memory. `numbers` holds first the arguments, then the values, then any partials. Each takes
/// `len` numbers.
pub(super) struct Elementwise<'a, R> {
    function: Function,
    numbers: &'a mut [R],
    len: usize,
}

impl<R: Real> Elementwise<'_, R> {
    /// Computes the value of a function of `I` numbers and its partials. The result has `O` blocks: the value first.
    #[inline(always)]
    pub(super) fn apply<L: Lane<R>, const W: usize, const I: usize, const O: usize>(
        function: Function,
        x: [Block<L, W>; I],
        memory: &mut Aligned<R>,
    ) -> [Block<L, W>; O] {
        let mut y = [x[0]; O];
        if const { W * L::N == 1 } {
            let (a, b) = (x[0][0], x[I - 1][0]);
            if const { O == 1 } {
                y[0][0] = single_value(function, a, b);
                return y;
            }
            let all = single(function, a, b);
            for o in 0..O {
                y[o][0] = all[o];
            }
            return y;
        }
        let len = W * L::N;
        memory.make_room((I + O) * len);
        for (k, x) in x.into_iter().enumerate() {
            store(memory, k, x);
        }
        R::vectorize(Elementwise {
            function,
            numbers: memory,
            len,
        });
        for (k, y) in y.iter_mut().enumerate() {
            *y = load(memory, I + k);
        }
        y
    }
}

/// Computes a function of single numbers, without partials. It is compiled only once for each number type.
#[inline(never)]
fn single_value<L: Real>(function: Function, a: L, b: L) -> L {
    match function {
        Function::UnaryValue(f) | Function::Unary(f) => unary_value(f, a),
        Function::BinaryValue(f) | Function::Binary(f) => binary_value(f, a, b),
    }
}

/// Computes a function of single numbers and its partials. It is compiled only once for each number type.
#[inline(never)]
fn single<L: Real>(function: Function, a: L, b: L) -> [L; 3] {
    match function {
        Function::UnaryValue(f) | Function::Unary(f) => {
            let (y, partial) = unary(f, a);
            [y, partial, partial]
        }
        Function::BinaryValue(f) | Function::Binary(f) => {
            let (y, [by_a, by_b]) = binary(f, a, b);
            [y, by_a, by_b]
        }
    }
}

impl<R: Real> Vectorized<R> for Elementwise<'_, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    const HAS_512: bool = false; // as for the replay around it
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self {
            function,
            numbers,
            len,
        } = self;
        for at in (0..len).step_by(L::N) {
            let x = L::load(&numbers[at..]);
            match function {
                Function::UnaryValue(f) => unary_value(f, x).store(&mut numbers[len + at..]),
                Function::Unary(f) => {
                    let (y, partial) = unary(f, x);
                    y.store(&mut numbers[len + at..]);
                    partial.store(&mut numbers[2 * len + at..]);
                }
                Function::BinaryValue(f) => {
                    let y = binary_value(f, x, L::load(&numbers[len + at..]));
                    y.store(&mut numbers[2 * len + at..]);
                }
                Function::Binary(f) => {
                    let (y, [by_a, by_b]) = binary(f, x, L::load(&numbers[len + at..]));
                    y.store(&mut numbers[2 * len + at..]);
                    by_a.store(&mut numbers[3 * len + at..]);
                    by_b.store(&mut numbers[4 * len + at..]);
                }
            }
        }
    }
}
