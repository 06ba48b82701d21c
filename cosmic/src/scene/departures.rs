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
}

impl Scene {
    /// The keys whose values differ from those of `stability`, in the order in which a scene is written.
    pub fn departures(&self) -> Vec<Departure> {
        let paper = Self::paper().settings().into_iter();
        let mut paper: HashMap<String, String> = paper.map(|s| (s.key, s.value)).collect();
        let departure = |Setting { key, value, .. }| {
            let there = paper.remove(&key);
            (there.as_ref() != Some(&value)).then_some(Departure {
                key,
                here: value,
                there,
            })
        };
        self.settings().into_iter().filter_map(departure).collect()
    }
}
