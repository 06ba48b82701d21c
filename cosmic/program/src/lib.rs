//! The command line. Each command has a file, with a struct of its arguments and a method `run`.
//!
//! The order of the modules is the architecture: each module uses only those above it.

mod arguments;
mod output;
mod interrupt;
mod progress;
mod runs;
mod source;
mod cost;
mod optimize;
mod resume;
mod evaluate;
mod check;
mod report;
mod walk;
mod robustness;
mod export;
mod sweep;
mod scene;
mod completions;

use autodiff::simd;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use cosmic::Registry;
use cosmic::error::{self, Error, Result, in_shell};
use cosmic::lattice::Truss;
use cosmic::laws::Choice;
use cosmic::objective::Loss;
use cosmic::policy::Policy;
use output::{complain, written};
use std::env;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Design a walking robot: its bars, their materials and its controller together.
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
    Check(check::Arguments),
    Report(report::Arguments),
    Walk(walk::Arguments),
    Robustness(robustness::Arguments),
    Export(export::Arguments),
    Sweep(sweep::Arguments),
    Scene(scene::Arguments),
    Completions(completions::Arguments),
}

impl Command {
    fn run(&self, registry: &Registry) -> Result<()> {
        let done = match self {
            Command::Optimize(arguments) => arguments.run(registry),
            Command::Resume(arguments) => arguments.run(registry),
            Command::Evaluate(arguments) => arguments.run(registry),
            Command::Check(arguments) => arguments.run(registry),
            Command::Report(arguments) => arguments.run(registry),
            Command::Walk(arguments) => arguments.run(registry),
            Command::Robustness(arguments) => arguments.run(registry),
            Command::Export(arguments) => arguments.run(registry),
            Command::Sweep(arguments) => arguments.run(registry),
            Command::Scene(arguments) => arguments.run(registry),
            Command::Completions(arguments) => arguments.run(command(registry)),
        };
        done.map_err(|error| or_scene(error, registry))
    }
}

/// Explains an error about a folder that does not exist if its name is that of a scene: the command needs a run.
fn or_scene(error: Error, registry: &Registry) -> Error {
    let Error::Read { path, .. } = &error else {
        return error;
    };
    let name = path.display().to_string();
    match registry.scene(&name) {
        Some(_) if !path.exists() => Error::Usage(format!(
            "`{name}` is a scene, but this command needs a run; make one with: {}, then name its folder, \
             runs/{name}-0",
            error::command(format_args!("optimize {name}"))
        )),
        _ => error,
    }
}

/// The parser of the command line. If an argument names a scene, its default is the default scene of the registry.
fn command(registry: &Registry) -> clap::Command {
    let default = registry.default_scene().name;
    let with_default = |command: clap::Command, argument| {
        command.mut_arg(argument, |argument| argument.default_value(default))
    };
    let command = Cli::command();
    let command = command.mut_subcommand("check", |command| with_default(command, "source"));
    command.mut_subcommand("sweep", |sweep| {
        sweep.mut_subcommand("run", |run| with_default(run, "spec"))
    })
}

/// The program `cosmic`, to which you can add your own laws, losses, policies, lattices and scenes.
///
/// ```no_run
/// use autodiff::Real;
/// use cosmic::geometry::Vector;
/// use cosmic::kernel;
/// use cosmic::laws::{Contact, Impact, Law, contact};
///
/// cosmic::settings! {
///     /// A node leaves the ground as fast as it hits it.
///     struct Trampoline {}
/// }
///
/// impl Law for Trampoline {
///     const NAME: &'static str = "trampoline";
/// }
///
/// #[kernel]
/// impl Contact for Trampoline {
///     fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
///         let velocity = impact.velocity;
///         velocity.with_up(-velocity.up())
///     }
/// }
///
/// fn main() -> std::process::ExitCode {
///     let program = cosmic_program::Program::new().with_law(contact::<Trampoline>());
///     // `cosmic optimize bounce`, and every other command.
///     program.with_scene("bounce", "[physics]\ncontact = \"trampoline\"").run()
/// }
/// ```
#[derive(Debug, Default)]
pub struct Program {
    registry: Registry,
}

impl Program {
    /// The program as it is, without added laws, losses, policies, lattices or scenes.
    pub fn new() -> Self {
        Self::default()
    }

    fn map(self, change: impl FnOnce(Registry) -> Registry) -> Self {
        Self {
            registry: change(self.registry),
        }
    }

    /// Adds a law, which scenes choose by its name; see [`Choice`].
    ///
    /// # Panics
    /// Like [`Registry::with_law`].
    #[must_use]
    pub fn with_law(self, law: Choice) -> Self {
        self.map(|registry| registry.with_law(law))
    }

    /// Adds a loss, which scenes choose by `objective.own_loss = "its_name"`.
    ///
    /// # Panics
    /// Like [`Registry::with_loss`].
    #[must_use]
    pub fn with_loss(self, name: &'static str, loss: impl Loss + 'static) -> Self {
        self.map(|registry| registry.with_loss(name, loss))
    }

    /// Adds a policy, which scenes choose by `controller.policy = "its_name"`. Only a program with this policy can
    /// read the runs that use it.
    ///
    /// # Panics
    /// Like [`Registry::with_policy`].
    #[must_use]
    pub fn with_policy(self, name: &'static str, policy: impl Policy + 'static) -> Self {
        self.map(|registry| registry.with_policy(name, policy))
    }

    /// Adds a lattice, which scenes choose by `lattice.file = "its_name"`. Run folders contain a copy of the
    /// lattice, so every program can read them.
    ///
    /// # Panics
    /// Like [`Registry::with_lattice`].
    #[must_use]
    pub fn with_lattice(self, name: &'static str, truss: Truss) -> Self {
        self.map(|registry| registry.with_lattice(name, truss))
    }

    /// Adds the scene `name`, whose TOML is `text`. The scene added last is the default scene.
    ///
    /// # Panics
    /// Like [`Registry::with_scene`].
    #[must_use]
    pub fn with_scene(self, name: &'static str, text: &'static str) -> Self {
        self.map(|registry| registry.with_scene(name, text))
    }

    /// Runs the command given on the command line. Returns exit code 0, or the exit code of the error
    /// ([`cosmic::Error::exit_code`]).
    pub fn run(self) -> ExitCode {
        self.run_with(env::args_os()).into()
    }

    /// Runs the command given by `arguments`, whose first element is the name of the program, and returns the exit
    /// code. One process can run several programs, each with its own laws.
    pub fn run_with(self, arguments: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> u8 {
        let Self { registry } = self;
        let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
        if let Some(program) = arguments.first() {
            error::started_with(start_of(Path::new(program)));
        }
        let mut command = command(&registry);
        let matches = command.try_get_matches_from_mut(arguments);
        let cli = matches.and_then(|matches| {
            let cli = Cli::from_arg_matches(&matches);
            cli.map_err(|request| request.format(&mut command))
        });
        match cli {
            Ok(cli) => exit_code(limit_registers().and_then(|()| cli.command.run(&registry))),
            Err(request) => refuse(&request),
        }
    }
}

/// The words with which the user started `program`, the first word of a command line, for the commands in messages.
///
/// Cargo starts programs in its folder of a profile, and examples in the folder `examples` there.
fn start_of(program: &Path) -> String {
    let name = program.file_stem().unwrap_or(program.as_os_str());
    let folder = program.parent().and_then(Path::file_name);
    let is_by_cargo = env::var_os("CARGO_MANIFEST_DIR").is_some();
    match folder.and_then(|folder| folder.to_str()) {
        Some("examples") if is_by_cargo => {
            let name = in_shell(Path::new(name));
            return format!("cargo run --release --example {name} --");
        }
        Some("release" | "debug") if is_by_cargo => return "cargo run --release --".to_owned(),
        _ => {}
    }
    let is_there = |folder: &Path| folder.join(program.file_name().unwrap_or_default()) == program;
    let path = env::var_os("PATH").unwrap_or_default();
    // An installer's start script gets the whole path of a program that the user called by its name.
    match env::split_paths(&path).any(|folder| is_there(&folder)) {
        true => in_shell(Path::new(name)),
        false => in_shell(program),
    }
}

/// The environment variable that chooses narrower SIMD registers than the machine has.
const SIMD: &str = "COSMIC_SIMD";

/// Limits this process to the registers that the environment asks for.
///
/// # Errors
/// [`Error::Usage`] for registers that the machine does not have, and if the process has already computed with others.
fn limit_registers() -> Result<()> {
    let Some(wanted) = env::var_os(SIMD) else {
        return Ok(());
    };
    let (wanted, there) = (wanted.to_string_lossy(), simd::levels());
    let Some(&level) = there.iter().find(|level| level.name() == wanted) else {
        let names: Vec<&str> = there.iter().map(|level| level.name()).collect();
        let names = names.join(", ");
        return Err(Error::Usage(format!(
            "the environment variable {SIMD} is `{wanted}`; this machine has: {names}"
        )));
    };
    match simd::limit(level) {
        now if now == level => Ok(()),
        now => Err(Error::Usage(format!(
            "the environment variable {SIMD} is `{wanted}`, but this process already computes with {}",
            now.name()
        ))),
    }
}

/// Prints the text of a command line that is not run: help or the version (exit code 0), or the mistake in the
/// arguments (exit code 2).
fn refuse(request: &clap::Error) -> u8 {
    let shown = request.print();
    if request.use_stderr() {
        return 2;
    }
    exit_code(written(shown))
}

/// Returns the exit code of a command's result. Prints the error if there is one.
fn exit_code(done: Result<()>) -> u8 {
    let Err(error) = done else {
        return 0;
    };
    complain(&error);
    error.exit_code()
}

/// Makes the code blocks of README.md doc tests of this crate.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
