//! The cost of a limited memory budget for a rollout, measured by how often steps are repeated.

use std::cell::Cell;
use std::panic::catch_unwind;

use crate::common::panic_message;
use autodiff::{Real, Tape, Var};
use autodiff_programs::{Kernel, Memory, Model, Program, Rollout, kernel};

/// The number of numbers in a state.
const STATE: usize = 8;

thread_local! {
    /// A count of the forward evaluations of [`Widen`].
    static EVALUATIONS: Cell<usize> = const { Cell::new(0) };
}

/// A kernel whose results make the stored row of a step longer than the state, so that small budgets matter.
struct Widen;

#[kernel]
impl Kernel<1, 3> for Widen {
    fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 3] {
        // The reverse sweep evaluates duals once per step, for every budget, so duals do not count.
        if !std::any::type_name::<R>().contains("Dual") {
            EVALUATIONS.set(EVALUATIONS.get() + 1);
        }
        [x / (R::one() + x * x), x * x, x]
    }
}

struct Join;

#[kernel]
impl Kernel<3, 1> for Join {
    fn eval<R: Real>(&self, [wave, square, x]: [R; 3], _: &[R]) -> [R; 1] {
        [x + R::lit(0.1) * wave - R::lit(0.05) * square]
    }
}

/// A model of one step, whose state has this many numbers.
#[derive(Clone)]
struct Step(usize);

impl Model for Step {
    fn record(&self, program: &mut Program) {
        let x = program.state(self.0);
        let wide = program.map(Widen, [x], &[]);
        let [next] = program.map(Join, wide, &[]);
        program.advance(x, next);
    }
}

/// Returns the number of forward evaluations of the kernel for one gradient.
fn evaluations(steps: usize, memory: Memory) -> usize {
    EVALUATIONS.set(0);
    gradient::<f64>((steps, STATE), memory, 1);
    EVALUATIONS.get()
}

/// Returns the gradient with respect to the start, for a rollout of `steps` steps on `len` numbers from several equal
/// starts.
fn gradient<R: Real>((steps, len): (usize, usize), memory: Memory, starts: usize) -> Vec<R> {
    let rollout = Rollout {
        memory,
        ..Rollout::new(Step(len), steps)
    };
    let start: Vec<R> = (0..len).map(|i| R::lit(0.1 * i as f64)).collect();
    let mut tape = Tape::new();
    let sum = tape.record(&start, |x: &[Var<R>]| {
        Var::sum_of(&rollout.run_batch(&vec![x; starts], &[]).concat())
    });
    tape.pullback(&[sum], &[R::one()]).to_vec()
}

/// Returns the smallest budget, in states. It is read from the message with which `refused` refuses a smaller budget.
fn least(refused: impl FnOnce()) -> usize {
    let message = panic_message(refused);
    let (_, end) = message
        .split_once("use at least ")
        .expect("the message names the smallest budget");
    let least = end.trim_end_matches(" states");
    least.parse().expect("a number")
}

/// Returns how many forward steps the gradient of a rollout takes.
fn steps_done(steps: usize, memory: Memory) -> usize {
    evaluations(steps, memory) / evaluations(1, Memory::All)
}

/// Returns the size of a step's stored row, in states. It follows from the smallest budget, which is two states larger.
/// The row is a whole number of states, because it consists of whole registers and registers have at most eight
/// numbers, like a state.
fn row() -> usize {
    least(|| _ = evaluations(100, Memory::States(1))) - 2
}

/// Returns `(s + t)! / (s! t!)`: the largest number of stretches of steps that `s` checkpoints can cover if each
/// stretch is repeated at most `t` times.
fn stretches(s: usize, t: usize) -> usize {
    (1..=t).fold(1, |product, k| product * (s + k) / k)
}

/// Returns how many steps are done to go back over `stretches(s, t)` stretches from a checkpoint at their beginning, by
/// Griewank's recurrence.
fn back(s: usize, t: usize) -> usize {
    match (s, t) {
        (_, 0) => 1,
        (1, t) => (t + 1) * (t + 2) / 2,
        (s, t) => stretches(s, t - 1) + back(s - 1, t) + back(s, t - 1),
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn steps_are_repeated_as_often_as_the_rule_says() {
    let row = row();
    for checkpoints in 2..row {
        for repetitions in 1..5 {
            let steps = stretches(checkpoints, repetitions);
            // Steps to the first checkpoints are not repeated, because these checkpoints are taken while the rollout
            // runs forward.
            let on_the_way: usize = (2..=checkpoints)
                .map(|s| stretches(s, repetitions - 1))
                .sum();
            let expected = steps + back(checkpoints, repetitions) - on_the_way;
            let memory = Memory::States(checkpoints + row);
            assert_eq!(
                steps_done(steps, memory),
                expected,
                "{steps} steps, {checkpoints} checkpoints"
            );
        }
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_budget_for_all_steps_does_none_again() {
    let (steps, row) = (7, row());
    let all = steps * row + 1;
    assert_eq!(steps_done(steps, Memory::All), steps);
    assert_eq!(steps_done(steps, Memory::States(all)), steps);
    assert_eq!(steps_done(steps, Memory::States(usize::MAX)), steps);
    assert!(steps_done(steps, Memory::States(all - 1)) > steps);
}

/// Half of a budget must be used for rows that are kept, and the rest for checkpoints.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn half_of_a_budget_keeps_rows() {
    let row = row();
    // Three rows are kept, and three checkpoints cover four stretches. So each step is done one more time.
    let steps = 3 * stretches(3, 1);
    let done = steps_done(steps, Memory::States(6 * row));
    assert!(done <= 2 * steps, "{done} for {steps}");
}

/// Operations use whole registers, of which a small state fills only a part. So the smallest budget depends on the
/// number type, the machine and the number of starts. The message must name it.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn the_message_names_the_smallest_budget() {
    fn check<R: Real + PartialEq>() {
        for (len, starts) in [(1, 1), (2, 1), (2, 2), (7, 1), (17, 2)] {
            for steps in [1, 2, 50] {
                let of = |memory| gradient::<R>((steps, len), memory, starts);
                let least = least(|| _ = of(Memory::States(1)));
                assert!(of(Memory::States(least)) == of(Memory::All));
                let less = catch_unwind(|| _ = of(Memory::States(least - 1)));
                assert!(
                    less.is_err(),
                    "{len} numbers: {least} states are not the least"
                );
            }
        }
    }
    check::<f64>();
    check::<f32>();
}

/// Several starts fill registers better than one, so a budget that is enough for one must be enough for several.
#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn a_budget_for_one_start_is_enough_for_several() {
    let least = least(|| _ = gradient::<f32>((50, 17), Memory::States(1), 1));
    for starts in 1..20 {
        let of = |memory| gradient::<f32>((50, 17), memory, starts);
        assert!(of(Memory::States(least)) == of(Memory::All), "{starts}");
    }
}
