//! The numbers of a study's runs, and of its trials over all seeds.

use super::check::Check;
use super::file::Trial;
use crate::export::Walks;
use crate::statistics::Statistics;
use crate::sweep::{RunState, SweepPlan};
use cosmic::error::Result;
use cosmic::record::Summary;
use cosmic::record::summary::{NUMBERS, ratio};
use std::path::{Path, PathBuf};

/// The column with the median displacement over perturbed starts, m: the number to quote.
pub(super) const DISPLACEMENT: &str = "displacement_p50";

/// The files of a finished run.
struct Finished {
    summary: Summary,
    check: Check,
    walks: Option<Walks>,
}

/// One run.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) seed: u64,
    /// True if the delivered design diverged.
    pub(super) diverged: bool,
    /// The version of MuJoCo, if the robot walked there.
    pub(super) mujoco: Option<String>,
    pub(super) folder: PathBuf,
    /// A number for each column: NaN if a rollout diverged, `None` if statistics leave it out.
    pub(super) numbers: Vec<(String, Option<f64>)>,
}

impl Run {
    fn read(folder: PathBuf, seed: u64, frictions: &[f64]) -> Result<Self> {
        let diverged = RunState::of(&folder) == RunState::Diverged;
        let read = || -> Result<Finished> {
            Ok(Finished {
                summary: Summary::read(&folder)?,
                check: Check::read(&folder)?,
                walks: Walks::read(&folder)?,
            })
        };
        let run = (!diverged).then(read).transpose()?;
        Ok(Self {
            seed,
            diverged,
            mujoco: run
                .as_ref()
                .and_then(|run| Some(run.walks.as_ref()?.mujoco.clone())),
            numbers: numbers(run.as_ref(), frictions),
            folder,
        })
    }

    /// The number of a column; `None` if a rollout diverged.
    pub(super) fn number(&self, column: &str) -> Option<f64> {
        let found = self.numbers.iter().find(|(name, _)| name == column);
        found
            .and_then(|(_, number)| *number)
            .filter(|x| x.is_finite())
    }
}

/// The numbers of a run, each with the name of its column; `run` is `None` if it diverged.
fn numbers(run: Option<&Finished>, frictions: &[f64]) -> Vec<(String, Option<f64>)> {
    type Number<'n> = &'n dyn Fn(&Finished) -> Option<f64>;
    let mut numbers = Vec::new();
    let mut add = |name: String, of: Number| {
        numbers.push((name, Some(run.and_then(of).unwrap_or(f64::NAN))));
    };
    for (name, of) in NUMBERS {
        add(name.to_owned(), &|run| of(&run.summary));
    }
    let of_check: [(&str, Number); 6] = [
        ("half_step_p50", &|run| run.check.half_step[1]),
        ("half_step_p10", &|run| run.check.half_step[0]),
        ("half_step_p90", &|run| run.check.half_step[2]),
        ("goal_behind_p50", &|run| run.check.goal_behind),
        ("one_hot", &|run| Some(f64::from(run.check.one_hot))),
        ("within_bounds", &|run| {
            Some(f64::from(run.check.within_bounds))
        }),
    ];
    for (name, of) in of_check {
        add(name.to_owned(), of);
    }
    for (name, of) in [
        ("mujoco", Walks::there as fn(&Walks, usize) -> _),
        ("coulomb", Walks::own),
    ] {
        for (k, friction) in frictions.iter().enumerate() {
            add(format!("{name}_{friction}"), &|run| {
                of(run.walks.as_ref()?, k)
            });
        }
    }
    add("spread".to_owned(), &|run| {
        Some(run.summary.displacement_p90? - run.summary.displacement_p10?)
    });
    add("steered".to_owned(), &|run| {
        let [ahead, behind] = [run.summary.displacement_p50?, run.check.goal_behind?];
        Some(f64::from(ahead > 0.0 && behind < 0.0))
    });
    let first_ratio = numbers.len();
    let mut add = |name: String, of: Number| {
        numbers.push((name, Some(run.and_then(of).unwrap_or(f64::NAN))));
    };
    add("clock_keeps".to_owned(), &|run| run.summary.clock_keeps());
    for (k, friction) in frictions.iter().enumerate() {
        add(format!("keeps_{friction}"), &|run| {
            ratio(run.walks.as_ref()?.there(k), run.summary.displacement_p50)
        });
        add(format!("agrees_{friction}"), &|run| {
            let walks = run.walks.as_ref()?;
            ratio(walks.there(k), walks.own(k))
        });
    }
    // Ratios to the displacement of an unreliable robot mean nothing.
    if run.is_some_and(|run| run.summary.is_unreliable()) {
        numbers[first_ratio..]
            .iter_mut()
            .for_each(|(_, number)| *number = None);
    }
    numbers
}

/// A trial over all its seeds.
#[derive(Clone, Debug)]
pub(super) struct TrialRow {
    pub(super) trial: Trial,
    pub(super) runs: Vec<Run>,
}

impl TrialRow {
    /// The numbers of a column, without those that statistics leave out.
    pub(super) fn sample(&self, column: &str) -> Vec<f64> {
        let number = |run: &Run| run.numbers.iter().find(|(name, _)| name == column)?.1;
        self.runs.iter().filter_map(number).collect()
    }

    /// The statistics of a column.
    pub(super) fn of(&self, column: &str) -> Statistics {
        Statistics::of(&self.sample(column))
    }

    /// The sum of a column without diverged runs. For a column of zeros and ones it is a count.
    pub(super) fn sum(&self, column: &str) -> usize {
        let numbers = self.sample(column).into_iter();
        numbers.filter(|x| x.is_finite()).sum::<f64>() as usize
    }

    /// The run that got farthest, the first of equals; `None` if all diverged.
    pub(super) fn best(&self) -> Option<&Run> {
        let runs = self.runs.iter().rev();
        let runs = runs.filter_map(|run| Some((run, run.number(DISPLACEMENT)?)));
        let farthest = runs.max_by(|(_, a), (_, b)| a.total_cmp(b));
        farthest.map(|(run, _)| run)
    }
}

/// Reads the records of all runs.
///
/// # Errors
/// If a record is missing or malformed.
pub(super) fn collect(
    sweep: &Path,
    plan: &SweepPlan,
    trials: Vec<Trial>,
    frictions: &[f64],
) -> Result<Vec<TrialRow>> {
    let seeds = plan.seeds.get();
    let run = |index: usize| Run::read(plan.folder(sweep, index), plan.parts(index).1, frictions);
    let row = |(k, trial): (usize, Trial)| {
        let runs = (k * seeds..(k + 1) * seeds)
            .map(run)
            .collect::<Result<_>>()?;
        Ok(TrialRow { trial, runs })
    };
    trials.into_iter().enumerate().map(row).collect()
}
