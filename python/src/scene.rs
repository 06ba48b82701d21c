//! The class `Scene`.

use crate::arrays::Sizes;
use crate::errors::{InputError, caught, raised};
use cosmic::Registry;
use cosmic::lattice::{Lattice, Truss};
use cosmic::record::RunPlan;
use cosmic::record::snapshot::SavedScene;
use cosmic::scene::{self, TrussFile};
use pyo3::prelude::*;
use pyo3::types::PyIterator;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
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

    /// Returns a copy of this scene, changed by the settings in a TOML text. If a checked truss is given, the name
    /// `truss.json` in the text stands for it.
    #[pyo3(signature = (text, truss = None))]
    fn overridden(&self, text: &str, truss: Option<&str>) -> PyResult<Self> {
        let mut registry = Registry::default();
        if let Some(truss) = truss {
            let truss = serde_json::from_str(truss).map_err(unreadable)?;
            registry = registry.with_lattice(TrussFile::COPY, truss);
        }
        let changed = || {
            let scene = self.scene.clone().knowing(&registry);
            let scene = scene.with("overrides", text).map_err(raised)?;
            // The name stands for the truss only in this text.
            Ok(scene.knowing(&Registry::default()))
        };
        Ok(Self {
            scene: caught(changed)?,
            name: self.name.clone(),
        })
    }

    /// The truss of the lattice as the text of a truss file, in the library's node numbers; `None` for a generated
    /// lattice.
    #[getter]
    fn truss(&self) -> PyResult<Option<String>> {
        caught(|| Ok(self.scene.lattice.file.truss().map(|truss| truss.to_json())))
    }

    /// Returns the value of a setting, such as `physics.gravity`, as a scene file states it. A truss is a `cosmic.Lattice`.
    fn __getitem__<'py>(this: &Bound<'py, Self>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let (py, scene) = (this.py(), &this.get().scene);
        if key == "lattice.file" && scene.lattice.file.truss().is_some() {
            let lattice = py.import("cosmic._lattice")?.getattr("Lattice")?;
            return lattice.call_method1("of", (this,));
        }
        let value = caught(|| scene.value(key).map_err(raised))?;
        let json = py.import("json")?;
        json.call_method1("loads", (value.to_string(),))
    }

    /// Returns the keys of all settings.
    fn keys(&self) -> Vec<String> {
        let settings = self.scene.settings().into_iter();
        settings.map(|setting| setting.key).collect()
    }

    /// Iterates over the keys of all settings.
    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.keys().into_pyobject(py)?.try_iter()
    }

    /// Returns whether two scenes have equal settings and lattices. Their names may differ.
    fn __eq__(&self, other: &Self) -> bool {
        self.scene == other.scene
    }

    /// Hashes the settings. Equal scenes may name their trusses differently, and may have zeros of different signs.
    fn __hash__(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        for setting in self.scene.settings() {
            if setting.key != "lattice.file" {
                setting.value.replace("-0.0", "0.0").hash(&mut hasher);
            }
        }
        hasher.finish()
    }

    /// Returns the complete scene as TOML.
    fn to_toml(&self) -> String {
        self.scene.to_toml()
    }

    /// Returns this scene, which cannot change.
    fn __copy__(this: Py<Self>) -> Py<Self> {
        this
    }

    /// Returns this scene, which cannot change.
    fn __deepcopy__(this: Py<Self>, _memo: Bound<PyAny>) -> Py<Self> {
        this
    }

    /// Returns the scene as text, including the nodes and edges of a custom lattice. `pickle` calls this method.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        let mut plan = RunPlan::new(&self.name, self.scene.clone(), 0).saved();
        // In this text, values that follow from others are still "auto".
        plan.scene.text = self.scene.to_toml();
        let text = serde_json::to_string(&plan).map_err(unreadable)?;
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
        let (lattice, steps) = (&self.scene.lattice, self.scene.physics.steps);
        let size = match lattice.file.truss() {
            Some(truss) => format!("{} nodes, {} edges", truss.nodes.len(), truss.edges.len()),
            None => format!("{} x {} cells", lattice.columns, lattice.rows),
        };
        format!("<Scene {}: {size}, {steps} steps>", self.name)
    }
}

/// Checks the text of a truss file. Returns it in the library's node numbers.
#[pyfunction]
pub(crate) fn truss(text: &str) -> PyResult<String> {
    let read = || serde_json::from_str(text).map_err(unreadable);
    caught(|| read().map(|truss: Truss| truss.to_json()))
}

fn unreadable(error: serde_json::Error) -> PyErr {
    InputError::new_err(error.to_string())
}

/// Returns the names of the built-in scenes, the default first.
#[pyfunction]
pub(crate) fn scenes() -> Vec<&'static str> {
    scene::BUILTIN.map(|scene| scene.name).to_vec()
}
