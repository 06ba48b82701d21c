//! Runs on a disk whose file system refuses locks, as some network disks do. A claim keeps each run to one process.
#![cfg(target_os = "linux")]

use crate::background::signal;
use crate::common::Bench;
use crate::program::{Told, command, has};
use serde_json::{Value, json};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;

/// The library that refuses locks. `None` if the machine has no C compiler.
static LIBRARY: LazyLock<Option<PathBuf>> = LazyLock::new(|| {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/no_locks.c");
    let library = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no_locks.so");
    let mut compiler = Command::new("cc");
    let compiled = compiler
        .args(["-shared", "-fPIC", "-o"])
        .arg(&library)
        .arg(source)
        .status();
    match compiled {
        Ok(status) => assert!(status.success(), "cc cannot compile tests/no_locks.c"),
        Err(_) => {
            let says =
                b"SKIPPED: no C compiler `cc`: runs on a disk without locks are not tested\n";
            // Written directly, because the test harness hides what passing tests print.
            io::stderr().write_all(says).unwrap();
            return None;
        }
    }
    Some(library)
});

/// A test folder on a disk without locks.
struct NoLocks {
    bench: Bench,
    library: &'static Path,
}

/// The name of the first claim in the folder of a run.
const CLAIM: &str = ".cosmic-claim-1";

/// The beginning of the warning.
const REFUSES: &str = "the file system refuses locks";

impl NoLocks {
    /// `None` without a C compiler.
    fn new(bench: Bench) -> Option<Self> {
        let library = LIBRARY.as_deref()?;
        Some(Self { bench, library })
    }

    fn command(&self, line: &str) -> Command {
        let mut command = command(line);
        command.env("LD_PRELOAD", self.library);
        command.stderr(Stdio::piped()).stdout(Stdio::piped());
        command.current_dir(self.bench.path(""));
        command
    }

    fn start(&self, line: &str) -> Child {
        self.command(line).spawn().unwrap()
    }

    fn cosmic(&self, line: &str) -> Told {
        Told::of(self.command(line).output().unwrap())
    }

    /// Kills the run `a` after some iterations, and returns its claim.
    fn killed(&self) -> Value {
        let mut child = self.start("optimize tiny.toml --out a");
        self.bench.await_lines("a/history.jsonl", 13);
        child.kill().unwrap();
        child.wait().unwrap();
        self.bench.json(&format!("a/{CLAIM}"))
    }

    fn claim(&self, claim: &Value) {
        self.bench.write(&format!("a/{CLAIM}"), claim.to_string());
    }

    /// The names of the claims on the run `a`.
    fn claims(&self) -> Vec<String> {
        let files = fs::read_dir(self.bench.path("a")).unwrap();
        let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.contains("claim")).collect()
    }
}

/// A run that is long enough to be killed.
fn slow() -> Bench {
    Bench::new(100, 512)
}

fn warnings(told: &Told) -> usize {
    told.error.matches(REFUSES).count()
}

#[test]
fn each_run_of_two_sweeps_in_one_folder_has_one_process() {
    let Some(disk) = NoLocks::new(Bench::default()) else {
        return;
    };
    let line = |out: &str| format!("sweep run tiny.toml --seeds 4 --threads 1 --out {out}");
    let both = [(); 2].map(|()| disk.start(&line("twice")));
    for told in both.map(|child| Told::of(child.wait_with_output().unwrap())) {
        // A process that began all of its runs after the other had finished them has nothing to warn about.
        assert!(warnings(&told.ok()) <= 1);
    }
    let once = disk.bench.ok(&line("once"));
    assert_eq!(warnings(&once), 0);
    for seed in 0..4 {
        let rows = disk
            .bench
            .rows(&format!("twice/runs/tiny-{seed}/history.jsonl"));
        assert_eq!(rows.len(), 24);
    }
    let [twice, once] = ["twice", "once"].map(|name| disk.bench.results(&format!("{name}/runs")));
    assert_eq!(twice, once);
}

#[test]
fn the_refusal_is_said_once() {
    let Some(disk) = NoLocks::new(Bench::default()) else {
        return;
    };
    for line in [
        "optimize tiny.toml --out one",
        "optimize tiny.toml --out several --starts 2",
        "sweep run tiny.toml --seeds 2 --out sweep",
    ] {
        assert_eq!(warnings(&disk.cosmic(line).ok()), 1, "{line}");
    }
    // ENOSYS and EOPNOTSUPP are the errors of other file systems.
    for (number, name) in [("38", "first"), ("95", "second")] {
        let mut command = disk.command(&format!("optimize tiny.toml --out {name}"));
        let told = Told::of(command.env("ERRNO", number).output().unwrap()).ok();
        has(
            &told.error,
            &[REFUSES, &format!("(os error {number})"), CLAIM],
        );
    }
}

#[test]
fn a_run_belongs_to_one_process() {
    let Some(disk) = NoLocks::new(slow()) else {
        return;
    };
    let owner = disk.start("optimize tiny.toml --out a");
    disk.bench.await_lines("a/history.jsonl", 13);
    let says = "error: a: another process is running this run\n";
    for line in ["resume a", "resume a --allow-unstable"] {
        let told = disk.cosmic(line);
        assert_eq!((told.code, &told.error[..]), (2, says));
    }
    // A process that stops gives the run free, also for other hosts.
    signal(&owner, "TERM");
    assert_eq!(owner.wait_with_output().unwrap().status.code(), Some(75));
    assert!(disk.claims().is_empty());
    disk.cosmic("resume a").ok();
    disk.bench.run("whole", "");
    assert_eq!(disk.bench.results("a"), disk.bench.results("whole"));
}

#[test]
fn a_killed_run_continues_on_its_host() {
    let Some(disk) = NoLocks::new(slow()) else {
        return;
    };
    let claim = disk.killed();
    assert_eq!(warnings(&disk.cosmic("resume a").ok()), 1);
    assert!(disk.claims().is_empty());
    disk.bench.run("whole", "");
    assert_eq!(disk.bench.results("a"), disk.bench.results("whole"));
    // The number of a dead process may belong to another one, which started later.
    fs::remove_file(disk.bench.path("a/summary.json")).unwrap();
    let mut again = claim.clone();
    again["process"] = std::process::id().into();
    disk.claim(&again);
    disk.cosmic("resume a --quiet").ok();
    assert_eq!(disk.bench.results("a"), disk.bench.results("whole"));
    // The claim of a process that lives is kept.
    fs::remove_file(disk.bench.path("a/summary.json")).unwrap();
    let stat = fs::read_to_string("/proc/self/stat").unwrap();
    let after_name = stat.rsplit_once(") ").unwrap().1;
    let started: u64 = after_name.split(' ').nth(19).unwrap().parse().unwrap();
    again["started"] = started.into();
    disk.claim(&again);
    disk.cosmic("resume a")
        .fails(2, &["a: another process is running this run"]);
}

#[test]
fn the_claim_of_another_host_is_removed_by_a_person() {
    let Some(disk) = NoLocks::new(slow()) else {
        return;
    };
    let mut claim = disk.killed();
    claim["host"] = json!("elsewhere");
    claim["process"] = json!(7);
    disk.claim(&claim);
    let remedy = "if that process has ended, remove its claim with: rm a/.cosmic-claim-1\n";
    let told = disk.cosmic("resume a");
    told.fails(
        2,
        &[
            "a: the process 7 of the host \"elsewhere\" claims this run",
            remedy,
        ],
    );
    for unknown in ["", "{\"host\":\"el"] {
        disk.bench.write(&format!("a/{CLAIM}"), unknown);
        disk.cosmic("resume a")
            .fails(2, &["a process that its claim does not name", remedy]);
    }
    let (_, command) = told.error.trim_end().split_once("with: ").unwrap();
    let mut shell = Command::new("sh");
    let removed = shell
        .args(["-c", command])
        .current_dir(disk.bench.path(""))
        .status();
    assert!(removed.unwrap().success());
    disk.cosmic("resume a").ok();
    disk.bench.run("whole", "");
    assert_eq!(disk.bench.results("a"), disk.bench.results("whole"));
}

#[test]
fn a_sweep_names_the_claims_of_other_hosts() {
    let Some(disk) = NoLocks::new(Bench::default()) else {
        return;
    };
    let line = "sweep run tiny.toml --seeds 2 --out s";
    disk.cosmic(line).ok();
    fs::remove_file(disk.bench.path("s/runs/tiny-1/summary.json")).unwrap();
    let claim = json!({ "host": "elsewhere", "process": 7, "started": 1 });
    disk.bench
        .write(&format!("s/runs/tiny-1/{CLAIM}"), claim.to_string());
    let remedy = "remove its claim with: rm s/runs/tiny-1/.cosmic-claim-1\n";
    let told = disk.cosmic(line).ok();
    has(
        &told.error,
        &["other processes are doing 1 of 2 runs", remedy],
    );
    disk.cosmic(&format!("{line} --index 1"))
        .fails(2, &[remedy]);
    fs::remove_file(disk.bench.path(&format!("s/runs/tiny-1/{CLAIM}"))).unwrap();
    disk.cosmic(line).ok();
    assert!(disk.bench.path("s/runs/tiny-1/summary.json").exists());
}
