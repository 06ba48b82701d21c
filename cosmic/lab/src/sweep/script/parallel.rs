//! A script for GNU parallel.

use super::task::{HandOver, Tasks, index, limited, title};

pub(super) fn script(hand_over: &HandOver, tasks: &Tasks) -> String {
    let (title, index, command) = (
        title(hand_over, tasks),
        index(hand_over).replace('\n', "\n  "),
        limited(hand_over, tasks),
    );
    let sweep = &tasks.sweep;
    // Writes ranges as the shell's braces do: `{3..17} 40` for `3-17,40`.
    let in_braces = |range: &&str| match range.split_once('-') {
        None => (*range).to_owned(),
        Some((first, last)) => format!("{{{first}..{last}}}"),
    };
    let ranges: Vec<String> = tasks.ranges().iter().map(in_braces).collect();
    let ranges = ranges.join(" ");
    let jobs = match (hand_over.throttle, hand_over.cores.get()) {
        (Some(throttle), _) => format!(" --jobs {throttle}"),
        (None, 1) => String::new(),
        (None, cores) => format!(" --jobs \"$(( ($(nproc) + {cores} - 1) / {cores} ))\""),
    };
    format!(
        r#"#!/bin/bash
{title}#
# Start it with:  bash FILE
# in the folder that this script was written in. If runs remain unfinished, start it again: finished runs are not
# repeated. Ctrl-C saves the runs and ends the script.

task() {{
  task=$1
  {index}while :; do
    {command}
    code=$?
    # 75: interrupted because its time is up. It continues at once.
    if [ "$code" -ne 75 ]; then return "$code"; fi
  done >>{sweep}/logs/"$task".log 2>&1
}}
export -f task
export SHELL=/bin/bash

printf '%s\n' {ranges} | parallel{jobs} --joblog {sweep}/logs/parallel.tsv task
"#
    )
}
