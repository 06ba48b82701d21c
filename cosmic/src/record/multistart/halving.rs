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
    pub(super) fn dropped_at(&self, seed: u64) -> Option<usize> {
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
    fn new(iteration: usize, mut standings: Vec<Standing>, keep: f64) -> Self {
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
fn median(before: &[Record], window: usize, of: fn(&Record) -> Option<f64>) -> Option<f64> {
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

#[cfg(test)]
mod tests {
    use super::{FORMAT, Halving, Rung, SEARCH, Standing, folder_of, median};
    use crate::Registry;
    use crate::codesign::Record;
    use crate::codesign::tests::{Up, records, tiny};
    use crate::record::files::read_json;
    use crate::record::{RunPlan, Search, history, optimise};
    use crate::scene::Scene;
    use std::num::NonZeroUsize;

    /// A rung for starts with these merits and the seeds 3, 4, and so on.
    fn rung(merits: &[Option<f64>], keep: f64) -> Rung {
        let standing = |(seed, &merit)| Standing {
            seed,
            displacement: None,
            merit,
        };
        Rung::new(40, (3..).zip(merits).map(standing).collect(), keep)
    }

    #[test]
    fn the_best_share_continues_and_the_rest_is_dropped() {
        let rungs = vec![rung(&[Some(0.5), None, Some(2.0), Some(0.5)], 0.5)];
        let order: Vec<u64> = rungs[0].standings.iter().map(|s| s.seed).collect();
        assert_eq!((order, rungs[0].kept), (vec![5, 3, 6, 4], 2));
        let search = Halving { rungs };
        let dropped = [5, 3, 6, 4].map(|seed| search.dropped_at(seed));
        assert_eq!(dropped, [None, None, Some(40), Some(40)]);
        // At least one start continues.
        for (starts, keep, kept) in [(2, 0.0, 1), (2, 1.0, 2), (10, 0.7, 7)] {
            assert_eq!(rung(&vec![None; starts], keep).kept, kept);
        }
    }

    #[test]
    fn the_snap_does_not_count_in_the_median() {
        let mut scene = tiny();
        scene.schedule.iterations = 4;
        (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 4);
        let rows = records(&scene);
        let reached = |row: &Record| row.displacement_horizon;
        assert_eq!(rows[3].displacement_horizon, None);
        assert_eq!(median(&rows, 1, reached), rows[2].displacement_horizon);
        assert_eq!(median(&rows, 8, reached), median(&rows[..3], 8, reached));
        assert_eq!(median(&rows[3..], 8, reached), None);
    }

    /// Starts are ranked by their merit. Their displacements would give another order.
    #[test]
    fn starts_are_ranked_by_a_user_s_loss_and_by_the_worse_of_two_goals() {
        let mut scene = tiny();
        scene.search.rungs = [4, 20, 20];
        (scene.search.keep, scene.search.window) = ([0.5; 3], 3);
        let check = |scene: &Scene| {
            let folder = tempfile::tempdir().unwrap();
            let plan = RunPlan {
                starts: NonZeroUsize::new(6).unwrap(),
                search: Search::Halving,
                ..RunPlan::new("tiny", scene.clone(), 0)
            };
            optimise(folder.path(), &plan, &mut ()).unwrap();
            let search: Halving = read_json(&folder.path().join(SEARCH), FORMAT).unwrap();
            let standings = &search.rungs[0].standings;
            let merit = |s: &Standing| s.merit.unwrap();
            assert!(standings.is_sorted_by(|a, b| merit(a) >= merit(b)));
            for s in standings {
                let rows = history::read(&folder_of(folder.path(), s.seed), 4).unwrap();
                assert_eq!(s.merit, median(&rows, 3, |row| row.merit_horizon));
            }
            let far = |s: &Standing| s.displacement.unwrap();
            assert!(
                !standings.is_sorted_by(|a, b| far(a) >= far(b)),
                "{standings:?}"
            );
        };
        let mut two = scene.clone();
        (two.controller.two_goals, two.controller.goal_scale) = (true, 3.0);
        check(&two);
        let own = scene.knowing(&Registry::default().with_loss("up", Up));
        check(&own.set(&["objective.own_loss=up"]).unwrap());
    }
}
