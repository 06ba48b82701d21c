//! Tasks to measure. Each can be done in several ways.

use std::hint::black_box;
use std::time::Instant;

/// Keeps data until the program ends, so that all ways to do a task can share them.
pub(crate) fn kept<T>(data: impl IntoIterator<Item = T>) -> &'static [T] {
    data.into_iter().collect::<Vec<T>>().leak()
}

/// One way to do a task.
pub(crate) struct Way {
    /// The crate that is used: `ours` or the name of another crate. For the first way, with which the others are
    /// compared, `by hand` or `primal`.
    by: &'static str,
    how: &'static str,
    run: Box<dyn FnMut() -> Vec<f64>>,
}

impl Way {
    pub(crate) fn new(
        by: &'static str,
        how: &'static str,
        run: impl FnMut() -> Vec<f64> + 'static,
    ) -> Self {
        let run = Box::new(run);
        Self { by, how, run }
    }
}

/// A task that is done in up to three ways: the reference, `ours`, and another crate's if this build has the crate.
pub(crate) struct Task {
    pub(crate) title: String,
    /// The source text of the task's file. It has a module for each crate.
    pub(crate) source: &'static str,
    /// The largest allowed difference between answers, relative to their largest number.
    pub(crate) tolerance: f64,
    pub(crate) ways: Vec<Way>,
}

impl Task {
    /// Asserts that the answers of all ways agree.
    ///
    /// # Panics
    /// If they differ by more than the tolerance.
    pub(crate) fn compare(&mut self) {
        let answers = self.ways.iter_mut().map(|way| (way.by, (way.run)()));
        // The way `primal` computes no gradient, so it has no answer to compare.
        let mut answers = answers.filter(|(by, _)| *by != "primal");
        let (_, first) = answers.next().expect("every task has at least one way");
        let scale = first.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(
            scale > 0.0,
            "{}: all answers are zero, so a comparison would prove nothing",
            self.title
        );
        for (by, other) in answers {
            assert_eq!(first.len(), other.len(), "{by}: {}", self.title);
            for (k, (a, b)) in first.iter().zip(&other).enumerate() {
                let agree = (a - b).abs() <= self.tolerance * scale;
                assert!(
                    agree,
                    "{}: the answers differ: number {k} is {b} by {by}, but {a} by the first way to do the task",
                    self.title
                );
            }
        }
    }

    /// Measures the times of all ways, which take turns. Returns a row of the table.
    pub(crate) fn measure(&mut self, rounds: usize) -> String {
        let works = self.ways.iter_mut().map(|way| &mut way.run);
        let seconds = in_turns(&mut works.collect::<Vec<_>>(), rounds);
        let (us, ratio) = (1e6 * seconds[1], seconds[1] / seconds[0]);
        let [reference, _, peer @ ..] = &self.ways[..] else {
            unreachable!("every task has a reference and a way that uses this project's crate");
        };
        let (title, reference, ours) = (&self.title, reference.by, lines(self.source, "ours"));
        let row = format!("| {title} | {us:.1} | {ratio:.1} times {reference} |");
        let [Way { by, how, .. }] = peer else {
            return format!("{row} none in this build | | | {ours} |");
        };
        let (theirs, ratio) = (1e6 * seconds[2], seconds[2] / seconds[1]);
        let lines = lines(self.source, &by.replace('-', "_"));
        format!("{row} {by}, {how} | {theirs:.1} | {ratio:.2} | {ours}, {lines} |")
    }
}

/// Measures the run time of `work` in seconds.
fn seconds<T>(work: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64()
}

/// The duration of one measurement, in seconds. It is long enough for caches and branch predictors to warm up,
/// and short compared with a time slice of the operating system.
const SPAN: f64 = 2e-3;

/// Measures the times of several pieces of work, which take turns. Returns for each one the minimum over `rounds`
/// rounds, in seconds. In a round each piece is repeated for [`SPAN`] seconds.
fn in_turns<T>(works: &mut [impl FnMut() -> T], rounds: usize) -> Vec<f64> {
    let mut least = vec![f64::INFINITY; works.len()];
    for round in 0..=rounds {
        for (work, least) in works.iter_mut().zip(&mut least) {
            let repeats = ((SPAN / *least) as usize).max(1);
            let all = || {
                for _ in 0..repeats {
                    black_box(work());
                }
            };
            let taken = seconds(all) / repeats as f64;
            // The first round is not timed. It only finds the number of repetitions.
            *least = if round == 0 { taken } else { least.min(taken) };
        }
    }
    least
}

/// Returns how many lines of code a module at the top level of a file has. Blank lines and comments do not count.
fn lines(source: &str, module: &str) -> usize {
    let head = format!("mod {module} {{");
    let body = source.lines().skip_while(|line| *line != head).skip(1);
    let code = body
        .take_while(|line| *line != "}")
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with("//"));
    let count = code.count();
    assert!(count > 0, "the file has no module {module}");
    count
}
