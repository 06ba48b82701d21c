//! Compares the drivers of this crate with those of NLopt on the test problems.

#[path = "../tests/problems.rs"]
mod problems;

use std::cell::RefCell;

use cosmic_optimiser::{Problem, Solution, Stop, augmented, mma};
use problems::CASES;

fn main() {
    for case in CASES {
        for (name, run) in [
            (
                "gcmma",
                run_conservative as fn(&mut Problem<'_>, &[f64]) -> Solution,
            ),
            ("plain", run_plain),
            ("augmented", run_augmented),
        ] {
            if case.equalities > 0 && name != "augmented" {
                continue;
            }
            let near: RefCell<Option<usize>> = RefCell::new(None);
            let count = RefCell::new(0);
            let values = |x: &[f64]| {
                let v = (case.values)(x);
                *count.borrow_mut() += 1;
                if near.borrow().is_none()
                    && case.excess(v[0]).abs() < 1e-6
                    && case.violation(&v[1..]) < 1e-6
                {
                    *near.borrow_mut() = Some(*count.borrow());
                }
                v
            };
            let [lower, upper] = case.bounds();
            let mut problem = Problem::new(&lower, &upper, values, case.gradients)
                .with_equalities(case.equalities);
            let s = run(&mut problem, case.start);
            drop(problem);
            println!(
                "{:8} {:10} near {:?} values {} gradients {} it {} excess {:.1e} violation {:.1e} kkt {:.1e} {:?}",
                case.name,
                name,
                near.borrow().unwrap_or(0),
                s.value_evaluations,
                s.gradient_evaluations,
                s.iterations,
                case.excess(s.objective),
                s.violation,
                s.kkt,
                s.status
            );
        }
    }
}

fn run_conservative(p: &mut Problem<'_>, start: &[f64]) -> Solution {
    mma::minimise(p, start, &mma::Options::default()).unwrap()
}
fn run_plain(p: &mut Problem<'_>, start: &[f64]) -> Solution {
    mma::minimise(
        p,
        start,
        &mma::Options {
            variant: mma::Variant::Plain,
            ..Default::default()
        },
    )
    .unwrap()
}
fn run_augmented(p: &mut Problem<'_>, start: &[f64]) -> Solution {
    augmented::minimise(p, start, &Stop::default()).unwrap()
}
