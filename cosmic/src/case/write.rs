//! Writes a case as a file.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::Serialize;

use super::Case;
use super::raw::{FORMAT, RawLagrangian, RawMarks, RawScene, VERSION};
use crate::design::Material;
use crate::geometry::Vector;
use crate::lattice::State;
use crate::policy::Weights;
use crate::projection::Projection;
use crate::scene::{ObjectiveSettings, Scene};
use crate::simulator::Divergence;

/// The keys of a case file, in the order in which they are written. [`Case::parse`] reads them back.
#[derive(Serialize)]
struct File<'a> {
    format: &'static str,
    version: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
    scene: RawScene,
    edges: &'a [[usize; 2]],
    #[serde(skip_serializing_if = "Option::is_none")]
    truss: Option<RawMarks>,
    l0: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    scale: Option<f64>,
    x0: &'a [Vector<f64>],
    v0: &'a [Vector<f64>],
    z: Cow<'a, [[f64; 3]]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    materials: Option<&'a [Material]>,
    controller: Weights,
    steps: usize,
    projection: Projection,
    al: RawLagrangian,
    #[serde(skip_serializing_if = "Option::is_none")]
    results: Option<LastStates<'a>>,
}

#[derive(Serialize)]
struct LastStates<'a> {
    trajectory: BTreeMap<usize, &'a State<f64>>,
}

impl Case {
    /// The text of a case file that holds all inputs of this case, but no results.
    pub fn to_json(&self) -> String {
        json(&self.file())
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
        let trajectory = last.steps.iter().copied().zip(&last.states).collect();
        json(&File {
            note: Some(note),
            steps: step + 1,
            results: Some(LastStates { trajectory }),
            ..self.file()
        })
    }

    fn file(&self) -> File<'_> {
        File {
            format: FORMAT,
            version: VERSION,
            note: None,
            scene: RawScene::of(&self.scene()),
            edges: &self.lattice.edges,
            truss: RawMarks::of(&self.layout, &self.lattice),
            l0: &self.lattice.rest_length,
            scale: Some(self.lattice.scale).filter(|scale| *scale != 1.0),
            x0: &self.start.x,
            v0: &self.start.v,
            z: self.design.vectors(),
            materials: self.design.layout(),
            controller: Weights::from(&self.controller),
            steps: self.physics.steps,
            projection: self.projection,
            al: RawLagrangian {
                lambda: self.lagrangian.multiplier.to_vec(),
                tau: self.lagrangian.penalty.to_vec(),
                thresholds: self.thresholds.to_vec(),
            },
            results: None,
        }
    }

    /// The paper's scene, changed by the settings of this case.
    fn scene(&self) -> Scene {
        Scene {
            lattice: self.layout.clone(),
            physics: self.physics.clone(),
            materials: self.materials.clone(),
            projection: self.sharpness.clone(),
            design: self.rules.clone(),
            controller: self.observation.clone(),
            objective: ObjectiveSettings {
                body: self.moved,
                ..ObjectiveSettings::default()
            },
            ..Scene::paper()
        }
    }
}

fn json(file: &File) -> String {
    serde_json::to_string(file).expect("numbers with string keys can be written as JSON")
}
