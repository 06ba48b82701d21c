//! One test per row of the table of conventions in `real.rs`, each in forward, reverse and nested
//! modes.

use crate::common::{assert_gradient, forward_gradient};
use autodiff::Elementary;
use autodiff::simd::{Lane, Vectorized};
use autodiff::{Dual, Function, Real, Tape, Var, gradient, hessian};
use num_traits::Zero;

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

enum Kink {
    Abs,
    Signum,
    Max,
    Min,
    Clamp,
    Select,
    Sqrt,
    Rsqrt,
    Ln,
    Recip,
    Divide,
    ZeroTimesSqrt,
    SqrtOfSquare,
    Hypot,
    Powi(i32),
    Powf,
    Atan2,
    Elementary(Elementary),
}

impl Function for Kink {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (one, two) = (R::one(), R::lit(2.0));
        match self {
            Kink::Abs => x[0].abs(),
            Kink::Signum => x[0].signum() * two,
            Kink::Max => x[0].max(x[1]),
            Kink::Min => x[0].min(x[1]),
            Kink::Clamp => x[0].clamp(x[1], x[2]),
            Kink::Select => R::select(x[0].less(one), two * x[0], x[0].sqrt().recip()),
            Kink::Sqrt => x[0].sqrt(),
            Kink::Rsqrt => x[0].rsqrt(),
            Kink::Ln => x[0].ln(),
            Kink::Recip => x[0].recip(),
            Kink::Divide => one / x[0],
            Kink::ZeroTimesSqrt => x[0].sqrt() * R::zero(),
            Kink::SqrtOfSquare => (x[0] * x[0]).sqrt(),
            Kink::Hypot => x[0].hypot(x[1]),
            Kink::Powi(exponent) => x[0].powi(*exponent),
            Kink::Powf => x[0].powf(x[1]),
            Kink::Atan2 => x[0].atan2(x[1]),
            Kink::Elementary(function) => x[0].elementary(*function),
        }
    }
}

#[test]
fn abs_is_flat_at_zero() {
    assert_gradient(&Kink::Abs, &[0.0], &[0.0]);
    assert_gradient(&Kink::Abs, &[-0.0], &[0.0]);
    assert_gradient(&Kink::Abs, &[-2.0], &[-1.0]);
    assert_eq!(hessian(&Kink::Abs, &[0.0]), [[0.0]]);
}

#[test]
fn signum_is_flat_and_zero_at_zero() {
    let signs: [(f64, f64); 6] = [
        (-INF, -1.0),
        (-3.0, -1.0),
        (-0.0, 0.0),
        (0.0, 0.0),
        (3.0, 1.0),
        (INF, 1.0),
    ];
    for (x, sign) in signs {
        // `f64::signum`, which is 1 at 0, hides the trait's method of the same name.
        assert_eq!(Real::signum(x), sign, "at {x}");
        assert_gradient(&Kink::Signum, &[x], &[0.0]);
    }
}

#[test]
fn max_at_a_tie_is_the_bound() {
    assert_gradient(&Kink::Max, &[1.0, 1.0], &[0.0, 1.0]);
    assert_gradient(&Kink::Max, &[2.0, 1.0], &[1.0, 0.0]);
    assert_gradient(&Kink::Max, &[0.0, 1.0], &[0.0, 1.0]);
}

#[test]
fn min_at_a_tie_is_the_bound() {
    assert_gradient(&Kink::Min, &[1.0, 1.0], &[0.0, 1.0]);
    assert_gradient(&Kink::Min, &[2.0, 1.0], &[0.0, 1.0]);
    assert_gradient(&Kink::Min, &[0.0, 1.0], &[1.0, 0.0]);
}

#[test]
fn clamp_at_and_beyond_a_bound_is_the_bound() {
    for x in [-1.0, 0.0] {
        assert_gradient(&Kink::Clamp, &[x, 0.0, 1.0], &[0.0, 1.0, 0.0]);
    }
    for x in [1.0, 2.0] {
        assert_gradient(&Kink::Clamp, &[x, 0.0, 1.0], &[0.0, 0.0, 1.0]);
    }
    assert_gradient(&Kink::Clamp, &[0.5, 0.0, 1.0], &[1.0, 0.0, 0.0]);
}

#[test]
fn select_passes_the_chosen_operand_alone() {
    // The other operand's partials are infinite at 0 and NaN below.
    assert_gradient(&Kink::Select, &[0.0], &[2.0]);
    assert_gradient(&Kink::Select, &[-1.0], &[2.0]);
    assert_gradient(&Kink::Select, &[4.0], &[-0.0625]);
}

/// Where all lanes choose alike, the choice is the operand itself.
#[test]
fn a_choice_of_all_lanes_is_not_recorded() {
    let mut tape = Tape::new();
    for (mask, chosen) in [(true, 3.0), (false, 4.0)] {
        let y = tape.record(&[3.0, 4.0], |x| Var::select(mask, x[0], x[1]));
        assert_eq!(y.value(), chosen);
        assert_eq!(tape.len(), 2, "the inputs and nothing else");
    }
}

/// The gradient of the root of what is above zero, a number a lane, on a tape of lanes.
struct RootAbove<'a>(&'a [f64; 8]);

impl Vectorized<f64> for RootAbove<'_> {
    type Output = Vec<f64>;
    fn run<L: Lane<f64>>(self) -> Vec<f64> {
        let gradient = |x: &[f64]| {
            let mut tape = Tape::new();
            let y = tape.record(&[L::load(x)], |x| x[0].max(Var::zero()).sqrt());
            let mut bar = vec![0.0; L::N];
            tape.pullback(&[y], &[L::one()])[0].store(&mut bar);
            bar
        };
        self.0.chunks_exact(L::N).flat_map(gradient).collect()
    }
}

#[test]
fn an_infinite_cotangent_passes_a_choice_of_lanes_on_one_side_alone() {
    let got = f64::vectorize(RootAbove(&[-2.0, -1.0, 0.0, 1.0, 4.0, 0.0, -3.0, 0.25]));
    // At zero the bound's own derivative counts, which is a constant's.
    assert_eq!(got, [0.0, 0.0, 0.0, 0.5, 0.25, 0.0, 0.0, 1.0]);
}

/// How many entries a tape of lanes has that chooses between constants, and the sum of its input's
/// cotangent.
struct ChoiceOfConstants;

impl Vectorized<f64> for ChoiceOfConstants {
    type Output = (usize, f64);
    fn run<L: Lane<f64>>(self) -> (usize, f64) {
        let x = L::load(&[-1.0, 1.0].repeat(8));
        let mut tape = Tape::new();
        let y = tape.record(&[x], |x| {
            Var::select(x[0].less(Var::zero()), Var::lit(2.0), Var::lit(3.0))
        });
        let mut bar = [0.0; 16];
        tape.pullback(&[y], &[L::one()])[0].store(&mut bar);
        (tape.len(), bar.iter().sum())
    }
}

#[test]
fn a_choice_of_constants_is_a_constant_where_lanes_disagree() {
    assert_eq!(
        f64::vectorize(ChoiceOfConstants),
        (1, 0.0),
        "the input alone"
    );
}

#[test]
fn infinite_slopes_are_infinite() {
    for zero in [0.0, -0.0] {
        assert_gradient(&Kink::Sqrt, &[zero], &[INF]);
        assert_gradient(&Kink::Ln, &[zero], &[INF]);
        assert_gradient(&Kink::Recip, &[zero], &[-INF]);
        assert_gradient(&Kink::Divide, &[zero], &[-INF]);
    }
    // The value is minus infinity at -0, the slope that from inside the domain all the same.
    assert_gradient(&Kink::Rsqrt, &[0.0], &[-INF]);
    assert_gradient(&Kink::Rsqrt, &[-0.0], &[-INF]);
}

#[test]
fn an_exact_zero_stops_at_an_infinite_partial() {
    let zero_times_infinity = |gradient: Vec<f64>| gradient[0].is_nan();
    // 0 sqrt(x): going back the zero comes first and stops; going forward the infinity does.
    assert_eq!(gradient(&Kink::ZeroTimesSqrt, &[0.0]), [0.0]);
    assert!(zero_times_infinity(forward_gradient(
        &Kink::ZeroTimesSqrt,
        &[0.0]
    )));
    // The factor is a constant, so its zero is a choice: `computed_zeros.rs` tests computed zeros.
    // sqrt(x x): the other way round.
    assert_eq!(forward_gradient(&Kink::SqrtOfSquare, &[0.0]), [0.0]);
    assert!(zero_times_infinity(gradient(&Kink::SqrtOfSquare, &[0.0])));
    // A zero tangent as such: x does not move at all.
    let still = Dual::<f64, 1>::constant(0.0).sqrt();
    assert_eq!(still.tangent, [0.0]);
}

#[test]
fn hypot_is_flat_at_the_origin() {
    assert_gradient(&Kink::Hypot, &[0.0, 0.0], &[0.0, 0.0]);
    assert_gradient(&Kink::Hypot, &[0.0, -2.0], &[0.0, -1.0]);
    // The smallest of all numbers are no origin.
    assert_gradient(&Kink::Hypot, &[5e-324, 0.0], &[1.0, 0.0]);
    let (three, four) = (f64::from_bits(3), f64::from_bits(4));
    assert_gradient(&Kink::Hypot, &[three, -four], &[0.6, -0.8]);
    let single = forward_gradient(&Kink::Hypot, &[3, 4].map(f32::from_bits));
    assert_eq!(single, [0.6, 0.8]);
    for (x, y) in [(INF, 1.0), (-1.0, -INF), (INF, INF)] {
        assert_eq!(Kink::Hypot.eval(&[x, y]), INF);
    }
}

#[test]
fn hypot_has_no_partial_by_an_infinite_argument() {
    assert_gradient(&Kink::Hypot, &[INF, 1.0], &[NAN, 0.0]);
    assert_gradient(&Kink::Hypot, &[-2.0, -INF], &[0.0, NAN]);
    assert_gradient(&Kink::Hypot, &[INF, -INF], &[NAN, NAN]);
}

#[test]
fn the_zeroth_power_is_flat() {
    for x in [-2.0, 0.0, INF] {
        assert_gradient(&Kink::Powi(0), &[x], &[0.0]);
    }
    assert_gradient(&Kink::Powi(1), &[0.0], &[1.0]);
    assert_gradient(&Kink::Powi(-1), &[0.0], &[-INF]);
    // An odd power is next, which is no i32.
    assert_gradient(&Kink::Powi(i32::MIN), &[-1.0], &[2147483648.0]);
}

#[test]
fn powf_at_zero_takes_the_limit() {
    for (y, by_x) in [(2.0, 0.0), (1.0, 1.0), (0.5, INF), (0.0, 0.0), (-1.0, -INF)] {
        assert_gradient(&Kink::Powf, &[0.0, y], &[by_x, 0.0]);
    }
}

#[test]
fn powf_without_a_value_has_no_partials() {
    for at in [[0.0, NAN], [NAN, 0.5], [-1.0, 5e-324], [-1.0, 0.5]] {
        assert_gradient(&Kink::Powf, &at, &[NAN, NAN]);
    }
}

#[test]
fn atan2_is_flat_at_the_origin() {
    assert_gradient(&Kink::Atan2, &[0.0, 0.0], &[0.0, 0.0]);
    assert_gradient(&Kink::Atan2, &[0.0, 2.0], &[0.5, 0.0]);
}

#[test]
fn atan2_is_flat_at_infinity() {
    for at in [[INF, 1.0], [1.0, INF], [-1.0, -INF], [INF, -INF]] {
        assert_gradient(&Kink::Atan2, &at, &[0.0, 0.0]);
    }
}

#[test]
fn at_the_end_of_a_domain_elementary_functions_take_the_limit() {
    let end = |function, x: f64, slope: f64| {
        assert_gradient(&Kink::Elementary(function), &[x], &[slope]);
    };
    for one in [-1.0, 1.0] {
        end(Elementary::Asin, one, INF);
        end(Elementary::Acos, one, -INF);
        end(Elementary::Atanh, one, INF);
    }
    end(Elementary::Ln1p, -1.0, INF);
    end(Elementary::Acosh, 1.0, INF);
    for zero in [0.0, -0.0] {
        end(Elementary::Log2, zero, INF);
        end(Elementary::Log10, zero, INF);
        end(Elementary::Cbrt, zero, INF);
    }
}

#[test]
fn outside_their_domain_elementary_functions_are_nan() {
    let outside = [
        (Elementary::Asin, vec![-1.5, 2.0]),
        (Elementary::Acos, vec![-1.5, 2.0]),
        (Elementary::Atanh, vec![-1.5, 2.0]),
        (Elementary::Ln1p, vec![-1.5, -1e300]),
        (
            Elementary::Acosh,
            vec![0.5, -0.5, -1.0, -1e8, -1e155, f64::MIN],
        ),
        (Elementary::Log2, vec![-1e-300, -8.0]),
        (Elementary::Log10, vec![-1e-300, -8.0]),
    ];
    for (function, points) in outside {
        for x in points {
            let kink = Kink::Elementary(function);
            assert!(kink.eval(&[x]).is_nan(), "{function:?} at {x}");
            assert_gradient(&kink, &[x], &[NAN]);
        }
    }
}

#[test]
fn nan_is_passed_on() {
    for function in [Kink::Sqrt, Kink::Rsqrt, Kink::Ln] {
        assert!(function.eval(&[-1.0_f64]).is_nan());
        assert_gradient(&function, &[-1.0], &[NAN]);
    }
    for function in [Kink::Abs, Kink::Recip, Kink::Sqrt, Kink::Ln] {
        assert!(function.eval(&[NAN]).is_nan());
        assert_gradient(&function, &[NAN], &[NAN]);
    }
    for function in [Kink::Max, Kink::Min, Kink::Hypot, Kink::Atan2] {
        assert!(function.eval(&[NAN, 1.0]).is_nan());
    }
    for function in [Kink::Hypot, Kink::Atan2] {
        for other in [0.0, 1.0, INF] {
            for at in [[NAN, other], [other, NAN]] {
                assert!(function.eval(&at).is_nan());
                assert_gradient(&function, &at, &[NAN, NAN]);
            }
        }
    }
    assert_gradient(&Kink::Max, &[NAN, 1.0], &[NAN, 0.0]);
    assert_gradient(&Kink::Min, &[NAN, 1.0], &[NAN, 0.0]);
    assert_gradient(&Kink::Clamp, &[NAN, 0.0, 1.0], &[NAN, 0.0, 0.0]);
    for exponent in [-2, -1, 1, 2, 3] {
        assert_gradient(&Kink::Powi(exponent), &[NAN], &[NAN]);
    }
}

/// Linear functions, whose slopes do not depend on the argument.
struct Linear(f64);

impl Function for Linear {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let sum = x[0] * R::lit(self.0) + R::one() - x[1];
        R::select(x[1].less_equal(R::one()), sum, R::zero())
    }
}

#[test]
fn linear_functions_have_a_slope_at_nan() {
    assert!(Linear(2.0).eval(&[NAN, 0.0]).is_nan());
    assert_gradient(&Linear(2.0), &[NAN, 0.0], &[2.0, -1.0]);
}

/// The value and the slope of `x.max(0)` at NaN, in the first lane.
struct MaxOfNan;

impl Vectorized<f64> for MaxOfNan {
    type Output = (usize, f64, f64);
    #[inline(always)]
    fn run<L: Lane<f64>>(self) -> Self::Output {
        let x = Dual::<L, 1>::variable(L::splat(NAN), 0);
        let y = x.max(Dual::lit(0.0));
        let [mut value, mut slope] = [[0.0; 16]; 2];
        y.value.store(&mut value);
        y.tangent[0].store(&mut slope);
        (L::N, value[0], slope[0])
    }
}

#[test]
fn lanes_pass_a_nan_but_not_its_slope_through_max() {
    let (lanes, value, slope) = f64::vectorize(MaxOfNan);
    assert!(value.is_nan());
    assert!(if lanes > 1 {
        slope == 1.0
    } else {
        slope.is_nan()
    });
}

#[test]
fn a_nan_bound_is_ignored() {
    assert_gradient(&Kink::Max, &[2.0, NAN], &[1.0, 0.0]);
    assert_gradient(&Kink::Min, &[2.0, NAN], &[1.0, 0.0]);
    assert_gradient(&Kink::Clamp, &[2.0, NAN, 3.0], &[1.0, 0.0, 0.0]);
    assert_gradient(&Kink::Clamp, &[2.0, 1.0, NAN], &[1.0, 0.0, 0.0]);
}
