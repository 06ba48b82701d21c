//! Values, slopes and second derivatives against mpmath, from the smallest subnormal to 1e300, in four
//! modes.

use std::path::Path;

use autodiff::{Elementary, Function, Real, gradient, gradient_of, hessian};

use crate::common::forward_gradient;

/// A function of the table below, by its name.
#[derive(Clone, Copy)]
struct Named<'a>(&'a str);

/// The functions: a name, how many ulps its value may be off, and the formula. A slope may be off by twice
/// as many, a second derivative by four times: each derivative doubles the operations or nearly. The
/// names are those of `data/precision/generate.py`.
macro_rules! functions {
    (|$x:ident, $y:ident| $($name:literal: $ulps:expr => $value:expr;)*) => {
        const NAMES: &[&str] = &[$($name),*];

        impl Named<'_> {
            fn ulps(self, [$x, $y]: [f64; 2]) -> f64 {
                match self.0 {
                    $($name => $ulps,)*
                    other => panic!("no function is called {other}"),
                }
            }
        }

        impl Function for Named<'_> {
            fn eval<R: Real>(&self, x: &[R]) -> R {
                let ($x, $y, lit, one) = (x[0], x[x.len() - 1], R::lit, R::one());
                match self.0 {
                    $($name => $value,)*
                    other => panic!("no function is called {other}"),
                }
            }
        }
    };
}

functions! {
    |x, y|
    "neg": 2.0 => -x;
    "square": 2.0 => x * x;
    "cube": 2.0 => x * x * x;
    "recip": 2.0 => x.recip();
    "abs": 2.0 => x.abs();
    "fma": 2.0 => x.fma(x, lit(3.0));
    "sqrt": 2.0 => x.sqrt();
    "rsqrt": 2.0 => x.rsqrt();
    "exp": 2.0 => x.exp();
    "ln": 2.0 => x.ln();
    "sin": 2.0 => x.sin();
    "cos": 2.0 => x.cos();
    "tan": 2.0 => x.tan();
    "tanh": 2.0 => x.tanh();
    "atan": 2.0 => x.atan2(one);
    "clamp": 2.0 => x.clamp(lit(-2.0), lit(2.0));
    "powi_0": 2.0 => x.powi(0);
    "powi_1": 2.0 => x.powi(1);
    "powi_2": 2.0 => x.powi(2);
    "powi_3": 2.0 => x.powi(3);
    "powi_7": 2.0 => x.powi(7);
    "powi_100": 2.0 => x.powi(100);
    "powi_m1": 2.0 => x.powi(-1);
    "powi_m2": 2.0 => x.powi(-2);
    "powi_m7": 2.0 => x.powi(-7);
    "powi_m100": 2.0 => x.powi(-100);
    "powi_1000": 2.0 => x.powi(1000);
    "powi_m1000": 2.0 => x.powi(-1000);
    "powi_most": 2.0 => x.powi(i32::MAX);
    "powi_least": 2.0 => x.powi(i32::MIN);
    "powf_0.3": 2.0 => x.powf(lit(0.3));
    "powf_1.5": 2.0 => x.powf(lit(1.5));
    "powf_m2.5": 2.0 => x.powf(lit(-2.5));
    "two_to_x": 2.0 => lit(2.0).powf(x);
    "x_to_x": 2.0 => x.powf(x);
    "asin": 2.0 => x.elementary(Elementary::Asin);
    "acos": 2.0 => x.elementary(Elementary::Acos);
    "sinh": 2.0 => x.elementary(Elementary::Sinh);
    "cosh": 2.0 => x.elementary(Elementary::Cosh);
    "asinh": 2.0 => x.elementary(Elementary::Asinh);
    "acosh": 2.0 => x.elementary(Elementary::Acosh);
    "atanh": 2.0 => x.elementary(Elementary::Atanh);
    "exp_m1": 2.0 => x.elementary(Elementary::ExpM1);
    "ln_1p": 2.0 => x.elementary(Elementary::Ln1p);
    "log2": 2.0 => x.elementary(Elementary::Log2);
    "log10": 2.0 => x.elementary(Elementary::Log10);
    "cbrt": 2.0 => x.elementary(Elementary::Cbrt);
    "sigmoid": 2.0 => (one + (-x).exp()).recip();
    "softplus": 2.0 => x.exp().elementary(Elementary::Ln1p);
    "add": 2.0 => x + y;
    "sub": 2.0 => x - y;
    "mul": 2.0 => x * y;
    "div": 2.0 => x / y;
    "max": 2.0 => x.max(y);
    "min": 2.0 => x.min(y);
    "dot": 2.0 => R::dot(&[x, y], &[y, x]);
    "atan2": 2.0 => x.atan2(y);
    "hypot": 2.0 => x.hypot(y);
    "powf": 2.0 => x.powf(y);
    "logistic": 2.0 => (one + (-x).exp()).recip();
    "log_sigmoid": 2.0 => -(-x).exp().elementary(Elementary::Ln1p);
    "softplus_by_halves": 2.0 => R::select(x.lt(R::zero()), x.exp().elementary(Elementary::Ln1p), x + (-x).exp().elementary(Elementary::Ln1p));
    "silu": 2.0 => x / (one + (-x).exp());
    "fermi": 2.0 => (one + x.exp()).recip();
    "ln_cosh": 2.0 => x.abs() + (lit(-2.0) * x.abs()).exp().elementary(Elementary::Ln1p) - lit(2.0).ln();
    "gaussian": 2.0 => (-(x * x)).exp();
    "maxwell": 2.0 => x * x * (-x).exp();
    "x_exp_minus_x": 2.0 => x * (-x).exp();
    "arrhenius": 2.0 => (-x.recip()).exp();
    "pseudo_huber": 2.0 => x * x / (one + (one + x * x).sqrt());
    "sqrt_1px2": 2.0 => (one + x * x).sqrt();
    "rsqrt_1px2": 2.0 => (one + x * x).rsqrt();
    "ln_1p_x2": 2.0 => (x * x).elementary(Elementary::Ln1p);
    "lorentz": 2.0 => one / (one + x * x);
    "softsign": 2.0 => x / (one + x.abs());
    "x_abs_x": 2.0 => x * x.abs();
    "sinc": 2.0 => x.sin() / x;
    "tanhc": 2.0 => x.tanh() / x;
    "exp_m1_over_x": 2.0 => x.elementary(Elementary::ExpM1) / x;
    "ln_1p_over_x": 2.0 => x.elementary(Elementary::Ln1p) / x;
    "x_ln_x": 2.0 => x * x.ln();
    "ln_squared": 2.0 => x.ln() * x.ln();
    "entropy": 2.0 => -(x * x.ln()) - (one - x) * (-x).elementary(Elementary::Ln1p);
    "logit": 2.0 => x.ln() - (-x).elementary(Elementary::Ln1p);
    "versine": 2.0 => lit(2.0) * (x * lit(0.5)).sin().powi(2);
    "one_minus_cos": 2.0 => one - x.cos();
    "cosh_m1": 2.0 => lit(2.0) * (x * lit(0.5)).elementary(Elementary::Sinh).powi(2);
    "sin_cos": 2.0 => x.sin() * x.cos();
    "sin_squared": 2.0 => x.sin().powi(2);
    "sin_of_square": 2.0 => (x * x).sin();
    "exp_of_sin": 2.0 => x.sin().exp();
    "coth": 2.0 => x.tanh().recip();
    "sech": 2.0 => x.elementary(Elementary::Cosh).recip();
    "sec": 2.0 => x.cos().recip();
    "gudermann": 2.0 => lit(2.0) * (x * lit(0.5)).tanh().atan2(one);
    "ln_of_ln": 2.0 => x.ln().ln();
    "sqrt_ln": 2.0 => x.sqrt() * x.ln();
    "root_difference": 2.0 => ((x + one).sqrt() + x.sqrt()).recip();
    "cbrt_squared": 2.0 => x.elementary(Elementary::Cbrt).powi(2);
    "horner": 2.0 => ((x + lit(2.0)) * x + lit(3.0)) * x + lit(4.0);
    "rational": 2.0 => (x * x + one) / (x * x + lit(3.0));
    "lennard_jones": 2.0 => x.powi(-12) - x.powi(-6);
    "morse": 2.0 => (one - x).elementary(Elementary::ExpM1).powi(2);
    "planck": 2.0 => x.powi(3) / x.elementary(Elementary::ExpM1);
    "gelu": 2.0 => x * lit(0.5) * (one + (lit(0.75) * (x + x.powi(3) / lit(32.0))).tanh());
    "x_to_minus_x": 2.0 => x.powf(-x);
    "ln_sum_exp": 2.0 => x.max(y) + (x.min(y) - x.max(y)).exp().elementary(Elementary::Ln1p);
    "softmax": 2.0 => (one + (y - x).exp()).recip();
    "parallel": 2.0 => x * y / (x + y);
    "contrast": 2.0 => (x - y) / (x + y);
    "geometric": 2.0 => (x * y).sqrt();
    "decay": 2.0 => x * (-y).exp();
    "divergence": 2.0 => x * (x / y).ln();
    "cosine_of_angle": 2.0 => x / x.hypot(y);
    "potential": 2.0 => (x * x + y * y).rsqrt();
    "gravity": 2.0 => x / x.hypot(y).powi(3);
    "wave": 2.0 => x.sin() * y.cos();
    "polar": 2.0 => x * y.cos();
    "quotient_of_logs": 2.0 => x.ln() / y.ln();
    "boltzmann": 2.0 => (-(x / y)).exp();
    "elastic": 2.0 => y * lit(0.5) * (x.hypot(one) - one).powi(2);
}

struct Case {
    function: String,
    x: Vec<f64>,
    /// The value, the slopes, and the rows of the upper triangle of the second derivatives.
    expected: Vec<f64>,
}

fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/precision");
    let files = std::fs::read_dir(folder).expect("the folder of tables");
    let paths = files.map(|file| file.expect("a folder entry").path());
    let tables = paths.filter(|path| path.extension().is_some_and(|e| e == "txt"));
    let read = |path| std::fs::read_to_string(path).expect("a readable table");
    let text: String = tables.map(read).collect();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(case).collect()
}

fn case(line: &str) -> Case {
    let mut words = line.split(' ');
    let function = words.next().expect("a name").to_owned();
    let mut x: Vec<f64> = words.map(|word| word.parse().expect("a float")).collect();
    // Of one argument there are 4 numbers, of two arguments 8.
    let expected = x.split_off(x.len() / 4);
    Case {
        function,
        x,
        expected,
    }
}

/// The same numbers as in the table, in one mode.
type Mode = fn(Named, &[f64]) -> Vec<f64>;

/// The value of plain code with slopes by forward and by reverse mode; slopes and second derivatives by
/// forward over reverse and by reverse over reverse mode.
const MODES: [(&str, Mode); 4] = [
    ("forward", |f, x| {
        [vec![f.eval(x)], forward_gradient(&f, x)].concat()
    }),
    ("reverse", |f, x| {
        [vec![f.eval(x)], gradient(&f, x)].concat()
    }),
    ("forward over reverse", |f, x| {
        let rows = hessian(&f, x);
        [vec![f.eval(x)], gradient(&f, x), triangle(&rows)].concat()
    }),
    ("reverse over reverse", |f, x| {
        let row = |i: usize| gradient_of(|x| gradient(&f, x)[i], x);
        let rows: Vec<Vec<f64>> = (0..x.len()).map(row).collect();
        [vec![f.eval(x)], gradient(&f, x), triangle(&rows)].concat()
    }),
];

fn triangle(rows: &[Vec<f64>]) -> Vec<f64> {
    let parts = rows.iter().enumerate().map(|(i, row)| &row[i..]);
    parts.flatten().copied().collect()
}

/// The distance in units of the expected number's last place. What is beyond the largest float counts as the
/// largest.
fn ulps(found: f64, expected: f64) -> f64 {
    let [found, expected] = [found, expected].map(|x| x.clamp(-f64::MAX, f64::MAX));
    let size = expected.abs().min(f64::MAX.next_down());
    let error = ((found - expected) / (size.next_up() - size)).abs();
    if error.is_nan() { f64::INFINITY } else { error }
}

#[test]
fn measure() {
    use std::collections::BTreeMap;
    let mut worst: BTreeMap<String, [(f64, String); 3]> = BTreeMap::new();
    for case in cases() {
        let f = Named(&case.function);
        for (mode, of) in MODES {
            for (place, (found, expected)) in
                of(f, &case.x).into_iter().zip(&case.expected).enumerate()
            {
                let order = if place == 0 {
                    0
                } else if place <= case.x.len() {
                    1
                } else {
                    2
                };
                let e = ulps(found, *expected);
                if e > 8.0 {
                    println!(
                        "BAD {} {:?} {mode} {place}: {found:e}, expected {expected:e}, {e:.1} ulps",
                        case.function, case.x
                    );
                }
                let slot = &mut worst.entry(case.function.clone()).or_default()[order];
                if e > slot.0 && e < 1e6 {
                    *slot = (e, format!("{:?} {mode}", case.x));
                }
            }
        }
    }
    for n in NAMES {
        println!("WORST {n} {:?}", worst[*n]);
    }
}
