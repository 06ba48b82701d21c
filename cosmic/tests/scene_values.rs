//! The sources of a scene's values: its base, the scene file of a run, and the option `--set`.

use cosmic::Registry;
use cosmic::laws::ContactLaw;
use cosmic::scene::{BUILTIN, ClockKind, Layout, Scene};

#[test]
fn missing_keys_come_from_the_base() {
    let load = |name| Scene::load(name).unwrap();
    for name in ["", "base = \"earth\"", "# a scene\n"] {
        assert_eq!(Scene::parse("empty", name).unwrap(), load("earth"));
    }
    assert_eq!(Scene::default(), load("earth"));
    for builtin in BUILTIN {
        let named = Scene::parse("named", &format!("base = {:?}", builtin.name)).unwrap();
        assert_eq!(named, load(builtin.name));
        assert_eq!(named.base.name(), builtin.name);
        // The complete text of a scene names its base. If a line is removed, the base gives the same value.
        let text = named.to_toml().replace("gravity = ", "# ");
        assert_eq!(Scene::parse("shown", &text).unwrap(), named);
    }
    // A file may change a setting of a law that only its base chooses.
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
    assert_eq!(scene.physics.friction, Scene::default().physics.friction);
    // A number may be written without a decimal point.
    let scene = Scene::parse("two", "physics.gravity = 5").unwrap();
    assert_eq!(scene.physics.gravity, 5.0);
}

/// The scene file of a run states its format and its version, and has every key.
#[test]
fn the_scene_of_a_run_is_complete() {
    let earth = Scene::default().set(&["design.one_piece=false"]).unwrap();
    let text = earth.to_run_toml();
    assert_eq!(Scene::parse("run", &text).unwrap(), earth);
    let without = |text: &str, key: &str| {
        let keep = |line: &&str| !line.starts_with(&format!("{key} = "));
        text.lines().filter(keep).collect::<Vec<_>>().join("\n")
    };
    let version = text.replacen("version = 1", "version = 8", 1);
    for (text, says) in [
        (without(&text, "gravity"), "`physics.gravity` is missing"),
        // The keys of a law that the scene uses must be present too.
        (without(&text, "at"), "`stops.at` is missing"),
        (version, "version 8, not \"cosmic-scene\" version 1"),
    ] {
        let told = Scene::parse("run", &text).unwrap_err().to_string();
        assert!(told.contains(says), "{told}");
    }
}

/// The text of the error report after `--set` has applied settings to the paper's scene.
fn refused_setting(settings: &[&str]) -> String {
    Scene::paper().set(settings).unwrap_err().to_string()
}

#[test]
fn single_settings_replace_those_of_a_scene() {
    let scene = Scene::load("coulomb").unwrap();
    let settings = [
        "physics.gravity=9.81",
        "controller.goal = [1, 0.5]",
        "physics.contact=none",
        "start.layout=\"tall\"",
        "gradient.cotangent_bound=off",
        "controller.clock=learned",
        "physics.gravity=5",
    ];
    let set = scene.set(&settings).unwrap();
    assert_eq!(set.physics.gravity, 5.0);
    assert_eq!(set.controller.goal, [1.0, 0.5]);
    assert_eq!(set.physics.contact, ContactLaw::none());
    assert_eq!(
        (set.start.layout, set.gradient.cotangent_bound),
        (Layout::Tall, None)
    );
    assert_eq!(set.controller.clock, ClockKind::Learned);
    assert_eq!(set.physics.friction, scene.physics.friction);
    assert_eq!(scene.set(&[""; 0]).unwrap(), scene);
    // Each of these settings alone would contradict the rest of the scene; together they fit.
    let both = [
        "schedule.iterations=100",
        "schedule.snap_at=90",
        "schedule.attraction_from=50",
    ];
    assert_eq!(scene.set(&both).unwrap().schedule.snap_at, 90);
    // `--set` also works on a scene whose file has only some of the keys.
    let part = Scene::parse("part", "[physics]\ndt = 0.001").unwrap();
    let set = part.set(&["physics.steps=5000"]).unwrap();
    assert_eq!((set.physics.dt, set.physics.steps), (0.001, 5000));
}

/// A setting sets one key: a new line or braces cannot bring others in.
#[test]
fn a_setting_sets_one_key() {
    for setting in [
        "physics.gravity=1\nphysics.steps=64",
        "physics.gravity=1\n[schedule]\niterations=1",
        "lattice={columns=3, rows=4}",
    ] {
        let report = refused_setting(&[setting]);
        assert!(report.contains("a setting sets one key"), "{report}");
    }
    let scene = Scene::paper().set(&["controller.goal=[3,\n1]"]);
    assert_eq!(scene.unwrap().controller.goal, [3.0, 1.0]);
}

/// Each setting in `wrong_settings.txt` is refused, and the report has the lines that follow it.
#[test]
fn a_wrong_setting_is_shown_as_the_user_wrote_it() {
    let (_, rows) = include_str!("wrong_settings.txt")
        .split_once("\n\n")
        .unwrap();
    for row in rows.trim_end().split("\n\n") {
        let (setting, says) = row.split_once('\n').unwrap();
        let report = refused_setting(&["physics.dt=0.001", setting]);
        assert!(
            says.lines().all(|line| report.contains(&line[2..])),
            "{row}\n{report}"
        );
        assert!(!report.contains("-->"), "{report}");
    }
    // If the values of two keys conflict and both are set, the report shows the setting of the key that the error is
    // about.
    let report = refused_setting(&["schedule.horizon=[512, 512]", "loss.window=1024"]);
    assert!(
        report.contains("the last 1024 steps, but the shortest horizon has only 512"),
        "{report}"
    );
    assert!(
        report.contains("--set loss.window=1024\n  |                   ^^^^"),
        "{report}"
    );
    // If an error about a key is found later, the report shows the last setting of this key. If the key is not set, the
    // report shows the scene.
    let shown = |name, settings: &[&str], key| {
        let error = Registry::default().fault(name, settings, key, "too long", "take less");
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
