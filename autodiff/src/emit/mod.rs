//! Writes the adjoint of a [`Kernel`] as straight-line Rust.
//!
//! The kernel is run once on the reverse tape over symbols, numbers that note how they were
//! made: the pullback then *is* the formula of the adjoint. What is printed is checked in beside
//! the kernel, and a test compares it with what [`adjoint`] prints today.
//!
//! A product with a cotangent goes through [`Real::chain`](crate::Real::chain) only where the partial may be
//! infinite: where it comes from a quotient, root or logarithm of something that is not a sum of
//! squares and positive constants.

mod graph;
mod print;
mod symbol;

use crate::kernel::Kernel;
use crate::reverse::Tape;
use graph::{GRAPH, Node, place};
use print::Printer;
use symbol::Symbol;

/// An `impl Adjoint` for the kernel type `name`, as Rust source.
///
/// `fields` are the kernel's constants as the printed code reads them (`self.dt`), and `build`
/// makes a kernel whose fields have the given values, in that order.
///
/// # Panics
/// If the kernel computes a literal from a field (`R::lit(2.0 * self.dt)`): the printed code
/// could not follow a change of the field. Such a number belongs into a field of its own.
pub fn adjoint<K, const I: usize, const O: usize>(
    name: &str,
    fields: &[&str],
    build: impl Fn(&[f64]) -> K,
) -> String
where
    K: Kernel<I, O>,
{
    // Numbers that no kernel has among its literals.
    let stand_ins = |seed: f64| (1..=fields.len()).map(move |k| (seed + k as f64).sqrt().fract());
    let [text, again] = [std::f64::consts::E, std::f64::consts::PI].map(|seed| {
        let values: Vec<f64> = stand_ins(seed).collect();
        let named: Vec<_> = fields.iter().copied().zip(values.iter().copied()).collect();
        body(&build(&values), &named)
    });
    assert_eq!(
        text, again,
        "a literal of the kernel {name} depends on a field"
    );
    let body = text
        .lines()
        .map(|line| format!("        {line}\n"))
        .collect::<String>();
    format!(
        "impl Adjoint<{I}, {O}> for {name} {{\n    #[inline(always)]\n    \
         fn vjp<R: Real>(&self, x: [R; {I}], y_bar: [R; {O}]) -> [R; {I}] {{\n{body}    }}\n}}\n"
    )
}

/// The statements of `vjp` for a kernel whose fields have the values named.
fn body<K, const I: usize, const O: usize>(kernel: &K, fields: &[(&str, f64)]) -> String
where
    K: Kernel<I, O>,
{
    GRAPH.take();
    let input = |k: usize| Symbol(place(Node::Input(k as u32)));
    let x: [Symbol; I] = std::array::from_fn(input);
    let y_bar: [Symbol; O] = std::array::from_fn(|k| input(I + k));
    let mut tape = Tape::new();
    let y = tape.record(&x, |x| {
        kernel.eval(std::array::from_fn::<_, I, _>(|k| x[k]))
    });
    let x_bar: Vec<u32> = tape.pullback(&y, &y_bar).iter().map(|s| s.0).collect();
    GRAPH.with_borrow(|graph| Printer::new(graph, (I, O), fields).print(&x_bar))
}
