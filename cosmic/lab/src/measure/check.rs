//! `check.json`: how the design of a finished run performs in changed scenes.

use cosmic::Registry;
use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::design::VolumeBounds;
use cosmic::error::Result;
use cosmic::geometry::Range;
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::{DesignFile, Summary, run};
use cosmic::scene::Scene;
use serde::{Deserialize, Serialize};
use std::path::Path;

const FORMAT: Format = Format::new("cosmic-check", 1);

/// The name of the check in a run's folder.
const CHECK: &str = "check.json";

/// Results of a delivered design in changed scenes. Displacements are in metres along the ground. Every rollout begins
/// at one of the perturbed starts that the summary also uses. A displacement is `None` if a rollout diverged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Check {
    /// The 10 % quantile, the median and the 90 % quantile of the displacement in rollouts with half the time step and
    /// twice as many steps.
    half_step: [Option<f64>; 3],
    /// The median displacement if the controller sees the goal mirrored behind the origin.
    pub(super) goal_behind: Option<f64>,
    /// True if every edge has exactly one material.
    one_hot: bool,
    /// True if the volumes are within the bounds of the scene, widened by `volume.widening`.
    within_bounds: bool,
}

/// The type of a function that takes one number from a check. It returns `None` if a rollout diverged.
pub(crate) type CheckNumber = fn(&Check) -> Option<f64>;

impl Check {
    /// The numbers of a check that tables show, each with the name of its column. The answers yes and no are the
    /// numbers 1 and 0.
    pub(crate) const NUMBERS: [(&str, CheckNumber); 6] = [
        ("half_step_p50", |check| check.half_step[1]),
        ("half_step_p10", |check| check.half_step[0]),
        ("half_step_p90", |check| check.half_step[2]),
        ("goal_behind_p50", |check| check.goal_behind),
        ("one_hot", |check| Some(f64::from(check.one_hot))),
        ("within_bounds", |check| {
            Some(f64::from(check.within_bounds))
        }),
    ];

    /// Measures a finished run and writes `check.json`, unless the file exists.
    ///
    /// # Errors
    /// The errors of reading the run's files and of [`write_json`].
    pub(crate) fn keep(folder: &Path, registry: &Registry) -> Result<()> {
        let path = folder.join(CHECK);
        if path.exists() {
            return Ok(());
        }
        write_json(&path, FORMAT, &Self::measure(folder, registry)?)
    }

    /// Reads the check of a run.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        read_json(&folder.join(CHECK), FORMAT)
    }

    fn measure(folder: &Path, registry: &Registry) -> Result<Self> {
        let (summary, scene) = (Summary::read(folder)?, run::read_scene(folder, registry)?);
        let path = folder.join(run::DESIGN);
        let design = DesignFile::read(&path)?;
        let case = design.case(&scene, &path.display().to_string())?;
        let judged = |scene: &Scene| -> Result<[Option<f64>; 3]> {
            let codesign = CoDesign::new(scene)?;
            let Quantiles { p10, p50, p90 } =
                codesign
                    .evaluator()
                    .judge(&case.own_design(), &case.controller, summary.seed);
            Ok([p10, p50, p90].map(|x| x.is_finite().then_some(x)))
        };
        let (mut half, mut behind) = (scene.clone(), scene.clone());
        half.physics.dt *= 0.5;
        half.physics.steps *= 2;
        behind.controller.goal[0] = -scene.controller.goal[0];
        let bounds = VolumeBounds::widened(&scene.volume, scene.volume.widening);
        // This tolerance only allows for rounding: the mean of a hundred numbers is rounded by about 1e-16.
        let is_within = |x: f64, bounds: Range| bounds.widened(1e-12).contains(x);
        Ok(Self {
            half_step: judged(&half)?,
            goal_behind: judged(&behind)?[1],
            one_hot: design.design().layout().is_some(),
            within_bounds: is_within(summary.volume, bounds.solid)
                && is_within(summary.actuator_volume, bounds.actuator),
        })
    }
}
