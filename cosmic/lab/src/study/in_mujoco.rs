//! `transfer.json`: how far a finished run's robot gets in MuJoCo, on grounds of several frictions.

use super::python;
use super::statistics::Statistics;
use crate::export::mujoco::{self, MujocoSettings};
use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::error::{Error, Result};
use cosmic::laws::ContactLaw;
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::summary::ratio;
use cosmic::record::{DesignFile, Summary, run};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The format of a transfer.
const FORMAT: Format = Format {
    name: "cosmic-transfer",
    version: 1,
};

/// The name of the transfer in a run's folder.
const TRANSFER: &str = "transfer.json";

/// The folder of the model in a run's folder.
const MODEL: &str = "export";

/// The coefficients of friction that robots are tried on. MuJoCo has no infinite one.
pub(super) const FRICTIONS: [f64; 4] = [5.0, 2.5, 1.0, 0.6];

/// Displacements of a delivered design along the ground, m; `None` if a rollout diverged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Transfer {
    /// The version of MuJoCo.
    pub(super) mujoco: String,
    /// The coefficients of friction.
    frictions: Vec<f64>,
    /// For each of them the walks in MuJoCo, from perturbed starts.
    walks: Vec<Vec<Option<f64>>>,
    /// For each of them the median of as many rollouts here, by our own law of Coulomb friction.
    own: Vec<Option<f64>>,
}

/// The output of the program of Python.
#[derive(Deserialize)]
struct Walks {
    mujoco: String,
    walks: Vec<Vec<Option<f64>>>,
}

impl Transfer {
    /// Measures a finished run and writes its transfer, unless it has one of these frictions.
    ///
    /// # Errors
    /// The errors of reading the run's files, of [`mujoco::write`] and of [`write_json`];
    /// [`Error::Usage`] where Python fails. `None` if it was stopped.
    pub(super) fn keep(
        folder: &Path,
        python: &Path,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<()>> {
        let known = Self::read(folder)?;
        if known.is_some_and(|known| known.frictions == FRICTIONS) {
            return Ok(Some(()));
        }
        let Some(found) = Self::measure(folder, python, is_stopped)? else {
            return Ok(None);
        };
        write_json(&folder.join(TRANSFER), FORMAT, &found).map(Some)
    }

    /// The transfer of a run, if it has one.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub(super) fn read(folder: &Path) -> Result<Option<Self>> {
        let path = folder.join(TRANSFER);
        path.exists().then(|| read_json(&path, FORMAT)).transpose()
    }

    fn measure(
        folder: &Path,
        python: &Path,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<Self>> {
        let summary = Summary::read(folder)?;
        let scene = run::read_scene(folder)?;
        let path = folder.join(run::DESIGN);
        let case = DesignFile::read(&path)?.case(&scene, &path.display().to_string())?;
        let model = folder.join(MODEL);
        mujoco::write(&case, &MujocoSettings::default(), &model)?;
        let selection = &scene.selection;
        let mut arguments = vec![
            model.display().to_string(),
            selection.perturbed_rollouts.to_string(),
            selection.perturbation.to_string(),
            summary.seed.to_string(),
        ];
        arguments.extend(FRICTIONS.map(|friction| friction.to_string()));
        let program = include_str!("walks.py");
        let Some(told) = python::run(python, program, &arguments, is_stopped)? else {
            return Ok(None);
        };
        let told: Walks = serde_json::from_slice(&told).map_err(|error| {
            Error::Usage(format!(
                "{}: the walks do not read: {error}",
                python.display()
            ))
        })?;
        let design = case.own_design();
        let own = FRICTIONS.map(|friction| {
            let mut scene = scene.clone();
            (scene.physics.contact, scene.physics.friction) = (ContactLaw::coulomb(), friction);
            let judged = CoDesign::new(&scene)?.judge(&design, &case.controller, summary.seed);
            Ok(Some(judged.p50).filter(|x| x.is_finite()))
        });
        Ok(Some(Self {
            mujoco: told.mujoco,
            frictions: FRICTIONS.to_vec(),
            walks: told.walks,
            own: own.into_iter().collect::<Result<_>>()?,
        }))
    }

    /// The median of the walks in MuJoCo at the `k`-th friction.
    pub(super) fn there(&self, k: usize) -> Option<f64> {
        let walks: Vec<f64> = (self.walks.get(k)?.iter())
            .map(|walk| walk.unwrap_or(f64::NAN))
            .collect();
        let median = (!walks.is_empty()).then(|| Quantiles::of(&walks).p50);
        median.filter(|x| x.is_finite())
    }

    /// The median of our own rollouts at the `k`-th friction.
    pub(super) fn own(&self, k: usize) -> Option<f64> {
        *self.own.get(k)?
    }
}

/// The share of its displacement that a robot keeps if it is said to keep most.
const MOST: f64 = 0.9;

/// A robot, and its walks in MuJoCo if it was tried there.
pub(super) struct Tried<'r> {
    /// The displacement of the delivered robot in its own scene, m; `None` if it diverged.
    pub(super) far: Option<f64>,
    /// Whether the robot is unreliable.
    pub(super) unreliable: bool,
    /// Its walks in MuJoCo.
    pub(super) transfer: Option<&'r Transfer>,
}

/// Robots of many seeds on ground of one friction. Ratios leave out unreliable robots, whose displacement is not a
/// useful reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct OnFriction {
    /// The coefficient.
    pub(super) friction: f64,
    /// Displacements in MuJoCo, m.
    pub(super) there: Statistics,
    /// Displacements here by our own law of Coulomb friction, m.
    pub(super) own: Statistics,
    /// Displacements in MuJoCo over those that the robots were delivered with.
    pub(super) keeps: Statistics,
    /// Robots that keep at least [`MOST`].
    pub(super) kept: usize,
    /// Displacements in MuJoCo over those here on the same friction.
    pub(super) agrees: Statistics,
}

impl OnFriction {
    /// A row for each friction, of the displacements that robots were delivered with and of their
    /// transfers; none where no robot was tried.
    pub(super) fn rows(robots: &[Tried]) -> Vec<Self> {
        if robots.iter().all(|robot| robot.transfer.is_none()) {
            return Vec::new();
        }
        let reliable = || robots.iter().filter(|robot| !robot.unreliable);
        let row = |(k, friction): (usize, f64)| {
            let of = |number: fn(&Transfer, usize) -> Option<f64>| {
                let of_robot = |robot: &Tried| number(robot.transfer?, k);
                Statistics::of(&robots.iter().map(of_robot).collect::<Vec<_>>())
            };
            let share = |of_robot: &dyn Fn(&Tried) -> Option<f64>| {
                Statistics::of(&reliable().map(of_robot).collect::<Vec<_>>())
            };
            let kept = |robot: &Tried| ratio(robot.transfer?.there(k), robot.far);
            let agrees = |robot: &Tried| {
                let transfer = robot.transfer?;
                ratio(transfer.there(k), transfer.own(k))
            };
            Self {
                friction,
                there: of(Transfer::there),
                own: of(Transfer::own),
                keeps: share(&kept),
                kept: reliable().filter(|robot| kept(robot) >= Some(MOST)).count(),
                agrees: share(&agrees),
            }
        };
        FRICTIONS.into_iter().enumerate().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{FRICTIONS, OnFriction, Transfer, Tried};

    #[test]
    fn a_robot_keeps_the_median_of_its_walks() {
        let walks = [Some(1.0), Some(3.0), None, Some(2.0), Some(2.0)];
        let transfer = Transfer {
            mujoco: String::new(),
            frictions: FRICTIONS.to_vec(),
            walks: vec![walks.to_vec(); 4],
            own: vec![Some(1.6), None, Some(1.0), Some(0.001)],
        };
        let tried = |far, unreliable, transfer| Tried {
            far: Some(far),
            unreliable,
            transfer,
        };
        let rows = OnFriction::rows(&[tried(4.0, false, Some(&transfer))]);
        assert_eq!(rows.len(), FRICTIONS.len());
        // A walk that was given up counts lowest.
        assert_eq!(
            (rows[0].there.median, rows[0].keeps.median),
            (Some(2.0), Some(0.5))
        );
        let agrees: Vec<_> = rows.iter().map(|row| row.agrees.median).collect();
        assert_eq!(agrees, [Some(1.25), None, Some(2.0), None]);
        assert_eq!(OnFriction::rows(&[tried(4.0, false, None)]), []);
        // The ratio of an unreliable robot is meaningless.
        let both = [(4.0, false), (0.2, true)];
        let both = both.map(|(far, unreliable)| tried(far, unreliable, Some(&transfer)));
        let rows = OnFriction::rows(&both);
        assert_eq!((rows[0].keeps.best, rows[0].kept), (Some(0.5), 0));
    }
}
