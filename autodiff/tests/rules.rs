//! The rule of every elementary function: forward against reverse, finite differences and
//! num-dual, at benign and extreme arguments.

use crate::common::assert_gradient;
use autodiff::{Function, Real, gradient};
use num_dual::{Dual64, DualNum};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Unary {
    Exp,
    Sin,
    Cos,
    Tan,
    Tanh,
    Sqrt,
    Rsqrt,
    Recip,
    Ln,
    Abs,
    Cube,
    InverseSquare,
}

use Unary::*;

/// Functions that vary over a distance of at least 0.1, whatever the argument (tan at -30: 0.15
/// from its pole).
const BY_DISTANCE: [Unary; 5] = [Exp, Sin, Cos, Tan, Tanh];
/// Functions that vary over a distance of the order of the argument.
const BY_RATIO: [Unary; 7] = [Sqrt, Rsqrt, Recip, Ln, Abs, Cube, InverseSquare];

const ANGLES: [f64; 9] = [-30.0, -1.0, -1e-8, 0.0, 1e-300, 1e-3, 0.5, 3.0, 12.0];
const RATIOS: [f64; 9] = [1e-300, 1e-100, 1e-8, 0.3, 1.0, 7.5, 1e8, 1e90, 1e300];

/// Every function of one number, with arguments of its own.
fn unary() -> impl Iterator<Item = (Unary, f64)> {
    let pairs = |(functions, arguments): (&'static [Unary], [f64; 9])| {
        let of = move |&function: &Unary| arguments.map(|x| (function, x));
        functions.iter().flat_map(of)
    };
    [(&BY_DISTANCE[..], ANGLES), (&BY_RATIO[..], RATIOS)]
        .into_iter()
        .flat_map(pairs)
}

impl Function for Unary {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let x = x[0];
        match self {
            Exp => x.exp(),
            Sin => x.sin(),
            Cos => x.cos(),
            Tan => x.tan(),
            Tanh => x.tanh(),
            Sqrt => x.sqrt(),
            Rsqrt => x.rsqrt(),
            Recip => x.recip(),
            Ln => x.ln(),
            Abs => x.abs(),
            Cube => x.powi(3),
            InverseSquare => x.powi(-2),
        }
    }
}

impl Unary {
    fn of_num_dual(self, x: Dual64) -> Dual64 {
        match self {
            Exp => x.exp(),
            Sin => x.sin(),
            Cos => x.cos(),
            Tan => x.tan(),
            Tanh => x.tanh(),
            Sqrt => x.sqrt(),
            Rsqrt => x.sqrt().recip(),
            Recip => x.recip(),
            Ln => x.ln(),
            Abs => num_traits::Signed::abs(&x),
            Cube => x.powi(3),
            InverseSquare => x.powi(-2),
        }
    }
}

#[derive(Clone, Copy, Debug)]
enum Binary {
    Product,
    Quotient,
    Hypot,
    Atan2,
    Powf,
    MulAdd,
    Difference,
}

use Binary::*;

/// Every function of two numbers at all pairs of these.
fn binary(of: &[f64]) -> impl Iterator<Item = (Binary, [f64; 2])> {
    let all = [Product, Quotient, Hypot, Atan2, Powf, MulAdd, Difference];
    let pairs = of.iter().flat_map(|&a| of.iter().map(move |&b| [a, b]));
    pairs.flat_map(move |pair| all.map(|function| (function, pair)))
}

impl Function for Binary {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (a, b) = (x[0], x[1]);
        match self {
            Product => a * b,
            Quotient => a / b,
            Hypot => a.hypot(b),
            Atan2 => a.atan2(b),
            Powf => a.powf(b),
            MulAdd => a.fma(b, a),
            Difference => -(a - b),
        }
    }
}

/// A central difference by `x[i]` over a distance of about `cbrt(eps) size`, and its error.
fn difference(function: &impl Function, x: &[f64], i: usize, size: f64) -> (f64, f64) {
    let moved = |h: f64| {
        let mut x = x.to_vec();
        x[i] += h;
        (x[i], function.eval(&x))
    };
    let h = f64::EPSILON.cbrt() * size;
    let ((a, at_a), (b, at_b)) = (moved(-h), moved(h));
    let slope = (at_b - at_a) / (b - a);
    // Truncation: h^2 f''' / 6, where f''' size^2 is below 24 |f'| + |f| / size for all functions
    // here. Rounding: a few ulps of each value.
    let relative = f64::EPSILON.cbrt().powi(2);
    let size_of_value = at_a.abs().max(at_b.abs()) / size;
    let truncation = relative * (4.0 * slope.abs() + size_of_value);
    (
        slope,
        truncation + 4.0 * f64::EPSILON * size_of_value * (size / h),
    )
}

fn assert_close_to_difference(
    function: &(impl Function + std::fmt::Debug),
    x: &[f64],
    sizes: &[f64],
) {
    for (i, &by) in gradient(function, x).iter().enumerate() {
        let (slope, error) = difference(function, x, i, sizes[i]);
        if !slope.is_finite() || !error.is_finite() {
            continue; // Beyond the range of f64, where the modes are only held to one another.
        }
        assert!(
            (by - slope).abs() <= error,
            "{function:?} at {x:?}: {by:e} by {i}, differences {slope:e}"
        );
    }
}

#[test]
fn unary_functions_agree_with_differences() {
    for (function, x) in unary() {
        let size = if BY_RATIO.contains(&function) { x } else { 0.1 };
        assert_close_to_difference(&function, &[x], &[size]);
    }
}

#[test]
fn unary_functions_agree_with_num_dual() {
    for (function, x) in unary() {
        let other = function.of_num_dual(Dual64::from_re(x).derivative());
        let ours = gradient(&function, &[x])[0];
        if !other.eps.is_normal() || !ours.is_normal() {
            continue; // Over- or underflow on the way, at another place in each crate.
        }
        // Both compute the textbook partial in a handful of operations. tanh alone
        // cancels in 1 - tanh^2, where an ulp of 1 in each crate is the best to be had.
        let floor = if matches!(function, Tanh) {
            2.0 * f64::EPSILON
        } else {
            0.0
        };
        let error = (ours - other.eps).abs();
        let allowed = 8.0 * f64::EPSILON * ours.abs() + floor;
        assert!(
            error <= allowed,
            "{function:?} at {x}: {ours}, num-dual {}",
            other.eps
        );
    }
}

#[test]
fn binary_functions_agree_with_differences() {
    let benign = [0.3, 1.0, 2.5, 40.0];
    for (function, [a, b]) in binary(&benign) {
        // x^y varies by x over x / y, by y over 1 / ln x, at least over 0.01 here.
        let powf = matches!(function, Powf);
        let sizes = if powf { [0.01 * a, 0.1] } else { [a, b] };
        assert_close_to_difference(&function, &[a, b], &sizes);
    }
    // Squares of these leave the range of f64; angle, distance and their partials do not.
    for (y, x) in [
        (1e200, -2e200),
        (-1e-200, 3e-200),
        (1e-300, 1e300),
        (5e300, 1e-300),
    ] {
        // An angle varies over distances of the order of the radius.
        let radius = f64::max(f64::abs(x), f64::abs(y));
        assert_close_to_difference(&Atan2, &[y, x], &[radius, radius]);
        assert_close_to_difference(&Hypot, &[y, x], &[radius, radius]);
        // Five roundings.
        let (got, std) = (Hypot.eval(&[y, x]), f64::hypot(y, x));
        assert!(
            (got / std - 1.0).abs() < 5.0 * f64::EPSILON,
            "{got:e}, {std:e}"
        );
    }
}

#[test]
fn all_modes_agree_to_the_bit() {
    let far = [-1e300, -800.0, 800.0, 1e16].map(|x| BY_DISTANCE.map(|f| (f, x)));
    let ends = [f64::MIN_POSITIVE, 5e-324, f64::MAX].map(|x| BY_RATIO.map(|f| (f, x)));
    let further = far.into_iter().flatten().chain(ends.into_iter().flatten());
    for (function, x) in unary().chain(further) {
        assert_gradient(&function, &[x], &gradient(&function, &[x]));
    }
    for (function, at) in binary(&RATIOS) {
        assert_gradient(&function, &at, &gradient(&function, &at));
    }
}

#[test]
fn single_precision_follows_double() {
    for (function, x) in unary() {
        let x = x as f32;
        let single = gradient(&function, &[x])[0];
        let double = gradient(&function, &[f64::from(x)])[0];
        if !single.is_normal() || !(double as f32).is_normal() {
            continue; // Over- or underflow on the way.
        }
        // A handful of operations, and the cancellation of tanh as above.
        let eps = f64::from(f32::EPSILON);
        let floor = f64::from(u8::from(matches!(function, Tanh))) * 2.0 * eps;
        let error = (f64::from(single) - double).abs();
        let allowed = 16.0 * eps * double.abs() + floor;
        assert!(
            error <= allowed,
            "{function:?} at {x}: {single}, f64 {double}"
        );
    }
}
