//! A zero of a kernel's reverse sweep, which runs in lanes, may hide an infinite partial. The table in the section *Zero
//! times infinity* of `kinks.md` in `cosmic-autodiff` says so.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::trace::first_non_finite;
use autodiff::{Function, Real, gradient};
use autodiff_programs::{Kernel, Rollout, kernel};

use crate::steps::Mapped;

#[derive(Clone, Copy)]
struct Reciprocal;

#[kernel]
impl Kernel<1, 1> for Reciprocal {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [x.recip()]
    }
}

struct Twice(Rollout<Mapped<Reciprocal>>);

impl Function for Twice {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.0.run(x, &[])[0]
    }
}

#[test]
fn check_and_trace_find_an_infinity_that_a_zero_hides() {
    let twice = Twice(Rollout::new(Mapped(Reciprocal, 1), 2));
    assert_eq!(gradient(|x| twice.eval(x), &[0.0]), [0.0]);
    let report = check_gradient(&twice, &[0.0], &Options::default());
    assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    let found = first_non_finite(|x| vec![twice.eval(x)], &[0.0]).expect("1 / 0");
    assert_eq!(found.operation, "recip", "{found}");
}

/// The length of a vector of one number.
#[derive(Clone, Copy)]
struct Root;

#[kernel]
impl Kernel<1, 1> for Root {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [(x * x).sqrt()]
    }
}

/// The kernels of a rollout are differentiated by duals, whatever they compute.
#[test]
fn kernels_stop_at_a_computed_zero_as_forward_mode_does() {
    let rollout = Rollout::new(Mapped(Root, 1), 1);
    assert_eq!(gradient(|x| rollout.run(x, &[])[0], &[0.0]), [0.0]);
}
