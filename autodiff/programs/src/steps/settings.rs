//! Models and the settings of their rollouts.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::checkpoints::Memory;
use super::cotangent_bound::CotangentBound;
use super::program::Program;

/// A dynamical system, whose step is recorded as a program. A model must own its data or share it through an `Arc`,
/// because the tape keeps a clone of the model.
pub trait Model: Send + Sync + 'static {
    /// Declares parameters, states, inputs and controls, records one step, and advances each part of the state.
    fn record(&self, program: &mut Program);
}

impl<M: Model + ?Sized> Model for Arc<M> {
    fn record(&self, program: &mut Program) {
        (**self).record(program);
    }
}

/// A simulation: `steps` steps of a model. [`Rollout::new`] sets defaults. Override them like this:
/// `Rollout { observed: vec![10, 20], ..Rollout::new(model, 20) }`.
#[derive(Clone, Debug)]
pub struct Rollout<M> {
    /// The system that is simulated.
    pub model: M,
    /// The number of steps.
    pub steps: usize,
    /// The [inputs](Program::input) of all steps, one step after the other. Additional numbers are ignored.
    pub inputs: Arc<[f64]>,
    /// The numbers of steps after which the state is observed, in ascending order; 0 stands for the initial state.
    pub observed: Vec<usize>,
    /// The indices of the numbers that are returned of each observed state; `None` returns all numbers. On a tape each
    /// returned number is a variable, which costs more than computing it.
    pub entries: Option<Vec<usize>>,
    /// The bound on the magnitude of every number in every state after the start; 0 or more. If a number is NaN or not
    /// below the bound, all outputs are NaN, even if the rollout recovers later. Derivatives do not depend on the
    /// bound.
    pub state_bound: Option<f64>,
    /// Clips the state's cotangent in the reverse sweep; `None` gives the exact gradient.
    pub cotangent_bound: Option<CotangentBound>,
    /// The units in which the norm of the state's cotangent is compared with the bound: one for each number of the
    /// state of a single start, all above 0. With `None` all units are 1. Numbers of different kinds, such as positions
    /// and velocities, need units for their norm to have a meaning.
    pub cotangent_units: Option<Arc<[f64]>>,
    /// How much memory to use for the reverse sweep.
    pub memory: Memory,
    /// A flag that another thread may set to stop the rollout. The rollout looks at it before every step, forward and in
    /// reverse. Once the flag is set, all steps are left out, and all outputs and all cotangents are NaN.
    pub stop: Option<Arc<AtomicBool>>,
}

/// True if a flag is given and set.
pub(super) fn is_set(flag: &Option<Arc<AtomicBool>>) -> bool {
    // The flag orders no other memory: after the rollout, its caller looks at the flag again.
    (flag.as_ref()).is_some_and(|flag| flag.load(Ordering::Relaxed))
}

/// The values of one parameter in a batch of rollouts.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a, R> {
    /// All starts share the same values.
    Shared(&'a [R]),
    /// Each start has its own values: one slice for each start. The parameter must be an array or a control, not a
    /// matrix.
    Each(&'a [&'a [R]]),
}

impl<M: Model + Clone> Rollout<M> {
    /// Returns a rollout of `steps` steps without inputs. It observes the whole last state, has no bounds, and keeps
    /// every step for the reverse sweep.
    pub fn new(model: M, steps: usize) -> Self {
        Self {
            model,
            steps,
            inputs: [].into(),
            observed: vec![steps],
            entries: None,
            state_bound: None,
            cotangent_bound: None,
            cotangent_units: None,
            memory: Memory::All,
            stop: None,
        }
    }

    /// Returns the settings without the model.
    pub(super) fn without_model(&self) -> Rollout<()> {
        Rollout {
            model: (),
            steps: self.steps,
            inputs: self.inputs.clone(),
            observed: self.observed.clone(),
            entries: self.entries.clone(),
            state_bound: self.state_bound,
            cotangent_bound: self.cotangent_bound,
            cotangent_units: self.cotangent_units.clone(),
            memory: self.memory,
            stop: self.stop.clone(),
        }
    }
}

impl Rollout<()> {
    /// True if another thread asks the rollout to stop.
    pub(super) fn is_stopped(&self) -> bool {
        is_set(&self.stop)
    }

    /// Checks the settings. `inputs` is the number of inputs of a step, `state` the length of a state.
    ///
    /// # Panics
    /// If a setting does not fit the model.
    #[track_caller]
    pub(super) fn check(&self, inputs: usize, state: usize) {
        assert!(
            self.observed.is_sorted(),
            "`observed` is {:?}; the steps must be in ascending order",
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
            "{} steps with {inputs} inputs each need {numbers} numbers, but `inputs` has only {}",
            self.steps,
            self.inputs.len()
        );
        check_bounds(self.state_bound, self.cotangent_bound);
        check_units(self.cotangent_units.as_deref(), state);
        if let Some(entries) = &self.entries {
            assert!(
                entries.iter().all(|&entry| entry < state),
                "the entries are {entries:?}; each must be less than {state}, the length of a state"
            );
        }
    }
}

/// # Panics
/// If a bound is negative or NaN, or [`CotangentBound::every`] is 0.
#[track_caller]
pub fn check_bounds(state: Option<f64>, cotangent: Option<CotangentBound>) {
    if let Some(bound) = state {
        assert!(
            bound >= 0.0,
            "`state_bound` is {bound}; it must be 0 or more"
        );
    }
    if let Some(CotangentBound { norm, every }) = cotangent {
        assert!(
            norm >= 0.0 && every > 0,
            "`cotangent_bound` has `norm` = {norm} and `every` = {every}; \
             `norm` must be 0 or more, and `every` 1 or more"
        );
    }
}

/// # Panics
/// If there are units, but not one for each number of the state.
#[track_caller]
pub fn check_units(units: Option<&[f64]>, state: usize) {
    if let Some(units) = units {
        let count = units.len();
        assert!(
            count == state,
            "`cotangent_units` has {count} numbers; it must have {state}, one for each number of the state"
        );
    }
}
