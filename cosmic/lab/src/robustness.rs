//! Domain randomisation: finished designs rolled out in drawn domains, the same for all of them.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use crate::files::write_text;
use crate::table::{Column, Table};
use cosmic::codesign::{CoDesign, Quantiles, Reached};
use cosmic::domain::{Domain, draw};
use cosmic::error::Result;
use cosmic::random::{Purpose, stream};
use cosmic::record::files::{Format, write_json};
use cosmic::record::summary::result_of;
use cosmic::record::{DesignFile, run};
use cosmic::scene::{RobustSettings, Scene};
use cosmic::simulator::Divergence;

/// What the files of results say they are.
const FORMAT: Format = Format {
    name: "cosmic-robustness",
    version: 1,
};

/// Designs among drawn domains.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Robustness {
    /// How far the domains are from the nominal one.
    pub scatter: RobustSettings,
    /// Seed of the draws.
    pub seed: u64,
    /// One design each.
    pub runs: Vec<RobustRun>,
}

impl Robustness {
    /// A row a run.
    pub fn table(&self) -> Table {
        let metres = |name, says| Column::new(name, says).unit("m").decimals(3, "diverged");
        let nominal = metres("nominal", "displacement of the robot as it was designed");
        let least = metres("least", "the least displacement over the drawn domains");
        let table = Table::of("", "", &self.runs)
            .column("run", "the run's folder", |run| &run.run[..])
            .add(nominal, |run| run.nominal)
            .add(least, |run| run.least)
            .add(metres("p10", "10 % quantile over them"), |run| run.p10)
            .add(metres("p50", "median over them"), |run| run.p50)
            .add(metres("p90", "90 % quantile over them"), |run| run.p90);
        if self.runs.iter().all(|run| run.loss.is_none()) {
            return table.done();
        }
        let says = "median loss over them, for another task than to get far";
        let loss = Column::new("loss", says).decimals(4, "–");
        table.add(loss, |run| run.loss).done()
    }

    /// Writes JSON or, where the file's name ends in `.csv`, the table.
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

/// One design among the domains. Lengths in metres along the ground.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustRun {
    /// The run's folder.
    pub run: String,
    /// How far the nominal robot gets in one rollout; `None` where it diverges.
    pub nominal: Option<f64>,
    /// The least over the drawn domains; `None` where a rollout diverged.
    pub least: Option<f64>,
    /// 10 % quantile over the drawn domains; `None` where it leans on a diverged rollout.
    pub p10: Option<f64>,
    /// Median over them.
    pub p50: Option<f64>,
    /// 90 % quantile over them.
    pub p90: Option<f64>,
    /// Where the scene's task is not to get far: the median loss over them.
    pub loss: Option<f64>,
    /// Where the nominal rollout diverges, if it does.
    #[serde(skip)]
    pub divergence: Option<Divergence>,
}

/// Where designs are tried out.
#[derive(Clone, Debug)]
pub struct DrawnDomains {
    /// How far the domains are from the nominal one, and how many there are.
    pub scatter: RobustSettings,
    /// Seed of the draws.
    pub seed: u64,
    /// The scene for all designs; without one, each in its own.
    pub scene: Option<Scene>,
}

/// Rolls out the designs of finished runs in as many domains as the trial's scatter has samples. For
/// lattices of one size all designs see the same draws.
///
/// # Errors
/// Where a run is not finished, its scene or design cannot be read, or the two do not fit.
pub fn measure(runs: &[PathBuf], trial: &DrawnDomains) -> Result<Robustness> {
    let runs = runs.iter().map(|folder| one(folder, trial));
    Ok(Robustness {
        scatter: trial.scatter.clone(),
        seed: trial.seed,
        runs: runs.collect::<Result<_>>()?,
    })
}

fn one(folder: &Path, trial: &DrawnDomains) -> Result<RobustRun> {
    let scene = match &trial.scene {
        Some(scene) => scene.clone(),
        None => Scene::read(&folder.join(run::SCENE))?,
    };
    let file = result_of(folder, run::DESIGN)?;
    let case = DesignFile::read(&file)?.case(&scene, &file.display().to_string())?;
    let codesign = CoDesign::new(&scene)?;
    let (task, mixture) = (codesign.task(), case.own_mixture());
    let mut stream = stream(trial.seed, Purpose::Robustness);
    let domains: Vec<Domain> = (0..trial.scatter.samples)
        .map(|_| draw(task, &trial.scatter, &mut stream))
        .collect();
    let reach = |domain: &Domain| codesign.reach(&mixture, &case.controller, domain);
    let reached: Vec<Reached> = domains.par_iter().map(reach).collect();
    let nominal = reach(&Domain {
        task: Cow::Borrowed(task),
        start: case.start.clone(),
    });
    let far: Vec<f64> = reached.iter().map(|r| r.moved[0]).collect();
    let merits: Vec<f64> = reached.iter().map(|r| r.merit).collect();
    let spread = Quantiles::of(&far);
    let finite = |x: f64| x.is_finite().then_some(x);
    let has_loss = !codesign.is_far();
    Ok(RobustRun {
        run: folder.display().to_string(),
        nominal: finite(nominal.moved[0]),
        least: least(&far),
        p10: finite(spread.p10),
        p50: finite(spread.p50),
        p90: finite(spread.p90),
        loss: has_loss
            .then(|| -Quantiles::of(&merits).p50)
            .and_then(finite),
        divergence: if nominal.moved[0].is_finite() {
            None
        } else {
            case.divergence()
        },
    })
}

/// The least number; `None` where one is none, a rollout that diverged.
fn least(numbers: &[f64]) -> Option<f64> {
    let all = numbers.iter().all(|x| x.is_finite());
    all.then(|| numbers.iter().copied().fold(f64::INFINITY, f64::min))
}
