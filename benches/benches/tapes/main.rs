//! The cost of a scalar tape: the gradient of one step of springs, on our tape, on those of other
//! crates and through our kernels. Answers are compared before anything is timed.
//!
//! - `cargo bench -p benches --bench tapes --features rivals,xad-rs --ignore-rust-version`
//! - the same with `-- --table` writes `docs/speed.md`, with the rollout's figures.

mod document;

use std::hint::black_box;

use benches::machine::{in_turns, write_page};
use benches::tapes::rivals::{self, Gradient, tapes};
use benches::tapes::step::SpringLattice;
use benches::tapes::{inputs, kernels};

/// Steps of the rollouts that kernels are timed in.
const STEPS: usize = 256;
/// Times that each measurement is taken, in turns; the least counts.
const ROUNDS: usize = 300;

/// A row of the table.
pub(crate) struct TapeRow {
    pub(crate) name: &'static str,
    /// Microseconds a step, or why there are none.
    pub(crate) time: Result<f64, &'static str>,
}

struct TimedTape {
    name: &'static str,
    steps: usize,
    run: Gradient,
}

fn main() {
    let lattice = SpringLattice::default();
    let inputs = inputs();
    compare(&lattice, &inputs);
    let mut rows = time(&mut subjects(&lattice), &lattice, &inputs);
    rows.extend(absent());
    let table = document::tapes(&rows);
    println!("{table}");
    write_page("speed.md", || document::page(&table));
}

/// The tapes that this build leaves out.
fn absent() -> Vec<TapeRow> {
    let mut rows = Vec::new();
    let mut leave_out = |name, why| {
        rows.push(TapeRow {
            name,
            time: Err(why),
        })
    };
    if cfg!(not(feature = "xad-rs")) {
        leave_out(
            "xad-rs",
            "not built: `--features xad-rs`, and Rust 1.98 or `--ignore-rust-version`",
        );
    }
    if cfg!(not(feature = "rivals")) {
        leave_out(
            "reverse, ad_trait, echidna",
            "not built: `--features rivals`",
        );
    }
    rows
}

fn subjects(lattice: &SpringLattice) -> Vec<TimedTape> {
    let (value, gradient) = (
        kernels::value(lattice, STEPS),
        kernels::gradient(lattice, STEPS),
    );
    let subject = |(name, steps, run)| TimedTape { name, steps, run };
    let tapes = tapes().into_iter().map(|(name, tape)| (name, 1, tape()));
    [("primal, scalar f64", 1, rivals::plain())]
        .into_iter()
        .chain(tapes)
        .chain([
            ("primal, kernels in lanes", STEPS, value),
            ("kernels of this crate", STEPS, gradient),
        ])
        .map(subject)
        .collect()
}

/// Every tape must agree with ours, and ours with the kernels' adjoints.
fn compare(lattice: &SpringLattice, inputs: &[f64]) {
    let (value, gradient) = rivals::ours()(lattice, inputs);
    let kernels = ("kernels", kernels::gradient(lattice, 1));
    let tapes = tapes().into_iter().map(|(name, tape)| (name, tape()));
    for (name, mut other) in tapes.chain([kernels]) {
        let (its_value, its_gradient) = other(lattice, inputs);
        assert_eq!(gradient.len(), its_gradient.len(), "{name}");
        // Sums of about 100 terms in another order: 100 roundings of the largest, at most.
        let scale = gradient.iter().fold(1.0, |most: f64, g| most.max(g.abs()));
        let differ = |a: f64, b: f64| (a - b).abs() > 1e-13 * scale.max(a.abs());
        assert!(
            !differ(value, its_value),
            "{name}: {its_value}, not {value}"
        );
        for (k, (&ours, &its)) in gradient.iter().zip(&its_gradient).enumerate() {
            assert!(
                !differ(ours, its),
                "{name}: component {k} is {its}, not {ours}"
            );
        }
    }
}

/// Microseconds a step, the least of many rounds.
fn time(subjects: &mut [TimedTape], lattice: &SpringLattice, inputs: &[f64]) -> Vec<TapeRow> {
    let works = subjects.iter_mut();
    let works = works.map(|subject| || (subject.run)(lattice, black_box(inputs)));
    let least = in_turns(&mut works.collect::<Vec<_>>(), ROUNDS);
    let rows = subjects.iter().zip(least);
    rows.map(|(subject, seconds)| TapeRow {
        name: subject.name,
        time: Ok(seconds * 1e6 / subject.steps as f64),
    })
    .collect()
}
