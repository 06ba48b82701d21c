//! The class `Scene`.

use crate::errors::{caught, raised, refused};
use cosmic::Registry;
use cosmic::record::RunPlan;
use cosmic::record::snapshot::SavedScene;
use cosmic::scene;
use pyo3::prelude::*;
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
            Some(text) => scene::Scene::load(text),
            None => scene::Scene::read(&source),
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
        let text =
            serde_json::to_string(&plan.saved()).map_err(|error| refused(error.to_string()))?;
        Ok((py.get_type::<Self>().getattr("restore")?, (text,)))
    }

    /// Reads the text that `__reduce__` made.
    #[staticmethod]
    fn restore(text: &str) -> PyResult<Self> {
        let plan: RunPlan<SavedScene> =
            serde_json::from_str(text).map_err(|error| refused(error.to_string()))?;
        let plan = plan.read(&Registry::default()).map_err(raised)?;
        Ok(Self {
            scene: plan.scene,
            name: plan.name,
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

/// Returns the names of the built-in scenes, the default first.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    scene::BUILTIN.map(|scene| scene.name).to_vec()
}
