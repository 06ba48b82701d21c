//! Tests that elementary functions have the same bits with and without the processor's fused multiply-add.

use super::power::{long_power, powi};
use super::primitive::{self, SIN_RANGE};
use super::scalar::{double, single};

/// Returns arguments of every binary exponent and both signs, with drawn digits, and special values.
fn arguments() -> impl Iterator<Item = f64> {
    let mut state = 1_u64;
    let drawn = (0..200_000_u64).map(move |k| {
        // Knuth's linear congruential generator.
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        f64::from_bits((k % 2) << 63 | (k % 2047) << 52 | state >> 12)
    });
    // Results become subnormal, zero or infinite there, or a function changes its formula.
    let edges = [
        0.35,
        0.5,
        0.78,
        1.57,
        10.0,
        20.0,
        87.0,
        88.722839,
        104.0,
        708.0,
        709.782712893384,
        745.2,
        1e4,
    ];
    let near = edges.into_iter().flat_map(|edge: f64| {
        (-40..40).flat_map(move |ulps| {
            let single = (edge as f32).to_bits().wrapping_add_signed(ulps);
            let double = edge.to_bits().wrapping_add_signed(ulps.into());
            [f64::from_bits(double), f32::from_bits(single).into()]
        })
    });
    let special = [0.0, 5e-324, f64::MIN_POSITIVE, f64::INFINITY, f64::NAN];
    let signed = near.chain(special).flat_map(|x| [x, -x]);
    drawn.chain(signed)
}

/// Asserts that two results of a function at `x` have the same bits or are both NaN.
macro_rules! assert_same {
    ($x:expr, $one:expr, $other:expr) => {
        let (one, other) = ($one, $other);
        let same = one.to_bits() == other.to_bits() || one.is_nan() && other.is_nan();
        assert!(
            same,
            "{} at {:e}: {one:e}, not {other:e}",
            stringify!($one),
            $x
        );
    };
}

/// If the processor has no fused multiply-add, the test compares functions with themselves.
#[test]
fn the_processors_multiply_add_keeps_all_bits() {
    macro_rules! compare {
        ($float:ident, $module:ident) => {
            for x in arguments().map(|x| x as $float) {
                assert_same!(x, $module::exp(x), primitive::exp(x));
                assert_same!(x, $module::tanh(x), primitive::tanh(x));
                if x.abs() <= SIN_RANGE as $float {
                    let (one, other) = ($module::small_sin_cos(x), primitive::sin_cos(x));
                    assert_same!(x, one.0, other.0);
                    assert_same!(x, one.1, other.1);
                }
            }
        };
    }
    compare!(f64, double);
    compare!(f32, single);
    for (k, x) in arguments().enumerate() {
        let exponent = [9, -9, 20, -33, 1000, -1001, i32::MAX, i32::MIN][k % 8];
        assert_same!(x, powi(x, exponent), long_power(x, exponent));
    }
}
