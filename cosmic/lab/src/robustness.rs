//! Domain randomization: simulates finished designs with randomly drawn variations: random changes of start,
//! friction, stiffness and masses. All designs get the same draws.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use crate::table::{Column, Table};
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::judge::{Evaluator, Quantiles};
use cosmic::numbers::finite;
use cosmic::outcome::DesignFile;
use cosmic::random::{Purpose, stream};
use cosmic::record::damaged::explained;
use cosmic::record::run;
use cosmic::record::summary::result_of;
use cosmic::scene::{Scatter, Scene};
use cosmic::search::CoDesign;
use cosmic::walk::Divergence;
use cosmic::world::{Variation, draw};

/// The results of several designs under random changes of the robots and their surroundings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Robustness {
    /// The number of random draws.
    pub samples: usize,
    /// The largest random changes.
    pub scatter: Scatter,
    /// The seed of the random draws.
    pub seed: u64,
    /// One entry per design.
    pub runs: Vec<RobustRun>,
    /// The folders of the designs whose rollouts without random changes diverged, and how.
    #[serde(skip)]
    pub divergences: Vec<(String, Divergence)>,
}

impl Robustness {
    /// A table with a row per run.
    pub fn table(&self) -> Table {
        let table = Table::of("", "", &self.runs)
            .column("run", "the run's folder", |run| &run.run[..])
            .keyed(Some)
            .missing("diverged");
        if self.runs.iter().all(|run| run.loss.is_none()) {
            return table.done();
        }
        let says = "median loss over the drawn variations, if the task is not distance";
        let loss = Column::new("loss", says).decimals(4, "–");
        table.add(loss, |run| run.loss).done()
    }
}

cosmic::keys! {
    /// The result of one design over all random draws. Displacements are along the ground; `None` if they depend on a
    /// diverged rollout.
    #[derive(Clone, Debug, PartialEq, Serialize)]
    struct RobustRun {
        /// The run's folder.
        run: String, "text";
        /// Displacement of the robot as it was designed, from a single rollout.
        nominal: Option<f64>, "number or `null`", unit "m", columns ["nominal"];
        /// The least displacement over the drawn variations.
        least: Option<f64>, "number or `null`", unit "m", columns ["least"];
        /// 10 % quantile over the drawn variations.
        p10: Option<f64>, "number or `null`", unit "m", columns ["p10"];
        /// Median over the drawn variations.
        p50: Option<f64>, "number or `null`", unit "m", columns ["p50"];
        /// 90 % quantile over the drawn variations.
        p90: Option<f64>, "number or `null`", unit "m", columns ["p90"];
        /// Median displacement over the drawn variations without feedback (open loop).
        clock_p50: Option<f64>, "number or `null`", unit "m", columns ["clock_p50"];
        /// Median loss over the drawn variations, if the task is not distance.
        loss: Option<f64>, "number or `null`", unit "the loss's";
    }
}

/// The settings of domain randomization: how many variations are drawn, and how far they may differ from the nominal
/// robot.
#[derive(Clone, Debug)]
pub struct DrawnVariations {
    /// The number of random draws.
    pub samples: usize,
    /// The largest random changes.
    pub scatter: Scatter,
    /// The seed of the random draws.
    pub seed: u64,
    /// The scene in which all designs are simulated; if `None`, each design is simulated in its own scene.
    pub scene: Option<Scene>,
    /// Settings that change the scenes, in the form of [`Scene::set`].
    pub settings: Vec<String>,
    /// The laws, losses, policies and lattices that the scenes of the designs may name.
    pub registry: Registry,
}

/// Rolls out the designs of finished runs with the drawn variations. Designs on lattices of equal size get equal draws.
///
/// # Errors
/// If a run is not finished, its scene or design cannot be read, or the design does not fit the scene.
pub fn measure(runs: &[PathBuf], trial: &DrawnVariations) -> Result<Robustness> {
    let mut divergences = Vec::new();
    let runs = runs.iter().map(|folder| {
        let (run, divergence) = one(folder, trial)?;
        divergences.extend(divergence.map(|divergence| (run.run.clone(), divergence)));
        Ok(run)
    });
    Ok(Robustness {
        samples: trial.samples,
        scatter: trial.scatter.clone(),
        seed: trial.seed,
        runs: runs.collect::<Result<_>>()?,
        divergences,
    })
}

/// The result of one design, and how its rollout without random changes diverged.
fn one(folder: &Path, trial: &DrawnVariations) -> Result<(RobustRun, Option<Divergence>)> {
    // The design is read before the scene. If a folder is not a run, both are missing, and the error should name the
    // design.
    let file = result_of(folder, run::DESIGN)?;
    let scene = match &trial.scene {
        Some(scene) => scene.clone(),
        None => run::read_scene(folder, &trial.registry)?,
    };
    let scene = scene.set(&trial.settings)?;
    let case = DesignFile::read(&file)
        .map_err(explained(&file))?
        .case(&scene, &file.display().to_string())?;
    let codesign = CoDesign::new(&scene)?;
    let (evaluator, design) = (codesign.evaluator(), case.own_design());
    let open_loop = evaluator.in_open_loop();
    let mut stream = stream(trial.seed, Purpose::Robustness);
    let draw = |_| draw(&evaluator.world, &trial.scatter, &mut stream);
    let drawn: Vec<Variation> = (0..trial.samples).map(draw).collect();
    let reach = |evaluator: &Evaluator, variation: &Variation| {
        evaluator.reach(&design, &case.controller, variation)
    };
    let with_feedback = |variation: &Variation| reach(evaluator, variation);
    let reached: Vec<_> = drawn.par_iter().map(with_feedback).collect();
    let nominal = reach(evaluator, &evaluator.world.nominal(&case.start));
    let by_clock = drawn.par_iter();
    let by_clock = by_clock.map(|variation| reach(&open_loop, variation).moved.forward());
    let by_clock: Vec<f64> = by_clock.collect();
    let far: Vec<f64> = reached.iter().map(|r| r.moved.forward()).collect();
    let merits: Vec<f64> = reached.iter().map(|r| r.merit).collect();
    let spread = Quantiles::of(&far);
    let least = far.iter().copied().fold(f64::INFINITY, f64::min);
    let loss = -Quantiles::of(&merits).p50;
    let diverges = !nominal.moved.forward().is_finite();
    let run = RobustRun {
        run: folder.display().to_string(),
        nominal: finite(nominal.moved.forward()),
        least: Some(least).filter(|_| far.iter().all(|x| x.is_finite())),
        p10: finite(spread.p10),
        p50: finite(spread.p50),
        p90: finite(spread.p90),
        clock_p50: finite(Quantiles::of(&by_clock).p50),
        loss: finite(loss).filter(|_| !evaluator.is_far()),
    };
    Ok((run, diverges.then(|| case.divergence()).flatten()))
}
