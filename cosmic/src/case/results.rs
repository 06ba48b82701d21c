//! The results of a case, with the keys and array shapes of a case file.

use std::collections::BTreeMap;

use serde::Serialize;
use serde_json::Value;

use crate::geometry::Row;
use crate::lattice::State;
use crate::policy::Weights;
use crate::walk::{Divergence, Energy, Loads};

/// The results of a case. Gradients are present only if they were requested. The two entries whose names end in
/// `_performance_constraints` are present only if the case has the stability projection.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CaseResults {
    /// The mixture of each edge.
    pub z_projected: Vec<[f64; 3]>,
    /// The mass of each node, in kg.
    pub node_mass: Vec<f64>,
    /// The activation of each edge in step 0.
    pub u0: Vec<f64>,
    /// The recorded states in the [frame](super::Frame) of the case's file. The key of a state is the number of steps done before it.
    pub trajectory: BTreeMap<usize, State<f64>>,
    /// The loss, in metres: minus the final position of the payload along the ground, `-(s . x_0(T))`.
    pub l_disp: f64,
    /// How far the payload got along the ground, in metres: `s . x_0(T) - s . x_0(0)`.
    pub displacement: f64,
    /// The share of solid material in the mixtures, as a mean over the edges.
    #[serde(rename = "V")]
    pub volume: f64,
    /// The share of actuators in the mixtures, as a mean over the edges.
    #[serde(rename = "V_act")]
    pub actuator_volume: f64,
    /// The binarisation measure of the mixtures.
    pub g_bin: f64,
    /// The overlap measures of the pairs of materials (0,1), (0,2) and (1,2).
    pub g_ortho: [f64; 3],
    /// The loads of a layout; `None` for an undecided design and for a rollout that diverges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loads: Option<Loads>,
    /// The energy that a layout needs; `None` if `loads` is `None`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy: Option<Energy>,
    /// The derivatives of `l_disp` with respect to all inputs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grad_l_disp: Option<Gradient>,
    /// The augmented objective: `l_disp` plus the terms of the augmented Lagrangian. The terms are computed from the
    /// mixtures `z_projected`.
    pub augmented: f64,
    /// The derivative of `augmented` with respect to the design vectors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grad_augmented: Option<DesignGradient>,
    /// The augmented objective, with terms that are computed from the mixtures of the performance projection.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub augmented_performance_constraints: Option<f64>,
    /// The derivative of `augmented_performance_constraints` with respect to the design vectors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grad_augmented_performance_constraints: Option<DesignGradient>,
    /// The first state that diverged; `None` if the rollout does not diverge. It is not written to the file.
    #[serde(skip)]
    pub divergence: Option<Divergence>,
}

/// The derivative of one number, such as a loss, with respect to all inputs of a rollout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gradient {
    /// The derivative with respect to the design vectors.
    pub z: Vec<[f64; 3]>,
    /// The derivative with respect to the controller's weights.
    #[serde(flatten)]
    pub weights: Weights,
    /// The derivative with respect to the initial positions. Rest lengths and masses count as constants.
    pub x0: Vec<Row>,
    /// The derivative with respect to the initial velocities.
    pub v0: Vec<Row>,
}

/// The derivative of one number, such as a loss, with respect to the design vectors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DesignGradient {
    /// The derivatives with respect to the three entries of each edge's design vector.
    pub z: Vec<[f64; 3]>,
}

impl CaseResults {
    /// The JSON text `{"results": {...}}`, whose numbers read back to the same bits. A number that is not finite
    /// becomes `null`; [`not_finite`](CaseResults::not_finite) names it.
    pub fn to_json(&self) -> String {
        let results = serde_json::to_string(self);
        let results = results.expect("numbers with string keys can be written as JSON");
        format!("{{\"results\":{results}}}")
    }

    /// The keys, such as `trajectory.128.x`, under which a number is not finite.
    pub fn not_finite(&self) -> Vec<String> {
        // Loads and energy are those of rollouts that do not diverge. A `null` in them is a number that does not exist.
        let measured = Self {
            loads: None,
            energy: None,
            ..self.clone()
        };
        let value = serde_json::to_value(measured)
            .expect("numbers with string keys can be written as JSON");
        let mut names = Vec::new();
        collect_nulls(&value, "", &mut names);
        names.dedup();
        names
    }
}

/// Appends to `names` the key of every null in `value`, whose own key is `key`. An entry of a list has the key of the
/// list.
fn collect_nulls(value: &Value, key: &str, names: &mut Vec<String>) {
    match value {
        Value::Null => names.push(key.to_owned()),
        Value::Array(list) => list.iter().for_each(|item| collect_nulls(item, key, names)),
        Value::Object(map) => {
            for (name, item) in map {
                let dot = if key.is_empty() { "" } else { "." };
                collect_nulls(item, &format!("{key}{dot}{name}"), names);
            }
        }
        Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}
