//! A program with a kernel whose adjoint the build script has emitted.

use autodiff::arrays::vjp_by_duals;
use autodiff::{Kernel, Pullback, Real};

mod drag;

use drag::Drag;

impl Kernel<3, 1> for Drag {
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; 3]) -> [R; 1] {
        self.decelerated(x)
    }
    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 3, 1, M>) -> [[R; 3]; M] {
        self.emitted_vjp(at)
    }
}

include!(concat!(env!("OUT_DIR"), "/drag_adjoint.rs"));

fn main() {
    let (drag, x) = (Drag { dt: 0.01 }, [2.0, 0.3, 9.81]);
    let at = Pullback::new(&drag, x, [[1.0]]);
    let ([emitted], [expected]) = (drag.vjp(at), vjp_by_duals(&drag, at));
    for (emitted, expected) in emitted.into_iter().zip(expected) {
        assert!(f64::abs(emitted - expected) < 1e-15, "{emitted}, not {expected}");
    }
    println!("the emitted adjoint is that of dual numbers: {emitted:?}");
}
