//! The table of times, as Markdown.

use std::fmt::Write as _;

use super::measure::{Effort, seconds};
use super::{DataFile, Error, Problem, answer, open};
use crate::machine::machine;

/// Times that others published or measured, in milliseconds: hand-written C++ derivatives.
const ANCHORS: [(&str, f64, f64); 4] = [
    ("ba1_n49_m7776_p31843", 0.67, 3.92),
    ("gmm_d10_K25", 1.36, 2.47),
    ("hand_complicated1_t26_c100", 0.08, 0.39),
    ("lstm_l2_c1024", 1.16, 7.39),
];

/// Checks and measures all cases, and returns the page.
///
/// # Errors
/// If a case cannot be read or its answer is wrong.
pub fn page(cases: &[DataFile], effort: Effort) -> Result<String, Error> {
    let mut page = heading(effort);
    for case in cases {
        let ([objective, derivative], error) = measure(case, effort)?;
        let anchor = ANCHORS.iter().find(|(name, ..)| *name == case.name);
        let anchor = anchor.map_or("| |".to_owned(), |(_, objective, derivative)| {
            format!("{objective} | {derivative} |")
        });
        // Writing to a string cannot fail.
        let _ = writeln!(
            page,
            "| {} | {objective:.4} | {derivative:.4} | {:.2} | {error:.0e} | {anchor}",
            case.name,
            derivative / objective,
        );
    }
    Ok(page)
}

/// How long objective and derivative of a case take, ms, and the error of its answer.
fn measure(case: &DataFile, effort: Effort) -> Result<([f64; 2], f64), Error> {
    let mut problem: Box<dyn Problem> = open(case.kind, &case.file, None)?;
    problem.derivative();
    problem.objective();
    let comparison = answer::compare(&problem.answer(), &case.reference);
    if !comparison.is_close() {
        return Err(Error::Wrong {
            name: case.name.clone(),
            field: comparison.field,
            error: comparison.error,
            tolerance: comparison.tolerance,
        });
    }
    let objective = seconds(effort, || problem.objective());
    let derivative = seconds(effort, || problem.derivative());
    Ok(([objective * 1e3, derivative * 1e3], comparison.error))
}

fn heading(effort: Effort) -> String {
    format!(
        "\
# ADBench

Times of the four objectives of ADBench (arXiv:1807.10129) on `autodiff`, in milliseconds.
Written by `cargo run --release -p benches --bin adbench -- table`.

Machine: {}, one thread. Each time is the smallest of ten samples of at least
{} s, as ADBench measures. The machine is shared and its timers are noisy: a row may be a third
off, and its two times need not have been taken under equal load.

- *objective*: the generic source as plain `f64`, in SIMD lanes. A slower objective would make
  the ratio look better; the times decide.
- *derivative*: objective and gradient or Jacobian, everything recorded and computed afresh, in
  memory that is kept.
- *error*: the largest `max |a - b| / max |b|` of any field against the reference answers; a case
  out of tolerance is not timed.
- *C++*: hand-written derivatives in C++, times taken elsewhere, for a sense of scale.

| case | objective | derivative | ratio | error | C++ objective | C++ derivative |
| --- | --- | --- | --- | --- | --- | --- |
",
        machine(),
        effort.least.as_secs_f64(),
    )
}
