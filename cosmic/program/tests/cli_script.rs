//! `cosmic sweep script`: tests that the scripts are valid and do the runs.
#![cfg(unix)]

use crate::background::signal;
use crate::common::{Bench, scene};
use crate::program::has;
use std::fs;
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Output};

/// Makes a test folder with a sweep of five runs, of which run 1 is done.
fn bench() -> Bench {
    let bench = Bench::with(&scene(24, 64, ""));
    let plan = "sweep plan tiny.toml --seeds 5 --iterations 3 --out s";
    bench.ok(plan);
    bench.ok("sweep run s --index 1");
    bench
}

/// A shell in the test folder. The program and the folder `bin` of the test folder are on its path.
fn shell(bench: &Bench, arguments: &[&str]) -> Command {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_cosmic"));
    let path = std::env::var("PATH").unwrap();
    let folders = [&bench.path("bin"), program.parent().unwrap()].map(|p| p.display().to_string());
    let mut command = Command::new("bash");
    command.args(arguments).current_dir(bench.path(""));
    command.env("PATH", format!("{}:{path}", folders.join(":")));
    command
}

fn bash(bench: &Bench, arguments: &[&str]) -> Output {
    shell(bench, arguments).output().unwrap()
}

/// Writes a script and checks its syntax.
fn script(bench: &Bench, options: &str) -> String {
    let line = format!("sweep script s {options} --out script");
    assert_eq!(bench.ok(&line).out, "script\n");
    let read = bash(bench, &["-n", "script"]);
    assert!(read.status.success(), "{options}: {read:?}");
    bench.read("script")
}

#[test]
fn a_script_for_slurm_is_an_array_over_the_unfinished_runs() {
    let bench = bench();
    let text = script(&bench, "--slurm");
    for line in [
        "# The unfinished runs of the sweep s, 4 of 5, in 4 tasks.",
        "#SBATCH --array=0,2-4",
        "#SBATCH --cpus-per-task=1",
        "#SBATCH --signal=B:TERM@60",
        "#SBATCH --output=s/logs/%a.log",
        "cosmic sweep run s --index \"$index\" --threads 1 &",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}: {text}");
    }
    assert!(bench.path("s/logs").is_dir());
    assert!(!text.contains("--time"));
    let text = script(&bench, "--slurm --throttle 3 --minutes 90 --cores 2");
    for line in [
        "#SBATCH --array=0-2%3",
        "#SBATCH --time=90",
        "#SBATCH --cpus-per-task=2",
        "first=$((task * 2))",
    ] {
        assert!(text.lines().any(|l| l == line), "{line}: {text}");
    }
}

/// The last task may have fewer runs than the others. If a run fails, its task exits with the code of that run.
#[test]
fn a_task_does_its_runs_and_exits_with_their_error() {
    let bench = bench();
    script(&bench, "--slurm --seeds-per-task 3");
    let mut task = shell(&bench, &["script"]);
    let output = task.env("SLURM_ARRAY_TASK_ID", "1").output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let told = bench.cosmic("sweep status s --json").json();
    assert_eq!(
        (&told["left"], &told["counts"]["done"]),
        (&"0,2".into(), &3.into())
    );
    bench.remove("s/runs/tiny-1/summary.json");
    bench.write("s/runs/tiny-1/snapshot.json", "{");
    let output = shell(&bench, &["script"])
        .env("SLURM_ARRAY_TASK_ID", "0")
        .output();
    assert_eq!(output.unwrap().status.code(), Some(2));
}

#[test]
fn a_task_that_is_terminated_saves_its_run_and_queues_again() {
    let bench = Bench::with(&scene(400, 2048, ""));
    bench.ok("sweep plan tiny.toml --seeds 2 --out s");
    script(&bench, "--slurm");
    fs::create_dir(bench.path("bin")).unwrap();
    bench.write("bin/scontrol", "#!/bin/sh\necho \"$@\" >queued\n");
    fs::set_permissions(bench.path("bin/scontrol"), PermissionsExt::from_mode(0o755)).unwrap();
    let mut task = shell(&bench, &["script"]);
    task.envs([("SLURM_ARRAY_JOB_ID", "7"), ("SLURM_ARRAY_TASK_ID", "1")]);
    let mut task = task.spawn().unwrap();
    bench.await_lines("s/runs/tiny-1/history.jsonl", 0);
    signal(&task, "TERM");
    assert_eq!(task.wait().unwrap().code(), Some(75));
    assert_eq!(bench.read("queued"), "requeue 7_1\n");
    let told = bench.cosmic("sweep status s --json").json();
    assert_eq!(told["runs"][1]["state"], "begun");
}

#[test]
fn a_script_for_parallel_does_the_unfinished_runs() {
    let bench = bench();
    let text = script(&bench, "--parallel --throttle 2 --minutes 3");
    has(&text, &["printf '%s\\n' 0 {2..4} | parallel --jobs 2 "]);
    has(&text, &["--kill-after=60 120 cosmic sweep run s "]);
    let there = Command::new("parallel").arg("--version").output();
    if !there.is_ok_and(|told| String::from_utf8_lossy(&told.stdout).starts_with("GNU parallel")) {
        let says = "SKIPPED: no GNU parallel here: the script for it is not run\n";
        // Written directly to standard error, because the test harness hides what passing tests print.
        io::stderr().write_all(says.as_bytes()).unwrap();
        return;
    }
    let output = bash(&bench, &["script"]);
    assert!(output.status.success(), "{output:?}");
    let told = bench.cosmic("sweep status s --json").json();
    assert_eq!(
        (&told["left"], &told["counts"]["done"]),
        (&"".into(), &5.into())
    );
    // The log has a header and one line per task.
    assert_eq!(bench.lines("s/logs/parallel.tsv"), 5);
    assert!(bench.read("s/logs/2.log").contains("run 2, tiny seed 2: "));
    let nothing = bench.cosmic("sweep script s --parallel");
    nothing.fails(2, &["s: all runs are finished"]);
}

#[test]
fn a_manifest_for_kubernetes_is_a_complete_job() {
    let bench = bench();
    let line = "sweep script s --kubernetes --throttle 3 --cores 2 --seeds-per-task 1 --minutes 10";
    let text = bench.ok(line).out;
    let job: serde_json::Value = serde_yaml_ng::from_str(&text).unwrap();
    assert_eq!(
        (&job["apiVersion"], &job["kind"]),
        (&"batch/v1".into(), &"Job".into())
    );
    let spec = &job["spec"];
    assert_eq!(spec["completionMode"], "Indexed");
    assert_eq!(
        (&spec["completions"], &spec["parallelism"]),
        (&4.into(), &3.into())
    );
    let interrupted = &spec["podFailurePolicy"]["rules"][0];
    assert_eq!(interrupted["action"], "Ignore");
    assert_eq!(
        interrupted["onExitCodes"]["values"],
        serde_json::json!([75])
    );
    let pod = &spec["template"]["spec"];
    assert_eq!(pod["restartPolicy"], "Never");
    let container = &pod["containers"][0];
    assert_eq!(
        interrupted["onExitCodes"]["containerName"],
        container["name"]
    );
    assert_eq!(container["resources"]["limits"]["cpu"], "2");
    // The script of the container does the unfinished runs. Each pod does one of them.
    let task = container["args"][0].as_str().unwrap();
    for pod in ["0", "3"] {
        let mut sh = shell(&bench, &["-c", task]);
        let output = sh.env("JOB_COMPLETION_INDEX", pod).output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
    let told = bench.cosmic("sweep status s --json").json();
    assert_eq!(told["left"], "2-3");
}

#[test]
fn wrong_options_for_scripts_are_refused() {
    let bench = bench();
    for (options, says) in [
        ("", "--slurm|--parallel|--kubernetes"),
        ("--slurm --kubernetes", "cannot be used with"),
        (
            "--slurm --minutes 1",
            "expected a whole number from 2 to 1000000",
        ),
        ("--slurm --throttle 0", "expected a whole number, 1 or more"),
    ] {
        let line = format!("sweep script s {options}");
        bench.fails(&line, 2, &[says]);
    }
}

/// The path of a task's log file, as a Slurm script states it. The directive is read in the way Slurm reads it: first
/// quotes and backslashes, then `%`.
fn slurm_log(text: &str, task: &str) -> String {
    let lines = text.lines();
    let mut values = lines.filter_map(|line| line.strip_prefix("#SBATCH --output="));
    let value = values.next().unwrap();
    let (mut word, mut quote, mut rest) = (String::new(), None, value.chars());
    while let Some(c) = rest.next() {
        match (c, quote) {
            ('\\', _) => word.extend(rest.next()),
            (c, Some(open)) if c == open => quote = None,
            ('\'' | '"', None) => quote = Some(c),
            (c, None) if c.is_whitespace() || c == '#' => break,
            (c, _) => word.push(c),
        }
    }
    // If a backslash remained, Slurm would not replace `%`.
    assert!(quote.is_none() && !word.contains('\\'), "{value}");
    let mut path = String::new();
    let mut rest = word.chars();
    while let Some(c) = rest.next() {
        match c {
            '%' => match rest.next() {
                Some('a') => path += task,
                Some('%') => path.push('%'),
                other => panic!("%{other:?} in {word}"),
            },
            c => path.push(c),
        }
    }
    path
}

/// Folder names with characters that are special in a shell, Slurm, YAML or Kubernetes.
const ODD: [&str; 10] = [
    "half%a",
    "it's 100%",
    "a#b \"c\"",
    "x=1+y:2",
    "$$ $(HOME) `id`",
    "-s & {} ;*?",
    "back\\slash",
    "my hetjob",
    "tab\tand\nline",
    "\u{e9}t\u{e9}~!",
];

/// Makes a test folder with a sweep of one run. The sweep's folder has the name `name`.
fn named(name: &str) -> Bench {
    let bench = Bench::with(&scene(24, 64, ""));
    let plan = "sweep plan tiny.toml --seeds 1 --iterations 2 --out s";
    bench.ok(plan);
    fs::rename(bench.path("s"), bench.path(name)).unwrap();
    bench
}

/// Returns the output of `sweep script` for the sweep in folder `name`. The name may contain spaces, so it is passed as
/// one argument.
fn script_of(bench: &Bench, name: &str, kind: &str) -> crate::program::Told {
    let mut command = crate::program::command("sweep script");
    command.args([kind, "--"]).arg(name);
    crate::program::Told::of(command.current_dir(bench.path("")).output().unwrap())
}

/// Checks that the only run is done and that its log is in the sweep's folder.
fn assert_done(bench: &Bench, name: &str, log: &str) {
    let folder = bench.path(name);
    assert!(folder.join("runs/tiny-0/summary.json").exists(), "{name:?}");
    let text = fs::read_to_string(folder.join(log)).unwrap();
    assert!(text.contains("run 0, tiny seed 0: "), "{name:?}: {text}");
    let entries = fs::read_dir(bench.path("")).unwrap().count();
    assert_eq!(entries, 2, "{name:?}: a stray file");
}

#[test]
fn slurm_finds_folders_of_any_name() {
    for name in ODD {
        let bench = named(name);
        let text = script_of(&bench, name, "--slurm").ok().out;
        let log = slurm_log(&text, "0");
        let mut task = shell(&bench, &["-c", &text]);
        // Slurm itself opens the log before it starts the task.
        if log != "/dev/null" {
            assert_eq!(log.trim_start_matches("./"), format!("{name}/logs/0.log"));
            let log = fs::File::create(bench.path(&log)).unwrap();
            task.stdout(log);
        }
        let output = task.env("SLURM_ARRAY_TASK_ID", "0").output().unwrap();
        assert!(output.status.success(), "{name:?}: {output:?}");
        assert_done(&bench, name, "logs/0.log");
    }
    let plain = named("half%a");
    let text = script_of(&plain, "half%a", "--slurm").ok().out;
    has(&text, &["#SBATCH --output=half%%a/logs/%a.log\n"]);
}

/// Expands container arguments as Kubernetes does: `$$` is a dollar sign, and `$(NAME)` is replaced if a variable
/// with this name exists.
fn expanded(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('$') {
        out += before;
        rest = match after.strip_prefix('$') {
            Some(after) => {
                out.push('$');
                after
            }
            None if after.starts_with("(HOME)") => &after["(HOME)".len()..],
            None => {
                out.push('$');
                after
            }
        };
    }
    out + rest
}

#[test]
fn kubernetes_finds_folders_of_any_name() {
    for name in ODD {
        let bench = named(name);
        let told = script_of(&bench, name, "--kubernetes");
        if name.contains(char::is_control) {
            told.fails(
                2,
                &["has a control character in its name", "rename the folder"],
            );
            continue;
        }
        let job: serde_json::Value = serde_yaml_ng::from_str(&told.ok().out).unwrap();
        let label = job["metadata"]["name"].as_str().unwrap();
        let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        assert!(label.chars().all(is_part) && !label.ends_with('-') && label.len() < 64);
        let container = &job["spec"]["template"]["spec"]["containers"][0];
        let task = expanded(container["args"][0].as_str().unwrap());
        let mut sh = shell(&bench, &["-c", &task]);
        let output = sh.env("JOB_COMPLETION_INDEX", "0").output().unwrap();
        assert!(output.status.success(), "{name:?}: {output:?}");
        assert_done(&bench, name, "logs/0.log");
    }
}

/// A stand-in for GNU parallel: like `parallel`, it runs a command in a shell for each line.
const STAND_IN: &str = "#!/bin/bash\nwhile [ \"$1\" != task ]; do shift; done\n\
    while read -r line; do bash -c \"task $line\"; done\n";

#[test]
fn parallel_finds_folders_of_any_name() {
    for name in ODD {
        let bench = named(name);
        let text = script_of(&bench, name, "--parallel").ok().out;
        let tools = tempfile::tempdir().unwrap();
        let parallel = tools.path().join("parallel");
        fs::write(&parallel, STAND_IN).unwrap();
        fs::set_permissions(&parallel, PermissionsExt::from_mode(0o755)).unwrap();
        let mut task = shell(&bench, &["-c", &text]);
        let path = task.get_envs().find(|(key, _)| *key == "PATH").unwrap().1;
        let path = format!(
            "{}:{}",
            tools.path().display(),
            path.unwrap().to_str().unwrap()
        );
        let output = task.env("PATH", path).output().unwrap();
        assert!(output.status.success(), "{name:?}: {output:?}");
        assert_done(&bench, name, "logs/0.log");
    }
}
