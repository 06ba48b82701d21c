//! The tape.

use super::arena::Arena;
use super::current::{self, CONSTANT};
use super::dependence::Dependence;
use super::entries::allocated;
use super::var::Var;
use crate::real::Real;

/// A record of one computation at a time, to be swept in reverse.
///
/// A tape is an ordinary value. You can keep it and record again to reuse its memory, send it to another thread,
/// or nest it (`Tape<Dual<f64, 1>>`, `Tape<Var<f64>>`). Its variables can only be used inside the closure of
/// [`record`](Tape::record).
///
/// An operation takes 24 bytes in f64 and 8 more in a reverse sweep. The memory is freed when the tape is
/// dropped. If the system runs out of memory, the process ends, as with any collection. For long loops use a
/// [`Rollout`](crate::Rollout), whose [`Memory`](crate::Memory) you can limit.
///
/// ```
/// use autodiff::{Real, Tape};
///
/// let mut tape = Tape::new();
/// let y = tape.record(&[3.0, 4.0], |x| x[0].hypot(x[1]));
/// assert_eq!(y.value(), 5.0);
/// assert_eq!(tape.pullback(&[y], &[1.0]), [0.6, 0.8]);
/// ```
///
/// Using a variable of an earlier recording panics:
///
/// ```should_panic
/// use autodiff::Tape;
///
/// let mut tape = Tape::new();
/// let old = tape.record(&[3.0], |x| x[0] * x[0]);
/// tape.record(&[4.0], |x| x[0] + old);
/// ```
pub struct Tape<R: Real> {
    arena: Arena<R>,
    /// The number of `R` within generations, see [`current::name_of`].
    name: u32,
    generation: u32,
    inputs: Vec<Var<R>>,
    bars: Vec<R>,
}

impl<R: Real> Tape<R> {
    /// An empty tape.
    pub fn new() -> Self {
        Tape {
            arena: Arena::new(),
            name: current::name_of::<R>(),
            generation: CONSTANT,
            inputs: Vec::new(),
            bars: Vec::new(),
        }
    }

    /// Replaces the last recording by a recording of `function` at `inputs`, and reuses its memory.
    ///
    /// The variables that `function` returns are only for [`pullback`](Tape::pullback), until the next recording.
    pub fn record<T>(&mut self, inputs: &[R], function: impl FnOnce(&[Var<R>]) -> T) -> T {
        self.arena.restart(inputs.len());
        self.generation = current::next_generation(self.name);
        let generation = self.generation;
        let mut variables = std::mem::take(&mut self.inputs);
        variables.clear();
        variables.extend((0..).zip(inputs).map(|(index, &value)| Var {
            value,
            index,
            generation,
        }));
        let result = current::enter(&mut self.arena, generation, || function(&variables));
        self.inputs = variables;
        result
    }

    /// Returns the cotangents of the inputs, given the cotangents of the outputs:
    /// `sum_i cotangents_i d outputs_i / d inputs` (a VJP). It can be called any number of times after a recording.
    ///
    /// # Panics
    /// If an output belongs to another recording, or the lengths differ.
    pub fn pullback(&mut self, outputs: &[Var<R>], cotangents: &[R]) -> &[R] {
        assert_eq!(
            outputs.len(),
            cotangents.len(),
            "`pullback` needs one cotangent for each output"
        );
        self.bars.clear();
        self.bars.resize(self.arena.entries.len(), R::zero());
        for (output, &cotangent) in outputs.iter().zip(cotangents) {
            if output.is_constant() {
                continue;
            }
            assert!(
                output.generation == self.generation,
                "`pullback` was given a variable of another tape or of an earlier recording; \
                 it needs variables that the last `record` of this tape returned"
            );
            self.bars[output.index as usize] += cotangent;
        }
        self.arena.sweep(&mut self.bars, self.inputs.len());
        &self.bars[..self.inputs.len()]
    }

    /// For each output of the last recording, the inputs that it is computed from, ascending. Inputs with zero
    /// derivatives are included.
    pub(crate) fn dependence(&self, outputs: &[Var<R>]) -> Vec<Vec<usize>> {
        let mut dependence = Dependence::new(&self.arena, self.inputs.len());
        let row = |output: &Var<R>| {
            if output.is_constant() {
                Vec::new()
            } else {
                dependence.of(output.index)
            }
        };
        outputs.iter().map(row).collect()
    }

    /// The number of entries of the last recording, including one for each input.
    pub fn len(&self) -> usize {
        self.arena.entries.len()
    }

    /// Removes the last recording and keeps its memory.
    pub(super) fn forget(&mut self) {
        self.arena.restart(0);
    }

    /// The number of bytes allocated, without the memory that fused entries own.
    pub(super) fn bytes(&self) -> usize {
        self.arena.bytes() + allocated(&self.inputs) + allocated(&self.bars)
    }

    /// Whether nothing is recorded.
    pub fn is_empty(&self) -> bool {
        self.arena.entries.is_empty()
    }
}

impl<R: Real> Default for Tape<R> {
    fn default() -> Self {
        Self::new()
    }
}
