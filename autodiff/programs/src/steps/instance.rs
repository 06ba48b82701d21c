//! Runs a recorded program, forward and in reverse, with numbers of one type.

use autodiff::Real;
use autodiff::internal::{WIDEST, prefetch};

use super::operation::StepOperation;
use super::program::Program;
use crate::arrays::{Aligned, Array, Bars, Operation, Parameter, RowLayout, StepValues, repeated};

/// Rows are set to zero piece by piece. This is the number of cotangents in a piece.
const ZEROED: usize = 128;

/// A program that runs with numbers of type `R`.
pub(crate) struct Instance<R: Real> {
    /// The declarations. Their operations are in `operations`.
    pub(super) program: Program,
    operations: Vec<Box<dyn Operation<R>>>,
    /// For each parameter, whether each start (initial state) has its own values for it. The method `load` sets it.
    own: Vec<bool>,
    controls: Vec<Control<R>>,
    pub(super) layout: RowLayout,
    /// How many numbers of a later row each operation prefetches. It is a multiple of the length of a cache line.
    prefetch_len: usize,
}

/// The numbers of an array whose values differ from step to step.
struct Control<R> {
    array: Array,
    /// The values: `array.len` numbers for each step, one step after the other.
    values: Vec<R>,
    /// The cotangents in the same order; `None` if they are not needed.
    bars: Option<Vec<R>>,
}

impl<R: Real> Instance<R> {
    /// Ends the recording and decides how rows lie in memory.
    ///
    /// # Panics
    /// If a part of the state was not advanced, or if a kernel must be replayed but cannot be recorded.
    #[track_caller]
    pub(crate) fn new(mut program: Program) -> Self {
        program.assert_advanced();
        let next: Vec<Array> = program.next.iter().copied().flatten().collect();
        let layout = RowLayout::new(&program.states, &next, program.ends[1]);
        let operations = std::mem::take(&mut program.operations).into_iter();
        let operations: Vec<_> = operations.map(StepOperation::compiled).collect();
        let share = layout.stride.div_ceil(operations.len().max(1));
        let control = |&array: &Array| Control {
            array,
            values: Vec::new(),
            bars: None,
        };
        Self {
            prefetch_len: share.next_multiple_of(Aligned::<R>::LINE),
            controls: program.controls.iter().map(control).collect(),
            own: Vec::new(),
            operations,
            layout,
            program,
        }
    }

    /// Returns zeros for the arrays of the parameters, with room for reads past the last array.
    pub(crate) fn parameters(&self) -> Aligned<R> {
        Aligned::zeros(self.program.ends[0] + self.padding())
    }

    /// Returns zeros for the cotangents of the parameters and of a row.
    pub(crate) fn bars(&self) -> [Aligned<R>; 2] {
        [self.parameters(), Aligned::zeros(self.row_len())]
    }

    /// How many numbers beyond the end of the last array an access of a whole register may reach.
    fn padding(&self) -> usize {
        2 * WIDEST * self.program.starts + self.program.margin
    }

    /// How many numbers a step may access, counted from the beginning of its row.
    pub(crate) fn row_len(&self) -> usize {
        self.layout.reach.max(self.program.ends[1]) + self.padding()
    }

    /// The distance from the beginning of one row to the beginning of the next.
    pub(crate) fn stride(&self) -> usize {
        self.layout.stride
    }

    /// The number of scalars in the state, for all starts together.
    pub(crate) fn state_len(&self) -> usize {
        self.program.states.iter().map(|a| a.len).sum()
    }

    /// Loads the parameters of a rollout over `steps` steps and checks their lengths. Where `own` is true, `parameters`
    /// has the values of all starts, interleaved. Other parameters are shared by all starts.
    #[track_caller]
    pub(crate) fn load(
        &mut self,
        values: &mut [R],
        parameters: &[&[R]],
        own: &[bool],
        steps: usize,
    ) {
        let [given, declared] = [parameters.len(), self.program.parameters.len()];
        assert_eq!(
            given, declared,
            "the program has {declared} parameters, but {given} were given"
        );
        self.own = own.to_vec();
        let starts = self.program.starts;
        let all = self.program.parameters.iter().zip(parameters).zip(own);
        for (at, ((declared, given), &own)) in all.enumerate() {
            let given_starts = if own { starts } else { 1 };
            let len = match declared {
                Parameter::Array(a) => a.len(),
                Parameter::Control(k) => steps.saturating_mul(self.controls[*k].array.len()),
                Parameter::Matrix(_) if own => {
                    panic!(
                        "parameter {at} is a matrix, which all starts must share: use `Given::Shared`"
                    )
                }
                Parameter::Matrix(m) => m.len(),
            };
            let over = match declared {
                Parameter::Control(_) => format!(" over {steps} steps"),
                _ => String::new(),
            };
            let numbers = given.len() / given_starts;
            assert_eq!(
                numbers, len,
                "parameter {at} of the program has {len} numbers{over}, but {numbers} were given"
            );
            let times = starts / given_starts;
            match declared {
                Parameter::Array(array) => {
                    values[array.range()].copy_from_slice(&repeated(given, times));
                }
                Parameter::Control(k) => self.controls[*k].values = repeated(given, times),
                Parameter::Matrix(_) => {}
            }
        }
        for operation in &mut self.operations {
            operation.load(parameters);
        }
    }

    /// Marks the arrays that carry derivatives. `parameters` says which parameters do; the state always does.
    pub(crate) fn set_active(&mut self, parameters: &[bool]) {
        let mut active = vec![false; self.program.arrays.len()];
        for (declared, &wanted) in self.program.parameters.iter().zip(parameters) {
            match declared {
                Parameter::Array(a) => active[a.id] = wanted,
                Parameter::Control(k) => {
                    let control = &mut self.controls[*k];
                    active[control.array.id] = wanted;
                    control.bars = wanted.then(|| vec![R::zero(); control.values.len()]);
                }
                Parameter::Matrix(_) => {}
            }
        }
        for state in &self.program.states {
            active[state.id] = true;
        }
        for operation in &mut self.operations {
            let is_active = operation.set_active(&active, parameters);
            for output in operation.outputs() {
                active[output.id] = is_active;
            }
        }
    }

    /// Writes a state into a row.
    pub(crate) fn set_state(&self, row: &mut [R], mut state: &[R]) {
        for part in &self.layout.state {
            let (here, rest) = state.split_at(part.len);
            row[part.range()].copy_from_slice(here);
            state = rest;
        }
    }

    /// Appends the state that is in a row to `to`.
    pub(crate) fn push_state(&self, row: &[R], to: &mut Vec<R>) {
        for part in &self.layout.state {
            to.extend_from_slice(&row[part.range()]);
        }
    }

    /// Writes the inputs and controls of one step into the step's row. `all` holds the inputs of all steps.
    pub(crate) fn set_inputs(&self, row: &mut [R], all: &[f64], step: usize) {
        let Program {
            inputs,
            inputs_len: len,
            starts,
            ..
        } = &self.program;
        let mut given = all[step * len..][..*len].iter();
        for part in inputs {
            let places = row[part.range()].chunks_exact_mut(*starts);
            for (to, &x) in places.zip(&mut given) {
                to.fill(R::lit(x));
            }
        }
        for Control { array, values, .. } in &self.controls {
            row[array.range()].copy_from_slice(&values[step * array.len..][..array.len]);
        }
    }

    /// Stores the cotangents of a step's controls. Call it after the reverse of that step.
    pub(crate) fn note_controls(&mut self, row_bars: &[R], step: usize) {
        for Control { array, bars, .. } in &mut self.controls {
            if let Some(bars) = bars {
                bars[step * array.len..][..array.len].copy_from_slice(&row_bars[array.range()]);
            }
        }
    }

    /// Prefetches a part of a row that will be needed soon. Each operation of a step prefetches another part: if the
    /// whole row were requested at once, the operation's own loads would have to wait.
    #[inline(always)]
    fn prefetch(&self, operation: usize, row: *const R) {
        let first = operation * self.prefetch_len;
        let left = self.layout.stride.saturating_sub(first);
        prefetch(row.wrapping_add(first), self.prefetch_len.min(left));
    }

    /// Computes a step. The new state is written to where the next row begins. `soon` is the row of the next step,
    /// which is prefetched; `None` if the next step uses the same row.
    pub(crate) fn step(&mut self, parameters: &[R], row: &mut [R], soon: Option<*const R>) {
        for k in 0..self.operations.len() {
            if let Some(soon) = soon {
                self.prefetch(k, soon);
            }
            self.operations[k].forward(parameters, row);
        }
        for (from, to) in &self.layout.moves {
            let to = self.layout.stride + to.start;
            if from.parameter {
                row[to..][..from.len].copy_from_slice(&parameters[from.range()])
            } else {
                row.copy_within(from.range(), to)
            }
        }
    }

    /// Moves the new state to the start of the row. Used by rollouts that do not keep their rows.
    pub(crate) fn rewind(&self, row: &mut [R]) {
        let RowLayout { stride, reach, .. } = self.layout;
        row.copy_within(stride..reach, 0);
    }

    /// The index in the state at which the part `part` begins.
    fn place_in_state(&self, part: Array) -> usize {
        let before = self
            .program
            .states
            .iter()
            .take_while(|state| **state != part);
        before.map(|state| state.len).sum()
    }

    /// Computes the reverse of a step from its row. On entry, `state_bar` is the cotangent of the new state. On return,
    /// it is the cotangent of the old state. The step's contribution is added to the cotangents of the parameters.
    /// `soon` is the row of the step before. It is prefetched, because the processor does not predict rows that are
    /// read backwards.
    pub(crate) fn reverse_step(
        &mut self,
        parameters: &[R],
        row: &[R],
        [parameter_bars, row_bars]: &mut [Aligned<R>; 2],
        state_bar: &mut Vec<R>,
        soon: *const R,
    ) {
        let bars = &mut Bars {
            parameters: &mut parameter_bars[..],
            row: &mut row_bars[..],
        };
        // Sets only the cotangents before the next row to zero. The cotangents of the new state, which follow, are set
        // below.
        let RowLayout { stride, state, .. } = &self.layout;
        // The zeros are written in pieces, because `memset` has a longer start-up time for long ranges.
        for piece in bars.row[..self.program.ends[1].min(*stride)].chunks_mut(ZEROED) {
            piece.fill(R::zero());
        }
        if self.layout.moves.is_empty() {
            // The new state is at the beginning of the next row.
            let mut given = &state_bar[..];
            for part in state {
                let (here, rest) = given.split_at(part.len);
                bars.row[stride + part.start..][..part.len].copy_from_slice(here);
                given = rest;
            }
        }
        for (from, to) in &self.layout.moves {
            let given = &state_bar[self.place_in_state(*to)..][..to.len];
            for (bar, &given) in bars.get_mut(*from).iter_mut().zip(given) {
                *bar += given;
            }
        }
        let values = StepValues { parameters, row };
        for k in (0..self.operations.len()).rev() {
            self.prefetch(k, soon);
            self.operations[k].reverse(&values, bars);
        }
        state_bar.clear();
        self.push_state(bars.row, state_bar);
    }

    /// Returns the cotangents of all parameters after the last reverse step. If each start has its own values of a
    /// parameter, the cotangents of that parameter are interleaved. Otherwise they are summed over the starts, from
    /// first to last.
    pub(crate) fn parameter_bars(&mut self, bars: &[R]) -> Vec<Vec<R>> {
        let sum = |of_starts: &[R]| {
            of_starts[1..]
                .iter()
                .fold(of_starts[0], |sum, &bar| sum + bar)
        };
        let of_starts = |own, bars: &[R]| {
            if own {
                bars.to_vec()
            } else {
                bars.chunks_exact(self.program.starts).map(sum).collect()
            }
        };
        let bar = |(declared, &own): (&Parameter, &bool)| match declared {
            Parameter::Array(a) => of_starts(own, &bars[a.range()]),
            Parameter::Matrix(m) => vec![R::zero(); m.len()],
            Parameter::Control(k) => {
                let Control { values, bars, .. } = &self.controls[*k];
                match bars {
                    Some(bars) => of_starts(own, bars),
                    None => {
                        vec![R::zero(); values.len() / if own { 1 } else { self.program.starts }]
                    }
                }
            }
        };
        let declared = self.program.parameters.iter().zip(&self.own);
        let mut all: Vec<Vec<R>> = declared.map(bar).collect();
        for operation in &mut self.operations {
            operation.matrix_bars(&mut all);
        }
        all
    }
}
