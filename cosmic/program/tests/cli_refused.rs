//! `cosmic optimize`: numbers that are not finite, and scenes that a program builds.

use crate::common::{Bench, scene};
use crate::program::has;
use cosmic::record::optimise;

/// The controller of this robot reacts to the slightest velocity. Therefore derivatives overflow although states do
/// not.
#[test]
fn gradients_that_are_not_finite_are_counted_and_skipped() {
    let chaos = "[controller]\nvelocity_scale = 1000.0\noffset_scale = 100.0\n\
                 [gradient]\ncotangent_bound = \"off\"\n";
    let bench = Bench::with(&(scene(12, 8192, "damping = 1.0") + chaos));
    let said = bench.run("a", "");
    let summary = bench.json("a/summary.json");
    let skipped = summary["skipped_gradients"].as_u64().unwrap();
    let rows = bench.rows("a/history.jsonl");
    assert_eq!(rows.len(), 12);
    let of_rows = rows.iter().map(|row| row["skipped"].as_u64().unwrap());
    assert_eq!(skipped, of_rows.sum::<u64>());
    assert!(skipped > 0 && summary["displacement_p50"].is_number());
    let says = format!("{skipped} gradients skipped");
    has(&said.error, &[&says]);
}

/// A scene that a program builds is checked like a scene file. Otherwise its run could not be resumed.
#[test]
fn a_scene_that_could_not_be_read_again_is_refused() {
    let bench = Bench::default();
    let mut plan = bench.plan();
    plan.scene.schedule.horizon = [8, 8];
    let refused = optimise(&bench.path("run"), &plan, &mut ()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    let says = "the shortest horizon has only 8";
    assert!(refused.to_string().contains(says), "{refused}");
    assert!(!bench.path("run").exists());
}
