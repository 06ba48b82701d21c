//! The functions of num-traits' `Float` for elements. Their values are compared with the system's functions, and their
//! slopes with difference quotients in 31 digits.

use std::cmp::Ordering;
use std::num::FpCategory;

use autodiff::simd::{Lane, Vectorized, kernel};
use autodiff::{DoubleDouble, Dual, Element, Real, Tape, Var, gradient, gradient_forward, hessian};
use num_traits::{Float, FloatConst, NumCast, One, Signed, ToPrimitive, Zero};

type Number = Element<Dual<DoubleDouble, 1>>;

/// The name of a function, the function of num-traits, the system's function, and the domain.
type Row = (&'static str, fn(Number) -> Number, fn(f64) -> f64, [f64; 2]);

/// One macro defines these functions for num-traits and for simba.
const FUNCTIONS: [Row; 28] = [
    ("abs", Float::abs, f64::abs, [-9.0, 9.0]),
    ("recip", Float::recip, f64::recip, [0.1, 9.0]),
    ("sqrt", Float::sqrt, f64::sqrt, [0.0, 9.0]),
    ("ln", Float::ln, f64::ln, [0.0, 9.0]),
    ("exp", Float::exp, f64::exp, [-9.0, 9.0]),
    ("tanh", Float::tanh, f64::tanh, [-9.0, 9.0]),
    ("tan", Float::tan, f64::tan, [-1.5, 1.5]),
    ("cos", Float::cos, f64::cos, [-9.0, 9.0]),
    ("sin", Float::sin, f64::sin, [-9.0, 9.0]),
    ("asin", Float::asin, f64::asin, [-1.0, 1.0]),
    ("acos", Float::acos, f64::acos, [-1.0, 1.0]),
    ("atan", Float::atan, f64::atan, [-5.0, 5.0]),
    ("sinh", Float::sinh, f64::sinh, [-5.0, 5.0]),
    ("cosh", Float::cosh, f64::cosh, [-5.0, 5.0]),
    ("asinh", Float::asinh, f64::asinh, [-9.0, 9.0]),
    ("acosh", Float::acosh, f64::acosh, [1.0, 9.0]),
    ("atanh", Float::atanh, f64::atanh, [-1.0, 1.0]),
    ("exp_m1", Float::exp_m1, f64::exp_m1, [-5.0, 5.0]),
    ("ln_1p", Float::ln_1p, f64::ln_1p, [-1.0, 9.0]),
    ("exp2", Float::exp2, f64::exp2, [-5.0, 5.0]),
    ("log2", Float::log2, f64::log2, [0.0, 9.0]),
    ("log10", Float::log10, f64::log10, [0.0, 9.0]),
    ("cbrt", Float::cbrt, f64::cbrt, [-9.0, 9.0]),
    ("floor", Float::floor, f64::floor, [-9.0, 9.0]),
    ("ceil", Float::ceil, f64::ceil, [-9.0, 9.0]),
    ("round", Float::round, f64::round, [-9.0, 9.0]),
    ("trunc", Float::trunc, f64::trunc, [-9.0, 9.0]),
    ("fract", Float::fract, f64::fract, [-9.0, 9.0]),
];

#[test]
fn elementary_functions_have_the_system_s_values_and_their_own_slopes() {
    for (name, ours, system, [least, most]) in FUNCTIONS {
        for k in (1..40).map(|k| k as f64) {
            let x = least + (most - least) * k / 40.0 + 1e-3 / k;
            let of = |x: DoubleDouble| ours(Element(Dual::variable(x, 0))).0;
            let value = of(DoubleDouble::from(x)).value.to_f64();
            // The crate's value is exact to f64, while the system's function has an error of an ulp or two.
            let error = (value - system(x)).abs();
            assert!(
                error <= 4.0 * f64::EPSILON * value.abs(),
                "{name}({x}): {value}"
            );
            // In 31 digits, a difference quotient over 1e-13 has 17 correct digits.
            let h = DoubleDouble::from(1e-13);
            let [above, below] = [h, -h].map(|h| of(DoubleDouble::from(x) + h).value);
            let slope = ((above - below) / (h + h)).to_f64();
            let ours = of(DoubleDouble::from(x)).tangent[0].to_f64();
            let error = (ours - slope).abs();
            assert!(
                error <= 1e-13 * (1.0 + slope.abs()),
                "{name}'({x}): {ours}, {slope}"
            );
        }
    }
}

#[test]
fn functions_reach_as_far_as_those_of_floats() {
    let largest = f64::MAX;
    // The logarithm of `2 x`. It serves as the reference for the largest floats, where the system's own functions
    // overflow.
    fn ln_twice(x: f64) -> f64 {
        x.ln() + std::f64::consts::LN_2
    }
    type Pair = (fn(Element<f64>) -> Element<f64>, fn(f64) -> f64, f64);
    // `precision.rs` has the other numbers up to 1e300.
    let pairs: [Pair; 6] = [
        (Float::asinh, |x| -ln_twice(-x), -largest),
        (Float::acosh, ln_twice, largest),
        (Float::sinh, f64::sinh, -f64::INFINITY),
        (Float::cosh, f64::cosh, 711.0),
        (Float::cbrt, f64::cbrt, f64::INFINITY),
        (Float::exp2, f64::exp2, 1000.5),
    ];
    for (place, (ours, system, x)) in pairs.into_iter().enumerate() {
        let (value, expected) = (ours(Element(x)).0, system(x));
        // Some of these functions are squares of `exp(x / 2)`, which has an error of 2 ulp. The others have errors of
        // an ulp or two.
        let error = f64::abs(value - expected);
        assert!(
            value == expected || error <= 6.0 * f64::EPSILON * f64::abs(expected).min(f64::MAX),
            "row {place} at {x}: {value}, not {expected}"
        );
    }
    // In single precision, squares overflow for numbers above 1.8e19, and the exponential for numbers above 88.7.
    let single = [Element(2e19_f32).asinh().0, Element(89.0_f32).sinh().0];
    let double = [2e19_f64.asinh(), 89.0_f64.sinh()];
    for (single, double) in single.into_iter().zip(double) {
        // The tolerance is for an ulp or two, each 6e-8, and for the error of `exp` as above.
        assert!((single as f64 / double - 1.0).abs() < 5e-7, "{single}");
    }
}

#[test]
fn powers_are_exact() {
    for k in -300..300 {
        let ten: f64 = format!("1e{k}").parse().expect("a number");
        let (power, k) = (f64::powi(2.0, k), k as f64);
        assert_eq!(Element(ten).log10().0, k);
        assert_eq!(Element(power).log2().0, k);
        assert_eq!(Element(k).exp2().0, power);
    }
    for k in (-3000..3000).map(|k| k as f64) {
        assert_eq!(Element(k * k * k).cbrt().0, k);
    }
    assert_eq!(Element(1000.0_f32).log10().0, 3.0);
    assert_eq!(Element(27.0_f32).cbrt().0, 3.0);
}

#[test]
fn odd_functions_keep_the_sign_of_a_zero() {
    fn zeros<T: Float>() -> [T; 11] {
        let zero = T::neg_zero();
        [
            zero.asin(),
            zero.sinh(),
            zero.asinh(),
            zero.atanh(),
            zero.ln_1p(),
            zero.cbrt(),
            zero.atan(),
            zero.sin(),
            zero.tan(),
            zero.tanh(),
            zero.exp_m1(),
        ]
    }
    assert!(zeros::<Element<f64>>().iter().all(|y| y.is_sign_negative()));
    assert!(zeros::<Element<f32>>().iter().all(|y| y.is_sign_negative()));
    assert!(
        zeros::<Element<DoubleDouble>>()
            .iter()
            .all(|y| y.is_sign_negative())
    );
}

/// Asserts which of the numbers are zero, are one, equal 0 and equal 1. If `moves`, the numbers carry derivatives.
fn assert_equals_no_constant<T>(numbers: [T; 4], moves: bool)
where
    T: Copy + Zero + One + PartialEq + PartialEq<f64> + PartialOrd<f64>,
{
    let [zeros, ones] = [
        numbers.map(|x| [x.is_zero(), x == T::zero(), x == 0.0]),
        numbers.map(|x| [x.is_one(), x == T::one(), x == 1.0]),
    ];
    let expected = |answers: [bool; 4]| answers.map(|answer| [answer && !moves; 3]);
    assert_eq!(zeros, expected([true, true, false, false]));
    assert_eq!(ones, expected([false, false, true, false]));
    // The order is that of the values, and so is the equality of two numbers that carry derivatives.
    let equal = Some(Ordering::Equal);
    assert_eq!(numbers[0].partial_cmp(&0.0), equal);
    assert_eq!(numbers[2].partial_cmp(&1.0), equal);
    assert!(numbers[0] == numbers[1] && numbers[0] != numbers[3]);
}

#[test]
fn a_number_that_carries_a_derivative_equals_no_constant() {
    let x = [0.0, -0.0, 1.0, 1e-300];
    assert_equals_no_constant(x.map(Element), false);
    assert_equals_no_constant(x.map(Dual::<f64, 2>::constant), false);
    assert_equals_no_constant(x.map(|x| Element(Dual::<f64, 2>::constant(x))), false);
    assert_equals_no_constant(x.map(Var::<f64>::constant), false);
    assert_equals_no_constant(x.map(|x| Element(Var::constant(x))), false);
    let moving = x.map(|x| Dual::<f64, 2>::variable(x, 1));
    assert_equals_no_constant(moving, true);
    assert_equals_no_constant(moving.map(Element), true);
    // Only the inner number carries a derivative.
    assert_equals_no_constant(moving.map(Var::constant), true);
    assert_equals_no_constant(moving.map(|x| Element(Dual::<_, 1>::constant(x))), true);
    Tape::new().record(&x, |x| {
        let moving = [0, 1, 2, 3].map(|k| x[k]);
        assert_equals_no_constant(moving, true);
        assert_equals_no_constant(moving.map(Element), true);
        assert_equals_no_constant(moving.map(Dual::<_, 1>::constant), true);
        assert_equals_no_constant(moving.map(|x| x * 0.0 + x.detach()), true);
    });
    let infinite = f64::INFINITY;
    assert!(Element(infinite) == Element(infinite) && Element(f64::NAN) != Element(f64::NAN));
    let far = Element(Dual::<f64, 1>::constant(infinite));
    assert!(far == Element(Dual::constant(infinite)) && far == infinite);
}

/// The product ends early at 0, so that the slopes of the later factors would be lost.
fn product_with_an_early_end<T>(factors: &[T]) -> T
where
    T: Copy + One + PartialEq<f64>,
{
    let mut product = T::one();
    for &factor in factors {
        product = product * factor;
        if product == 0.0 {
            break;
        }
    }
    product
}

#[test]
fn a_loop_that_ends_at_an_exact_zero_keeps_the_slopes_of_the_later_factors() {
    let x = [0.0, 2.0, 3.0];
    assert_eq!(product_with_an_early_end(&x), 0.0);
    let elements = |x: &[Var<f64>]| {
        let x: Vec<Element<Var<f64>>> = x.iter().copied().map(Element).collect();
        product_with_an_early_end(&x).0
    };
    let expected = gradient(|x| x[0] * x[1] * x[2], &x);
    assert_eq!(gradient(product_with_an_early_end, &x), expected);
    assert_eq!(gradient(elements, &x), expected);
    assert_eq!(gradient_forward(product_with_an_early_end, &x), expected);
    let second = hessian(|x| x[0] * x[1] * x[2], &x);
    assert_eq!(hessian(product_with_an_early_end, &x), second);
}

/// Computes a cubic root by Newton's method, in code that is generic over `Float`.
fn cubic_root<T: Float>(x: T) -> T {
    let three = T::from(3.0).expect("a small number");
    let mut root = x.max(T::one());
    while (root * root * root - x).abs() > T::epsilon() * T::from(8.0).expect("likewise") * x {
        root = root - (root * root * root - x) / (three * root * root);
    }
    root
}

#[test]
fn generic_float_code_is_differentiated() {
    fn root<R: Real>(x: &[R]) -> R {
        cubic_root(Element(x[0])).0
    }
    // After Newton's last step the first derivative is exact to within rounding. The second derivative has the error
    // that one quadratic step leaves.
    let x: f64 = 8.0;
    assert!(f64::abs(root(&[x]) - 2.0) < 1e-14);
    assert!(f64::abs(gradient(root, &[x])[0] - 1.0 / 12.0) < 1e-12);
    assert!(f64::abs(hessian(root, &[x])[0][0] + 1.0 / 144.0) < 1e-8);
    let wide = root(&[DoubleDouble::from(x)]) - DoubleDouble::from(2.0);
    assert!(f64::abs(wide.to_f64()) < 1e-30);
}

#[test]
fn classes_and_signs_are_those_of_f64() {
    let special = [
        0.0,
        -0.0,
        1.0,
        -2.5,
        5e-324,
        f64::MAX,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];
    for x in special {
        let element = Element(x);
        assert_eq!(element.classify(), x.classify(), "{x}");
        assert_eq!(element.is_sign_negative(), x.is_sign_negative(), "{x}");
        assert_eq!(element.is_finite(), x.is_finite());
        assert_eq!(element.is_infinite(), x.is_infinite());
        assert_eq!(element.is_normal(), x.is_normal());
        assert_eq!(
            (element.is_positive(), element.is_negative()),
            (x > 0.0, x < 0.0)
        );
        assert_eq!(
            Float::copysign(Element(3.0), element).0,
            3.0_f64.copysign(x)
        );
    }
    assert_eq!(Element(f64::NAN).classify(), FpCategory::Nan);
    assert!(Element(f64::NAN).is_nan() && Element(f64::NAN) != Element(f64::NAN));
}

#[test]
fn ranges_are_those_of_the_type_inside() {
    fn ranges<T: Float>() -> [T; 4] {
        [
            T::max_value(),
            T::min_value(),
            T::min_positive_value(),
            T::epsilon(),
        ]
    }
    assert_eq!(ranges::<Element<f64>>().map(|x| x.0), ranges::<f64>());
    assert_eq!(ranges::<Element<f32>>().map(|x| x.0), ranges::<f32>());
    let logarithm = Float::log(Element(7.0), Element(3.0)).0;
    assert_eq!(logarithm, 7.0_f64.ln() / 3.0_f64.ln());
    assert_eq!(Element(90.0).to_radians().0, std::f64::consts::FRAC_PI_2);
    assert_eq!(Element(std::f64::consts::PI).to_degrees().0, 180.0);
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn no_primitive_number_comes_out() {
    let moving = Element(Dual::<f64, 1>::variable(2.0, 0));
    assert_eq!(
        (moving.to_f64(), moving.to_i64(), moving.to_u32()),
        (None, None, None)
    );
    assert_eq!(<f64 as NumCast>::from(moving), None);
    assert!(std::panic::catch_unwind(|| moving.integer_decode()).is_err());
    assert_eq!(Element(1.5).to_string(), "1.5");
    let constant: Element<Dual<f64, 1>> = NumCast::from(7_u8).expect("a small number");
    assert_eq!((constant.0.value, constant.0.tangent), (7.0, [0.0]));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn lanes_pass_until_they_disagree_about_a_branch() {
    struct InLanes([f64; 16]);
    #[kernel]
    impl Vectorized<f64> for InLanes {
        type Output = ();
        fn run<L: Lane<f64>>(self) {
            let x = Element(L::load(&self.0));
            let mut rounded = vec![0.0; L::N];
            x.round().0.store(&mut rounded);
            for (rounded, x) in rounded.iter().zip(self.0) {
                assert_eq!(*rounded, x.round());
            }
            assert!(x > Element::lit(-9.0));
            let torn = std::panic::AssertUnwindSafe(|| x > Element::lit(0.0));
            assert_eq!(std::panic::catch_unwind(torn).is_err(), L::N > 1);
        }
    }
    f64::vectorize(InLanes(std::array::from_fn(|i| 0.75 * (i as f64 - 1.0))));
}

/// Returns the errors of the constants: each one is compared with the value of a formula, such as `sqrt(2)`.
fn misfits<F: Float + FloatConst>() -> Vec<F> {
    let number = |x: f64| F::from(x).unwrap_or_else(F::nan);
    let (two, ten) = (number(2.0), number(10.0));
    vec![
        F::E() - F::one().exp(),
        F::PI() - number(4.0) * F::one().atan(),
        F::TAU() - two * F::PI(),
        F::FRAC_1_PI() - F::PI().recip(),
        F::FRAC_2_PI() - two / F::PI(),
        F::FRAC_2_SQRT_PI() - two / F::PI().sqrt(),
        F::FRAC_PI_2() - F::PI() / two,
        F::FRAC_PI_3() - F::PI() / number(3.0),
        F::FRAC_PI_4() - F::PI() / number(4.0),
        F::FRAC_PI_6() - F::PI() / number(6.0),
        F::FRAC_PI_8() - F::PI() / number(8.0),
        F::SQRT_2() - two.sqrt(),
        F::FRAC_1_SQRT_2() - two.sqrt().recip(),
        F::LN_2() - two.ln(),
        F::LN_10() - ten.ln(),
        F::LOG2_E() - two.ln().recip(),
        F::LOG10_E() - ten.ln().recip(),
        F::LOG10_2() - two.ln() / ten.ln(),
        F::LOG2_10() - ten.ln() / two.ln(),
    ]
}

#[test]
fn constants_have_all_digits_that_a_number_has() {
    // The formulas are two operations on numbers up to 7, each with an error of 1e-32 in double-double.
    let wide = misfits::<Element<DoubleDouble>>();
    let off = |x: &Element<DoubleDouble>| x.0.abs().less(DoubleDouble::lit(3e-31));
    assert!(wide.iter().all(off), "{wide:?}");
    assert_eq!(Element::<f32>::PI().0, std::f32::consts::PI);
}

#[test]
fn sums_and_products_are_differentiated() {
    fn spread<T: Float + std::iter::Sum + for<'a> std::iter::Product<&'a T>>(x: &[T]) -> T {
        x.iter().copied().sum::<T>() * x.iter().product::<T>()
    }
    let slope = gradient(
        |x| spread(&x.iter().map(|&x| Element(x)).collect::<Vec<_>>()).0,
        &[2.0, 3.0],
    );
    // The function is (x + y) x y. Its slopes are 2 x y + y^2 and x^2 + 2 x y.
    assert_eq!(slope, [21.0, 16.0]);
}
