//! [`Fused`] functions on the tape: one call of the function, with an entry for each output.

use smallvec::SmallVec;

use super::current::{self, CONSTANT};
use super::fused_entry::{Call, FusedEntry, Parents, SavedCall};
use super::index::NONE;
use super::var::Var;
use crate::real::{Fused, Real};

/// Implements [`Real::fused`] for variables. Everything that does not depend on the type of the function is in other
/// functions, so that it is not compiled again for every function.
#[track_caller]
pub(super) fn fused<R: Real, F: Fused>(function: F, inputs: &[&[Var<R>]]) -> Vec<Var<R>> {
    let (values, generation) = (all_values(inputs), generation(inputs));
    let values = slices(&values);
    if generation == CONSTANT {
        // Calling `eval` would be wrong, because constants of this tape may carry a derivative of an inner mode.
        return constants(R::fused(function, &values));
    }
    let (outputs, saved) = function.record(&values);
    push(
        inputs,
        generation,
        outputs,
        Box::new(SavedCall { function, saved }),
    )
}

type Values<R> = SmallVec<[Vec<R>; 4]>;

fn all_values<R: Real>(inputs: &[&[Var<R>]]) -> Values<R> {
    let values = |slice: &&[Var<R>]| slice.iter().map(|x| x.value).collect();
    inputs.iter().map(values).collect()
}

fn slices<R>(values: &Values<R>) -> SmallVec<[&[R]; 4]> {
    values.iter().map(Vec::as_slice).collect()
}

/// Returns the common generation of all variables.
#[track_caller]
fn generation<R: Real>(inputs: &[&[Var<R>]]) -> u32 {
    let mut generation = CONSTANT;
    for slice in inputs {
        generation = Var::common_of(slice, generation);
    }
    generation
}

fn constants<R: Real>(outputs: Vec<R>) -> Vec<Var<R>> {
    outputs.into_iter().map(Var::constant).collect()
}

/// Pushes the entries of a call and returns its outputs as variables.
#[track_caller]
fn push<R: Real>(
    inputs: &[&[Var<R>]],
    generation: u32,
    outputs: Vec<R>,
    call: Box<dyn Call<R>>,
) -> Vec<Var<R>> {
    if outputs.is_empty() {
        return Vec::new();
    }
    let entry = FusedEntry {
        call,
        first: NONE,
        outputs: outputs.len(),
        lengths: inputs.iter().map(|slice| slice.len()).collect(),
        wanted: inputs
            .iter()
            .map(|slice| slice.iter().any(|x| !x.is_constant()))
            .collect(),
        parents: inputs
            .iter()
            .map(|slice| Parents::new(slice.iter().map(|x| x.index)))
            .collect(),
    };
    let zero = R::zero();
    // SAFETY: the generation of a `Var<R>` belongs to a recording of `R`. `push_fused` only moves a finished entry, so it
    // runs no code from outside `reverse`.
    #[allow(unsafe_code)]
    let first = unsafe { current::with(generation, |arena| arena.push_fused(entry, zero)) };
    let variable = |(i, value)| Var {
        value,
        index: first + i,
        generation,
    };
    (0..).zip(outputs).map(variable).collect()
}

/// Returns the values of variables. A list of up to eight variables needs no allocation.
pub(super) fn values<R: Real>(numbers: &[Var<R>]) -> SmallVec<[R; 8]> {
    numbers.iter().map(|x| x.value).collect()
}
