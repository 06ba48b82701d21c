//! The tests' virtual environment of Python, with the packages that run the files of `export`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

/// The packages of the environment.
const PACKAGES: [&str; 2] = ["mujoco==4.0.*", "numpy==2.*"];

/// The path of the environment's Python, or the reason why there is none.
static PYTHON: LazyLock<Result<PathBuf, String>> = LazyLock::new(make);

/// The path of a Python with the packages. Prints a message and returns `None` if the machine has no Python or cannot
/// reach the registry. Panics on other errors.
pub(crate) fn python() -> Option<&'static Path> {
    match &*PYTHON {
        Ok(python) => Some(python),
        Err(why) => {
            let says = format!("SKIPPED: {why}: the files of `cosmic export` are not run\n");
            // The text is written to standard error directly, because the test harness hides what passing tests print.
            io::stderr().write_all(says.as_bytes()).unwrap();
            None
        }
    }
}

fn make() -> Result<PathBuf, String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../python/environment.sh");
    let made = Command::new(script).args(PACKAGES).output();
    let made = made.map_err(|error| format!("no python/environment.sh: {error}"))?;
    let errors = String::from_utf8_lossy(&made.stderr).trim().to_owned();
    if made.status.code() == Some(3) {
        return Err(errors);
    }
    assert!(made.status.success(), "no environment: {errors}");
    let python = String::from_utf8(made.stdout).unwrap();
    Ok(PathBuf::from(python.trim_end()))
}
