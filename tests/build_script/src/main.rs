//! A kernel whose adjoint the build script has emitted.

use autodiff::{Kernel, Real};

mod drag;

use drag::Drag;

impl Kernel<3, 1> for Drag {
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; 3]) -> [R; 1] {
        self.decelerated(x)
    }
    #[inline(always)]
    fn vjp<R: Real>(&self, x: [R; 3], y_bar: [R; 1]) -> [R; 3] {
        self.emitted_vjp(x, y_bar)
    }
}

include!(concat!(env!("OUT_DIR"), "/drag_adjoint.rs"));

fn main() {
    let (drag, x) = (Drag { dt: 0.01 }, [2.0, 0.3, 9.81]);
    let emitted = drag.vjp(x, [1.0]);
    // By dual numbers, which need nothing emitted.
    let (_, [expected]) = drag.partials(x);
    for (emitted, expected) in emitted.into_iter().zip(expected) {
        assert!(f64::abs(emitted - expected) < 1e-15, "{emitted}, not {expected}");
    }
    println!("the emitted adjoint is that of dual numbers: {emitted:?}");
}
