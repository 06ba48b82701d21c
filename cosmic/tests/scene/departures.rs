//! Checks that every value of a key is a plain number, is a value of the paper, or is a departure.
#![allow(unreachable_pub)] // `settings!` makes public structs.

use crate::small::Up;
use autodiff::Real;
use cosmic::geometry::Vector;
use cosmic::lattice::Lattice;
use cosmic::laws::{Contact, Impact, Law};
use cosmic::scene::{Scene, Setting, TrussFile};
use cosmic::{Registry, laws};
use std::collections::HashSet;
use std::sync::Arc;

/// Settings that switch off every departure of the paper's scenes.
const WITHOUT: &str = "
gradient = { design_memory = 0.0, cotangent_bound = 'off' }
schedule = { settle = 0.0, snap_trials = 0, polish_trials = 0 }
loss.kind = 'final'
selection.kind = 'last'
design.one_piece = false
";

/// For each key, the values that agree with the paper: the paper uses them or leaves them open, or they do not change
/// the method. A new word that a key allows, or a new key whose values are not numbers, is listed here or is a departure
/// from the paper.
const PAPERS: &[(&str, &[&str])] = &[
    ("lattice.kind", &["\"rectangular\""]),
    ("lattice.file", &["\"off\""]),
    ("lattice.mirror", &["false"]),
    ("physics.integrator", &["\"symplectic_euler\""]),
    ("physics.contact", &["\"infinite\"", "\"coulomb\""]),
    ("physics.void_edges", &["\"keep\""]),
    // This setting decides which runs are refused. It does not change a run.
    ("physics.unstable_step", &["\"error\"", "\"warn\""]),
    // This setting decides which rollouts have no result. It does not change a rollout.
    ("physics.speed_bound", &["\"off\"", "1.0"]),
    ("ground.profile", &["\"flat\""]),
    // The points are read only with the profile "points", which is a departure.
    ("ground.points", &["[[1.0, 0.1]]"]),
    ("controller.policy", &["\"mlp\""]),
    ("controller.clock", &["\"fixed\""]),
    ("controller.goals", &["\"fixed\""]),
    // The starts of the paper's designs d, b and c, of its ablation, and of its design a.
    (
        "start.kind",
        &[
            "\"uniform\"",
            "\"stability\"",
            "\"three_legged\"",
            "\"filled\"",
            "\"layout\"",
        ],
    ),
    ("start.layout", &["\"tall\""]),
    ("design.one_piece", &["false"]),
    ("design.free_ends", &["true"]),
    ("design.crossings", &["true"]),
    ("binarisation.method", &["\"augmented\""]),
    ("gradient.cotangent_bound", &["\"off\""]),
    // The gradient does not depend on the memory.
    ("gradient.memory", &["\"off\"", "1.0"]),
    ("gradient.precision", &["\"f64\""]),
    ("loss.kind", &["\"final\""]),
    ("selection.kind", &["\"last\""]),
    ("parts.skeleton", &["\"numbers\""]),
    ("parts.actuator", &["\"numbers\""]),
    // The material and the joints are read only with parts, which are a departure.
    (
        "parts.material",
        &[
            "\"carbon\"",
            "\"glass\"",
            "\"aluminium\"",
            "\"steel\"",
            "\"pla\"",
            "[2e9, 900.0]",
        ],
    ),
    ("parts.joint", &["\"off\"", "1.0"]),
    ("parts.length", &["\"off\"", "1.0"]),
    ("parts.force", &["\"off\"", "1.0"]),
    ("parts.speed", &["\"off\"", "1.0"]),
    ("parts.bore", &["\"off\"", "1.0"]),
    ("objective.task", &["\"far\""]),
    ("objective.body", &["\"payload\""]),
    ("objective.own_loss", &["\"off\""]),
];

/// Values to try for keys whose description does not list all their values.
const MORE_VALUES: &[(&str, &[&str])] = &[
    ("ground.points", &["[[1.0, 0.1]]"]),
    ("parts.material", &["[2e9, 900.0]"]),
];

/// For a key that only some scenes read, settings with which the scene reads it.
const READ_WITH: &[(&str, &str)] = &[("start.layout", "start.kind = 'three_legged'")];

/// Settings that are 0 in the paper's scenes, but switch nothing on if they are another number.
const PLAIN: &[&str] = &[
    "lattice.drop",
    "physics.incline_deg",
    "ground.seed",
    "parts.end_mass",
];

cosmic::settings! {
    /// A contact law of ground without friction: it leaves the velocity along the ground unchanged.
    struct Ice {}
}

impl Law for Ice {
    const NAME: &'static str = "ice_of_departures";
}

impl Contact for Ice {
    fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
        impact.velocity.along()
    }
}

/// The scene of the paper with this name, after all its departures are switched off.
fn paper(name: &str) -> Scene {
    let scene = Scene::load(name).unwrap();
    scene.with("without departures", WITHOUT).unwrap()
}

fn options(scene: &Scene) -> HashSet<String> {
    let departures = scene.departures().into_iter();
    departures.map(|departure| departure.option).collect()
}

/// The scene with `key` set to `value`, even if the value contradicts other settings. `None` if the key does not allow
/// the value.
fn with(scene: &Scene, key: &str, value: &str) -> Option<Scene> {
    let mut scene = scene.clone();
    scene.field(key)?.read_text(value).ok()?;
    Some(scene)
}

/// The values that a table lists for a key.
fn listed(table: &[(&str, &'static [&'static str])], key: &str) -> &'static [&'static str] {
    let entry = table.iter().find(|(other, _)| *other == key);
    entry.map_or(&[], |(_, values)| *values)
}

/// True if the text is a number or an array of numbers in TOML.
fn is_numeric(value: &str) -> bool {
    let mut parts = value
        .split(['[', ']', ',', ' '])
        .filter(|part| !part.is_empty())
        .peekable();
    parts.peek().is_some() && parts.all(|part| part.parse::<f64>().is_ok())
}

/// The values to try for a key: the names in its description, both booleans, a number if the key can be "off", and the
/// values in [`MORE_VALUES`]. Empty for a key whose values are plain numbers.
fn values(scene: &mut Scene, key: &str) -> Vec<String> {
    let field = scene.field(key).unwrap();
    // Without "auto", which stands for a number.
    let (allowed, value) = (field.value.allowed(&field.limits), field.value.toml());
    if allowed == "true or false" {
        return vec!["true".to_owned(), "false".to_owned()];
    }
    let names = allowed.split('"').skip(1).step_by(2);
    let mut values: Vec<String> = names.map(|name| format!("{name:?}")).collect();
    if allowed.starts_with("a number") && !values.is_empty() {
        values.push("1.0".to_owned());
    }
    values.extend(listed(MORE_VALUES, key).iter().map(ToString::to_string));
    assert!(
        !values.is_empty() || is_numeric(&value),
        "{key}: list its values in MORE_VALUES"
    );
    values
}

#[test]
fn every_value_that_is_not_a_number_is_in_the_paper_or_a_departure() {
    let registry = Registry::default().with_loss("own", Up);
    let registry = registry.with_law(laws::contact::<Ice>());
    let scene = paper("stability").knowing(&registry);
    let mut papers: HashSet<(String, String)> = HashSet::new();
    for setting in scene.settings() {
        let key = &setting.key[..];
        let mut base = scene.clone();
        for (_, settings) in READ_WITH.iter().filter(|(other, _)| *other == key) {
            base = base.with("read with", settings).unwrap();
        }
        for value in values(&mut base, key) {
            // The setting of forces takes an array of names.
            let changed = [value.clone(), format!("[{value}]")];
            let changed = changed.iter().find_map(|value| with(&base, key, value));
            let changed = changed.unwrap_or_else(|| panic!("{key} cannot be {value}"));
            let is_paper_s = listed(PAPERS, key).contains(&&value[..]);
            assert_ne!(
                options(&changed).contains(key),
                is_paper_s,
                "{key} = {value} must be a departure or in PAPERS, and not both"
            );
            if is_paper_s {
                papers.insert((key.to_owned(), value));
            }
        }
    }
    for (key, values) in PAPERS {
        for value in *values {
            let entry = ((*key).to_owned(), (*value).to_owned());
            assert!(papers.contains(&entry), "{key} = {value}: no scene has it");
        }
    }
}

/// A number that is 0 in the paper's scenes must be a departure if it is not 0, or be listed in [`PLAIN`].
#[test]
fn every_number_that_switches_something_on_is_a_departure() {
    let scene = paper("stability");
    for Setting { key, value, .. } in scene.settings() {
        if value.parse() != Ok(0.0) {
            continue;
        }
        let more = ["1", "0.5", "0.01"];
        let more = more
            .iter()
            .find_map(|more| with(&scene, &key, more))
            .unwrap();
        let is_plain = PLAIN.contains(&&key[..]);
        assert_ne!(
            options(&more).contains(&key),
            is_plain,
            "{key} must be a departure or in PLAIN, and not both"
        );
    }
}

#[test]
fn a_truss_is_a_departure() {
    let mut scene = paper("stability");
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    scene.lattice.file = TrussFile::new("of this test", Arc::new(lattice.truss()));
    assert_eq!(options(&scene), HashSet::from(["lattice.file".to_owned()]));
}

#[test]
fn the_paper_s_scenes_only_have_departures_that_can_be_switched_off() {
    for name in [
        "stability",
        "uniform",
        "incline",
        "five_by_five",
        "coulomb",
        "baseline_tall",
        "baseline_short",
    ] {
        assert_eq!(options(&paper(name)), HashSet::new(), "{name}");
    }
    // In the paper, this start follows the baseline's layout, `tall`. The scene `three_legged` follows `short`.
    let legs = paper("three_legged");
    assert_eq!(options(&legs), HashSet::from(["start.layout".to_owned()]));
}

/// A setting that the scene does not read is no departure.
#[test]
fn a_layout_has_no_departures_in_settings_for_designing() {
    let text = "
        [design]
        free_ends = false
        crossings = false
        feet = 2
        [projection]
        hold_materials = 1.0
        [materials]
        penalisation = 3
        [binarisation]
        method = 'constraints'
        [schedule]
        stability_share = 0.0
    ";
    let of = |name| options(&paper(name).with("designs", text).unwrap());
    assert_eq!(of("baseline_tall"), HashSet::new());
    assert_eq!(of("uniform").len(), 7);
}

/// If a program's own loss replaces the task, the task and its loss are not read. So they are no departures.
#[test]
fn an_own_loss_replaces_the_task_s() {
    let registry = Registry::default().with_loss("own", Up);
    let scene = registry.load("stability").unwrap();
    let scene = scene.set(&["objective.own_loss=own", "objective.task=climb"]);
    let scene = scene.unwrap();
    let options = options(&scene);
    assert!(options.contains("objective.own_loss"), "{options:?}");
    assert!(
        !options.contains("loss.kind") && !options.contains("objective.task"),
        "{options:?}"
    );
}
