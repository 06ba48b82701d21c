//! Every [`Elementary`] function, and the methods that have rules of their own, in every mode against differences in
//! double-double. The functions are taken from [`Elementary::ALL`], and what is expected at a pole or at an end of the domain follows from the values beside it. So
//! a new function needs a line here only if it has a slope at a pole.

use autodiff::simd::kernel;
use autodiff::{DoubleDouble, Dual, Elementary, Function, Real, gradient};

use crate::common::{forward_gradient, gradients, second_derivatives};
use crate::in_lanes::slopes;

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

/// Arguments where functions use series, ends of domains, poles, and arguments further out.
const POINTS: [f64; 40] = [
    0.0, -0.0, 3.3e-16, -1e-14, 1e-10, -1e-8, 1e-5, -1e-3, 0.1, -0.3, 0.3, 0.5, -0.7, 0.999,
    -0.999, 1.0, -1.0, 1.001, -1.001, 1.0625, 1.46, -1.5, 1.7, 2.0, -2.0, 2.5, -2.6, 3.0, -4.0,
    9.0, -9.3, 16.0, -20.0, 25.0, 123.25, 500.0, 1e4, 1e10, -1e8, -1e155,
];

/// Slopes at poles where the function is defined on both sides, and at kinks. Everywhere else a pole has none.
const CONVENTIONS: [(Of, f64, f64); 5] = [
    (Of::Table(Elementary::LnGamma), 0.0, -INF),
    (Of::Table(Elementary::Digamma), 0.0, INF),
    (Of::Table(Elementary::Trigamma), 0.0, -INF),
    (Of::Recip, 0.0, -INF),
    (Of::Rsqrt, 0.0, -INF),
];

/// Functions whose third derivatives are less accurate than those of others, and by how much: their terms cancel.
const LESS_ACCURATE: [(Of, f64); 1] = [(Of::Table(Elementary::LnErfc), 64.0)];

/// A function of one number: one of the table, or a method that has a rule of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Of {
    Table(Elementary),
    Recip,
    Sqrt,
    Rsqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Tanh,
    Atan,
}

const METHODS: [Of; 10] = [
    Of::Recip,
    Of::Sqrt,
    Of::Rsqrt,
    Of::Exp,
    Of::Ln,
    Of::Sin,
    Of::Cos,
    Of::Tan,
    Of::Tanh,
    Of::Atan,
];

#[kernel]
fn apply<R: Real>(function: Of, x: R) -> R {
    match function {
        Of::Table(function) => x.elementary(function),
        Of::Recip => x.recip(),
        Of::Sqrt => x.sqrt(),
        Of::Rsqrt => x.rsqrt(),
        Of::Exp => x.exp(),
        Of::Ln => x.ln(),
        Of::Sin => x.sin(),
        Of::Cos => x.cos(),
        Of::Tan => x.tan(),
        Of::Tanh => x.tanh(),
        Of::Atan => x.atan(),
    }
}

impl Function for Of {
    #[inline(always)]
    fn eval<R: Real>(&self, x: &[R]) -> R {
        apply(*self, x[0])
    }
}

/// The derivative of a function of one number, in forward mode. It is itself a function that can be differentiated.
#[derive(Clone, Copy)]
struct Slope<F>(F);

impl<F: Function> Function for Slope<F> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.0.eval(&[Dual::<R, 1>::variable(x[0], 0)]).tangent[0]
    }
}

fn wide(function: &impl Function, x: DoubleDouble) -> DoubleDouble {
    function.eval(&[x])
}

/// A derivative by differences of a function.
#[derive(Clone, Copy)]
struct Differences {
    slope: f64,
    /// The distance between the slopes of two steps.
    doubt: f64,
    /// How much the slope may be off: by some dozens of roundings, also of the argument. What remains of a larger value
    /// counts too, for slopes near 0. In `f32` it is larger by the ratio of the epsilons.
    allowed: f64,
}

impl Differences {
    /// Takes the differences on the scale of the argument or, if they do not settle, on the scale 1.
    fn at(function: &impl Function, x: f64) -> Self {
        let near = Self::with_step(function, x, 1e-8 * if x == 0.0 { 1.0 } else { x.abs() });
        if near.is_sure() {
            return near;
        }
        let far = Self::with_step(function, x, 1e-8);
        if far.is_sure() { far } else { near }
    }

    /// Takes the differences of fourth order with the step `h` and a quarter of it. With double-double's 29 digits or
    /// more, the second is off by 1e-34 times a fifth derivative and by 1e-20 of the value's change over the scale.
    fn with_step(function: &impl Function, x: f64, h: f64) -> Self {
        let middle = wide(function, x.into());
        let slopes = [h, h / 4.0].map(|h| {
            let h = DoubleDouble::from(h);
            let at = |steps: f64| {
                wide(
                    function,
                    DoubleDouble::from(x) + h * DoubleDouble::from(steps),
                )
            };
            let [near, far] = [1.0, 2.0].map(|k| [at(k), at(-k)]);
            let eight = DoubleDouble::from(8.0);
            let slope =
                (eight * (near[0] - near[1]) - (far[0] - far[1])) / (DoubleDouble::from(12.0) * h);
            let curvature = (near[0] + near[1] - middle - middle) / (h * h);
            [slope, curvature].map(DoubleDouble::to_f64)
        });
        let [[first, _], [slope, curvature]] = slopes;
        let (roundings, rest) = (64.0 * f64::EPSILON, 1e-17);
        let rest = rest * middle.to_f64().abs() / x.abs().max(1.0);
        // The second term is what the roundings of double-double may add up to.
        let doubt = (slope - first).abs() + 1e-29 * middle.to_f64().abs() / h;
        Self {
            slope,
            doubt: if doubt.is_nan() { INF } else { doubt },
            allowed: roundings * (slope.abs() + (x * curvature).abs()) + rest,
        }
    }

    /// Whether the two steps agree, so that the function is smooth here.
    fn is_sure(self) -> bool {
        self.allowed.is_finite() && self.doubt <= 0.1 * self.allowed
    }

    fn has(self, found: f64, epsilon: f64) -> bool {
        (found - self.slope).abs() <= self.allowed * epsilon / f64::EPSILON
    }
}

/// What is expected of a function at a point where differences do not settle.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Special {
    /// The value and all derivatives are NaN.
    Outside,
    /// A pole, or a limit of the slope: infinite, or NaN.
    Slope(f64),
    /// The value overflows, or has too few digits in double-double.
    Unknown,
}

fn special(function: Of, x: f64) -> Special {
    let middle = wide(&function, x.into()).to_f64();
    if function.eval(&[x]).is_nan() {
        return Special::Outside;
    }
    let mut listed = CONVENTIONS
        .iter()
        .filter(|&&(of, at, _)| of == function && at == x);
    if let Some(&(_, _, slope)) = listed.next() {
        return Special::Slope(slope);
    }
    // The quotients of both sides at two distances. They are NaN outside the domain.
    let quotients = [1.0, -1.0].map(|side| {
        [1e-10, 1e-14].map(|h: f64| {
            let h = DoubleDouble::from(side * h * x.abs().max(1.0));
            let there = wide(&function, DoubleDouble::from(x) + h);
            ((there - wide(&function, x.into())) / h).to_f64()
        })
    });
    let inside: Vec<_> = quotients.into_iter().filter(|q| !q[0].is_nan()).collect();
    if middle.is_nan() || inside.is_empty() {
        return Special::Unknown;
    }
    if inside.len() == 2 && middle.is_infinite() {
        return Special::Slope(NAN);
    }
    let grows = |q: &[f64; 2]| {
        q[0] * inside[0][0] > 0.0 && (q[1].abs() > 1.2 * q[0].abs() || q[0].is_infinite())
    };
    assert!(
        inside.iter().all(grows),
        "{function:?} has a kink at {x}: add its slope to `CONVENTIONS`, and a row to `kinks.md`"
    );
    Special::Slope(INF * inside[0][0].signum())
}

/// Collects the results that are not as expected.
struct Judge {
    function: Of,
    mistakes: Vec<String>,
    /// How many points were smooth, outside the domain, and special.
    seen: [usize; 3],
}

impl Judge {
    fn is(&mut self, right: bool, what: &str, x: f64, found: f64, expected: f64) {
        if !right {
            let function = self.function;
            self.mistakes.push(format!(
                "{function:?}, {what} at {x:?}: {found:e}, not {expected:e}"
            ));
        }
    }

    fn are(&mut self, found: &[(String, f64)], x: f64, of: Differences, epsilon: f64) {
        for (what, found) in found {
            self.is(of.has(*found, epsilon), what, x, *found, of.slope);
        }
    }

    /// Judges values and slopes at one point. `found` has the names of the modes, with values and slopes.
    fn first(&mut self, found: &[(String, [f64; 2])], x: f64, epsilon: f64) {
        let of = Differences::at(&self.function, x);
        let value = wide(&self.function, x.into()).to_f64();
        let special = if of.is_sure() {
            None
        } else {
            Some(special(self.function, x))
        };
        let kind = special.map_or(0, |special| 1 + usize::from(special != Special::Outside));
        self.seen[kind] += 1;
        let ratio = epsilon / f64::EPSILON;
        // Beyond these limits the type has fewer digits, or double-double has.
        let most = if ratio > 1.0 { 1e37 } else { 1e270 };
        let fits = |x: f64| x == 0.0 || (most.recip() < x.abs() && x.abs() < most);
        if special.is_none() && !(fits(value) && fits(of.slope)) {
            return;
        }
        // The value of a function is off by some roundings, also of the argument.
        let least = 1e-17 * x.abs().min(1.0);
        let room = 64.0 * f64::EPSILON * (value.abs() + (x * of.slope).abs()) + least;
        for (what, [y, slope]) in found {
            match special {
                None => {
                    self.is(
                        (y - value).abs() <= room * ratio,
                        &format!("value {what}"),
                        x,
                        *y,
                        value,
                    );
                    self.is(
                        of.has(*slope, epsilon),
                        &format!("slope {what}"),
                        x,
                        *slope,
                        of.slope,
                    );
                }
                Some(Special::Outside) => {
                    self.is(
                        y.is_nan() && slope.is_nan(),
                        &format!("slope {what}"),
                        x,
                        *slope,
                        NAN,
                    );
                }
                Some(Special::Slope(expected)) => {
                    let same = *slope == expected || slope.is_nan() && expected.is_nan();
                    self.is(same, &format!("slope {what}"), x, *slope, expected);
                }
                Some(Special::Unknown) => {}
            }
        }
    }

    /// Judges second and third derivatives, where the function is smooth.
    fn higher(&mut self, x: f64) {
        let (function, first) = (self.function, Slope(self.function));
        let second = Slope(first);
        if !Differences::at(&function, x).is_sure() {
            return;
        }
        let of_second = Differences::at(&first, x);
        let modes = second_derivatives(&function, &[x]);
        let named = modes.map(|(mode, found)| (format!("second derivative {mode}"), found));
        self.are(&named, x, of_second, f64::EPSILON);
        let third = Slope(second).eval(&[x]);
        let mut of_third = Differences::at(&second, x);
        let listed = LESS_ACCURATE.iter().filter(|(of, _)| *of == function);
        of_third.allowed *= listed.map(|(_, factor)| factor).product::<f64>();
        self.are(
            &[("third derivative".into(), third)],
            x,
            of_third,
            f64::EPSILON,
        );
        let wide = wide(&second, x.into()).to_f64();
        self.are(
            &[("second derivative in DoubleDouble".into(), wide)],
            x,
            of_second,
            f64::EPSILON,
        );
    }
}

/// Returns what is wrong with a function, and how many points of each kind there were.
fn judged(function: Of) -> Judge {
    let mut judge = Judge {
        function,
        mistakes: Vec::new(),
        seen: [0; 3],
    };
    let single = POINTS.map(|x| x as f32);
    let (many, many_single) = (slopes(function, &POINTS), slopes(function, &single));
    for (i, x) in POINTS.into_iter().enumerate() {
        let value = function.eval(&[x]);
        let mut found: Vec<_> = gradients(&function, &[x])
            .into_iter()
            .map(|(mode, slope)| (mode.to_owned(), [value, slope[0]]))
            .collect();
        found.extend(many.iter().map(|(way, found)| (way.to_string(), found[i])));
        let wide_x = [DoubleDouble::from(x)];
        let wide = [
            wide(&function, wide_x[0]),
            forward_gradient(&function, &wide_x)[0],
        ];
        found.push((
            "forward in DoubleDouble".into(),
            wide.map(DoubleDouble::to_f64),
        ));
        let wide = [wide[0], gradient(|x| function.eval(x), &wide_x)[0]];
        found.push((
            "reverse in DoubleDouble".into(),
            wide.map(DoubleDouble::to_f64),
        ));
        judge.first(&found, x, f64::EPSILON);
        judge.higher(x);
        let x = [single[i]];
        if !x[0].is_finite() {
            continue;
        }
        let slopes = [
            forward_gradient(&function, &x)[0],
            gradient(|x| function.eval(x), &x)[0],
        ];
        let [forward, reverse] = slopes.map(|slope| [function.eval(&x), slope].map(f64::from));
        let mut found = vec![("forward".into(), forward), ("reverse".into(), reverse)];
        found.extend(
            many_single
                .iter()
                .map(|(way, found)| (way.to_string(), found[i])),
        );
        let found: Vec<_> = found
            .into_iter()
            .map(|(way, found)| (format!("{way} in f32"), found))
            .collect();
        judge.first(&found, x[0].into(), f32::EPSILON.into());
    }
    judge
}

#[test]
fn every_function_has_its_derivatives_in_every_mode() {
    let (mut mistakes, mut seen) = (Vec::new(), [0; 3]);
    let table = Elementary::ALL.iter().map(|&function| Of::Table(function));
    for function in table.chain(METHODS) {
        let judge = judged(function);
        assert!(
            judge.seen[0] >= 15,
            "{function:?} is smooth at {} points",
            judge.seen[0]
        );
        mistakes.extend(judge.mistakes);
        seen = std::array::from_fn(|kind| seen[kind] + judge.seen[kind]);
        for x in [NAN, -NAN] {
            let nan = gradients(&function, &[x]);
            assert!(
                nan.iter().all(|(_, slope)| slope[0].is_nan()),
                "{function:?} of NaN: {nan:?}"
            );
        }
    }
    assert!(
        mistakes.is_empty(),
        "{} mistakes\n{}",
        mistakes.len(),
        mistakes.join("\n")
    );
    // The functions that there are have ends and poles at many of these points.
    assert!(seen[1] > 100 && seen[2] > 50, "{seen:?}");
}
