//! The JSON form of laws in case files.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use serde::de::{self, Error as _, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::settings::{Settings, read_json};

/// A law in JSON. It is either its name, or an object that maps its name to its settings.
pub struct LawFile {
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
    pub fn new(name: &str, settings: &mut dyn Settings) -> Self {
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
