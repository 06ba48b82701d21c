//! The cost of the scalar tape: the gradient of one step of springs, on the tape and through kernels. Answers
//! are compared before anything is timed.
//!
//! `cargo bench -p benches --bench tapes` prints a section of `RESULTS.md`.

use std::hint::black_box;

use benches::machine::{SPAN, in_turns, section};
use benches::tapes::step::SpringLattice;
use benches::tapes::{Gradient, inputs, kernels, on_tape, plain};

/// Steps of the rollouts that kernels are timed in.
const STEPS: usize = 256;
/// Times that each measurement is taken, in turns; the least counts.
const ROUNDS: usize = 300;

struct TimedTape {
    name: &'static str,
    steps: usize,
    run: Gradient,
}

fn main() {
    let lattice = SpringLattice::default();
    let inputs = inputs();
    compare(&lattice, &inputs);
    let table = table(&mut subjects(&lattice), &lattice, &inputs);
    let command = "cargo bench -p benches --bench tapes";
    println!("{}", section("Scalar tapes", command, &table));
}

fn subjects(lattice: &SpringLattice) -> [TimedTape; 4] {
    [
        ("primal, scalar f64", 1, plain()),
        ("`Tape`", 1, on_tape()),
        (
            "primal, kernels in lanes",
            STEPS,
            kernels::value(lattice, STEPS),
        ),
        ("kernels", STEPS, kernels::gradient(lattice, STEPS)),
    ]
    .map(|(name, steps, run)| TimedTape { name, steps, run })
}

/// The tape must agree with the adjoints of the kernels.
fn compare(lattice: &SpringLattice, inputs: &[f64]) {
    let (value, gradient) = on_tape()(lattice, inputs);
    let (other_value, other) = kernels::gradient(lattice, 1)(lattice, inputs);
    assert_eq!(gradient.len(), other.len());
    // Sums of about 100 terms in another order: 100 roundings of the largest, at most.
    let scale = gradient.iter().fold(1.0, |most: f64, g| most.max(g.abs()));
    let differ = |a: f64, b: f64| (a - b).abs() > 1e-13 * scale.max(a.abs());
    assert!(!differ(value, other_value), "{other_value}, not {value}");
    for (k, (&a, &b)) in gradient.iter().zip(&other).enumerate() {
        assert!(!differ(a, b), "component {k} is {b}, not {a}");
    }
}

/// Microseconds a step; the first row is the primal that ratios are taken to.
fn table(subjects: &mut [TimedTape], lattice: &SpringLattice, inputs: &[f64]) -> String {
    let works = subjects.iter_mut();
    let works = works.map(|subject| || (subject.run)(lattice, black_box(inputs)));
    let least = in_turns(&mut works.collect::<Vec<_>>(), SPAN, ROUNDS);
    let mut table = String::from("| one step | us | times the primal |\n| --- | --- | --- |\n");
    for (TimedTape { name, steps, .. }, seconds) in subjects.iter().zip(&least) {
        let time = seconds * 1e6 / *steps as f64;
        let times = time / (least[0] * 1e6);
        table += &format!("| {name} | {time:.3} | {times:.1} |\n");
    }
    table
}
