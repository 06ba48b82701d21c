//! Which states are kept, and from where the reverse sweep runs forward again.
//!
//! With fewer checkpoints than steps, a stretch of steps is divided by the binomial rule: A. Griewank,
//! "Achieving logarithmic growth of temporal and spatial complexity in reverse automatic
//! differentiation", Optimization Methods and Software 1 (1992). With `s` checkpoints no step is run
//! again more than `t` times, as long as there are at most `(s + t)! / (s! t!)` leaves, stretches
//! short enough for the rows of all their steps to be kept.

use std::ops::Range;

/// How many states the forward run of a rollout keeps for the reverse sweep. The gradient does not depend on it.
///
/// ```
/// use autodiff::{Kernel, Memory, Model, Program, Real, Rollout, Var, gradient};
///
/// /// Cooling by radiation.
/// #[derive(Clone, Copy)]
/// struct Cooling;
///
/// impl Kernel<1, 1> for Cooling {
///     #[inline(always)]
///     fn eval<R: Real>(&self, [heat]: [R; 1]) -> [R; 1] {
///         [heat - R::lit(0.01) * heat.powi(4)]
///     }
/// }
///
/// impl Model for Cooling {
///     fn record<R: Real>(&self, program: &mut Program<R>) {
///         let heat = program.state(16);
///         let [next] = program.map(Cooling, [heat]);
///         program.advance(heat, next);
///     }
/// }
///
/// let gradient = |memory| {
///     let rollout = Rollout { memory, ..Rollout::new(Cooling, 1000) };
///     gradient(|x: &[Var<f64>]| Var::sum_of(&rollout.run(x, &[])), &[1.1; 16])
/// };
/// // Ten states in place of a thousand.
/// assert_eq!(gradient(Memory::States(10)), gradient(Memory::All));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Memory {
    /// Every step: the fastest.
    #[default]
    All,
    /// No more numbers than this many states have; the sweep then runs parts of the rollout again. The
    /// least budget is the record of one step, that is its state and the outputs of its operations, and
    /// two more states. With that any number of steps is possible; with more, steps are run again less
    /// often.
    ///
    /// Ten states are enough if the operations of a step put out no more than seven times the numbers
    /// of a state, rounded up: each operation begins at a whole register, of up to 16 numbers, so that
    /// small states take more, and in single precision more than in double. What is enough for one start
    /// is enough for several. A smaller budget is refused when a tape records the rollout, with a message
    /// that says how many states are needed.
    States(usize),
    /// As [`States`](Memory::States), with the budget in bytes; below the least budget it is the least.
    Bytes(usize),
}

/// The schedule of a reverse sweep.
#[derive(Debug)]
pub(super) struct CheckpointSchedule {
    /// How many steps have their rows kept at once.
    pub(super) leaf: usize,
    /// Checkpoints that may be held at once, the start's included.
    checkpoints: usize,
}

impl CheckpointSchedule {
    /// From the lengths of a state and of a row, in numbers of type `R`.
    pub(super) fn new<R>(memory: Memory, steps: usize, [state, row]: [usize; 2]) -> Self {
        let all = Self {
            leaf: steps,
            checkpoints: 1,
        };
        // The record of a step, its start, and one more checkpoint if there is more than one step.
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
            "a memory of {} states cannot hold two of them and the record of a step, \
             {row} numbers: {least} states do",
            budget / state
        );
        Self { leaf, checkpoints }
    }

    /// Where a stretch gets its next checkpoint, if it is longer than a leaf and a checkpoint is free
    /// beside those `held`.
    pub(super) fn split(&self, steps: Range<usize>, held: usize) -> Option<usize> {
        let leaves = steps.len().div_ceil(self.leaf);
        let free = self.checkpoints.saturating_sub(held);
        if leaves <= 1 || free == 0 {
            return None;
        }
        // The least number of repetitions possible with the checkpoint below and the free ones.
        let repeats = (1..)
            .find(|&t| binomial(free + 1, t) >= leaves)
            .unwrap_or(1);
        let upper = binomial(free, repeats).min(leaves - 1);
        Some(steps.start + (leaves - upper) * self.leaf)
    }

    /// Where the last leaf of a stretch begins.
    pub(super) fn leaf_start(&self, steps: Range<usize>) -> usize {
        steps.end.saturating_sub(self.leaf).max(steps.start)
    }
}

/// `(s + t)! / (s! t!)`, or the largest integer if that overflows.
fn binomial(s: usize, t: usize) -> usize {
    (1..=t)
        .try_fold(1_usize, |product, k| Some(product.checked_mul(s + k)? / k))
        .unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::{CheckpointSchedule, Memory};

    /// Runs the schedule of the sweep on step numbers alone: the steps done forward, and the most
    /// numbers held.
    fn simulate(memory: Memory, steps: usize, [state, row]: [usize; 2]) -> (usize, usize) {
        let schedule = CheckpointSchedule::new::<f64>(memory, steps, [state, row]);
        let (mut stack, mut end, mut done, mut most) = (vec![0], steps, steps, 0);
        while schedule.leaf < steps && end > 0 {
            let top = *stack.last().expect("the start is below all");
            let to = schedule.split(top..end, stack.len());
            // The first descent happens while the rollout runs forward anyway.
            done += if end == steps {
                0
            } else {
                to.unwrap_or(end) - top
            };
            match to {
                Some(middle) => {
                    assert!(top < middle && middle < end);
                    stack.push(middle);
                }
                None => {
                    done += if end == steps { end - top } else { 0 };
                    end = schedule.leaf_start(top..end);
                    stack.retain(|&step| step < end);
                }
            }
            most = most.max(stack.len() * state + schedule.leaf * row);
        }
        (done, most)
    }

    #[test]
    fn budgets_are_kept_at_the_price_they_must_cost() {
        for states in [10, 11, 16, 40, 300] {
            let (done, most) = simulate(Memory::States(states), 4096, [144, 358]);
            println!(
                "{states} states: {:.2} rollouts forward",
                done as f64 / 4096.0
            );
            assert!(most <= states * 144, "{most} numbers for {states} states");
            // The binomial bound for 10 states: two steps' rows and five checkpoints, so 2048 leaves
            // and 12 repetitions.
            assert!(done <= 13 * 4096, "{done} steps for {states} states");
        }
        assert_eq!(simulate(Memory::All, 4096, [144, 358]), (4096, 0));
        let bytes = |bytes| simulate(Memory::Bytes(bytes), 4096, [144, 358]);
        assert_eq!(
            bytes(40 * 144 * 8),
            simulate(Memory::States(40), 4096, [144, 358])
        );
        // Two states and a record, which is three states rounded up.
        assert_eq!(bytes(0), simulate(Memory::States(5), 4096, [144, 358]));
        assert_eq!(
            simulate(Memory::States(11_000), 4096, [144, 358]),
            (4096, 0)
        );
    }

    #[test]
    #[should_panic(
        expected = "a memory of 3 states cannot hold two of them and the record of a step, \
                               25 numbers: 5 states do"
    )]
    fn too_small_a_budget_is_told() {
        CheckpointSchedule::new::<f64>(Memory::States(3), 100, [10, 25]);
    }
}
