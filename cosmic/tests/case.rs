//! A case has every setting of its scene, those of own laws among them.

#![allow(unreachable_pub)] // `settings!` makes public structs.

use autodiff::Real;
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::Truss;
use cosmic::laws::{Bar, BarForce, Law, on_bars};
use cosmic::objective::Loss;
use cosmic::scene::Scene;
use cosmic::settings::{Field, within};
use cosmic::world::Trajectory;
use cosmic::{Registry, kernel};
use serde_json::Value;

cosmic::settings! {
    /// Which way a bar is pulled.
    enum Way {
        /// Together.
        Together = "together",
        /// Apart.
        Apart = "apart",
    }
}

cosmic::settings! {
    /// A law with a setting of every type.
    struct Everything {
        /// A number.
        number: f64 = 0.1, allowed within(-1e300, 1e300), source "a test";
        /// An integer.
        count: usize = 3, allowed within(0.0, 1e6), source "a test";
        /// Two numbers.
        pair: [f64; 2] = [0.25, -1.5], allowed within(-1e6, 1e6), source "a test";
        /// A bound that is off.
        off: Option<f64> = None, allowed within(0.0, 1e6), source "a test";
        /// A bound that is on.
        on: Option<f64> = Some(2.5), allowed within(0.0, 1e6), source "a test";
        /// A boolean.
        truth: bool = false, source "a test";
        /// A name.
        way: Way = Way::Together, source "a test";
    }
}

impl Law for Everything {
    const NAME: &'static str = "everything_of_case";
}

#[kernel]
impl BarForce for Everything {
    fn tension<R: Real>(_: &Self, _: Bar<R>) -> R {
        R::zero()
    }
}

/// A loss of a user.
struct Rest;

impl Loss for Rest {
    fn observed(&self, steps: usize) -> Vec<usize> {
        vec![steps]
    }

    fn loss<R: Real>(&self, walk: &Trajectory<R>) -> R {
        walk.payload(0).x.forward()
    }
}

/// What a program can add to scenes.
fn registry() -> Registry {
    let truss = Truss {
        nodes: [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0], [0.1, 0.1]]
            .map(Vector::from)
            .to_vec(),
        edges: vec![[0, 1], [1, 2], [0, 3], [1, 3], [2, 3]],
        rest: vec![0.11, 0.1, 0.14, 0.1, 0.14],
        ..Truss::default()
    };
    Registry::default()
        .with_law(on_bars::<Everything>())
        .with_loss("rest", Rest)
        .with_lattice("roof", truss)
}

/// The words in quotes in the phrase about what a field allows.
fn words(allowed: &str) -> Vec<String> {
    let words = allowed.split('"').skip(1).step_by(2);
    words.map(|word| format!("{word:?}")).collect()
}

/// Small scenes with all forces. One or the other allows most values of other settings.
fn scenes() -> [Scene; 4] {
    [
        "base = 'stability'\nlattice.columns = 3\nlattice.rows = 2\nphysics.contact = 'coulomb'",
        "base = 'stability'\nlattice.file = 'roof'",
        "base = 'errand'\nlattice.columns = 3\nlattice.rows = 2",
        "base = 'cube'\nlattice.columns = 2\nlattice.rows = 2\nlattice.depth = 3",
    ]
    .map(|base| {
        let text = format!("{base}\nparts.stroke = 1\ncontroller = {{hidden = 2, clocks = 2}}");
        let scene = registry().parse("scene", &text).unwrap();
        let forces = scene
            .clone()
            .field("physics.forces")
            .map(|field| words(&field.allowed()));
        let forces = forces.unwrap().join(", ");
        scene.set(&[format!("physics.forces=[{forces}]")]).unwrap()
    })
}

/// Texts of values, in TOML, of which a field with this value may allow some.
fn others(value: &Value, allowed: &str) -> Vec<String> {
    let mut others = words(allowed);
    match value {
        Value::Bool(is) => others.push((!is).to_string()),
        Value::Number(x) => others.extend(numbers(x.as_f64().unwrap(), x.is_u64())),
        Value::Array(list) => {
            let whole = list.iter().all(Value::is_u64);
            let all = list.iter().filter_map(Value::as_f64);
            let all: Vec<[String; 6]> = all.map(|x| numbers(x, whole)).collect();
            let each = (0..6).map(|k| all.iter().map(|x| &x[k][..]).collect::<Vec<_>>().join(", "));
            others.extend(each.map(|numbers| format!("[{numbers}]")));
            others.push("['stops', 'everything_of_case']".to_owned());
            others.push("[[0.5, 0.0], [0.75, 0.02]]".to_owned());
        }
        _ => others.extend(["0.5", "'roof'", "'0.1 * 2'", "[2e9, 900.0]"].map(str::to_owned)),
    }
    others
}

/// Numbers near `x`.
fn numbers(x: f64, whole: bool) -> [String; 6] {
    let near = [1.25 * x, 0.75 * x, x + 1.0, x - 1.0, x + 0.1, 3.0];
    near.map(|near| match whole {
        true => (near.ceil() as usize).to_string(),
        false => format!("{near:?}"),
    })
}

/// The scene with another value of the setting `key`; `None` if none of the [others] fits the scene.
fn changed(scene: &Scene, key: &str) -> Option<Scene> {
    let field = |field: Field| others(&field.value.json(), &field.allowed());
    let others = scene.clone().field(key).map(field)?;
    others.iter().find_map(|value| {
        let other = scene.set(&[format!("{key}={value}")]).ok()?;
        (other.settings() != scene.settings()).then_some(other)
    })
}

/// The robot of a scene is the same after it was written as a case and read: its lattice, its controller, and every setting
/// of the scene. The case names no other file.
fn survives(scene: &Scene, key: &str) {
    let case = Case::of_scene(scene, 1).unwrap();
    let text = case.to_json();
    let read =
        Case::parse_with(&registry(), "case", &text).unwrap_or_else(|e| panic!("{key}: {e}"));
    assert_eq!(read.scene, *scene, "{key}");
    assert_eq!(read, case, "{key}");
    assert!(!text.contains("roof"), "{key}");
}

#[test]
fn every_setting_survives() {
    let scenes = scenes();
    let keys = scenes
        .iter()
        .flat_map(Scene::settings)
        .map(|setting| setting.key);
    let keys: std::collections::BTreeSet<String> = keys.collect();
    let mut unchanged = Vec::new();
    for key in &keys {
        match scenes.iter().find_map(|scene| changed(scene, key)) {
            Some(scene) => survives(&scene, key),
            None => unchanged.push(key),
        }
    }
    println!(
        "{} of {} keys were changed, not {unchanged:?}",
        keys.len() - unchanged.len(),
        keys.len()
    );
    assert!(30 * unchanged.len() < keys.len(), "{unchanged:?}");
}

/// Numbers that only cases have survive too.
#[test]
fn every_number_of_cases_survives() {
    let [scene, ..] = scenes();
    let mut keys = Vec::new();
    scene.clone().of_sections(|section, settings| {
        let fields = settings.fields_of_cases().into_iter();
        let fields = fields.filter(|field| field.of_cases);
        keys.extend(fields.map(|field| (section, field.key)));
    });
    assert!(keys.contains(&("physics", "passes")));
    for (section, key) in keys {
        let mut other = scene.clone();
        other.of_sections(|name, settings| {
            let fields = settings.fields_of_cases().into_iter();
            for field in fields.filter(|field| (name, field.key) == (section, key)) {
                let value = others(&field.value.json(), "").remove(0);
                field.read_text(&value).unwrap();
            }
        });
        assert_ne!(other, scene, "{key}");
        survives(&other, key);
    }
}

/// A program without the law of a case says so, at its place.
#[test]
fn an_unknown_law_is_named() {
    let [scene, ..] = scenes();
    let text = Case::of_scene(&scene, 1).unwrap().to_json();
    let says = Case::parse("case.json", &text).unwrap_err().to_string();
    assert!(
        says.contains("`scene.physics.forces` names an unknown law:"),
        "{says}"
    );
    assert!(says.contains("everything_of_case"), "{says}");
}

/// Each change of a case makes it wrong, and the message has the place and these words.
#[test]
fn wrong_scenes_of_cases_are_refused() {
    let [scene, truss, ..] = scenes();
    let refused = |scene: &Scene, pointer: &str, value: Value, words: &str| {
        let text = Case::of_scene(scene, 1).unwrap().to_json();
        let mut json: Value = serde_json::from_str(&text).unwrap();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        let parent = json.pointer_mut(parent).unwrap().as_object_mut().unwrap();
        match value {
            // Stands for no value at all.
            Value::Null => parent.remove(key),
            value => parent.insert(key.to_owned(), value),
        };
        let says = Case::parse_with(&registry(), "case.json", &json.to_string());
        let says = says.expect_err(words).to_string();
        assert!(
            says.contains(words) && says.contains("case.json:1:"),
            "{says}"
        );
    };
    let of_scene =
        |pointer: &str, value: Value, words: &str| refused(&scene, pointer, value, words);
    of_scene(
        "/scene/physics/dt",
        "fast".into(),
        "`scene.physics.dt` is a string: \"fast\"; allowed: a number from 1e-9 to 1",
    );
    of_scene(
        "/scene/physics/dt",
        2.0.into(),
        "`scene.physics.dt` is out of range: 2.0",
    );
    of_scene(
        "/scene/physics/dt",
        Value::Null,
        "`scene`: `physics.dt` is missing",
    );
    of_scene(
        "/scene/stops/at",
        Value::Null,
        "`scene`: `stops.at` is missing",
    );
    of_scene(
        "/scene/projection/beta",
        Value::Null,
        "`scene`: `projection.beta` is missing",
    );
    of_scene(
        "/scene/physics/colour",
        1.into(),
        "`scene.physics.colour`: unknown key `physics.colour`",
    );
    of_scene(
        "/scene/physics",
        1.into(),
        "`scene.physics`: expected a section of the scene, found 1",
    );
    let steps = scene.set(&["ground.profile=steps"]).unwrap();
    refused(
        &steps,
        "/scene/ground/spacing",
        1e-300.into(),
        "`scene.ground`: the profile of the ground has the same point twice",
    );
    of_scene("/scene/lattice/columns", 4.into(), "rows of `x0`");
    of_scene(
        "/scene/controller/hidden",
        3.into(),
        "entries in `controller.b1`",
    );
    of_scene(
        "/scene/lattice/file",
        "roof.json".into(),
        "`scene.lattice.file`: the truss must be in the case",
    );
    of_scene(
        "/version",
        3.into(),
        "version 3, not \"cosmic-case\" version 1 or 2",
    );
    of_scene(
        "/version",
        1.into(),
        "`scene.actuator`: unknown field `actuator`",
    );
    refused(
        &truss,
        "/truss",
        Value::Null,
        "`scene.lattice.file`: the truss must be in the case",
    );
    refused(
        &truss,
        "/scene/lattice/file",
        "off".into(),
        "`truss`: the scene has no truss",
    );
    refused(
        &truss,
        "/edges",
        serde_json::json!([[1, 0], [1, 2], [0, 3], [1, 3], [2, 3]]),
        "`edges`: expected the edges of `truss`",
    );
}
