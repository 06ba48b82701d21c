//! A trace names the step and the line of a kernel's operation.

use autodiff::Real;
use autodiff::trace::first_non_finite;
use autodiff_programs::{Kernel, Rollout, kernel};

use crate::steps::Mapped;

/// The change of a number that falls, until the square root of a negative number is taken.
#[derive(Clone, Copy)]
struct Fall;
#[kernel]
impl Kernel<1, 1> for Fall {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [x.sqrt() - R::lit(0.5)]
    }
}

/// The line of the root in [`Fall`].
const ROOT: u32 = line!() - 5;

#[test]
fn a_rollout_reports_the_step() {
    let rollout = Rollout::new(Mapped(Fall, 1), 9);
    let mut x: f64 = 1.0;
    let mut step = 0;
    while x >= 0.0 {
        x = x.sqrt() - 0.5;
        step += 1;
    }
    let found = first_non_finite(|x| rollout.run(x, &[]), &[1.0]).expect("a root of less than 0");
    assert_eq!((found.operation, found.step), ("sqrt", Some(step)));
    assert!(
        found.to_string().contains(&format!("in step {step}: of -")),
        "{found}"
    );
    assert_eq!((found.place.file(), found.place.line()), (file!(), ROOT));
}

#[test]
fn operations_after_a_rollout_have_no_step() {
    let rollout = Rollout::new(Mapped(Fall, 1), 2);
    let found = first_non_finite(
        |x| {
            let end = rollout.run(x, &[])[0];
            vec![(end - end).sqrt()]
        },
        &[1.0],
    );
    let found = found.expect("a root of 0");
    assert_eq!((found.operation, found.step), ("sqrt", None));
}
