//! `check.json`: what a study measures of a finished run in addition to its summary.

use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::design::VolumeBounds;
use cosmic::error::Result;
use cosmic::geometry::Range;
use cosmic::projection::{Projection, one_hot};
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::{DesignFile, Summary, run};
use cosmic::scene::Scene;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The format of a check.
const FORMAT: Format = Format {
    name: "cosmic-check",
    version: 1,
};

/// The name of the check in a run's folder.
const CHECK: &str = "check.json";

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
    /// Measures the design of a finished run.
    ///
    /// # Errors
    /// The errors of reading the run's files.
    pub(super) fn measure(folder: &Path) -> Result<Self> {
        let summary = Summary::read(folder)?;
        let scene = run::read_scene(folder)?;
        let path = folder.join(run::DESIGN);
        let design = DesignFile::read(&path)?;
        let controller = design.robot(&scene, &path.display().to_string())?;
        let judged = |scene: &Scene| -> Result<Quantiles> {
            let codesign = CoDesign::new(scene)?;
            let mixture = if design.is_snapped() {
                one_hot(&design.materials)
            } else {
                codesign.task().mixture(Projection::Performance, &design.z)
            };
            Ok(codesign.judge(&mixture, &controller, summary.seed))
        };
        let finite = |x: f64| x.is_finite().then_some(x);
        let mut behind = scene.clone();
        behind.controller = scene.controller.turned_back();
        let Quantiles { p10, p50, p90 } = judged(&with_half_steps(&scene))?;
        Ok(Self {
            half_step: [p10, p50, p90].map(finite),
            goal_behind: finite(judged(&behind)?.p50),
            one_hot: design.is_snapped(),
            within_bounds: is_within(&scene, [summary.volume, summary.actuator_volume]),
        })
    }

    /// Measures a finished run and writes its check, unless it has one.
    ///
    /// # Errors
    /// As [`measure`](Self::measure) and [`write_json`].
    pub(super) fn keep(folder: &Path) -> Result<()> {
        let path = folder.join(CHECK);
        if path.exists() {
            return Ok(());
        }
        write_json(&path, FORMAT, &Self::measure(folder)?)
    }

    /// The check of a run.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub(super) fn read(folder: &Path) -> Result<Self> {
        read_json(&folder.join(CHECK), FORMAT)
    }
}

/// The scene at half the time step.
pub(super) fn with_half_steps(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.physics.dt *= 0.5;
    scene.physics.steps *= 2;
    scene
}

fn is_within(scene: &Scene, [solid, actuator]: [f64; 2]) -> bool {
    let bounds = VolumeBounds::widened(&scene.volume, scene.volume.widening);
    // A mean of a hundred shares is rounded at 1e-16.
    let within = |x: f64, bound: Range| bound.widened(1e-12).contains(x);
    within(solid, bounds.solid) && within(actuator, bounds.actuator)
}
