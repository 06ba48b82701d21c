//! Settings that follow from the robot and its world: the value "auto" in scene files.

use cosmic::lattice::Lattice;
use cosmic::laws::{Damper, Stops};
use cosmic::scene::{AnyDesign, Scene};

/// Every key that can follow, with a value that no rule gives here, and with the power of the scale of lengths by which
/// the value grows. Times grow by its square root.
const KEYS: [(&str, &str, f64); 28] = [
    ("lattice.payload", "5", 0.0),
    ("physics.dt", "0.0123", 0.5),
    ("physics.substeps", "33", 0.0),
    ("physics.steps", "777", 0.0),
    ("physics.speed_bound", "7.7", 0.5),
    ("controller.omega", "7.7", -0.5),
    ("controller.goal", "[7.0, 7.0]", 1.0),
    ("controller.goal_scale", "7.7", -1.0),
    ("controller.offset_scale", "7.7", -1.0),
    ("controller.velocity_scale", "7.7", -0.5),
    ("controller.gain", "[7.0, 7.0]", 0.0),
    ("schedule.horizon", "[77, 99]", 0.0),
    ("schedule.window", "0.7", 0.5),
    ("loss.window", "33", 0.0),
    ("loss.every", "7", 0.0),
    ("volume.solid", "[0.3, 0.4]", 0.0),
    ("volume.actuator", "[0.1, 0.11]", 0.0),
    ("schedule.iterations", "88", 0.0),
    ("schedule.snap_at", "66", 0.0),
    ("schedule.attraction_from", "1", 0.0),
    ("schedule.horizon_over", "[7, 9]", 0.0),
    ("binarisation.threshold_over", "[7, 9]", 0.0),
    ("goals.along", "[-7.0, 7.0]", 1.0),
    ("adam.rate", "0.7", 0.0),
    ("adam.fine_rate", "0.7", 0.0),
    ("stops.at", "0.2", 0.0),
    ("stops.stiffness", "777.0", -1.0),
    ("damper.time", "0.007", 0.5),
];

fn set(scene: &Scene, key: &str, value: &str) -> Scene {
    scene.set(&[format!("{key}={value}")]).unwrap()
}

/// The scene with "auto" for every key that allows it.
fn following(scene: &Scene) -> Scene {
    let all = KEYS.map(|(key, ..)| format!("{key}=auto"));
    scene.set(&all).unwrap()
}

fn values(scene: &Scene) -> Vec<(String, String)> {
    let all = scene.following().into_iter();
    all.map(|setting| (setting.key, setting.value)).collect()
}

/// What experiments found for `earth` alone. `stability` declares its other numbers.
const OF_EARTH: [(&str, &str); 11] = [
    ("schedule.window", "1.024"),
    ("schedule.iterations", "75"),
    ("schedule.snap_at", "1"),
    ("schedule.attraction_from", "0"),
    ("schedule.horizon_over", "[20, 37]"),
    ("controller.gain", "[2.0, 0.2]"),
    ("binarisation.threshold_over", "[5, 25]"),
    ("adam.rate", "0.004"),
    ("stops.at", "0.27"),
    ("stops.stiffness", "1300.0"),
    ("damper.time", "0.00025"),
];

/// For `earth`, every rule gives the number that experiments found.
#[test]
fn the_rules_give_earth_the_declared_numbers() {
    let earth = following(&Scene::load("earth").unwrap());
    let forces = ["physics.forces=[\"damper\", \"stops\"]"];
    let declared = Scene::paper().set(&forces).unwrap().settings();
    assert_eq!(values(&earth).len(), KEYS.len());
    for (key, value) in values(&earth) {
        let found = OF_EARTH.iter().find(|(other, _)| *other == key);
        let declared = declared.iter().find(|setting| setting.key == key);
        let expected = found.map_or(&*declared.unwrap().value, |(_, found)| found);
        assert_eq!(value, expected, "{key}");
    }
}

/// Each key that allows "auto" has a rule, and a number in the file wins over the rule.
#[test]
fn every_key_that_can_follow_has_a_rule() {
    let base = following(&Scene::load("earth").unwrap());
    for (key, odd, _) in KEYS {
        let fixed = set(&base, key, odd);
        assert!(fixed.following().iter().all(|other| other.key != key));
        let text = fixed
            .settings()
            .into_iter()
            .find(|setting| setting.key == key);
        assert_eq!(text.unwrap().value, odd);
        assert_eq!(values(&set(&fixed, key, "auto")), values(&base), "{key}");
    }
    let refused = base.set(&["physics.gravity=auto"]).unwrap_err().to_string();
    assert!(
        refused.contains("physics.gravity") && !refused.contains("or \"auto\""),
        "{refused}"
    );
    let told = base.set(&["physics.dt=soon"]).unwrap_err().to_string();
    assert!(told.contains("or \"auto\""), "{told}");
}

/// A robot four times as large, of the same material density per node and with bars of a quarter of the stiffness per
/// mass, gets numbers with the same digits in binary: the time scale doubles exactly.
#[test]
fn the_rules_scale_exactly_with_the_size() {
    let numbers = |text: &str| -> Vec<f64> {
        let list = text.trim_matches(['[', ']']).split(", ");
        list.map(|number| number.parse().unwrap()).collect()
    };
    let small = following(&Scene::load("earth").unwrap());
    let small = small
        .set(&["lattice.columns=7", "lattice.rows=3", "physics.damping=3"])
        .unwrap();
    for power in [-3, -1, 1, 2] {
        let (length, time) = (4_f64.powi(power), 2_f64.powi(power));
        let mut large = small.clone();
        large.lattice.spacing *= length;
        // The mass of a bar is its density times its length, and times scale with `sqrt(mass / stiffness)`.
        large.materials.density = large.materials.density.map(|density| density / length);
        large.materials.stiffness = large.materials.stiffness.map(|k| k / (time * time));
        large.physics.damping /= time;
        assert!(large.follow().is_empty());
        for ((key, a), (_, b)) in values(&small).into_iter().zip(values(&large)) {
            let (_, _, exponent) = KEYS.into_iter().find(|(other, ..)| *other == key).unwrap();
            let expected = numbers(&a).into_iter().map(|x| x * length.powf(exponent));
            assert_eq!(
                numbers(&b),
                expected.collect::<Vec<_>>(),
                "{key} at 4^{power}"
            );
        }
    }
}

/// Bars that are a hundred times as stiff vibrate ten times as fast. They get substeps, and the steps of the controller stay
/// as long as they are.
#[test]
fn stiff_bars_get_substeps() {
    let earth = Scene::load("earth").unwrap();
    let stiff = set(&earth, "materials.stiffness", "[1e-7, 4e4, 30.0]");
    assert_eq!(stiff.physics.dt, earth.physics.dt);
    assert!(stiff.physics.substeps >= 9, "{}", stiff.physics.substeps);
    // Beyond the largest number of substeps, the step itself shrinks, and the simulated time stays.
    let stiffer = set(&earth, "materials.stiffness", "[1e-7, 1e9, 30.0]");
    assert_eq!(stiffer.physics.substeps, 1024);
    assert!(stiffer.physics.dt < 0.8 * earth.physics.dt);
    let time = |scene: &Scene| scene.physics.dt * scene.physics.steps as f64;
    let share = time(&stiffer) / time(&earth);
    // The number of steps is rounded to a whole number.
    assert!((share - 1.0).abs() < 1e-4, "{share}");
}

/// Stops and dampers follow from the bars: actuators of 250 N/m do not run through stops that fit 30 N/m. Time steps that
/// fit these numbers are stable for every design.
#[test]
fn the_laws_of_bars_follow_from_the_bars() {
    let world = "[lattice]\ncolumns = 5\nrows = 3\nspacing = 0.4\n\
                 [materials]\nstiffness = [1e-7, 1500.0, 250.0]\ndensity = [1e-8, 0.2, 0.8]\nmax_strain = [0.0, 0.0, 0.2]\n";
    let world = Scene::parse("world", world).unwrap();
    let stops: Stops = world.physics.forces.chosen().unwrap();
    assert_eq!(stops.stiffness, 1300.0 / 30.0 * 250.0);
    // Two roundings of a number of this size.
    assert!((stops.at - 27.0 / 35.0 * 0.2).abs() < 1e-16);
    // The damping ratio of a bar of skeleton between two nodes, `time / 2` times its frequency.
    let ratio = |scene: &Scene| {
        let damper: Damper = scene.physics.forces.chosen().unwrap();
        let ([_, k, _], [_, density, _]) = (scene.materials.stiffness, scene.materials.density);
        let mass = scene.physics.node_mass + 0.5 * density * scene.lattice.spacing;
        0.5 * damper.time * (2.0 * k / mass).sqrt()
    };
    let earth = Scene::load("earth").unwrap();
    // A few roundings of a number below 1.
    assert!((ratio(&world) - ratio(&earth)).abs() < 1e-15);
    assert!((ratio(&earth) - 0.088).abs() < 5e-4);
    for scene in [&earth, &world] {
        let mut whole = scene.physics.clone();
        whole.substeps = 1;
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let any = AnyDesign::new(&lattice, &scene.materials, &whole);
        let substep = scene.physics.dt / scene.physics.substeps as f64;
        assert!(substep <= any.stable_step(scene.robust.faster()));
    }
    // A law that such a scene chooses follows too; one that a scene of plain numbers chooses does not.
    let forces = ["physics.forces=[\"bumpers\", \"stops\"]"];
    let shown = |scene: &Scene| {
        let settings = scene.set(&forces).unwrap().settings().into_iter();
        let of_laws =
            settings.filter(|s| s.key.starts_with("bumpers.s") || s.key.starts_with("stops."));
        of_laws.map(|setting| setting.value).collect::<Vec<_>>()
    };
    assert_eq!(shown(&world)[0], "7500.0");
    assert_eq!(shown(&Scene::paper()), ["2000.0", "0.35", "400.0"]);
    // The numbers of a law that is not chosen are not there.
    let bare = world.set(&["physics.forces=[]"]).unwrap();
    assert!(
        bare.following()
            .iter()
            .all(|other| !other.key.starts_with("stops"))
    );
    // Bars without stiffness and actuators that do not move have allowed numbers too.
    set(&earth, "materials.stiffness", "[0.0, 0.0, 0.0]");
    set(&earth, "materials.max_strain", "[0.0, 0.0, 0.0]");
}

/// The phases of a run are shares of it. A start from a layout has no snap.
#[test]
fn phases_follow_the_number_of_iterations() {
    let earth = Scene::load("earth").unwrap();
    // With windows the bars are decided at once.
    let windows = set(&earth, "schedule.iterations", "600");
    assert_eq!(
        (windows.schedule.attraction_from, windows.schedule.snap_at),
        (0, 1)
    );
    let slow = set(&earth, "schedule.window", "off");
    assert_eq!(
        (slow.schedule.iterations, slow.schedule.snap_at),
        (300, 240)
    );
    let long = set(&slow, "schedule.iterations", "600");
    assert_eq!(
        (long.schedule.attraction_from, long.schedule.snap_at),
        (340, 480)
    );
    assert_eq!(long.schedule.horizon_over, [160, 300]);
    // The shortest run that snaps and tunes its controller.
    let short = set(&long, "schedule.iterations", "2");
    assert_eq!(
        (short.schedule.attraction_from, short.schedule.snap_at),
        (0, 1)
    );
    let layout = set(&long, "start.kind", "layout");
    assert_eq!(layout.schedule.snap_at, 0);
}

/// A robot whose actuators can lift more than 1.5 times its weight begins with smaller strokes and learns in smaller steps,
/// but in short rollouts it may learn faster.
#[test]
fn strong_robots_are_treated_with_care() {
    let earth = Scene::load("earth").unwrap();
    // One actuator of 30 N/m lifts 0.23 times the weight.
    for (stiffness, care) in [(30.0, 1.0), (180.0, 1.0), (600.0, 0.321), (1e5, 0.1)] {
        let strong = set(
            &earth,
            "materials.stiffness",
            &format!("[1e-7, 1e5, {stiffness}]"),
        );
        let shares = |strong: &Scene| {
            [
                strong.controller.gain[1] / earth.controller.gain[1],
                strong.adam.rate / earth.adam.rate,
                strong.adam.fine_rate / earth.adam.fine_rate,
            ]
        };
        for share in shares(&strong) {
            assert!((share - care).abs() < 0.005, "{share} at {stiffness} N/m");
        }
        let [short, long] = [1, 16].map(|parts| {
            let steps = parts * strong.physics.steps / 4;
            shares(&set(&strong, "physics.steps", &steps.to_string()))
        });
        for (share, expected) in short
            .into_iter()
            .zip([care, care.powf(0.25), care.powf(0.25)])
        {
            // The tolerance above, to the power of a quarter.
            assert!(
                (share - expected).abs() < 0.005,
                "{share} at {stiffness} N/m"
            );
        }
        // Longer rollouts than usual need no more care.
        assert_eq!(long[1..], shares(&strong)[1..]);
    }
}

/// A template keeps the word "auto", so that the numbers follow the user's changes. The scene of a run has numbers.
#[test]
fn a_run_keeps_the_numbers_and_a_template_keeps_the_word() {
    let scene = set(&Scene::load("earth").unwrap(), "lattice.columns", "9");
    let template = Scene::parse("template", &scene.to_toml()).unwrap();
    assert_eq!(template, scene);
    assert_eq!(values(&template), values(&scene));
    assert!(scene.to_toml().contains("\nomega = \"auto\"\n"));
    let run = scene.registry().parse("run", &scene.to_run_toml()).unwrap();
    assert_eq!(run, scene);
    assert!(run.following().is_empty());
    assert!(
        scene
            .to_run_toml()
            .contains("# Follows from the scene: 10 rad/s divided by the time scale, times")
    );
}

/// Numbers that follow out of range are refused by name.
#[test]
fn a_value_out_of_range_is_refused() {
    let earth = Scene::load("earth").unwrap();
    let refused = earth
        .set(&["physics.gravity=1e-9"])
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("`physics.dt` follows from the robot and its world as"),
        "{refused}"
    );
}

/// A robot that carries much or climbs, and a truss of which half cannot be stiff, get the bars of a stiff frame and a faster
/// clock. Others get those of the paper.
#[test]
fn a_robot_that_needs_bars_gets_them() {
    let earth = Scene::load("earth").unwrap();
    let follows = |scene: &Scene| {
        let of = |key: &str| {
            let settings = scene.settings().into_iter();
            settings
                .filter(|s| s.key == key)
                .map(|s| s.value)
                .next()
                .unwrap()
        };
        ["volume.solid", "volume.actuator", "controller.omega"].map(of)
    };
    let soft = ["[0.5, 0.5]", "[0.2, 0.22]", "10.0"];
    // 1.2 (2 * 36 - 3) of 110 edges are 0.753.
    let firm = ["[0.75, 0.85]", "[0.35, 0.45]", "20.0"];
    assert_eq!(follows(&earth), soft);
    // The bars of a half-full lattice weigh 0.42 kg.
    for (key, values) in [
        ("physics.payload_mass", ["0.13", "0.15"]),
        ("physics.incline_deg", ["4.9", "5.0"]),
        ("physics.incline_deg", ["-4.9", "-5.0"]),
    ] {
        assert_eq!(follows(&set(&earth, key, values[0])), soft, "{key}");
        assert_eq!(follows(&set(&earth, key, values[1])), firm, "{key}");
    }
    // Heavy nodes decide alone.
    let heavy = earth.set(&["physics.node_mass=0.1", "physics.payload_mass=1"]);
    assert_eq!(follows(&heavy.unwrap())[..2], ["[0.9, 1.0]", "[0.2, 1.0]"]);
}
