//! `cosmic evaluate` with results that are not finite: its messages and files.

use crate::cli_evaluate::{evaluate, folder};
use crate::common::Bench;
use crate::program::{Told, has};
use serde_json::{Value, json};
use std::fs;

/// A key of `[physics]`: a time step that is far too long.
const WILD: &str = "dt = 0.5";

/// The last line on standard error, which has the error.
fn news(told: &Told) -> &str {
    told.error.lines().last().unwrap()
}

#[test]
fn a_divergence_is_reported_saved_and_can_be_replayed() {
    let folder = folder(WILD);
    let told = evaluate(&folder, "case.json --gradient");
    told.fails(
        3,
        &[
            "cosmic evaluate diverged.json",
            "these results are not finite and were written as null: ",
            "trajectory.2048.x",
        ],
    );
    let news_now = news(&told);
    assert!(news_now.starts_with("error: diverged in step "), "{told:?}");
    has(news_now, &[": node ", " m, velocity ["]);
    let json: Value = serde_json::from_str(&told.out).unwrap();
    assert!(json["results"]["l_disp"].is_null());

    let again = evaluate(&folder, "diverged.json");
    assert_eq!((again.code, news(&again)), (3, news_now));
    let kept = folder.json("diverged.json");
    assert_eq!(kept["format"], "cosmic-case");
    let states = kept["results"]["trajectory"].as_object().unwrap();
    assert!(states.contains_key(&kept["steps"].to_string()) && states.len() > 1);
}

/// If the snap has made the design a layout (one material per edge), `diverged.json` has exactly this layout.
#[test]
fn a_diverging_layout_can_be_replayed() {
    let text = "base = \"stability\"\n[start]\nkind = \"layout\"\n[schedule]\nsnap_at = 0\n[physics]\ndt = 0.2\n";
    let folder = Bench::with(text);
    let first = evaluate(&folder, "tiny.toml");
    first.fails(3, &[]);
    let again = evaluate(&folder, "diverged.json");
    assert_eq!((again.code, news(&again)), (3, news(&first)));
    let [shares, first] = [again, first].map(|told| {
        let json: Value = serde_json::from_str(&told.out).unwrap();
        json["results"]["z_projected"].as_array().unwrap().clone()
    });
    assert_eq!(shares, first);
    assert!(shares.contains(&json!([1.0, 0.0, 0.0])));
}

#[test]
fn the_last_states_lie_beside_the_results() {
    let folder = folder(WILD);
    fs::create_dir(folder.path("sub")).unwrap();
    evaluate(&folder, "case.json --out sub/results.json").fails(3, &[]);
    let exists = |name: &str| folder.path(name).exists();
    assert!(exists("sub/diverged.json") && exists("sub/results.json"));
    assert!(!exists("diverged.json"));

    let says = "error: --out: diverged.json is reserved for the last states";
    evaluate(&folder, "case.json --out diverged.json").fails(2, &[says]);
    assert!(!exists("diverged.json"));
    #[cfg(unix)]
    {
        // No file can be written beside a device, so the states are written to the current folder.
        evaluate(&folder, "case.json --out /dev/null").fails(3, &[]);
        assert!(exists("diverged.json"));
        assert!(!std::path::Path::new("/dev/diverged.json").exists());
    }
}

/// Without damping, small changes grow without bound. So all states are finite, but the derivatives overflow.
#[test]
fn a_gradient_that_overflows_is_an_error() {
    let folder = Bench::with("base = \"stability\"\n[physics]\ndamping = 0.0\n");
    evaluate(&folder, "tiny.toml").ok();
    let told = evaluate(&folder, "tiny.toml --gradient");
    let says = "error: these results are not finite: grad_augmented.z, grad_l_disp.b1, ";
    told.fails(3, &[says, "; take fewer steps"]);
    assert!(!folder.path("diverged.json").exists());
}
