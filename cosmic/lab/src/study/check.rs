//! The measurements of a study's runs, each a file in the run's folder.

use crate::export::{Walks, check_python};
use crate::sweep::PlannedStudy;
use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::design::VolumeBounds;
use cosmic::error::Result;
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::{DesignFile, Summary, run};
use cosmic::scene::Scene;
use serde::{Deserialize, Serialize};
use std::path::Path;

const FORMAT: Format = Format::new("cosmic-check", 1);

/// The name of the check in a run's folder.
const CHECK: &str = "check.json";

impl PlannedStudy {
    /// Checks that this machine can measure.
    ///
    /// # Errors
    /// [`Error::Usage`](cosmic::Error::Usage) if robots walk in MuJoCo and the Python lacks it.
    pub fn check(&self) -> Result<()> {
        let mut python = self.python.iter();
        python.try_for_each(|python| check_python(python.as_ref()))
    }

    /// Measures a run that is done and writes the files of the measurements, except those that exist. Returns
    /// `None` if it was stopped.
    ///
    /// # Errors
    /// The errors of reading and writing the run's files; [`Error::Usage`](cosmic::Error::Usage) if Python fails.
    pub fn measure(&self, folder: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Option<()>> {
        let path = folder.join(CHECK);
        if !path.exists() {
            write_json(&path, FORMAT, &Check::measure(folder)?)?;
        }
        match &self.python {
            None => Ok(Some(())),
            Some(python) => Walks::keep(folder, &self.frictions, python.as_ref(), is_stopped),
        }
    }
}

/// Displacements of a delivered design in changed scenes, from the perturbed starts of the summary. In
/// metres along the ground; `None` if a rollout diverged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Check {
    /// At half the time step, with twice the steps: 10 % quantile, median, 90 % quantile.
    pub(super) half_step: [Option<f64>; 3],
    /// With the goal mirrored behind the origin: the median.
    pub(super) goal_behind: Option<f64>,
    /// True if every edge has exactly one material.
    pub(super) one_hot: bool,
    /// True if the volumes are within the widened bounds.
    pub(super) within_bounds: bool,
}

impl Check {
    /// The check of a run.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub(super) fn read(folder: &Path) -> Result<Self> {
        read_json(&folder.join(CHECK), FORMAT)
    }

    fn measure(folder: &Path) -> Result<Self> {
        let (summary, scene) = (Summary::read(folder)?, run::read_scene(folder)?);
        let path = folder.join(run::DESIGN);
        let design = DesignFile::read(&path)?;
        let case = design.case(&scene, &path.display().to_string())?;
        let judged = |scene: &Scene| -> Result<[Option<f64>; 3]> {
            let codesign = CoDesign::new(scene)?;
            let Quantiles { p10, p50, p90 } =
                codesign.judge(&case.own_mixture(), &case.controller, summary.seed);
            Ok([p10, p50, p90].map(|x| x.is_finite().then_some(x)))
        };
        let (mut half, mut behind) = (scene.clone(), scene.clone());
        half.physics.dt *= 0.5;
        half.physics.steps *= 2;
        behind.controller = scene.controller.turned_back();
        let bounds = VolumeBounds::widened(&scene.volume, scene.volume.widening);
        // A mean of a hundred shares is rounded at 1e-16.
        let is_within =
            |x: f64, [least, most]: [f64; 2]| (least - 1e-12..=most + 1e-12).contains(&x);
        Ok(Self {
            half_step: judged(&half)?,
            goal_behind: judged(&behind)?[1],
            one_hot: design.is_snapped(),
            within_bounds: is_within(summary.volume, bounds.solid)
                && is_within(summary.actuator_volume, bounds.actuator),
        })
    }
}
