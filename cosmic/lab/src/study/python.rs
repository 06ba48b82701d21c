//! Programs of Python that use MuJoCo.

use cosmic::error::{Error, Result, in_shell};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

/// How often a program at work is looked at.
const LOOK: Duration = Duration::from_millis(20);

/// Checks that a Python has MuJoCo.
///
/// # Errors
/// [`Error::Usage`], with the remedy.
pub(super) fn check(python: &Path) -> Result<()> {
    let found = run(python, "import mujoco, numpy", &[], &|| false);
    found.map(drop).map_err(|error| {
        Error::Usage(format!(
            "{error}; make an environment that has MuJoCo, by: python3 -m venv mujoco && \
             mujoco/bin/pip install mujoco numpy, and name its Python: --python mujoco/bin/python"
        ))
    })
}

/// What a program writes to its standard output, which it may fill little by little: less than the 64 KiB
/// that a pipe holds. `None` if it was ended because `is_stopped` said so.
///
/// # Errors
/// [`Error::Usage`] where it cannot be started or fails.
pub(super) fn run(
    python: &Path,
    program: &str,
    arguments: &[String],
    is_stopped: &dyn Fn() -> bool,
) -> Result<Option<Vec<u8>>> {
    let failed = |says: &str| Error::Usage(format!("{}: {says}", in_shell(python)));
    // Many programs run side by side: each has one thread. It leaves no compiled files behind.
    let started = Command::new(python)
        .args(["-B", "-c", program])
        .args(arguments)
        .envs(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"].map(|name| (name, "1")))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = started.map_err(|error| failed(&error.to_string()))?;
    let ended = |child: &mut Child| child.try_wait().map_err(|error| failed(&error.to_string()));
    while ended(&mut child)?.is_none() {
        if is_stopped() {
            // One that has just ended by itself is as good.
            let _ = child.kill();
            let _ = child.wait();
            return Ok(None);
        }
        thread::sleep(LOOK);
    }
    let output = child.wait_with_output();
    let output = output.map_err(|error| failed(&error.to_string()))?;
    if output.status.success() {
        return Ok(Some(output.stdout));
    }
    // Interrupts from the keyboard reach it as well.
    if is_stopped() {
        return Ok(None);
    }
    let told = String::from_utf8_lossy(&output.stderr);
    let last = told.lines().rev().find(|line| !line.trim().is_empty());
    Err(failed(last.unwrap_or("it failed and does not say why")))
}
