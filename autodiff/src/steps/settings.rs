//! Models and the settings of their rollouts.

use std::sync::Arc;

use super::checkpoints::Memory;
use super::cotangent_bound::CotangentBound;
use super::program::Program;
use crate::real::{ByType, Real};

/// A system that steps: its step is recorded as a program for any number type. It must own its data, or
/// share them by an `Arc`, because the tape keeps it.
pub trait Model: Clone + Send + Sync + 'static {
    /// Declares parameters, states, inputs and controls, records one step and advances every state.
    fn record<R: Real>(&self, program: &mut Program<R>);
    /// [`record`](Self::record) for `f64`. Generic code is compiled by every crate that uses it. A model
    /// for other crates overrides this method and [`record_f32`](Self::record_f32) with the very line of
    /// their defaults: its kernels are then compiled once for floats, in the crate of the model.
    fn record_f64(&self, program: &mut Program<f64>) {
        self.record(program);
    }
    /// [`record`](Self::record) for `f32`; see [`record_f64`](Self::record_f64).
    fn record_f32(&self, program: &mut Program<f32>) {
        self.record(program);
    }
}

/// Records a model by the method for the number type.
pub(super) struct RecordModel<'a, M>(pub(super) &'a M);

impl<'a, M: Model> ByType for RecordModel<'a, M> {
    type Of<R: Real> = &'a mut Program<R>;
    type Output<R: Real> = ();
    fn f64(self, program: &mut Program<f64>) {
        self.0.record_f64(program);
    }
    fn f32(self, program: &mut Program<f32>) {
        self.0.record_f32(program);
    }
    fn other<R: Real>(self, program: &mut Program<R>) {
        self.0.record(program);
    }
}

/// `steps` steps of a model: [`Rollout::new`] has defaults, and the other fields are set by name,
/// `Rollout { observed: vec![10, 20], ..Rollout::new(model, 20) }`.
#[derive(Clone, Debug)]
pub struct Rollout<M> {
    /// The system that is stepped.
    pub model: M,
    /// How many steps.
    pub steps: usize,
    /// The [inputs](Program::input) of all steps, one step after the other; numbers past the last step
    /// are ignored.
    pub inputs: Arc<[f64]>,
    /// After how many steps the state is observed, in ascending order; 0 is the start.
    pub observed: Vec<usize>,
    /// Which numbers of an observed state are returned, by their index in the state; `None` for all. On a
    /// tape each is a variable, which costs more than its computation.
    pub entries: Option<Vec<usize>>,
    /// If any number of any state after the start, observed or not, is NaN or not below this in
    /// magnitude, all outputs are NaN: a rollout that went astray and came back is not taken for a good
    /// one. Derivatives do not depend on it. Not below 0.
    pub state_bound: Option<f64>,
    /// Clips the cotangent; `None` gives the exact gradient.
    pub cotangent_bound: Option<CotangentBound>,
    /// How many states the forward run keeps for the reverse sweep.
    pub memory: Memory,
}

/// A parameter of several rollouts.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a, R> {
    /// One for all of them.
    Shared(&'a [R]),
    /// One for each: an array or a control, not a matrix.
    Each(&'a [&'a [R]]),
}

impl<M: Model> Rollout<M> {
    /// `steps` steps without inputs. The last state is observed, all of it; there are no bounds, and every
    /// step is kept for the reverse sweep.
    pub fn new(model: M, steps: usize) -> Self {
        Self {
            model,
            steps,
            inputs: [].into(),
            observed: vec![steps],
            entries: None,
            state_bound: None,
            cotangent_bound: None,
            memory: Memory::All,
        }
    }

    /// Refuses settings that the steps rely on without checks, given how many inputs a step takes.
    pub(super) fn check(&self, inputs: usize) {
        assert!(
            self.observed.is_sorted(),
            "the observed steps of a rollout ascend"
        );
        let last = self.observed.last().copied().unwrap_or(0);
        assert!(
            last <= self.steps,
            "step {last} of {} is observed",
            self.steps
        );
        let numbers = self.steps.saturating_mul(inputs);
        assert!(
            self.inputs.len() >= numbers,
            "{} steps with {inputs} inputs each take {numbers} numbers: a rollout has {}",
            self.steps,
            self.inputs.len()
        );
        if let Some(bound) = self.state_bound {
            assert!(
                bound >= 0.0,
                "the state of a rollout is bounded by {bound}, which is not 0 or more"
            );
        }
        if let Some(CotangentBound { norm, every }) = self.cotangent_bound {
            assert!(
                norm >= 0.0 && every > 0,
                "the cotangent of a rollout is bounded by {norm} every {every} steps: \
                 it takes a norm of 0 or more, and 1 step or more"
            );
        }
    }
}
