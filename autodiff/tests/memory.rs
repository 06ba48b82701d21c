//! What a rollout's memory budget costs: how often a step is done again, to the last one.

use std::cell::Cell;
use std::panic::catch_unwind;

use autodiff::{Adjoint, Kernel, Memory, Model, Program, Real, Rollout, Tape, Var};

/// Numbers of a state.
const STATE: usize = 8;

thread_local! {
    /// How often [`Widen`] was evaluated forward.
    static EVALUATIONS: Cell<usize> = const { Cell::new(0) };
}

/// Its outputs make the row of a step longer than the state, so that budgets bite.
struct Widen;

impl Kernel<1, 3> for Widen {
    fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 3] {
        // The reverse sweep evaluates duals, once a step whatever the budget.
        if !std::any::type_name::<R>().contains("Dual") {
            EVALUATIONS.set(EVALUATIONS.get() + 1);
        }
        [x.sin(), x * x, x]
    }
}

impl Adjoint<1, 3> for Widen {}

struct Join;

impl Kernel<3, 1> for Join {
    fn eval<R: Real>(&self, [sine, square, x]: [R; 3]) -> [R; 1] {
        [x + R::lit(0.1) * sine - R::lit(0.05) * square]
    }
}

impl Adjoint<3, 1> for Join {}

#[derive(Clone)]
struct Step;

impl Model for Step {
    fn record<R: Real>(&self, program: &mut Program<R>) {
        let x = program.state(STATE);
        let wide = program.map(Widen, [x]);
        let [next] = program.map(Join, wide);
        program.advance(x, next);
    }
}

/// How often the kernel is evaluated forward for a gradient.
fn evaluations(steps: usize, memory: Memory) -> usize {
    let rollout = Rollout {
        memory,
        ..Rollout::new(Step, steps)
    };
    let start: Vec<f64> = (0..STATE).map(|i| 0.1 * i as f64).collect();
    EVALUATIONS.set(0);
    let mut tape = Tape::new();
    let sum = tape.record(&start, |x| Var::sum(&rollout.run(x, &[])));
    tape.pullback(&[sum], &[1.0]);
    EVALUATIONS.get()
}

/// How many steps are done forward for a gradient, in a rollout of so many.
fn steps_done(steps: usize, memory: Memory) -> usize {
    evaluations(steps, memory) / evaluations(1, Memory::All)
}

/// Numbers that a step keeps, in states: as the refusal of too small a budget has it.
fn row() -> usize {
    let refused = catch_unwind(|| evaluations(100, Memory::States(1)));
    let message = refused.expect_err("one state cannot do");
    let message = message.downcast::<String>().expect("a sentence");
    let (_, end) = message.split_once("step: ").expect("the row's length");
    let numbers: usize = end.trim_end_matches(" numbers").parse().expect("a number");
    assert_eq!(numbers % STATE, 0, "the row is not a number of states");
    numbers / STATE
}

/// `(s + t)! / (s! t!)`: stretches that `s` snapshots and `t` repetitions can do.
fn stretches(s: usize, t: usize) -> usize {
    (1..=t).fold(1, |product, k| product * (s + k) / k)
}

/// Steps done to go back over that many, from a snapshot at their start: Griewank's recurrence.
fn back(s: usize, t: usize) -> usize {
    match (s, t) {
        (_, 0) => 1,
        (1, t) => (t + 1) * (t + 2) / 2,
        (s, t) => stretches(s, t - 1) + back(s - 1, t) + back(s, t - 1),
    }
}

#[test]
fn no_step_is_done_oftener_than_the_rule_says() {
    let row = row();
    for snapshots in 2..row {
        for repetitions in 1..5 {
            let steps = stretches(snapshots, repetitions);
            // The first snapshots are taken as the rollout runs anyway.
            let on_the_way: usize = (2..=snapshots).map(|s| stretches(s, repetitions - 1)).sum();
            let expected = steps + back(snapshots, repetitions) - on_the_way;
            let memory = Memory::States(snapshots + row);
            assert_eq!(
                steps_done(steps, memory),
                expected,
                "{steps} steps, {snapshots} snapshots"
            );
        }
    }
}

#[test]
fn a_budget_for_all_steps_does_none_again() {
    let (steps, row) = (7, row());
    let all = steps * row + 1;
    assert_eq!(steps_done(steps, Memory::All), steps);
    assert_eq!(steps_done(steps, Memory::States(all)), steps);
    assert!(steps_done(steps, Memory::States(all - 1)) > steps);
}

/// Half of a budget goes into rows that are kept, the rest into snapshots.
#[test]
fn half_of_a_budget_keeps_rows() {
    let row = row();
    // Three rows, and three snapshots of four stretches: each step is done once more.
    let steps = 3 * stretches(3, 1);
    let done = steps_done(steps, Memory::States(6 * row));
    assert!(done <= 2 * steps, "{done} for {steps}");
    // Two snapshots are the least; one fewer is refused, as `row` shows.
    steps_done(20, Memory::States(row + 2));
    assert!(catch_unwind(|| evaluations(20, Memory::States(row + 1))).is_err());
}
