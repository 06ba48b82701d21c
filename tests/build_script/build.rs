//! Generates the adjoint of the kernel at build time. So no generated code is in the repository, and none can be out of
//! date.

use autodiff::Real;
use autodiff_programs::{Kernel, emit, kernel};

#[path = "src/drag.rs"]
mod drag;

use drag::Drag;

/// The kernel without a generated adjoint: the build script only records the formula.
#[kernel]
impl Kernel<3, 1> for Drag {
    fn eval<R: Real>(&self, x: [R; 3], _: &[R]) -> [R; 1] {
        self.decelerated(x)
    }
}

fn main() {
    let source = emit::adjoint("Drag", &["self.dt"], |fields| Drag { dt: fields[0] });
    let folder = std::env::var("OUT_DIR").expect("cargo sets it");
    std::fs::write(format!("{folder}/drag_adjoint.rs"), source).expect("a folder of this build");
    println!("cargo::rerun-if-changed=src/drag.rs");
}
