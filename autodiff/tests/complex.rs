//! Complex numbers over elements: every function on both axes and off them, compared with differences in 31 digits.

use crate::common::{forward_gradient, gradients, hessian_rows};
use autodiff::{
    DoubleDouble, Element, Function, Real, Var, gradient, gradient_forward, jacobian_reverse,
    value_and_gradient,
};
use nalgebra::{Complex, ComplexField};

/// The functions of num-complex, and those of nalgebra's trait, which has formulas of its own. The second argument is
/// the exponent, the divisor or the base.
fn of<R: Real>(name: &str, x: &[R]) -> Complex<Element<R>> {
    let z = Complex::new(Element(x[0]), Element(x[1]));
    let w = Complex::new(Element(x[2]), Element(x[3]));
    let base = w.re + Element::lit(1.5);
    match name {
        "inv" => z.inv(),
        "finv" => z.finv(),
        "div" => z / (w + Element::lit(1.5)),
        "fdiv" => z.fdiv(w + Element::lit(1.5)),
        "mul" => z * w,
        "norm" => Complex::new(z.norm(), z.arg()),
        "exp" => z.exp(),
        "exp2" => z.exp2(),
        "expf" => z.expf(base),
        "ln" => z.ln(),
        "log" => z.log(base),
        "log2" => z.log2(),
        "log10" => z.log10(),
        "sqrt" => z.sqrt(),
        "cbrt" => z.cbrt(),
        "powi" => Complex::powi(&z, 3),
        "powi of -2" => Complex::powi(&z, -2),
        "powf" => z.powf(w.re),
        "powf of a constant" => z.powf(Element::lit(1.5)),
        "powc" => z.powc(w),
        "powc of a constant" => z.powc(Complex::new(0.5, -1.0).map_parts()),
        "sin" => z.sin(),
        "cos" => z.cos(),
        "tan" => z.tan(),
        "asin" => z.asin(),
        "acos" => z.acos(),
        "atan" => z.atan(),
        "sinh" => z.sinh(),
        "cosh" => z.cosh(),
        "tanh" => z.tanh(),
        "asinh" => z.asinh(),
        "acosh" => z.acosh(),
        "atanh" => z.atanh(),
        "field sqrt" => ComplexField::sqrt(z),
        "field cbrt" => ComplexField::cbrt(z),
        "field exp" => ComplexField::exp(z),
        "field ln" => ComplexField::ln(z),
        "field ln_1p" => ComplexField::ln_1p(z),
        "field powi" => ComplexField::powi(z, 3),
        "field powf" => ComplexField::powf(z, w.re),
        "field powc" => ComplexField::powc(z, w),
        "field asin" => ComplexField::asin(z),
        "field acos" => ComplexField::acos(z),
        "field atan" => ComplexField::atan(z),
        "field asinh" => ComplexField::asinh(z),
        "field acosh" => ComplexField::acosh(z),
        "field atanh" => ComplexField::atanh(z),
        "field sinc" => ComplexField::sinc(z),
        "field to_exp" => ComplexField::to_exp(z).1,
        _ => panic!("no function is called {name}"),
    }
}

/// Makes a constant complex element.
trait MapParts {
    fn map_parts<R: Real>(self) -> Complex<Element<R>>;
}

impl MapParts for Complex<f64> {
    fn map_parts<R: Real>(self) -> Complex<Element<R>> {
        Complex::new(Element::lit(self.re), Element::lit(self.im))
    }
}

/// Functions of `z` alone. Those of the second list have a branch point or a pole at 0.
const OF_ONE: [&str; 22] = [
    "powi",
    "exp",
    "exp2",
    "sin",
    "cos",
    "tan",
    "sinh",
    "cosh",
    "tanh",
    "asin",
    "acos",
    "atan",
    "asinh",
    "acosh",
    "atanh",
    "field exp",
    "field ln_1p",
    "field asin",
    "field acos",
    "field atan",
    "field asinh",
    "field atanh",
];
const NOT_AT_ZERO: [&str; 18] = [
    "inv",
    "finv",
    "norm",
    "ln",
    "log2",
    "log10",
    "sqrt",
    "cbrt",
    "powi of -2",
    "powf of a constant",
    "powc of a constant",
    "field sqrt",
    "field cbrt",
    "field ln",
    "field acosh",
    "field sinc",
    "field to_exp",
    "field powi",
];
/// Functions of both arguments.
const OF_TWO: [&str; 9] = [
    "mul",
    "div",
    "fdiv",
    "expf",
    "log",
    "powf",
    "powc",
    "field powf",
    "field powc",
];

/// Numbers on both axes, on every cut with both signs of zero, and off the axes.
const NUMBERS: [[f64; 2]; 20] = [
    [4.0, 0.0],
    [4.0, -0.0],
    [-4.0, 0.0],
    [-4.0, -0.0],
    [0.0, 2.0],
    [0.0, -2.0],
    [-0.0, 2.0],
    [-0.0, -2.0],
    [0.3, 0.0],
    [0.3, -0.0],
    [-0.3, 0.0],
    [-0.3, -0.0],
    [0.0, 0.4],
    [0.0, -0.4],
    [-0.0, 0.4],
    [-0.0, -0.4],
    [0.7, -1.3],
    [-2.1, 0.6],
    [0.2, 0.1],
    [-0.3, -3.0],
];
const SECOND: [[f64; 2]; 5] = [[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [0.5, -0.7], [1.0, -0.0]];

/// The real or the imaginary part of a function.
struct Part(&'static str, bool);

impl Function for Part {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let y = of(self.0, x);
        if self.1 { y.im.0 } else { y.re.0 }
    }
}

/// Returns a point off both axes, 4e-15 away from `x`, on that side of each cut from which the function's value at `x`
/// is the limit. If there is no cut, the side is that of the signs of zero.
fn beside(name: &str, x: &[f64]) -> Vec<DoubleDouble> {
    let here = of(name, x);
    let sides = [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    let points = sides.map(|sides| {
        let signs = [0, 1].map(|k| sides[k] * 1.0_f64.copysign(x[k]));
        let moved = (0..x.len()).map(|k| {
            let sign = signs.get(k).copied().unwrap_or(1.0);
            DoubleDouble::from(x[k]) + DoubleDouble::from(4e-15 * sign)
        });
        moved.collect::<Vec<DoubleDouble>>()
    });
    let near = |point: &&Vec<DoubleDouble>| {
        let there = of(name, point);
        let gaps = [(there.re, here.re), (there.im, here.im)];
        gaps.iter()
            .all(|(a, b)| (a.0.to_f64() - b.0).abs() < 1e-8 * (1.0 + b.0.abs()))
    };
    let found = points.iter().find(near);
    found
        .unwrap_or_else(|| panic!("{name} at {x:?} is the limit of neither side"))
        .clone()
}

/// Central differences of the values at a point, one row for each value.
fn differences(
    values: impl Fn(&[DoubleDouble]) -> Vec<DoubleDouble>,
    x: &[DoubleDouble],
) -> Vec<f64> {
    let columns = (0..x.len()).map(|k| crate::common::differences(&values, x, k, 1e-15));
    let columns: Vec<Vec<DoubleDouble>> = columns.collect();
    let rows = (0..columns[0].len()).flat_map(|i| columns.iter().map(move |column| column[i]));
    rows.map(|slope| slope.to_f64()).collect()
}

/// Returns what is wrong with the slopes and the second derivatives of a function in every mode.
fn mistakes(name: &'static str, x: &[f64]) -> Vec<String> {
    let beside = beside(name, x);
    let mut mistakes = Vec::new();
    for part in [false, true].map(|imaginary| Part(name, imaginary)) {
        let slopes = differences(|x| vec![part.eval(x)], &beside);
        // The point beside is off by 4e-15 times derivatives up to 1e4. The formulas of num-complex lose two digits
        // where terms cancel, and second derivatives lose them twice.
        let mut close = |mode: &str, found: &[f64], expected: &[f64]| {
            let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-10 * (1.0 + b.abs());
            if !found.iter().zip(expected).all(near) {
                mistakes.push(format!(
                    "{name}, {mode}, imaginary {}, at {x:?}: {found:?}, not {expected:?}",
                    part.1
                ));
            }
        };
        let (value, _) = value_and_gradient(|x| part.eval(x), x);
        close("value", &[value], &[part.eval(x)]);
        for (mode, found) in gradients(&part, x) {
            close(mode, &found, &slopes);
        }
        close(
            "eight directions",
            &gradient_forward(|x| part.eval(x), x),
            &slopes,
        );
        let second = differences(|x| forward_gradient(&part, x), &beside);
        close("Hessian", &hessian_rows(&part, x).concat(), &second);
        close("tapes", &hessian_by_tapes(&part, x), &second);
    }
    mistakes
}

fn assert_none(mistakes: Vec<String>) {
    assert!(mistakes.is_empty(), "{}", mistakes.join("\n"));
}

/// The Hessian by a tape on a tape.
fn hessian_by_tapes(part: &Part, x: &[f64]) -> Vec<f64> {
    let slopes = |x: &[Var<f64>]| gradient(|x| part.eval(x), x);
    jacobian_reverse(slopes, x).as_slice().to_vec()
}

#[test]
fn functions_of_complex_numbers_are_right_on_axes_and_cuts_and_off_them() {
    let mut found = Vec::new();
    for name in OF_ONE.into_iter().chain(NOT_AT_ZERO) {
        for [re, im] in NUMBERS {
            found.extend(mistakes(name, &[re, im, 0.5, 0.0]));
        }
    }
    for name in OF_ONE {
        found.extend(mistakes(name, &[0.0, 0.0, 0.5, 0.0]));
    }
    assert_none(found);
}

#[test]
fn powers_and_quotients_are_right_where_the_exponent_is_zero_or_real() {
    let mut found = Vec::new();
    for name in OF_TWO {
        for [re, im] in NUMBERS {
            for [p, q] in SECOND {
                found.extend(mistakes(name, &[re, im, p, q]));
            }
        }
    }
    assert_none(found);
}

/// Points where a function of complex numbers has no derivative.
const BRANCH_POINTS: [(&str, [f64; 2]); 39] = [
    ("norm", [0.0, 0.0]),
    ("ln", [0.0, 0.0]),
    ("ln", [-0.0, -0.0]),
    ("log", [0.0, 0.0]),
    ("log2", [0.0, 0.0]),
    ("log10", [0.0, 0.0]),
    ("sqrt", [0.0, 0.0]),
    ("sqrt", [-0.0, 0.0]),
    ("cbrt", [0.0, 0.0]),
    ("powf", [0.0, 0.0]),
    ("asin", [1.0, 0.0]),
    ("asin", [-1.0, 0.0]),
    ("asin", [-1.0, -0.0]),
    ("acos", [1.0, 0.0]),
    ("acos", [-1.0, 0.0]),
    ("atan", [0.0, 1.0]),
    ("atan", [0.0, -1.0]),
    ("atan", [-0.0, 1.0]),
    ("asinh", [0.0, 1.0]),
    ("asinh", [0.0, -1.0]),
    ("acosh", [1.0, 0.0]),
    ("acosh", [-1.0, 0.0]),
    ("atanh", [1.0, 0.0]),
    ("atanh", [-1.0, 0.0]),
    ("atanh", [1.0, -0.0]),
    ("field sqrt", [0.0, 0.0]),
    ("field cbrt", [0.0, 0.0]),
    ("field ln", [0.0, 0.0]),
    ("field powf", [0.0, 0.0]),
    ("field powc", [0.0, 0.0]),
    ("field asin", [1.0, 0.0]),
    ("field acos", [-1.0, 0.0]),
    ("field atan", [0.0, 1.0]),
    ("field asinh", [0.0, -1.0]),
    ("field acosh", [1.0, 0.0]),
    ("field acosh", [-1.0, 0.0]),
    ("field atanh", [1.0, 0.0]),
    ("field to_exp", [0.0, 0.0]),
    ("field ln_1p", [-1.0, 0.0]),
];

#[test]
fn at_a_branch_point_no_slope_is_finite() {
    let mut found = Vec::new();
    for (name, [re, im]) in BRANCH_POINTS {
        let x = [re, im, 0.5, 0.0];
        let [real, imaginary] = [false, true].map(|imaginary| Part(name, imaginary));
        for part in [&real, &imaginary] {
            let together = [
                gradient(|x| part.eval(x), &x),
                gradient_forward(|x| part.eval(x), &x),
            ];
            for slopes in together {
                if slopes[..2].iter().any(|slope| slope.is_finite()) {
                    found.push(format!("{name} at {x:?}, imaginary {}: {slopes:?}", part.1));
                }
            }
        }
        let [of_real, of_imaginary] = [gradients(&real, &x), gradients(&imaginary, &x)];
        // Forward mode looks along each axis alone: the test after next.
        for ((mode, real), (_, imaginary)) in of_real.iter().zip(&of_imaginary).skip(1) {
            for (real, imaginary) in real[..2].iter().zip(imaginary) {
                if real.is_finite() && imaginary.is_finite() {
                    found.push(format!("{name} at {x:?}, {mode}: {real} and {imaginary}"));
                }
            }
        }
    }
    assert_none(found);
}

/// At a pole the value is not finite, so that a slope of 0 from forward mode misleads nobody.
#[test]
fn at_a_pole_no_value_is_finite() {
    for name in ["inv", "finv", "powi of -2", "field sinc"] {
        for part in [false, true].map(|imaginary| Part(name, imaginary)) {
            let (value, _) = value_and_gradient(|x| part.eval(x), &[0.0, 0.0, 0.5, 0.0]);
            assert!(!value.is_finite(), "{name}: {value}");
        }
    }
}

/// num-complex returns a constant for a power of 0. Where the real part is a constant 0, its roots take the absolute value
/// of the imaginary part, which is flat at 0. If this test fails, num-complex has changed, and the documentation of
/// `interop` must change too.
#[test]
fn what_num_complex_loses_at_zero_is_pinned() {
    // All these slopes are infinite.
    let power = Part("powc", false);
    for (mode, slopes) in gradients(&power, &[0.0, 0.0, 0.5, 0.0]) {
        assert_eq!(slopes, [0.0; 4], "{mode}");
    }
    for name in ["sqrt", "cbrt"] {
        let root = |x: &[Var<f64>]| of(name, &[Var::lit(0.0), x[0], x[0], x[0]]).re.0;
        assert_eq!(gradient(root, &[0.0]), [0.0], "{name}");
        assert_eq!(
            forward_gradient(&Part(name, false), &[0.0; 4])[1],
            0.0,
            "{name}"
        );
    }
}

/// The attenuation of a cable of 2 ohm, whose inductance and conductance by length are the arguments.
struct Attenuation;

impl Function for Attenuation {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [inductance, conductance] = [0, 1].map(|k| Element(x[k]));
        let series = Complex::new(Element::lit(2.0), inductance * Element::lit(1e6));
        let across = Complex::new(conductance, Element::lit(1e-3));
        (series * across).sqrt().re.0
    }
}

#[test]
fn the_attenuation_of_a_cable_has_its_slopes_without_inductance_and_leakage() {
    let x = [0.0, 0.0];
    let expected = [-7905.694150420949, 15.811388300841896];
    for (mode, slopes) in gradients(&Attenuation, &x) {
        let close = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < 1e-13;
        assert!(
            slopes.iter().zip(&expected).all(close),
            "{mode}: {slopes:?}"
        );
    }
    let at = |k: usize, h: f64| {
        let mut x = x.map(DoubleDouble::from);
        x[k] += DoubleDouble::from(h);
        forward_gradient(&Attenuation, &x)
    };
    let rows = hessian_rows(&Attenuation, &x);
    // The root changes on the scales 1e-6 and 1e-3. A difference over 1e-18 is off by its square.
    for (k, row) in rows.iter().enumerate() {
        let [above, below] = [at(k, 1e-18), at(k, -1e-18)];
        for (found, (above, below)) in row.iter().zip(above.iter().zip(below)) {
            let slope = ((*above - below) / DoubleDouble::from(2e-18)).to_f64();
            assert!((found / slope - 1.0).abs() < 1e-9, "{rows:?}");
        }
    }
    let expected = [1.976423537605237e9, 7905.694150420949];
    assert!((rows[0][0] / expected[0] - 1.0).abs() < 1e-13, "{rows:?}");
    assert!((rows[1][1] / expected[1] - 1.0).abs() < 1e-13, "{rows:?}");
}
