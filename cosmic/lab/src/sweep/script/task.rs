//! The tasks that are handed to a scheduler: their numbers, and the lines that all scripts share.

use crate::sweep::in_ranges;
use cosmic::error::in_shell;
use std::num::NonZeroUsize;
use std::path::Path;

/// A task receives a signal this many seconds before its time is up.
pub(super) const GRACE: u64 = 60;

/// The runs that are handed to a scheduler, and the options of their tasks.
#[derive(Clone, Copy, Debug)]
pub struct HandOver<'s> {
    /// The path of the sweep's folder on the machine that runs the tasks.
    pub sweep: &'s Path,
    /// The number of runs in the plan.
    pub runs: usize,
    /// The numbers of the unfinished runs, in ascending order; there is at least one.
    pub left: &'s [usize],
    /// The number of runs per task.
    pub per_task: NonZeroUsize,
    /// The number of cores per task. Each core does one run at a time.
    pub cores: NonZeroUsize,
    /// The largest number of tasks that may run at the same time.
    pub throttle: Option<NonZeroUsize>,
    /// The time limit of a task, in minutes.
    pub minutes: Option<u64>,
}

/// The tasks that have unfinished runs. Task `k` does up to `per_task` consecutive runs, of which the first has number
/// `k * per_task`.
#[derive(Clone)]
pub(super) struct Tasks {
    /// The numbers of the tasks as ranges, such as `3-17,40`.
    pub(super) numbers: String,
    pub(super) count: usize,
    /// The sweep's folder, quoted for a shell.
    pub(super) sweep: String,
    /// A label for jobs: the name of the sweep's folder, reduced to letters, digits and dashes.
    pub(super) name: String,
}

impl Tasks {
    pub(super) fn of(hand_over: &HandOver) -> Self {
        let per_task = hand_over.per_task.get();
        let left = hand_over.left.iter();
        let mut numbers: Vec<usize> = left.map(|index| index / per_task).collect();
        numbers.dedup();
        let path = std::path::absolute(hand_over.sweep);
        let path = path.unwrap_or_else(|_| hand_over.sweep.to_owned());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Self {
            numbers: in_ranges(&numbers),
            count: numbers.len(),
            sweep: in_shell(hand_over.sweep),
            name: label(&name),
        }
    }

    /// The task numbers as a list of ranges, such as `3-17` and `40`.
    pub(super) fn ranges(&self) -> Vec<&str> {
        self.numbers.split(',').collect()
    }
}

/// Turns the name of a folder into a label that every scheduler accepts.
fn label(name: &str) -> String {
    let letters = name.chars().map(|c| {
        let c = c.to_ascii_lowercase();
        if c.is_ascii_alphanumeric() { c } else { '-' }
    });
    let name: String = format!("sweep-{}", letters.take(40).collect::<String>());
    name.trim_end_matches('-').to_owned()
}

/// The comment at the top of a script. It names the sweep and counts its runs and tasks.
pub(super) fn title(hand_over: &HandOver, tasks: &Tasks) -> String {
    let HandOver { runs, left, .. } = hand_over;
    let sweep: String = hand_over.sweep.display().to_string();
    let sweep = sweep.replace(char::is_control, "?");
    let (left, tasks) = (left.len(), tasks.count);
    let counted = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    format!(
        "# The unfinished runs of the sweep {sweep}, {left} of {runs}, in {}.\n",
        counted(tasks, "task")
    )
}

/// The shell lines that compute `$index` from `$task`: the numbers of the runs of a task.
pub(super) fn index(hand_over: &HandOver) -> String {
    let (per_task, runs) = (hand_over.per_task.get(), hand_over.runs);
    if per_task == 1 {
        return "index=$task\n".to_owned();
    }
    let last = runs - 1;
    format!(
        "first=$((task * {per_task}))\n\
         last=$((first + {per_task} - 1))\n\
         if [ \"$last\" -gt {last} ]; then last={last}; fi\n\
         index=$first-$last\n"
    )
}

/// The command of a task.
pub(super) fn command(hand_over: &HandOver, tasks: &Tasks) -> String {
    let (sweep, cores) = (&tasks.sweep, hand_over.cores);
    format!("cosmic sweep run {sweep} --index \"$index\" --threads {cores}")
}

/// The command of a task. If the tasks have a time limit, the command sends a signal before the end, so that the runs
/// are saved.
pub(super) fn limited(hand_over: &HandOver, tasks: &Tasks) -> String {
    let command = command(hand_over, tasks);
    match hand_over.minutes {
        None => command,
        Some(minutes) => {
            let seconds = minutes * 60 - GRACE;
            format!(
                "timeout --preserve-status --signal=TERM --kill-after={GRACE} {seconds} {command}"
            )
        }
    }
}
