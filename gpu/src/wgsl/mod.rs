//! Prints the program of a step as WGSL, the shading language of WebGPU, so that a population of simulations runs on a
//! GPU: the forward sweep, and the reverse sweep with all cotangents.
//!
//! This module only makes text. It knows no device: a caller compiles the text with any implementation of WebGPU, fills
//! the buffers and starts the two entry points. A workgroup carries one simulation (a **member** of the population)
//! through many steps, with the numbers of the step in the workgroup's memory.
//!
//! Nothing is written twice for this. Kernels are recorded, and their adjoints are recorded on the reverse tape, as for
//! [`emit`](autodiff_programs::emit). Numbers are single precision. The elementary functions are those of `autodiff`; those of the
//! language have too few digits.
//!
//! ```
//! use autodiff::{Real, lit};
//! use autodiff_programs::{Kernel, Model, Program};
//! use cosmic::kernel;
//! use cosmic_gpu::wgsl::{Options, print};
//!
//! /// A pendulum of length 1, in steps of 0.01 s.
//! struct Swing;
//!
//! #[kernel]
//! impl Kernel<3, 2> for Swing {
//!     fn eval<R: Real>(&self, [angle, speed, gravity]: [R; 3], _: &[R]) -> [R; 2] {
//!         let speed = speed - lit(0.01) * gravity * angle.sin();
//!         [angle + lit(0.01) * speed, speed]
//!     }
//! }
//!
//! #[derive(Clone)]
//! struct Pendulum;
//!
//! impl Model for Pendulum {
//!     fn record(&self, program: &mut Program) {
//!         let gravity = program.parameter(1);
//!         let [angle, speed] = [(); 2].map(|()| program.state(1));
//!         let [next_angle, next_speed] = program.map(Swing, [angle, speed, gravity], &[]);
//!         program.advance(angle, next_angle);
//!         program.advance(speed, next_speed);
//!     }
//! }
//!
//! let printed = print(&Pendulum, &Options::default())?;
//! assert!(printed.source().contains("fn forward("));
//! assert!(printed.source().contains("fn reverse("));
//! assert_eq!(printed.state(), 2);
//! # Ok::<(), cosmic_gpu::wgsl::Refused>(())
//! ```
//!
//! # Differences from a processor
//!
//! A device may fuse or reorder products and sums, flush tiny numbers to zero, and assume that no number is infinite or
//! NaN. A literal that is infinite becomes the largest float. So results agree with those of `f32` within rounding, and
//! repeat bit for bit only on one device.
//!
//! A program with [controls](autodiff_programs::Program::control), with linear equations ([`solve`](autodiff_programs::Program::solve)), or with
//! uniform inputs that are computed in the step and carry derivatives is [refused](Refused). So is a kernel that calls
//! `ln_gamma`, `digamma`, `trigamma` or `cot_pi`.

mod calls;
mod formula;
mod library;
mod memory;
mod printed;
mod writer;
mod printing;
mod kernels;
mod layers;
mod sums;
mod bounds;
mod spill;
mod source;

use autodiff_programs::{Model, Program};

pub use memory::Placed;
pub use printed::{GROUPS_IN_A_ROW, Options, Printed, Refused};

/// Prints the step of a model.
///
/// # Errors
/// If the model has a control or an operation that cannot be printed; see the [module](self).
///
/// # Panics
/// If a kernel cannot be recorded, as a [`Program`] says; if a part of the state is not advanced; and
/// if `options` do not fit the model: an index that is too large, an empty workgroup, no kept step, a negative bound, or
/// not one unit for each number of the state.
#[track_caller]
pub fn print(model: &dyn Model, options: &Options) -> Result<Printed, Refused> {
    let mut program = Program::default();
    model.record(&mut program);
    source::print(&program.parts(), options)
}
