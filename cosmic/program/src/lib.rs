//! The command line: one file a command, each a struct of arguments with a `run`.
//!
//! The order of the modules is the architecture: each uses only those above it.

mod arguments;
mod output;
mod interrupt;
mod progress;
mod runs;
mod source;
mod optimize;
mod resume;
mod evaluate;
mod gradcheck;
mod verify;
mod explain;
mod report;
mod compare;
mod robustness;
mod mujoco;
mod export;
mod study;
mod sweep;
mod scene;
mod completions;

use clap::{CommandFactory, Parser, Subcommand};
use cosmic::error::Result;
use cosmic::lattice::{self, Truss};
use cosmic::laws::{self, Choice};
use cosmic::objective::{self, Loss};
use cosmic::policy::{self, Policy};
use output::{complain, written};
use std::process::ExitCode;

/// Co-design of truss-lattice robots: structure, material and neural control optimised together.
#[derive(Debug, Parser)]
#[command(name = "cosmic", version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Optimize(optimize::Arguments),
    Resume(resume::Arguments),
    Evaluate(evaluate::Arguments),
    Gradcheck(gradcheck::Arguments),
    Verify(verify::Arguments),
    Explain(explain::Arguments),
    Report(report::Arguments),
    Compare(compare::Arguments),
    Robustness(robustness::Arguments),
    Export(export::Arguments),
    Study(study::Arguments),
    Sweep(sweep::Arguments),
    Scene(scene::Arguments),
    Completions(completions::Arguments),
}

impl Command {
    fn run(&self) -> Result<()> {
        match self {
            Command::Optimize(arguments) => arguments.run(),
            Command::Resume(arguments) => arguments.run(),
            Command::Evaluate(arguments) => arguments.run(),
            Command::Gradcheck(arguments) => arguments.run(),
            Command::Verify(arguments) => arguments.run(),
            Command::Explain(arguments) => arguments.run(),
            Command::Report(arguments) => arguments.run(),
            Command::Compare(arguments) => arguments.run(),
            Command::Robustness(arguments) => arguments.run(),
            Command::Export(arguments) => arguments.run(),
            Command::Study(arguments) => arguments.run(),
            Command::Sweep(arguments) => arguments.run(),
            Command::Scene(arguments) => arguments.run(),
            Command::Completions(arguments) => arguments.run(Cli::command()),
        }
    }
}

/// The program, with what its author adds to it.
///
/// ```no_run
/// use autodiff::Real;
/// use cosmic::geometry::Vector;
/// use cosmic::laws::{Contact, Impact, Law, contact};
///
/// cosmic::settings! {
///     /// A node leaves the ground as fast as it meets it.
///     struct Trampoline {}
/// }
///
/// impl Law for Trampoline {
///     const NAME: &'static str = "trampoline";
/// }
///
/// impl Contact for Trampoline {
///     #[inline(always)]
///     fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
///         let velocity = impact.velocity;
///         velocity.with_up(-velocity.up())
///     }
/// }
///
/// fn main() -> std::process::ExitCode {
///     let program = cosmic_program::Program::new().with(contact::<Trampoline>());
///     // `cosmic optimize bounce`, and every other command.
///     program.scene("bounce", "[physics]\ncontact = \"trampoline\"").run()
/// }
/// ```
#[derive(Debug, Default)]
pub struct Program(());

impl Program {
    /// The program as it ships.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a law: scenes choose it by its name, see [`cosmic::laws::Choice`].
    ///
    /// # Panics
    /// As [`cosmic::laws::add`].
    #[must_use]
    pub fn with(self, law: Choice) -> Self {
        laws::add(law);
        self
    }

    /// Adds a loss: scenes choose it by `objective.own_loss = "its_name"`.
    ///
    /// # Panics
    /// As [`cosmic::objective::add`].
    #[must_use]
    pub fn with_loss(self, name: &'static str, loss: impl Loss + 'static) -> Self {
        objective::add(name, loss);
        self
    }

    /// Adds a policy: scenes choose it by `controller.policy = "its_name"`. Its runs need this program.
    ///
    /// # Panics
    /// As [`cosmic::policy::add`].
    #[must_use]
    pub fn with_policy(self, name: &'static str, policy: impl Policy + 'static) -> Self {
        policy::add(name, policy);
        self
    }

    /// Adds a lattice: scenes choose it by `lattice.file = "its_name"`. Run folders hold a copy, which
    /// every program reads.
    ///
    /// # Panics
    /// As [`cosmic::lattice::add`].
    #[must_use]
    pub fn lattice(self, name: &'static str, truss: Truss) -> Self {
        lattice::add(name, truss);
        self
    }

    /// Adds a scene with a name, from its TOML. The last one added is what an omitted scene means.
    ///
    /// # Panics
    /// As [`cosmic::scene::add`].
    #[must_use]
    pub fn scene(self, name: &'static str, text: &'static str) -> Self {
        cosmic::scene::add(name, text);
        self
    }

    /// Runs the command that the process was started with. The exit code is 0, or the error's own
    /// ([`cosmic::Error::exit_code`]).
    pub fn run(self) -> ExitCode {
        match Cli::try_parse() {
            Ok(cli) => exit_code(cli.command.run()),
            Err(request) => refuse(&request),
        }
    }
}

/// Shows help or the version (exit 0), or the mistake in the arguments (exit 2).
fn refuse(request: &clap::Error) -> ExitCode {
    let shown = request.print();
    if request.use_stderr() {
        return ExitCode::from(2);
    }
    exit_code(written(shown))
}

/// The exit code of a result. Shows the error.
fn exit_code(done: Result<()>) -> ExitCode {
    let Err(error) = done else {
        return ExitCode::SUCCESS;
    };
    complain(&error);
    ExitCode::from(error.exit_code())
}

/// The README's code, compiled and run with the documentation's.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
