//! Collects the numbers of a finished run from its summary and its measurements.

use super::check::Check;
use super::walks::Walks;
use cosmic::error::Result;
use cosmic::keys::{Keyed, columns};
use cosmic::record::Summary;
use cosmic::record::summary::ratio;
use std::path::Path;

/// The summary and the measurements of a finished run.
struct Finished {
    summary: Summary,
    check: Check,
    walks: Option<Walks>,
}

/// Returns all numbers of a run, each with the name of its column. A number is NaN if a rollout diverged. It is `None`
/// if it is a ratio and the robot is unreliable, because such a ratio is meaningless. `folder` is `None` for a run that
/// diverged. `length` is the extent of the lattice along the ground at rest, m.
///
/// # Errors
/// If a record is missing or malformed.
pub(crate) fn numbers(
    folder: Option<&Path>,
    length: f64,
    frictions: &[f64],
) -> Result<Vec<(String, Option<f64>)>> {
    let read = |folder: &Path| -> Result<Finished> {
        Ok(Finished {
            summary: Summary::read(folder)?,
            check: Check::read(folder)?,
            walks: Walks::read(folder)?,
        })
    };
    let run = folder.map(read).transpose()?;
    let mut numbers = Vec::new();
    let mut add = |name: String, of: &dyn Fn(&Finished) -> Option<f64>| {
        // For an unreliable robot, a ratio to its displacement is meaningless.
        let is_ratio = name.contains("keeps") || name.contains("agrees");
        let is_left_out = is_ratio && run.as_ref().is_some_and(|run| run.summary.is_unreliable());
        let number = run.as_ref().and_then(of).unwrap_or(f64::NAN);
        numbers.push((name, (!is_left_out).then_some(number)));
    };
    let of_summary = run.as_ref().map(|run| run.summary.numbers());
    for (k, name) in columns(&Summary::keys()).into_iter().enumerate() {
        add(name.to_owned(), &|_| of_summary.as_ref()?[k]);
    }
    for (name, of) in Check::NUMBERS {
        add(name.to_owned(), &|run| of(&run.check));
    }
    type OfWalks = fn(&Walks, usize, Option<f64>) -> Option<f64>;
    let of_walks: [(&str, OfWalks); 4] = [
        ("mujoco", |walks, k, _| walks.there(k)),
        ("coulomb", |walks, k, _| walks.own(k)),
        ("keeps", |walks, k, far| ratio(walks.there(k), far)),
        ("agrees", |walks, k, _| ratio(walks.there(k), walks.own(k))),
    ];
    for (name, of) in of_walks {
        for (k, friction) in frictions.iter().enumerate() {
            let of = |run: &Finished| of(run.walks.as_ref()?, k, run.summary.displacement_p50);
            add(format!("{name}_{friction}"), &of);
        }
    }
    add("clock_keeps".to_owned(), &|run| run.summary.clock_keeps());
    add("spread".to_owned(), &|run| {
        Some(run.summary.displacement_p90? - run.summary.displacement_p10?)
    });
    add("reliable".to_owned(), &|run| {
        Some(f64::from(!run.summary.is_unreliable()))
    });
    add("lengths".to_owned(), &|run| {
        let moved = run.summary.displacement_p50?;
        (length > 0.0).then(|| moved / length)
    });
    add("steered".to_owned(), &|run| {
        let [ahead, behind] = [run.summary.displacement_p50?, run.check.goal_behind?];
        Some(f64::from(ahead > 0.0 && behind < 0.0))
    });
    Ok(numbers)
}
