//! Decides which states a rollout keeps as checkpoints, from which the reverse sweep runs forward again.
//!
//! With fewer checkpoints than steps, the steps are divided by the binomial rule: A. Griewank, "Achieving logarithmic
//! growth of temporal and spatial complexity in reverse automatic differentiation", Optimization Methods and Software 1
//! (1992). A leaf is a range of steps whose rows are all kept at once. With `s` checkpoints and at most
//! `(s + t)! / (s! t!)` leaves, each step is run again at most `t` times.

use std::ops::Range;

/// How much memory a rollout uses for its reverse sweep. The gradient does not depend on it.
///
/// ```
/// use autodiff::{Real, Var, gradient};
/// use autodiff_programs::{Kernel, Memory, Model, Program, Rollout, kernel};
///
/// /// Cooling by radiation.
/// #[derive(Clone, Copy)]
/// struct Cooling;
///
/// #[kernel]
/// impl Kernel<1, 1> for Cooling {
///     fn eval<R: Real>(&self, [heat]: [R; 1], _: &[R]) -> [R; 1] {
///         [heat - R::lit(0.01) * heat.powi(4)]
///     }
/// }
///
/// impl Model for Cooling {
///     fn record(&self, program: &mut Program) {
///         let heat = program.state(16);
///         let [next] = program.map(Cooling, [heat], &[]);
///         program.advance(heat, next);
///     }
/// }
///
/// let gradient = |memory| {
///     let rollout = Rollout { memory, ..Rollout::new(Cooling, 1000) };
///     gradient(|x: &[Var<f64>]| Var::sum_of(&rollout.run(x, &[])), &[1.1; 16])
/// };
/// // Ten states instead of a thousand give the same gradient.
/// assert_eq!(gradient(Memory::States(10)), gradient(Memory::All));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Memory {
    /// Keep every step. This is the fastest.
    #[default]
    All,
    /// A memory budget: room for as many numbers as this many states have. The sweep then runs parts of the rollout
    /// again. With a larger budget it repeats less. The smallest possible budget is two states plus the row of one step
    /// (its state and the outputs of its operations). This budget is enough for any number of steps.
    ///
    /// Ten states are enough if the outputs of a step have at most seven times as many numbers as a state. Outputs are
    /// rounded up to whole registers of up to 16 numbers, so small states need more. A budget that is enough for one
    /// start is enough for several. If the budget is too small, recording the rollout on a tape panics with a message
    /// that says how many states are needed.
    States(usize),
    /// Like [`States`](Memory::States), but in bytes. A budget that is too small is raised to the smallest possible
    /// one.
    Bytes(usize),
}

/// Decides when the forward run and the reverse sweep set checkpoints.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct CheckpointSchedule {
    /// The number of consecutive steps whose rows are kept at once.
    pub(super) leaf: usize,
    /// The number of checkpoints that may be held at once, including the start.
    checkpoints: usize,
}

impl CheckpointSchedule {
    /// The schedule for runs without a reverse sweep: one row and no checkpoints.
    pub(super) const NOTHING: Self = Self {
        leaf: 1,
        checkpoints: 0,
    };

    /// Creates the schedule of a rollout. `state` and `row` are the lengths of a state and of a row, in numbers of type
    /// `R`.
    #[track_caller]
    pub(super) fn new<R>(memory: Memory, steps: usize, [state, row]: [usize; 2]) -> Self {
        let all = Self {
            leaf: steps,
            checkpoints: 1,
        };
        // The row of a step, the start state, and one more checkpoint if there are several steps.
        let least = steps.min(2) + row.div_ceil(state.max(1));
        let budget = match memory {
            Memory::All => return all,
            Memory::States(states) => states.saturating_mul(state),
            Memory::Bytes(bytes) => (bytes / size_of::<R>().max(1)).max(least * state),
        };
        // A state without numbers takes no memory.
        if state == 0 || budget >= steps.saturating_mul(row).saturating_add(state) {
            return all;
        }
        let leaf = (budget / 2 / row).max(1);
        let checkpoints = budget.saturating_sub(leaf * row) / state;
        assert!(
            checkpoints >= 2,
            "`Memory::States({})` is too small: it must hold two states and the row of one step \
             ({row} numbers); use at least {least} states",
            budget / state
        );
        Self { leaf, checkpoints }
    }

    /// Returns the step at which to set the next checkpoint within `steps`, which begins at a checkpoint. Returns
    /// `None` if `steps` is a leaf or all checkpoints are in use. `held` is the number of checkpoints in use.
    pub(super) fn split(&self, steps: Range<usize>, held: usize) -> Option<usize> {
        let leaves = steps.len().div_ceil(self.leaf);
        let free = self.checkpoints.saturating_sub(held);
        if leaves <= 1 || free == 0 {
            return None;
        }
        // The smallest number of repetitions that is possible with the checkpoint at `steps.start` and the free ones.
        let repeats = (1..)
            .find(|&t| binomial(free + 1, t) >= leaves)
            .unwrap_or(1);
        let upper = binomial(free, repeats).min(leaves - 1);
        Some(steps.start + (leaves - upper) * self.leaf)
    }

    /// Returns the first step of the last leaf in `steps`. A leaf is a range of steps whose rows are kept at once.
    pub(super) fn leaf_start(&self, steps: Range<usize>) -> usize {
        steps.end.saturating_sub(self.leaf).max(steps.start)
    }
}

/// Returns `(s + t)! / (s! t!)`, or the largest integer on overflow.
fn binomial(s: usize, t: usize) -> usize {
    (1..=t)
        .try_fold(1_usize, |product, k| Some(product.checked_mul(s + k)? / k))
        .unwrap_or(usize::MAX)
}
