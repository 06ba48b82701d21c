//! The tape, which records a computation and differentiates it in reverse.

use super::arena::Arena;
use super::current::{self, CONSTANT};
use super::dependence::Dependence;
use super::entries::allocated;
use super::var::Var;
use crate::real::Real;

/// Records a computation and differentiates it in reverse. It holds one recording at a time.
///
/// A tape is an ordinary value. You can reuse its memory by recording again, send it to another thread, or nest it
/// (`Tape<Dual<f64, 1>>`, `Tape<Var<f64>>`). Its variables can only be used inside the closure of
/// [`record`](Tape::record).
///
/// In f64, an operation takes 24 bytes, and 8 more in a reverse sweep. The memory is freed when the tape is dropped. If
/// the system runs out of memory, the process ends, as with any collection. For long loops use a
/// `Rollout` of `autodiff_programs`, whose memory you can limit.
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
    /// The identifier of `R` in generations, see [`current::name_of`].
    name: u32,
    generation: u32,
    inputs: Vec<Var<R>>,
    bars: Vec<R>,
}

impl<R: Real> Tape<R> {
    /// Returns an empty tape.
    #[track_caller]
    pub fn new() -> Self {
        Tape {
            arena: Arena::new(),
            name: current::name_of::<R>(),
            generation: CONSTANT,
            inputs: Vec::new(),
            bars: Vec::new(),
        }
    }

    /// Records `function` at `inputs`. This replaces the last recording and reuses its memory.
    ///
    /// Pass variables that `function` returns to [`pullback`](Tape::pullback), before the next recording. They have no
    /// other use.
    #[track_caller]
    pub fn record<T>(&mut self, inputs: &[R], function: impl FnOnce(&[Var<R>]) -> T) -> T {
        let variables = self.start(inputs);
        let result = current::enter(&mut self.arena, self.generation, || function(&variables));
        self.inputs = variables;
        result
    }

    /// Begins a recording and returns its inputs.
    fn start(&mut self, inputs: &[R]) -> Vec<Var<R>> {
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
        variables
    }

    /// Returns the cotangents of the inputs, given the cotangents of the outputs:
    /// `sum_i cotangents_i d outputs_i / d inputs` (a VJP). It can be called any number of times after a recording.
    ///
    /// # Panics
    /// If an output belongs to another recording, or there is not one cotangent for each output.
    #[track_caller]
    pub fn pullback(&mut self, outputs: &[Var<R>], cotangents: &[R]) -> &[R] {
        assert_eq!(
            outputs.len(),
            cotangents.len(),
            "`pullback` needs one cotangent for each output"
        );
        self.assert_own(outputs);
        self.bars.clear();
        self.bars.resize(self.arena.entries.len(), R::zero());
        for (output, &cotangent) in outputs.iter().zip(cotangents) {
            if output.is_constant() {
                continue;
            }
            self.bars[output.index as usize] += cotangent;
        }
        self.arena.sweep(&mut self.bars, self.inputs.len());
        &self.bars[..self.inputs.len()]
    }

    /// # Panics
    /// If one of the variables belongs to another recording.
    #[track_caller]
    pub(crate) fn assert_own(&self, outputs: &[Var<R>]) {
        let is_own = |output: &Var<R>| output.is_constant() || output.generation == self.generation;
        assert!(
            outputs.iter().all(is_own),
            "`pullback` was given a variable of another tape or of an earlier recording; \
             it needs variables that the last `record` of this tape returned"
        );
    }

    /// For each output of the last recording, returns the inputs that it is computed from, in ascending order. Inputs
    /// with a zero derivative are included.
    ///
    /// # Panics
    /// If an output belongs to another recording.
    #[track_caller]
    pub(crate) fn dependence(&self, outputs: &[Var<R>]) -> Vec<Vec<usize>> {
        self.assert_own(outputs);
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

    /// The number of entries of the last recording. Each input counts as one entry.
    pub fn len(&self) -> usize {
        self.arena.entries.len()
    }

    /// Removes the last recording but keeps its memory.
    pub(super) fn forget(&mut self) {
        self.arena.restart(0);
    }

    /// How many bytes are allocated, not counting the memory that fused entries own.
    pub(super) fn bytes(&self) -> usize {
        self.arena.bytes() + allocated(&self.inputs) + allocated(&self.bars)
    }

    /// Whether the tape has no entries.
    pub fn is_empty(&self) -> bool {
        self.arena.entries.is_empty()
    }
}

impl<R: Real> Default for Tape<R> {
    #[track_caller]
    fn default() -> Self {
        Self::new()
    }
}
