//! Kernels whose fields change the operations or the derivative, and not only the values of constants.

use autodiff::Real;
use autodiff::custom::{Rule, apply};
use autodiff_programs::emit::adjoint;
use autodiff_programs::{Kernel, kernel};

use crate::common::assert_refused;

/// What the fields `a` and `b` of the kernel are used for.
#[derive(Clone, Copy, Debug)]
enum Use {
    Values,
    Exponent,
    Above(f64),
    Order,
    Both,
    Loop,
    Results,
    Finite,
    Halved,
    InRule,
}

#[derive(Clone, Copy)]
struct Fielded {
    case: Use,
    a: f64,
    b: f64,
}

/// A kernel that returns its input, with a derivative that depends on the field.
#[derive(Clone)]
struct Steep(f64);

impl Rule for Steep {
    fn value<R: Real>(&self, x: &[R]) -> R {
        x[0]
    }
    fn partials<R: Real>(&self, x: &[R], _value: R) -> Vec<R> {
        vec![if self.0 > 3.0 { x[0].sin() } else { x[0].cos() }]
    }
}

#[kernel]
impl Kernel<2, 2> for Fielded {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 2] {
        let Fielded { case, a, b } = *self;
        let (k, l) = (R::lit(a), R::lit(b));
        let branch = |is_true: bool| if is_true { (k * x).sin() } else { k * x };
        let first = match case {
            Use::Values => {
                let chosen = R::select(k.less(x), l, R::zero()).abs();
                k * x - R::lit(-b) * y + chosen * (k + x * x + R::lit(100.0)).sqrt()
            }
            Use::Exponent => x.powi(a as i32),
            Use::Above(bound) => branch(a > bound),
            Use::Order => branch(a < b),
            Use::Both => branch(a > 3.0 && b < 0.0),
            Use::Loop => (0..a as usize).fold(x, |x, _| x.sin()),
            Use::Results => return if a > 1.0 { [x, y] } else { [y, x] },
            Use::Finite => branch(a.is_finite()),
            Use::Halved => R::lit(0.5 * a) * x,
            Use::InRule => apply(Steep(a), &[x]),
        };
        [first, y]
    }
}

const FIELDS: [&str; 2] = ["self.a", "self.b"];

fn build(case: Use) -> impl Fn(&[f64]) -> Fielded {
    move |values| {
        let [a, b] = [values[0], values[1]];
        Fielded { case, a, b }
    }
}

fn emit(case: Use) -> String {
    adjoint("Fielded", &FIELDS, build(case))
}

#[test]
fn a_field_that_is_a_literal_may_have_any_value() {
    let text = emit(Use::Values);
    assert!(text.contains("R::lit(self.a)"), "{text}");
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_field_must_not_decide_the_operations() {
    let of_one = [
        Use::Exponent,
        Use::Above(250.0),
        Use::Above(1e-6),
        Use::Order,
        Use::Loop,
        Use::Results,
        Use::Finite,
    ];
    for case in of_one {
        println!("{case:?}");
        let says = "`self.a` decides the operations of the kernel Fielded";
        assert_refused(says, || emit(case));
    }
    let says = "the fields together decide the operations of the kernel Fielded";
    assert_refused(says, || emit(Use::Both));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_field_must_not_decide_a_literal() {
    let says = "`self.a` decides a literal of the kernel Fielded";
    assert_refused(says, || emit(Use::Halved));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_field_must_not_decide_the_derivative_of_a_fused_function() {
    let says = "a field of the kernel Fielded decides the derivative of a fused function";
    assert_refused(says, || emit(Use::InRule));
}
