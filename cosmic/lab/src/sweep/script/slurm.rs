//! A batch script for Slurm.

use super::task::{GRACE, HandOver, Tasks, command, index, title};

pub(super) fn script(hand_over: &HandOver, tasks: &Tasks) -> String {
    let (title, index, command) = (
        title(hand_over, tasks),
        index(hand_over),
        command(hand_over, tasks),
    );
    let Tasks {
        numbers,
        sweep,
        name,
        ..
    } = tasks;
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
# in the folder that this script was written in. Where an array may not reach so far (MaxArraySize of
# `scontrol show config`), write the script with more --seeds-per-task.
#
# {GRACE} seconds before its time is up, a task saves its runs. Its exit code is then 75, and it queues again.
# Start the script again for runs that are left after all: those that are over are not done twice.
#SBATCH --job-name={name}
#SBATCH --array={numbers}{throttle}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task={cores}
{time}#SBATCH --signal=B:TERM@{GRACE}
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output={sweep}/logs/%a.log

# Slurm signals this shell alone, which passes the signal on.
run=
trap 'if [ -n "$run" ]; then kill -TERM "$run"; fi' TERM

task=$SLURM_ARRAY_TASK_ID
{index}{command} &
run=$!
wait "$run"
code=$?
# A signal ends the first wait; the second is for the end of the runs.
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
