//! Wrong scenes: each is refused at its line and column, with what is wrong and what is allowed
//! there.

use cosmic::laws::ContactLaw;
use cosmic::scene::{
    BUILTIN, GradientPrecision, Integrator, Layout, LossKind, Pass, Scene, SelectionKind,
    StartKind, fault,
};
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
        "format = \"cosmic-scene\"\nversion = ^2",
        "`version` is out of range: 2",
        "reads versions up to 1",
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
        "`physics.dt` is a text: \"fast\"",
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
        "is a text",
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
    ("[adam]\ngradient_norm = ^\"of\"", "is a text", "or \"off\""),
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
        "the least share of actuators (0.2)",
    ),
    (
        "[volume]\nsolid = ^[0.6, 0.5]",
        "the first entry (0.6) is above the second (0.5)",
    ),
    ("[mma]\nasymin = ^20", "above the largest (10)"),
    (
        "[ground]\nprofile = ^\"points\"",
        "a profile of points has none: set ground.points",
    ),
    (
        "[ground]\nprofile = \"steps\"\nramp = ^0.4",
        "a step rises on 0.4 m, and the next begins after 0.3 m",
    ),
    (
        "[ground]\nprofile = \"steps\"\ncount = ^40",
        "there may be 32 steps, not 40",
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
fn what_is_left_out_is_the_base_s() {
    let load = |name| Scene::load(name).unwrap();
    for name in ["", "base = \"earth\"", "# a scene\n"] {
        assert_eq!(Scene::parse("empty", name).unwrap(), load("earth"));
    }
    assert_eq!(Scene::default(), load("earth"));
    for builtin in BUILTIN {
        let named = Scene::parse("named", &format!("base = {:?}", builtin.name)).unwrap();
        assert_eq!(named, load(builtin.name));
        assert_eq!(named.base.name(), builtin.name);
        // The base goes with the complete text: a line taken out of it changes nothing.
        let text = named.to_toml().replace("gravity = ", "# ");
        assert_eq!(Scene::parse("shown", &text).unwrap(), named);
    }
    // The base has the laws whose settings a file changes.
    let softer = Scene::parse("softer", "[stops]\nstiffness = 900").unwrap();
    assert_eq!(softer.physics.gravity, 9.81);
    assert!(
        softer.to_toml().contains("\n[stops]\n")
            && softer.to_toml().contains("\nstiffness = 900.0\n")
    );
    Scene::parse("none", "base = \"stability\"\n[stops]\nstiffness = 900").unwrap_err();

    let scene = Scene::parse(
        "one",
        "physics.dt = 1e-3\n[gradient]\ncotangent_bound = \"off\"",
    )
    .unwrap();
    assert_eq!(scene.physics.dt, 1e-3);
    assert_eq!(scene.gradient.cotangent_bound, None);
    assert_eq!(scene.physics.steps, Scene::default().physics.steps);
    // A number may be written without a point.
    let scene = Scene::parse("two", "physics.gravity = 5").unwrap();
    assert_eq!(scene.physics.gravity, 5.0);
}

/// The scene of a run lacks no key of its version; keys that are newer have the values of before.
#[test]
fn the_scene_of_a_run_is_complete() {
    let earth = Scene::default().set(&["design.one_piece=false"]).unwrap();
    let text = earth.to_run_toml();
    for read in [
        Scene::parse("run", &text),
        Scene::parse_of_run("run", &text),
    ] {
        assert_eq!(read.unwrap(), earth);
    }
    let without = |text: &str, key: &str| {
        let keep = |line: &&str| !line.starts_with(&format!("{key} = "));
        text.lines().filter(keep).collect::<Vec<_>>().join("\n")
    };
    let lacking = without(&text, "gravity");
    for read in [
        Scene::parse("run", &lacking),
        Scene::parse_of_run("run", &lacking),
    ] {
        let says = read.unwrap_err().to_string();
        assert!(says.contains("`physics.gravity` is missing"), "{says}");
    }
    // A law that the scene chooses has its keys too.
    let says = Scene::parse("run", &without(&text, "at"))
        .unwrap_err()
        .to_string();
    assert!(says.contains("`stops.at` is missing"), "{says}");
    // From before scenes of runs had versions: nothing comes from a base, and keys that did not exist yet were off.
    let old = without(&without(&without(&text, "format"), "version"), "base");
    assert_eq!(Scene::parse_of_run("old", &old).unwrap(), earth);
    let older = ["one_piece", "polish_trials", "integrator", "speed_bound"];
    let older = older
        .iter()
        .fold(old.clone(), |text, key| without(&text, key));
    let read = Scene::parse_of_run("older", &older).unwrap();
    assert!(!read.design.one_piece && read.schedule.polish_trials == 0);
    assert_eq!(read.physics.speed_bound, None);
    for text in ["", &without(&old, "gravity")] {
        let says = Scene::parse_of_run("old", text).unwrap_err().to_string();
        assert!(says.contains(" missing"), "{says}");
    }
}

#[test]
fn departures_are_named_and_can_all_be_switched_off() {
    let options = |scene: &Scene| -> Vec<_> {
        let departures = scene.departures().into_iter();
        departures.map(|departure| departure.option).collect()
    };
    let mut scene = Scene::load("stability").unwrap();
    assert_eq!(
        options(&scene),
        [
            "loss.kind",
            "gradient.cotangent_bound",
            "gradient.design_memory",
            "schedule.snap_trials",
            "schedule.polish_trials",
            "schedule.settle",
            "selection.kind",
            "design.one_piece"
        ]
    );
    let mut given = scene.clone();
    given.start.kind = StartKind::Layout;
    let of_designs = [
        "gradient.design_memory",
        "schedule.snap_trials",
        "schedule.polish_trials",
    ];
    assert!(
        options(&given)
            .iter()
            .all(|o| !of_designs.contains(&&o[..]))
    );
    (scene.gradient.design_memory, scene.schedule.settle) = (0.0, 0.0);
    (scene.schedule.snap_trials, scene.schedule.polish_trials) = (0, 0);
    scene.loss.kind = LossKind::Final;
    scene.gradient.cotangent_bound = None;
    scene.selection.kind = SelectionKind::Last;
    scene.design.one_piece = false;
    assert_eq!(options(&scene), Vec::<&str>::new());
    let physics = scene.physics.clone();
    (scene.physics.integrator, scene.physics.substeps) = (Integrator::Leapfrog, 2);
    let of_steps = ["physics.integrator", "physics.substeps"];
    assert_eq!(options(&scene), of_steps);
    scene.physics = physics;
    scene.start.kind = StartKind::ThreeLegged;
    assert_eq!(options(&scene), ["start.layout"]);
    let scene = Scene::parse("f32", "[gradient]\nprecision = \"f32\"").unwrap();
    assert_eq!(scene.gradient.precision, GradientPrecision::F32);
    assert!(options(&scene).contains(&"gradient.precision".to_string()));
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

/// The refusal of `--set` with these settings of the default scene.
fn refused_setting(settings: &[&str]) -> String {
    Scene::paper().set(settings).unwrap_err().to_string()
}

#[test]
fn single_settings_take_the_place_of_any_scene_s_own() {
    let scene = Scene::load("coulomb").unwrap();
    let settings = [
        "physics.gravity=9.81",
        "controller.goal = [1, 0.5]",
        "physics.contact=none",
        "start.layout=\"tall\"",
        "adam.gradient_norm=off",
        "controller.two_goals=true",
        "schedule.cycle=dc",
        "physics.gravity=5",
    ];
    let set = scene.set(&settings).unwrap();
    assert_eq!(set.physics.gravity, 5.0);
    assert_eq!(set.controller.goal, [1.0, 0.5]);
    assert_eq!(set.physics.contact, ContactLaw::none());
    assert_eq!(
        (set.start.layout, set.adam.gradient_norm),
        (Layout::Tall, None)
    );
    assert!(set.controller.two_goals && set.schedule.cycle == [Pass::Design, Pass::Controller]);
    assert_eq!(set.physics.friction, scene.physics.friction);
    assert_eq!(scene.set(&[""; 0]).unwrap(), scene);
    // One alone would be at odds with the scene; together they fit.
    let both = [
        "schedule.iterations=100",
        "schedule.snap_at=90",
        "schedule.attraction_from=50",
    ];
    assert_eq!(scene.set(&both).unwrap().schedule.snap_at, 90);
    // A file that holds only some keys.
    let part = Scene::parse("part", "[physics]\ndt = 0.001").unwrap();
    let set = part.set(&["physics.steps=5000"]).unwrap();
    assert_eq!((set.physics.dt, set.physics.steps), (0.001, 5000));
}

/// Settings that are refused: what is said, and the option with what stands below it.
const WRONG_SETTINGS: [(&str, &str, &str); 10] = [
    (
        "base=stability",
        "error: `base` cannot be changed here\n",
        "| --set base=\"stability\"
  |       ^^^^ it describes a whole scene file: set it at the top of that file",
    ),
    (
        "physics.gravity=1e9",
        "error: `physics.gravity` is out of range: 1e9\n",
        "| --set physics.gravity=1e9
  |                       ^^^ allowed: a number from -1000 to 1000",
    ),
    (
        "physics.gravity=fast",
        "`physics.gravity` is a text: \"fast\"",
        "| --set physics.gravity=\"fast\"
  |                       ^^^^^^ allowed: a number",
    ),
    (
        "physics.gravty=1",
        "unknown key `gravty` in [physics]",
        "did you mean `gravity`?",
    ),
    (
        "physcs.gravity=1",
        "unknown section `physcs`",
        "did you mean `physics`?",
    ),
    (
        "gravity=1",
        "unknown section `gravity`",
        "did you mean `physics.gravity`?",
    ),
    (
        "physics=1",
        "is a whole number, not a section",
        "write physics.KEY=VALUE",
    ),
    (
        "physics.gravity",
        "`physics.gravity` has no value",
        "write SECTION.KEY=VALUE",
    ),
    ("physics.gravity=", "not TOML", "| --set physics.gravity="),
    (
        "controller.goal=[1, 2, 3]",
        "has 3 entries: [1, 2, 3]",
        "|                       ^^^^^^^^^ allowed: 2 numbers",
    ),
];

#[test]
fn a_wrong_setting_is_shown_as_it_was_given() {
    for (setting, says, shown) in WRONG_SETTINGS {
        let report = refused_setting(&["physics.dt=0.001", setting]);
        assert!(report.contains(says) && report.contains(shown), "{report}");
        assert!(!report.contains("-->"), "{report}");
    }
    // A conflict is pointed at in the setting that names one of its keys.
    let report = refused_setting(&["physics.dt=0.001", "physics.steps=512"]);
    assert!(
        report.contains("the horizon (4096 steps) is longer"),
        "{report}"
    );
    assert!(
        report.contains("--set physics.steps=512\n  |                     ^^^"),
        "{report}"
    );
    // A fault found later is shown in the last setting of its key, or else in the scene.
    let shown = |name, settings: &[&str], key| {
        let error = fault(name, settings, key, "too long", "take less");
        error.map(|error| error.to_string())
    };
    let report = shown("coulomb", &["physics.dt=1", "physics.dt=0.5"], "physics.dt").unwrap();
    assert!(
        report.contains("--set physics.dt=0.5\n  |                  ^^^ take less"),
        "{report}"
    );
    let report = shown("coulomb", &["physics.dt=1"], "physics.contact").unwrap();
    assert!(report.contains("--> coulomb:"), "{report}");
    assert_eq!(shown("coulomb", &[], "physics.dt"), None);
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
