//! Rollouts as one fused function.

use super::progress::running;
use super::settings::{Model, Rollout};
use super::sweep::{Recorded, Starts, Stepper};
use crate::real::{Fused, Real};

impl<M: Model> Rollout<M> {
    /// Runs all steps and returns the observed states (or the chosen [`entries`](Rollout::entries) of
    /// each), one after the other.
    ///
    /// `start` is the initial state, its parts one after the other in the order of the model's
    /// declarations; `parameters` are one slice each, in that order too: an array, a matrix row by row, a
    /// [control](crate::Program::control) step by step.
    ///
    /// On the tape the whole rollout is one fused entry.
    ///
    /// # Panics
    /// - If lengths differ from the model's declarations, or the inputs are too few for all steps;
    /// - if an observed step or an entry is out of range, or the observed steps do not ascend;
    /// - if a bound is below 0 or NaN, or checked every 0 steps;
    /// - on a tape, if the [`Memory`](crate::Memory) is too little for a step;
    /// - if the model leaves a part of its state unadvanced, or records what [`Program`](crate::Program) refuses.
    pub fn run<R: Real>(&self, start: &[R], parameters: &[&[R]]) -> Vec<R> {
        let inputs: Vec<&[R]> = std::iter::once(start)
            .chain(parameters.iter().copied())
            .collect();
        R::fused(self.clone(), &inputs)
    }

    /// The places of the returned numbers in a state of `len` numbers, which interleaves `starts` starts.
    fn places(&self, starts: usize, len: usize) -> Vec<usize> {
        let Some(entries) = &self.entries else {
            return (0..len).collect();
        };
        assert!(
            entries.iter().all(|entry| *entry < len / starts),
            "a rollout has {} numbers in a state: the entries {entries:?} are wanted",
            len / starts
        );
        let interleaved = |&entry: &usize| entry * starts..(entry + 1) * starts;
        entries.iter().flat_map(interleaved).collect()
    }

    /// The observed numbers, interleaved for several starts.
    pub(super) fn forward<R: Real>(&self, starts: Starts, inputs: &[&[R]]) -> Vec<R> {
        let _running = running();
        let mut stepper = Stepper::new(self, starts, inputs);
        let mut row = stepper.row(inputs[0]);
        let places = self.places(starts.count, stepper.state_len());
        let (mut seen, mut observed) = (Vec::new(), self.observed.iter().peekable());
        for step in 0..=self.steps {
            while observed.next_if_eq(&&step).is_some() {
                let state = stepper.state(&row);
                seen.extend(places.iter().map(|&i| state[i]));
            }
            if step < self.steps {
                stepper.step_in_place(step, &mut row);
            }
        }
        stepper.apply_state_bound(self.steps, &row, &mut seen);
        seen
    }

    /// [`forward`](Self::forward), and the record for the reverse sweep.
    pub(super) fn recorded<R: Real>(
        &self,
        starts: Starts,
        inputs: &[&[R]],
    ) -> (Vec<R>, Recorded<R>) {
        let _running = running();
        let mut recorded = Recorded::new(self, starts, inputs);
        let places = self.places(starts.count, recorded.state_len());
        let (mut seen, mut observed) = (Vec::new(), self.observed.iter().peekable());
        for step in 0..=self.steps {
            while observed.next_if_eq(&&step).is_some() {
                let state = recorded.state(step);
                seen.extend(places.iter().map(|&i| state[i]));
            }
            if step < self.steps {
                recorded.step(step);
            }
        }
        recorded.apply_state_bound(&mut seen);
        (seen, recorded)
    }

    /// The cotangents of the (interleaved) starts, then of each parameter.
    pub(super) fn reversed<R: Real>(
        &self,
        starts: usize,
        saved: &mut Recorded<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let _running = running();
        let state_len = saved.state_len();
        let places = self.places(starts, state_len);
        let mut seeds = self
            .observed
            .iter()
            .zip(y_bar.chunks_exact(places.len().max(1)))
            .rev()
            .peekable();
        let mut state_bar = vec![R::zero(); state_len];
        let parameter_bars = saved.reverse(wanted, &mut state_bar, |step, state_bar| {
            while let Some((_, seed)) = seeds.next_if(|(at, _)| **at == step) {
                for (&place, &s) in places.iter().zip(seed) {
                    state_bar[place] += s;
                }
            }
            if let Some(bound) = self.cotangent_bound {
                bound.clip(step, starts, state_bar);
            }
        });
        std::iter::once(state_bar).chain(parameter_bars).collect()
    }
}

impl<M: Model> Fused for Rollout<M> {
    type Saved<R: Real> = Recorded<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        self.forward(Starts::ONE, inputs)
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Recorded<R>) {
        self.recorded(Starts::ONE, inputs)
    }

    fn reverse<R: Real>(
        &self,
        saved: &mut Recorded<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        self.reversed(1, saved, y_bar, &wanted[1..])
    }
}
