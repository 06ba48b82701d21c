//! A zero that was computed does not hide an infinite partial on the tape; a zero that was chosen stops it.

use crate::common::{assert_gradient, forward_gradient, gradients};
use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::custom::{Rule, apply};
use autodiff::trace::first_non_finite;
use autodiff::{
    Elementary, Function, Kernel, Model, Program, Real, Rollout, Var, gradient, gradient_of,
    hessian, vjp_of,
};

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

enum Overflow {
    Resistors,
    Reciprocals,
    ExpOfLn,
    Atan,
    LnOfExp,
    Logistic,
    Cancelling,
    DotOfReciprocal,
}

impl Function for Overflow {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let one = R::one();
        match self {
            Self::Resistors => one / (one / x[0] + one / x[1]),
            Self::Reciprocals => x[0].recip().recip(),
            Self::ExpOfLn => x[0].ln().exp(),
            Self::Atan => (one / x[0]).atan(),
            Self::LnOfExp => (one + x[0].exp()).ln(),
            Self::Logistic => one / (one + (-x[0]).exp()),
            Self::Cancelling => x[0].sqrt() - x[0].sqrt(),
            Self::DotOfReciprocal => R::dot(&[x[0], x[1]], &[x[0], x[1]]).recip().recip(),
        }
    }
}

#[test]
fn an_intermediate_overflow_never_gives_a_wrong_zero() {
    let (zero, at) = ([0.0], |x: f64| [x]);
    assert_gradient(&Overflow::Resistors, &[0.0, 2.0], &[NAN, 0.0]);
    assert_gradient(&Overflow::Reciprocals, &zero, &[NAN]);
    assert_gradient(&Overflow::ExpOfLn, &zero, &[NAN]);
    assert_gradient(&Overflow::Atan, &zero, &[NAN]);
    assert_gradient(&Overflow::LnOfExp, &at(1000.0), &[NAN]);
    assert_gradient(&Overflow::Logistic, &at(-800.0), &[NAN]);
    assert_gradient(&Overflow::Cancelling, &zero, &[NAN]);
    // The zero slope of the square stops the infinity.
    assert_gradient(&Overflow::DotOfReciprocal, &[0.0, 0.0], &[0.0, 0.0]);
}

/// Squares of square roots, in which the zero comes first in forward mode: the operand has a tangent of 0.
enum Still {
    Square,
    Dot,
    Sum,
    SquarePlus,
}

impl Function for Still {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let root = match self {
            Self::Square => (x[0] * x[0]).sqrt(),
            Self::Dot => R::dot(x, x).sqrt(),
            Self::Sum => (x[0] * x[0] + x[1] * x[1]).sqrt(),
            Self::SquarePlus => (x[0] * x[0] + x[1]).sqrt(),
        };
        root * root
    }
}

#[test]
fn an_operand_that_does_not_move_has_a_slope_of_zero() {
    assert_gradient(&Still::Square, &[0.0], &[0.0]);
    assert_gradient(&Still::Dot, &[0.0, 0.0], &[0.0, 0.0]);
    assert_gradient(&Still::Sum, &[0.0, 0.0], &[0.0, 0.0]);
    // By the second argument the slope is 1, which cannot be computed from the root.
    assert_gradient(&Still::SquarePlus, &[0.0, 0.0], &[0.0, NAN]);
}

/// Choices whose side not taken has an infinite partial.
enum Choice {
    MaskTimes,
    TimesMask,
    MaskFma,
    MaskDot,
    MaskOver,
    MaskDeep,
    Signum,
    Abs,
    AbsOfSquare,
    Max,
    Min,
    Clamp,
    Select,
    Branch,
    ZerothPower,
    TimesZero,
}

impl Function for Choice {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (zero, one, root) = (R::zero(), R::one(), x[0].sqrt());
        let mask = R::select(x[0].less_equal(zero), zero, one);
        match self {
            Self::MaskTimes => mask * root,
            Self::TimesMask => root * mask,
            Self::MaskFma => root.fma(mask, one) + mask.fma(root, one),
            Self::MaskDot => R::dot(&[mask, one], &[root, one]),
            Self::MaskOver => mask / (one + root),
            Self::MaskDeep => (mask * root).exp() + (one - mask) * one,
            Self::Signum => x[0].signum() * root,
            Self::Abs => root.abs(),
            Self::AbsOfSquare => (root * root).abs() * root.abs(),
            Self::Max => (root - one).max(zero),
            Self::Min => (one - root).min(zero),
            Self::Clamp => root.clamp(one, R::lit(2.0)),
            Self::Select => R::select(x[0].less_equal(zero), one, root.recip()),
            Self::Branch => {
                if x[0].primal() > 0.0 {
                    root
                } else {
                    zero
                }
            }
            Self::ZerothPower => root.powi(0),
            Self::TimesZero => root * R::lit(0.0),
        }
    }
}

#[test]
fn a_chosen_zero_stops_an_infinite_partial() {
    let choices = [
        Choice::MaskTimes,
        Choice::TimesMask,
        Choice::MaskFma,
        Choice::MaskDot,
        Choice::MaskOver,
        Choice::MaskDeep,
        Choice::Signum,
        Choice::Abs,
        Choice::AbsOfSquare,
        Choice::Max,
        Choice::Min,
        Choice::Clamp,
        Choice::Select,
        Choice::Branch,
        Choice::ZerothPower,
        Choice::TimesZero,
    ];
    for (place, choice) in choices.into_iter().enumerate() {
        for (mode, gradient) in gradients(&choice, &[0.0]) {
            if mode.starts_with("reverse") {
                assert_eq!(gradient, [0.0], "choice {place}, {mode}");
            }
        }
    }
}

#[test]
fn a_cotangent_that_was_given_as_zero_stops() {
    let values = |x: &[Var<f64>]| vec![x[0].recip(), x[0]];
    assert_eq!(vjp_of(values, &[0.0], &[0.0, 1.0]).1, [1.0]);
}

/// A branch that is not taken does not change other components of the gradient.
#[test]
fn other_components_are_bit_identical() {
    let clean = |x: &[Var<f64>]| (x[1] * x[2]).sin() / x[2] + x[1].exp();
    let doubtful = |x: &[Var<f64>]| clean(x) + x[0].recip().recip();
    let (plain, found) = (
        gradient_of(clean, &[0.0, 0.3, 0.7]),
        gradient_of(doubtful, &[0.0, 0.3, 0.7]),
    );
    assert!(found[0].is_nan());
    assert_eq!(found[1..], plain[1..]);
}

#[derive(Clone, Copy)]
struct Reciprocal;

impl Rule for Reciprocal {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0].recip()
    }
    fn partials<R: Real>(&self, _: &[R], value: R) -> Vec<R> {
        vec![-(value * value)]
    }
}

impl Kernel<1, 1> for Reciprocal {
    #[inline(always)]
    fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [x.recip()]
    }
}

#[derive(Clone)]
struct Twice;

impl Model for Twice {
    fn record<R: Real>(&self, program: &mut Program<R>) {
        let x = program.state(1);
        let [once] = program.map(Reciprocal, [x]);
        let [twice] = program.map(Reciprocal, [once]);
        program.advance(x, twice);
    }
}

/// Functions for which a zero still hides an infinity in a reverse sweep over lanes or behind a
/// fused function.
enum Hidden {
    Rule,
    Rollout(Rollout<Twice>),
}

impl Function for Hidden {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        match self {
            Self::Rule => apply(Reciprocal, &[x[0].recip()]),
            Self::Rollout(rollout) => rollout.run(x, &[])[0],
        }
    }
}

#[test]
fn check_and_trace_find_an_infinity_that_a_zero_hides() {
    for hidden in [Hidden::Rule, Hidden::Rollout(Rollout::new(Twice, 1))] {
        assert_eq!(gradient(&hidden, &[0.0]), [0.0]);
        let report = check_gradient(&hidden, &[0.0], &Options::default());
        assert_eq!(report.verdict, Verdict::Wrong, "{report}");
        let found = first_non_finite(&[0.0], |x| vec![hidden.eval(x)]).expect("1 / 0");
        assert_eq!(found.operation, "recip", "{found}");
    }
}

/// Every function of one number, composed with every other.
struct Chained(usize, usize);

const FUNCTIONS: usize = 30;

fn function<R: Real>(number: usize, x: R) -> R {
    let one = R::one();
    match number {
        0 => x.recip(),
        1 => one / x,
        2 => x.sqrt(),
        3 => x.rsqrt(),
        4 => x.exp(),
        5 => x.ln(),
        6 => x.sin(),
        7 => x.cos(),
        8 => x.tan(),
        9 => x.tanh(),
        10 => x.atan(),
        11 => x.powi(1),
        12 => x.powi(2),
        13 => x.powi(-3),
        14 => x.powf(R::lit(1.5)),
        15 => R::lit(2.0).powf(x),
        16 => x.elementary(Elementary::Asin),
        17 => x.elementary(Elementary::Acos),
        18 => x.elementary(Elementary::Sinh),
        19 => x.elementary(Elementary::Cosh),
        20 => x.elementary(Elementary::Asinh),
        21 => x.elementary(Elementary::Acosh),
        22 => x.elementary(Elementary::Atanh),
        23 => x.elementary(Elementary::ExpM1),
        24 => x.elementary(Elementary::Ln1p),
        25 => x.elementary(Elementary::Log2),
        26 => x.elementary(Elementary::Cbrt),
        27 => x.elementary(Elementary::Sigmoid),
        28 => x.elementary(Elementary::Softplus),
        _ => x.hypot(x * x),
    }
}

impl Function for Chained {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        function(self.0, function(self.1, x[0]))
    }
}

/// Forward mode is the reference: where it gives NaN, no other mode gives a number; elsewhere the
/// modes agree.
#[test]
fn no_mode_gives_a_number_where_forward_mode_gives_nan() {
    let points = [
        0.0, -0.0, 1.0, -1.0, 0.3, 2.0, 1000.0, -1000.0, 1e200, -1e200, 1e-200, 5e-324, INF, -INF,
        NAN,
    ];
    for (outer, inner) in (0..FUNCTIONS * FUNCTIONS).map(|k| (k / FUNCTIONS, k % FUNCTIONS)) {
        for x in points {
            let chained = Chained(outer, inner);
            let forward = forward_gradient(&chained, &[x])[0];
            for (mode, gradient) in gradients(&chained, &[x]) {
                let slope = gradient[0];
                // The partials are equal but are multiplied in another order.
                let close = (slope - forward).abs() <= 4.0 * f64::EPSILON * forward.abs();
                let same = slope == forward || close || slope.is_nan();
                let same = if forward.is_nan() {
                    slope.is_nan()
                } else {
                    same
                };
                assert!(
                    same,
                    "{outer} of {inner} at {x}: {slope} {mode}, {forward} forward"
                );
            }
        }
    }
}

#[test]
fn a_computed_zero_has_no_second_derivative_either() {
    assert!(hessian(&Overflow::Reciprocals, &[0.0_f64])[0][0].is_nan());
    assert!(hessian(&Still::Square, &[0.0_f64])[0][0].is_nan());
}
