//! Claims: they keep a run to one process where the file system refuses locks, as some network disks do.
//!
//! A claim is a file that must be new. If several processes create the file at once, one of them succeeds. The file
//! names its process. So a claim of a dead process of this host does not count, whatever killed it. Whether a process of
//! another host lives cannot be known, so only a person can remove its claim.
//!
//! No process removes the claim of another one: of two that find a dead claim, the slower one could remove the new claim
//! of the faster one. Instead, the next process creates a claim with the next number. The highest number counts.

use crate::error::{Error, Result, in_shell};
use crate::record::files::CLAIM;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{process, thread};

/// The number of attempts to lock or claim a folder. A single attempt may fail by chance: if another thread starts a child
/// process, the child holds a copy of every lock for a moment.
pub(super) const TRIES: usize = 5;
/// The pause after a failed attempt.
pub(super) const PAUSE: Duration = Duration::from_millis(10);

/// A claim of this process on a folder. The file is removed when this value is dropped.
#[derive(Debug)]
pub(super) struct Claim {
    pub(super) file: PathBuf,
}

/// The process that made a claim: the content of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Owner {
    /// The name of the machine; empty if it is not known.
    host: String,
    /// The number of the process.
    process: u32,
    /// The time at which the process started, in the unit of the operating system. Numbers of processes are used again,
    /// but not at the same time. `None` if it is not known.
    started: Option<u64>,
}

impl Claim {
    /// Claims an existing folder.
    pub(super) fn take(folder: &Path) -> Result<Self> {
        for _ in 0..TRIES {
            let number = match numbers(folder).map_err(Error::reading(folder))?.last() {
                None => 1,
                Some(last) => match owner(&file_of(folder, *last)) {
                    Ok(owner) if owner.is_dead() => last + 1,
                    Ok(owner) if owner.is_known() => return Err(Error::Taken(folder.to_owned())),
                    // A process that has just created its claim may not have written it yet.
                    Err(error) if error.kind() != ErrorKind::NotFound => {
                        thread::sleep(PAUSE);
                        continue;
                    }
                    // The owner has just released the folder.
                    Err(_) => continue,
                    Ok(_) => break,
                },
            };
            let claim = file_of(folder, number);
            match File::create_new(&claim) {
                Ok(mut file) => {
                    let claim = Self { file: claim };
                    let written = serde_json::to_vec(&Owner::this()).map_err(io::Error::from);
                    let written = written.and_then(|owner| file.write_all(&owner));
                    let written = written.and_then(|()| file.sync_all());
                    return written.map(|()| claim).map_err(Error::writing(folder));
                }
                // Another process was faster.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => thread::sleep(PAUSE),
                Err(error) => return Err(Error::writing(folder)(error)),
            }
        }
        Err(claimed(folder).unwrap_or_else(|| Error::Taken(folder.to_owned())))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // A claim that cannot be removed is that of a dead process soon.
        let _ = fs::remove_file(&self.file);
    }
}

/// If the folder of a run is claimed by a process that may be dead, which cannot be known on this host, returns the error
/// that says how to remove the claim.
pub fn claimed(folder: &Path) -> Option<Error> {
    let numbers = numbers(folder).ok()?;
    let owner = owner(&file_of(folder, *numbers.last()?)).ok();
    if owner.as_ref().is_some_and(Owner::is_known) {
        return None;
    }
    let files = numbers
        .iter()
        .map(|number| in_shell(&file_of(folder, *number)));
    Some(Error::Claimed {
        run: folder.to_owned(),
        by: owner.map_or(
            "a process that its claim does not name".to_owned(),
            |owner| {
                let Owner { host, process, .. } = owner;
                match &host[..] {
                    "" => format!("the process {process} of an unknown host"),
                    host => format!("the process {process} of the host {host:?}"),
                }
            },
        ),
        remove: files.collect::<Vec<_>>().join(" "),
    })
}

/// Removes all claims on the folder of a finished run.
pub(super) fn remove_all(folder: &Path) {
    for number in numbers(folder).into_iter().flatten() {
        // A claim that is left behind does no harm.
        let _ = fs::remove_file(file_of(folder, number));
    }
}

fn file_of(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("{CLAIM}{number}"))
}

/// The numbers of the claims on a folder, in ascending order.
fn numbers(folder: &Path) -> io::Result<Vec<u64>> {
    let mut numbers = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        let number = name
            .to_str()
            .and_then(|name| name.strip_prefix(CLAIM)?.parse::<u64>().ok());
        numbers.extend(number);
    }
    numbers.sort_unstable();
    Ok(numbers)
}

fn owner(file: &Path) -> io::Result<Owner> {
    Ok(serde_json::from_slice(&fs::read(file)?)?)
}

impl Owner {
    /// This process.
    fn this() -> Self {
        let id = process::id();
        Self {
            host: fs::read_to_string("/proc/sys/kernel/hostname")
                .map_or(String::new(), |name| name.trim().to_owned()),
            process: id,
            started: started(id),
        }
    }

    /// Whether this host can say if the process lives.
    fn is_known(&self) -> bool {
        let this = Self::this();
        !this.host.is_empty()
            && self.host == this.host
            && self.started.is_some()
            && this.started.is_some()
    }

    /// True if the process is known to be dead. Its number may belong to another process now.
    fn is_dead(&self) -> bool {
        self.is_known() && started(self.process) != self.started
    }
}

/// The time at which a process of this host started, in ticks of the kernel since the start of the machine. `None` if the
/// process is dead, and on other systems than Linux.
fn started(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the program, in parentheses, may contain spaces and parentheses.
    let mut fields = status.rsplit_once(") ")?.1.split(' ');
    // Field 3 is the state. A zombie is dead, but its parent has not asked for its exit code yet.
    let is_dead = matches!(fields.next()?, "Z" | "X" | "x");
    // Field 22 is the time of the start.
    let started = fields.nth(18)?.parse().ok()?;
    (!is_dead).then_some(started)
}
