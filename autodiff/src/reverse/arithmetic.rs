//! Implements [`Real`] for variables.

use num_traits::Zero;
use smallvec::SmallVec;

use super::current::{self, CONSTANT};
use super::entries::Term;
use super::fused;
use super::var::{Var, is_choice};
use crate::operators::{closure_operators, constants_by_f64, literal_operators, operators};
use crate::real::{Accepts, Fused, Real};
use crate::rule::{self, by_choice, by_rule};

impl<R: Real> Real for Var<R> {
    type Mask = R::Mask;

    by_rule! {
        #[inline]
        |x, _, rule| x.apply(rule),
        |x, y, _, rule| x.apply2(y, rule),
    }
    by_choice! { #[inline] }

    /// Records an entry only if the mask differs between lanes.
    #[inline]
    #[track_caller]
    fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        match rule::uniform(mask) {
            Some(true) => if_true,
            Some(false) => if_false,
            None => {
                let value = R::select(mask, if_true.value, if_false.value);
                let generation = Self::common(if_true.generation, if_false);
                if generation == CONSTANT {
                    return Self::constant(value);
                }
                let (parents, zero) = ([if_true.index, if_false.index], R::zero());
                // SAFETY: the generation of a `Var<R>` belongs to a recording of `R`. `push_select` only moves numbers, so
                // it runs no code from outside `reverse`.
                #[allow(unsafe_code)]
                let index = unsafe {
                    current::with(generation, |arena| arena.push_select(mask, parents, zero))
                };
                Var {
                    value,
                    index,
                    generation,
                }
            }
        }
    }
    #[inline(always)]
    fn fma(self, factor: Self, term: Self) -> Self {
        let (value, one) = (self.value.fma(factor.value, term.value), R::one());
        if factor.is_constant() {
            return self.times_constant_plus(factor.value, term, value);
        }
        if self.is_constant() {
            return factor.times_constant_plus(self.value, term, value);
        }
        if term.is_constant() {
            return self.product(factor, value);
        }
        if self.is(factor) {
            return self.apply2(term, (value, [self.value + factor.value, one]));
        }
        let product = self.product(factor, value);
        product.apply2(term, (value, [one, one]))
    }
    /// At zero the slope is 0, by convention.
    #[inline]
    #[track_caller]
    fn abs(self) -> Self {
        let (value, partial) = rule::abs(self.value);
        self.times_constant(partial, value)
    }
    /// Records no entry: the result has the value of `self` and the entry of `soft`.
    #[inline]
    fn straight_through(self, soft: Self) -> Self {
        Var {
            value: self.value.straight_through(soft.value),
            ..soft
        }
    }
    #[inline]
    #[track_caller]
    fn chain(partial: Self, cotangent: Self) -> Self {
        if cotangent.is_zero() {
            return Self::zero();
        }
        let value = R::chain(partial.value, cotangent.value);
        if partial.is_constant() {
            return cotangent.times_constant(partial.value, value);
        }
        partial.apply2(cotangent, (value, [cotangent.value, partial.value]))
    }
    /// Records a single entry.
    fn dot<T: Copy>(a: &[Self], b: &[T]) -> Self
    where
        Self: Accepts<T>,
    {
        // A conversion may be code of another crate, and may record.
        let b: SmallVec<[Self; 8]> = b.iter().map(|&y| Self::accept(y)).collect();
        let value = R::dot(&fused::values(a), &fused::values(&b));
        let generation = Self::common_of(&b, Self::common_of(a, CONSTANT));
        // So may the test for zero of the number type.
        let factors = b.iter().chain(a);
        let stops: SmallVec<[bool; 16]> = factors
            .map(|factor| factor.is_constant() && is_choice(&factor.value))
            .collect();
        let term = |((x, factor), &stops): ((&Self, &Self), &bool)| Term {
            partial: factor.value,
            parent: x.index,
            stops,
        };
        let pairs = a.iter().zip(&b).chain(b.iter().zip(a));
        // SAFETY: the iterator only copies numbers.
        #[allow(unsafe_code)]
        unsafe {
            Self::push_linear(value, pairs.zip(&stops).map(term), generation)
        }
    }
    /// Records a single entry.
    fn sum_of(terms: &[Self]) -> Self {
        let (value, one) = (R::sum_of(&fused::values(terms)), R::one());
        let generation = Self::common_of(terms, CONSTANT);
        let term = |x: &Self| Term {
            partial: one,
            parent: x.index,
            stops: false,
        };
        // SAFETY: the iterator only copies numbers.
        #[allow(unsafe_code)]
        unsafe {
            Self::push_linear(value, terms.iter().map(term), generation)
        }
    }
    /// Records one entry for each output.
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        fused::fused(function, inputs)
    }
}

impl<R: Real> Var<R> {
    /// Records `self * factor + term` for a constant `factor`. `value` is the value of this expression.
    #[inline(always)]
    #[track_caller]
    fn times_constant_plus(self, factor: R, term: Self, value: R) -> Self {
        let one = R::one();
        if is_choice(&factor) {
            return self.stopped(value).apply2(term, (value, [one, one]));
        }
        self.apply2(term, (value, [factor, one]))
    }

    /// Computes `self / divisor`. If `self` is a constant zero, the divisor gets no derivative, as in a product, unless
    /// the quotient is NaN.
    #[inline(always)]
    #[track_caller]
    fn quotient(self, divisor: Self) -> Self {
        let (value, partials) = rule::div(self.value, divisor.value);
        if self.is_constant() && is_choice(&self.value) && rule::vanishes(value) {
            return divisor.stopped(value);
        }
        self.apply2(divisor, (value, partials))
    }
}

operators! {
    #[inline(always)]
    impl[R: Real] Var<R>:
    a + b => {
        // Adding a constant records nothing.
        let (value, one) = (a.value + b.value, R::one());
        if b.is_constant() {
            return a.moved_to(value);
        }
        if a.is_constant() {
            return b.moved_to(value);
        }
        a.apply2(b, (value, [one, one]))
    },
    a - b => {
        let (value, one) = (a.value - b.value, R::one());
        if b.is_constant() {
            return a.moved_to(value);
        }
        a.apply2(b, (value, [one, -one]))
    },
    a * b => a.product(b, a.value * b.value),
    a / b => a.quotient(b),
    -a => a.apply((-a.value, -R::one())),
    0 => Self::constant(R::zero()),
    1 => Self::constant(R::one()),
    a == 0 => a.is_constant() && a.value.is_zero(),
}

literal_operators! { [R: Real] Var<R> }

constants_by_f64! { [R: Real] Var<R> }
closure_operators! { [R: Real] Var<R> }
