#![allow(unreachable_pub)] // `settings!` makes public structs.

use autodiff::Real;
use cosmic::Registry;
use cosmic::kernel;
use cosmic::laws::{Bar, BarForce, ContactLaw, ForceLaws, Law, LawFile, on_bars};
use cosmic::settings::{Field, SettingValue, Settings, read_json, within};
use serde_json::{Value, json};

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

/// Values that the tests try for a setting: `null`, a boolean, numbers, and every allowed name.
fn others(field: &Field) -> Vec<Value> {
    let values = [
        json!(null),
        json!(true),
        json!(1),
        json!(0.5),
        json!([0.5, 1e-7]),
    ];
    let names = field.allowed();
    let names = names.split('"').skip(1).step_by(2).map(Value::from);
    values.into_iter().chain(names).collect()
}

fn law_json(name: &str, law: &mut dyn Settings) -> Value {
    serde_json::to_value(LawFile::new(name, law)).unwrap()
}

/// For every setting of a law, changes the setting, writes the law, reads it back, and checks that it is the same.
fn round_trip(name: &'static str, law: &mut dyn Settings, read: &dyn Fn(&Value) -> Value) {
    let (keys, mut tried) = (law.fields().len(), 0);
    for k in 0..keys {
        let values = others(&law.fields()[k]);
        let before = law_json(name, law);
        let mut changed = false;
        for value in values {
            let field = law.fields().swap_remove(k);
            // If the setting rejects the value, the setting does not change.
            let _ = read_json(field, &value);
            let written = law_json(name, law);
            assert_eq!(read(&written), written);
            changed |= written != before;
        }
        tried += usize::from(changed);
    }
    assert_eq!(tried, keys, "{name}: a setting did not change");
}

/// Reads force laws from a JSON text, in a program that knows the law [`Everything`].
fn forces(text: &str) -> Result<ForceLaws, String> {
    let mut laws = ForceLaws::default();
    laws.know(&Registry::default().with_law(on_bars::<Everything>()));
    let files: Vec<LawFile> = serde_json::from_str(text).map_err(|error| error.to_string())?;
    laws.read_files(&files).map(|()| laws)
}

#[test]
fn laws_are_read_as_they_are_written() {
    for name in ["damper", "stops", Everything::NAME] {
        let mut laws = forces(&json!([name]).to_string()).unwrap();
        let read = |written: &Value| {
            let laws = forces(&json!([written]).to_string()).unwrap();
            serde_json::to_value(laws).unwrap()[0].clone()
        };
        let (name, law) = laws.settings().next().unwrap();
        round_trip(name, law, &read);
    }
    for mut contact in [
        ContactLaw::none(),
        ContactLaw::infinite(),
        ContactLaw::coulomb(),
    ] {
        let read = |written: &Value| {
            let mut contact = ContactLaw::infinite();
            let file = serde_json::from_value(written.clone()).unwrap();
            contact.read_file(&file).unwrap();
            serde_json::to_value(contact).unwrap()
        };
        round_trip(contact.name(), contact.settings(), &read);
    }
    // `along_bars` finds a law even if one of its settings is off.
    let all = forces(&json!([Everything::NAME]).to_string()).unwrap();
    assert_eq!(all.along_bars::<Everything>(), Some(Everything::default()));
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
