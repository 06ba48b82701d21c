//! Each row of the tables of conventions in `kinks.md` has a test, which runs in forward, reverse and nested modes.

use crate::common::{Sym, assert_gradient, assert_gradients, formula, second_derivatives};
use autodiff::simd::{Lane, Vectorized, kernel};
use autodiff::{Dual, Element, Function, Real, Tape, Var, gradient, hessian};
use num_traits::{Float, Zero};

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

#[test]
fn abs_is_flat_at_zero() {
    assert_gradients(
        |x| x[0].abs(),
        &[([0.0], [0.0]), ([-0.0], [0.0]), ([-2.0], [-1.0])],
    );
    assert_eq!(hessian(|x| x[0].abs(), &[0.0]), [[0.0]]);
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
        // `Real::signum` is written in full, because `x.signum()` would call `f64::signum`, which is 1 at 0.
        assert_eq!(Real::signum(x), sign, "at {x}");
        assert_gradients(|x| x[0].signum(), &[([x], [0.0])]);
    }
}

#[test]
fn a_bound_decides_at_a_tie_and_beyond() {
    assert_gradients(
        |x| x[0].max(x[1]),
        &[
            ([1.0, 1.0], [0.0, 1.0]),
            ([2.0, 1.0], [1.0, 0.0]),
            ([0.0, 1.0], [0.0, 1.0]),
        ],
    );
    assert_gradients(
        |x| x[0].min(x[1]),
        &[
            ([1.0, 1.0], [0.0, 1.0]),
            ([2.0, 1.0], [0.0, 1.0]),
            ([0.0, 1.0], [1.0, 0.0]),
        ],
    );
    assert_gradients(
        |x| x[0].clamp(x[1], x[2]),
        &[
            ([-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
            ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]),
            ([0.5, 0.0, 1.0], [1.0, 0.0, 0.0]),
            ([1.0, 0.0, 1.0], [0.0, 0.0, 1.0]),
            ([2.0, 0.0, 1.0], [0.0, 0.0, 1.0]),
        ],
    );
}

#[test]
fn select_passes_only_the_chosen_operand() {
    // The operand that is not chosen has an infinite partial at 0 and a partial of NaN below 0.
    assert_gradients(
        |x| {
            let (one, two) = (Sym::lit(1.0), Sym::lit(2.0));
            Sym::select(x[0].less(one), x[0] * two, x[0].sqrt().recip())
        },
        &[([0.0], [2.0]), ([-1.0], [2.0]), ([4.0], [-0.0625])],
    );
}

/// If all lanes choose the same operand, the result must be that operand itself. The tape must get no new entry.
#[test]
fn a_choice_of_all_lanes_is_not_recorded() {
    let mut tape = Tape::new();
    for (mask, chosen) in [(true, 3.0), (false, 4.0)] {
        let y = tape.record(&[3.0, 4.0], |x| Var::select(mask, x[0], x[1]));
        assert_eq!(y.value(), chosen);
        assert_eq!(tape.len(), 2, "only the inputs");
    }
}

/// Computes the gradient of `sqrt(max(x, 0))` at eight numbers, on a tape whose lanes hold one number each.
struct RootAbove<'a>(&'a [f64; 8]);

#[kernel]
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
fn an_infinite_cotangent_passes_only_the_chosen_side_of_each_lane() {
    let got = f64::vectorize(RootAbove(&[-2.0, -1.0, 0.0, 1.0, 4.0, 0.0, -3.0, 0.25]));
    // At 0 the maximum takes the derivative of the bound, which is 0 because the bound is a constant.
    assert_eq!(got, [0.0, 0.0, 0.0, 0.5, 0.25, 0.0, 0.0, 1.0]);
}

#[test]
fn infinite_slopes_are_infinite() {
    for zero in [0.0, -0.0] {
        assert_gradients(|x| x[0].sqrt(), &[([zero], [INF])]);
        assert_gradients(|x| x[0].ln(), &[([zero], [INF])]);
        assert_gradients(|x| x[0].recip(), &[([zero], [-INF])]);
        assert_gradients(|x| Sym::lit(1.0) / x[0], &[([zero], [-INF])]);
        // At -0 the value is minus infinity, but the slope is still the limit from inside the domain.
        assert_gradients(|x| x[0].rsqrt(), &[([zero], [-INF])]);
    }
}

#[test]
fn hypot_is_flat_at_the_origin_and_has_no_partial_by_an_infinite_argument() {
    let (three, four) = (f64::from_bits(3), f64::from_bits(4));
    assert_gradients(
        |x| x[0].hypot(x[1]),
        &[
            ([0.0, 0.0], [0.0, 0.0]),
            ([0.0, -2.0], [0.0, -1.0]),
            // The smallest numbers above 0 must not be mistaken for the origin.
            ([5e-324, 0.0], [1.0, 0.0]),
            ([three, -four], [0.6, -0.8]),
            ([INF, 1.0], [NAN, 0.0]),
            ([-2.0, -INF], [0.0, NAN]),
            ([INF, -INF], [NAN, NAN]),
        ],
    );
    let hypot = formula(2, |x| x[0].hypot(x[1]));
    let single = gradient(|x| hypot.eval(x), &[3, 4].map(f32::from_bits));
    assert_eq!(single, [0.6, 0.8]);
    for (x, y) in [(INF, 1.0), (-1.0, -INF), (INF, INF)] {
        assert_eq!(hypot.eval(&[x, y]), INF);
    }
}

#[test]
fn powers_take_the_limit_at_zero() {
    for x in [-2.0, 0.0, INF] {
        assert_gradients(|x| x[0].powi(0), &[([x], [0.0])]);
    }
    assert_gradients(|x| x[0].powi(1), &[([0.0], [1.0])]);
    assert_gradients(|x| x[0].powi(-1), &[([0.0], [-INF])]);
    // The exponent of the slope, one less than `i32::MIN`, is odd and does not fit into an i32.
    assert_gradients(|x| x[0].powi(i32::MIN), &[([-1.0], [2147483648.0])]);
    assert_gradients(
        |x| x[0].powf(x[1]),
        &[
            ([0.0, 2.0], [0.0, 0.0]),
            ([0.0, 1.0], [1.0, 0.0]),
            ([0.0, 0.5], [INF, 0.0]),
            ([0.0, 0.0], [0.0, 0.0]),
            ([0.0, -1.0], [-INF, 0.0]),
            // If the value is NaN, the partials must be NaN.
            ([0.0, NAN], [NAN, NAN]),
            ([NAN, 0.5], [NAN, NAN]),
            ([-1.0, 5e-324], [NAN, NAN]),
            ([-1.0, 0.5], [NAN, NAN]),
        ],
    );
}

#[test]
fn atan2_is_flat_at_the_origin_and_at_infinity() {
    assert_gradients(
        |x| x[0].atan2(x[1]),
        &[
            ([0.0, 0.0], [0.0, 0.0]),
            ([0.0, 2.0], [0.5, 0.0]),
            ([INF, 1.0], [0.0, 0.0]),
            ([1.0, INF], [0.0, 0.0]),
            ([-1.0, -INF], [0.0, 0.0]),
            ([INF, -INF], [0.0, 0.0]),
        ],
    );
}

#[test]
fn nan_is_passed_on() {
    for x in [-1.0, NAN] {
        let roots = [
            formula(1, |x| x[0].sqrt()),
            formula(1, |x| x[0].rsqrt()),
            formula(1, |x| x[0].ln()),
        ];
        for function in roots {
            assert!(function.eval(&[x]).is_nan());
            assert_gradient(&function, &[x], &[NAN]);
        }
    }
    for function in [formula(1, |x| x[0].abs()), formula(1, |x| x[0].recip())] {
        assert!(function.eval(&[NAN]).is_nan());
        assert_gradient(&function, &[NAN], &[NAN]);
    }
    for function in [
        formula(2, |x| x[0].hypot(x[1])),
        formula(2, |x| x[0].atan2(x[1])),
    ] {
        for other in [0.0, 1.0, INF] {
            for at in [[NAN, other], [other, NAN]] {
                assert!(function.eval(&at).is_nan());
                assert_gradient(&function, &at, &[NAN, NAN]);
            }
        }
    }
    for exponent in [-2, -1, 1, 2, 3] {
        assert_gradients(|x| x[0].powi(exponent), &[([NAN], [NAN])]);
    }
}

#[test]
fn bounds_pass_a_nan_on_and_a_nan_bound_is_ignored() {
    let [max, min] = [
        formula(2, |x| x[0].max(x[1])),
        formula(2, |x| x[0].min(x[1])),
    ];
    for bounded in [max, min] {
        assert!(bounded.eval(&[NAN, 1.0]).is_nan());
        assert_gradient(&bounded, &[NAN, 1.0], &[NAN, 0.0]);
        assert_gradient(&bounded, &[2.0, NAN], &[1.0, 0.0]);
    }
    assert_gradients(
        |x| x[0].clamp(x[1], x[2]),
        &[
            ([NAN, 0.0, 1.0], [NAN, 0.0, 0.0]),
            ([2.0, NAN, 3.0], [1.0, 0.0, 0.0]),
            ([2.0, 1.0, NAN], [1.0, 0.0, 0.0]),
        ],
    );
}

/// The slope of a linear function does not depend on the argument, so it must be right even at NaN.
#[test]
fn linear_functions_have_a_slope_at_nan() {
    let linear = formula(2, |x| {
        let sum = x[0] * Sym::lit(2.0) + Sym::lit(1.0) - x[1];
        Sym::select(x[1].less_equal(Sym::lit(1.0)), sum, Sym::lit(0.0))
    });
    assert!(linear.eval(&[NAN, 0.0]).is_nan());
    assert_gradient(&linear, &[NAN, 0.0], &[2.0, -1.0]);
}

/// Returns the value and the slope of `x.max(0)` at NaN, computed in lanes. The results are those of the first lane.
struct MaxOfNan;

#[kernel]
impl Vectorized<f64> for MaxOfNan {
    type Output = (usize, f64, f64);
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

/// Asserts that the second derivative with respect to the first argument at zero has this value in four nestings:
/// forward over forward, forward over reverse, reverse over forward, and reverse over reverse mode.
#[track_caller]
fn assert_seconds(function: impl FnOnce(&[Sym]) -> Sym, expected: f64) {
    let function = formula(2, |x| {
        let y = function(x);
        y * y
    });
    let found = second_derivatives(&function, &[0.0; 2]);
    let same = |(_, x): &(_, f64)| *x == expected || x.is_nan() && expected.is_nan();
    assert!(found.iter().all(same), "{found:?}, not {expected}");
}

#[test]
fn the_second_derivative_of_a_chosen_zero_is_zero() {
    assert_seconds(|x| x[0].abs(), 0.0);
    assert_seconds(|x| x[0].hypot(x[1]), 0.0);
    assert_seconds(|x| x[0].max(Sym::lit(0.0)), 0.0);
    assert_seconds(|x| x[0].min(Sym::lit(0.0)), 0.0);
}

/// A zero that was computed, times an infinite slope. What the table says to write instead has its second derivative.
#[test]
fn a_product_with_an_infinite_slope_has_a_second_derivative_as_one_function() {
    type Unary = fn(Sym) -> Sym;
    // By forward over reverse mode, and by the other nestings.
    let products: [(Unary, f64, f64); 9] = [
        (|x| x * x.sqrt(), NAN, NAN),
        (|x| x * x.ln(), NAN, NAN),
        (|x| x * x.powf(1.5), 0.0, NAN),
        (|x| x.powf(1.5) * x, 0.0, NAN),
        (|x| x.powf(1.5).fma(x, x), 0.0, NAN),
        (
            |x| Sym::dot(&[x, x], &[x.powf(1.5), Sym::lit(1.0)]),
            0.0,
            NAN,
        ),
        (|x| x.powf(1.5), INF, INF),
        (|x| x.xlogx(), INF, INF),
        (|x| x.powf(2.5), 0.0, 0.0),
    ];
    for (k, (function, by_hessian, otherwise)) in products.into_iter().enumerate() {
        let found = second_derivatives(&formula(1, |x| function(x[0])), &[0.0]);
        for (mode, found) in found {
            let expected = match mode {
                "forward over reverse" | "of the Hessian" => by_hessian,
                _ => otherwise,
            };
            let same = found == expected || found.is_nan() && expected.is_nan();
            assert!(same, "{k}, {mode}: {found}, not {expected}");
        }
    }
}

#[test]
fn an_infinite_slope_times_zero_has_no_second_derivative() {
    assert_seconds(|x| (x[0] * x[0]).sqrt(), f64::NAN);
    assert_seconds(|x| (x[0] * x[0] + x[1] * x[1]).sqrt(), f64::NAN);
    // If the smooth function is written without a kink, its second derivative is correct.
    let written = hessian(|x| x[0] * x[0] + x[1] * x[1], &[0.0; 2]);
    assert_eq!(written, [[2.0, 0.0], [0.0, 2.0]]);
}

/// The norm and the argument of a complex number, from which num-complex computes roots and logarithms.
struct Polar {
    norm: bool,
}

impl Function for Polar {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [re, im] = [0, 1].map(|k| Element(x[k]));
        match self.norm {
            true => Float::hypot(re, im).0,
            false => Float::atan2(im, re).0,
        }
    }
}

#[test]
fn the_norm_and_the_argument_of_an_element_have_no_slope_at_the_origin() {
    for norm in [true, false] {
        for x in [[0.0, 0.0], [-0.0, 0.0]] {
            assert_gradient(&Polar { norm }, &x, &[NAN, NAN]);
        }
    }
    assert_gradient(&Polar { norm: true }, &[0.0, -2.0], &[0.0, -1.0]);
    assert_gradient(&Polar { norm: false }, &[-2.0, 0.0], &[-0.0, -0.5]);
}
