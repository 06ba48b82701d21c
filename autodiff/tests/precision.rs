//! Compares values, slopes and second derivatives in four modes with those of mpmath. The arguments range from the
//! smallest subnormal number to 1e300.

use autodiff::{Elementary, Function, Real, gradient};

use crate::common::{Formula, Sym, formula, forward_gradient, hessian_rows, rows};

/// The name of a function; how many ulps its value, slopes and second derivatives may be off at a point; and the
/// function.
type Row = (&'static str, fn(f64, f64) -> [f64; 3], fn(Sym, Sym) -> Sym);

/// Defines functions of `x` and `y`, which are the first and the last argument. The names are those in
/// `data/precision/generate.py`. An [`Elementary`] function is here only if it is less accurate than [`FEW`].
macro_rules! functions {
    (|$x:ident, $y:ident, $one:ident, $lit:ident| $($name:literal: $ulps:expr => $value:expr;)*) => {
        #[allow(unused_variables)]
        const FUNCTIONS: &[Row] = &[$(
            ($name, |$x, $y| $ulps, |$x, $y| {
                let ($one, $lit) = (Sym::lit(1.0), Sym::lit);
                $value
            }),
        )*];
    };
}

/// The tolerances in ulps for formulas with a few rounding errors.
const FEW: [f64; 3] = [2.0, 4.0, 8.0];

/// Returns the square of the ratio of the longer side to the shorter side. If a side is zero, nothing cancels, and the
/// result is 1.
fn squared_ratio(x: f64, y: f64) -> f64 {
    let ratio = (x / y).abs().max((y / x).abs());
    if ratio.is_finite() {
        ratio * ratio
    } else {
        1.0
    }
}

functions! {
    |x, y, one, lit|
    // Operators and methods. Each rule is a few operations with errors of at most an ulp.
    "neg": FEW => -x;
    "square": FEW => x * x;
    "cube": FEW => x * x * x;
    "recip": FEW => x.recip();
    "abs": FEW => x.abs();
    "fma": FEW => x.fma(x, lit(3.0));
    "sqrt": FEW => x.sqrt();
    "rsqrt": FEW => x.rsqrt();
    "exp": FEW => x.exp();
    "ln": FEW => x.ln();
    "sin": FEW => x.sin();
    "cos": FEW => x.cos();
    "tan": FEW => x.tan();
    "tanh": FEW => x.tanh();
    "atan": FEW => x.atan2(one);
    "clamp": FEW => x.clamp(lit(-2.0), lit(2.0));
    "powi_0": FEW => x.powi(0);
    "powi_1": FEW => x.powi(1);
    "powi_2": FEW => x.powi(2);
    "powi_3": FEW => x.powi(3);
    "powi_7": FEW => x.powi(7);
    "powi_100": FEW => x.powi(100);
    "powi_m1": FEW => x.powi(-1);
    "powi_m2": FEW => x.powi(-2);
    "powi_m7": FEW => x.powi(-7);
    "powi_m100": FEW => x.powi(-100);
    "powi_1000": FEW => x.powi(1000);
    "powi_m1000": FEW => x.powi(-1000);
    "powi_most": FEW => x.powi(i32::MAX);
    "powi_least": FEW => x.powi(i32::MIN);
    "powf_1.5": FEW => x.powf(lit(1.5));
    "powf_m2.5": FEW => x.powf(lit(-2.5));
    "two_to_x": FEW => lit(2.0).powf(x);
    "add": FEW => x + y;
    "sub": FEW => x - y;
    "mul": FEW => x * y;
    "div": FEW => x / y;
    "max": FEW => x.max(y);
    "min": FEW => x.min(y);
    "dot": FEW => Sym::dot(&[x, y], &[y, x]);
    "atan2": [2.0, 3.0, 8.0] => x.atan2(y);
    "hypot": [2.0, 3.0, 8.0] => x.hypot(y);
    // The second derivative is a power whose exponent is rounded, which costs `ln x` times that rounding. The same
    // holds for the slope where `0.3 / x` overflows.
    "powf_0.3": [2.0, 4.0 + f64::from(x < 1e-308) * x.ln().abs() / 2.0, 8.0 + x.ln().abs() / 2.0] =>
        x.powf(lit(0.3));
    "powf": [2.0, 4.0, 8.0 + x.ln().abs() / 2.0] => x.powf(y);
    "xlogy": FEW => x.xlogy(y);
    // Below 3 the second derivative is a difference of terms that are up to 20 times as large.
    "ln_erfc": [4.0, 4.0, 64.0] => x.ln_erfc();
    // Below 0 the value is a difference of logarithms, and near -2.457 it is close to zero.
    "ln_gamma": [2.0 + 16.0 * f64::from(x < 0.0), 4.0, 8.0] => x.ln_gamma();
    // Next to a zero, a few ulps remain of 31 digits.
    "digamma": [2.0 + 2.0 * f64::from(x < 0.0), 4.0, 8.0] => x.digamma();
    // A sum of up to seventeen terms.
    "trigamma": [4.0, 4.0, 8.0] => x.trigamma();
    // A sum of a dozen terms.
    "ln_beta": [16.0, 16.0, 64.0] => x.ln_beta(y);
    // In the second derivative, terms cancel that are as much larger as the square of the longer side.
    "norm": [2.0, 4.0, 8.0 + 2.0 * squared_ratio(x, y)] => Sym::norm(&[x, y]);
    "logsumexp": FEW => Sym::logsumexp(&[x, y]);
    "x_to_x": [2.0, 4.0, 8.0] => x.powf(x);
    "x_to_minus_x": [2.0, 4.0, 8.0] => x.powf(-x);
    // Formulas in which no terms cancel.
    "softplus_by_halves": FEW => Sym::select(
        x.less(lit(0.0)),
        x.exp().ln_1p(),
        x + (-x).exp().ln_1p(),
    );
    "x_exp_minus_x": FEW => x * (-x).exp();
    "rsqrt_1px2": FEW => (one + x * x).rsqrt();
    "x_abs_x": FEW => x * x.abs();
    "x_ln_x": FEW => x * x.ln();
    "entropy": FEW => -(x * x.ln()) - (one - x) * (-x).ln_1p();
    "logit": FEW => x.ln() - (-x).ln_1p();
    "versine": FEW => lit(2.0) * (x * lit(0.5)).sin().powi(2);
    "cosh_m1": FEW => lit(2.0) * (x * lit(0.5)).sinh().powi(2);
    "sin_squared": FEW => x.sin().powi(2);
    "sin_of_square": FEW => (x * x).sin();
    "exp_of_sin": FEW => x.sin().exp();
    "coth": FEW => x.tanh().recip();
    "sech": FEW => x.cosh().recip();
    "sec": FEW => x.cos().recip();
    "gudermann": FEW => lit(2.0) * (x * lit(0.5)).tanh().atan2(one);
    "root_difference": FEW => ((x + one).sqrt() + x.sqrt()).recip();
    "cbrt_squared": FEW => x.cbrt().powi(2);
    "horner": FEW => ((x + lit(2.0)) * x + lit(3.0)) * x + lit(4.0);
    "lennard_jones": FEW => x.powi(-12) - x.powi(-6);
    "morse": FEW => (one - x).exp_m1().powi(2);
    "gelu": FEW => x * lit(0.5) * (one + (lit(0.75) * (x + x.powi(3) / lit(32.0))).tanh());
    "ln_sum_exp": FEW => x.max(y) + (x.min(y) - x.max(y)).exp().ln_1p();
    "softmax": FEW => (one + (y - x).exp()).recip();
    "parallel": FEW => x * y / (x + y);
    "contrast": FEW => (x - y) / (x + y);
    "geometric": FEW => (x * y).sqrt();
    "decay": FEW => x * (-y).exp();
    "divergence": FEW => x * (x / y).ln();
    "wave": FEW => x.sin() * y.cos();
    "polar": FEW => x * y.cos();
    "quotient_of_logs": FEW => x.ln() / y.ln();
    "boltzmann": FEW => (-(x / y)).exp();
    "elastic": FEW => y * lit(0.5) * (x.hypot(one) - one).powi(2);
    "gaussian": FEW => (-(x * x)).exp();
    // `sin^2` and `cos^2` may nearly cancel.
    "sin_cos": [2.0, 8.0, 3.0] => x.sin() * x.cos();
    // The second derivative is a difference that vanishes with `x`.
    "logistic": [2.0, 3.0, 8.0 + 2.0 / x.abs()] => (one + (-x).exp()).recip();
    "fermi": [2.0, 3.0, 8.0 + 2.0 / x.abs()] => (one + x.exp()).recip();
    // The rounding of the exponent `1/x` is multiplied by `1/x`.
    "arrhenius": [4.0 + 0.5 / x, 4.0 + 0.5 / x, 8.0 + 0.5 / x] => (-x.recip()).exp();
    // Terms that are `x` or `x^2` times as large as the result cancel.
    "softsign": [2.0, 4.0 + x.abs(), 8.0 + 2.0 * x.abs()] => x / (one + x.abs());
    "rational": [2.0, 4.0 + x * x, 8.0 + 2.0 * x * x] => (x * x + one) / (x * x + lit(3.0));
    "sqrt_1px2": [2.0, 4.0, 8.0 + 4.0 * x * x] => (one + x * x).sqrt();
    "pseudo_huber": [2.0, 4.0, 8.0 + 4.0 * x * x] => x * x / (one + (one + x * x).sqrt());
    // Terms with `1/x` and `1/x^2` cancel if `x` is small.
    "tanhc": [3.0, 32.0, 96.0] => x.tanh() / x;
    "exp_m1_over_x": [3.0, 16.0, 256.0] => x.exp_m1() / x;
    // At some points the value is close to zero.
    "ln_of_ln": [16.0, 4.0, 8.0] => x.ln().ln();
    "ln_cosh": [16.0, 3.0, 4.0] =>
        x.abs() + (lit(-2.0) * x.abs()).exp().ln_1p() - lit(2.0).ln();
    "one_minus_cos": [16.0, 3.0, 4.0] => one - x.cos();
    // At some points the second derivative is close to zero.
    "silu": [2.0, 4.0, 32.0] => x / (one + (-x).exp());
    "maxwell": [2.0, 4.0, 32.0] => x * x * (-x).exp();
    "ln_1p_x2": [2.0, 4.0, 32.0] => (x * x).ln_1p();
    "lorentz": [2.0, 4.0, 32.0] => one / (one + x * x);
    "ln_1p_over_x": [2.0, 4.0, 32.0] => x.ln_1p() / x;
    "ln_squared": [2.0, 4.0, 32.0] => x.ln() * x.ln();
    "sqrt_ln": [2.0, 4.0, 32.0] => x.sqrt() * x.ln();
    "planck": [3.0, 4.0, 128.0] => x.powi(3) / x.exp_m1();
    "potential": [3.0, 4.0, 128.0] => (x * x + y * y).rsqrt();
    // At some points the slope or the second derivative is close to zero.
    "cosine_of_angle": [2.0, 4.0 + 2.0 * squared_ratio(x, y), 256.0] => x / x.hypot(y);
    "gravity": [4.0, 128.0, 64.0] => x / x.hypot(y).powi(3);
}

/// Cases that are known to be wrong. If one of them is fixed, the test asks to remove it from this list. The slope of a
/// quotient with respect to the divisor is `-(x/y)/y`. In the second derivative, the zero of `x/y` is multiplied by an
/// infinite `1/y`. A formula without that product would make every division slower.
const WRONG_TODAY: [(&str, &str); 1] = [("div", "0.0,1e-310 0.0,5e-324")];

struct Case {
    function: String,
    /// The arguments as text, as they are written in the table.
    at: String,
    x: Vec<f64>,
    /// The value, then the slopes, then the upper triangle of the second derivatives row by row.
    expected: Vec<f64>,
}

fn cases() -> Vec<Case> {
    rows("precision", case)
}

fn case(line: &str) -> Case {
    let words: Vec<&str> = line.split(' ').collect();
    // A line has 4 numbers for a function of one number, and 8 numbers for a function of two numbers.
    let (x, expected) = words[1..].split_at(words.len() / 4);
    let floats = |words: &[&str]| {
        words
            .iter()
            .map(|word| word.parse().expect("a float"))
            .collect()
    };
    Case {
        function: words[0].to_owned(),
        at: x.join(","),
        x: floats(x),
        expected: floats(expected),
    }
}

/// A function that computes the results of a line of the table in one mode.
type Mode = fn(&Formula, &[f64]) -> Vec<f64>;

/// The first two modes return the value and the slopes, by forward and by reverse mode. The last two also return second
/// derivatives, by forward over reverse and by reverse over reverse mode.
const MODES: [(&str, Mode); 4] = [
    ("forward", |f, x| {
        [vec![f.eval(x)], forward_gradient(f, x)].concat()
    }),
    ("reverse", |f, x| {
        [vec![f.eval(x)], gradient(|x| f.eval(x), x)].concat()
    }),
    ("forward over reverse", |f, x| {
        let rows = hessian_rows(f, x);
        with_triangle(f, x, |i| rows[i].clone())
    }),
    ("reverse over reverse", |f, x| {
        with_triangle(f, x, |i| gradient(|x| gradient(|x| f.eval(x), x)[i], x))
    }),
];

fn with_triangle(f: &Formula, x: &[f64], row: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
    let second = (0..x.len()).flat_map(|i| row(i).split_off(i));
    [f.eval(x)]
        .into_iter()
        .chain(gradient(|x| f.eval(x), x))
        .chain(second)
        .collect()
}

/// Returns the distance from the expected number, in units of its last place. An infinite number counts as the largest
/// float.
fn ulps(found: f64, expected: f64) -> f64 {
    let [found, expected] = [found, expected].map(|x| x.clamp(-f64::MAX, f64::MAX));
    let size = expected.abs().min(f64::MAX.next_down());
    ((found - expected) / (size.next_up() - size)).abs()
}

impl Case {
    /// Returns the function, and how many ulps its value, slopes and second derivatives may be off here.
    fn function(&self) -> (Formula, [f64; 3]) {
        let last = self.x.len() - 1;
        if let Some((_, allowed, function)) = FUNCTIONS.iter().find(|row| row.0 == self.function) {
            let f = formula(self.x.len(), |x| function(x[0], x[last]));
            return (f, allowed(self.x[0], self.x[last]));
        }
        let mut all = Elementary::ALL.iter();
        let function = all.find(|f| f.name() == self.function);
        let &function = function.expect("a function of the table");
        (formula(1, |x| x[0].elementary(function)), FEW)
    }

    /// Describes the results that are wrong in some mode, and by how many ulps.
    fn mistakes(&self) -> Vec<String> {
        let (arguments, (f, allowed)) = (self.x.len(), self.function());
        let mut mistakes = Vec::new();
        for (mode, of) in MODES {
            for (place, (found, &expected)) in
                of(&f, &self.x).into_iter().zip(&self.expected).enumerate()
            {
                let order = place.min(1) + usize::from(place > arguments);
                let error = ulps(found, expected);
                // A NaN is never close enough.
                let within = error <= allowed[order];
                if !within {
                    let allowed = allowed[order];
                    mistakes.push(format!(
                        "{}({}), {mode}, number {place}: {found:e}, expected {expected:e}: \
                         {error:.1e} ulps, not {allowed:.0}",
                        self.function, self.at
                    ));
                }
            }
        }
        mistakes
    }

    fn is_wrong_today(&self) -> bool {
        let mut listed = WRONG_TODAY
            .iter()
            .filter(|(function, _)| *function == self.function);
        listed.any(|(_, points)| points.split(' ').any(|at| at == self.at))
    }
}

#[test]
fn values_slopes_and_second_derivatives_are_within_their_ulps_in_four_modes() {
    let cases = cases();
    let named = FUNCTIONS.iter().map(|row| row.0);
    for name in named.chain(Elementary::ALL.iter().map(|f| f.name())) {
        assert!(
            cases.iter().any(|case| case.function == name),
            "no case of {name}: add a line to `data/precision/generate.py`"
        );
    }
    let mut wrong = Vec::new();
    for case in &cases {
        let mistakes = case.mistakes();
        if !case.is_wrong_today() {
            wrong.extend(mistakes);
        } else if mistakes.is_empty() {
            wrong.push(format!(
                "{}({}) is right now; remove it from WRONG_TODAY",
                case.function, case.at
            ));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} mistakes\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}
