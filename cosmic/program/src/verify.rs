//! `cosmic verify`.

use crate::output::{in_colour, note, print_as};
use crate::source::SourceArguments;
use clap::Args;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::error::Result;
use cosmic::record::files::make_folder;
use cosmic_lab::report::sheet::{Section, Sheet};
use cosmic_lab::verify::{accuracy, distance, gradients, stability, stiff};
use std::path::PathBuf;

/// Tell whether the distance depends on time step, integrator and precision; measure the errors of trajectories, gradients
/// and time steps against more accurate methods
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    robot: SourceArguments,
    /// Compare the distance with other time steps, integrators and precisions
    #[arg(long)]
    distance: bool,
    /// Check trajectories: error against run time for each integrator, time step and precision
    #[arg(long)]
    accuracy: bool,
    /// Check gradients: error, time and memory for each mode and horizon
    #[arg(long)]
    gradients: bool,
    /// Check stability: the largest stable time steps of the design, and stiff and extreme robots
    #[arg(long)]
    stability: bool,
    /// Compare explicit and implicit steps with bars of any stiffness. Only if asked for
    #[arg(long)]
    stiff: bool,
    /// Folder for verify.html, verify.json, a CSV file per table and an SVG file per figure
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print all tables, not only the verdict
    #[arg(long)]
    rows: bool,
    /// Write JSON to standard output
    #[arg(long)]
    json: bool,
}

/// A function that does one part of the verification and returns its section of the report.
type Part = fn(&Case) -> Section;

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let case = self.robot.read(registry)?.case;
        if let Some(folder) = &self.out {
            make_folder(folder)?;
        }
        let sections = self.parts().into_iter().map(|part| part(&case));
        let sheet = Sheet {
            title: format!("Verification of {}", self.robot.source),
            subject: subject(&case),
            sections: sections.collect(),
        };
        let text = match self.rows {
            true => sheet.to_text(),
            false => sheet.verdict_text(in_colour),
        };
        print_as(self.json, &sheet.to_json(), &text)?;
        if let Some(folder) = &self.out {
            for path in sheet.write(folder)? {
                note(&path.display().to_string());
            }
        }
        sheet.judge()
    }

    /// Returns the parts that the user asks for. Without an option for a part, returns all parts but `stiff`, which takes
    /// minutes.
    fn parts(&self) -> Vec<Part> {
        let all =
            !(self.distance || self.accuracy || self.gradients || self.stability || self.stiff);
        let parts: [(bool, Part); 5] = [
            (self.distance || all, distance),
            (self.accuracy || all, accuracy),
            (self.gradients || all, gradients),
            (self.stability || all, stability),
            (self.stiff, stiff),
        ];
        let wanted = parts.into_iter().filter(|(wanted, _)| *wanted);
        wanted.map(|(_, part)| part).collect()
    }
}

/// Describes the size of the case in words.
fn subject(case: &Case) -> String {
    let (lattice, physics) = (&case.lattice, &case.physics);
    format!(
        "{} nodes, {} edges, {} steps of {} s",
        lattice.nodes(),
        lattice.edges.len(),
        physics.steps,
        physics.dt
    )
}
