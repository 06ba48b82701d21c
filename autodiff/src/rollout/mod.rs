//! Rollouts: stepping a [`Program`] many times, and the reverse sweep through all of it.
//!
//! The forward run keeps the row of every step: its state and the outputs of its operations. The
//! reverse sweep goes back one step at a time and recomputes what happens inside operations. Memory:
//! `steps` rows, or what a [`Memory`] budget allows.

mod many;
mod memory;
mod sweep;
#[cfg(test)]
mod tests;

use std::sync::Arc;

pub use memory::Memory;
pub use sweep::Recorded;

use crate::fused::Fused;
use crate::program::Program;
use crate::real::{Mask, Real};
use many::Many;
use sweep::{Starts, Sweep};

/// A system that steps: its step is recorded as a program for any number type. It must own its data, or
/// share them by an `Arc`, because the tape keeps it.
pub trait Model: Clone + Send + Sync + 'static {
    /// Declares parameters, states, inputs and controls, records one step and advances every state.
    fn record<R: Real>(&self, program: &mut Program<R>);
}

/// A bound on the norm of the state's cotangent in the reverse sweep (gradient clipping): where it is
/// exceeded, the cotangent is scaled back to it. The result is then no longer the exact gradient. The
/// norm does not overflow; a cotangent with an infinite number or NaN in it becomes NaN. Derivatives of
/// such a gradient take the factor of the scaling for a constant: Hessians are not exact either, and
/// need not be symmetric.
///
/// ```
/// use autodiff::{Adjoint, CotangentBound, Kernel, Model, Program, Real, Rollout, Var, gradient_of};
///
/// /// Each step doubles `x`.
/// #[derive(Clone, Copy)]
/// struct Doubling;
///
/// impl Kernel<1, 1> for Doubling {
///     #[inline(always)]
///     fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
///         [x + x]
///     }
/// }
/// impl Adjoint<1, 1> for Doubling {}
///
/// impl Model for Doubling {
///     fn record<R: Real>(&self, program: &mut Program<R>) {
///         let x = program.state(1);
///         let [next] = program.map(Doubling, [x]);
///         program.advance(x, next);
///     }
/// }
///
/// let slope = |rollout: Rollout<Doubling>| gradient_of(|x: &[Var<f64>]| rollout.run(x, &[])[0], &[1.0]);
/// assert_eq!(slope(Rollout::new(Doubling, 10)), [1024.0]);
/// let bound = CotangentBound { norm: 5.0, every: 1 };
/// let bounded = Rollout { cotangent_bound: Some(bound), ..Rollout::new(Doubling, 10) };
/// assert_eq!(slope(bounded), [5.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CotangentBound {
    /// The largest Euclidean norm, not below 0.
    pub norm: f64,
    /// The cotangent is checked after every `every` steps, counted from the start, and at the start
    /// itself; 1 or more.
    pub every: usize,
}

/// `steps` steps of a model: [`Rollout::new`] has defaults, and the other fields are set by name,
/// `Rollout { observed: vec![10, 20], ..Rollout::new(model, 20) }`.
#[derive(Clone, Debug)]
pub struct Rollout<M> {
    /// What is stepped.
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
    /// What the forward run keeps for the reverse sweep.
    pub memory: Memory,
}

/// A parameter of several rollouts.
#[derive(Clone, Copy, Debug)]
pub enum Given<'a, R> {
    /// The same for all of them.
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

    /// Runs all steps and returns the observed states (or the chosen [`entries`](Rollout::entries) of
    /// each), one after the other.
    ///
    /// `start` is the initial state, its parts one after the other in the order of the model's
    /// declarations; `parameters` are one slice each, in that order too: an array, a matrix row by row, a
    /// [control](Program::control) step by step.
    ///
    /// On the tape the whole rollout is one fused entry.
    ///
    /// # Panics
    /// - If lengths differ from the model's declarations, or the inputs are too few for all steps;
    /// - if an observed step or an entry is out of range, or the observed steps do not ascend;
    /// - if a bound is below 0 or NaN, or checked every 0 steps;
    /// - on a tape, if the [`Memory`] is too little for a step;
    /// - if the model leaves a part of its state unadvanced, or records what [`Program`] refuses.
    pub fn run<R: Real>(&self, start: &[R], parameters: &[&[R]]) -> Vec<R> {
        let inputs: Vec<&[R]> = std::iter::once(start)
            .chain(parameters.iter().copied())
            .collect();
        R::fused(self.clone(), &inputs)
    }

    /// What [`run`](Rollout::run) returns from each of several starts, to the bit, in less time: as
    /// many starts as a register has lanes run together, and each weight that is read serves them
    /// all.
    ///
    /// On the tape this too is one fused entry. The cotangents of starts have the same bits as from
    /// `run`; those of the parameters, which all starts share, are sums over steps and starts in another
    /// order, and differ from the sum of those of `run` by rounding.
    ///
    /// ```
    /// use autodiff::{Adjoint, Kernel, Model, Program, Real, Rollout, Var, gradient_of};
    ///
    /// /// Each step takes a share of `x`.
    /// #[derive(Clone, Copy)]
    /// struct Decay;
    ///
    /// impl Kernel<2, 1> for Decay {
    ///     #[inline(always)]
    ///     fn eval<R: Real>(&self, [x, share]: [R; 2]) -> [R; 1] {
    ///         [x - share * x]
    ///     }
    /// }
    /// impl Adjoint<2, 1> for Decay {}
    ///
    /// impl Model for Decay {
    ///     fn record<R: Real>(&self, program: &mut Program<R>) {
    ///         let (share, x) = (program.parameter(1), program.state(1));
    ///         let [next] = program.map(Decay, [x, share]);
    ///         program.advance(x, next);
    ///     }
    /// }
    ///
    /// let rollout = Rollout::new(Decay, 2);
    /// // (a + b) (1 - share)^2, differentiated by a, b and the share.
    /// let left = |x: &[Var<f64>]| {
    ///     let ends = rollout.run_many(&[&x[..1], &x[1..2]], &[&x[2..]]);
    ///     ends[0][0] + ends[1][0]
    /// };
    /// assert_eq!(gradient_of(left, &[1.0, 3.0, 0.5]), [0.25, 0.25, -4.0]);
    /// ```
    ///
    /// # Panics
    /// As [`run`](Rollout::run).
    pub fn run_many<R: Real>(&self, starts: &[&[R]], parameters: &[&[R]]) -> Vec<Vec<R>> {
        let shared: Vec<Given<R>> = parameters.iter().map(|p| Given::Shared(p)).collect();
        self.run_each(starts, &shared)
    }

    /// Like [`run_many`](Rollout::run_many) where some parameters differ from start to start: all but the
    /// matrices may. The cotangents of a start's own parameters have the same bits as from
    /// [`run`](Rollout::run).
    ///
    /// ```
    /// use autodiff::{Adjoint, Given, Kernel, Model, Program, Real, Rollout};
    ///
    /// /// A mass on a spring, in steps of 0.1 s.
    /// #[derive(Clone, Copy)]
    /// struct Spring;
    ///
    /// impl Kernel<3, 2> for Spring {
    ///     #[inline(always)]
    ///     fn eval<R: Real>(&self, [x, v, stiffness]: [R; 3]) -> [R; 2] {
    ///         let v = v - R::lit(0.1) * stiffness * x;
    ///         [x + R::lit(0.1) * v, v]
    ///     }
    /// }
    /// impl Adjoint<3, 2> for Spring {}
    ///
    /// impl Model for Spring {
    ///     fn record<R: Real>(&self, program: &mut Program<R>) {
    ///         let stiffness = program.parameter(1);
    ///         let (x, v) = (program.state(1), program.state(1));
    ///         let [x_next, v_next] = program.map(Spring, [x, v, stiffness]);
    ///         program.advance(x, x_next);
    ///         program.advance(v, v_next);
    ///     }
    /// }
    ///
    /// let rollout = Rollout::new(Spring, 8);
    /// let start: &[f64] = &[1.0, 0.0];
    /// let both = rollout.run_each(&[start; 2], &[Given::Each(&[&[1.0], &[4.0]])]);
    /// let [soft, stiff] = [1.0, 4.0].map(|stiffness| rollout.run(start, &[&[stiffness]]));
    /// assert_eq!(both, [soft, stiff]);
    /// ```
    ///
    /// # Panics
    /// As [`run`](Rollout::run); and if a [`Given::Each`] has not one slice per start, or is for a matrix.
    pub fn run_each<R: Real>(&self, starts: &[&[R]], parameters: &[Given<R>]) -> Vec<Vec<R>> {
        if starts.is_empty() {
            return Vec::new();
        }
        let (mut inputs, mut own) = (starts.to_vec(), Vec::new());
        for parameter in parameters {
            match parameter {
                Given::Shared(given) => inputs.push(given),
                Given::Each(given) => {
                    assert_eq!(
                        given.len(),
                        starts.len(),
                        "Given::Each needs one slice for each start"
                    );
                    inputs.extend(*given);
                }
            }
            own.push(matches!(parameter, Given::Each(_)));
        }
        let many = Many {
            rollout: self.clone(),
            starts: starts.len(),
            own,
        };
        let seen = R::fused(many, &inputs);
        let len = seen.len() / starts.len();
        (0..starts.len())
            .map(|start| seen[start * len..][..len].to_vec())
            .collect()
    }

    /// Refuses settings that the steps rely on without checks, given how many inputs a step takes.
    fn check(&self, inputs: usize) {
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

    /// Where the returned numbers lie in a state of `len` numbers, in which those of `starts` starts are
    /// interleaved.
    fn places(&self, (starts, len): (usize, usize)) -> Vec<usize> {
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

    /// Scales each start's cotangent back where the bound asks for it, after `step` steps.
    fn clip<R: Real>(&self, (step, starts): (usize, usize), state_bar: &mut [R]) {
        let Some(CotangentBound { norm, every }) = self.cotangent_bound else {
            return;
        };
        if !step.is_multiple_of(every) || state_bar.is_empty() {
            return;
        }
        let limit = R::lit(norm);
        for start in 0..starts {
            let of_start = state_bar[start..].iter().step_by(starts);
            let mut of_start: Vec<R> = of_start.copied().collect();
            let (squared, unit) = measure(&mut of_start);
            let in_units = limit / unit;
            let exceeds = (in_units * in_units).lt(squared) | !squared.finite();
            // With infinite numbers among them, a factor of zero would hide the others.
            let factor = limit * squared.rsqrt();
            let factor = R::select(squared.finite(), factor, R::lit(f64::NAN));
            let bars = state_bar[start..].iter_mut().step_by(starts);
            for (bar, measured) in bars.zip(of_start) {
                *bar = R::select(exceeds, measured * factor, *bar);
            }
        }
    }

    /// The observed numbers, interleaved for several starts.
    fn forward<R: Real>(&self, starts: Starts, inputs: &[&[R]]) -> Vec<R> {
        let mut sweep = Sweep::new(self, starts, inputs);
        let mut row = sweep.row(inputs[0]);
        let places = self.places((starts.count, sweep.state_len()));
        let (mut seen, mut observed) = (Vec::new(), self.observed.iter().peekable());
        for step in 0..=self.steps {
            while observed.next_if_eq(&&step).is_some() {
                let state = sweep.state(&row);
                seen.extend(places.iter().map(|&i| state[i]));
            }
            if step < self.steps {
                sweep.step_in_place(step, &mut row);
            }
        }
        sweep.apply_state_bound((self.steps, &row), &mut seen);
        seen
    }

    /// The same, and what the reverse sweep needs.
    fn recorded<R: Real>(&self, starts: Starts, inputs: &[&[R]]) -> (Vec<R>, Recorded<R>) {
        let mut recorded = Recorded::new(self, starts, inputs);
        let places = self.places((starts.count, recorded.state_len()));
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
    fn reversed<R: Real>(
        &self,
        (starts, saved): (usize, &mut Recorded<R>),
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let state_len = saved.state_len();
        let places = self.places((starts, state_len));
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
            self.clip((step, starts), state_bar);
        });
        std::iter::once(state_bar).chain(parameter_bars).collect()
    }
}

/// Divides numbers by a unit, 1 or the largest magnitude, with which their squares neither overflow
/// nor lose to underflow more than rounding does. Returns the sum of squares, and the unit.
fn measure<R: Real>(numbers: &mut [R]) -> (R, R) {
    let squared = R::dot(numbers, numbers).detach();
    // Squares that underflow, even in single precision, are below 1e-38: nothing beside this.
    let fits = R::lit(1e-30).le(squared) & squared.finite();
    if fits.all() {
        return (squared, R::one());
    }
    let magnitudes = numbers.iter().map(|x| x.detach().abs());
    let largest = magnitudes.fold(R::zero(), |largest, x| x.max(largest));
    let unit = R::select(fits | largest.le(R::zero()), R::one(), largest);
    for number in &mut *numbers {
        *number /= unit;
    }
    (R::dot(numbers, numbers).detach(), unit)
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
        self.reversed((1, saved), y_bar, &wanted[1..])
    }
}
