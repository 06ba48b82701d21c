//! A task, and several ways to do it, with their times.

use benches::machine::{SPAN, in_turns};

/// Keeps data that all ways of a task share for the lifetime of the program.
pub(crate) fn kept<T>(data: impl IntoIterator<Item = T>) -> &'static [T] {
    data.into_iter().collect::<Vec<T>>().leak()
}

/// One way to do a task.
pub(crate) struct Way {
    /// The crate: `ours` or the name of a peer. `by hand` or `primal` is the reference of ratios.
    pub(crate) by: &'static str,
    pub(crate) how: &'static str,
    /// The modules of the task's file that belong to this way.
    pub(crate) modules: &'static [&'static str],
    pub(crate) run: Box<dyn FnMut() -> Vec<f64>>,
}

impl Way {
    pub(crate) fn new(
        by: &'static str,
        how: &'static str,
        modules: &'static [&'static str],
        run: impl FnMut() -> Vec<f64> + 'static,
    ) -> Self {
        Self {
            by,
            how,
            modules,
            run: Box::new(run),
        }
    }
}

/// A task that is done in several ways. The first way is the reference of ratios.
pub(crate) struct Task {
    pub(crate) title: String,
    pub(crate) about: &'static str,
    /// The source text of the task's file.
    pub(crate) source: &'static str,
    /// The largest allowed difference between answers, relative to their largest number.
    pub(crate) tolerance: f64,
    pub(crate) ways: Vec<Way>,
}

/// The measurements of a way.
pub(crate) struct Outcome {
    pub(crate) by: &'static str,
    pub(crate) how: &'static str,
    pub(crate) seconds: f64,
    pub(crate) lines: usize,
}

impl Task {
    /// Compares the answers.
    ///
    /// # Panics
    /// If they differ by more than the tolerance.
    pub(crate) fn compare(&mut self) {
        let answers = self
            .ways
            .iter_mut()
            .map(|way| (way.by, way.how, (way.run)()));
        // The primal has no gradient to compare.
        let mut answers = answers.filter(|(by, ..)| *by != "primal");
        let (_, _, first) = answers.next().expect("a task has a way");
        let scale = first.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(
            scale > 0.0,
            "{}: all answers are zero, so a comparison would prove nothing",
            self.title
        );
        for (by, how, other) in answers {
            assert_eq!(first.len(), other.len(), "{by}, {how}: {}", self.title);
            for (k, (a, b)) in first.iter().zip(&other).enumerate() {
                let agree = (a - b).abs() <= self.tolerance * scale;
                assert!(
                    agree,
                    "{}: number {k} of the answer by {by}, {how}, is {b}, but the first way computes {a}",
                    self.title
                );
            }
        }
    }

    /// Times the ways alternately.
    pub(crate) fn measure(&mut self, rounds: usize) -> Vec<Outcome> {
        let works = self.ways.iter_mut().map(|way| &mut way.run);
        let seconds = in_turns(&mut works.collect::<Vec<_>>(), SPAN, rounds);
        let source = self.source;
        let outcome = |(way, seconds): (&Way, f64)| Outcome {
            by: way.by,
            how: way.how,
            seconds,
            lines: way.modules.iter().map(|name| lines(source, name)).sum(),
        };
        self.ways.iter().zip(seconds).map(outcome).collect()
    }
}

/// Counts the lines of code of a top-level module of a file, without blank lines and comments.
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
