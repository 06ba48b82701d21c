//! Printed programs, parsed and checked as a device would.

use crate::program::Every;
use autodiff::{Elementary, Real};
use autodiff_programs::{Kernel, Model, Program};
use cosmic::kernel;
use cosmic_gpu::wgsl::{Options, Printed, print};

/// Parses and checks a text as a device would.
fn check(printed: &Printed) {
    let module = naga::front::wgsl::parse_str(printed.source()).unwrap_or_else(|error| {
        panic!(
            "{}\n{}",
            error.emit_to_string(printed.source()),
            printed.source()
        )
    });
    let (flags, all) = (
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::empty(),
    );
    let checked = naga::valid::Validator::new(flags, all).validate(&module);
    checked.unwrap_or_else(|error| panic!("{}", error.emit_to_string(printed.source())));
}

#[test]
fn every_operation_is_printed() {
    for (common, wanted) in [
        (vec![], vec![]),
        (vec![], (0..8).collect()),
        (vec![4, 5, 6, 7], vec![0, 2]),
        (vec![0, 1, 2, 3, 4, 5, 6, 7], (0..8).collect()),
    ] {
        for workgroup in [4, 64] {
            let options = Options {
                workgroup,
                common: common.clone(),
                wanted: wanted.clone(),
                ..Options::default()
            };
            check(&print(&Every::new(), &options).unwrap());
        }
    }
}

/// Applies an elementary function and powers to every number.
#[derive(Clone)]
struct Applied(Elementary);

#[kernel]
impl Kernel<1, 1> for Applied {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
        [x.elementary(self.0) + x.powi(-3) + x.atan2(2.0) + x.powf(0.5) + x.hypot(1.0) + x.cos()]
    }
}

impl Model for Applied {
    fn record(&self, p: &mut Program) {
        let x = p.state(3);
        let [next] = p.map(self.clone(), [x], &[]);
        p.advance(x, next);
    }
}

#[test]
fn every_function_is_printed() {
    use Elementary::*;
    let all = [
        Asin, Acos, Sinh, Cosh, Asinh, Acosh, Atanh, ExpM1, Ln1p, Log2, Log10, Cbrt, Sinc, Sinhc,
        Sigmoid, Softplus, Xlogx, Erf, Erfc,
    ];
    for function in all {
        check(&print(&Applied(function), &Options::default()).unwrap());
    }
    for function in [LnGamma, Digamma, Trigamma, CotPi] {
        let refused = print(&Applied(function), &Options::default()).unwrap_err();
        assert!(refused.to_string().contains("formula loops"), "{refused}");
    }
}
