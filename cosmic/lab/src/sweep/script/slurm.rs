//! A batch script for Slurm.

use super::task::{GRACE, HandOver, Tasks, command, index, title};
use cosmic::error::in_shell;

/// The file that receives the output of a task.
struct Output {
    file: String,
    /// The lines of the script that redirect the output to its file. They are empty if a Slurm directive can name the
    /// file.
    redirect: String,
}

/// Decides how the output of tasks gets into its file. A `#SBATCH` directive can name most files, but not all: Slurm
/// gives a special meaning to backslashes and to its words for heterogeneous jobs, and a directive ends at the end of
/// its line.
fn output(hand_over: &HandOver, tasks: &Tasks) -> Output {
    let sweep = hand_over.sweep.display().to_string();
    let lower = sweep.to_ascii_lowercase();
    let is_other = |c: char| c == '\\' || c.is_control();
    if sweep.contains(is_other)
        || ["hetjob", "packjob"]
            .iter()
            .any(|word| lower.contains(word))
    {
        let redirect = format!(
            "exec >>{}/logs/\"$SLURM_ARRAY_TASK_ID\".log 2>&1\n\n",
            tasks.sweep
        );
        return Output {
            file: "/dev/null".to_owned(),
            redirect,
        };
    }
    // In the directive, `%a` stands for the task's number and `%%` for a percent sign.
    let sweep = in_shell(sweep.replace('%', "%%").as_ref());
    Output {
        file: format!("{sweep}/logs/%a.log"),
        redirect: String::new(),
    }
}

pub(super) fn script(hand_over: &HandOver, tasks: &Tasks) -> String {
    let (title, index, command) = (
        title(hand_over, tasks),
        index(hand_over),
        command(hand_over, tasks),
    );
    let Tasks { numbers, name, .. } = tasks;
    let Output {
        file: output,
        redirect,
    } = output(hand_over, tasks);
    let cores = hand_over.cores;
    let throttle = hand_over
        .throttle
        .map_or_else(String::new, |n| format!("%{n}"));
    let time = hand_over
        .minutes
        .map_or_else(String::new, |minutes| format!("#SBATCH --time={minutes}\n"));
    format!(
        r#"#!/bin/bash
{title}#
# Start it with:  sbatch FILE
# in the folder that this script was written in. If the array is too large (MaxArraySize of
# `scontrol show config`), write the script with more --seeds-per-task.
#
# {GRACE} seconds before its time is up, a task saves its runs, ends with exit code 75, and is queued again.
# If runs remain unfinished, start the script again: finished runs are not repeated.
#SBATCH --job-name={name}
#SBATCH --array={numbers}{throttle}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={cores}
{time}#SBATCH --signal=B:TERM@{GRACE}
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output={output}

{redirect}# Slurm signals only this shell, which passes the signal on.
run=
trap 'if [ -n "$run" ]; then kill -TERM "$run"; fi' TERM

task=$SLURM_ARRAY_TASK_ID
{index}{command} &
run=$!
wait "$run"
code=$?
# A signal ends the first wait; the second waits for the end of the runs.
if [ "$code" -gt 128 ]; then
  wait "$run"
  code=$?
fi
if [ "$code" -eq 75 ]; then
  scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
"#
    )
}
