//! The crate's own elementary functions against the system's.

use autodiff::Real;

/// The distance of a float from a reference, in units of the reference's last place.
fn ulps(a: f64, b: f64, epsilon: f64, least: f64) -> f64 {
    if a == b || (a.is_nan() && b.is_nan()) {
        return 0.0;
    }
    (a - b).abs() / (b.abs().max(least) * epsilon)
}

fn ulps_f64(a: f64, b: f64) -> f64 {
    ulps(a, b, f64::EPSILON, f64::MIN_POSITIVE)
}

fn ulps_f32(a: f32, b: f64) -> f64 {
    if a == b as f32 {
        return 0.0;
    }
    ulps(a.into(), b, f32::EPSILON.into(), f32::MIN_POSITIVE.into())
}

/// Arguments of all sizes and both signs, dense where the functions bend.
fn arguments(largest: f64) -> impl Iterator<Item = f64> {
    (0..40_000).flat_map(move |k| {
        let t = f64::from(k) / 40_000.0;
        let spread = largest * (t * 2.0 - 1.0) + 0.37e-3;
        let small = 1e-12_f64.powf(t) * if k % 2 == 0 { 1.0 } else { -1.0 };
        [spread, small]
    })
}

#[test]
fn errors_are_within_the_documented_ulps() {
    // The system's functions are themselves right to within 1 ulp: hence the added 1.
    for x in arguments(700.0) {
        assert!(ulps_f64(Real::exp(x), x.exp()) <= 3.0, "exp({x})");
    }
    for x in arguments(22.0) {
        assert!(ulps_f64(Real::tanh(x), x.tanh()) <= 5.0, "tanh({x})");
    }
    for x in arguments(2000.0) {
        // Near a zero of the function the reduction leaves an absolute error.
        let close = |a: f64, b: f64| ulps_f64(a, b) <= 3.0 || (a - b).abs() < 1e-19;
        assert!(close(Real::sin(x), x.sin()), "sin({x})");
        assert!(close(Real::cos(x), x.cos()), "cos({x})");
    }
    // Single precision is judged against double, which is exact to it.
    for x in arguments(80.0) {
        let single = x as f32;
        let double = f64::from(single);
        assert!(
            ulps_f32(Real::exp(single), double.exp()) <= 2.0,
            "exp f32 {x}"
        );
        assert!(
            ulps_f32(Real::tanh(single), double.tanh()) <= 4.0,
            "tanh f32 {x}"
        );
        // Near a zero the argument's reduction counts, whose error is absolute: a hundredth of an
        // f32's ulp at 1.
        let close = |a: f32, b: f64| ulps_f32(a, b) <= 2.0 || (f64::from(a) - b).abs() < 1e-9;
        assert!(close(Real::sin(single), double.sin()), "sin f32 {x}");
        assert!(close(Real::cos(single), double.cos()), "cos f32 {x}");
    }
}

#[test]
fn extremes_give_limits_and_nan_is_passed_on() {
    let inf = f64::INFINITY;
    assert_eq!(
        [inf, -inf, 1e300, -1e300].map(Real::exp),
        [inf, 0.0, inf, 0.0]
    );
    assert_eq!(
        [inf, -inf, 1e300, 0.0].map(Real::tanh),
        [1.0, -1.0, 1.0, 0.0]
    );
    assert!(Real::exp(709.78_f64) < inf && Real::exp(709.79_f64) == inf);
    assert!(Real::exp(-745.0_f64) > 0.0 && Real::exp(-746.0_f64) == 0.0);
    for f in [Real::exp, Real::tanh, Real::sin, Real::cos] as [fn(f64) -> f64; 4] {
        assert!(f(f64::NAN).is_nan());
    }
    assert!(Real::sin(inf).is_nan());
}
