//! Laws that are formulas in a scene: their values, derivatives, and messages about wrong formulas.

use autodiff::{Dual, Real};
use autodiff_programs::kernels::Fixed;
use cosmic::laws::kernels::{MovingTension, Tension};
use cosmic::laws::{Bar, BarForce, BarFormula};
use cosmic::scene::Scene;

use super::kernels::{DT, is_right, values};

fn scene(tension: &str) -> Scene {
    let text = format!(
        "physics.forces = ['bar_formula']\nbar_formula = {{tension = {tension:?}, a = 3, b = 0.5}}"
    );
    Scene::parse("formula", &text).unwrap_or_else(|error| panic!("{error}"))
}

fn law(tension: &str) -> BarFormula {
    let law = scene(tension).physics.forces.chosen();
    law.expect("the scene has chosen the law")
}

fn bar<R: Real>(length: R) -> Bar<R> {
    Bar {
        length,
        rate: R::lit(-0.5),
        target: R::lit(0.75),
        rest_length: R::lit(2.0),
        stiffness: R::lit(40.0),
        strain: R::lit(0.25),
        largest_strain: 0.5,
    }
}

#[test]
fn a_formula_has_the_value_of_its_code() {
    for (text, value) in [
        ("0.2 * stiffness * max(length - rest_length, 0)", 8.0),
        ("  1+2*3-4/8 ", 6.5),
        ("10 - 2 - 3 + +1", 6.0),
        ("-length^2", -9.0),
        ("(-length)**2 * 2^-1", 4.5),
        ("2^length^2 / 2^9", 1.0),
        ("length^0.5 / sqrt(length)", 1.0),
        ("actuator + strain * target * rate", 0.40625),
        ("a * b - 1.5e0 + .5 + 1E-1 * 10", 1.5),
        ("min(length, a) + abs(rate) + cos(0)", 4.5),
        ("log(exp(b)) + tanh(0) + sin(0)", 0.5),
        ("where(length > a, 1, where(length >= a, 2, 3))", 2.0),
        ("where(rate < 0, 1, 2) + where(0 <= rate, 10, 20)", 21.0),
    ] {
        let found = BarFormula::tension(&law(text), bar(3.0));
        assert!((found - value).abs() < 1e-14, "{text}: {found}");
    }
}

/// At equal numbers, `max` and `min` have the derivative of the second one, and `where` that of its choice.
#[test]
fn kinks_have_the_derivatives_of_the_library() {
    for (text, slope) in [
        ("max(length, rest_length)", 0.0),
        ("max(rest_length, length)", 1.0),
        ("min(length, 4 - length)", -1.0),
        ("abs(length - 2)", 0.0),
        ("where(length <= 2, length^3, sqrt(2 - length))", 12.0),
    ] {
        let length = Dual::<f64, 1>::variable(2.0, 0);
        let law = law(text);
        let of = cosmic::settings::StepInputs::constant::<Dual<f64, 1>>(&law);
        assert_eq!(
            BarFormula::tension(&of, bar(length)).tangent,
            [slope],
            "{text}"
        );
    }
}

/// The adjoint agrees with finite differences, and an error of a percent is noticed.
#[test]
fn formulas_have_the_right_derivatives() {
    for text in [
        "stiffness * max(length - 1.05 * rest_length, 0) + a * rate",
        "stiffness * rest_length * tanh(a * (length / rest_length - 1)) * exp(-b * rate^2)",
        "where(rate > 0, log(1 + rate), sin(rate)) + (length / target)^1.7 - sqrt(strain) * cos(length)",
    ] {
        for [dvx, dvy] in [[0.4, -0.1], [-2.0, 1.0]] {
            let law = law(text);
            let kernel = Tension {
                law: law.clone(),
                dt: DT,
                softening: 1e-12,
                largest_strain: 0.35,
            };
            let kernel = MovingTension(kernel);
            let uniforms = values(&law);
            is_right(
                &Fixed { kernel, uniforms },
                [0.08, 0.09, dvx, dvy, 0.3, 40.0, 0.1, 0.35],
            );
        }
    }
}

/// A formula is written as it was read, to scene files and case files.
#[test]
fn a_formula_stays_as_it_is_written() {
    let text = " 0.2*stiffness\t* max(length-rest_length,\n0)";
    let scene = scene(text);
    let again = Scene::parse("again", &scene.to_run_toml()).unwrap();
    assert_eq!(again, scene);
    assert_ne!(again, self::scene("0.3 * stiffness"));
    let json = serde_json::to_value(&scene).unwrap();
    assert_eq!(json["bar_formula"]["tension"], text);
}

/// The message says what is wrong and at which column, and what is allowed.
#[test]
fn wrong_formulas_are_refused() {
    for (text, says) in [
        ("", "needs a number, a name or `(` at column 1: \"\""),
        ("lenght - 1", "has the unknown name `lenght` at column 1:"),
        ("2 * x", "has the unknown name `x` at column 5:"),
        ("length 2", "needs an operator or the end at column 8:"),
        ("(length", "needs `)` at column 8:"),
        ("length)", "needs an operator or the end at column 7:"),
        ("max(length)", "needs `,` at column 11:"),
        ("sqrt(length, 2)", "needs `)` at column 12:"),
        ("sqrt length", "needs `(` at column 6:"),
        (
            "where(length, 1, 2)",
            "needs a comparison with <, <=, > or >= at column 13:",
        ),
        ("length < 2", "needs an operator or the end at column 8:"),
        ("2 * ", "needs a number, a name or `(` at column 5:"),
        ("1.2.3", "has the malformed number `1.2.3` at column 1:"),
        ("3 length", "needs an operator or the end at column 3:"),
        (
            "length - 1/0",
            "has the constant inf, which is not a finite number, at column 11:",
        ),
        (
            "length * sqrt(-1)",
            "has the constant NaN, which is not a finite number, at column 10:",
        ),
        (
            "1e999",
            "has the constant inf, which is not a finite number, at column 1:",
        ),
        ("length · 2", "needs an operator or the end at column 8:"),
        ("é", "needs a number, a name or `(` at column 1:"),
        (
            &"(".repeat(60),
            "is nested more than 50 times at column 51:",
        ),
        (
            &"-".repeat(60),
            "is nested more than 50 times at column 51:",
        ),
        (&"1+".repeat(600), "is longer than 1000 characters:"),
    ] {
        let setting = format!("bar_formula.tension={text:?}");
        let base = scene("0");
        let message = base.set(&[&setting]).unwrap_err().to_string();
        assert!(
            message.contains(&format!("`bar_formula.tension` {says}")),
            "{text}\n{message}"
        );
        let allowed = "allowed: a formula of numbers and length, rate, target, rest_length, stiffness, strain, \
                       actuator, a, b, c, d, with + - * / ^, abs, sqrt, exp, log, sin, cos, tanh, min, max and \
                       where(left < right, value, other)";
        assert!(message.contains(allowed), "{message}");
    }
    let message = scene("0")
        .set(&["bar_formula.tension=3"])
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("`bar_formula.tension` is a whole number: 3"),
        "{message}"
    );
}
