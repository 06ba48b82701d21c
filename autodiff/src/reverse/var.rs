//! The reverse variable, and how its operations are recorded.

use super::current::{self, CONSTANT};
use super::entries::{Entry, Term};
use super::index::{NONE, STOPPED};
use crate::operators::by_primal;
use crate::real::{Mask, Real};

/// A value whose history is recorded by a [`Tape`](crate::Tape); 16 bytes for f64.
///
/// Constants, and results of constants only, have no history and are never recorded. `<` and [`Real::less`] compare
/// values, without derivatives. [`Zero::is_zero`](num_traits::Zero::is_zero) is only true for a constant zero, and a
/// number with a history never `==` a constant ([pitfalls](crate::guide#pitfalls)).
///
/// # Panics
/// Every operation that records panics if the variable's tape is not recording or has begun another recording, and if
/// its operands belong to different recordings. Adding a constant records nothing, so it does not panic. A variable of
/// an old recording may be mistaken for a current one if 16 million recordings of the same number type lie between
/// them.
#[derive(Clone, Copy, Debug)]
pub struct Var<R> {
    pub(super) value: R,
    /// The index of the variable's entry on the tape; `NONE` for a constant.
    pub(super) index: u32,
    /// The generation, which identifies the recording; `CONSTANT` for a constant.
    pub(super) generation: u32,
}

impl<R: Real> Var<R> {
    /// Makes a constant, which has no history.
    #[inline(always)]
    pub fn constant(value: R) -> Self {
        Var {
            value,
            index: NONE,
            generation: CONSTANT,
        }
    }

    /// The value, without its derivative.
    #[inline(always)]
    pub fn value(self) -> R {
        self.value
    }

    /// Whether the number is a constant, which has no history.
    #[inline(always)]
    pub fn is_constant(&self) -> bool {
        self.generation == CONSTANT
    }

    /// Returns the common generation of a variable and of the operands before it, whose common generation is `so_far`.
    /// Panics if they belong to different recordings.
    #[inline(always)]
    #[track_caller]
    pub(super) fn common(so_far: u32, Var { generation, .. }: Self) -> u32 {
        if so_far == CONSTANT || so_far == generation {
            generation
        } else if generation == CONSTANT {
            so_far
        } else {
            mixed()
        }
    }

    /// Returns the common generation of the variables in a slice and of the operands before them, like
    /// [`common`](Self::common).
    #[track_caller]
    pub(super) fn common_of(numbers: &[Self], mut so_far: u32) -> u32 {
        for &number in numbers {
            so_far = Self::common(so_far, number);
        }
        so_far
    }

    // Everything up to the operators is always inlined. Otherwise a variable may be stored in one width and loaded in
    // another, and that stall takes longer than the rest of an operation.

    /// Records a function of one number, given its value and partial.
    #[inline(always)]
    #[track_caller]
    pub(super) fn apply(self, (value, partial): (R, R)) -> Self {
        let entry = Entry {
            partials: [partial, partial],
            parents: [self.index, NONE],
        };
        Self::record(value, entry, self.generation)
    }

    /// Records a function of two numbers, given its value and partials.
    #[inline(always)]
    #[track_caller]
    pub(super) fn apply2(self, other: Self, (value, partials): (R, [R; 2])) -> Self {
        if self.generation == other.generation {
            let entry = Entry {
                partials,
                parents: [self.index, other.index],
            };
            return Self::record(value, entry, self.generation);
        }
        if other.is_constant() {
            return self.apply((value, partials[0]));
        }
        if self.is_constant() {
            return other.apply((value, partials[1]));
        }
        mixed()
    }

    /// Whether two variables refer to the same entry. Their values may differ, because adding a constant keeps the
    /// entry.
    #[inline(always)]
    pub(super) fn is(self, other: Self) -> bool {
        (self.index, self.generation) == (other.index, other.generation)
    }

    /// Adds a constant, given the sum. The result has the same entry, so nothing is recorded.
    #[inline(always)]
    pub(super) fn moved_to(self, value: R) -> Self {
        Var { value, ..self }
    }

    /// Records the product with a variable, given the value of the product.
    #[inline(always)]
    #[track_caller]
    pub(super) fn product(self, factor: Self, value: R) -> Self {
        if self.is(factor) {
            // `(x + a) (x + b)` has only one parent, `x`.
            return self.apply((value, self.value + factor.value));
        }
        if self.generation != factor.generation {
            if factor.is_constant() {
                return self.times_constant(factor.value, value);
            }
            if self.is_constant() {
                return factor.times_constant(self.value, value);
            }
        }
        self.apply2(factor, (value, [factor.value, self.value]))
    }

    /// Records the product with a constant, given the value of the product. A constant zero passes no derivative.
    #[inline(always)]
    #[track_caller]
    pub(super) fn times_constant(self, factor: R, value: R) -> Self {
        if is_choice(&factor) {
            return self.stopped(value);
        }
        self.apply((value, factor))
    }

    /// Records a value that depends on this number but passes no derivative to it, because of a choice.
    #[track_caller]
    pub(super) fn stopped(self, value: R) -> Self {
        let entry = Entry {
            partials: [R::zero(), R::zero()],
            parents: [STOPPED, self.index],
        };
        Self::record(value, entry, self.generation)
    }

    /// Records the entry of a value, unless the value is a constant.
    #[inline(always)]
    #[track_caller]
    fn record(value: R, entry: Entry<R>, generation: u32) -> Self {
        if generation == CONSTANT {
            return Self::constant(value);
        }
        // SAFETY: the generation of a `Var<R>` belongs to a recording of `R`.
        #[allow(unsafe_code)]
        let index = unsafe { current::push(generation, entry) };
        Var {
            value,
            index,
            generation,
        }
    }

    /// Records a value with many terms. Terms of constants, whose parent is `NONE`, are skipped.
    ///
    /// # Safety
    /// The iterator must run no code from outside `reverse`: neither conversions nor methods of the number type. Such code
    /// could record on the same tape while the arena is borrowed.
    #[allow(unsafe_code)]
    #[inline(always)]
    #[track_caller]
    pub(super) unsafe fn push_linear(
        value: R,
        terms: impl Iterator<Item = Term<R>>,
        generation: u32,
    ) -> Self {
        if generation == CONSTANT {
            return Self::constant(value);
        }
        let terms = terms.filter(|term| term.parent != NONE);
        let zero = R::zero();
        // SAFETY: the generation of a `Var<R>` belongs to a recording of `R`. The caller guarantees the rest.
        let index = unsafe { current::with(generation, |arena| arena.push_linear(terms, zero)) };
        Var {
            value,
            index,
            generation,
        }
    }
}

/// Whether a constant factor and all derivatives that it carries are zero. Always false for lanes: the factor may be
/// zero in some lanes only, which one entry cannot represent.
#[inline(always)]
pub(super) fn is_choice<R: Real>(factor: &R) -> bool {
    R::Mask::IS_SINGLE && factor.is_zero()
}

/// Panics with the message that the operands belong to different recordings. This function takes no arguments, because
/// passing the two generations would cost every operation a few instructions.
#[cold]
#[track_caller]
fn mixed() -> ! {
    panic!(
        "an operation was given variables of two recordings: one belongs to an earlier recording, \
         or they belong to two tapes; to nest tapes, record `Var<Var<f64>>` on the inner one"
    )
}

by_primal! { [] Var<R>, |x| x.generation != CONSTANT }
