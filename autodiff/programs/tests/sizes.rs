//! Sizes of a step's arrays that must be refused.

use crate::common::{assert_refused, panic_message};
use crate::steps::Times;
use autodiff_programs::{Model, Program, Rollout};

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
