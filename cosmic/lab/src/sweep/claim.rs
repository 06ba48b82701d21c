//! Claims make sure that at most one process at a time works on a run, even if processes on several hosts share the
//! sweep's folder.
//!
//! The K-th claim of the run NAME is the file `claims/NAME/K`. Only one process can create it; this process holds the
//! claim. The file contains the holder's host and a count that the holder increases while it works. A process that
//! finds the holder gone creates the next file. On the holder's host, a lock on the file shows whether the holder still
//! runs. Other hosts watch whether the count still increases, and measure the time by their own clocks: network file
//! systems may lack locks, and clocks of hosts may differ.

use cosmic::error::{Error, Result};
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The times of claims.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// How often a holder increases its count.
    pub beat: Duration,
    /// After how long without an increase the holder counts as gone.
    pub gone_after: Duration,
}

/// The times that programs use. Tests use shorter times.
pub(super) const PACE: Pace = Pace {
    beat: Duration::from_secs(10),
    gone_after: Duration::from_secs(60),
};

/// The content that a holder writes into the file of a claim when it gives the claim back.
const FREE: &[u8] = b"free\n";

/// The name and the boot id of this host. If the system does not tell them (`None`), locks are not used.
static HOST: LazyLock<Option<String>> = LazyLock::new(|| {
    let read = |name: &str| fs::read_to_string(Path::new("/proc/sys/kernel").join(name)).ok();
    let parts = [read("hostname")?, read("random/boot_id")?];
    Some(parts.map(|part| part.trim().to_owned()).join(" "))
});

/// The claims of other hosts that this process watches. For each file of a claim, what this process has seen in it.
static SEEN: LazyLock<Mutex<HashMap<PathBuf, Seen>>> = LazyLock::new(Mutex::default);

struct Seen {
    content: Vec<u8>,
    /// The time of the last change of the content; without a change, the time when it was first seen.
    since: Instant,
    /// True if the content has changed since it was first seen.
    changed: bool,
}

/// The outcome of an attempt to claim a run, that is, to become the only process that works on it.
pub enum Answer {
    /// This process has claimed the run.
    Granted(Claim),
    /// Another process has claimed the run.
    Taken,
    /// A process on another host holds the claim. It is not known yet whether that process still works, so it must be
    /// watched for longer.
    Watched,
}

/// A claim that this process holds: no other process works on the run. Dropping the value gives the claim back.
pub struct Claim {
    is_lost: Arc<AtomicBool>,
    stop: Option<Sender<()>>,
    beating: Option<JoinHandle<()>>,
}

impl Claim {
    /// True once another process has taken over the run because this process did not increase its count in time.
    pub fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Relaxed)
    }
}

/// Tries to claim the run with the name `name`.
///
/// # Errors
/// [`Error::Write`] if the file of the claim cannot be written.
pub fn claim(sweep: &Path, name: &str, pace: Pace) -> Result<Answer> {
    let folder = sweep.join("claims").join(name);
    fs::create_dir_all(&folder).map_err(Error::writing(&folder))?;
    let last = last(&folder)?;
    if last > 0 {
        match holder(&numbered(&folder, last), pace)? {
            Holder::Gone => {}
            Holder::Works => return Ok(Answer::Taken),
            Holder::Unknown => return Ok(Answer::Watched),
        }
    }
    let own = last + 1;
    let path = numbered(&folder, own);
    let file = match OpenOptions::new().write(true).create_new(true).open(&path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => return Ok(Answer::Taken),
        opened => opened.map_err(Error::writing(&path))?,
    };
    // If the file cannot be locked, `host` is `None`, and other processes on this host watch the count too.
    let host = HOST.as_deref().filter(|_| file.try_lock().is_ok());
    let held = Held { path, file, host };
    held.write(0)?;
    // If this process is slow, other processes may already have created a later file.
    if self::last(&folder)? > own {
        let _ = fs::remove_file(&held.path);
        return Ok(Answer::Taken);
    }
    if last > 0 {
        // The old file may stay: only the file with the highest number counts.
        let _ = fs::remove_file(numbered(&folder, last));
    }
    Ok(Answer::Granted(Claim::new(held, folder, own, pace)))
}

fn numbered(folder: &Path, number: u64) -> PathBuf {
    folder.join(number.to_string())
}

/// The number of the last claim of a run; 0 if no process has ever claimed the run.
fn last(folder: &Path) -> Result<u64> {
    let mut last = 0;
    for entry in fs::read_dir(folder).map_err(Error::reading(folder))? {
        let file = entry.map_err(Error::reading(folder))?.file_name();
        let number = file.to_str().and_then(|number| number.parse().ok());
        last = last.max(number.unwrap_or(0));
    }
    Ok(last)
}

/// The file of a claim that this process holds. The system releases its lock when the process ends, even by a crash.
struct Held {
    path: PathBuf,
    file: File,
    /// The name and boot id of this host, as the holder of the lock; `None` if the file is not locked.
    host: Option<&'static str>,
}

impl Held {
    /// Writes the host and the count into the file. The length of the file stays the same, so that a reader sees either
    /// the old or the new content.
    fn write(&self, count: u64) -> Result<()> {
        let host = self.host.unwrap_or("-");
        let text = format!("{host}\n{} {count:020}\n", process::id());
        self.replace(text.as_bytes())
    }

    fn replace(&self, content: &[u8]) -> Result<()> {
        let mut file = &self.file;
        (file.seek(SeekFrom::Start(0)))
            .and_then(|_| file.write_all(content))
            .and_then(|()| file.set_len(content.len() as u64))
            .and_then(|()| file.sync_data())
            .map_err(Error::writing(&self.path))
    }
}

/// What is known about the process that holds a claim.
enum Holder {
    Works,
    Gone,
    /// Not known yet: the holder must be watched for longer.
    Unknown,
}

fn holder(path: &Path, pace: Pace) -> Result<Holder> {
    let mut file = match File::open(path) {
        // The file has just been removed by a process that took over the run. So a holder works.
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Holder::Works),
        opened => opened.map_err(Error::reading(path))?,
    };
    let mut content = Vec::new();
    file.read_to_end(&mut content)
        .map_err(Error::reading(path))?;
    if content == FREE {
        return Ok(Holder::Gone);
    }
    let host = content.split(|&byte| byte == b'\n').next();
    if HOST
        .as_deref()
        .is_some_and(|own| host == Some(own.as_bytes()))
    {
        // The system releases a holder's lock when the holder ends. So if the file can be locked, the holder has ended.
        return Ok(if file.try_lock_shared().is_ok() {
            Holder::Gone
        } else {
            Holder::Works
        });
    }
    let mut seen = SEEN.lock().unwrap_or_else(PoisonError::into_inner);
    let now = Instant::now();
    let before = seen.entry(path.to_owned()).or_insert_with(|| Seen {
        content: content.clone(),
        since: now,
        changed: false,
    });
    if before.content != content {
        (before.content, before.since, before.changed) = (content, now, true);
    }
    Ok(if now - before.since >= pace.gone_after {
        Holder::Gone
    } else if before.changed {
        Holder::Works
    } else {
        Holder::Unknown
    })
}

impl Claim {
    /// Starts a thread that increases the count in the claim's file until the claim is dropped.
    fn new(held: Held, folder: PathBuf, own: u64, pace: Pace) -> Self {
        let is_lost = Arc::new(AtomicBool::new(false));
        let (stop, stopped) = channel::<()>();
        let lost = Arc::clone(&is_lost);
        let beating = thread::spawn(move || {
            for count in 1.. {
                if stopped.recv_timeout(pace.beat) != Err(RecvTimeoutError::Timeout) {
                    break;
                }
                // Errors are ignored here: if the folder cannot be used, the run itself reports that.
                let _ = held.write(count);
                if last(&folder).is_ok_and(|last| last > own) {
                    lost.store(true, Ordering::Relaxed);
                    return;
                }
            }
            // If the claim cannot be given back, other processes still take over the run after a while.
            let _ = held.replace(FREE);
        });
        Self {
            is_lost,
            stop: Some(stop),
            beating: Some(beating),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(beating) = self.beating.take() {
            let _ = beating.join();
        }
    }
}
