//! Compares the drivers of this crate with those of NLopt on the test problems. Prints the table of the README.
//!
//! `comparison.py`, which runs NLopt, gets the values and gradients from this program: `comparison serve` answers each
//! line `NAME x_0 x_1 ...` with a line of all values and a line of all gradients.

#[path = "../tests/problems.rs"]
mod problems;

use std::io::{BufRead, stdin};

use problems::{CASES, DRIVERS, Effort, NLOPT, run};

fn main() {
    if std::env::args().nth(1).as_deref() == Some("serve") {
        return serve();
    }
    let nlopt: Vec<(&str, &str, Effort)> = NLOPT.lines().filter_map(Effort::parse).collect();
    for (equalities, drivers, rivals) in [
        (false, &DRIVERS[..2], ["MMA", "CCSAQ"]),
        (true, &DRIVERS[2..], ["AUGLAG", "SLSQP"]),
    ] {
        let ours = drivers.iter().map(|(name, _)| *name);
        let names: Vec<&str> = ours.chain(rivals).collect();
        println!("| problem | {} |", names.join(" | "));
        println!("| --- |{}", " --: |".repeat(names.len()));
        for case in CASES
            .iter()
            .filter(|case| (case.equalities > 0) == equalities)
        {
            let ours = drivers.iter().map(|(_, driver)| run(case, *driver).1);
            let found = |rival: &str| {
                let row = nlopt
                    .iter()
                    .find(|row| (row.0, row.1) == (case.name, rival));
                row.expect("comparison.py runs every problem").2
            };
            let cells: Vec<String> = ours
                .chain(rivals.map(found))
                .map(|cell| cell.to_string())
                .collect();
            println!("| {} | {} |", case.name, cells.join(" | "));
        }
        println!();
    }
}

/// Answers lines from the standard input. A line without a name lists the problems.
fn serve() {
    let text = |numbers: &[f64]| {
        let words: Vec<String> = numbers.iter().map(f64::to_string).collect();
        words.join(" ")
    };
    for line in stdin().lock().lines().map_while(Result::ok) {
        let mut words = line.split_whitespace();
        let name = words.next();
        let Some(case) = CASES.iter().find(|case| Some(case.name) == name) else {
            for case in CASES {
                let [lower, upper] = case.bounds();
                let numbers = [text(case.start), text(&lower), text(&upper)].join(" ");
                println!(
                    "{} {} {} {numbers}",
                    case.name, case.equalities, case.optimum
                );
            }
            println!();
            continue;
        };
        let x: Vec<f64> = words.map(|word| word.parse().expect("a number")).collect();
        println!(
            "{}\n{}",
            text(&(case.values)(&x)),
            text(&(case.gradients)(&x))
        );
    }
}
