//! Every operation on every number type must have the same value as on floats.

use std::ops::{AddAssign, DivAssign, MulAssign, SubAssign};

use autodiff::Elementary;
use autodiff::trace::{Traced, first_non_finite};
use autodiff::{DoubleDouble, Dual, Mask, Real, Tape, Var};

/// Applies an assigning operator and returns its result.
fn assigned<R: Copy>(x: R, y: R, operator: fn(&mut R, R)) -> R {
    let mut result = x;
    operator(&mut result, y);
    result
}

/// Returns the value of each elementary function, with its name.
fn elementary<R: Real>(x: R) -> Vec<(&'static str, R)> {
    [
        ("asin", Elementary::Asin),
        ("acos", Elementary::Acos),
        ("sinh", Elementary::Sinh),
        ("cosh", Elementary::Cosh),
        ("asinh", Elementary::Asinh),
        ("acosh", Elementary::Acosh),
        ("atanh", Elementary::Atanh),
        ("exp_m1", Elementary::ExpM1),
        ("ln_1p", Elementary::Ln1p),
        ("log2", Elementary::Log2),
        ("log10", Elementary::Log10),
        ("cbrt", Elementary::Cbrt),
    ]
    .map(|(name, function)| (name, x.elementary(function)))
    .into()
}

/// Returns the value of each operation, with its name.
fn operations<R: Real>([x, y, z]: [R; 3]) -> Vec<(&'static str, R)> {
    let truth = |mask: R::Mask| R::select(mask, R::one(), R::zero());
    let inside = x.less(y) & !y.less_equal(z) | z.finite();
    let methods = [
        ("+", x + y),
        ("-", x - y),
        ("*", x * y),
        ("/", x / y),
        ("negative", -x),
        ("+=", assigned(x, y, AddAssign::add_assign)),
        ("-=", assigned(x, y, SubAssign::sub_assign)),
        ("*=", assigned(x, y, MulAssign::mul_assign)),
        ("/=", assigned(x, y, DivAssign::div_assign)),
        ("lit", R::lit(0.25)),
        ("zero", R::zero()),
        ("one", R::one()),
        ("less", truth(x.less(y))),
        ("less_equal", truth(x.less_equal(y))),
        ("finite", truth(x.finite())),
        ("splat", truth(R::Mask::splat(true))),
        ("masks", truth(inside)),
        ("select", R::select(inside, y, z)),
        ("fma", x.fma(y, z)),
        ("recip", x.recip()),
        ("sqrt", x.sqrt()),
        ("rsqrt", x.rsqrt()),
        ("exp", x.exp()),
        ("ln", x.ln()),
        ("sin", x.sin()),
        ("cos", x.cos()),
        ("tan", x.tan()),
        ("tanh", x.tanh()),
        ("atan2", x.atan2(y)),
        ("powi", x.powi(3)),
        ("negative powi", x.powi(-2)),
        ("powf", x.abs().powf(y)),
        ("abs", x.abs()),
        ("signum", x.signum()),
        ("max", x.max(y)),
        ("min", x.min(y)),
        ("clamp", x.clamp(-z.abs(), z.abs())),
        ("hypot", x.hypot(y)),
        ("detach", x.detach()),
        ("straight_through", x.straight_through(y)),
        ("chain", R::chain(x, y)),
        ("chain_add", R::chain_add(x, y, z)),
        ("dot", R::dot(&[x, y, z], &[z, x, y])),
        ("sum", R::sum_of(&[x, y, z])),
    ];
    [&methods, &elementary(x)[..]].concat()
}

/// Returns points of both signs: at kinks, near kinks, and at infinity.
fn points() -> Vec<[f64; 3]> {
    let of = [-2.5, -1.0, -0.0, 0.0, 1e-3, 0.7, 3.0, f64::INFINITY];
    let third = |i: usize, k: usize| of[(3 * i + k) % of.len()];
    let points =
        (0..of.len()).flat_map(|i| (0..of.len()).map(move |k| [of[i], of[k], third(i, k)]));
    points.collect()
}

/// Asserts that the values of a number type agree with those of floats. The tolerance is relative to the result and the
/// arguments. If it is zero, the numbers must be equal.
fn check(name: &str, tolerance: f64, values: impl Fn([f64; 3]) -> Vec<f64>) {
    let mut sound = 0;
    for point in points() {
        let scale = point.iter().filter(|x| x.is_finite());
        let scale = 1.0 + scale.map(|x| x.abs()).sum::<f64>();
        for ((operation, expected), value) in operations(point).into_iter().zip(values(point)) {
            let same = value == expected || value.is_nan() && expected.is_nan();
            let close =
                (value - expected).abs() <= tolerance * (expected.abs() + scale).min(f64::MAX);
            assert!(
                same || close,
                "{name}: {operation} at {point:?}: {value}, not {expected}"
            );
            sound += usize::from(expected.is_finite());
        }
    }
    assert!(sound > 1800, "{name}: {sound}");
}

/// Returns the results of all operations on numbers of type `R`, as floats.
fn values<R: Real>(x: [R; 3], value: impl Fn(R) -> f64) -> Vec<f64> {
    let results = operations(x).into_iter();
    results.map(|(_, result)| value(result)).collect()
}

#[test]
fn duals_have_the_values_of_floats() {
    check("Dual", 0.0, |point| {
        values(point.map(|x| Dual::<f64, 1>::variable(x, 0)), |y| y.value)
    });
}

#[test]
fn tape_variables_have_the_values_of_floats() {
    check("Var", 0.0, |point| {
        Tape::new().record(&point, |x| values([x[0], x[1], x[2]], Var::value))
    });
}

#[test]
fn traced_numbers_have_the_values_of_floats() {
    check("Traced", 0.0, |point| {
        let mut seen = Vec::new();
        first_non_finite(
            |x| {
                seen = values([x[0], x[1], x[2]], Traced::value);
                x.to_vec()
            },
            &point,
        );
        seen
    });
}

#[test]
fn extended_numbers_round_to_the_values_of_floats() {
    // The tolerance is twice the error of the float's own function, which is 4 ulp for tanh.
    check("DoubleDouble", 2e-15, |point| {
        values(point.map(DoubleDouble::from), f64::from)
    });
}

#[test]
fn single_precision_has_the_values_of_floats_to_its_digits() {
    // Functions such as tan(3) amplify the rounding error of the argument, 6e-8. The rounding errors of the function
    // itself are added.
    check("f32", 1e-6, |point| {
        values(point.map(|x| x as f32), f64::from)
    });
}
