//! Successive halving: weak starts are dropped early.
//!
//! All starts run up to a given iteration, which is called a rung. The best ones continue to the next rung. A dropped
//! start keeps its folder and its snapshot, and can be resumed by hand. Starts are ranked by numbers from their own
//! histories, so a search that is interrupted and resumed gives them the same ranks.

use super::starts::{folder_of, run_of, seeds, side_by_side};
use crate::codesign::{Record, is_ranked_by_distance};
use crate::error::{Result, fits};
use crate::objective::of_scene;
use crate::record::files::write_json;
use crate::record::format::Format;
use crate::record::history;
use crate::record::run::Observer;
use crate::record::snapshot::RunPlan;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The format of the record of a search.
pub const FORMAT: Format = Format::new("cosmic-search", 1);

/// The name of the record of a search, in the folder of several starts.
pub const SEARCH: &str = "search.json";

/// The record of a search. People and other programs read it, but a resumed search does not.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Halving {
    /// The iterations at which starts were dropped so far, in order, each with its ranking of the starts.
    pub rungs: Vec<Rung>,
}

/// An iteration after which starts are dropped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// The iteration.
    pub iteration: usize,
    /// The starts that reached this rung, best first.
    pub standings: Vec<Standing>,
    /// The number of starts that continue.
    pub kept: usize,
}

/// The rank of a start at a rung (an iteration after which starts are dropped).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Standing {
    /// The seed.
    pub seed: u64,
    /// The median of `displacement_horizon` over the last iterations before starts are dropped, in metres. `None` if at
    /// least half of the rollouts of these iterations diverged.
    pub displacement: Option<f64>,
    /// The number that starts are ranked by: the median of the merit over the same iterations. The merit is the
    /// displacement; for tasks other than distance, minus the loss. With two goals, it is the merit for the worse goal.
    pub merit: Option<f64>,
}

impl Halving {
    /// The iteration after which the start with this seed was dropped; `None` if it was not dropped.
    pub fn dropped_at(&self, seed: u64) -> Option<usize> {
        let drops = |rung: &&Rung| rung.standings[rung.kept..].iter().any(|s| s.seed == seed);
        self.rungs.iter().find(drops).map(|rung| rung.iteration)
    }
}

/// Runs the starts of a plan up to the last iteration at which starts are dropped, and drops the weak ones.
pub(super) fn climb(folder: &Path, plan: &RunPlan, observer: &mut dyn Observer) -> Result<Halving> {
    let settings = &plan.scene.search;
    let by_distance = is_ranked_by_distance(&plan.scene, &*of_scene(&plan.scene));
    let mut left: Vec<u64> = seeds(plan).collect();
    let mut search = Halving::default();
    for (&iteration, &keep) in settings.rungs.iter().zip(&settings.keep) {
        if iteration >= plan.last_iteration() || left.len() == 1 {
            break;
        }
        let standings = side_by_side(folder, &left, observer, |seed, observer| {
            if let Some(mut run) = run_of(folder, seed, plan, iteration)? {
                match run.advance(iteration, observer) {
                    // A start that diverged before the rung ranks last and does not stop the others.
                    Err(error) if error.is_of_rollouts() => {
                        return Ok(Standing {
                            seed,
                            displacement: None,
                            merit: None,
                        });
                    }
                    done => done?,
                }
            }
            let rows = rows(&folder_of(folder, seed), iteration)?;
            let displacement = median(&rows, settings.window, |row| row.displacement_horizon);
            let merit = if by_distance {
                displacement
            } else {
                median(&rows, settings.window, |row| row.merit_horizon)
            };
            Ok(Standing {
                seed,
                displacement,
                merit,
            })
        })?;
        let rung = Rung::new(iteration, standings, keep);
        left = rung.standings[..rung.kept].iter().map(|s| s.seed).collect();
        search.rungs.push(rung);
        write_json(&folder.join(SEARCH), FORMAT, &search)?;
    }
    Ok(search)
}

impl Rung {
    /// Ranks the starts by their merits (displacement or minus the loss), and keeps the share `keep` of the starts. Of
    /// starts with equal merits, the one with the lower seed ranks first.
    pub fn new(iteration: usize, mut standings: Vec<Standing>, keep: f64) -> Self {
        let rank = |s: &Standing| s.merit.unwrap_or(f64::NEG_INFINITY);
        standings.sort_by(|a, b| rank(b).total_cmp(&rank(a)).then(a.seed.cmp(&b.seed)));
        // Rounding must not turn a share of 0.7 of 10 starts into 8.
        let kept = (keep * standings.len() as f64 - 1e-9).ceil() as usize;
        Self {
            iteration,
            kept: kept.clamp(1, standings.len()),
            standings,
        }
    }
}

/// Reads the records of a start's iterations up to a rung (an iteration after which starts are dropped).
fn rows(folder: &Path, iteration: usize) -> Result<Vec<Record>> {
    let rows = history::read(folder, iteration)?;
    let file = folder.join(history::LINES).display().to_string();
    fits(&file, "lines up to the rung", rows.len(), iteration)?;
    Ok(rows)
}

/// The median of a number over the last `window` iterations; `None` if the median is not finite. The iteration of the
/// snap does not count, because it has no such number. This median predicts the final result of a start better than the
/// number of one full rollout does.
pub fn median(before: &[Record], window: usize, of: fn(&Record) -> Option<f64>) -> Option<f64> {
    let passes = before.iter().rev().filter(|row| row.pass.is_some());
    let reached = |row: &Record| of(row).unwrap_or(f64::NEG_INFINITY);
    let mut sorted: Vec<f64> = passes.take(window).map(reached).collect();
    if sorted.is_empty() {
        return None;
    }
    sorted.sort_by(f64::total_cmp);
    let (below, above) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
    let median = 0.5 * (below + above);
    median.is_finite().then_some(median)
}
