//! The two directions of a rollout.

use std::any::Any;
use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use super::memory::Plan;
use super::{Model, Rollout};
use crate::lanes::prefetch;
use crate::program::{Aligned, Program};
use crate::real::Real;

/// A program with the numbers it is running on.
pub(super) struct Sweep<R: Real> {
    program: Program<R>,
    values: Aligned<R>,
    /// The constants of all steps, and those of one as numbers of type `R`.
    constants: Arc<[f64]>,
    inputs: Vec<R>,
}

impl<R: Real> Sweep<R> {
    pub(super) fn new<M: Model>(rollout: &Rollout<M>, inputs: &[&[R]]) -> Self {
        let mut program = Program::default();
        rollout.model.record(&mut program);
        let mut program = program.finish();
        let mut values = program.arena();
        let (start, parameters) = inputs.split_first().expect("a rollout has a start");
        assert_eq!(
            start.len(),
            program.state_len(),
            "the start of a rollout differs in length"
        );
        program.load(&mut values, parameters);
        program.set_state(&mut values, start);
        Self {
            constants: rollout.inputs.clone(),
            inputs: vec![R::zero(); program.input_len()],
            program,
            values,
        }
    }

    pub(super) fn state_len(&self) -> usize {
        self.program.state_len()
    }

    /// Appends the state.
    pub(super) fn push_state(&self, to: &mut Vec<R>) {
        self.program.push_state(&self.values, to);
    }

    /// Does a step; its row (the state before it, then what the program keeps) is appended where
    /// rows are wanted.
    pub(super) fn step(&mut self, step: usize, mut rows: Option<&mut Vec<R>>) {
        R::mark_step(step);
        self.set_inputs(step);
        if let Some(rows) = &mut rows {
            self.program.push_state(&self.values, rows);
        }
        self.program.step(&mut self.values);
        if let Some(rows) = rows {
            self.program.push_kept(&self.values, rows);
        }
    }

    fn set_inputs(&mut self, step: usize) {
        let len = self.inputs.len();
        for (to, &from) in self
            .inputs
            .iter_mut()
            .zip(&self.constants[step * len..][..len])
        {
            *to = R::lit(from);
        }
        self.program.set_inputs(&mut self.values, &self.inputs);
    }

    /// The reverse of a step, from its row.
    fn reverse_step(&mut self, step: usize, row: &[R], bars: &mut [R], state_bar: &mut Vec<R>) {
        let (state, kept) = row.split_at(self.state_len());
        self.program.set_state(&mut self.values, state);
        self.program.set_kept(&mut self.values, kept);
        self.set_inputs(step);
        self.program.reverse_step(&mut self.values, bars, state_bar);
    }
}

/// A state and how many steps were done before it.
#[derive(Clone)]
struct Snapshot<R> {
    step: usize,
    state: Vec<R>,
}

/// What the forward run leaves for the reverse sweep.
pub struct Recorded<R: Real> {
    sweep: Sweep<R>,
    plan: Plan,
    steps: usize,
    /// States from which the reverse sweep runs forward again; the start is the first.
    snapshots: Vec<Snapshot<R>>,
    /// The rows of the last steps run, one after the other; of all of them where memory allows.
    rows: Vec<R>,
}

impl<R: Real> Recorded<R> {
    pub(super) fn new<M: Model>(rollout: &Rollout<M>, inputs: &[&[R]]) -> Self {
        let sweep = Sweep::new(rollout, inputs);
        let row = sweep.state_len() + sweep.program.kept_len();
        let plan = Plan::new(rollout.memory, rollout.steps, [sweep.state_len(), row]);
        Self {
            rows: spare_rows(plan.leaf.min(rollout.steps) * row),
            snapshots: vec![Snapshot {
                step: 0,
                state: inputs[0].to_vec(),
            }],
            steps: rollout.steps,
            plan,
            sweep,
        }
    }

    pub(super) fn sweep(&self) -> &Sweep<R> {
        &self.sweep
    }

    /// A step of the first run forward: keeps its row, or now and then a snapshot.
    pub(super) fn step(&mut self, step: usize) {
        if self.plan.leaf >= self.steps {
            return self.sweep.step(step, Some(&mut self.rows));
        }
        let last = self.snapshots.last().map_or(0, |snapshot| snapshot.step);
        if self.plan.split(last..self.steps, self.snapshots.len()) == Some(step) {
            self.snapshots.push(self.snapshot(step));
        }
        self.sweep.step(step, None);
    }

    fn snapshot(&self, step: usize) -> Snapshot<R> {
        let mut state = Vec::with_capacity(self.sweep.state_len());
        self.sweep.push_state(&mut state);
        Snapshot { step, state }
    }

    /// Goes back from the last step to the first. `at` sees the state's cotangent after the
    /// steps' number given, first after all, last at the start; returns the parameters'.
    pub(super) fn reverse(
        &mut self,
        wanted: &[bool],
        state_bar: &mut Vec<R>,
        mut at: impl FnMut(usize, &mut Vec<R>),
    ) -> Vec<Vec<R>> {
        self.sweep.program.set_active(wanted);
        let mut bars = self.sweep.program.arena();
        let kept = self.plan.leaf >= self.steps;
        let mut stack = self.snapshots.clone();
        let mut end = self.steps;
        at(end, state_bar);
        while end > 0 {
            let top = stack.last().expect("the start is below all");
            let first = self.plan.leaf_start(top.step..end);
            if let Some(middle) = self.plan.split(top.step..end, stack.len()) {
                let top = top.clone();
                self.run_again(&top, middle);
                stack.push(self.snapshot(middle));
                continue;
            }
            if !kept {
                let top = top.clone();
                self.run_again(&top, first);
                self.rows.clear();
                for step in first..end {
                    self.sweep.step(step, Some(&mut self.rows));
                }
            }
            self.reverse_rows(first..end, &mut bars, state_bar, &mut at);
            end = first;
            while stack.last().is_some_and(|snapshot| snapshot.step >= end) {
                stack.pop();
            }
        }
        self.sweep.program.parameter_bars(&bars)
    }

    /// Steps on from a snapshot.
    fn run_again(&mut self, from: &Snapshot<R>, to: usize) {
        self.sweep
            .program
            .set_state(&mut self.sweep.values, &from.state);
        for step in from.step..to {
            self.sweep.step(step, None);
        }
    }

    fn reverse_rows(
        &mut self,
        steps: Range<usize>,
        bars: &mut [R],
        state_bar: &mut Vec<R>,
        at: &mut impl FnMut(usize, &mut Vec<R>),
    ) {
        let row = self.rows.len() / steps.len();
        for step in steps.clone().rev() {
            let place = (step - steps.start) * row;
            // Memory is read backwards here, which the processor does not foresee.
            prefetch(&self.rows[place.saturating_sub(2 * row)..][..row]);
            self.sweep
                .reverse_step(step, &self.rows[place..][..row], bars, state_bar);
            at(step, state_bar);
        }
    }
}

thread_local! {
    /// Rows that are done with, for the thread's next sweep: to have fresh pages from the system
    /// costs as much as a quarter of it.
    static SPARE: RefCell<Option<Box<dyn Any>>> = const { RefCell::new(None) };
}

/// No rows, with room for so many numbers.
fn spare_rows<R: Real>(len: usize) -> Vec<R> {
    let spare = SPARE.with_borrow_mut(Option::take);
    let mut rows = spare
        .and_then(|s| s.downcast().ok())
        .map_or_else(Vec::new, |s| *s);
    rows.reserve_exact(len);
    rows
}

impl<R: Real> Drop for Recorded<R> {
    fn drop(&mut self) {
        let mut rows = std::mem::take(&mut self.rows);
        rows.clear();
        // At the end of a thread there may be nowhere to put it.
        let _ = SPARE.try_with(|spare| spare.replace(Some(Box::new(rows))));
    }
}
