//! Wrong scenes: each is refused at its line and column, with what is wrong and what is allowed
//! there.

use cosmic::scene::Scene;
use cosmic::{Error, error};
use proptest::prelude::*;
use std::fs;

/// Message and full report of the refusal of a text, in which `^` marks the place of the fault.
fn refusal(text: &str) -> (String, String) {
    let (before, after) = text.split_once('^').unwrap();
    match Scene::parse("my.toml", &[before, after].concat()) {
        Err(Error::Malformed {
            file,
            line,
            column,
            message,
            report,
        }) => {
            let last = before.rsplit('\n').next().unwrap();
            let place = (before.matches('\n').count() + 1, last.chars().count() + 1);
            assert_eq!((line, column), place, "{report}");
            assert_eq!(file, "my.toml");
            let place = format!("my.toml:{line}:{column}");
            assert!(report.contains(&place), "{report}");
            (message, report)
        }
        other => panic!("{text:?} gave {other:?}"),
    }
}

/// Wrong scenes, what is said of them, and what is allowed there.
const WRONG: [(&str, &str, &str); 43] = [
    (
        "base = ^\"eart\"",
        "`base` names an unknown built-in scene: \"eart\"",
        "did you mean `earth`?",
    ),
    (
        "base = ^\"my.toml\"",
        "`base` names an unknown built-in scene: \"my.toml\"",
        "known: earth, stability",
    ),
    (
        "base = ^3",
        "`base` must be the name of a scene, not 3",
        "known: earth",
    ),
    (
        "[physics]\n^base = \"earth\"",
        "unknown key `base` in [physics]",
        "above the first section",
    ),
    (
        "format = \"cosmic-scene\"\nversion = ^3",
        "`version` is out of range: 3",
        "reads versions up to 2",
    ),
    (
        "format = ^\"cosmic-design\"\nversion = 1",
        "`format` is not a known format: \"cosmic-design\"",
        "allowed: \"cosmic-scene\"",
    ),
    (
        "version = ^1",
        "`version` cannot be used alone: 1",
        "begins with format = \"cosmic-scene\" and a version",
    ),
    (
        "^format = \"cosmic-scene\"\nversion = 1\nphysics.dt = 0.001",
        "`lattice.columns`, `lattice.rows`, `lattice.spacing` and ",
        "must hold every key of its version",
    ),
    (
        "[loss]\n^version = 1",
        "unknown key `version` in [loss]",
        "above the first section",
    ),
    (
        "^bse = \"earth\"",
        "unknown section `bse`",
        "did you mean `base`?",
    ),
    (
        "[physics]\n^stpes = 3",
        "unknown key `stpes` in [physics]",
        "did you mean `steps`?",
    ),
    (
        "[^physcs]\ndt = 0.1",
        "unknown section `physcs`",
        "did you mean `physics`?",
    ),
    (
        "^dt = 0.1",
        "unknown section `dt`",
        "known: lattice, physics",
    ),
    (
        "[lattice]\n^dt = 0.1",
        "unknown key `dt` in [lattice]",
        "belongs to [physics]",
    ),
    (
        "physics = ^3",
        "is a whole number, not a section",
        "write [physics]",
    ),
    (
        "[physics]\ndt = ^\"fast\"",
        "`physics.dt` is a string: \"fast\"",
        "from 1e-9 to 1",
    ),
    (
        "[physics]\ndt = ^5.0",
        "`physics.dt` is out of range: 5.0",
        "from 1e-9 to 1",
    ),
    ("[physics]\ndt = ^0", "out of range: 0", "from 1e-9 to 1"),
    (
        "[physics]\ngravity = ^nan",
        "out of range: nan",
        "a number from -1000 to 1000",
    ),
    (
        "[physics]\ngravity = ^-inf",
        "out of range: -inf",
        "a number from",
    ),
    (
        "[physics]\ngravity = ^1e999",
        "out of range: 1e999",
        "a number from",
    ),
    (
        "[physics]\nsteps = ^1.5",
        "is a number with a point",
        "a whole number from 1",
    ),
    (
        "[physics]\nsteps = ^-1",
        "out of range: -1",
        "a whole number from 1 to 1e6",
    ),
    (
        "[physics]\nsteps = ^99999999999999999999999999",
        "out of range",
        "whole number",
    ),
    (
        "[physics]\nsteps = ^0xffffffffffffffffff",
        "out of range",
        "whole number",
    ),
    (
        "[physics]\ncontact = ^\"sticky\"",
        "names an unknown law: \"sticky\"",
        "\"infinite\" or",
    ),
    ("[lattice]\ncolumns = ^1", "out of range: 1", "from 2 to 64"),
    (
        "[controller]\ngoal = ^[1.0]",
        "has 1 entries",
        "2 numbers, each from",
    ),
    (
        "[controller]\ngoal = [1.0, ^\"é\"]",
        "is a string",
        "2 numbers, each from",
    ),
    (
        "[controller]\ngoal_relative = ^1",
        "is a whole number",
        "true or false",
    ),
    (
        "[materials]\ndensity = ^[1, 2, 3, 4]",
        "has 4 entries",
        "3 numbers",
    ),
    (
        "[schedule]\ncycle = ^\"dce\"",
        "cannot be \"dce\"",
        "letters d and c",
    ),
    (
        "[schedule]\ncycle = ^\"\"",
        "cannot be \"\"",
        "letters d and c",
    ),
    (
        "[adam]\ngradient_norm = ^\"of\"",
        "is a string",
        "or \"off\"",
    ),
    ("[physics]\ndt = ^2000-01-01", "is a date", "a number"),
    (
        "^[[physics]]\ndt = 0.1",
        "is an array, not a section",
        "write [physics]",
    ),
    (
        "[ground]\npoints = [[0.1, 0.0], [0.2, 0.1], ^[0.2, 0.3]]",
        "`ground.points` is not ahead of the point before it: [0.2, 0.3]",
        "along increasing",
    ),
    (
        "[ground]\npoints = [[0.1, 0.0], ^[0.2]]",
        "`ground.points` has 1 entries",
        "pairs [along, height]",
    ),
    (
        "[ground]\npoints = [[0.1, ^2e3]]",
        "`ground.points` is out of range: 2e3",
        "each number from -1000 to 1000",
    ),
    (
        "[ground]\npoints = ^3",
        "`ground.points` is a whole number: 3",
        "up to 64 pairs",
    ),
    (
        "[ground]\nprofile = ^\"bumpy\"",
        "cannot be \"bumpy\"",
        "\"flat\" or \"points\" or \"steps\" or \"rough\"",
    ),
    ("[physics^\ndt = 0.1", "not TOML", "unclosed table"),
    (
        "[physics]\ndt = 0.1\n^dt = 0.2",
        "not TOML: duplicate key",
        "",
    ),
];

#[test]
fn wrong_scenes_are_refused_where_they_are_wrong() {
    for (text, says, allowed) in WRONG {
        let (message, report) = refusal(text);
        assert!(message.contains(says), "{text:?}: {message}");
        assert!(report.contains(allowed) && report.contains('^'), "{report}");
    }
}

/// Scenes whose settings contradict one another, and what is said.
const AT_ODDS: [(&str, &str); 16] = [
    (
        "[ground]\nprofile = ^\"rough\"\nspacing = 1e-20",
        "that is not ahead of",
    ),
    (
        "[schedule]\nsnap_at = ^400",
        "the snap (iteration 400) comes after the last",
    ),
    (
        "[schedule]\niterations = ^100",
        "comes after the last iteration (100)",
    ),
    (
        "[schedule]\nattraction_from = ^250",
        "after the snap (iteration 240)",
    ),
    ("[schedule]\nsnap_at = ^0", "the start must be a layout"),
    (
        "[start]\nkind = ^\"layout\"",
        "nothing to snap at iteration 240: set snap_at = 0",
    ),
    (
        "[lattice]\nrows = ^5\n[start]\nkind = \"three_legged\"",
        "6x6 nodes, not 6x5",
    ),
    (
        "[physics]\nsteps = ^512",
        "the horizon (4096 steps) is longer",
    ),
    (
        "[schedule]\nhorizon = ^[512, 512]",
        "the shortest horizon has (512)",
    ),
    ("[loss]\nevery = ^4096", "every 4096th step, of only 2048"),
    (
        "[volume]\nsolid = ^[0.1, 0.1]",
        "the smallest share of actuators (0.2)",
    ),
    (
        "[volume]\nsolid = ^[0.6, 0.5]",
        "the first entry (0.6) is above the second (0.5)",
    ),
    ("[mma]\nasymin = ^20", "above the largest (10)"),
    (
        "[ground]\nprofile = ^\"points\"",
        "the profile `points` has no points: set ground.points",
    ),
    (
        "[ground]\nprofile = \"steps\"\nramp = ^0.4",
        "the ramp of a step is 0.4 m long, and the next step begins after 0.3 m",
    ),
    (
        "[ground]\nprofile = \"steps\"\ncount = ^40",
        "there are 40 steps; at most 32 are allowed",
    ),
];

#[test]
fn settings_at_odds_are_pointed_at() {
    for (text, says) in AT_ODDS {
        let (message, _) = refusal(text);
        assert!(message.contains(says), "{text:?}: {message}");
    }
}

#[test]
fn a_profile_has_64_points_at_most() {
    let points = |n: usize| (0..n).map(|k| [k as f64, 0.0]).collect::<Vec<_>>();
    let text = |n| format!("[ground]\nprofile = \"points\"\npoints = ^{:?}", points(n));
    let (message, _) = refusal(&text(65));
    assert!(message.contains("has 65 points"), "{message}");
    let scene = Scene::parse("most", &text(64).replace('^', "")).unwrap();
    assert_eq!(scene.physics.ground.resolved().points(), points(64));
}

#[test]
fn every_fault_is_reported_and_a_flood_is_cut() {
    let (_, report) = refusal("[physics]\ndt = ^9.0\nsteps = \"x\"\n[lattice]\nrows = 0");
    assert_eq!(report.matches("error: ").count(), 3, "{report}");
    let flood: String = (0..30).map(|n| format!("key{n} = 1\n")).collect();
    let (_, report) = refusal(&format!("[physics]\n^{flood}"));
    assert!(report.ends_with("... and 20 more"), "{report}");
}

#[test]
fn unreadable_files_are_told_from_malformed_ones() {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| Scene::read(&folder.path().join(name)).unwrap_err();
    let code = |name: &str| read(name).exit_code();
    assert_eq!(code("missing.toml"), 4);
    assert_eq!(code("."), 4);
    let latin = b"[physics]\n# \xe9t\xe9\n";
    fs::write(folder.path().join("latin1.toml"), latin).unwrap();
    assert_eq!(code("latin1.toml"), 2);
    match read("latin1.toml") {
        Error::Malformed {
            line: 2,
            column: 3,
            message,
            ..
        } => assert!(message.contains("0xe9")),
        other => panic!("{other:?}"),
    }
    fs::write(folder.path().join("huge.toml"), vec![b'#'; 2 << 20]).unwrap();
    assert_eq!(code("huge.toml"), 2);
    assert!(read("huge.toml").to_string().contains("1048576 bytes"));
}

/// Any text is read as a scene or refused with a place inside the text.
fn survives(text: &str) -> error::Result<()> {
    match Scene::parse("any", text) {
        Err(Error::Malformed { line, column, .. }) => {
            assert!(line >= 1 && column >= 1 && line <= text.matches('\n').count() + 1);
            Ok(())
        }
        other => other.map(drop),
    }
}

/// Deeper than a recursive reader likes.
const NESTED: &str = match str::from_utf8(&[b'['; 4000]) {
    Ok(text) => text,
    Err(_) => "",
};

proptest! {
    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("any.toml");
        fs::write(&file, &bytes).unwrap();
        let _ = Scene::read(&file);
        survives(&String::from_utf8_lossy(&bytes)).unwrap();
    }

    #[test]
    fn no_mutation_of_a_scene_makes_the_reader_panic(
        at in any::<prop::sample::Index>(),
        cut in 0..40usize,
        inserted in prop::sample::select(vec![
            "", "nan", "[", "]", "\"", "\"\"\"", "=", "\n", "\r", "\t", "\0",
            "é", "🤖", "{", "1e999", "-", "'",
            NESTED,
        ]),
    ) {
        let mut text = Scene::paper().to_toml();
        let from = at.index(text.len());
        let to = (from + cut).min(text.len());
        text.replace_range(from..to, inserted);
        survives(&text).unwrap();
    }
}
