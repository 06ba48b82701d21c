//! Every operation on every number type must have the same value as on floats.

use autodiff::trace::first_non_finite;
use autodiff::{DoubleDouble, Dual, Elementary, Mask, Real, Tape};
use num_traits::{One, Zero};

use crate::common::{Formula, Sym, Truth, formulas};

/// Returns each operation, with its name.
fn operations([x, y, z]: [Sym; 3]) -> Vec<(&'static str, Sym)> {
    let truth = |mask| Sym::select(mask, Sym::one(), Sym::zero());
    let inside = x.less(y) & !y.less_equal(z) | z.finite();
    let mut operations = vec![
        ("+", x + y),
        ("-", x - y),
        ("*", x * y),
        ("/", x / y),
        ("negative", -x),
        ("lit", Sym::lit(0.25)),
        ("less", truth(x.less(y))),
        ("less_equal", truth(x.less_equal(y))),
        ("finite", truth(x.finite())),
        ("splat", truth(Truth::splat(true))),
        ("masks", truth(inside)),
        ("select", Sym::select(inside, y, z)),
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
        ("chain", Sym::chain(x, y)),
        ("chain_add", Sym::chain_add(x, y, z)),
        ("dot", Sym::dot(&[x, y, z], &[z, x, y])),
        ("sum", Sym::sum_of(&[x, y, z])),
    ];
    let functions = Elementary::ALL.iter();
    operations.extend(functions.map(|&f| (f.name(), x.elementary(f))));
    operations
}

/// Returns points of both signs: at kinks, near kinks, and at infinity.
fn points() -> Vec<[f64; 3]> {
    let of = [-2.5, -1.0, -0.0, 0.0, 1e-3, 0.7, 3.0, f64::INFINITY];
    let third = |i: usize, k: usize| of[(3 * i + k) % of.len()];
    let points =
        (0..of.len()).flat_map(|i| (0..of.len()).map(move |k| [of[i], of[k], third(i, k)]));
    points.collect()
}

/// Asserts that the values of a number type agree with those of floats. `values` evaluates all operations at a point.
/// The tolerance is relative to the result and the arguments. If it is zero, the numbers must be equal.
fn check(tolerance: f64, values: impl Fn(&Formula, [f64; 3]) -> Vec<f64>) {
    let mut names = Vec::new();
    let all = formulas(3, |x| {
        let (of, results) = operations([x[0], x[1], x[2]]).into_iter().unzip();
        names = of;
        results
    });
    let mut sound = 0;
    for point in points() {
        let scale = point.iter().filter(|x| x.is_finite());
        let scale = 1.0 + scale.map(|x| x.abs()).sum::<f64>();
        let both = all.values(&point).into_iter().zip(values(&all, point));
        for (operation, (expected, value)) in names.iter().zip(both) {
            let same = value == expected || value.is_nan() && expected.is_nan();
            let close =
                (value - expected).abs() <= tolerance * (expected.abs() + scale).min(f64::MAX);
            assert!(
                same || close,
                "{operation} at {point:?}: {value}, not {expected}"
            );
            sound += usize::from(expected.is_finite());
        }
    }
    assert!(sound > 1800, "{sound}");
}

#[test]
fn duals_have_the_values_of_floats() {
    check(0.0, |all, point| {
        let moving = point.map(|x| Dual::<f64, 1>::variable(x, 0));
        all.values(&moving).iter().map(|y| y.value).collect()
    });
}

#[test]
fn tape_variables_have_the_values_of_floats() {
    check(0.0, |all, point| {
        let results = Tape::new().record(&point, |x| all.values(x));
        results.iter().map(|y| y.value()).collect()
    });
}

#[test]
fn traced_numbers_have_the_values_of_floats() {
    check(0.0, |all, point| {
        let mut seen = Vec::new();
        first_non_finite(
            |x| {
                seen = all.values(x).iter().map(|y| y.value()).collect();
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
    check(2e-15, |all, point| {
        let wide = all.values(&point.map(DoubleDouble::from));
        wide.into_iter().map(DoubleDouble::to_f64).collect()
    });
}

#[test]
fn single_precision_has_the_values_of_floats_to_its_digits() {
    // Functions such as tan(3) amplify the rounding error of the argument, 6e-8. The rounding errors of the function
    // itself are added.
    check(1e-6, |all, point| {
        let single = all.values(&point.map(|x| x as f32));
        single.into_iter().map(f64::from).collect()
    });
}
