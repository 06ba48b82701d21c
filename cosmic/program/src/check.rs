//! `cosmic check`.

use crate::arguments::{Output, Settings, Work, seed};
use crate::cost::is_large;
use crate::output::{in_colour, note, print, print_json};
use crate::source::Source;
use clap::Args;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::error::{Error, Result};
use cosmic::numbers::rounded;
use cosmic::parallel::pool;
use cosmic::record::files::make_folder;
use cosmic::scene::BUILTIN;
use cosmic_lab::check::accuracy::Method;
use cosmic_lab::check::{accuracy, distance, gradient, plan, stability};
use cosmic_lab::report::sheet::{Section, Sheet};
use std::path::PathBuf;

/// Check a robot: what a step computes, whether the gradient is right, and whether the distance depends on the time step
///
/// The gradient is compared with finite differences and forward mode, and a gradient that is wrong on purpose must be
/// noticed. It is that of the scene's loss; a design uses the scene beside it. For a reference case it is that of the
/// displacement.
///
/// A robot that stands still has no gradient, because its feet stick to the ground. Then the slopes are those of the
/// same robot thrown up and forward, and the output says so. If a group of parameters has no gradient even then, nothing
/// could be compared, and the check fails.
///
/// The distance of a run or a design must change by at most 20 % at half the time step and with another integrator. For a
/// scene, whose robot is not designed yet, the distance is only printed.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A built-in scene, a scene file, a run's folder or design.json, or a reference case
    #[arg(value_name = "SCENE", default_value = BUILTIN[0].name)]
    source: String,
    #[command(flatten)]
    settings: Settings,
    /// Maximum number of steps for the gradient. The motion is chaotic, so finite differences are meaningless over
    /// thousands of steps
    #[arg(
        long,
        value_name = "N",
        default_value_t = 256,
        allow_negative_numbers = true
    )]
    steps: usize,
    /// Seed of the random directions of the gradient
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Also measure error against run time, for several integrators and time steps
    #[arg(long)]
    accuracy: bool,
    /// Also simulate stiff and extreme robots
    #[arg(long)]
    stability: bool,
    /// Folder for check.html, a page with charts, and a CSV file for each table
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    work: Work,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let source = Source::read(&self.source, &self.settings, registry)?;
        if let Some(folder) = &self.out {
            make_folder(folder)?;
        }
        let pool = pool(self.work.threads)?;
        let sheet = pool.install(|| self.sheet(&source))?;
        match self.work.output.json {
            true => print_json(&sheet.to_json())?,
            false => print(&format!("\n{}", sheet.outcomes(in_colour)))?,
        }
        if let Some(folder) = &self.out {
            for path in sheet.write(folder)? {
                note(&path.display().to_string());
            }
        }
        sheet.judge()
    }

    /// Does the checks that the user asks for. Prints each of them when it is done, unless the output is JSON.
    ///
    /// # Errors
    /// [`Error::Diverged`] if the robot diverges in the steps of the gradient; the errors of [`print`].
    fn sheet(&self, source: &Source) -> Result<Sheet> {
        let Source { case, scene, .. } = source;
        let Output { quiet, json } = self.work.output;
        let mut short = case.clone();
        short.scene.physics.steps = self.steps.min(case.scene.physics.steps);
        if let Some(divergence) = short.divergence() {
            return Err(Error::from(&divergence));
        }
        let mut sheet = Sheet {
            title: self.source.clone(),
            subject: subject(case),
            sections: Vec::new(),
        };
        let gradient = || gradient(case, scene.as_ref(), self.steps, self.seed);
        let distance = || distance(case, source.is_delivered);
        let (plan, accuracy, stability) = (|| plan(case), || accuracy(case), || stability(case));
        let part = |title, run| Part {
            title,
            is_wanted: true,
            wait: "",
            run,
        };
        let parts = [
            part("Plan", &plan),
            part("Gradient", &gradient),
            part("Distance", &distance),
            Part {
                is_wanted: self.accuracy,
                wait: FINER,
                ..part("Accuracy", &accuracy)
            },
            Part {
                is_wanted: self.stability,
                wait: EXTREME,
                ..part("Stability", &stability)
            },
        ];
        let show = |text: &str| if json { Ok(()) } else { print(text) };
        show(&format!("{}: {}\n", sheet.title, sheet.subject))?;
        if !quiet && is_large(&case.lattice) {
            note("checking a large lattice; the gradient may take a minute ...");
        }
        for part in parts.iter().filter(|part| part.is_wanted) {
            // The heading comes first, so that the user sees which part is running.
            show(&format!("\n{}\n", part.title.to_uppercase()))?;
            if !quiet && !part.wait.is_empty() {
                note(part.wait);
            }
            let section = (part.run)();
            show(&section.to_text(in_colour))?;
            sheet.sections.push(section);
        }
        Ok(sheet)
    }
}

/// A part of a check.
struct Part<'a> {
    title: &'static str,
    /// True if the user asks for this part.
    is_wanted: bool,
    /// What to say before a part that takes long; empty for the others.
    wait: &'static str,
    run: &'a dyn Fn() -> Section,
}

/// What a user waits for in the part about accuracy.
const FINER: &str =
    "simulating with time steps down to 1/2048 of the scene's; this may take a minute ...";
/// What a user waits for in the part about stability.
const EXTREME: &str =
    "simulating more than a hundred stiff and extreme robots; this may take minutes ...";

/// Describes a case in a few words.
fn subject(case: &Case) -> String {
    let (lattice, physics) = (&case.lattice, &case.scene.physics);
    format!(
        "{}, {} nodes, {} edges, {} steps of {} s, {}",
        case.scene.lattice.name(),
        lattice.nodes(),
        lattice.edges.len(),
        physics.steps,
        rounded(physics.dt, 5),
        Method::of(case).name()
    )
}
