//! The file of a case: its keys, in the order in which they are written.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::de::value::StringDeserializer;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value, json};

use super::{Case, Frame, version_1};
use crate::design::Material;
use crate::geometry::Row;
use crate::lattice::Truss;
use crate::policy::Weights;
use crate::projection::Projection;
use crate::scene::{JsonSetting, Scene, TrussFile};
use crate::walk::Divergence;

/// The key `format` of the cases that the program writes.
pub(super) const FORMAT: &str = "cosmic-case";
/// The key `version` of the cases that the program writes.
pub(super) const VERSION: u32 = 2;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[expect(
    dead_code,
    reason = "the last fields belong to the format but are not read"
)]
pub(super) struct CaseFile {
    pub(super) format: Option<String>,
    pub(super) version: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<Value>,
    /// The sections of the scene, each with its keys; in version 1 other keys.
    scene: Map<String, Value>,
    pub(super) edges: Vec<[usize; 2]>,
    /// The truss of the scene. Present only in cases with a truss.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) truss: Option<Truss>,
    pub(super) l0: Vec<f64>,
    /// The scale of the lattice, m. A case without this key has the scale of the paper's lattice.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub(super) scale: f64,
    pub(super) x0: Vec<Row>,
    pub(super) v0: Vec<Row>,
    pub(super) z: Vec<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) materials: Option<Vec<Material>>,
    pub(super) controller: Weights,
    pub(super) steps: usize,
    #[serde(deserialize_with = "word")]
    pub(super) projection: Projection,
    pub(super) al: Lagrangian,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) results: Option<Results>,
    // The keys below describe the origin and the tolerances of a case. Nothing is computed from them.
    #[serde(default, skip_serializing)]
    tolerance: IgnoredAny,
    #[serde(default, skip_serializing)]
    sensitivity: IgnoredAny,
    #[serde(default, skip_serializing)]
    coverage: IgnoredAny,
    #[serde(default, skip_serializing)]
    name: IgnoredAny,
}

impl From<&Case> for CaseFile {
    fn from(case: &Case) -> Self {
        let Case { scene, lattice, .. } = case;
        Self {
            format: Some(FORMAT.to_owned()),
            version: Some(VERSION),
            note: None,
            scene: sections(scene.clone()),
            edges: lattice.edges.clone(),
            truss: scene.lattice.file.truss().map(|truss| Truss::clone(truss)),
            l0: lattice.rest_length.clone(),
            scale: lattice.scale,
            x0: lattice.dimension.rows(&case.start.x),
            v0: lattice.dimension.rows(&case.start.v),
            z: case.design.vectors().into_owned(),
            materials: case.design.layout().map(<[_]>::to_vec),
            controller: Weights::from(&case.controller),
            steps: scene.physics.steps,
            projection: case.projection,
            al: Lagrangian {
                lambda: case.lagrangian.multiplier,
                tau: case.lagrangian.penalty,
                thresholds: case.thresholds,
            },
            results: None,
            tolerance: IgnoredAny,
            sensitivity: IgnoredAny,
            coverage: IgnoredAny,
            name: IgnoredAny,
        }
    }
}

impl Case {
    /// The text of a case file that holds all inputs of this case, but no results. The file is always in the world's frame,
    /// even if the [frame](Case::frame) of this case is another.
    pub fn to_json(&self) -> String {
        CaseFile::from(self).text()
    }

    /// The text of a case file that reproduces a divergence: this case, cut after the step that diverges. Its results
    /// are the last states of the rollout. Numbers that are not finite are written as `null`.
    pub fn diverged_json(&self, divergence: &Divergence) -> String {
        let (step, node) = (divergence.step, divergence.node);
        let note = format!(
            "step {step} diverged at node {node}, {}; the last states are in `results`",
            divergence.term
        );
        let last = &divergence.last;
        let states = last.states.iter().map(|state| json!(state));
        let mut file = CaseFile::from(self);
        file.note = Some(note.into());
        file.steps = step + 1;
        file.results = Some(Results {
            trajectory: last.steps.iter().copied().zip(states).collect(),
        });
        file.text()
    }
}

/// The sections of a scene. A truss is in the case, so the scene does not name its file.
fn sections(mut scene: Scene) -> Map<String, Value> {
    if let Some(truss) = scene.lattice.file.truss() {
        scene.lattice.file = TrussFile::new(TrussFile::COPY, Arc::clone(truss));
    }
    match json!(scene) {
        Value::Object(sections) => sections,
        _ => Map::new(),
    }
}

impl CaseFile {
    /// The version of the file, which may be omitted if it is 1.
    pub(super) fn version(&self) -> u32 {
        self.version.unwrap_or(1)
    }

    /// The settings of the scene, and the frame of the file.
    ///
    /// # Errors
    /// A sentence about a value of the wrong form; in version 1 also about an unknown or missing key.
    pub(super) fn settings(&self) -> Result<(Vec<JsonSetting>, Frame), String> {
        if self.version() == 1 {
            return version_1::converted(&self.scene);
        }
        let mut given = Vec::new();
        for (section, keys) in &self.scene {
            let Value::Object(keys) = keys else {
                return Err(format!(
                    "`scene.{section}`: expected a section of the scene, found {keys}"
                ));
            };
            given.extend(keys.iter().map(|(key, value)| JsonSetting {
                key: format!("{section}.{key}"),
                place: format!("scene.{section}.{key}"),
                value: value.clone(),
            }));
        }
        Ok((given, Frame::default()))
    }

    fn text(&self) -> String {
        serde_json::to_string(self).expect("numbers with string keys can be written as JSON")
    }
}

/// Reads a string that must be one of a few words. It is read as a string first, because the JSON parser's error for
/// any other type would only say that it expected a value.
fn word<'de, T: DeserializeOwned, D: Deserializer<'de>>(given: D) -> Result<T, D::Error> {
    T::deserialize(StringDeserializer::new(String::deserialize(given)?))
}

fn one() -> f64 {
    1.0
}

fn is_one(scale: &f64) -> bool {
    *scale == one()
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Lagrangian {
    pub(super) lambda: [f64; 4],
    pub(super) tau: [f64; 4],
    pub(super) thresholds: [f64; 4],
}

/// The results in a case file. Only the step numbers of the recorded states are read.
#[derive(Deserialize, Serialize)]
pub(super) struct Results {
    #[serde(default, deserialize_with = "steps_only")]
    pub(super) trajectory: BTreeMap<usize, Value>,
}

/// Reads the numbers of steps without keeping the states, which may be long.
fn steps_only<'de, D: Deserializer<'de>>(given: D) -> Result<BTreeMap<usize, Value>, D::Error> {
    let states = BTreeMap::<usize, IgnoredAny>::deserialize(given)?;
    Ok(states.into_keys().map(|step| (step, Value::Null)).collect())
}
