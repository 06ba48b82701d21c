//! Writes the adjoint of a [`Kernel`] as straight-line Rust.
//!
//! The kernel runs once on a reverse tape of symbols, which are numbers that record how they were computed. The
//! pullback on this tape then yields the formula of the adjoint. Keep the printed code in the repository beside the
//! kernel, with a test that it is up to date ([`assert_fresh`]).
//!
//! # From a build script
//!
//! A build script can emit the code instead. It needs this crate as one of its `[build-dependencies]`, and the kernel's
//! formula in a file that both your crate and the script include:
//!
//! ```text
//! // build.rs
//! #[path = "src/drag.rs"]
//! mod drag;
//! // … impl Kernel for drag::Drag with only `eval` …
//! let source = emit::adjoint("Drag", &["self.dt"], |fields| Drag { dt: fields[0] });
//! std::fs::write(format!("{folder}/drag_adjoint.rs"), source)?; // folder: OUT_DIR
//!
//! // src/main.rs
//! include!(concat!(env!("OUT_DIR"), "/drag_adjoint.rs"));
//! ```
//!
//! The folder `tests/build_script` of the repository contains an example.
//!
//! # Zero cotangents
//!
//! Each product of a partial and a cotangent goes through [`Real::chain`](autodiff::Real::chain), which returns zero for a
//! cotangent of zero. If possible it is replaced by a plain product, which is faster. This requires that the partial
//! and its derivatives are known to be finite wherever the inputs and all results of the kernel are finite. A partial
//! is known to be finite if it is made of
//!
//! - inputs, fields, finite constants, sums, sines, cosines, hyperbolic tangents and selects;
//! - square roots, logarithms and reciprocals of numbers that are known to be at least 1e-12, such as a sum of squares
//!   and a positive literal (the sign of a field is not known);
//! - products in which one factor is bounded by constants;
//! - other products, if their overflow would also make a result infinite or NaN. This is not known if the product is
//!   only used inside a `select`, a reciprocal or a hyperbolic tangent.
//!
//! Exponentials, powers and other quotients never count as finite. The emitted code can differ from the tape in these
//! cases:
//!
//! - A product with a constant zero is zero, even if the other factor is NaN. The constant may also come from a select
//!   between constants, as in `signum`.
//! - The product of a computed cotangent of zero and an infinite partial is zero. On the tape it is NaN.
//! - A sum, or a product with a bounded factor, may overflow if its operands are near the largest float.
//! - If a sum or product makes a result infinite, NaN may be passed on for a cotangent of zero.
//! - If the emitted derivative is differentiated in reverse, a plain product with a cotangent of zero is an ordinary
//!   entry of the tape. If the cotangent of that product is infinite, the result is NaN; see [the
//!   conventions](autodiff::real).

mod fields;
mod print;

use std::array::from_fn;
use std::f64::consts::{E, PI};

use autodiff::{Tape, Var};
use print::{Adjoint, Printer};

use super::operation::Place;
use super::recording::{Recording, current, record};
use super::symbol::Symbol;
use crate::arrays::Kernel;

/// The end of the expression of a field that is promised to be positive.
const POSITIVE: &str = " > 0";

/// Returns Rust source code with a method `emitted_vjp` for the kernel type `name`. Implement its [`Kernel::vjp`] by
/// calling `self.emitted_vjp(at)`. Numbers that the results `y` already contain, such as a hyperbolic tangent, are not
/// computed again. Numbers that do not depend on the cotangents are computed once for all rows of cotangents.
///
/// `fields` are the expressions with which the printed code reads the kernel's constants (such as `self.dt`). `build`
/// makes a kernel whose fields have the given values, in that order. For a kernel with uniform inputs, `build` makes a
/// [`Fixed`](crate::kernels::Fixed) kernel, and the uniform inputs are fields named `at.uniforms[0]`, `at.uniforms[1]` and so
/// on.
///
/// ```
/// use autodiff::Real;
/// use autodiff_programs::{Kernel, emit, kernel};
///
/// struct Decay {
///     dt: f64,
/// }
/// #[kernel]
/// impl Kernel<2, 1> for Decay {
///     fn eval<R: Real>(&self, [x, rate]: [R; 2], _: &[R]) -> [R; 1] {
///         [x - R::lit(self.dt) * rate * x]
///     }
/// }
/// // Keep this beside the kernel, and test that it stays the same.
/// let source = emit::adjoint("Decay", &["self.dt"], |fields| Decay { dt: fields[0] });
/// assert!(source.contains("fn emitted_vjp<R: Real, const M: usize>"));
/// assert!(source.contains("R::lit(self.dt)"));
/// ```
///
/// Work that a kernel skips if [`Mask::any`](autodiff::Mask::any) is false is always printed. By the contract of
/// [`Mask`](autodiff::Mask), the results are the same. If a kernel breaks this contract, it is not detected here; use
/// [`check_gradient`](autodiff::check::check_gradient).
///
/// # Fields
///
/// A field whose expression ends in ` > 0` (such as `self.softening > 0`) is promised to be positive, and safely away
/// from zero: the code is printed as if it were a positive constant, without guards against a division by it.
///
/// The printed code is used for all values of the fields, so a field must not decide a branch (`if self.k > 1.0`), a
/// loop or an integer exponent (`x.powi(self.n)`). To check this, `build` is called with many values: of both signs,
/// small, large, infinite and NaN. It should create the struct directly, without a constructor that checks its
/// arguments.
///
/// # Panics
/// - If a field decides which operations the kernel does.
/// - If the kernel computes a literal from a field (`R::lit(2.0 * self.dt)`), because the printed code could not follow
///   a change of the field. Make this number a separate field.
/// - If the kernel loops until `any` is false, because for symbols it never is. Rounding an [`Element`](autodiff::Element)
///   does this.
#[track_caller]
pub fn adjoint<K: Kernel<I, O>, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: impl Fn(&[f64]) -> K,
) -> String {
    const {
        assert!(
            K::UNIFORMS == 0,
            "the uniform inputs of an emitted kernel must be `Fixed`"
        );
    }
    fields::check(name, fields, &build);
    // Several runs with different values, of both signs and different sizes. They detect fields that decide the
    // derivative of a fused function. `fields::check` cannot detect these, because it only records `eval`, in which
    // such a derivative does not appear.
    let (few, more) = (
        fields::stand_ins(E, fields.len()),
        fields::stand_ins(PI, fields.len()),
    );
    let mut runs: [Vec<f64>; 4] = [
        few.clone().collect(),
        more.clone().collect(),
        few.map(|value| -37.0 * value).collect(),
        more.map(|value| 1e6 * value).collect(),
    ];
    let is_positive: Vec<bool> = fields.iter().map(|f| f.ends_with(POSITIVE)).collect();
    for run in &mut runs {
        let promised = run.iter_mut().zip(&is_positive).filter(|(_, is)| **is);
        promised.for_each(|(value, _)| *value = value.abs());
    }
    let [text, others @ ..] = runs.map(|values| {
        let names = fields.iter().map(|f| f.trim_end_matches(POSITIVE));
        let named: Vec<_> = names.zip(values.iter().copied()).collect();
        let recording = Recording::simplified(&values, &is_positive);
        let (adjoint, recording) = record(recording, || {
            let kernel = build(&values);
            pulled_back([I, O], |x| {
                kernel.eval(from_fn::<_, I, _>(|k| x[k]), &[]).to_vec()
            })
        });
        Printer::new(&recording, &adjoint, &named).print()
    });
    assert!(
        others.iter().all(|other| *other == text),
        "a field of the kernel {name} decides the derivative of a fused function, but the printed code is the same \
         for all values; write a separate kernel for each case"
    );
    let body: String = text.lines().map(|l| format!("        {l}\n")).collect();
    let signature =
        format!("&self, at: autodiff_programs::Pullback<R, {I}, {O}, M>) -> [[R; {I}]; M]");
    format!(
        "impl {name} {{\n    #[inline(always)]\n    #[allow(clippy::needless_range_loop)]\n    \
         pub(crate) fn emitted_vjp<R: Real, const M: usize>({signature} {{\n{body}    }}\n}}\n"
    )
}

/// Asserts that a source file consists of `header`, an empty line and these methods. If the environment variable `EMIT`
/// is set, writes the file first. A relative path in a test starts at the folder of the package.
///
/// # Panics
/// If the file has another content, or cannot be read or written.
#[track_caller]
pub fn assert_fresh(file: &str, header: &str, methods: &[String]) {
    let emitted = [header, &methods.join("\n")].join("\n");
    if std::env::var_os("EMIT").is_some()
        && let Err(error) = std::fs::write(file, &emitted)
    {
        panic!("{file}: {error}");
    }
    let checked_in = match std::fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) => panic!("{file}: {error}"),
    };
    assert!(
        checked_in == emitted,
        "{file} is out of date, because its kernels have changed; run this test with EMIT=1 to write it again"
    );
}

/// Records the adjoint of code with `inputs` inputs and `outputs` results on a tape of symbols. The cotangents of the
/// results are the inputs of the recording after those of the code.
pub(crate) fn pulled_back(
    [inputs, outputs]: [usize; 2],
    eval: impl FnOnce(&[Var<Symbol>]) -> Vec<Var<Symbol>>,
) -> Adjoint {
    let x: Vec<Symbol> = (0..inputs).map(Symbol::input).collect();
    let y_bar: Vec<Symbol> = (inputs..inputs + outputs).map(Symbol::input).collect();
    let mut tape = Tape::new();
    let y = tape.record(&x, eval);
    let values: Vec<Symbol> = y.iter().map(|y| y.value()).collect();
    let results = places(&values);
    current(|recording| recording.assume_finite(&results));
    Adjoint {
        results,
        x_bar: places(tape.pullback(&y, &y_bar)),
    }
}

/// The places of numbers in the current recording.
pub(crate) fn places(symbols: &[Symbol]) -> Vec<Place> {
    symbols.iter().map(|symbol| symbol.0).collect()
}
