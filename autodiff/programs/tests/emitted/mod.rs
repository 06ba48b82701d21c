//! Emitted derivatives of kernels must be up to date and agree with dual numbers.

use std::array::from_fn;

use autodiff::{Element, Real, Var};
use autodiff_programs::emit::{adjoint, assert_fresh};
use autodiff_programs::kernels::vjp_by_duals;
use autodiff_programs::{Kernel, Memory, Model, Program, Pullback, Rollout, data, kernel};

use crate::common::{Formula, Sym, formula};

mod fields;
mod guarded;
#[rustfmt::skip]
mod written;

use guarded::{Guarded, Held};

const HEADER: &str = "\
//! Derivatives of the kernels, emitted from recordings of them: not to be edited. After a change:
//! `EMIT=1 cargo test -p cosmic-autodiff --test all emitted::`.

use autodiff::Real;

use super::guarded::{Guarded, Held};
use super::Bent;
";

/// A kernel with a field, a square root whose operand may be zero, a result that is an input, and a result that other
/// operations read.
#[derive(Clone, Copy)]
struct Bent {
    stiffness: f64,
}

#[kernel]
impl Kernel<2, 3> for Bent {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 3] {
        let bent = (R::lit(self.stiffness) * x * y).tanh();
        [bent, y, x.abs().sqrt() / (R::one() + bent * bent)]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        self.emitted_vjp(at)
    }
}

/// Wraps a kernel so that its derivatives are computed by dual numbers instead of emitted code.
#[derive(Clone, Copy)]
struct Plain<K>(K);

#[kernel]
impl<K: Kernel<I, O>, const I: usize, const O: usize> Kernel<I, O> for Plain<K> {
    fn eval<R: Real>(&self, x: [R; I], _: &[R]) -> [R; O] {
        self.0.eval(x, &[])
    }
}

#[test]
fn what_is_written_is_up_to_date() {
    let build = |fields: &[f64]| Bent {
        stiffness: fields[0],
    };
    let fields = ["self.stiffness"];
    let parts = [
        adjoint("Bent", &fields, build),
        adjoint("Held", &[], |_| Held),
        adjoint("Guarded", &["self.width"], |f| Guarded { width: f[0] }),
    ];
    assert_fresh("tests/emitted/written.rs", HEADER, &parts);
    // A generated function that gets the results as arguments must not compute them again.
    assert!(!parts[0].contains("tanh"), "{}", parts[0]);
}

const BENT: Bent = Bent { stiffness: 0.8 };

fn assert_close(got: &[f64], expected: &[f64]) {
    for (g, e) in got.iter().zip(expected) {
        // The tolerance is for a few operations in a different order. Infinities must be equal.
        assert!(
            g == e || (g - e).abs() <= 1e-14 * e.abs().min(f64::MAX),
            "{got:?} and {expected:?}"
        );
    }
}

#[test]
fn emitted_partials_are_those_of_duals() {
    // Where the root is zero, both derivatives must be infinite.
    let points: Vec<[f64; 2]> = (0..21)
        .map(|i| [0.25 * f64::from(i) - 2.5, 1.5 - 0.2 * f64::from(i)])
        .collect();
    data::jacobians(
        &BENT,
        points.len(),
        |i| points[i],
        |i, by_x| {
            let identity: [[f64; 3]; 3] = from_fn(|i| from_fn(|j| f64::from(i == j)));
            let at = Pullback::new(&BENT, points[i], &[], identity);
            let rows = vjp_by_duals(&BENT, at);
            for o in 0..3 {
                assert_close(&[by_x.value(o)], &[at.y[o]]);
                assert_close(&by_x.row(o), &rows[o]);
            }
        },
    );
}

/// Operations are written as the methods that compute them. Partials are those of the rules, which other tests check.
#[test]
fn operations_are_written_by_their_names() {
    struct Operation(Formula);
    #[kernel]
    impl Kernel<2, 1> for Operation {
        fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 1] {
            // The partial with respect to `y` is the value of the operation.
            [self.0.values(&[x])[0] * y]
        }
    }
    type Method = fn(Sym) -> Sym;
    let operations: [(&str, Method); 9] = [
        ("exp", |x| x.exp()),
        ("tanh", |x| x.tanh()),
        ("layer_tanh", |x| x.layer_tanh()),
        ("hypot", |x| x.hypot(2.0)),
        ("powi", |x| x.powi(3)),
        ("powf", |x| x.powf(2.5)),
        ("fma", |x| x.fma(x, Sym::lit(1.0))),
        ("detach", |x| x.detach()),
        ("sinh", |x| x.sinh()),
    ];
    for (name, operation) in operations {
        let of_x = formula(1, |x| operation(x[0]));
        let text = adjoint("Operation", &[], |_| Operation(of_x.clone()));
        assert!(text.contains(&format!(".{name}(")), "{name}: {text}");
    }
}

/// At negative zero, the slope must be the limit from inside the domain, as everywhere in this crate. So the emitted
/// formula removes the sign of a zero, unless the operand cannot be negative zero.
#[test]
fn limits_at_negative_zero_are_taken_from_inside() {
    struct LogOf(usize);
    #[kernel]
    impl Kernel<2, 1> for LogOf {
        fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 1] {
            let of = match self.0 {
                0 => x,
                1 => x.sin(),
                2 => x.fma(y, R::one()),
                3 => x * x,
                _ => x.fma(x, R::one()),
            };
            [of.ln()]
        }
    }
    for (of, may_be_negative_zero) in [true, true, true, false, false].into_iter().enumerate() {
        let text = adjoint("LogOf", &[], |_| LogOf(of));
        assert_eq!(text.contains(" + t"), may_be_negative_zero, "{text}");
    }
    /// A kernel in which each sum uses the previous one twice. The emitter must not work out twice what it knows about
    /// a sum, because the work would double with every sum.
    struct Doubled;
    #[kernel]
    impl Kernel<1, 1> for Doubled {
        fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
            [(0..64).fold(x, |sum, _| sum + sum).ln()]
        }
    }
    assert!(adjoint("Doubled", &[], |_| Doubled).contains(".recip()"));
}

/// Where a partial may be infinite, the emitted code must test whether the cotangent is zero. It must do so for the
/// reciprocal of a product that may be close to zero, even if neither of its factors is.
#[test]
fn products_may_come_closer_to_zero_than_their_factors() {
    struct Inverse(f64);
    #[kernel]
    impl Kernel<1, 1> for Inverse {
        fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
            let clear = |least| x * x + R::lit(least * self.0);
            [(clear(1.0) * clear(2.0)).recip()]
        }
    }
    let [clear, close] = [1e-3, 1e-7].map(|least| adjoint("Inverse", &[], |_| Inverse(least)));
    let looked_for = |text: &str| text.matches("chain(").count();
    assert!(looked_for(&close) > looked_for(&clear), "{clear}\n{close}");
}

/// The square root of a sum with a field needs a guard, because the field could make the sum zero, unless the field is
/// promised to be positive.
#[test]
fn a_positive_field_needs_no_guard() {
    struct Softened(f64);
    #[kernel]
    impl Kernel<1, 1> for Softened {
        fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
            [(x * x + R::lit(self.0)).sqrt()]
        }
    }
    let emitted = |field: &str| adjoint("Softened", &[field], |f| Softened(f[0]));
    let [promised, unknown] = ["self.0 > 0", "self.0"].map(emitted);
    let lines = |text: &str| text.lines().count();
    assert!(lines(&promised) < lines(&unknown), "{promised}\n{unknown}");
}

/// The length of a state. It is odd, so that some lanes are left over.
const STATE: usize = 11;

#[derive(Clone)]
struct Steps<K>(K);

impl<K: Kernel<2, 3> + Clone + Sync> Model for Steps<K> {
    fn record(&self, program: &mut Program) {
        let pull = program.parameter(STATE);
        let x = program.state(STATE);
        let [_, _, root] = program.map(self.0.clone(), [x, pull], &[]);
        let [next, _, _] = program.map(self.0.clone(), [root, pull], &[]);
        program.advance(x, next);
    }
}

fn gradient<K: Kernel<2, 3> + Clone + Sync>(kernel: K, memory: Memory) -> Vec<f64> {
    let rollout = Rollout {
        memory,
        ..Rollout::new(Steps(kernel), 9)
    };
    let x: Vec<f64> = (0..2 * STATE).map(|i| 0.4 + 0.05 * i as f64).collect();
    let sum = |x: &[Var<f64>]| {
        let (start, pull) = x.split_at(STATE);
        Var::sum_of(&rollout.run(start, &[pull]))
    };
    autodiff::gradient(sum, &x)
}

#[test]
fn a_program_gives_the_adjoint_the_results_of_its_own_step() {
    let expected = gradient(Plain(BENT), Memory::All);
    assert!(expected.iter().all(|g| *g > 0.0), "{expected:?}");
    for memory in [Memory::All, Memory::States(30)] {
        let got = gradient(BENT, memory);
        for (g, e) in got.iter().zip(&expected) {
            // The tolerance is for eighteen kernels whose operations are rounded in a different order.
            assert!((g - e).abs() <= 1e-13 * e.abs(), "{got:?} and {expected:?}");
        }
    }
}

/// A kernel that rounds its input in a loop with as many steps as the number has bits.
struct Rounded;

#[kernel]
impl Kernel<1, 1> for Rounded {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [num_traits::Float::floor(Element(x)).0 * x]
    }
}

#[test]
#[should_panic(expected = "if it loops until")]
fn a_loop_that_values_end_is_refused() {
    adjoint("Rounded", &[], |_| Rounded);
}
