//! The class `Scene`.

use crate::arrays::Sizes;
use crate::errors::{InputError, caught, raised};
use cosmic::Registry;
use cosmic::lattice::Lattice;
use cosmic::record::RunPlan;
use cosmic::record::snapshot::SavedScene;
use cosmic::scene;
use pyo3::prelude::*;
use std::collections::HashMap;
use std::path::PathBuf;

/// A complete experiment: lattice, physics, schedule and every other setting.
#[pyclass(frozen, module = "cosmic._core")]
pub(crate) struct Scene {
    pub(crate) scene: scene::Scene,
    /// The name of the scene in summaries.
    #[pyo3(get)]
    pub(crate) name: String,
}

#[pymethods]
impl Scene {
    /// Loads a built-in scene by its name, or a scene file.
    #[staticmethod]
    fn load(source: PathBuf) -> PyResult<Self> {
        let stem = source.file_stem().unwrap_or(source.as_os_str());
        let name = stem.to_string_lossy().into_owned();
        // A path that is not UTF-8 cannot be the name of a built-in scene.
        let read = || match source.to_str() {
            Some(text) => Registry::default().load(text),
            None => Registry::default().read(&source),
        };
        let scene = caught(|| read().map_err(raised))?;
        Ok(Self { scene, name })
    }

    /// Parses a scene from TOML. Missing keys come from its `base`, by default the scene `earth`.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Self> {
        let scene = caught(|| scene::Scene::parse("scene", text).map_err(raised))?;
        let name = "scene".to_owned();
        Ok(Self { scene, name })
    }

    /// Returns a copy of this scene, changed by the settings in a TOML text.
    fn overridden(&self, text: &str) -> PyResult<Self> {
        Ok(Self {
            scene: caught(|| self.scene.with("overrides", text).map_err(raised))?,
            name: self.name.clone(),
        })
    }

    /// Returns the complete scene as TOML.
    fn to_toml(&self) -> String {
        self.scene.to_toml()
    }

    /// Returns the scene as text, including the nodes and edges of a custom lattice. `pickle` and `copy` call this
    /// method.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let plan = RunPlan::new(&self.name, self.scene.clone(), 0);
        let text = serde_json::to_string(&plan.saved()).map_err(unreadable)?;
        Ok((py.get_type::<Self>().getattr("restore")?, (text,)))
    }

    /// Reads the text that `__reduce__` made.
    #[staticmethod]
    fn restore(text: &str) -> PyResult<Self> {
        let plan: RunPlan<SavedScene> = serde_json::from_str(text).map_err(unreadable)?;
        let plan = plan.read(&Registry::default()).map_err(raised)?;
        Ok(Self {
            scene: plan.scene,
            name: plan.name,
        })
    }

    /// The sizes that determine how much memory an optimisation or a rollout needs.
    #[getter]
    fn sizes(&self) -> PyResult<HashMap<&'static str, f64>> {
        caught(|| {
            let scene = &self.scene;
            let sizes = Sizes::of(
                &Lattice::new(&scene.lattice, &scene.physics),
                &scene.controller,
            );
            let shapes = sizes.shapes().into_iter();
            let numbers = shapes.map(|(_, shape)| shape.iter().map(|&n| n as f64).product::<f64>());
            let horizon = scene.schedule.horizon.into_iter().max();
            Ok(HashMap::from([
                ("nodes", sizes.nodes as f64),
                ("edges", sizes.edges as f64),
                ("hidden", scene.controller.hidden as f64),
                ("numbers", numbers.sum()),
                ("steps", scene.physics.steps as f64),
                ("horizon", horizon.unwrap_or(0) as f64),
                (
                    "budget",
                    scene.gradient.memory.unwrap_or(f64::INFINITY) * 1e6,
                ),
            ]))
        })
    }

    fn __repr__(&self) -> String {
        let lattice = &self.scene.lattice;
        let steps = self.scene.physics.steps;
        format!(
            "<Scene {}: {} x {} cells, {steps} steps>",
            self.name, lattice.columns, lattice.rows
        )
    }
}

fn unreadable(error: serde_json::Error) -> PyErr {
    InputError::new_err(error.to_string())
}

/// Returns the names of the built-in scenes, the default first.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    scene::BUILTIN.map(|scene| scene.name).to_vec()
}
