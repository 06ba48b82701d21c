//! Formulas of single numbers: kernels and their adjoints as lists of operations, for printers.

use autodiff::Var;

use super::emit::{places, pulled_back};
use super::operation::{Op, Place};
use super::recording::{Recording, record};
use super::replayed::ReplayedKernel;
use super::symbol::Symbol;

/// A formula: each operation reads only those before it. A subexpression occurs once, and there are neither dot products
/// nor sums over runs.
#[derive(Debug)]
pub struct Formula {
    /// The operations.
    pub ops: Vec<Op>,
    /// The operations that compute the results.
    pub results: Vec<Place>,
}

impl Formula {
    /// Records code that returns the places of its results.
    fn recorded(code: impl FnOnce() -> Vec<Place>) -> Self {
        let (results, recording) = record(Recording::simplified(&[], &[]), code);
        Self {
            ops: recording.ops,
            results,
        }
    }

    /// A function of one number.
    pub fn of_one(function: impl FnOnce(Symbol) -> Symbol) -> Self {
        Self::recorded(|| vec![function(Symbol::input(0)).0])
    }

    /// The results of a kernel. The inputs of the formula are those of the kernel, then its uniform inputs.
    pub fn of_kernel(of: &ReplayedKernel) -> Self {
        let inputs = of.inputs.len();
        Self::recorded(|| {
            let given = 0..inputs + of.uniforms.len();
            let given: Vec<Symbol> = given.map(Symbol::input).collect();
            places(&of.kernel.evaluate(&given[..inputs], &given[inputs..]))
        })
    }

    /// The cotangents of those inputs and uniform inputs of a kernel that are `wanted`. The inputs of the formula are those
    /// of [`of_kernel`](Self::of_kernel), then the cotangents of the results.
    pub fn of_adjoint(of: &ReplayedKernel, wanted: &[bool]) -> Self {
        let inputs = of.inputs.len();
        let counts = [inputs + of.uniforms.len(), of.outputs.len()];
        Self::recorded(|| {
            let eval = |x: &[Var<Symbol>]| of.kernel.evaluate(&x[..inputs], &x[inputs..]);
            let x_bar = pulled_back(counts, eval).x_bar.into_iter();
            let wanted = x_bar.zip(wanted).filter(|(_, wanted)| **wanted);
            wanted.map(|(x_bar, _)| x_bar).collect()
        })
    }
}
