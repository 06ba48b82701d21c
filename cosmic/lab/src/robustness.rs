//! Domain randomization: simulates finished designs in randomly drawn domains, that is, with random changes of start,
//! friction, stiffness and masses. All designs get the same draws.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use crate::files::write_text;
use crate::table::{Column, Table};
use cosmic::Registry;
use cosmic::codesign::{CoDesign, Quantiles};
use cosmic::domain::{Domain, draw};
use cosmic::error::Result;
use cosmic::random::{Purpose, stream};
use cosmic::record::files::{Format, write_json};
use cosmic::record::summary::result_of;
use cosmic::record::{DesignFile, run};
use cosmic::scene::{Scatter, Scene};
use cosmic::simulator::Divergence;

/// The format of the results.
const FORMAT: Format = Format {
    name: "cosmic-robustness",
    version: 1,
};

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
}

impl Robustness {
    /// A table with a row per run.
    pub fn table(&self) -> Table {
        let metres = |name, says| Column::new(name, says).unit("m").decimals(3, "diverged");
        let nominal = metres("nominal", "displacement of the robot as it was designed");
        let says = "median displacement over the drawn domains without feedback (open loop)";
        let clock = metres("clock_p50", says);
        let least = metres("least", "the least displacement over the drawn domains");
        let table = Table::of("", "", &self.runs)
            .column("run", "the run's folder", |run| &run.run[..])
            .add(nominal, |run| run.nominal)
            .add(least, |run| run.least)
            .add(
                metres("p10", "10 % quantile over the drawn domains"),
                |run| run.p10,
            )
            .add(metres("p50", "median over the drawn domains"), |run| {
                run.p50
            })
            .add(
                metres("p90", "90 % quantile over the drawn domains"),
                |run| run.p90,
            )
            .add(clock, |run| run.clock_p50);
        if self.runs.iter().all(|run| run.loss.is_none()) {
            return table.done();
        }
        let says = "median loss over the drawn domains, if the task is not distance";
        let loss = Column::new("loss", says).decimals(4, "–");
        table.add(loss, |run| run.loss).done()
    }

    /// Writes the results to a file: as a CSV table if the file's name ends in `.csv`, otherwise as JSON.
    ///
    /// # Errors
    /// [`Error::Write`](cosmic::Error::Write).
    pub fn write(&self, path: &Path) -> Result<()> {
        if path.extension().is_some_and(|extension| extension == "csv") {
            return write_text(path, &self.table().to_csv());
        }
        write_json(path, FORMAT, self)
    }
}

/// The result of one design over all random draws. Lengths are in metres along the ground.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustRun {
    /// The run's folder.
    pub run: String,
    /// The displacement without random changes, from a single rollout; `None` if the rollout diverged.
    pub nominal: Option<f64>,
    /// The smallest displacement over the random draws; `None` if a rollout diverged.
    pub least: Option<f64>,
    /// The 10 % quantile of the displacement over the random draws; `None` if it depends on a diverged rollout.
    pub p10: Option<f64>,
    /// The median displacement over the random draws.
    pub p50: Option<f64>,
    /// The 90 % quantile of the displacement over the random draws.
    pub p90: Option<f64>,
    /// The median displacement over the random draws if the controller gets no feedback (open loop).
    pub clock_p50: Option<f64>,
    /// The median loss over the random draws, if the scene's task is another than distance.
    pub loss: Option<f64>,
    /// Describes how the rollout without random changes diverged; `None` if it did not.
    #[serde(skip)]
    pub divergence: Option<Divergence>,
}

/// The settings of domain randomization: how many domains are drawn, and how far they may differ from the nominal
/// domain.
#[derive(Clone, Debug)]
pub struct DrawnDomains {
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
    /// The laws and losses that the scenes of the designs may name.
    pub registry: Registry,
}

/// Rolls out the designs of finished runs in the drawn domains. Designs on lattices of equal size get equal draws.
///
/// # Errors
/// If a run is not finished, its scene or design cannot be read, or the design does not fit the scene.
pub fn measure(runs: &[PathBuf], trial: &DrawnDomains) -> Result<Robustness> {
    let runs = runs.iter().map(|folder| one(folder, trial));
    Ok(Robustness {
        samples: trial.samples,
        scatter: trial.scatter.clone(),
        seed: trial.seed,
        runs: runs.collect::<Result<_>>()?,
    })
}

fn one(folder: &Path, trial: &DrawnDomains) -> Result<RobustRun> {
    // The design is read before the scene. If a folder is not a run, both are missing, and the error should name the
    // design.
    let file = result_of(folder, run::DESIGN)?;
    let scene = match &trial.scene {
        Some(scene) => scene.clone(),
        None => run::read_scene(folder, &trial.registry)?,
    };
    let scene = scene.set(&trial.settings)?;
    let case = DesignFile::read(&file)?.case(&scene, &file.display().to_string())?;
    let codesign = CoDesign::new(&scene)?;
    let (task, design) = (codesign.task(), case.own_design());
    let mut stream = stream(trial.seed, Purpose::Robustness);
    let draw = |_| draw(task, &trial.scatter, &mut stream);
    let domains: Vec<Domain> = (0..trial.samples).map(draw).collect();
    let reach = |domain: &Domain| {
        codesign
            .evaluator()
            .reach(&design, &case.controller, domain)
    };
    let reached: Vec<_> = domains.par_iter().map(reach).collect();
    let nominal = reach(&Domain {
        task: Cow::Borrowed(task),
        start: case.start.clone(),
    });
    let open_loop: Vec<Domain> = (domains.iter())
        .map(|domain| domain.without_feedback(&case.start))
        .collect();
    let by_clock = open_loop.par_iter().map(|domain| reach(domain).moved[0]);
    let by_clock: Vec<f64> = by_clock.collect();
    let far: Vec<f64> = reached.iter().map(|r| r.moved[0]).collect();
    let merits: Vec<f64> = reached.iter().map(|r| r.merit).collect();
    let spread = Quantiles::of(&far);
    let least = far.iter().copied().fold(f64::INFINITY, f64::min);
    let finite = |x: f64| x.is_finite().then_some(x);
    let loss = -Quantiles::of(&merits).p50;
    let diverges = !nominal.moved[0].is_finite();
    Ok(RobustRun {
        run: folder.display().to_string(),
        nominal: finite(nominal.moved[0]),
        least: Some(least).filter(|_| far.iter().all(|x| x.is_finite())),
        p10: finite(spread.p10),
        p50: finite(spread.p50),
        p90: finite(spread.p90),
        clock_p50: finite(Quantiles::of(&by_clock).p50),
        loss: finite(loss).filter(|_| !codesign.evaluator().is_far()),
        divergence: diverges.then(|| case.divergence()).flatten(),
    })
}
