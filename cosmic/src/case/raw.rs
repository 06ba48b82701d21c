//! The keys of a case file, before any shape is checked: that of arrays too, as a length that does
//! not fit is told with the one that does.

use std::collections::BTreeMap;

use serde::de::value::StringDeserializer;
use serde::de::{DeserializeOwned, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize};

use crate::controller::Weights;
use crate::design::Material;
use crate::laws::ContactLaw;
use crate::projection::Projection;
use crate::scene::{Integrator, VoidEdges};

/// `FORMAT` and `VERSION` at the head of the cases that the program writes itself.
pub(super) const FORMAT: &str = "cosmic-case";
/// As [`FORMAT`].
pub(super) const VERSION: u32 = 1;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawCase {
    pub(super) format: Option<String>,
    pub(super) version: Option<u32>,
    pub(super) scene: RawScene,
    pub(super) edges: Vec<Vec<usize>>,
    pub(super) l0: Vec<f64>,
    pub(super) x0: Vec<Vec<f64>>,
    pub(super) v0: Vec<Vec<f64>>,
    pub(super) z: Vec<Vec<f64>>,
    pub(super) materials: Option<Vec<Material>>,
    pub(super) controller: Weights,
    pub(super) steps: usize,
    #[serde(deserialize_with = "word")]
    pub(super) projection: Projection,
    pub(super) al: RawLagrangian,
    pub(super) results: Option<RawResults>,
    // The fields below say how a case was made and how well it must be met. Nothing is computed from them.
    #[serde(rename = "tolerance")]
    _tolerance: Option<IgnoredAny>,
    #[serde(rename = "sensitivity")]
    _sensitivity: Option<IgnoredAny>,
    #[serde(rename = "coverage")]
    _coverage: Option<IgnoredAny>,
    #[serde(rename = "name")]
    _name: Option<IgnoredAny>,
    #[serde(rename = "note")]
    _note: Option<IgnoredAny>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawScene {
    pub(super) columns: usize,
    pub(super) rows: usize,
    pub(super) spacing: f64,
    pub(super) origin_x: f64,
    pub(super) drop: f64,
    pub(super) ground_height: f64,
    pub(super) alpha_deg: f64,
    pub(super) gravity: f64,
    pub(super) gamma: f64,
    pub(super) m_eps: f64,
    pub(super) payload_mass: f64,
    pub(super) dt: f64,
    // Written only where it is not the paper's: such a case is read by any program of the format.
    #[serde(default, deserialize_with = "word")]
    #[serde(skip_serializing_if = "is_default")]
    pub(super) integrator: Integrator,
    #[serde(default = "single", skip_serializing_if = "is_single")]
    pub(super) substeps: usize,
    #[serde(deserialize_with = "word")]
    pub(super) contact: ContactLaw,
    pub(super) mu: f64,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) stiffening: f64,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) bending_radius: f64,
    /// The chosen laws that the format has no keys for, as sections of a scene.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(super) laws: String,
    #[serde(default, deserialize_with = "word")]
    #[serde(skip_serializing_if = "is_default")]
    pub(super) void_edges: VoidEdges,
    pub(super) omega: f64,
    pub(super) n_cpg: usize,
    pub(super) goal: Vec<f64>,
    #[serde(default = "one")]
    pub(super) goal_scale: f64,
    #[serde(default)]
    pub(super) goal_relative: bool,
    pub(super) offset_scale: f64,
    pub(super) velocity_scale: f64,
    pub(super) beta: f64,
    pub(super) beta_stab: f64,
    pub(super) beta_ste: f64,
    pub(super) delta: f64,
    #[serde(default = "single", skip_serializing_if = "is_single")]
    pub(super) penalisation: usize,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) hold_materials: f64,
    pub(super) library: RawLibrary,
}

/// One of a few words. Taken as a text first: of what is none, the parser of JSON itself would say
/// no more than that it expected a value.
fn word<'de, T: DeserializeOwned, D: Deserializer<'de>>(given: D) -> Result<T, D::Error> {
    T::deserialize(StringDeserializer::new(String::deserialize(given)?))
}

fn one() -> f64 {
    1.0
}

fn single() -> usize {
    1
}

fn is_single(option: &usize) -> bool {
    *option == 1
}

/// Options beyond the format's first version are written where they are used.
fn is_default<T: Default + PartialEq>(option: &T) -> bool {
    *option == T::default()
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLibrary {
    pub(super) k: Vec<f64>,
    pub(super) rho: Vec<f64>,
    pub(super) a_max: Vec<f64>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLagrangian {
    pub(super) lambda: Vec<f64>,
    pub(super) tau: Vec<f64>,
    pub(super) thresholds: Vec<f64>,
}

/// The results; only the numbers of the recorded steps are read.
#[derive(Deserialize)]
pub(super) struct RawResults {
    #[serde(default)]
    pub(super) trajectory: BTreeMap<usize, IgnoredAny>,
}
