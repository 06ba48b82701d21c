//! The forward run of a rollout and its reverse sweep.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use autodiff::Real;
use autodiff::internal::{begin_step, lanes, pool};

use super::checkpoints::CheckpointSchedule;
use super::instance::Instance;
use super::program::Program;
use super::settings::{Model, Rollout, is_set};
use super::watch::Watch;
use crate::arrays::Aligned;

/// How many starts run interleaved, and which parameters they share.
#[derive(Clone, Copy)]
pub(super) struct Starts<'a> {
    pub(super) count: usize,
    /// For each parameter, whether each start (initial state) has its own values for it.
    pub(super) own: &'a [bool],
}

/// A program together with the values of its parameters and inputs.
pub(super) struct Stepper<R: Real> {
    instance: Instance<R>,
    parameters: Aligned<R>,
    /// The inputs of all steps, one step after the other.
    inputs: Arc<[f64]>,
    /// The check of all states except the start against the rollout's bound; `None` if the rollout has no bound.
    watch: Option<Watch<R>>,
    /// The flag that stops the rollout: while it is set, no step is computed.
    stop: Option<Arc<AtomicBool>>,
}

impl<R: Real> Stepper<R> {
    /// Records the program and loads its numbers. `inputs` are the starts (interleaved if there are several), then the
    /// parameters.
    #[track_caller]
    fn new(rollout: &Rollout<()>, model: &dyn Model, starts: Starts, inputs: &[&[R]]) -> Self {
        let mut program = Program::side_by_side(starts.count, lanes::<R>());
        model.record(&mut program);
        let mut instance = Instance::new(program);
        let state_len = instance.state_len();
        rollout.check(instance.program.inputs_len, state_len / starts.count);
        let mut parameters = instance.parameters();
        let (start, given) = inputs.split_first().expect("input 0 is the initial state");
        assert_eq!(
            start.len(),
            state_len,
            "the start of a rollout has {} numbers, but the model's state has {}",
            start.len() / starts.count,
            state_len / starts.count
        );
        instance.load(&mut parameters, given, starts.own, rollout.steps);
        Self {
            instance,
            parameters,
            inputs: rollout.inputs.clone(),
            watch: rollout.state_bound.map(Watch::new),
            stop: rollout.stop.clone(),
        }
    }

    pub(super) fn state_len(&self) -> usize {
        self.instance.state_len()
    }

    /// Allocates a row that begins with this state.
    pub(super) fn row(&self, state: &[R]) -> Aligned<R> {
        let mut row = Aligned::zeros(self.instance.row_len());
        self.instance.set_state(&mut row, state);
        row
    }

    /// Returns the state that is in a row.
    pub(super) fn state(&self, row: &[R]) -> Vec<R> {
        let mut state = Vec::with_capacity(self.state_len());
        self.instance.push_state(row, &mut state);
        state
    }

    /// Runs a step and prefetches the row `soon`. The new state is written to the beginning of the next row.
    fn step(&mut self, step: usize, row: &mut [R], soon: Option<*const R>) {
        if is_set(&self.stop) {
            return;
        }
        begin_step(step);
        self.instance.set_inputs(row, &self.inputs, step);
        self.instance.step(&self.parameters, row, soon);
        // The old state is checked rather than the new one: loading the new state would have to wait until its stores
        // are done.
        if let (Some(watch), true) = (&mut self.watch, step > 0) {
            watch.look(&self.instance, row);
        }
    }

    /// Replaces the observations of each start that has exceeded the bound in some state by NaN. First checks the last
    /// state, which is at the beginning of `row`; `steps` is its number of steps.
    pub(super) fn apply_state_bound(&self, steps: usize, row: &[R], seen: &mut [R]) {
        let Some(mut watch) = self.watch else {
            return;
        };
        if steps > 0 {
            watch.look(&self.instance, row);
        }
        let verdicts = watch.verdicts(self.instance.program.starts);
        for (seen, verdict) in seen.iter_mut().zip(verdicts.iter().cycle()) {
            *seen = R::select(verdict.finite(), *seen, *verdict);
        }
    }

    /// Runs a step that keeps the new state in the same row.
    pub(super) fn step_in_place(&mut self, step: usize, row: &mut [R]) {
        self.step(step, row, None);
        self.instance.rewind(row);
    }
}

/// A state, and the number of steps that lead from the start to it.
#[derive(Clone)]
struct Checkpoint<R> {
    step: usize,
    state: Vec<R>,
}

/// A forward run, with everything that its reverse sweep needs.
pub(super) struct ForwardRun<R: Real> {
    stepper: Stepper<R>,
    schedule: CheckpointSchedule,
    steps: usize,
    /// The checkpoints from which the reverse sweep runs forward again. The first one is the start.
    checkpoints: Vec<Checkpoint<R>>,
    /// The rows of all steps, one after the other, if memory allows; otherwise the rows of one leaf.
    rows: Aligned<R>,
    /// The row of steps that do not keep their rows: each of these steps overwrites it.
    row: Aligned<R>,
}

impl<R: Real> ForwardRun<R> {
    /// Prepares a forward run. If `keeps` is true, the run keeps what a reverse sweep needs. The other arguments are
    /// those of [`Stepper::new`].
    #[track_caller]
    pub(super) fn new(
        rollout: &Rollout<()>,
        model: &dyn Model,
        starts: Starts,
        inputs: &[&[R]],
        keeps: bool,
    ) -> Self {
        let stepper = Stepper::new(rollout, model, starts, inputs);
        let (stride, row) = (stepper.instance.stride(), stepper.row(inputs[0]));
        let lengths = [stepper.state_len(), stride];
        let schedule = match keeps {
            true => CheckpointSchedule::new::<R>(rollout.memory, rollout.steps, lengths),
            false => CheckpointSchedule::NOTHING,
        };
        let leaf = schedule.leaf.min(rollout.steps);
        let kept = leaf.saturating_sub(1).checked_mul(stride);
        let kept = kept.and_then(|kept| kept.checked_add(row.len()));
        let kept = kept.filter(|kept| *kept < isize::MAX as usize / (2 * size_of::<R>().max(1)));
        let Some(kept) = kept else {
            panic!(
                "the intermediate values of {leaf} steps do not fit into memory; set the rollout's \
                 `memory` to a smaller budget"
            );
        };
        let mut rows = match keeps {
            true => pooled_rows(kept),
            false => Aligned::zeros(kept),
        };
        stepper.instance.set_state(&mut rows, inputs[0]);
        Self {
            checkpoints: vec![Checkpoint {
                step: 0,
                state: inputs[0].to_vec(),
            }],
            steps: rollout.steps,
            schedule,
            rows,
            row,
            stepper,
        }
    }

    pub(super) fn state_len(&self) -> usize {
        self.stepper.state_len()
    }

    /// Calls [`Stepper::apply_state_bound`] after the forward run. Then switches the check off, because the steps that
    /// the reverse sweep repeats need no second check.
    pub(super) fn apply_state_bound(&mut self, seen: &mut [R]) {
        let last = self.row_after(self.steps);
        self.stepper.apply_state_bound(self.steps, last, seen);
        self.stepper.watch = None;
    }

    /// Whether the run keeps the rows of all steps.
    fn keeps_all(&self) -> bool {
        self.schedule.leaf >= self.steps
    }

    /// Returns the row that begins with the state after `step` steps. Only valid during the forward run.
    fn row_after(&self, step: usize) -> &[R] {
        if self.keeps_all() {
            &self.rows[step * self.stepper.instance.stride()..]
        } else {
            &self.row
        }
    }

    /// Returns the state after `step` steps. Only valid during the forward run.
    pub(super) fn state(&self, step: usize) -> Vec<R> {
        self.stepper.state(self.row_after(step))
    }

    /// Runs a step of the forward run. If the rows of all steps are kept, the step gets its own row. Otherwise a
    /// checkpoint of the state before the step is kept if the schedule asks for one.
    pub(super) fn step(&mut self, step: usize) {
        if self.keeps_all() {
            return self.step_to_row(step, step);
        }
        let last = self.checkpoints.last().map_or(0, |last| last.step);
        let held = self.checkpoints.len();
        if self.schedule.split(last..self.steps, held) == Some(step) {
            self.checkpoints.push(self.checkpoint(step));
        }
        self.stepper.step_in_place(step, &mut self.row);
    }

    /// Runs a step in row number `row` of the kept rows, and prefetches the next row.
    fn step_to_row(&mut self, step: usize, row: usize) {
        let (stride, len) = (
            self.stepper.instance.stride(),
            self.stepper.instance.row_len(),
        );
        let row = &mut self.rows[row * stride..];
        let next = row[stride..].as_ptr();
        self.stepper.step(step, &mut row[..len], Some(next));
    }

    /// Returns the state that is in [`row`](Self::row) as a checkpoint.
    fn checkpoint(&self, step: usize) -> Checkpoint<R> {
        Checkpoint {
            step,
            state: self.stepper.state(&self.row),
        }
    }

    /// Sweeps back from the last step to the first and returns the cotangents of the parameters. Calls
    /// `at(step, state_bar)` with the cotangent of the state after `step` steps, for every `step` from the last down to
    /// 0, which stands for the start. `at` may add to the cotangent and clip it.
    pub(super) fn reverse(
        &mut self,
        wanted: &[bool],
        state_bar: &mut Vec<R>,
        mut at: impl FnMut(usize, &mut Vec<R>),
    ) -> Vec<Vec<R>> {
        self.stepper.instance.set_active(wanted);
        let mut bars = self.stepper.instance.bars();
        let mut stack = self.checkpoints.clone();
        let mut end = self.steps;
        at(end, state_bar);
        // Each turn either sets a further checkpoint or reverses the last leaf.
        while end > 0 {
            let top = stack.last().expect("the first checkpoint is never removed");
            let first = self.schedule.leaf_start(top.step..end);
            if let Some(middle) = self.schedule.split(top.step..end, stack.len()) {
                let top = top.clone();
                self.run_again(&top, middle);
                stack.push(self.checkpoint(middle));
                continue;
            }
            if !self.keeps_all() {
                let top = top.clone();
                self.run_again(&top, first);
                let state = self.checkpoint(first).state;
                self.stepper.instance.set_state(&mut self.rows, &state);
                for step in first..end {
                    self.step_to_row(step, step - first);
                }
            }
            self.reverse_rows(first..end, &mut bars, state_bar, &mut at);
            end = first;
            // Drops the checkpoints that are no longer needed: all steps after them are reversed.
            stack.retain(|checkpoint| checkpoint.step < end);
        }
        self.stepper.instance.parameter_bars(&bars[0])
    }

    /// Runs the steps from a checkpoint up to step `to` again, in [`row`](Self::row).
    fn run_again(&mut self, from: &Checkpoint<R>, to: usize) {
        self.stepper.instance.set_state(&mut self.row, &from.state);
        for step in from.step..to {
            self.stepper.step_in_place(step, &mut self.row);
        }
    }

    fn reverse_rows(
        &mut self,
        steps: Range<usize>,
        bars: &mut [Aligned<R>; 2],
        state_bar: &mut Vec<R>,
        at: &mut impl FnMut(usize, &mut Vec<R>),
    ) {
        let stepper = &mut self.stepper;
        let (stride, len) = (stepper.instance.stride(), stepper.instance.row_len());
        for step in steps.clone().rev() {
            if is_set(&stepper.stop) {
                return;
            }
            let place = (step - steps.start) * stride;
            let soon = self.rows[place.saturating_sub(stride)..].as_ptr();
            let row = &self.rows[place..][..len];
            (stepper.instance).reverse_step(&stepper.parameters, row, bars, state_bar, soon);
            stepper.instance.note_controls(&bars[1], step);
            at(step, state_bar);
        }
    }
}

/// Returns a buffer of at least `len` numbers, whose values are arbitrary. Reuses the buffer of the thread's last sweep
/// if it is long enough.
fn pooled_rows<R: Real>(len: usize) -> Aligned<R> {
    match pool::take::<Aligned<R>>() {
        Some(rows) if rows.len() >= len => *rows,
        // Allocates a quarter more than needed, for later sweeps that are longer. Pages that are never touched use no
        // memory.
        _ => Aligned::zeros(len + len / 4),
    }
}

impl<R: Real> Drop for ForwardRun<R> {
    fn drop(&mut self) {
        if self.schedule != CheckpointSchedule::NOTHING {
            let rows = std::mem::replace(&mut self.rows, Aligned::zeros(0));
            pool::keep(Box::new(rows));
        }
    }
}
