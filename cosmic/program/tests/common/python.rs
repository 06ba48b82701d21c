//! Makes a virtual environment of Python, with the packages that run the files of `export`. It is made once, in the target
//! folder.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::LazyLock;

/// The packages of the environment.
const PACKAGES: [&str; 2] = ["mujoco==4.0.*", "numpy==2.*"];

/// The messages that `pip` prints if it cannot reach the registry.
const CUT_OFF: [&str; 3] = [
    "connection broken by",
    "Max retries exceeded",
    "Read timed out",
];

/// The path of the environment's Python, or the reason why there is none.
static PYTHON: LazyLock<Result<PathBuf, &str>> = LazyLock::new(make);

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

fn make() -> Result<PathBuf, &'static str> {
    let place = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = place.join("python");
    let (python, ready) = (folder.join("bin/python"), folder.join("ready"));
    // One process makes the environment, while other processes wait for the lock.
    let lock = File::create(place.join("python.lock")).unwrap();
    lock.lock().unwrap();
    let packages = PACKAGES.join(" ");
    if fs::read_to_string(&ready).is_ok_and(|known| known == packages) {
        return Ok(python);
    }
    let venv = ["-m", "venv", "--clear"];
    let made = Command::new("python3").args(venv).arg(&folder).output();
    let made = made.map_err(|_| "no python3 here")?;
    assert!(made.status.success(), "no environment: {}", words(&made));
    let pip = ["-m", "pip", "install", "--quiet", "--retries", "2"];
    let fetched = Command::new(&python).args(pip).args(PACKAGES).output();
    let fetched = fetched.unwrap();
    let is_cut_off = || CUT_OFF.iter().any(|says| words(&fetched).contains(says));
    if !fetched.status.success() && is_cut_off() {
        return Err("the registry of Python packages cannot be reached");
    }
    assert!(fetched.status.success(), "no packages: {}", words(&fetched));
    fs::write(ready, packages).unwrap();
    Ok(python)
}

fn words(output: &Output) -> String {
    let [out, error] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    format!("{out}{error}")
}
