//! The JSON form of laws in case files.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::settings::{Settings, read_json};

/// A law in JSON. It is either its name, or an object that maps its name to its settings.
pub(crate) struct LawFile {
    pub(super) name: String,
    settings: Entries<serde_json::Value>,
}

impl Serialize for LawFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Entries(settings) = &self.settings;
        if settings.is_empty() {
            return self.name.serialize(serializer);
        }
        let settings: BTreeMap<_, _> = settings.iter().map(|(key, value)| (key, value)).collect();
        serializer.collect_map([(&self.name, settings)])
    }
}

/// The entries of a JSON object, in the order in which the file lists them.
struct Entries<T>(Vec<(String, T)>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(EntriesVisitor(PhantomData))
    }
}

struct EntriesVisitor<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for EntriesVisitor<T> {
    type Value = Entries<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut entries: Vec<(String, T)> = Vec::new();
        while let Some((key, value)) = map.next_entry::<String, T>()? {
            if entries.iter().any(|(other, _)| *other == key) {
                return Err(A::Error::custom(format!("the key `{key}` occurs twice")));
            }
            entries.push((key, value));
        }
        Ok(Entries(entries))
    }
}

struct LawVisitor;

impl<'de> Visitor<'de> for LawVisitor {
    type Value = LawFile;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("the name of a law, or an object {\"name\": {settings}}")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<LawFile, E> {
        Ok(LawFile {
            name: name.to_owned(),
            settings: Entries(Vec::new()),
        })
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<LawFile, A::Error> {
        let Entries(laws) =
            EntriesVisitor::<Entries<serde_json::Value>>(PhantomData).visit_map(map)?;
        let names: Vec<String> = laws.iter().map(|(name, _)| format!("`{name}`")).collect();
        let [(name, settings)] = <[_; 1]>::try_from(laws).map_err(|laws| {
            let found = if laws.is_empty() {
                "none".to_owned()
            } else {
                names.join(" and ")
            };
            let write =
                "write each law as its name, or as a separate object {\"name\": {settings}}";
            A::Error::custom(format!(
                "expected one law in an object, found {found}; {write}"
            ))
        })?;
        Ok(LawFile { name, settings })
    }
}

impl<'de> Deserialize<'de> for LawFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(LawVisitor)
    }
}

impl LawFile {
    /// Makes the JSON form of a law with this name and these settings.
    pub(super) fn new(name: &str, settings: &mut dyn Settings) -> Self {
        let fields = settings.fields().into_iter();
        let settings = fields.map(|field| (field.key.to_owned(), field.value.json()));
        Self {
            name: name.to_owned(),
            settings: Entries(settings.collect()),
        }
    }

    /// Copies the values in this file to the settings of `law`.
    ///
    /// # Errors
    /// A message about an unknown setting or a wrong value.
    pub(super) fn fill(&self, law: &mut dyn Settings) -> Result<(), String> {
        for (key, value) in &self.settings.0 {
            let field = law.fields().into_iter().find(|field| field.key == key);
            let no_field = || format!("the law `{}` has no setting `{key}`", self.name);
            read_json(field.ok_or_else(no_field)?, value)?;
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(unreachable_pub)] // `settings!` makes public structs.
mod tests {
    use autodiff::Real;
    use serde_json::{Value, json};

    use super::LawFile;
    use crate::Registry;
    use crate::laws::{Bar, BarForce, ContactLaw, ForceLaws, Law, on_bars};
    use crate::settings::{Field, SettingValue, Settings, within};

    crate::settings! {
        /// Which way a bar is pulled.
        enum Way {
            /// Together.
            Together = "together",
            /// Apart.
            Apart = "apart",
        }
    }

    crate::settings! {
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
                let _ = super::read_json(field, &value);
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

    #[track_caller]
    fn refused(text: &str, says: &str) {
        let error = forces(text).unwrap_err();
        assert!(error.contains(says), "{text}: {error}");
    }

    #[test]
    fn malformed_laws_are_refused() {
        refused(
            r#"[{"stops": {"at": 0.2}, "damper": {}}]"#,
            "expected one law in an object, found `stops` and `damper`",
        );
        refused("[{}]", "expected one law in an object, found none");
        refused(
            r#"[{"stops": {"at": 0.2, "at": 0.3}}]"#,
            "the key `at` occurs twice",
        );
        refused(
            r#"[{"stops": {}, "stops": {}}]"#,
            "the key `stops` occurs twice",
        );
        refused(
            r#"["stops", {"stops": {"at": 0.2}}]"#,
            "the force `stops` occurs twice",
        );
        refused(
            r#"[{"stops": {"at": null}}]"#,
            "`at` cannot be null; allowed: a number",
        );
        refused(
            r#"[{"stops": {"at": {"a": 1}}}]"#,
            "`at` cannot be {\"a\":1}; allowed",
        );
        refused(r#"[{"stops": null}]"#, "expected an object");
        refused(
            r#"[{"stops": {"height": 1}}]"#,
            "the law `stops` has no setting `height`",
        );
        refused("[3]", "expected the name of a law, or an object");
        refused(r#"["wool"]"#, "unknown force `wool`");
        // Two laws in two objects keep their order.
        let both = r#"[{"stops": {"at": 0.2}}, "damper"]"#;
        let both = forces(both).unwrap();
        let names: Vec<_> = both.laws().map(|law| law.name()).collect();
        assert_eq!(names, ["stops", "damper"]);
        let contact = serde_json::from_str::<LawFile>(r#"{"coulomb": {}, "none": {}}"#);
        assert!(contact.is_err());
    }
}
