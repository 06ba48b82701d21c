//! The functions of elements, differentiated as often as three times: in every mode, against
//! differences in 31 digits, where formulas that are good for values cancel.

use crate::common::{assert_gradient, gradients};
use autodiff::{DoubleDouble, Dual, Element, Function, Real, gradient, hessian};

/// A function by the name that num-traits or simba has for it.
#[derive(Clone, Copy, Debug)]
struct Named(&'static str);

/// Both traits have methods of the same names: this is the only place that sees simba's.
mod cardinal {
    use ::nalgebra::ComplexField;
    use autodiff::{Element, Real};

    pub(crate) fn sinc<R: Real>(x: Element<R>) -> Element<R> {
        x.sinc()
    }
    pub(crate) fn sinhc<R: Real>(x: Element<R>) -> Element<R> {
        x.sinhc()
    }
}

impl Function for Named {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        use num_traits::Float;
        let x = Element(x[0]);
        let y = match self.0 {
            "asin" => x.asin(),
            "acos" => x.acos(),
            "atan" => x.atan(),
            "sinh" => x.sinh(),
            "cosh" => x.cosh(),
            "asinh" => x.asinh(),
            "acosh" => x.acosh(),
            "atanh" => x.atanh(),
            "tanh" => x.tanh(),
            "exp_m1" => x.exp_m1(),
            "exp2" => x.exp2(),
            "ln_1p" => x.ln_1p(),
            "log2" => x.log2(),
            "log10" => x.log10(),
            "log" => x.log(Element::lit(3.0)),
            "cbrt" => x.cbrt(),
            "sinc" => cardinal::sinc(x),
            "sinhc" => cardinal::sinhc(x),
            name => unreachable!("no function {name}"),
        };
        y.0
    }
}

/// The derivative as a function, by forward or by reverse mode.
#[derive(Clone, Copy)]
struct Slope<F>(F);
struct Reverse<F>(F);

impl<F: Function> Function for Slope<F> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.0.eval(&[Dual::<R, 1>::variable(x[0], 0)]).tangent[0]
    }
}

impl<F: Function> Function for Reverse<F> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        gradient(&self.0, x)[0]
    }
}

/// A step of 1e-10: truncation leaves some 1e-20 of a fifth derivative, rounding 1e-31 / 1e-10.
fn difference(function: &impl Function, x: f64) -> f64 {
    let h = DoubleDouble::from(1e-10);
    let [above, below] = [h, -h].map(|h| function.eval(&[DoubleDouble::from(x) + h]));
    ((above - below) / (h + h)).to_f64()
}

#[track_caller]
fn assert_close(what: (Named, &str, f64), got: f64, expected: f64) {
    // Some dozens of roundings; what differences cannot see.
    let error = 2e-14 * expected.abs() + 1e-17;
    assert!(
        (got - expected).abs() <= error,
        "{what:?}: {got}, not {expected}"
    );
}

/// Where the functions have series, and further out.
const NEAR_ZERO: [f64; 9] = [0.0, 3.3e-16, -1e-14, 1e-10, -1e-8, 1e-5, -1e-3, 0.3, -0.7];
const EVERYWHERE: [f64; 6] = [0.999, -1.0, 1.7, -4.0, 9.0, -20.0];
/// Where those of positive numbers have them.
const POSITIVE: [f64; 7] = [1.001, 1.0625, 1.5, 2.0, 10.0, 123.0, 1e4];

/// Calls with every function at every point of its domain.
fn at_all_points(mut check: impl FnMut(Named, f64)) {
    let on_unit = ["asin", "acos", "atanh", "tanh", "ln_1p"].map(Named);
    let everywhere = [
        "atan", "sinh", "cosh", "asinh", "exp_m1", "exp2", "sinc", "sinhc",
    ];
    let everywhere = everywhere.map(Named);
    let positive = ["acosh", "log2", "log10", "log", "cbrt"].map(Named);
    let mut all = |functions: &[Named], points: &[f64]| {
        for &function in functions {
            points.iter().for_each(|&x| check(function, x));
        }
    };
    all(&on_unit, &NEAR_ZERO);
    all(&everywhere, &NEAR_ZERO);
    all(&everywhere, &EVERYWHERE);
    all(&positive, &POSITIVE);
}

#[test]
fn three_derivatives_keep_their_digits() {
    at_all_points(|f, x| {
        let (first, second) = (Slope(f), Slope(Slope(f)));
        let third = Slope(second);
        assert_close((f, "'", x), first.eval(&[x]), difference(&f, x));
        assert_close((f, "''", x), second.eval(&[x]), difference(&first, x));
        assert_close((f, "'''", x), third.eval(&[x]), difference(&second, x));
        let wide = second.eval(&[DoubleDouble::from(x)]).to_f64();
        assert_close((f, "'' in DoubleDouble", x), wide, difference(&first, x));
    });
}

#[test]
fn every_mode_has_the_same_second_derivative() {
    at_all_points(|f, x| {
        let expected = difference(&Slope(f), x);
        let modes = gradients(&Slope(f), &[x]).into_iter();
        for (mode, got) in modes.chain(gradients(&Reverse(f), &[x])) {
            assert_close((f, mode, x), got[0], expected);
        }
        assert_close((f, "hessian", x), hessian(&f, &[x])[0][0], expected);
    });
}

#[test]
fn large_arguments_have_a_derivative() {
    for x in [1e20, 1e150, 1e155, 1e300] {
        for name in ["asinh", "acosh"] {
            let slope = gradient(&Named(name), &[x])[0];
            // A handful of roundings.
            assert!((slope * x - 1.0).abs() < 1e-15, "{name}'({x}): {slope}");
        }
    }
    // (e^x / 2)' is itself, to the same bits.
    let sinh: f64 = Named("sinh").eval(&[710.0]);
    assert_gradient(&Named("sinh"), &[710.0], &[sinh]);
    assert_gradient(&Named("cosh"), &[-710.0], &[-sinh]);
}
