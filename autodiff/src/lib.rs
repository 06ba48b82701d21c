//! Automatic differentiation behind one trait.
//!
//! Write a function once, generic over [`Real`]. The same source then runs as plain floating
//! point, in SIMD lanes, on dual numbers and on a reverse tape, and so has a value, a derivative
//! along a direction, a gradient, a Jacobian, a Hessian.
//!
//! ```
//! use autodiff::{Function, Real, gradient, gradient_of, hessian, lit};
//!
//! // A closure, for one derivative; floats are constants.
//! let slope = gradient_of(|x| (x[0].powi(2) - 1.0).powi(2) + 0.5 * x[1] * x[1], &[2.0, 3.0]);
//! assert_eq!(slope, [24.0, 3.0]);
//!
//! // A type, for all of them; `lit` makes a constant on either side of an operator.
//! struct Well;
//!
//! impl Function for Well {
//!     fn eval<R: Real>(&self, x: &[R]) -> R {
//!         (x[0].powi(2) - lit(1.0)).powi(2) + lit(0.5) * x[1] * x[1]
//!     }
//! }
//!
//! assert_eq!(gradient(&Well, &[2.0, 3.0]), [24.0, 3.0]);
//! assert_eq!(hessian(&Well, &[2.0, 3.0]), [[44.0, 0.0], [0.0, 1.0]]);
//! ```
//!
//! Every driver takes the function first, then the point, then the rest; its closure form ends in
//! `_of`. A generic function without data needs no type either: `fn well<R: Real>(x: &[R]) -> R` goes
//! to every driver that ends in `_of`, `hessian_of(well, &[2.0, 3.0])`.
//!
//! # Writing a function
//!
//! - In a closure, over [`Var`] or [`Dual`], formulas stand as on paper: `2.0 * x[0] + 1.0`, `&x * &y`,
//!   `x += 0.5`, `x > 0.0`. A number by itself, an argument or a start, is `Var::lit(0.0)`:
//!   `x[0].max(Var::lit(0.0))`. A closure that has a name before it is passed on says what it takes,
//!   `let f = |x: &[_]| …`.
//! - In code over `R: Real` a constant beside an operator is [`lit(9.81)`](lit): `lit(9.81) * x[0]`, where
//!   `9.81 * x[0]` does not compile, because `f32` could not. A constant by itself, as an argument or a
//!   start, is [`R::lit(9.81)`](Real::lit), `R::zero()` or `R::one()`.
//! - What is not differentiated, data and settings, is a field of the type.
//! - Loops, arrays, iterators and helper functions over `R: Real` are plain Rust:
//!   `x.iter().map(|&x| x * x).sum::<R>()`. The sum of a slice is [`R::sum_of(&terms)`](Real::sum_of), a
//!   dot product [`R::dot(&a, &b)`](Real::dot): one entry each on the tape.
//! - A comparison, [`x.less(y)`](Real::less), gives a mask: write `R::select(x.less(y), a, b)`, not
//!   `if x < y`; the [pitfalls](#pitfalls) say why. (For `x < y` the compiler suggests the bound
//!   `PartialOrd`. Do not follow it: an implementation of `eval` cannot add bounds.)
//! - The elementary functions are methods of [`Real`], with [`sigmoid`](Real::sigmoid) and
//!   [`softplus`](Real::softplus) among them; [`custom`] adds others.
//! - Code that is not to be differentiated, a solver or a table, takes floats: [`x.primal()`](Real::primal).
//!   The solution that a solver finds gets its derivatives from [`implicit::root`], as constants
//!   [`R::lits(&found)`](Real::lits).
//!
//! # Traits for functions
//!
//! Each is a type with one generic method to write, because a closure cannot be generic over numbers.
//!
//! | trait | a function | taken by |
//! | --- | --- | --- |
//! | [`Function`], [`VectorFunction`] | of a slice, with one result or several | the drivers: [`gradient`], [`jacobian`], … |
//! | [`Kernel`] | of a few numbers, for each element of some arrays | [`Program::map`], [`data::jacobians`] |
//! | [`Model`] | one time step, of kernels and matrix products over arrays | [`Rollout`] |
//! | [`data::Summand`] | of parameters that all data share and of one datum | [`data::Sum`] |
//! | [`implicit::Residual`] | zero at the solution of equations | [`implicit::root`] |
//! | [`custom::Rule`] | with one result, whose partials you give | [`custom::apply`] |
//! | [`Fused`] | of several slices, whose reverse sweep you write | [`Real::fused`] |
//!
//! [`Parameters`] is for the arguments: nested structs, arrays and matrices of numbers in place of one
//! slice.
//!
//! # Many time steps
//!
//! A plain loop over steps works, but its record on the tape grows with every operation. Where each
//! step does the same, record it once: a [`Kernel`] for what happens to each element of some arrays,
//! a [`Model`] that strings kernels together, a [`Rollout`] that runs them, in lanes and with little
//! memory. The whole rollout is then a single operation of a function.
//!
//! A single small system, such as an ODE of a few numbers, fills no lanes. There a rollout whose kernels have
//! no [emitted](emit) adjoint takes the time of a loop on the tape, and saves memory alone; with an emitted
//! one half of it. By up to some eight parameters a loop over [`Dual`] is the fastest of all.
//!
//! A kernel takes arrays of one length: a parameter that all elements share is an array of one
//! number, which [`Program::gather`] repeats, `program.gather(drag, &[Some(0); BALLS])`. **Mark a
//! kernel's `eval`, and every function that it calls, `#[inline(always)]`**: without it the same
//! numbers take some fifty times as long, for a reason that [`Kernel`] gives. Derivatives are taken by
//! the start and the parameters; a force that differs from step to step is a parameter too, a
//! [control](Program::control).
//!
//! ```
//! use autodiff::{Function, Kernel, Model, Program, Real, Rollout, gradient};
//!
//! /// A step of a thrown ball, with air drag: `[x, y, vx, vy]` at its end from those before.
//! struct Ball;
//!
//! impl Kernel<4, 4> for Ball {
//!     #[inline(always)]
//!     fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
//!         let (dt, drag) = (R::lit(0.01), R::lit(-0.02) * vx.hypot(vy));
//!         let vx = vx + dt * drag * vx;
//!         let vy = vy + dt * (drag * vy - R::lit(9.81));
//!         [x + dt * vx, y + dt * vy, vx, vy]
//!     }
//! }
//!
//! #[derive(Clone)]
//! struct Flight {
//!     balls: usize,
//! }
//!
//! impl Model for Flight {
//!     fn record<R: Real>(&self, program: &mut Program<R>) {
//!         let state = [(); 4].map(|()| program.state(self.balls));
//!         let next = program.map(Ball, state);
//!         for (state, next) in state.into_iter().zip(next) {
//!             program.advance(state, next);
//!         }
//!     }
//! }
//!
//! /// The squared distance from (5, 0) of one ball after a second, given its initial velocity.
//! struct Miss(Rollout<Flight>);
//!
//! impl Function for Miss {
//!     fn eval<R: Real>(&self, v: &[R]) -> R {
//!         let start = [R::zero(), R::zero(), v[0], v[1]];
//!         let end = self.0.run(&start, &[]); // the states observed; no parameters
//!         let dx = end[0] - R::lit(5.0);
//!         dx * dx + end[1] * end[1]
//!     }
//! }
//!
//! let miss = Miss(Rollout::new(Flight { balls: 1 }, 100));
//! let mut v = vec![3.0, 3.0];
//! for _ in 0..100 {
//!     let slope = gradient(&miss, &v);
//!     v = v.iter().zip(slope).map(|(v, slope)| v - 0.4 * slope).collect();
//! }
//! assert!(miss.eval(&v) < 1e-12);
//! ```
//!
//! # Five terms
//!
//! For `y = f(x)` with Jacobian `J`:
//!
//! - the **primal** is the ordinary value, `x` or `y`;
//! - a **tangent** is the rate at which a value changes along a direction of the input: `x_dot`,
//!   `y_dot`;
//! - a **cotangent** is the sensitivity of a later scalar to a value: `y_bar`, `x_bar`;
//! - a **JVP** (Jacobian-vector product) takes a tangent forward, `y_dot = J x_dot`: the derivative
//!   along a direction;
//! - a **VJP** (vector-Jacobian product) takes a cotangent back, `x_bar = J^T y_bar`: with `y` a
//!   scalar and `y_bar = 1`, the gradient.
//!
//! # Which mode when
//!
//! | wanted | take | cost, in evaluations |
//! | --- | --- | --- |
//! | derivative along a direction | [`jvp`] | about 2 |
//! | gradient of one scalar by many arguments | [`gradient`], [`value_and_gradient`] | a few for arrays, tens for scalars on the tape; whatever the number of arguments |
//! | gradient by a handful of arguments | [`gradient_forward`] | 2 to 3 for every four arguments; no tape |
//! | cotangents of several values at once | [`vjp`] | likewise |
//! | all of a Jacobian | [`jacobian`] | forward over arguments or reverse over values, whichever are fewer |
//! | a Jacobian that is mostly zeros | [`sparse_jacobian`] | one direction per colour: 3 for a tridiagonal one of any size |
//! | Hessian times a vector | [`hessian_vector`] | a few gradients |
//! | all of a Hessian | [`hessian`] | that for every four arguments |
//! | a Hessian that is mostly zeros | [`sparse_hessian`] | a gradient's for every colour |
//! | gradient of thousands of time steps | [`Rollout`] of a [`Model`] | a few; memory grows with the state alone |
//! | the same from many starts | [`Rollout::run_batch`] | about half of running them one by one, in lanes over the starts; nine tenths for two starts |
//! | values and gradients of one function at many points | [`data::Recorded`] | recorded once; a few, in lanes over the points |
//! | gradient of a sum over data, of a network's loss for example | [`data::Sum`] | a few, in lanes over the data |
//! | Jacobians of one small function at many points | [`data::jacobians`] | forward over its arguments, in lanes over the points; a few where the kernel's adjoint is emitted ([`emit::adjoint`]) |
//!
//! Three tiers of reverse mode stand behind this, and mix freely:
//!
//! - [`Tape`] and [`Var`] record scalar code of any shape, entry by entry;
//! - [`Real::dot`], [`Real::sum_of`], [`fused::dense`], [`fused::dense_batch`] and every [`Fused`] function are
//!   one entry each;
//! - a [`Program`] records one step over arrays, with [`Kernel`]s mapped over them, and runs it
//!   many times forward and back in lanes.
//!
//! [`custom`] is for a derivative that is known better than the code shows, [`implicit`] for the
//! solution of equations, whatever solver found it. [`check`] tells whether a gradient is right,
//! [`trace`] where a NaN came from, [`DoubleDouble`] what rounding does: it runs the same source in 31
//! digits.
//!
//! Code that asks for num-traits' `Float` takes any number of this crate as an [`Element`].
//!
//! The folder `examples` has short programs, listed in the README: optimisation, least squares, an ODE's
//! parameters by loop, rollout and duals, networks, a logistic regression with the derivative of its
//! optimum, a large sparse system, a loop that depends on values, matrices, nested structs, a contact
//! law with its gradient checked, optimal control and a custom rule.
//!
//! # Pitfalls
//!
//! - **Kinks.** Where no derivative exists, one is chosen, the same in every mode: the table in
//!   [`real`]. It is a convention; an optimiser that sits on a kink gets what the table says.
//! - **Smooth functions of kinks.** Each kink is taken by itself: where two cancel, their derivatives
//!   need not. `ln(1 + e^x)` as it is often written, `x.max(0) + ln(1 + exp(-|x|))`, has the slope
//!   0 at 0, where 1/2 is right: take [`softplus`](Real::softplus). Where there is no such method, choose
//!   by `select` between two smooth forms that agree at the switch.
//! - **Overflow on the way.** `1 / (1 + exp(-x))` is 0 at -800, but its parts are infinite, and their
//!   derivatives NaN: take [`sigmoid`](Real::sigmoid). `1 / (1 / a + 1 / b)` has the slope 1 by `a` at
//!   `a = 0`, but the computed slope is NaN: write `a * b / (a + b)`. In lanes and kernels the computed slope
//!   may be 0 instead. [`check`] finds such a wrong slope; see [zero times infinity](real#zero-times-infinity).
//!
//!   ```
//!   use autodiff::{Real, gradient_of, hessian_of};
//!
//!   assert_eq!(gradient_of(|x| x[0].softplus(), &[0.0]), [0.5]);
//!   assert_eq!(hessian_of(|x| x[0].softplus(), &[0.0]), [[0.25]]);
//!   assert_eq!([-1e3, 1e3].map(|x| gradient_of(|x| x[0].softplus(), &[x])[0]), [0.0, 1.0]);
//!   assert!(gradient_of(|x| x[0].sigmoid(), &[-500.0])[0] > 0.0);
//!   ```
//! - **Units.** Partials are numbers of the same type: where that of `1/x` or `rsqrt(x)` is too small or too
//!   large for it, in `f32` beyond some 1e19, slopes become 0 or infinite though the value is neither.
//! - **`if` on values.** Comparisons look at primals, so the derivative is that of the branch taken,
//!   even at the switch; how the switch itself moves is not part of it. Lanes may
//!   disagree, so generic code computes both sides and [`select`](Real::select)s. The side not
//!   taken passes no derivative, not even an infinite one. Two kinds of condition compile all the
//!   same: `x.is_zero()`, which comes with num-traits' `Zero`, and [`Mask::any`] or [`Mask::all`].
//!   Both answer for all lanes at once, and `is_zero` is false for a variable that happens to be
//!   zero: `if x.is_zero() { 1 } else { sin(x) / x }` gives NaN where one lane is zero and another is
//!   not. Give the side not taken an argument that is safe:
//!
//!   ```
//!   use autodiff::{Function, Real, hessian, value_and_gradient};
//!
//!   struct Sinc;
//!
//!   impl Function for Sinc {
//!       fn eval<R: Real>(&self, x: &[R]) -> R {
//!           let (x, one) = (x[0], R::one());
//!           // The next term of the series, x^4 / 120, is below rounding there.
//!           let small = x.abs().less(R::lit(1e-4));
//!           let safe = R::select(small, one, x);
//!           R::select(small, one - x * x / R::lit(6.0), safe.sin() / safe)
//!       }
//!   }
//!
//!   assert_eq!(value_and_gradient(&Sinc, &[0.0]), (1.0, vec![0.0]));
//!   assert_eq!(hessian(&Sinc, &[0.0]), [[-1.0 / 3.0]]);
//!   ```
//! - **`sqrt` of zero** has an infinite derivative, which turns into NaN at the next zero. The exception
//!   is a zero that a choice made, for example a mask from [`select`](Real::select). Keep lengths away
//!   from it, `sqrt(d.d + eps)`, or use [`Real::hypot`], which is flat there. [`trace::first_non_finite`]
//!   finds the line.
//! - **Aliasing.** Variables are values: `let y = x` is the same variable, not a copy that is
//!   differentiated separately. To hold a quantity fixed, [`detach`](Real::detach) it.
//! - **Exact for the code as written.** That includes its constants, iteration counts and stopping
//!   rules, and is not always the function meant. The derivative of a solver stopped early is that of
//!   the last iterate; [`implicit::root`] has that of the solution.
//! - **Builds without optimisation.** Kernels are compiled into the calling crate, each as one large
//!   function in which, without optimisation, every intermediate has a stack slot of its own: with wide
//!   registers, megabytes of stack. So this crate uses scalars where it is itself built without
//!   optimisation. Where only the dependencies are optimised, by
//!   `[profile.dev.package."*"]`, it cannot tell: set `opt-level = 1` in `[profile.dev]` too.
//! - **Method names.** On plain `f64` the inherent `max`, `clamp`, `signum`, … hide the trait's,
//!   which differ at ties, NaN and zero. Generic code gets the trait's.
//!
//! # Features
//!
//! - `data`, on by default: sums and maps over [`data`] are compiled for floats in this crate. Without it,
//!   this crate compiles in half the time, and each crate that has such a sum compiles 7 s longer;
//! - `derive`: `#[derive(Parameters)]` for structures of [`parameters`];
//! - `nalgebra`: [`Element`] in nalgebra's matrices, module `nalgebra`;
//! - `rayon`: Jacobians and Hessians on several cores, module `parallel`.
//!
//! # Versions
//!
//! Within a version that semantic versioning calls compatible, new methods of [`Real`] come with
//! defaults, and so do new methods of the traits for functions. Errors and results may get new fields
//! and variants. So may settings, [`check::Options`] and [`Rollout`]: make them from their defaults,
//! `Options { seed: 1, ..Options::default() }`.
//!
//! # Misuse
//!
//! A variable used outside its recording, on another thread or with another tape's variables, a slice
//! of the wrong length: these are mistakes in the calling code, and panic with a message that says so.

// Tests of the crate share files with those in `tests`.
#[cfg(test)]
extern crate self as autodiff;

// The order of the modules is the architecture: each uses only those above it.
mod literal;
mod mask;
mod operators;
mod elementary;
mod dual;
pub mod real;
mod constant;
mod rule;
mod math;
pub mod simd;
mod product;
pub mod fused;
mod forward;
mod pool;
mod restored;
mod reverse;
pub mod custom;
pub mod arrays;
mod record;
pub mod steps;
pub mod drivers;
pub mod data;
pub mod parameters;
pub mod interop;
pub mod diagnose;

pub use arrays::{Array, Graph, Kernel, Matrix, Pullback};
pub use constant::lit;
pub use diagnose::{DoubleDouble, check, trace};
#[cfg(feature = "rayon")]
pub use drivers::parallel;
pub use drivers::{
    Dense, Function, VectorFunction, gradient, gradient_forward, gradient_forward_of, gradient_of,
    hessian, hessian_of, hessian_vector, hessian_vector_of, implicit, jacobian, jacobian_of, jvp,
    jvp_of, sparse,
    sparse::{sparse_hessian, sparse_jacobian},
    value_and_gradient, value_and_gradient_of, vjp, vjp_of,
};
pub use dual::Dual;
pub use elementary::Elementary;
pub use interop::Element;
#[cfg(feature = "nalgebra")]
pub use interop::nalgebra;
pub use parameters::Parameters;
pub use real::{Fused, Mask, Real};
pub use record::emit;
pub use reverse::{Tape, Var};
pub use steps::{AnyProgram, CotangentBound, Given, Memory, Model, Program, Rollout};

/// The README's code, compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
