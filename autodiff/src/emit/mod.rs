//! Writes the adjoint of a [`Kernel`], or all its partials, as straight-line Rust.
//!
//! The kernel is run once on the reverse tape over symbols, numbers that note how they were
//! made: the pullback then *is* the formula of the adjoint. What is printed is checked in beside
//! the kernel, and a test compares it with what [`adjoint`] or [`partials`] prints today.
//!
//! A product with a cotangent goes through [`Real::chain`](crate::Real::chain), so that a cotangent
//! of zero passes zero, unless the partial is known to be finite, with its own derivatives, wherever
//! the inputs and all results of the kernel are. It is where it is made of
//!
//! - inputs, fields, finite constants, sums, sines, cosines, hyperbolic tangents and choices;
//! - roots, logarithms and reciprocals of what is at least 1e-12: of a sum of squares and a positive
//!   literal. The sign of a field is not known;
//! - products with what constants bound;
//! - other products where an overflow makes a result infinite or NaN too. Behind a `select`, a
//!   reciprocal or a hyperbolic tangent it may not.
//!
//! Exponentials, powers and other quotients are never taken to be finite. What remains: a product
//! with a constant zero is zero, also where the other factor is NaN, and a choice between constants
//! (`signum`) is one of them; a sum, or a product with what constants bound, of numbers near the
//! largest float; and a result that a sum or product has made infinite, whose cotangent of zero may
//! then pass NaN. Where an emitted derivative is itself differentiated in reverse, a product with a
//! cotangent of zero is an entry of the tape like others, and an infinity that comes back to it makes
//! NaN: see
//! [the conventions](crate::real).

mod graph;
mod known;
mod print;
mod symbol;

use num_traits::One;

use crate::kernel::Kernel;
use crate::reverse::{Tape, Var};
use graph::{GRAPH, Graph, Node, place};
use print::{Formula, Printer};
use symbol::Symbol;

/// An `impl Adjoint` for the kernel type `name`, as Rust source.
///
/// `fields` are the kernel's constants as the printed code reads them (`self.dt`), and `build`
/// makes a kernel whose fields have the given values, in that order.
///
/// # Panics
/// If the kernel computes a literal from a field (`R::lit(2.0 * self.dt)`): the printed code
/// could not follow a change of the field. Such a number belongs into a field of its own. And if
/// it loops for as long as [`Mask::any`](crate::Mask::any) says so, as an
/// [`Element`](crate::Element) that is rounded does: a formula has no values that would end it.
///
/// Work that a kernel skips where no lane wants it, by `any`, is printed as if it were wanted: that is
/// the same by the contract of [`Mask`](crate::Mask). What breaks it, a kernel that computes something
/// else there, is not noticed: [`check_gradient`](crate::check::check_gradient) tells.
pub fn adjoint<K, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: impl Fn(&[f64]) -> K,
) -> String
where
    K: Kernel<I, O>,
{
    let body = body(name, fields, |values, named| {
        let formula = Formula {
            results: Vec::new(),
            ..pulled_back(&build(values))
        };
        let (text, lists) = print(&formula, named);
        text + &lists[0]
    });
    format!(
        "impl Adjoint<{I}, {O}> for {name} {{\n    #[inline(always)]\n    \
         fn vjp<R: Real>(&self, x: [R; {I}], y_bar: [R; {O}]) -> [R; {I}] {{\n{body}    }}\n}}\n"
    )
}

/// An `impl Adjoint` that is given the kernel's results, as Rust source: what they contain, a
/// hyperbolic tangent for example, is not computed again. The arguments are those of [`adjoint`].
///
/// ```
/// use autodiff::{Kernel, Real, emit};
///
/// struct Squash;
/// impl Kernel<1, 1> for Squash {
///     #[inline(always)]
///     fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
///         [x.tanh()]
///     }
/// }
/// let source = emit::adjoint_with_results("Squash", &[], |_| Squash);
/// assert!(source.starts_with("impl Adjoint<1, 1> for Squash"));
/// assert!(!source.contains("tanh"));
/// ```
///
/// # Panics
/// As [`adjoint`].
pub fn adjoint_with_results<K, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: impl Fn(&[f64]) -> K,
) -> String
where
    K: Kernel<I, O>,
{
    let body = body(name, fields, |values, named| {
        let (text, lists) = print(&pulled_back(&build(values)), named);
        text + &lists[0]
    });
    format!(
        "impl Adjoint<{I}, {O}> for {name} {{\n    #[inline(always)]\n    \
         fn vjp_with_results<R: Real>(&self, x: [R; {I}], y: [R; {O}], y_bar: [R; {O}]) \
         -> [R; {I}] {{\n{body}    }}\n}}\n"
    )
}

/// An `impl Partials` for the kernel type `name`, as Rust source: a pullback for every result,
/// and what they share with each other and with the values is computed once. The arguments are
/// those of [`adjoint`].
///
/// ```
/// use autodiff::{Kernel, Real, emit};
///
/// struct Area;
/// impl Kernel<2, 1> for Area {
///     #[inline(always)]
///     fn eval<R: Real>(&self, [width, height]: [R; 2]) -> [R; 1] {
///         [width * height]
///     }
/// }
/// let source = emit::partials("Area", &[], |_| Area);
/// assert!(source.starts_with("impl Partials<2, 1> for Area"));
/// assert!(source.contains("[[x1, x0]]"));
/// ```
///
/// # Panics
/// As [`adjoint`].
pub fn partials<K, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: impl Fn(&[f64]) -> K,
) -> String
where
    K: Kernel<I, O>,
{
    let body = body(name, fields, |values, named| {
        let mut tape = Tape::new();
        let y = record(&build(values), &mut tape, &inputs::<I>(0));
        let mut rows = vec![places(&y.map(Var::value))];
        rows.extend((0..O).map(|o| places(tape.pullback(&y[o..=o], &[Symbol::one()]))));
        let formula = Formula {
            sizes: (I, 0),
            results: Vec::new(),
            rows,
        };
        let (text, lists) = print(&formula, named);
        format!("{text}({}, [{}])", lists[0], lists[1..].join(", "))
    });
    format!(
        "impl Partials<{I}, {O}> for {name} {{\n    #[inline(always)]\n    \
         fn partials<R: Real>(&self, x: [R; {I}]) -> ([R; {O}], [[R; {I}]; {O}]) {{\n{body}    \
         }}\n}}\n"
    )
}

/// The lines of a function, indented: what `print` makes of values for the fields and of the
/// fields' names beside them.
///
/// # Panics
/// If that depends on the values.
fn body(name: &str, fields: &[&str], print: impl Fn(&[f64], &[(&str, f64)]) -> String) -> String {
    // Numbers that no kernel has among its literals.
    let stand_ins = |seed: f64| (1..=fields.len()).map(move |k| (seed + k as f64).sqrt().fract());
    let [text, again] = [std::f64::consts::E, std::f64::consts::PI].map(|seed| {
        let values: Vec<f64> = stand_ins(seed).collect();
        let named: Vec<_> = fields.iter().copied().zip(values.iter().copied()).collect();
        GRAPH.set(Graph::new(&values));
        print(&values, &named)
    });
    assert_eq!(
        text, again,
        "a literal of the kernel {name} depends on a field"
    );
    text.lines()
        .map(|line| format!("        {line}\n"))
        .collect()
}

/// `N` inputs of the formula, from the one numbered `first` on.
fn inputs<const N: usize>(first: usize) -> [Symbol; N] {
    std::array::from_fn(|k| Symbol(place(Node::Input((first + k) as u32))))
}

/// The kernel's results.
fn record<K, const I: usize, const O: usize>(
    kernel: &K,
    tape: &mut Tape<Symbol>,
    x: &[Symbol; I],
) -> [Var<Symbol>; O]
where
    K: Kernel<I, O>,
{
    let y = tape.record(x, |x| kernel.eval(std::array::from_fn::<_, I, _>(|k| x[k])));
    GRAPH.with_borrow_mut(|graph| graph.assume_finite(&places(&y.map(Var::value))));
    y
}

/// The cotangents of a kernel's inputs, its results given.
fn pulled_back<K, const I: usize, const O: usize>(kernel: &K) -> Formula
where
    K: Kernel<I, O>,
{
    let mut tape = Tape::new();
    let (x, y_bar) = (inputs::<I>(0), inputs::<O>(I));
    let y = record(kernel, &mut tape, &x);
    Formula {
        sizes: (I, O),
        results: places(&y.map(Var::value)),
        rows: vec![places(tape.pullback(&y, &y_bar))],
    }
}

fn places(symbols: &[Symbol]) -> Vec<u32> {
    symbols.iter().map(|symbol| symbol.0).collect()
}

/// The statements that compute the rows of a formula, and each row as an array.
fn print(formula: &Formula, fields: &[(&str, f64)]) -> (String, Vec<String>) {
    GRAPH.with_borrow(|graph| Printer::new(graph, formula, fields).print())
}
