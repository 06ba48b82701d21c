//! Emits the adjoint of the kernel, so that no emitted code is checked in or stale.

use autodiff::{Kernel, Real, emit};

#[path = "src/drag.rs"]
mod drag;

use drag::Drag;

/// The build script needs only the formula of the kernel.
impl Kernel<3, 1> for Drag {
    fn eval<R: Real>(&self, x: [R; 3]) -> [R; 1] {
        self.decelerated(x)
    }
}

fn main() {
    let source = emit::adjoint("Drag", &["self.dt"], |fields| Drag { dt: fields[0] });
    let folder = std::env::var("OUT_DIR").expect("cargo sets it");
    std::fs::write(format!("{folder}/drag_adjoint.rs"), source).expect("a folder of this build");
    println!("cargo::rerun-if-changed=src/drag.rs");
}
