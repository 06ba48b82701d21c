//! Programs of Python that use MuJoCo.

use crate::child::Printing;
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

/// Runs a program and returns its standard output. Returns `None` if the program was stopped because `is_stopped`
/// returned true.
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
    let printing = Printing::of(&mut child);
    let status = loop {
        if let Some(status) = ended(&mut child)? {
            break status;
        }
        if is_stopped() {
            // One that has just ended by itself is as good.
            let _ = child.kill();
            let _ = child.wait();
            return Ok(None);
        }
        thread::sleep(LOOK);
    };
    let printed = printing.end();
    if status.success() {
        return Ok(Some(printed.out));
    }
    // Interrupts from the keyboard reach it as well.
    if is_stopped() {
        return Ok(None);
    }
    Err(failed(&printed.reason()))
}

#[cfg(all(test, unix))]
mod tests {
    use super::run;
    use std::cell::Cell;
    use std::path::Path;
    use std::time::{Duration, Instant};

    /// Runs a shell script; `bash` takes `-c` as Python does.
    fn shell(
        program: &str,
        is_stopped: &dyn Fn() -> bool,
    ) -> cosmic::error::Result<Option<Vec<u8>>> {
        run(Path::new("bash"), program, &[], is_stopped)
    }

    /// Stops a program that still runs after a minute, so that the test fails instead of hanging.
    fn patience() -> impl Fn() -> bool {
        let began = Instant::now();
        move || began.elapsed() > Duration::from_secs(60)
    }

    #[test]
    fn a_program_may_print_more_than_pipes_hold() {
        let much = "head -c 3000000 /dev/zero | tr '\\0' x";
        let both = format!("{much} >&2; {much}; {much} >&2");
        let out = shell(&both, &patience()).unwrap().expect("it ends");
        assert_eq!(out, vec![b'x'; 3_000_000]);
        let fails = format!("{much}; {much} >&2; echo; echo reason >&2; exit 1");
        let error = shell(&fails, &patience()).unwrap_err();
        assert!(error.to_string().ends_with("reason"), "a long message");
    }

    #[test]
    fn a_program_is_stopped_while_it_prints() {
        let looks = Cell::new(0);
        let is_stopped = || {
            looks.set(looks.get() + 1);
            looks.get() > 3
        };
        assert_eq!(
            shell("while true; do echo x; done", &is_stopped).unwrap(),
            None
        );
        // A grandchild process may keep the pipes open.
        looks.set(0);
        assert_eq!(shell("sleep 5 & wait", &is_stopped).unwrap(), None);
    }
}
