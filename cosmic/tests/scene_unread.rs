//! Tests of the warnings about settings without effect. The tests change these settings to check that they really have
//! none.

use autodiff::Real;
use cosmic::Registry;
use cosmic::lattice::Truss;
use cosmic::objective::Loss;
use cosmic::scene::Scene;
use cosmic::search::CoDesign;
use cosmic::world::Trajectory;
use std::collections::BTreeSet;

/// A loss that is smaller if the payload ends higher.
struct Height;

impl Loss for Height {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        -trajectory.payload(0).x.up()
    }
}

const TRUSS: &str = r#"{"format": "cosmic-truss", "version": 1,
    "nodes": [[0.1, 0.0], [0.2, 0.0], [0.1, 0.1], [0.2, 0.1]],
    "edges": [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]}"#;

/// Settings of a scene with a small robot that moves, and with an optimisation that has every phase.
const SMALL: [&str; 19] = [
    "lattice.columns=3",
    "lattice.rows=3",
    "lattice.drop=0.01",
    "physics.steps=96",
    "controller.hidden=3",
    "controller.gain=[6, 6]",
    "projection.hold_materials=0.1",
    "volume.solid=[0.3, 0.7]",
    "volume.actuator=[0, 0.42]",
    "schedule.iterations=14",
    "schedule.attraction_from=5",
    "schedule.snap_at=8",
    "schedule.horizon=[48, 96]",
    "schedule.horizon_over=[2, 6]",
    "schedule.snap_trials=4",
    "schedule.polish_trials=4",
    "binarisation.threshold_over=[1, 6]",
    "loss.window=16",
    "loss.every=4",
];

/// Other scenes, each as changes of the settings in [`SMALL`].
const OTHERS: [&[&str]; 25] = [
    &[
        "lattice.columns=6",
        "lattice.rows=6",
        "start.kind=layout",
        "schedule.snap_at=0",
        "schedule.attraction_from=0",
    ],
    &[],
    &["physics.contact=coulomb", "robust.samples=1"],
    &["physics.contact=none"],
    &[
        "ground.profile=steps",
        "ground.from=0.02",
        "ground.spacing=0.02",
    ],
    &[
        "ground.profile=rough",
        "ground.from=0.02",
        "ground.spacing=0.02",
    ],
    &[
        "ground.profile=points",
        "ground.points=[[0.0, 0.0], [0.1, 0.01]]",
    ],
    &[
        "start.kind=layout",
        "start.layout=filled",
        "schedule.snap_at=0",
        "schedule.attraction_from=0",
    ],
    &["start.kind=filled", "start.void=0.4"],
    &["start.kind=uniform"],
    &["physics.integrator=implicit"],
    &["loss.kind=final"],
    &["schedule.window=0.05"],
    &["objective.task=reach"],
    &["objective.task=economy"],
    &["objective.own_loss=height"],
    &["controller.goal_scale=0"],
    &[
        "binarisation.method=constraints",
        "schedule.polish_trials=0",
    ],
    &["gradient.cotangent_bound=off", "schedule.horizon=[96, 96]"],
    &["selection.kind=last", "gradient.cotangent_bound=0.01"],
    &["lattice.file=square", "lattice.drop=0"],
    &[
        "parts.skeleton=tube",
        "parts.material=[2.5e6, 2000]",
        "parts.joint=1e4",
    ],
    &[
        "parts.actuator=device",
        "parts.actuator_mass=0.01",
        "parts.stroke=0.2",
        "parts.bore=0.01",
        "parts.end_mass=0.001",
    ],
    &[
        "controller.goals=given",
        "controller.goal_scale=3",
        "objective.task=reach",
        "robust.samples=1",
    ],
    &[
        "controller.goals=given",
        "controller.policy=gaits",
        "controller.goal_scale=3",
        "objective.task=reach",
        "selection.kind=robust",
    ],
];

/// More values to try for some keys: names, and numbers that differ much from those in the scenes.
const NAMES: [&str; 12] = [
    "design.feet=3",
    "lattice.kind=triangular",
    "ground.profile=rough",
    "ground.points=[[0.0, 0.0], [0.05, 0.02]]",
    "start.layout=filled",
    "start.layout=tall",
    "objective.task=climb",
    "parts.material=steel",
    "parts.joint=2e3",
    "parts.bore=0.02",
    "loss.kind=final",
    "binarisation.method=constraints",
];

/// Values to try for a key instead of `value`: slightly larger and smaller numbers, the other boolean, and the values
/// in [`NAMES`].
fn others(key: &str, value: &str) -> Vec<String> {
    let named = NAMES
        .iter()
        .filter(|name| name.starts_with(&format!("{key}=")));
    let mut all: Vec<String> = named.map(|name| (*name).to_owned()).collect();
    let is_text = value.contains('"');
    for more in [true, false] {
        let changed = |number: &str| match (number.parse::<i64>(), number.parse::<f64>()) {
            (Ok(n), _) => (n + if more { 1 } else { -1 }).to_string(),
            (_, Ok(x)) => format!("{:?}", if more { 1.2 * x + 0.01 } else { 0.8 * x }),
            _ => match number {
                "true" => "false".to_owned(),
                "false" => "true".to_owned(),
                other => other.to_owned(),
            },
        };
        let inner = value.trim_start_matches('[').trim_end_matches(']');
        let entries: Vec<_> = inner.split(", ").map(changed).collect();
        let entries = entries.join(", ");
        match value.starts_with('[') {
            _ if is_text => {}
            true => all.push(format!("{key}=[{entries}]")),
            false => all.push(format!("{key}={entries}")),
        }
    }
    all
}

/// The result of an optimisation as text: the delivered design with every measured number; `None` if the scene fails.
fn outcome(scene: &Scene) -> Option<String> {
    let delivery = CoDesign::new(scene).ok()?.optimise(0, |_| ());
    delivery.ok().map(|delivery| format!("{delivery:?}"))
}

/// The warning that a key has no effect, if the scene has this warning.
fn warning(scene: &Scene, key: &str) -> Option<String> {
    let mut warnings = scene.warnings().into_iter();
    let of_key = |warning: &cosmic::scene::Finding| {
        warning.says.starts_with("this setting has no effect") && warning.settings[0].key == key
    };
    warnings.find(of_key).map(|warning| warning.to_string())
}

/// The scene of a small robot, with these changes.
fn small(changes: &[&str]) -> Scene {
    let square: Truss = serde_json::from_str(TRUSS).unwrap();
    let registry = Registry::default().with_loss("height", Height);
    let registry = registry.with_lattice("square", square);
    let small = registry.load("stability").unwrap().set(&SMALL).unwrap();
    small.set(changes).unwrap()
}

/// Every scene that differs from this scene in one key, with this key.
fn changes(scene: &Scene) -> Vec<(String, Scene)> {
    let settings = scene.settings().into_iter();
    let changed = settings.flat_map(|s| {
        let others = others(&s.key, &s.value).into_iter();
        others.filter_map(move |other| Some((s.key.clone(), scene.set(&[other]).ok()?)))
    });
    changed
        .filter(|(key, changed)| changed.settings().iter().any(|s| s.key == *key))
        .collect()
}

/// The keys that have a warning in this scene. Panics if changing such a key changes a bit of the result, `before`.
fn without_effect(scene: &Scene, before: &String) -> BTreeSet<String> {
    let mut keys = BTreeSet::new();
    for (key, changed) in changes(scene) {
        if warning(&changed, &key).is_some() {
            let after = outcome(&changed);
            assert_eq!(
                after.as_ref(),
                Some(before),
                "{key} in {:?}",
                scene.changed()
            );
            keys.insert(key);
        }
    }
    keys
}

/// The next test, on one scene.
#[test]
fn settings_with_a_warning_have_no_effect() {
    let scene = small(&[]);
    let keys = without_effect(&scene, &outcome(&scene).expect("it ends"));
    assert!(keys.len() > 10, "{keys:?}");
}

/// If a scene warns that a key has no effect, changing the key does not change a bit of the result. Conversely, every
/// key with such a warning has an effect in another scene, which does not have the warning. So no warning is given too
/// often.
#[test]
#[ignore = "takes two minutes; check-heavy.sh runs it"]
fn exactly_the_settings_without_effect_have_a_warning() {
    let scenes = OTHERS.map(small);
    let outcomes: Vec<_> = scenes
        .iter()
        .map(|scene| outcome(scene).expect("it ends"))
        .collect();
    let all = || scenes.iter().zip(&outcomes);
    let mut idle: BTreeSet<_> = all()
        .flat_map(|(scene, before)| without_effect(scene, before))
        .collect();
    assert!(idle.len() > 40, "{}", idle.len());
    for (scene, before) in all() {
        for (key, changed) in changes(scene) {
            if idle.contains(&key)
                && warning(&changed, &key).is_none()
                && outcome(&changed).is_none_or(|after| after != *before)
            {
                idle.remove(&key);
            }
        }
    }
    // These keys decide only which scenes are refused, and what the verdict says.
    for key in ["stroke", "length", "force", "speed"] {
        idle.remove(&format!("parts.{key}"));
    }
    assert_eq!(idle, BTreeSet::new(), "these keys matter nowhere");
}

#[test]
fn only_values_that_differ_from_the_base_get_a_warning() {
    let ice = "base = \"stability\"\n[physics]\nfriction = 0.8\n[ground]\nrise = 0.1\n[loss]\nwindow = 2048\n";
    let warnings = |text: &str| -> Vec<String> {
        let warnings = Scene::parse("ice", text).unwrap().warnings().into_iter();
        warnings.map(|warning| warning.to_string()).collect()
    };
    let expected = [
        "this setting has no effect: it is read only with a contact law that slips (physics.friction = 0.8)",
        "this setting has no effect: it is read only with the profile `steps` (ground.rise = 0.1)",
    ];
    assert_eq!(warnings(ice), expected);
    assert_eq!(
        warnings(&ice.replace("0.8", "0.8\ncontact = \"coulomb\"")),
        expected[1..]
    );
    // With the base `earth`, the friction has an effect, and the window is the same as in the base.
    assert_eq!(warnings(&ice.replace("stability", "earth")), expected[1..]);
    assert_eq!(
        warnings(&ice.replace("0.8", "2.5").replace("0.1", "0.02")),
        [""; 0]
    );
}

/// End stops that an actuator cannot reach, or that give way more than the actuator, are probably those of another robot.
#[test]
fn stops_that_do_not_fit_their_actuators_get_a_warning() {
    let said = |scene: &Scene| -> Vec<String> {
        let warnings = scene.warnings().into_iter();
        warnings.map(|warning| warning.to_string()).collect()
    };
    let world = "[materials]\nstiffness = [1e-7, 1e5, 2000.0]\nmax_strain = [0.0, 0.0, 0.2]\n";
    let world = Scene::parse("world", world).unwrap();
    assert_eq!(said(&world), [] as [&str; 0]);
    let beyond = said(&world.set(&["stops.at=0.27"]).unwrap());
    assert!(
        matches!(&beyond[..], [one] if one.contains("beyond the stroke") && one.contains("0.27")),
        "{beyond:?}"
    );
    let soft = said(&world.set(&["stops.stiffness=1300"]).unwrap());
    assert!(
        matches!(&soft[..], [one] if one.contains("softer") && one.contains("1300")),
        "{soft:?}"
    );
    // Just stiff enough, for stops at the end of the stroke.
    let fits = ["stops.stiffness=2000", "stops.at=0.2"];
    assert_eq!(said(&world.set(&fits).unwrap()), [] as [&str; 0]);
    // Without stops, or without a stroke, there is nothing to fit.
    assert_eq!(
        said(&world.set(&["physics.forces=[]"]).unwrap()),
        [] as [&str; 0]
    );
    let still = world.set(&["stops.at=0.27", "materials.max_strain=[0.0, 0.0, 0.0]"]);
    assert!(
        said(&still.unwrap())
            .iter()
            .all(|warning| !warning.contains("stops"))
    );
}

/// A frame of 36 nodes in the plane has a floppy mode unless it has 69 bars, and the lattice has 110 edges.
#[test]
fn too_few_bars_for_a_stiff_robot_get_a_warning() {
    let earth = Scene::load("earth").unwrap();
    let warned = |most: &str| {
        let scene = earth.set(&[format!("volume.solid=[0.3, {most}]")]).unwrap();
        let found = scene.warnings().into_iter();
        let mut says = found.map(|warning| warning.to_string());
        says.any(|says| says.contains("every design sags") && says.contains("volume.solid"))
    };
    assert!(warned("0.62") && !warned("0.63"));
    // The share of the paper is a default.
    assert!(!earth.warnings().iter().any(|w| w.says.contains("sags")));
}
