//! The number type on which a traced function runs.

use std::panic::Location;

use num_traits::Zero;

use super::origin::{CLEAN, Origin, count, name_callers, note, noted};
use crate::constant::printed;
use crate::dual::Dual;
use crate::operators::{closure_operators, literal_operators, operators};
use crate::real::{Accepts, Fused, Mask, Real};
use crate::rule::{self, by_rule};

/// A number that remembers its origin: the operation in which the number itself, or a partial that it depends on,
/// became infinite or NaN. Only the value is public; [`first_non_finite`](super::first_non_finite) reads the origin.
#[derive(Clone, Copy, Debug)]
pub struct Traced<R> {
    value: R,
    /// Whether the number depends on an argument of the function. Partials matter only for such numbers.
    active: bool,
    pub(super) origin: Origin,
}

impl<R: Real> Traced<R> {
    pub(super) fn variable(value: R, origin: Origin) -> Self {
        Self {
            value,
            active: true,
            origin,
        }
    }

    fn constant(value: R) -> Self {
        Self {
            value,
            active: false,
            origin: CLEAN,
        }
    }

    /// Returns the number without its origin.
    pub fn value(self) -> R {
        self.value
    }

    #[track_caller]
    fn apply(self, operation: &'static str, (value, partial): (R, R)) -> Self {
        Self::judged(operation, value, &[(self, partial)])
    }

    #[track_caller]
    fn apply2(self, operation: &'static str, other: Self, rule: (R, [R; 2])) -> Self {
        let (value, [by_self, by_other]) = rule;
        Self::judged(operation, value, &[(self, by_self), (other, by_other)])
    }

    /// Returns the result of an operation, given its operands and the partials with respect to them.
    #[track_caller]
    fn judged(operation: &'static str, value: R, operands: &[(Self, R)]) -> Self {
        count();
        let active = operands.iter().any(|(x, _)| x.active);
        let inherited = operands.iter().map(|(x, _)| x.origin).min();
        let origin = inherited.unwrap_or(CLEAN);
        let sound = |x: R| x.finite().all();
        let partials_sound = operands.iter().all(|&(x, by)| !x.active || sound(by));
        if origin != CLEAN || sound(value) && partials_sound {
            return Self {
                value,
                active,
                origin,
            };
        }
        let [of, partials] = [
            listed(operands.iter().map(|(x, _)| x.value)),
            listed(operands.iter().map(|&(_, partial)| partial)),
        ];
        let numbers = format!("of {of}: value {}, partial {partials}", printed(value));
        Self {
            value,
            active,
            origin: note(operation, Location::caller(), numbers),
        }
    }
}

fn clean<R>(numbers: &[Traced<R>]) -> bool {
    numbers.iter().all(|x| x.origin == CLEAN)
}

/// Marks the outputs of a fused function as depending on its inputs. `eval` may compute them without the inputs, as for
/// an implicit root or a custom rule.
fn depend<R: Real>(outputs: &mut [Traced<R>], inputs: &[&[Traced<R>]]) {
    let active = inputs.iter().copied().flatten().filter(|x| x.active);
    let Some(origin) = active.map(|x| x.origin).min() else {
        return;
    };
    for y in outputs.iter_mut().filter(|y| !y.active) {
        y.active = true;
        y.origin = y.origin.min(origin);
    }
}

/// Returns whether the values of a function and its derivatives with respect to the active inputs are finite. The
/// derivatives are computed in reverse and in forward mode, because in one of them a zero may hide an infinity.
fn soundly_differentiated<R: Real>(function: &impl Fused, inputs: &[&[Traced<R>]]) -> bool {
    let values = |slice: &&[Traced<R>]| slice.iter().map(|x| x.value).collect();
    let values: Vec<Vec<R>> = inputs.iter().map(values).collect();
    let values: Vec<&[R]> = values.iter().map(Vec::as_slice).collect();
    let moved = |x: &Traced<R>| match x.active {
        true => Dual::<R, 1>::variable(x.value, 0),
        false => Dual::constant(x.value),
    };
    let moved = inputs.iter().map(|slice| slice.iter().map(moved).collect());
    let moved: Vec<Vec<Dual<R, 1>>> = moved.collect();
    let moved: Vec<&[Dual<R, 1>]> = moved.iter().map(Vec::as_slice).collect();
    let tangents = function.forward(&moved).into_iter().map(|y| y.tangent[0]);
    let wanted = |slice: &&[Traced<R>]| slice.iter().any(|x| x.active);
    let wanted: Vec<bool> = inputs.iter().map(wanted).collect();
    let (y, mut saved) = function.record(&values);
    let x_bar = function.reverse(&mut saved, &vec![R::one(); y.len()], &wanted);
    let wanted_bars = x_bar.iter().zip(&wanted).filter(|(_, wanted)| **wanted);
    let cotangents = wanted_bars.flat_map(|(bars, _)| bars).copied();
    let mut numbers = cotangents.chain(y).chain(tangents);
    numbers.all(|x| x.finite().all())
}

fn listed<R: Real>(numbers: impl Iterator<Item = R>) -> String {
    let words: Vec<String> = numbers.map(printed).collect();
    words.join(" and ")
}

impl<R: Real> Real for Traced<R> {
    type Mask = R::Mask;

    by_rule! {
        #[inline]
        |x, operation, rule| x.apply(operation, rule),
        |x, y, operation, rule| x.apply2(operation, y, rule),
    }

    /// The result has the origin of the chosen operand.
    fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        match rule::uniform(mask) {
            Some(true) => if_true,
            Some(false) => if_false,
            None => Self {
                value: R::select(mask, if_true.value, if_false.value),
                active: if_true.active || if_false.active,
                origin: if_true.origin.min(if_false.origin),
            },
        }
    }
    #[track_caller]
    fn fma(self, factor: Self, term: Self) -> Self {
        let value = self.value.fma(factor.value, term.value);
        let operands = [(self, factor.value), (factor, self.value), (term, R::one())];
        Self::judged("multiply-add", value, &operands)
    }
    #[track_caller]
    fn abs(self) -> Self {
        self.apply("abs", rule::abs(self.value))
    }
    fn signum(self) -> Self {
        Self {
            value: self.value.signum().detach(),
            ..self.detach()
        }
    }
    /// Drops the partials and their origin. If the value itself is not finite, its origin is kept.
    fn detach(self) -> Self {
        let sound = self.value.finite().all();
        Self {
            value: self.value.detach(),
            active: false,
            origin: if sound { CLEAN } else { self.origin },
        }
    }
    fn straight_through(self, soft: Self) -> Self {
        Self {
            value: self.value.straight_through(soft.value),
            active: soft.active,
            origin: self.detach().origin.min(soft.origin),
        }
    }
    #[track_caller]
    fn chain(partial: Self, cotangent: Self) -> Self {
        if cotangent.is_zero() {
            return cotangent;
        }
        let value = R::chain(partial.value, cotangent.value);
        partial.apply2(
            "product",
            cotangent,
            (value, [cotangent.value, partial.value]),
        )
    }
    #[track_caller]
    fn dot<T: Copy>(a: &[Self], b: &[T]) -> Self
    where
        Self: Accepts<T>,
    {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        let mut sum = Self::zero();
        for (&x, &y) in a.iter().zip(b) {
            sum = x.fma(Self::accept(y), sum);
        }
        sum
    }
    #[track_caller]
    fn sum_of(terms: &[Self]) -> Self {
        let mut sum = Self::zero();
        for &term in terms {
            sum += term;
        }
        sum
    }
    /// Traces the operations inside `eval`, and also evaluates the function's own derivative. If that derivative is
    /// finite, no operation inside is reported. If it is not finite although all operations inside are, the whole
    /// function is reported.
    #[track_caller]
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        let before = noted();
        let mut outputs = function.eval(inputs);
        // Operations of this crate's own functions, such as a dense layer, are in the line of the call.
        name_callers(before, Location::caller(), F::SOURCES);
        depend(&mut outputs, inputs);
        if inputs.iter().any(|slice| !clean(slice)) {
            return outputs;
        }
        let sound = soundly_differentiated(&function, inputs);
        let blamed = if sound {
            CLEAN
        } else if clean(&outputs) {
            let numbers = "its derivative is not finite".into();
            note("fused function", Location::caller(), numbers)
        } else {
            return outputs;
        };
        outputs.iter_mut().for_each(|y| y.origin = blamed);
        outputs
    }
}

operators! {
    impl[R: Real] Traced<R>:
    a + b => a.apply2("sum", b, (a.value + b.value, [R::one(), R::one()])),
    a - b => a.apply2("difference", b, (a.value - b.value, [R::one(), -R::one()])),
    a * b => a.apply2("product", b, rule::mul(a.value, b.value)),
    a / b => a.apply2("quotient", b, rule::div(a.value, b.value)),
    -a => a.apply("negative", (-a.value, -R::one())),
    0 => Self::constant(R::zero()),
    1 => Self::constant(R::one()),
    a == 0 => !a.active && a.value.is_zero(),
}

literal_operators! { [R: Real] Traced<R> }
closure_operators! { [R: Real] Traced<R> }
