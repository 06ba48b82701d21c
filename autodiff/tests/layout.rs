//! The memory layout of a step's arrays, and sizes that must be refused.

use crate::common::{assert_refused, panic_message};
use crate::steps::{Mapped, Times};
use autodiff::{Given, Graph, Model, Program, Real, Rollout, Tape, Var};

/// A model whose next state is a layer of one row, with a zero on each side of it.
#[derive(Clone)]
struct Gapped;

impl Model for Gapped {
    fn record(&self, p: &mut Program) {
        let (matrix, bias) = (p.matrix(1, 3), p.parameter(1));
        let x = p.state(3);
        let row = p.dense_tanh(matrix, &[x], bias);
        let next = p.gather(row, &[None, Some(0), None]);
        p.advance(x, next);
    }
}

/// Fills the memory of this thread's last rollout with NaN. The next rollout may reuse this memory.
fn leave_nan() {
    Tape::new().record(&[f64::NAN; 1 << 12], |x| {
        Rollout::new(Mapped(Times(0.5), 1 << 12), 3).run(x, &[]);
    });
}

#[test]
fn what_a_gather_leaves_out_is_zero_wherever_it_lies() {
    for count in 1..=16 {
        leave_nan();
        let ends = Tape::new().record(&[0.5; 3], |x| {
            let (weights, bias) = ([Var::lit(1.0); 3], [Var::lit(0.25)]);
            let parameters = [Given::Shared(&weights), Given::Shared(&bias)];
            Rollout::new(Gapped, 2).run_batch(&vec![x; count], &parameters)
        });
        for end in ends {
            // The first step computes the tanh of three halves plus the bias. The second step does the same with that
            // result.
            let expected = [0.0, (1.75f64.tanh() + 0.25).tanh(), 0.0];
            let end: Vec<f64> = end.iter().map(|x| x.value()).collect();
            assert_eq!(
                (end[0], end[2]),
                (expected[0], expected[2]),
                "{count} starts"
            );
            // The tolerance is for two tanh of this crate with an error of 4 ulp each.
            assert!((end[1] - expected[1]).abs() < 1e-14, "{count} starts");
        }
    }
}

/// A model that computes half of the second differences along a chain. The nodes do not fill a register.
#[derive(Clone)]
struct Chain;

impl Model for Chain {
    fn record(&self, p: &mut Program) {
        let graph = Graph::new(5, &[[0, 1], [1, 2], [2, 3], [3, 4]]);
        let x = p.state(5);
        let [next] = p.map_edges(&graph, Times(0.5), [x], &[], &[]);
        p.advance(x, next);
    }
}

/// Registers of edges may reach past the last node, into the results of the step and into memory of earlier steps. The
/// numbers found there must not matter.
#[test]
fn numbers_behind_the_nodes_do_not_matter() {
    const TWICE: [f64; 5] = [0.25, -1.0, 1.5, -1.0, 0.25];
    for count in 1..=16 {
        leave_nan();
        let mut tape = Tape::new();
        let ends = tape.record(&[0.0, 0.0, 1.0, 0.0, 0.0], |x| {
            Rollout::new(Chain, 2).run_batch(&vec![x; count], &[])
        });
        for end in ends {
            let values: Vec<f64> = end.iter().map(|x| x.value()).collect();
            assert_eq!(values, TWICE, "{count} starts");
            // The second difference at a middle node is symmetric.
            assert_eq!(tape.pullback(&end[2..3], &[1.0]), TWICE, "{count} starts");
        }
    }
}

/// A model with two parts of the state, whose lengths add up to this number. If the sum wrapped around, it would be too
/// small to be refused.
#[derive(Clone)]
struct Huge(usize);

impl Model for Huge {
    fn record(&self, p: &mut Program) {
        let [long, short] = [self.0.wrapping_sub(1032), 1032].map(|len| p.state(len));
        let [next] = p.map(Times(0.5), [short], &[]);
        p.advance(long, long);
        p.advance(short, next);
    }
}

/// A model with a matrix whose number of entries overflows a `usize` to 0.
#[derive(Clone)]
struct HugeMatrix;

impl Model for HugeMatrix {
    fn record(&self, p: &mut Program) {
        let (x, side) = (p.state(1), 1 << (usize::BITS / 2));
        p.matrix(side, side);
        p.advance(x, x);
    }
}

/// A model with a state, and with more inputs than any memory can hold.
#[derive(Clone)]
struct ManyInputs;

impl Model for ManyInputs {
    fn record(&self, p: &mut Program) {
        let x = p.state(1);
        p.input(1 << (usize::BITS - 4));
        p.advance(x, x);
    }
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn sizes_beyond_any_memory_are_refused() {
    let too_long = "too long: their total length overflows";
    assert_refused(too_long, || Rollout::new(Huge(8), 1).run(&[1.0; 8], &[]));
    assert_refused(too_long, || Rollout::new(HugeMatrix, 1).run(&[1.0], &[&[]]));
    let missing = "but `inputs` has only 0";
    assert_refused(missing, || Rollout::new(ManyInputs, 2).run(&[1.0], &[]));
}

#[test]
#[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
fn starts_whose_arrays_overflow_are_refused() {
    let huge = 1 << (usize::BITS - 3);
    let start: &[f64] = &[1.0; 8];
    let message = panic_message(|| Rollout::new(Huge(huge), 1).run_batch(&[start; 16], &[]));
    // On machines whose registers have one lane, single starts run one after the other. Then the length of one start is
    // refused, and nothing overflows.
    let alone = format!("the model's state has {huge}");
    assert!(
        message.contains("too long: their total length overflows") || message.contains(&alone),
        "{message}"
    );
}

#[test]
fn an_array_says_whether_it_is_empty() {
    let mut program = Program::default();
    let [none, some] = [0, 2].map(|len| program.state(len));
    assert!(none.is_empty() && !some.is_empty());
    assert_eq!([none.len(), some.len()], [0, 2]);
}
