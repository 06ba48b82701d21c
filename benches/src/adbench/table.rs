//! Makes the table of the times of all cases.

use std::fmt::Write as _;

use super::{Case, gap};
use crate::machine::in_turns;
use crate::objectives::Error;

/// The minimum duration of one time measurement (a sample) in seconds, as in ADBench.
const SAMPLE: f64 = 0.5;
/// The number of samples.
const SAMPLES: usize = 10;

/// Published times of objectives and derivatives that were written by hand in C++, in milliseconds.
const CPP: [(&str, f64, f64); 4] = [
    ("ba1_n49_m7776_p31843", 0.67, 3.92),
    ("gmm_d10_K25", 1.36, 2.47),
    ("hand_complicated1_t26_c100", 0.08, 0.39),
    ("lstm_l2_c1024", 1.16, 7.39),
];

/// Checks the answers of all cases, measures their times, and returns a Markdown table.
///
/// # Errors
/// If a case cannot be read or its answer is out of tolerance.
pub fn table(cases: &[Case]) -> Result<String, Error> {
    let mut table = String::from(
        "| case | objective | derivative | ratio | error | C++ objective | C++ derivative |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for case in cases {
        let ([objective, derivative], error) = measure(case)?;
        let cpp = CPP.iter().find(|(name, ..)| *name == case.name);
        let cpp = cpp.map_or("| |".to_owned(), |(_, objective, derivative)| {
            format!("{objective} | {derivative} |")
        });
        // Writing to a string cannot fail.
        let _ = writeln!(
            table,
            "| {} | {objective:.4} | {derivative:.4} | {:.2} | {error:.0e} | {cpp}",
            case.name,
            derivative / objective,
        );
    }
    Ok(table)
}

/// Returns the times of objective and derivative in milliseconds, and the error of the answer.
fn measure(case: &Case) -> Result<([f64; 2], f64), Error> {
    let (mut problem, mut other) = (case.open()?, case.open()?);
    problem.derivative();
    problem.objective();
    let gap = gap(&problem.answer(), &case.reference);
    if !gap.is_close() {
        return Err(Error::file(&case.file)(format!("wrong answer: {gap:?}")));
    }
    let mut works: [&mut dyn FnMut(); 2] =
        [&mut || problem.objective(), &mut || other.derivative()];
    let seconds = in_turns(&mut works, SAMPLE, SAMPLES);
    Ok(([seconds[0] * 1e3, seconds[1] * 1e3], gap.error))
}
