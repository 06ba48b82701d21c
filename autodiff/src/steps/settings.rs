//! Models and the settings of their rollouts.

use std::sync::Arc;

use super::checkpoints::Memory;
use super::cotangent_bound::CotangentBound;
use super::program::Program;
use crate::real::{ByType, Real};

/// A system that steps. Its step is recorded as a program for any number type. A model must own its data or
/// share them through an `Arc`, because the tape keeps the model.
pub trait Model: Clone + Send + Sync + 'static {
    /// Declares parameters, states, inputs and controls, records one step, and advances every state.
    fn record<R: Real>(&self, program: &mut Program<R>);
    /// [`record`](Self::record) for `f64`. Every crate that uses generic code compiles it again. To compile the
    /// kernels of a model for floats only once, in the crate of the model, override this method and
    /// [`record_f32`](Self::record_f32) there with the same line as the default.
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

/// `steps` steps of a model. [`Rollout::new`] sets defaults; other values are set by name:
/// `Rollout { observed: vec![10, 20], ..Rollout::new(model, 20) }`.
#[derive(Clone, Debug)]
pub struct Rollout<M> {
    /// The system that is stepped.
    pub model: M,
    /// The number of steps.
    pub steps: usize,
    /// The [inputs](Program::input) of all steps, one step after the other. Numbers past the last step are
    /// ignored.
    pub inputs: Arc<[f64]>,
    /// The steps after which the state is observed, in ascending order; 0 is the start.
    pub observed: Vec<usize>,
    /// The indices of the numbers of an observed state that are returned; `None` returns all. On a tape each
    /// returned number is a variable, which costs more than its computation.
    pub entries: Option<Vec<usize>>,
    /// The bound on all numbers of all states after the start, in magnitude; 0 or more. If a number is NaN or
    /// not below the bound, all outputs are NaN, even if the rollout recovers later. Derivatives do not depend
    /// on the bound.
    pub state_bound: Option<f64>,
    /// Clips the cotangent; `None` gives the exact gradient.
    pub cotangent_bound: Option<CotangentBound>,
    /// The memory for the reverse sweep.
    pub memory: Memory,
}

/// A parameter of a batch of rollouts.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a, R> {
    /// The same values for all starts.
    Shared(&'a [R]),
    /// Values for each start. The parameter is an array or a control, not a matrix.
    Each(&'a [&'a [R]]),
}

impl<M: Model> Rollout<M> {
    /// Returns a rollout of `steps` steps without inputs. It observes the whole last state, has no bounds, and
    /// keeps every step for the reverse sweep.
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

    /// Checks the settings that steps rely on, for a step that takes this many inputs.
    pub(super) fn check(&self, inputs: usize) {
        assert!(
            self.observed.is_sorted(),
            "the observed steps of a rollout must ascend: {:?}",
            self.observed
        );
        let last = self.observed.last().copied().unwrap_or(0);
        assert!(
            last <= self.steps,
            "step {last} cannot be observed: the rollout has {} steps",
            self.steps
        );
        let numbers = self.steps.saturating_mul(inputs);
        assert!(
            self.inputs.len() >= numbers,
            "{} steps with {inputs} inputs each need {numbers} numbers: the rollout has {}",
            self.steps,
            self.inputs.len()
        );
        if let Some(bound) = self.state_bound {
            assert!(
                bound >= 0.0,
                "`state_bound` is {bound}; it must be 0 or more"
            );
        }
        if let Some(CotangentBound { norm, every }) = self.cotangent_bound {
            assert!(
                norm >= 0.0 && every > 0,
                "`cotangent_bound` has the norm {norm} and is checked every {every} steps; \
                 the norm must be 0 or more, and the steps 1 or more"
            );
        }
    }
}
