//! `cosmic optimize --search halving`: weak starts are dropped early.

use crate::common::{Bench, scene};
use serde_json::Value;
use std::fs;

/// A search that drops weak starts after three of its 24 iterations: one during the co-design, one after the snap, and
/// the last one.
const RUNGS: &str = "[search]\nrungs = [8, 20, 24]\nkeep = [0.5, 0.5, 0.5]\nwindow = 4\n";

fn tiny() -> Bench {
    Bench::with(&(scene(24, 64, "") + RUNGS))
}

const SEARCH: &str = "--starts 5 --search halving";

/// The number of iterations that a start has done.
fn iterations(bench: &Bench, seed: u64) -> u64 {
    let snapshot = bench.json(&format!("a/starts/{seed}/snapshot.json"));
    snapshot["progress"]["iteration"].as_u64().unwrap()
}

#[test]
fn weak_starts_stop_at_a_rung_and_the_others_are_whole_runs() {
    let bench = tiny();
    let said = bench.run("a", SEARCH);
    let search = bench.json("a/search.json");
    let rungs = search["rungs"].as_array().unwrap();
    // The search has five starts, then three, then two. The rung at the last iteration drops none.
    let sizes: Vec<_> = rungs
        .iter()
        .map(|rung| (rung["standings"].as_array().unwrap().len(), &rung["kept"]))
        .collect();
    assert_eq!(sizes, [(5, &Value::from(3)), (3, &Value::from(2))]);
    let summary = bench.json("a/summary.json");
    let starts = summary["starts"].as_array().unwrap();
    for (seed, start) in (0..5).zip(starts) {
        assert_eq!(start["seed"], seed);
        let done = start["dropped_at"].as_u64();
        assert_eq!(iterations(&bench, seed), done.unwrap_or(24));
        let told = format!("start {seed}: dropped after iteration");
        assert_eq!(said.out.contains(&told), done.is_some(), "{}", said.out);
        assert_eq!(start["displacement_robust_p50"].is_null(), done.is_some());
    }
    let dropped = |start: &&Value| start["dropped_at"].is_u64();
    assert_eq!(starts.iter().filter(dropped).count(), 3);
    // A start that survives has the same results as a run of its seed alone.
    let best = summary["seed"].to_string();
    bench.run("alone", &format!("--seed {best}"));
    let [all, alone] = ["a", "alone"].map(|run| bench.results(run));
    for (name, bytes) in alone {
        assert_eq!(all[&format!("starts/{best}/{name}")], bytes, "{name}");
    }
}

/// For this task, starts are not ranked by displacement but by the median of minus the loss. The median is taken over
/// the last iterations before starts are dropped.
#[test]
fn starts_are_ranked_by_the_merit_of_their_task() {
    let bench = Bench::with(&(scene(24, 64, "") + RUNGS + "[objective]\ntask = \"climb\"\n"));
    bench.run("a", SEARCH);
    let search = bench.json("a/search.json");
    let rung = &search["rungs"][0];
    let median = |seed: &Value, of: &str| {
        let rows = bench.rows(&format!("a/starts/{seed}/history.jsonl"));
        let rung = rows[4..8].iter();
        let mut numbers: Vec<f64> = rung.map(|row| row[of].as_f64().unwrap()).collect();
        numbers.sort_by(f64::total_cmp);
        0.5 * (numbers[1] + numbers[2])
    };
    let standings = rung["standings"].as_array().unwrap();
    let merits = standings.iter().map(|s| s["merit"].as_f64().unwrap());
    assert!(merits.clone().is_sorted_by(|a, b| a > b), "{standings:?}");
    let mut by_displacement = standings.clone();
    let of = |s: &Value| s["displacement"].as_f64().unwrap();
    by_displacement.sort_by(|a, b| of(b).total_cmp(&of(a)));
    assert_ne!(&by_displacement, standings);
    for (standing, merit) in standings.iter().zip(merits) {
        let seed = &standing["seed"];
        assert_eq!(merit, median(seed, "merit_horizon"));
        assert_eq!(of(standing), median(seed, "displacement_horizon"));
    }
}

/// A search pauses each start at the iterations in which weak starts are dropped. These pauses do not change the random
/// numbers of later iterations.
#[test]
fn robust_and_tilted_starts_are_paused_without_a_trace() {
    let more = "[robust]\nsamples = 2\n[start]\nkind = \"uniform\"\ntilt = 0.1\n";
    let bench = Bench::with(&(scene(24, 64, "") + RUNGS + more));
    bench.run("a", SEARCH);
    let best = bench.json("a/summary.json")["seed"].to_string();
    bench.run("alone", &format!("--seed {best}"));
    let [all, alone] = ["a", "alone"].map(|run| bench.results(run));
    let kept = &all[&format!("starts/{best}/design.json")];
    assert_eq!(*kept, alone["design.json"]);
    bench.run("other", "--seed 77");
    assert_ne!(
        bench.read("other/design.json"),
        bench.read("alone/design.json")
    );
}

#[test]
fn the_search_depends_on_neither_threads_nor_interruptions() {
    let bench = tiny();
    bench.run("a", SEARCH);
    bench.run("b", &format!("{SEARCH} --threads 3"));
    assert_eq!(bench.results("a"), bench.results("b"));
    // Make the state that a kill between two rungs leaves: there is no summary, one start is unfinished and another has
    // not begun.
    let best = bench.json("a/summary.json")["seed"].as_u64().unwrap();
    let other = (0..5).find(|&seed| seed != best).unwrap();
    let whole = bench.results("a");
    for name in ["summary.json", "search.json", "design.json"] {
        bench.remove(&format!("a/{name}"));
    }
    fs::remove_dir_all(bench.path(&format!("a/starts/{other}"))).unwrap();
    bench.remove(&format!("a/starts/{best}/summary.json"));
    // A full disk may leave such an incomplete line.
    let history = format!("a/starts/{best}/history.jsonl");
    bench.write(&history, bench.read(&history) + "{\"format\":\"cosm");
    bench.ok("resume a");
    assert_eq!(bench.results("a"), whole);
}

#[test]
fn a_search_needs_several_starts_and_rungs_that_ascend() {
    let said = Bench::default().optimize("a", "--search halving");
    said.fails(2, &["--starts"]);
    let refused = |rungs: &str, says: &[&str]| {
        let bench = Bench::with(&(scene(24, 64, "") + "[search]\nrungs = " + rungs + "\n"));
        bench.optimize("a", SEARCH).fails(2, says);
        assert!(!bench.path("a").exists());
    };
    let says = "`search.rungs` is [30, 20, 40]; the numbers must ascend";
    refused("[30, 20, 40]", &[says]);
    let says = [
        "`search.rungs` is out of range: 0",
        "each from 1 to 1e5",
        "tiny.toml:",
    ];
    refused("[0, 8, 20]", &says);
}

#[test]
fn a_start_whose_history_lacks_rows_is_refused() {
    let bench = tiny();
    bench.run("a", SEARCH);
    bench.remove("a/summary.json");
    bench.write("a/starts/0/history.jsonl", "");
    let says = "starts/0/history.jsonl: expected 8 lines up to the rung, found 0";
    bench.fails("resume a", 2, &[says]);
    bench.remove("a/starts/0/history.jsonl");
    bench.fails("resume a", 4, &[]);
}
