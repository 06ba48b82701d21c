//! The arithmetic of [`Dual`], the number of forward mode.

use crate::dual::Dual;
use crate::operators::{closure_operators, constants_by_f64, literal_operators, operators};
use crate::real::{Accepts, Fused, Mask, Real};
use crate::rule::{self, by_choice, by_rule};

impl<R: Real, const N: usize> Dual<R, N> {
    /// Makes a constant, whose tangents are all zero.
    #[inline(always)]
    pub fn constant(value: R) -> Self {
        Dual {
            value,
            tangent: [R::zero(); N],
        }
    }

    /// Makes a variable, whose tangent is 1 in direction `index` and 0 in all other directions.
    ///
    /// # Panics
    /// If `index` is not below `N`.
    #[inline(always)]
    #[track_caller]
    pub fn variable(value: R, index: usize) -> Self {
        assert!(
            index < N,
            "direction {index} is out of range: the dual has {N} directions"
        );
        let mut dual = Self::constant(value);
        dual.tangent[index] = R::one();
        dual
    }

    /// Returns the result of a function of this number, given the function's value and partial.
    #[inline(always)]
    fn apply(self, (value, partial): (R, R)) -> Self {
        let mut tangent = self.tangent;
        if is_finite(partial) {
            for i in 0..N {
                tangent[i] *= partial;
            }
        } else {
            for i in 0..N {
                tangent[i] = R::chain(partial, tangent[i]);
            }
        }
        Dual { value, tangent }
    }

    /// Returns the result of a function of this number and `other`, given the function's value and its two partials.
    #[inline(always)]
    fn apply2(self, other: Self, (value, partials): (R, [R; 2])) -> Self {
        // A sum is finite only if both of its terms are finite.
        let finite = is_finite(partials[0] + partials[1]);
        self.joined(other, (value, partials), finite)
    }

    /// Like [`apply2`](Self::apply2), but the caller says whether both partials are finite floats.
    #[inline(always)]
    fn joined(self, other: Self, (value, [by_self, by_other]): (R, [R; 2]), finite: bool) -> Self {
        let mut tangent = self.tangent;
        if finite {
            for i in 0..N {
                tangent[i] = by_self * tangent[i] + by_other * other.tangent[i];
            }
        } else {
            for i in 0..N {
                let by_self = R::chain(by_self, self.tangent[i]);
                tangent[i] = R::chain_add(by_other, other.tangent[i], by_self);
            }
        }
        Dual { value, tangent }
    }
}

/// Returns whether a partial is a finite float. The product of a finite partial and a tangent equals [`Real::chain`],
/// except for the sign of a zero. So one test is enough for all tangents. The result is false for lanes, because code
/// cannot branch on them. It is also false for numbers that carry derivatives, because these may be infinite even if
/// the primal is finite.
#[inline(always)]
fn is_finite<R: Real>(partial: R) -> bool {
    R::IS_FLOAT && partial.finite().all()
}

impl<R: Real, const N: usize> Real for Dual<R, N> {
    type Mask = R::Mask;

    by_rule! {
        #[inline(always)]
        |x, _, rule| x.apply(rule),
        |x, y, _, rule| x.apply2(y, rule),
    }
    by_choice! { #[inline(always)] }

    /// Multiplies by a constant, which takes only one product for each tangent.
    #[inline(always)]
    fn scale(self, factor: f64) -> Self {
        self.apply((self.value.scale(factor), R::lit(factor)))
    }
    #[inline(always)]
    fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        let mut tangent = if_true.tangent;
        for i in 0..N {
            tangent[i] = R::select(mask, if_true.tangent[i], if_false.tangent[i]);
        }
        Dual {
            value: R::select(mask, if_true.value, if_false.value),
            tangent,
        }
    }
    #[inline(always)]
    fn fma(self, factor: Self, term: Self) -> Self {
        let value = self.value.fma(factor.value, term.value);
        let mut tangent = term.tangent;
        // The value is finite only if both factors are finite.
        if is_finite(value) {
            for i in 0..N {
                let by_self = factor.value.fma(self.tangent[i], tangent[i]);
                tangent[i] = self.value.fma(factor.tangent[i], by_self);
            }
        } else {
            for i in 0..N {
                let by_self = R::chain_add(factor.value, self.tangent[i], tangent[i]);
                tangent[i] = R::chain_add(self.value, factor.tangent[i], by_self);
            }
        }
        Dual { value, tangent }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.apply(rule::abs(self.value))
    }
    #[inline(always)]
    fn straight_through(self, soft: Self) -> Self {
        Dual {
            value: self.value.straight_through(soft.value),
            tangent: soft.tangent,
        }
    }
    /// Applies the chain rule to the value and to each tangent of the cotangent separately. A part that is zero stays
    /// zero, even if another part is not zero.
    #[inline(always)]
    fn chain(partial: Self, cotangent: Self) -> Self {
        let mut tangent = cotangent.tangent;
        for i in 0..N {
            let by_partial = R::chain(partial.tangent[i], cotangent.value);
            tangent[i] = R::chain_add(partial.value, cotangent.tangent[i], by_partial);
        }
        Dual {
            value: R::chain(partial.value, cotangent.value),
            tangent,
        }
    }
    #[inline(always)]
    fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
        let mut tangent = term.tangent;
        for i in 0..N {
            let by_partial = R::chain_add(partial.tangent[i], cotangent.value, term.tangent[i]);
            tangent[i] = R::chain_add(partial.value, cotangent.tangent[i], by_partial);
        }
        Dual {
            value: R::chain_add(partial.value, cotangent.value, term.value),
            tangent,
        }
    }
    #[inline(always)]
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        function.forward(inputs)
    }
}

operators! {
    #[inline(always)]
    impl[R: Real, const N: usize] Dual<R, N>:
    a + b => {
        let (value, mut tangent) = (a.value + b.value, a.tangent);
        for i in 0..N {
            tangent[i] += b.tangent[i];
        }
        Dual { value, tangent }
    },
    a - b => {
        let (value, mut tangent) = (a.value - b.value, a.tangent);
        for i in 0..N {
            tangent[i] -= b.tangent[i];
        }
        Dual { value, tangent }
    },
    a * b => {
        let rule = rule::mul(a.value, b.value);
        // The partials are the two factors. If their product is finite, both are finite.
        a.joined(b, rule, is_finite(rule.0))
    },
    a / b => a.apply2(b, rule::div(a.value, b.value)),
    -a => {
        let mut tangent = a.tangent;
        for i in 0..N {
            tangent[i] = -tangent[i];
        }
        Dual { value: -a.value, tangent }
    },
    0 => Self::constant(R::zero()),
    1 => Self::constant(R::one()),
    a == 0 => a.value.is_zero() && a.tangent.iter().all(R::is_zero),
}

literal_operators! { [R: Real, const N: usize] Dual<R, N>, |a, factor| a.scale(factor) }
constants_by_f64! { [R: Real, const N: usize] Dual<R, N> }
closure_operators! { [R: Real, const N: usize] Dual<R, N> }

/// Converts numbers to duals. Number `k` gets the tangent 1 in direction `k`.
#[inline(always)]
pub fn seeded<R: Real, const I: usize>(x: [R; I]) -> [Dual<R, I>; I] {
    let mut seeded = [Dual::constant(R::zero()); I];
    // A closure might be compiled without the instruction set of the lanes.
    for i in 0..I {
        seeded[i] = Dual::variable(x[i], i);
    }
    seeded
}
