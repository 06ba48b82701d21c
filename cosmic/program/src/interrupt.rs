//! Handles Ctrl-C, SIGTERM, SIGHUP and SIGUSR1, the signal of schedulers before the time of a job is up. The first signal
//! asks a run to stop, the second one ends the process at once.

use crate::output::note;
use cosmic::error::{Error, Result};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Starts to listen for the signals, and returns a flag that the first signal sets. Unless `quiet` is true, the first
/// signal prints a note, except SIGUSR1.
///
/// # Errors
/// [`Error::Usage`] if the signal handler cannot be installed.
pub(super) fn listen(quiet: bool) -> Result<Arc<AtomicBool>> {
    let asked = Arc::new(AtomicBool::new(false));
    let heard = Arc::clone(&asked);
    let on_signal = move || {
        if heard.swap(true, Ordering::Relaxed) {
            // Ending at once loses little: the run can be resumed from its last snapshot.
            process::exit(75);
        }
        if !quiet {
            note(
                "stopping: what is running is saved after its current time step, so that it can be resumed; press \
                 Ctrl-C again to end now",
            );
        }
    };
    ctrlc::set_handler(on_signal)
        .map_err(|error| Error::Usage(format!("cannot install the signal handler: {error}")))?;
    #[cfg(unix)]
    listen_for_usr1(&asked)?;
    Ok(asked)
}

/// Lets SIGUSR1 do what the other signals do.
///
/// # Errors
/// [`Error::Usage`] if the signal handler cannot be installed.
#[cfg(unix)]
fn listen_for_usr1(asked: &Arc<AtomicBool>) -> Result<()> {
    use signal_hook::consts::SIGUSR1;
    use signal_hook::flag;
    // The first function ends the process if the flag is set already, so it must run first.
    flag::register_conditional_shutdown(SIGUSR1, 75, Arc::clone(asked))
        .and_then(|_| flag::register(SIGUSR1, Arc::clone(asked)))
        .map(|_| ())
        .map_err(|error| Error::Usage(format!("cannot install the signal handler: {error}")))
}
