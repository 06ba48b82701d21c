//! `transfer.json`: the displacement of a finished run's robot in MuJoCo, on ground of several frictions.

use crate::child;
use crate::export::mujoco::{self, MujocoSettings};
use cosmic::Registry;
use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::error::{Error, Result, in_shell};
use cosmic::laws::ContactLaw;
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::{DesignFile, Summary, run};
use cosmic::scene::{Integrator, SelectionSettings};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::Command;

const FORMAT: Format = Format::new("cosmic-transfer", 1);

/// The name of the file in a run's folder.
const TRANSFER: &str = "transfer.json";
/// The name of the folder with the model for MuJoCo, beside the file.
const MODEL: &str = "export";

/// The displacements of a delivered design in MuJoCo, and its displacements in this simulator for comparison. A
/// displacement is in metres along the ground, and `None` if the rollout diverged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Walks {
    /// The version of MuJoCo.
    pub mujoco: String,
    /// The coefficients of friction.
    pub frictions: Vec<f64>,
    /// For each friction, the displacements in MuJoCo, one for each perturbed start.
    pub walks: Vec<Vec<Option<f64>>>,
    /// For each friction, the median displacement in this simulator with the contact law `coulomb`, over as many
    /// rollouts as in MuJoCo.
    pub own: Vec<Option<f64>>,
}

/// The output of `walks.py`.
#[derive(Deserialize)]
struct Printed {
    mujoco: String,
    walks: Vec<Vec<Option<f64>>>,
}

impl Walks {
    /// Measures the walks of a finished run and writes `transfer.json`. Does nothing if the file already exists and has
    /// these frictions. Returns `None` if the measurement was stopped.
    ///
    /// # Errors
    /// The errors of reading the run's files, of [`mujoco::write`] and of [`write_json`]; [`Error::Usage`] if Python
    /// fails.
    pub(crate) fn keep(
        folder: &Path,
        frictions: &[f64],
        python: &Path,
        registry: &Registry,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<()>> {
        if Self::read(folder)?.is_some_and(|known| known.frictions == frictions) {
            return Ok(Some(()));
        }
        let Some(found) = Self::measure(folder, frictions, python, registry, is_stopped)? else {
            return Ok(None);
        };
        write_json(&folder.join(TRANSFER), FORMAT, &found).map(Some)
    }

    /// Reads the displacements of a run's robot in MuJoCo; `None` if they were not measured.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub(crate) fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(TRANSFER);
        path.exists().then(|| read_json(&path, FORMAT)).transpose()
    }

    fn measure(
        folder: &Path,
        frictions: &[f64],
        python: &Path,
        registry: &Registry,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<Self>> {
        let summary = Summary::read(folder)?;
        let scene = run::read_scene(folder, registry)?;
        let path = folder.join(run::DESIGN);
        let case = DesignFile::read(&path)?.case(&scene, &path.display().to_string())?;
        let model = folder.join(MODEL);
        let settings = MujocoSettings {
            rigid: case.physics.integrator == Integrator::Implicit,
            ..MujocoSettings::default()
        };
        mujoco::write(&case, &settings, &model)?;
        let mut arguments = vec![
            model.display().to_string(),
            SelectionSettings::PERTURBED_ROLLOUTS.to_string(),
            (scene.selection.perturbation * case.lattice.scale).to_string(),
            summary.seed.to_string(),
        ];
        arguments.extend(frictions.iter().map(f64::to_string));
        let program = include_str!("walks.py");
        let Some(printed) = output_of(python, program, &arguments, is_stopped)? else {
            return Ok(None);
        };
        let printed: Printed = serde_json::from_slice(&printed).map_err(|error| {
            let python = in_shell(python);
            Error::Usage(format!(
                "{python}: the script that simulates the walks wrote malformed output: {error}"
            ))
        })?;
        let design = case.own_design();
        let own = frictions.iter().map(|friction| {
            let mut scene = scene.clone();
            (scene.physics.contact, scene.physics.friction) = (ContactLaw::coulomb(), *friction);
            let judged =
                CoDesign::new(&scene)?
                    .evaluator()
                    .judge(&design, &case.controller, summary.seed);
            Ok(Some(judged.p50).filter(|x| x.is_finite()))
        });
        Ok(Some(Self {
            mujoco: printed.mujoco,
            frictions: frictions.to_vec(),
            walks: printed.walks,
            own: own.collect::<Result<_>>()?,
        }))
    }

    /// The median displacement in MuJoCo at the `k`-th friction.
    pub fn there(&self, k: usize) -> Option<f64> {
        let walks = self.walks.get(k)?.iter();
        let walks: Vec<f64> = walks.map(|walk| walk.unwrap_or(f64::NAN)).collect();
        let median = (!walks.is_empty()).then(|| Quantiles::of(&walks).p50);
        median.filter(|x| x.is_finite())
    }

    /// The median displacement in this simulator at the `k`-th friction.
    pub fn own(&self, k: usize) -> Option<f64> {
        *self.own.get(k)?
    }
}

/// Checks that the Python interpreter `python` has the package MuJoCo.
///
/// # Errors
/// [`Error::Usage`], whose message tells how to install the package.
pub(crate) fn check_python(python: &Path) -> Result<()> {
    let found = output_of(python, "import mujoco, numpy", &[], &|| false);
    found.map(drop).map_err(|error| {
        Error::Usage(format!(
            "{error}; install MuJoCo with: python3 -m venv mujoco && mujoco/bin/pip install mujoco numpy; then \
             use that Python: --python mujoco/bin/python"
        ))
    })
}

/// Runs a Python program and returns its standard output; `None` if it was stopped.
fn output_of(
    python: &Path,
    program: &str,
    arguments: &[String],
    is_stopped: &dyn Fn() -> bool,
) -> Result<Option<Vec<u8>>> {
    let mut command = Command::new(python);
    command.args(["-B", "-c", program]).args(arguments);
    // Many of these programs run in parallel, so each gets one thread. `-B` stops Python from writing compiled files.
    command.envs(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"].map(|name| (name, "1")));
    let output = child::output(&mut command, is_stopped);
    output.map_err(|says| Error::Usage(format!("{}: {says}", in_shell(python))))
}
