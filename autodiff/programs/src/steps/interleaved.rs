//! Runs one start or several interleaved starts forward, and sweeps back.

use autodiff::Real;
use autodiff::internal::running;

use super::settings::{Model, Rollout};
use super::sweep::{ForwardRun, Starts};

impl Rollout<()> {
    /// Returns the positions, within an observed state, of the numbers that the rollout returns. The state has `len`
    /// numbers, in which `starts` starts are interleaved.
    fn places(&self, starts: usize, len: usize) -> Vec<usize> {
        let Some(entries) = &self.entries else {
            return (0..len).collect();
        };
        let interleaved = |&entry: &usize| entry * starts..(entry + 1) * starts;
        entries.iter().flat_map(interleaved).collect()
    }

    /// Runs all steps. Returns the observed numbers, interleaved if there are several starts, and the forward run that
    /// the reverse sweep needs. If `keeps` is false, no reverse sweep follows and no steps are kept.
    #[track_caller]
    pub(super) fn recorded<R: Real>(
        &self,
        model: &dyn Model,
        starts: Starts,
        inputs: &[&[R]],
        keeps: bool,
    ) -> (Vec<R>, ForwardRun<R>) {
        let _running = running();
        let mut run = ForwardRun::new(self, model, starts, inputs, keeps);
        let places = self.places(starts.count, run.state_len());
        let (mut seen, mut observed) = (Vec::new(), self.observed.iter().peekable());
        for step in 0..=self.steps {
            while observed.next_if_eq(&&step).is_some() {
                let state = run.state(step);
                seen.extend(places.iter().map(|&i| state[i]));
            }
            if step < self.steps {
                run.step(step);
            }
        }
        run.apply_state_bound(&mut seen);
        if self.is_stopped() {
            seen.fill(R::lit(f64::NAN));
        }
        (seen, run)
    }

    /// Returns the cotangents of the initial states, then the cotangents of each parameter. The numbers of several initial
    /// states are interleaved.
    pub(super) fn reversed<R: Real>(
        &self,
        starts: usize,
        saved: &mut ForwardRun<R>,
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
                bound.clip(step, starts, self.cotangent_units.as_deref(), state_bar);
            }
        });
        let mut bars: Vec<Vec<R>> = std::iter::once(state_bar).chain(parameter_bars).collect();
        if self.is_stopped() {
            bars.iter_mut().for_each(|bars| bars.fill(R::lit(f64::NAN)));
        }
        bars
    }
}
