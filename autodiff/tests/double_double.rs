//! Double-double arithmetic is compared with 60-digit values. It is also tested as the inner number type of every mode.

use crate::common::{
    Formula, differences, formula, forward_gradient, hessian_rows, largest_difference, rows,
};
use autodiff::{DoubleDouble, Function, Real, gradient};
use num_traits::FromPrimitive;

/// One line of a table.
struct Case {
    function: String,
    a: DoubleDouble,
    b: DoubleDouble,
    /// The exact value, as a sum of floats.
    value: [f64; 3],
}

fn cases() -> Vec<Case> {
    rows("double_double", case)
}

fn case(line: &str) -> Case {
    let mut words = line.split_whitespace();
    let function = words.next().expect("a name").to_owned();
    let numbers: Vec<f64> = words
        .take(7)
        .map(|word| word.parse().expect("a float"))
        .collect();
    let [a, a_low, b, b_low, ref value @ ..] = numbers[..] else {
        panic!("a line of too few numbers: {line}");
    };
    Case {
        function,
        a: DoubleDouble::new(a, a_low),
        b: DoubleDouble::new(b, b_low),
        value: value.try_into().expect("three floats"),
    }
}

impl Case {
    fn computed(&self) -> DoubleDouble {
        let (a, b) = (self.a, self.b);
        match self.function.as_str() {
            "add" => a + b,
            "mul" => a * b,
            "div" => a / b,
            "sqrt" => a.sqrt(),
            "exp" => a.exp(),
            "ln" => a.ln(),
            "sin" => a.sin(),
            "cos" => a.cos(),
            "tan" => a.tan(),
            "tanh" => a.tanh(),
            "atan2" => a.atan2(b),
            "powi" => a.powi(b.to_f64() as i32),
            "powf" => a.powf(b),
            "erf" => a.erf(),
            "erfc" => a.erfc(),
            "ln_gamma" => a.ln_gamma(),
            "digamma" => a.digamma(),
            "trigamma" => a.trigamma(),
            other => panic!("no function is called {other}"),
        }
    }

    fn relative_error(&self) -> f64 {
        let [high, low] = self.computed().parts();
        let value = self.value;
        // The first two differences are exact, because their operands agree in all but the last bits.
        ((high - value[0]) + (low - value[1]) - value[2]).abs() / value[0].abs()
    }

    /// Returns the error that the documentation of the module allows.
    fn allowed(&self) -> f64 {
        match self.function.as_str() {
            "add" | "mul" | "div" | "sqrt" => 1e-31,
            "powi" => 1e-31 * (1.0 + self.b.to_f64().abs()),
            "powf" => 1e-30 + 1e-31 * (self.b * self.a.ln()).to_f64().abs(),
            // Numbers up to 1 cancel.
            "erfc" => 1e-30 / self.value[0].clamp(0.01, 1.0) + 1e-31 * self.a.to_f64().powi(2),
            "ln_gamma" | "digamma" | "trigamma" => 1e-29,
            _ => 1e-30,
        }
    }
}

#[test]
fn relative_errors_are_as_documented() {
    let cases = cases();
    assert!(cases.len() >= 200, "{} cases are too few", cases.len());
    for case in &cases {
        let error = case.relative_error();
        let (function, [high, low]) = (&case.function, case.a.parts());
        assert!(
            error <= case.allowed(),
            "{function}({high:e} + {low:e}, {:?}): {error:e}",
            case.b
        );
    }
}

#[test]
fn infinities_zeros_and_nan_are_those_of_f64() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f64::INFINITY,
        f64::NEG_INFINITY,
        f64::NAN,
    ];
    let same = |wide: DoubleDouble, float: f64, what: &str| {
        let [high, low] = wide.parts();
        let equal = high == float || high.is_nan() && float.is_nan();
        // For a finite value, the second float must be smaller than the rounding error of the first. Otherwise it must
        // be zero.
        assert!(
            equal && (low == 0.0 || low.abs() <= high.abs() * f64::EPSILON),
            "{what}: {wide:?}, f64 {float}"
        );
    };
    for a in special {
        let x = DoubleDouble::from(a);
        let signs = (x.abs().to_f64().to_bits(), (-x).to_f64().to_bits());
        assert_eq!(signs, (a.abs().to_bits(), (-a).to_bits()));
        same(x.sqrt(), a.sqrt(), "sqrt");
        same(x.exp(), a.exp(), "exp");
        same(x.ln(), a.ln(), "ln");
        same(x.tanh(), Real::tanh(a), "tanh");
        if a.is_infinite() {
            assert_eq!(x.tanh().parts(), [a.signum(), 0.0]);
        }
        same(x.recip(), a.recip(), "recip");
        same(x.signum(), Real::signum(a), "signum");
        for b in special {
            let y = DoubleDouble::from(b);
            same(x + y, a + b, "sum");
            same(x * y, a * b, "product");
            same(x / y, a / b, "quotient");
            same(x.atan2(y), a.atan2(b), "atan2");
            assert_eq!(
                (x.less(y), x.less_equal(y), x.finite()),
                (a < b, a <= b, a.is_finite())
            );
            // For a negative base, `powf` gives NaN in double-double. In f64 it gives numbers for integer exponents.
            if a >= 0.0 {
                same(x.powf(y), a.powf(b), "powf");
            }
        }
    }
    assert!(DoubleDouble::from(1e300).sin().to_f64().is_nan());
    assert_eq!(
        DoubleDouble::from(800.0).exp().parts(),
        [f64::INFINITY, 0.0]
    );
    assert_eq!(DoubleDouble::from(-800.0).exp().parts(), [0.0, 0.0]);
}

/// A function of all elementary functions, with arguments at which no term dominates.
fn mixed() -> Formula {
    formula(3, |x| {
        let wave = (x[0] * x[1]).sin() + x[2].exp() / x[0].cos();
        wave * x[1].tanh() + x[2].powf(x[1]) + x[0].hypot(x[2]).ln() + x[0].atan2(x[2]).powi(3)
    })
}

fn wide(x: &[f64]) -> Vec<DoubleDouble> {
    x.iter().copied().map(DoubleDouble::from).collect()
}

#[test]
fn derivatives_are_as_precise_as_the_number_inside() {
    let (mixed, x) = (mixed(), [0.7, 1.3, 2.1]);
    let exact = gradient(|x| mixed.eval(x), &wide(&x));
    let forward = forward_gradient(&mixed, &wide(&x));
    // The tolerance is for about twenty operations with errors of 1e-31 to 1e-30 each, done in two different orders.
    assert!(largest_difference(&forward, &exact) < 1e-29);

    // The truncation error is h^2 / 6 times a third derivative of about 10; the rounding error is 1e-31 / h.
    for i in 0..3 {
        let slope = differences(|x| vec![mixed.eval(x)], &wide(&x), i, 1e-10)[0];
        assert!(
            (slope - exact[i]).to_f64().abs() < 1e-18,
            "{i}: {slope:?}, {:?}",
            exact[i]
        );
    }

    // The tolerance is for twenty operations in f64, 20 * 1e-16, times a condition number of order one.
    assert!(largest_difference(&wide(&gradient(|x| mixed.eval(x), &x)), &exact) < 1e-14);
    let slopes = |x: &[DoubleDouble]| gradient(|x| mixed.eval(x), x);
    let rows = (0..3).flat_map(|i| differences(slopes, &wide(&x), i, 1e-10));
    let rows: Vec<DoubleDouble> = rows.collect();
    assert!(largest_difference(&wide(&hessian_rows(&mixed, &x).concat()), &rows) < 1e-13);
}

#[test]
fn integers_become_wide_numbers_exactly() {
    let two_to_63 = 2.0_f64.powi(63);
    let parts = |number: Option<DoubleDouble>| number.expect("a number").parts();
    assert_eq!(
        parts(DoubleDouble::from_u64(u64::MAX)),
        [2.0 * two_to_63, -1.0]
    );
    assert_eq!(
        parts(DoubleDouble::from_i64(i64::MIN + 1)),
        [-two_to_63, 1.0]
    );
    assert_eq!(parts(DoubleDouble::from_f64(0.1)), [0.1, 0.0]);
}

#[test]
fn a_sum_keeps_what_is_small() {
    let small = DoubleDouble::from(2.0_f64.powi(-80));
    let sum: DoubleDouble = [DoubleDouble::from(1.0), small, DoubleDouble::from(-1.0)]
        .into_iter()
        .sum();
    assert_eq!(sum, small);
}

/// If the sum of two finite floats overflows, the number must be infinite.
#[test]
fn a_number_beyond_the_largest_is_infinite() {
    // This is a quarter of the distance between the two largest floats. Half of that distance would round up to
    // infinity.
    let quarter = DoubleDouble::from(2.0_f64.powi(969));
    let above_one = DoubleDouble::new(1.0, 2.0_f64.powi(-54));
    for sign in [1.0, -1.0].map(DoubleDouble::from) {
        let nearly = sign * (DoubleDouble::from(f64::MAX) + quarter);
        assert_eq!(nearly.to_f64(), sign.to_f64() * f64::MAX);
        for beyond in [nearly + sign * quarter, nearly * above_one] {
            assert_eq!(beyond.parts(), [sign.to_f64() * f64::INFINITY, 0.0]);
        }
    }
}
