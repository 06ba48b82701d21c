//! The options of `export` for MuJoCo.

use crate::arguments::{number, whole};
use clap::Args;
use cosmic_lab::export::mujoco::{MOST_FRICTION, MujocoSettings};

/// Settings of MuJoCo that scenes do not have. Except for friction, their values hardly change the distance walked.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options for MuJoCo")]
pub(super) struct MujocoOptions {
    /// Coefficient of friction, at most 5 [default: the scene's coefficient, limited to 5]
    #[arg(long, value_name = "MU", value_parser = above_zero(MOST_FRICTION), allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Mechanical steps per step of the controller, at least as many as in the scene
    #[arg(long, value_name = "N", default_value_t = MujocoSettings::default().substeps, value_parser = whole(1..=64_usize), allow_negative_numbers = true)]
    substeps: usize,
    /// Time constant of contacts in s, at least two mechanical steps
    #[arg(long, value_name = "S", default_value_t = MujocoSettings::default().contact_time, value_parser = above_zero(1.0), allow_negative_numbers = true)]
    contact_time: f64,
    /// Ratio of frictional to normal impedance; with a small ratio contacts creep
    #[arg(long, value_name = "R", default_value_t = MujocoSettings::default().impedance_ratio, value_parser = above_zero(1e6), allow_negative_numbers = true)]
    impedance_ratio: f64,
    /// Maximum number of solver iterations per step
    #[arg(long, value_name = "N", default_value_t = MujocoSettings::default().iterations, value_parser = whole(1..=10_000_usize), allow_negative_numbers = true)]
    solver_iterations: usize,
    /// Tolerance of the solver
    #[arg(long, value_name = "T", default_value_t = MujocoSettings::default().tolerance, value_parser = above_zero(1.0), allow_negative_numbers = true)]
    solver_tolerance: f64,
    /// Hold skeleton bars at their length, by equality constraints; robots with implicit steps need it
    #[arg(long)]
    rigid: bool,
}

impl MujocoOptions {
    pub(super) fn settings(&self) -> MujocoSettings {
        MujocoSettings {
            friction: self.friction,
            substeps: self.substeps,
            contact_time: self.contact_time,
            impedance_ratio: self.impedance_ratio,
            iterations: self.solver_iterations,
            tolerance: self.solver_tolerance,
            rigid: self.rigid,
        }
    }
}

/// Makes a parser for numbers above 0 and up to `most`.
fn above_zero(most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone {
    move |text| {
        let expected = format!("expected a number above 0, at most {most}");
        number(text, |x| 0.0 < x && x <= most, expected)
    }
}
