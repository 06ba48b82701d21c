//! `--set key=value` wherever a scene is taken.

use crate::common::{Bench, scene};
use crate::program::Told;
use serde_json::Value;
use std::fs;

fn json(said: &Told) -> Value {
    assert_eq!(said.code, 0, "{said:?}");
    serde_json::from_str(&said.out).unwrap()
}

#[test]
fn keys_of_every_kind_are_set() {
    let bench = Bench::default();
    let settings = [
        "physics.gravity=3.7",
        "controller.hidden = 7",
        "physics.contact=coulomb",
        "start.kind=\"uniform\"",
        "materials.max_strain=[0, 0, 0.1]",
    ];
    let mut arguments = vec!["scene", "show", "stability", "--json"];
    arguments.extend(settings.iter().flat_map(|setting| ["--set", *setting]));
    let scene = json(&bench.cosmic(&arguments));
    assert_eq!(scene["physics"]["gravity"], 3.7);
    assert_eq!(scene["controller"]["hidden"], 7);
    assert_eq!(scene["physics"]["contact"], "coulomb");
    assert_eq!(scene["start"]["kind"], "uniform");
    assert_eq!(scene["materials"]["max_strain"][2], 0.1);
    // All else is the scene's own.
    let whole = json(&bench.cosmic(&["scene", "show", "stability", "--json"]));
    assert_eq!(scene["lattice"], whole["lattice"]);
    assert_ne!(scene["physics"], whole["physics"]);
}

#[test]
fn every_command_that_takes_a_scene_takes_settings() {
    let bench = Bench::default();
    let scene = &bench.scene[..];
    let with = |arguments: &[&str], setting: &str| {
        bench.cosmic(&[arguments, &["--set", setting]].concat())
    };
    let explained = json(&with(&["explain", scene, "--json"], "physics.steps=96"));
    assert_eq!(explained["rollout"]["steps"], 96);
    let evaluated = |file: &str, setting: &str| {
        let said = with(&["evaluate", file], setting);
        json(&said)["results"]["trajectory"].clone()
    };
    assert_ne!(
        evaluated(scene, "physics.gravity=3.7"),
        evaluated(scene, "physics.gravity=9.81")
    );
    let checked = with(&["gradcheck", scene], "physics.steps=96");
    assert!(checked.out.contains("over 96 steps"), "{checked:?}");
    let checked = with(&["verify", scene, "--stability"], "physics.steps=96");
    assert!(checked.out.contains("96 steps of"), "{checked:?}");
    let checked = with(&["scene", "check", scene], "physics.dt=-1");
    assert_eq!(checked.code, 2, "{checked:?}");

    let run = ["--set", "physics.gravity=3.7", "--iterations", "2"];
    bench.run("a", &run);
    let kept = fs::read_to_string(bench.path("a/scene.toml")).unwrap();
    assert!(kept.contains("gravity = 3.7"), "{kept}");
    // A design lies in the scene beside it.
    assert_ne!(
        evaluated("a", "physics.gravity=9.81"),
        evaluated("a", "physics.gravity=3.7")
    );
    let robust = ["robustness", "a", "--samples", "1", "--json"];
    let other = [&robust[..], &["--scene", scene]].concat();
    assert_ne!(
        json(&with(&other, "physics.gravity=3.7"))["runs"],
        json(&with(&other, "physics.gravity=9.81"))["runs"]
    );
    let said = with(&robust, "physics.gravity=3.7");
    assert!(said.code == 2 && said.error.contains("--scene"), "{said:?}");
    let plan = ["sweep", "plan", scene, "--seeds", "1", "--out", "s"];
    assert_eq!(with(&plan, "physics.gravity=3.7").code, 0);
    let plan = bench.json("s/plan.json").to_string();
    assert!(plan.contains("3.7"), "{plan}");
}

#[test]
fn wrong_settings_say_what_is_allowed() {
    let bench = Bench::default();
    let refused = |settings: &[&str], says: &[&str]| {
        let mut arguments = vec!["optimize", &bench.scene];
        arguments.extend(settings.iter().flat_map(|setting| ["--set", *setting]));
        let said = bench.cosmic(&arguments);
        assert_eq!((said.code, &said.out[..]), (2, ""), "{said:?}");
        for text in says {
            assert!(said.error.contains(text), "no {text:?} in {}", said.error);
        }
    };
    refused(
        &["physics.gravty=9.81"],
        &["physics.gravty", "did you mean `gravity`?"],
    );
    refused(
        &["fysics.gravity=9.81"],
        &["fysics", "did you mean `physics`?"],
    );
    refused(
        &["physics.gravity=fast"],
        &["physics.gravity", "fast", "allowed: "],
    );
    refused(
        &["physics.contact=glue"],
        &["physics.contact", "glue", "coulomb"],
    );
    refused(
        &["physics.dt=-0.1"],
        &["`physics.dt` is out of range: -0.1", "allowed: "],
    );
    refused(&["physics.dt"], &["physics.dt"]);
    // Every setting that is wrong is shown.
    refused(
        &["physics.dt=0", "physics.steps=0"],
        &["physics.dt", "physics.steps"],
    );
    assert!(!bench.path("runs").exists());
}

#[test]
fn of_several_settings_of_a_key_the_last_counts() {
    let bench = Bench::default();
    let twice = ["--set", "physics.dt=0.001", "--set", "physics.dt=0.0005"];
    let show = ["scene", "show", "stability", "--json"];
    let said = bench.cosmic(&[&show[..], &twice].concat());
    assert_eq!(json(&said)["physics"]["dt"], 0.0005);
}

/// The scene's own line of the time step is not the one to change.
#[test]
fn an_unstable_step_is_shown_where_it_was_set() {
    let bench = Bench::with(&scene(4, 32, "dt = 0.001"));
    let said = bench.optimize("a", &["--set", "physics.dt=0.05"]);
    assert!(said.code == 2 && !bench.path("a").exists(), "{said:?}");
    assert!(said.error.contains("--set physics.dt=0.05"), "{said:?}");
    assert!(!said.error.contains("tiny.toml"), "{said:?}");
}

#[test]
fn a_reference_case_has_no_scene_to_change() {
    let bench = Bench::default();
    fs::write(bench.path("case.json"), "{}").unwrap();
    let said = bench.cosmic(&["evaluate", "case.json", "--set", "physics.dt=0.001"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(
        said.error.contains("case.json is a reference case"),
        "{said:?}"
    );
}
