//! Rollouts: stepping a [`Program`] many times, and the reverse sweep through all of it.
//!
//! The forward run keeps every state (and the few arrays that a program marks as kept); the
//! reverse sweep goes back one step at a time and computes the rest of that step again, so that
//! the record of a step never leaves the cache. Memory: `steps * (state + kept)` numbers.

use std::any::Any;
use std::cell::RefCell;
use std::sync::Arc;

use crate::fused::Fused;
use crate::lanes::prefetch;
use crate::program::{Aligned, Program};
use crate::real::Real;

/// A system that steps: its step is recorded as a program for any number type.
pub trait Model: Clone + Send + Sync + 'static {
    /// Declares parameters, states and inputs, records one step and advances every state.
    fn record<R: Real>(&self, program: &mut Program<R>);
}

/// A bound on the norm of the state's cotangent in the reverse sweep: where it is exceeded, the
/// cotangent is scaled back. The result is then no longer the exact gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CotangentBound {
    /// The largest Euclidean norm.
    pub norm: f64,
    /// It is looked at every so many steps.
    pub every: usize,
}

/// `steps` steps of a model.
#[derive(Clone, Debug)]
pub struct Rollout<M> {
    /// What is stepped.
    pub model: M,
    /// How many steps.
    pub steps: usize,
    /// The inputs of the steps, one step after the other: `steps * inputs` numbers at least.
    pub inputs: Arc<[f64]>,
    /// After how many steps the state is wanted, ascending; 0 is the start.
    pub observed: Vec<usize>,
    /// `None`, the default of all drivers, gives the exact gradient.
    pub cotangent_bound: Option<CotangentBound>,
}

impl<M: Model> Rollout<M> {
    /// The observed states one after the other, from the parts of the start's state and the
    /// parameters in the order of the model's declarations.
    ///
    /// On the tape the whole rollout is one entry.
    ///
    /// # Panics
    /// If lengths differ from the model's declarations or an observed step is out of range.
    pub fn run<R: Real>(&self, start: &[R], parameters: &[&[R]]) -> Vec<R> {
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
        let inputs: Vec<&[R]> = std::iter::once(start)
            .chain(parameters.iter().copied())
            .collect();
        R::fused(self.clone(), &inputs)
    }

    fn forward<R: Real>(&self, sweep: &mut Sweep<R>, mut keep: Option<&mut Vec<R>>) {
        let mut constants = Constants::new(&self.inputs, sweep.program.input_len());
        let mut observed = self.observed.iter().peekable();
        for step in 0..=self.steps {
            while observed.next_if(|&&at| at == step).is_some() {
                sweep.program.push_state(&sweep.values, &mut sweep.observed);
            }
            if step == self.steps {
                break;
            }
            sweep
                .program
                .set_inputs(&mut sweep.values, constants.of(step));
            if let Some(history) = &mut keep {
                sweep.program.push_state(&sweep.values, history);
            }
            sweep.program.step(&mut sweep.values);
            if let Some(history) = &mut keep {
                sweep.program.push_kept(&sweep.values, history);
            }
        }
    }

    /// Scales the state's cotangent back where the bound asks for it.
    fn bound<R: Real>(&self, step: usize, state_bar: &mut [R]) {
        let Some(CotangentBound { norm, every }) = self.cotangent_bound else {
            return;
        };
        if !step.is_multiple_of(every) {
            return;
        }
        let squared = R::dot(state_bar, state_bar).detach();
        let limit = R::lit(norm);
        let exceeds = (limit * limit).lt(squared);
        let factor = R::select(exceeds, limit * squared.rsqrt(), R::one());
        for bar in state_bar {
            *bar *= factor;
        }
    }
}

/// A program with the numbers it is running on.
struct Sweep<R: Real> {
    program: Program<R>,
    values: Aligned<R>,
    observed: Vec<R>,
}

impl<R: Real> Sweep<R> {
    fn new<M: Model>(model: &M, inputs: &[&[R]]) -> Self {
        let mut program = Program::default();
        model.record(&mut program);
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
            program,
            values,
            observed: Vec::new(),
        }
    }
}

/// The constants of one step, as numbers of type `R`.
struct Constants<'a, R> {
    all: &'a [f64],
    current: Vec<R>,
}

impl<'a, R: Real> Constants<'a, R> {
    fn new(all: &'a [f64], len: usize) -> Self {
        Self {
            all,
            current: vec![R::zero(); len],
        }
    }

    fn of(&mut self, step: usize) -> &[R] {
        let len = self.current.len();
        for (to, &from) in self.current.iter_mut().zip(&self.all[step * len..][..len]) {
            *to = R::lit(from);
        }
        &self.current
    }
}

/// What the forward run leaves for the reverse sweep.
pub struct Recorded<R: Real> {
    sweep: Sweep<R>,
    /// Per step: the state before it, then what the program keeps.
    history: Vec<R>,
}

thread_local! {
    /// A history that is done with, for the thread's next one: to have fresh pages from the
    /// system costs as much as a quarter of the sweep.
    static SPARE: RefCell<Option<Box<dyn Any>>> = const { RefCell::new(None) };
}

/// An empty history with room for so many numbers.
fn history<R: Real>(len: usize) -> Vec<R> {
    let spare = SPARE.with_borrow_mut(Option::take);
    let mut history = spare
        .and_then(|s| s.downcast().ok())
        .map_or_else(Vec::new, |s| *s);
    history.reserve_exact(len);
    history
}

impl<R: Real> Drop for Recorded<R> {
    fn drop(&mut self) {
        let mut history = std::mem::take(&mut self.history);
        history.clear();
        // At the end of a thread there may be nowhere to put it.
        let _ = SPARE.try_with(|spare| spare.replace(Some(Box::new(history))));
    }
}

impl<M: Model> Fused for Rollout<M> {
    type Saved<R: Real> = Recorded<R>;

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        let mut sweep = Sweep::new(&self.model, inputs);
        self.forward(&mut sweep, None);
        sweep.observed
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Recorded<R>) {
        let mut sweep = Sweep::new(&self.model, inputs);
        let row = sweep.program.state_len() + sweep.program.kept_len();
        let mut history = history(self.steps * row);
        self.forward(&mut sweep, Some(&mut history));
        (
            std::mem::take(&mut sweep.observed),
            Recorded { sweep, history },
        )
    }

    fn reverse<R: Real>(
        &self,
        saved: &mut Recorded<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let Recorded {
            sweep: Sweep {
                program, values, ..
            },
            history,
        } = saved;
        program.set_active(&wanted[1..]);
        let mut constants = Constants::new(&self.inputs, program.input_len());
        let mut bars = program.arena();
        let state_len = program.state_len();
        let row = state_len + program.kept_len();
        let mut seeds = self
            .observed
            .iter()
            .zip(y_bar.chunks_exact(state_len))
            .rev()
            .peekable();
        let mut state_bar = vec![R::zero(); state_len];
        for step in (0..=self.steps).rev() {
            if step < self.steps {
                // Memory is read backwards here, which the processor does not foresee.
                prefetch(&history[step.saturating_sub(2) * row..][..row]);
                let (state, kept) = history[step * row..][..row].split_at(state_len);
                program.set_state(values, state);
                program.set_kept(values, kept);
                program.set_inputs(values, constants.of(step));
                program.reverse_step(values, &mut bars, &mut state_bar);
            }
            while let Some((_, seed)) = seeds.next_if(|(at, _)| **at == step) {
                for (bar, &s) in state_bar.iter_mut().zip(seed) {
                    *bar += s;
                }
            }
            self.bound(step, &mut state_bar);
        }
        let mut all = vec![state_bar];
        all.extend(program.parameter_bars(&bars));
        all
    }
}
