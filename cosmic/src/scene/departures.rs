//! The departures of a scene from the paper: the keys whose values differ from those of `stability`.

use std::collections::HashMap;

use serde::Serialize;

use super::Scene;
use super::keys::Setting;

/// A key of a scene whose value differs from that of `stability`, the paper's scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Departure {
    /// The key, as `section.key`.
    pub key: String,
    /// The value in the scene, as TOML.
    pub here: String,
    /// The value in `stability`, as TOML. `None` for a setting of a law that `stability` does not choose.
    pub there: Option<String>,
    /// The unit of its numbers; empty for numbers without a unit and for other values.
    #[serde(skip)]
    pub unit: &'static str,
}

impl Scene {
    /// The keys whose values differ from those of `stability`, in the order in which a scene is written.
    pub fn departures(&self) -> Vec<Departure> {
        let paper = Self::paper().settings().into_iter();
        let mut paper: HashMap<String, String> = paper.map(|s| (s.key, s.value)).collect();
        let departure = |Setting {
                             key, value, unit, ..
                         }| {
            let there = paper.remove(&key);
            (there.as_ref() != Some(&value)).then_some(Departure {
                key,
                here: value,
                there,
                unit,
            })
        };
        self.settings().into_iter().filter_map(departure).collect()
    }

    /// The [departures](Self::departures) in the section `physics` whose keys are not among `known`. A description of the
    /// scene that knows only these keys, such as a model for another simulator, must refuse or name the others.
    pub fn physics_beyond(&self, known: &[&str]) -> Vec<Departure> {
        let mut beyond = self.departures();
        beyond.retain(|departure| {
            let key = departure.key.strip_prefix("physics.");
            key.is_some_and(|key| !known.contains(&key))
        });
        beyond
    }
}
