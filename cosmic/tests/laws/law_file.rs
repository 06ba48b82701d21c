#![allow(unreachable_pub)] // `settings!` makes public structs.

use autodiff::Real;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::kernel;
use cosmic::laws::{Bar, BarForce, ForceLaws, Law, LawFile, on_bars};
use cosmic::scene::Scene;
use cosmic::settings::{SettingValue, within};

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
    const NAME: &'static str = "everything_of_law_file";
}

#[kernel]
impl BarForce for Everything {
    fn tension<R: Real>(_: &Self, _: Bar<R>) -> R {
        R::zero()
    }
}

/// Reads force laws from a JSON text, in a program that knows the law [`Everything`].
fn forces(text: &str) -> Result<ForceLaws, String> {
    let mut laws = ForceLaws::default();
    laws.know(&Registry::default().with_law(on_bars::<Everything>()));
    let files: Vec<LawFile> = serde_json::from_str(text).map_err(|error| error.to_string())?;
    laws.read_files(&files).map(|()| laws)
}

/// A case has all settings of a law, whatever their types are.
#[test]
fn laws_are_read_as_they_are_written() {
    let registry = Registry::default().with_law(on_bars::<Everything>());
    let text = "base = 'stability'\nphysics.forces = ['stops', 'everything_of_law_file']\neverything_of_law_file = {number = \
                1e-7, count = 5, pair = [0.5, 3.0], off = 7.5, on = 'off', truth = true, way = 'apart'}";
    let scene = registry.parse("everything", text).unwrap();
    let expected = Everything {
        number: 1e-7,
        count: 5,
        pair: [0.5, 3.0],
        off: Some(7.5),
        on: None,
        truth: true,
        way: Way::Apart,
    };
    let along_bars = |scene: &Scene| scene.physics.forces.along_bars::<Everything>();
    assert_eq!(along_bars(&scene), Some(expected));
    let case = Case::of_scene(&scene, 0).unwrap();
    let read = Case::parse_with(&registry, "case", &case.to_json()).unwrap();
    assert_eq!(read.scene.physics.forces, scene.physics.forces);
}

/// Each list of laws in `wrong_laws.txt` is refused, and the message has the words that follow it.
#[test]
fn malformed_laws_are_refused() {
    let (_, rows) = include_str!("../wrong_laws.txt")
        .split_once("\n\n")
        .unwrap();
    let lines: Vec<&str> = rows.lines().collect();
    for [text, words] in lines.as_chunks::<2>().0 {
        let error = forces(text).unwrap_err();
        assert!(
            error.contains(words.trim_start_matches("! ")),
            "{text}: {error}"
        );
    }
    // Two laws in two objects keep their order.
    let both = r#"[{"stops": {"at": 0.2}}, "damper"]"#;
    let both = forces(both).unwrap();
    let names: Vec<_> = both.about().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["stops", "damper"]);
    let contact = serde_json::from_str::<LawFile>(r#"{"coulomb": {}, "none": {}}"#);
    assert!(contact.is_err());
}
