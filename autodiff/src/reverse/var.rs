//! The reverse variable, and the recording of its operations.

use super::current::{self, CONSTANT};
use super::entries::{Entry, Term};
use super::index::{NONE, STOPPED};
use crate::operators::by_primal;
use crate::real::{Mask, Real};

/// A value whose history a [`Tape`](crate::Tape) records; 16 bytes for f64.
///
/// Constants and results of constants have no history and are never recorded. `==`, `<` and [`Real::less`] compare
/// primals. [`Zero::is_zero`](num_traits::Zero::is_zero) is only true for a constant zero.
///
/// # Panics
/// Every operation that records panics if the variable's tape is not recording or has begun another recording,
/// and if variables of two recordings meet. Adding a constant records nothing, so it does not panic. After
/// 16 million recordings of its number type a stale variable may be mistaken for a current one.
#[derive(Clone, Copy, Debug)]
pub struct Var<R> {
    pub(super) value: R,
    /// The entry; `NONE` for a constant.
    pub(super) index: u32,
    /// The recording; `CONSTANT` for a constant.
    pub(super) generation: u32,
}

impl<R: Real> Var<R> {
    /// A number without history.
    #[inline(always)]
    pub fn constant(value: R) -> Self {
        Var {
            value,
            index: NONE,
            generation: CONSTANT,
        }
    }

    /// The primal.
    #[inline(always)]
    pub fn value(self) -> R {
        self.value
    }

    /// Whether the number has no history.
    #[inline(always)]
    pub fn is_constant(&self) -> bool {
        self.generation == CONSTANT
    }

    /// The generation of a result of a number and of others, which have the generation `so_far`.
    #[inline(always)]
    pub(super) fn common(so_far: u32, &Var { generation, .. }: &Self) -> u32 {
        if so_far == CONSTANT || so_far == generation {
            generation
        } else if generation == CONSTANT {
            so_far
        } else {
            mixed()
        }
    }

    // Everything up to the operators is always inlined. A variable that is stored in one width and loaded in
    // another stalls for longer than the rest of an operation takes.

    /// A function of one number, given its value and partial.
    #[inline(always)]
    pub(super) fn apply(self, (value, partial): (R, R)) -> Self {
        let entry = Entry {
            partials: [partial, partial],
            parents: [self.index, NONE],
        };
        Self::record(value, entry, self.generation)
    }

    /// A function of two numbers, given its value and partials.
    #[inline(always)]
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

    /// Whether both refer to the same entry. Their values may differ by added constants.
    #[inline(always)]
    pub(super) fn is(self, other: Self) -> bool {
        (self.index, self.generation) == (other.index, other.generation)
    }

    /// The number plus a constant, which is another value at the same entry. Nothing is recorded.
    #[inline(always)]
    pub(super) fn moved_to(self, value: R) -> Self {
        Var { value, ..self }
    }

    /// The product with a variable, given its value.
    #[inline(always)]
    pub(super) fn product(self, factor: Self, value: R) -> Self {
        if self.is(factor) {
            // `(x + a) (x + b)`: one parent.
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

    /// The product with a constant, given its value. A constant zero counts as a choice.
    #[inline(always)]
    pub(super) fn times_constant(self, factor: R, value: R) -> Self {
        if is_choice(&factor) {
            return self.stopped(value);
        }
        self.apply((value, factor))
    }

    /// A value that depends on this number but passes no derivative to it, because of a choice.
    pub(super) fn stopped(self, value: R) -> Self {
        let entry = Entry {
            partials: [R::zero(), R::zero()],
            parents: [STOPPED, self.index],
        };
        Self::record(value, entry, self.generation)
    }

    /// Appends an entry for a value, unless it is a constant.
    #[inline(always)]
    fn record(value: R, entry: Entry<R>, generation: u32) -> Self {
        if generation == CONSTANT {
            return Self::constant(value);
        }
        // SAFETY: the generations of variables of `R` belong to recordings of `R`.
        #[allow(unsafe_code)]
        let index = unsafe { current::push(generation, entry) };
        Var {
            value,
            index,
            generation,
        }
    }

    /// A value with many terms. Terms of constants, whose parent is `NONE`, are skipped.
    #[inline(always)]
    pub(super) fn push_linear(
        value: R,
        terms: impl Iterator<Item = Term<R>>,
        generation: u32,
    ) -> Self {
        if generation == CONSTANT {
            return Self::constant(value);
        }
        let terms = terms.filter(|term| term.parent != NONE);
        let zero = R::zero();
        // SAFETY: the iterators of both callers read slices of `Copy` numbers and run no code of others.
        #[allow(unsafe_code)]
        let index = unsafe { current::with(generation, |arena| arena.push_linear(terms, zero)) };
        Var {
            value,
            index,
            generation,
        }
    }
}

/// Whether a constant factor and all derivatives that it carries are zero. False for lanes, because each lane
/// chooses separately and one entry cannot represent that.
#[inline(always)]
pub(super) fn is_choice<R: Real>(factor: &R) -> bool {
    R::Mask::IS_SINGLE && factor.is_zero()
}

/// Has no arguments, because passing the two recordings would cost every operation instructions.
#[cold]
fn mixed() -> ! {
    panic!(
        "variables of two recordings met in one operation: one of them belongs to an earlier recording, \
         or two tapes are recording; to nest tapes, record `Var<Var<f64>>` in the inner one"
    )
}

by_primal! { [] Var<R> }
