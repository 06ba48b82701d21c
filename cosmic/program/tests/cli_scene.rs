//! `cosmic scene` and `cosmic completions`: output, messages and exit codes.

use crate::common::{Bench, scene};
use crate::program::{Told, command, cosmic, has};
use cosmic::scene::{BUILTIN, Scene};
use std::fs;
use std::process::Command;

/// Runs `scene check` on a file with this text.
fn check(text: impl AsRef<[u8]>) -> Told {
    let bench = Bench::default();
    bench.write("my.toml", text);
    bench.cosmic("scene check my.toml")
}

#[test]
fn list_prints_one_scene_per_line_with_its_name_first() {
    let told = cosmic("scene list").ok().out;
    let names = told.lines().map(|line| line.split_whitespace().next());
    assert!(names.eq(BUILTIN.map(|scene| Some(scene.name))));
    let list = cosmic("scene list --json").json();
    assert_eq!(list.as_array().unwrap().len(), BUILTIN.len());
    assert_eq!(list[0]["name"], BUILTIN[0].name);
}

#[test]
fn default_and_show_print_whole_scenes_that_read_back() {
    let told = cosmic("scene default").ok().out;
    assert_eq!(Scene::parse("default", &told).unwrap(), Scene::default());
    for scene in BUILTIN {
        let told = cosmic(&format!("scene show {}", scene.name)).ok().out;
        let read = Scene::parse(scene.name, &told).unwrap();
        assert_eq!(read, Scene::load(scene.name).unwrap());
        check(told).ok();
    }
    let json = cosmic("scene show coulomb --json").json();
    assert_eq!(json["physics"]["friction"], 2.5);
}

#[test]
fn check_says_ok_or_where_it_is_wrong() {
    let told = check("[physics]\ndt = 0.001\n").ok();
    assert!(told.out.ends_with("my.toml: ok\n"), "{told:?}");
    let told = check("").ok();
    assert_eq!(told.error, "");

    let told = check("[physics]\ndt = 5.0\n");
    assert_eq!((&told.out[..], told.code), ("", 2));
    let lines: Vec<_> = told.error.lines().collect();
    assert_eq!(lines[0], "error: `physics.dt` is out of range: 5.0");
    assert_eq!(lines[1], " --> my.toml:2:6");
    assert_eq!(lines[3], "2 | dt = 5.0");
    assert_eq!(
        lines[4],
        "  |      ^^^ allowed: a number from 1e-9 to 1, or \"auto\""
    );

    let told = check(b"[physics]\ndt = \xff\n");
    let allowed = "\n  = allowed: a scene is UTF-8 text\n";
    told.fails(2, &["0xff is not UTF-8", "my.toml:2:6", allowed]);
}

#[test]
fn check_refuses_what_optimize_refuses() {
    let bench = Bench::with("[physics]\ndt = 0.05\nsubsteps = 1\n");
    let told = bench.cosmic("scene check tiny.toml");
    told.fails(2, &["tiny.toml:2:6"]);
    assert_eq!(told.out, "");
    let refused = bench.optimize("run", "");
    assert_eq!(refused.code, 2, "{refused:?}");
    assert_eq!(
        refused.error.replace(" or add --allow-unstable", ""),
        told.error
    );
    let told = bench.cosmic("scene check tiny.toml --json");
    told.fails(2, &[]);
    let json: serde_json::Value = serde_json::from_str(&told.out).unwrap();
    assert_eq!(json["ok"], false);
    let setting = &json["refusals"][0]["settings"][0];
    assert_eq!(setting["key"], "physics.dt");
    assert_eq!(setting["value"], "0.05");
    // If the file sets none of the keys that determine the time step, the message lists their values.
    let settings = "(physics.dt = 0.002, physics.substeps = 1); set physics.dt to";
    let told = check("base = \"stability\"\n[materials]\nstiffness = [1e-7, 1e6, 30]\n");
    told.fails(2, &[settings]);
}

#[test]
fn check_warns_about_valid_but_senseless_settings() {
    let nonsense = "[materials]\nstiffness = [1000, 400, 30]\n[physics]\ngravity = -4.8\n";
    let told = check(nonsense).ok();
    assert!(told.out.ends_with("my.toml: ok\n"), "{told:?}");
    let expected = [
        "warning: void is at least as stiff as skeleton (materials.stiffness = [1000.0, 400.0, 30.0])",
        "warning: gravity points up (physics.gravity = -4.8)",
    ];
    for warning in expected {
        assert!(told.error.lines().any(|line| line == warning), "{told:?}");
    }
}

/// `scene check` prints a short line for each number that follows from the robot and its world, and then a line about the
/// robot, the world and the cost, except with `--json` or `--quiet`.
#[test]
fn the_world_is_described() {
    let earth = "world: gravity 9.81 m/s²; feet slip at friction 1 (contact coulomb); no drag; damped bars \
                 (time 0.00025 s); end stops (at a strain of 0.27, stiffness 1300 N/m)\n";
    let told = check("").ok().out;
    assert!(told.starts_with("physics.dt = 0.002 (auto)\n"), "{told}");
    assert!(told.ends_with("\nmy.toml: ok\n"), "{told}");
    let robot = "\nrobot: 6x6, 36 nodes, 110 edges; 0.5 m long, 0.5 m high; about ";
    let cost = "cost: 8192 steps a rollout, about ";
    has(
        &told,
        &["\ncontroller.omega = 10.0 (auto)\n", robot, earth, cost],
    );
    let moon =
        "base = \"rough\"\n[physics]\ngravity = 1.6\nincline_deg = 5\nforces = [\"stops\"]\n";
    let says = "world: gravity 1.6 m/s²; feet never slip (contact infinite); incline 5 degrees; ground rough; \
                drag 20 per second; no damping in bars; end stops (at a strain of 0.35, stiffness 400 N/m)\n";
    has(&check(moon).ok().out, &[says]);
    let bench = Bench::new(2, 32);
    bench.write("moon.toml", moon);
    assert_eq!(bench.ok("scene check moon.toml --quiet").out, "");
    bench.cosmic("scene check moon.toml --json").json();
}

/// A scene has a name or a file, and `--set` changes both.
#[test]
fn a_scene_is_checked_by_its_name() {
    let told = cosmic("scene check earth --set physics.gravity=1.62").ok();
    has(&told.out, &["world: gravity 1.62 m/s²", "\nearth: ok\n"]);
    let told = cosmic("scene check earth --set physics.gravity=-1");
    has(&told.error, &["warning: gravity points up"]);
    cosmic("scene check earht").fails(4, &["did you mean `earth`?"]);
}

/// Valid scenes that make no sense get warnings that name the numbers.
#[test]
fn nonsense_is_warned_about() {
    let truss = |nodes: &str, edges: &str| {
        format!(
            "{{\"format\": \"cosmic-truss\", \"version\": 1, \"nodes\": {nodes}, \"edges\": {edges}, \"payload\": [{{\"node\": 0}}]}}"
        )
    };
    let bench = Bench::default();
    let square = "[[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]]";
    let of_size = |s: f64, up: f64| {
        let top = s + up;
        truss(
            &format!("[[0, {up}], [{s}, {up}], [{s}, {top}], [0, {top}]]"),
            square,
        )
    };
    bench.write("millimetres.json", of_size(600.0, 0.0));
    bench.write("floating.json", of_size(0.3, 5.0));
    bench.write("tiny.json", of_size(3e-4, 0.0));
    let two = "[[0, 0], [0.1, 0], [0.1, 0.1], [0.3, 0], [0.4, 0], [0.4, 0.1]]";
    let edges = "[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]]";
    bench.write("pieces.json", truss(two, edges));
    for (set, says) in [
        ("lattice.file=millimetres.json", "the robot measures 600 m"),
        ("lattice.file=tiny.json", "the robot measures 0.0003 m"),
        (
            "lattice.file=floating.json",
            "the robot starts 5 m above the ground",
        ),
        (
            "lattice.file=pieces.json",
            "the truss is in 2 pieces: no chain of edges connects node 0 with node 3",
        ),
        ("lattice.spacing=10", "the robot measures 50 m"),
        ("lattice.drop=3", "the robot starts 3 m above the ground"),
        (
            "physics.steps=1",
            "a rollout lasts 0.002 s, which is less than a period of the clock (0.628 s)",
        ),
        (
            "physics.gravity=0",
            "without gravity the robot does not rest on the ground",
        ),
    ] {
        let told = bench.cosmic(&format!("scene check earth --set {set}"));
        has(&told.error, &["warning: ", says]);
        // The robot is described although the scene is nonsense, so that its numbers are seen.
        has(&told.out, &["robot: "]);
    }
}

/// Stiff, light bars need many explicit steps. The cost is announced, and the implicit step is advised.
#[test]
fn many_mechanical_steps_are_announced() {
    let stiff = "--set materials.stiffness=[1e-4,1e7,250]";
    let told = cosmic(&format!("scene check earth {stiff}"));
    has(&told.out, &[" substeps a rollout, about "]);
    let advice = "; set physics.integrator = \"implicit\": a rollout then takes ";
    has(
        &told.error,
        &[
            "light or stiff bars make the simulation slow: a rollout takes ",
            advice,
        ],
    );
    let implicit = cosmic(&format!(
        "scene check earth {stiff} --set physics.integrator=implicit"
    ));
    assert!(!implicit.error.contains("simulation slow"), "{implicit:?}");
}

/// `optimize` prints the same warnings as `scene check`.
#[test]
fn optimize_describes_the_world_and_warns_as_check_does() {
    let bench = Bench::with(&scene(2, 32, "gravity = -4.8\nfriction = 0.8"));
    let expected = [
        "world: gravity -4.8 m/s²; feet never slip (contact infinite); drag 20 per second; no damping in bars; no end stops",
        "warning: gravity points up (physics.gravity = -4.8)",
        "warning: this setting has no effect: it is read only with a contact law that slips (physics.friction = 0.8)",
    ];
    let told = bench.cosmic("scene check tiny.toml");
    let optimised = bench.cosmic("optimize tiny.toml --out a");
    for line in expected {
        assert!(
            (told.out.clone() + &told.error).lines().any(|l| l == line),
            "{told:?}"
        );
        assert!(optimised.error.lines().any(|l| l == line), "{optimised:?}");
    }
    let quiet = bench.cosmic("optimize tiny.toml --quiet --out b");
    assert!(
        !quiet.error.contains("warning: ") && !quiet.error.contains("world: "),
        "{quiet:?}"
    );
    bench.cosmic("optimize tiny.toml --json --out c").json();
}

#[test]
fn missing_scenes_exit_with_4_and_a_hint() {
    let hint = "did you mean `stability`?";
    cosmic("scene show stabilty").fails(4, &[hint]);
    let says = "no built-in scene and no file is named `no/such/file.toml`";
    cosmic("scene check no/such/file.toml").fails(4, &[says]);
    cosmic("scene check .").fails(4, &[]);
}

#[test]
fn bad_usage_exits_with_2_and_help_with_0() {
    for line in ["frobnicate", "scene show", "scene list --frob", ""] {
        let told = cosmic(line);
        told.fails(2, &["Usage: cosmic"]);
        assert_eq!(told.out, "", "{line}");
    }
    cosmic("--help").ok();
    cosmic("--version").ok();
    // Writing to `/dev/full` fails as on a full disk.
    #[cfg(target_os = "linux")]
    {
        let full = fs::File::create("/dev/full").unwrap();
        let told = command("--version").stdout(full).output().unwrap();
        Told::of(told).fails(4, &["error: cannot write standard output"]);
    }
}

#[test]
fn completions_are_written_for_every_shell() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let told = cosmic(&format!("completions {shell}")).ok();
        has(&told.out, &["cosmic"]);
    }
    cosmic("completions abacus").fails(2, &[]);
}

#[cfg(unix)]
#[test]
fn a_reader_of_the_output_may_stop_early() {
    let pipe = "\"$0\" scene default | head -n 1 >/dev/null; echo ${PIPESTATUS[0]}";
    let mut command = Command::new("bash");
    let output = command
        .args(["-c", pipe, env!("CARGO_BIN_EXE_cosmic")])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).trim(), "0");
    assert!(output.stderr.is_empty());
}
