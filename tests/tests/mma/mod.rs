//! The method of moving asymptotes reproduces recorded results: those of single updates, and those of whole runs.

mod problems;

use cosmic::optimiser::{Linearisation, Mma, MmaSettings, MmaState, Update};
use cosmic_tests::{Reference, reference_subfolder, references};
use problems::Problem;
use serde::Deserialize;
use serde_json::Value;

/// A recorded run of the method. The fields of the file that no test uses are not read.
#[derive(Deserialize)]
struct Case {
    name: String,
    statement: String,
    data: Value,
    start: Vec<f64>,
    xmin: Vec<f64>,
    xmax: Vec<f64>,
    parameters: Parameters,
    iterations: usize,
    #[serde(rename = "final")]
    end: End,
    trace: Vec<Iteration>,
}

#[derive(Deserialize)]
struct Parameters {
    asyinit: f64,
    asyincr: f64,
    asydecr: f64,
    asymin: f64,
    asymax: f64,
    albefa: f64,
    raa0: f64,
    #[serde(rename = "move")]
    move_limit: f64,
    a: Vec<f64>,
    c: Vec<f64>,
    d: Vec<f64>,
}

#[derive(Deserialize)]
struct End {
    f0: f64,
}

/// One iteration of a recorded run. In long runs, only the first iterations have vectors.
#[derive(Deserialize)]
struct Iteration {
    f0: f64,
    lam: Vec<f64>,
    x: Option<Vec<f64>>,
    low: Option<Vec<f64>>,
    upp: Option<Vec<f64>>,
    x_next_exact: Option<Vec<f64>>,
    y_exact: Option<Vec<f64>>,
    lam_exact: Option<Vec<f64>>,
}

/// The recorded runs in the folder `mma` of the reference cases.
fn cases() -> Vec<Case> {
    let case = |reference: &Reference| {
        serde_json::from_str(&reference.text)
            .unwrap_or_else(|error| panic!("{}: {error}", reference.name()))
    };
    let references = references(&reference_subfolder("mma"));
    references.iter().map(case).collect()
}

/// The common value of all entries of a list, or `otherwise` for an empty list. Panics if the entries are not equal.
fn uniform(what: &str, list: &[f64], otherwise: f64) -> f64 {
    let first = list.first().copied().unwrap_or(otherwise);
    let is_uniform = list.iter().all(|&entry| entry == first);
    assert!(
        is_uniform,
        "`{what}` must be the same for all constraints, but is {list:?}"
    );
    first
}

impl Case {
    fn problem(&self) -> Box<dyn Problem> {
        problems::problem(&self.statement, self.data.clone())
    }

    fn method(&self) -> Mma {
        let p = &self.parameters;
        assert_eq!(uniform("a", &p.a, 0.0), 0.0, "`a` must be zero");
        let usual = MmaSettings::default();
        let parameters = MmaSettings {
            move_limit: p.move_limit,
            asyinit: p.asyinit,
            asyincr: p.asyincr,
            asydecr: p.asydecr,
            asymin: p.asymin,
            asymax: p.asymax,
            albefa: p.albefa,
            raa0: p.raa0,
            c: uniform("c", &p.c, usual.c),
            d: uniform("d", &p.d, usual.d),
        };
        Mma::new(parameters, &self.xmin, &self.xmax).expect("usable settings")
    }

    /// The iterations in which vectors were recorded.
    fn kept(&self) -> impl Iterator<Item = (usize, &Iteration)> {
        (self.trace.iter().enumerate()).filter(|(_, iteration)| iteration.x_next_exact.is_some())
    }

    /// The optimiser's state before iteration `k`, as it was recorded.
    fn state(&self, k: usize) -> MmaState {
        let point = |back: usize| self.trace[k.saturating_sub(back)].x.clone();
        let before = &self.trace[k.saturating_sub(1)];
        let kept = "an iteration is kept with those before it";
        MmaState {
            updates: k as u64,
            previous: point(1).expect(kept),
            before_previous: point(2).expect(kept),
            low: before.low.clone().expect(kept),
            upp: before.upp.clone().expect(kept),
            multipliers: Vec::new(),
        }
    }

    /// Asserts that each variable differs from the expected one by at most `tolerance` times the range of the variable.
    fn assert_close(&self, what: &str, (found, expected): (&[f64], &[f64]), tolerance: f64) {
        assert_eq!(found.len(), expected.len(), "{}: {what}", self.name);
        for (j, (found, expected)) in found.iter().zip(expected).enumerate() {
            let off = (found - expected).abs() / (self.xmax[j] - self.xmin[j]);
            assert!(
                off <= tolerance,
                "{}: {what}[{j}] is {found}, recorded {expected}: off by {off:e} of the range",
                self.name
            );
        }
    }
}

fn update(mma: &mut Mma, state: &mut MmaState, problem: &dyn Problem, x: &[f64]) -> Update {
    let (values, mut rows) = problem.linearise(x);
    let objective_gradient = rows.remove(0);
    let at = Linearisation {
        point: x,
        objective_gradient: &objective_gradient,
        constraints: &values[1..],
        jacobian: &rows,
    };
    mma.update(state, &at).expect("finite input")
}

/// Asserts that two numbers differ by at most `tolerance` times the expected number, or by `tolerance` if that is
/// larger.
fn assert_near(what: &str, found: f64, expected: f64, tolerance: f64) {
    let off = (found - expected).abs() / expected.abs().max(1.0);
    assert!(
        off <= tolerance,
        "{what} is {found}, recorded {expected}: off by {off:e}"
    );
}

fn kept(vector: &Option<Vec<f64>>) -> &[f64] {
    vector
        .as_deref()
        .expect("the vectors of an iteration are kept together")
}

/// An update from a recorded state gives the recorded asymptotes and the recorded new point. Every update starts from
/// the record, so that errors do not add up.
#[test]
fn each_update_is_the_recorded_one() {
    for case in cases() {
        let (problem, mut mma) = (case.problem(), case.method());
        for (k, iteration) in case.kept() {
            let mut state = case.state(k);
            let update = update(&mut mma, &mut state, &*problem, kept(&iteration.x));
            let at = |what: &str| format!("iteration {}: {what}", k + 1);
            // The update and the record do the same few operations on the same numbers, so they differ only by
            // rounding.
            case.assert_close(&at("low"), (&state.low, kept(&iteration.low)), 1e-12);
            case.assert_close(&at("upp"), (&state.upp, kept(&iteration.upp)), 1e-12);
            // The record solves its subproblem to about 1e-13; the condition of the problem amplifies this error.
            let points = (&update.point[..], kept(&iteration.x_next_exact));
            case.assert_close(&at("x_next"), points, 1e-8);
            compare_duals(&case.name, &update, iteration);
        }
    }
}

/// Compares the elastic variables of an update with the recorded ones, and also the multipliers if they are unique.
fn compare_duals(name: &str, update: &Update, iteration: &Iteration) {
    let (elastic, exact) = (kept(&iteration.y_exact), kept(&iteration.lam_exact));
    assert_eq!(update.diagnostics.elastic.len(), elastic.len(), "{name}");
    for i in 0..elastic.len() {
        let what = |what: &str| format!("{name}: {what}[{i}]");
        // The elastic variable y = (lam - c) / d has the rounding error of c = 1000. The tolerance 1e-10 leaves room
        // for larger c.
        assert_near(&what("y"), update.diagnostics.elastic[i], elastic[i], 1e-10);
        // The record has the multipliers of two solvers. If the subproblem had many solutions, the two solvers would
        // find different ones. So the solution is unique if they agree to the accuracy of the interior point method.
        let unique = (iteration.lam[i] - exact[i]).abs() <= 1e-5 * exact[i].abs().max(1.0);
        if unique {
            assert_near(&what("lam"), update.multipliers[i], exact[i], 1e-8);
        }
    }
}

/// A run from the start, with as many iterations as the recorded run, ends at the same point.
#[test]
fn whole_runs_end_where_the_recorded_ones_do() {
    for case in cases() {
        let (problem, mut mma) = (case.problem(), case.method());
        let mut x = case.start.clone();
        let mut state = mma.init(&x);
        for _ in 0..case.iterations {
            let update = update(&mut mma, &mut state, &*problem, &x);
            // The constraints are sums of terms up to 1e3; the tolerance allows a few roundings of numbers of that
            // size.
            assert!(
                update.diagnostics.residual <= 1e-10,
                "{}: {update:?}",
                case.name
            );
            x = update.point;
        }
        let end = problem.linearise(&x).0[0];
        let off = (end - case.end.f0).abs() / case.end.f0.abs();
        assert!(
            off <= case.run_tolerance(),
            "{}: f0 ends at {end}, recorded {}: off by {off:e}",
            case.name,
            case.end.f0
        );
    }
}

impl Case {
    /// The tolerance for the last point of a run. The recorded run solved its subproblems only to 1e-7, which moved
    /// points by up to 4e-2. A converged run still ends at the same point, to 1e-5. For a run that has not converged,
    /// the tolerance is the distance that the recorded run moved in its last ten iterations.
    fn run_tolerance(&self) -> f64 {
        let last = self
            .trace
            .iter()
            .rev()
            .take(10)
            .map(|iteration| iteration.f0);
        let (least, most) = last.fold((self.end.f0, self.end.f0), |(least, most), f0| {
            (f64::min(least, f0), f64::max(most, f0))
        });
        ((most - least) / self.end.f0.abs()).max(1e-5)
    }
}
