//! Inputs that went wrong in other systems, from public reports. Every case of `data/reports/reports.json` must be right
//! in every mode of this crate. `reports/code.rs` has the reports that need code of their own.

mod code;
mod expression;

use crate::common::{Formula, forward_gradient, gradients, hessian_rows};
use autodiff::data::Recorded;
use autodiff::{
    Dual, Function, Kernel, Model, Program, Real, Rollout, gradient, gradient_forward, kernel,
    value_and_gradient,
};
use serde_json::Value;

/// A right number: an interval, which is a single number except at a kink.
struct Right {
    bounds: [f64; 2],
    /// How far a result may be from a bound, relative to the bound.
    tolerance: f64,
    /// Whether NaN or an infinity is right too.
    or_not_finite: bool,
}

impl Right {
    fn allows(&self, found: f64) -> bool {
        let [low, high] = self.bounds;
        if self.or_not_finite && !found.is_finite() || low.is_nan() && found.is_nan() {
            return true;
        }
        let slack = |bound: f64| match bound.is_finite() {
            true => bound.abs() * self.tolerance,
            false => 0.0,
        };
        low - slack(low) <= found && found <= high + slack(high)
    }
}

struct Case {
    /// The link, the function and the point.
    name: String,
    formula: Formula,
    x: Vec<f64>,
    single: bool,
    value: Right,
    gradient: Vec<Right>,
    hessian: Vec<Vec<Right>>,
    /// Whether the results are those that this crate documents and not the right ones.
    here: bool,
}

/// Reads a number. JSON has no infinities, so they are texts.
fn number(entry: &Value) -> f64 {
    match entry {
        Value::String(text) => text.parse().expect("inf, -inf or nan"),
        number => number.as_f64().expect("a number"),
    }
}

fn list(entry: &Value) -> &[Value] {
    entry.as_array().expect("a list")
}

/// Reads a case. If `documented` is true and this crate documents other results, the case has those results.
fn case(case: &Value, tolerances: &Value, documented: bool) -> Case {
    let single = case["type"] == "f32";
    let (rounded, epsilon): (fn(f64) -> f64, _) = match single {
        true => (|x| f64::from(x as f32), f64::from(f32::EPSILON)),
        false => (|x| x, f64::EPSILON),
    };
    let class = case["tolerance"].as_str().expect("a tolerance");
    let tolerance = number(&tolerances[class]["epsilons"]) * epsilon;
    let right = |entry: &Value, or_not_finite: &str| Right {
        bounds: match entry {
            Value::Array(bounds) => [rounded(number(&bounds[0])), rounded(number(&bounds[1]))],
            single => [rounded(number(single)); 2],
        },
        tolerance,
        or_not_finite: case[or_not_finite] == true,
    };
    let result = |what: &str| match &case["here"][what] {
        other if documented && !other.is_null() => other.clone(),
        _ => case[what].clone(),
    };
    let x: Vec<f64> = list(&case["x"]).iter().map(number).map(rounded).collect();
    let text = case["f"].as_str().expect("a function");
    let gradient = result("gradient");
    let entries = |row: &Value, or: &str| list(row).iter().map(|entry| right(entry, or)).collect();
    let rows = match result("hessian") {
        Value::Null => Vec::new(),
        rows => list(&rows).to_vec(),
    };
    Case {
        name: format!("{}: {text} at {x:?}", case["links"][0]),
        formula: expression::parsed(text, x.len()),
        single,
        value: right(&case["value"], "or_not_finite"),
        gradient: entries(&gradient, "or_not_finite"),
        hessian: rows
            .iter()
            .map(|row| entries(row, "hessian_or_not_finite"))
            .collect(),
        here: !case["here"].is_null(),
        x,
    }
}

fn cases(documented: bool) -> Vec<Case> {
    let file: Value =
        serde_json::from_str(include_str!("../data/reports/reports.json")).expect("JSON");
    let tolerances = &file["tolerances"];
    list(&file["cases"])
        .iter()
        .map(|entry| case(entry, tolerances, documented))
        .collect()
}

/// The results of a mode. A mode that does not compute a value or a Hessian has none.
#[derive(Default)]
struct Found {
    mode: &'static str,
    value: Option<f64>,
    gradient: Vec<f64>,
    hessian: Vec<Vec<f64>>,
    /// Whether a computed zero stops an infinite partial, as in lanes.
    lanes: bool,
}

impl Found {
    fn gradient(mode: &'static str, (value, gradient): (f64, Vec<f64>)) -> Self {
        let value = Some(value);
        Self {
            mode,
            value,
            gradient,
            ..Self::default()
        }
    }

    fn hessian(mode: &'static str, hessian: Vec<Vec<f64>>) -> Self {
        Self {
            mode,
            hessian,
            ..Self::default()
        }
    }

    fn in_lanes(self) -> Self {
        Self {
            lanes: true,
            ..self
        }
    }
}

/// A function in an array program, as a kernel. A kernel has a fixed number of inputs; it uses the first ones.
#[derive(Clone)]
struct Mapped {
    formula: Formula,
    arguments: usize,
}

#[kernel]
impl Kernel<4, 1> for Mapped {
    fn eval<R: Real>(&self, x: [R; 4], _: &[R]) -> [R; 1] {
        [self.formula.values(&x[..self.arguments])[0]]
    }
}

/// How many copies of the point a program computes. They fill a register and leave a rest.
const COPIES: usize = 9;

impl Model for Mapped {
    fn record(&self, program: &mut Program) {
        let x = [(); 4].map(|()| program.state(COPIES));
        let [y] = program.map(self.clone(), x, &[]);
        for (state, next) in x.into_iter().zip([y, x[1], x[2], x[3]]) {
            program.advance(state, next);
        }
    }
}

struct InProgram(Rollout<Mapped>);

impl InProgram {
    fn new(formula: &Formula, arguments: usize) -> Self {
        let formula = formula.clone();
        Self(Rollout::new(Mapped { formula, arguments }, 1))
    }
}

impl Function for InProgram {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let of = |i: usize| x.get(i).copied().unwrap_or(R::zero());
        let start: Vec<R> = (0..4 * COPIES).map(|k| of(k / COPIES)).collect();
        // Only the last copy depends on the arguments.
        let moves = |k: usize| k % COPIES == COPIES - 1;
        let start = start.into_iter().enumerate();
        let start = start.map(|(k, x)| if moves(k) { x } else { x.detach() });
        self.0.run(&start.collect::<Vec<_>>(), &[])[COPIES - 1]
    }
}

/// Returns the point as duals that move along argument `one`.
fn moving(x: &[f64], one: usize) -> Vec<Dual<f64, 1>> {
    let mut duals: Vec<_> = x.iter().copied().map(Dual::constant).collect();
    duals[one].tangent[0] = 1.0;
    duals
}

/// Computes the value and the gradient of a function of doubles in every mode.
fn first_derivatives(f: &Formula, x: &[f64]) -> Vec<Found> {
    let recorded = Recorded::new(f, x.len()).expect("a formula needs no values");
    let program = InProgram::new(f, x.len());
    let value = f.eval(x);
    let by_modes = gradients(f, x).into_iter();
    let mut found: Vec<Found> = by_modes
        .map(|(mode, gradient)| Found::gradient(mode, (value, gradient)))
        .collect();
    let of_dual = f.eval(&moving(x, 0)).value;
    let several = gradient_forward(|x| f.eval(x), x);
    let by_program = gradient(|x| program.eval(x), x);
    let through_program = forward_gradient(&program, x);
    found.extend([
        Found::gradient("duals", (of_dual, several)),
        Found::gradient("tape", value_and_gradient(|x| f.eval(x), x)),
        Found::gradient("recorded", recorded.value_and_gradient(x)).in_lanes(),
        Found::gradient("program", (program.eval(x), by_program)).in_lanes(),
        Found::gradient("forward over program", (value, through_program)).in_lanes(),
    ]);
    let points = recorded.values_and_gradients(&[x; COPIES]).into_iter();
    found.extend(points.map(|both| Found::gradient("recorded, many points", both).in_lanes()));
    found
}

/// Computes the Hessian of a function of doubles in every nesting of modes.
fn second_derivatives(f: &Formula, x: &[f64]) -> Vec<Found> {
    let recorded = Recorded::new(f, x.len()).expect("a formula needs no values");
    let program = InProgram::new(f, x.len());
    let tangents = |row: Vec<Dual<f64, 1>>| row.iter().map(|g| g.tangent[0]).collect();
    let forward = |i| tangents(forward_gradient(f, &moving(x, i)));
    let over_forward = |i: usize| gradient(|x| forward_gradient(f, x)[i], x);
    let reverse = |i| tangents(gradient(|x| f.eval(x), &moving(x, i)));
    let over_reverse = |i: usize| gradient(|x| gradient(|x| f.eval(x), x)[i], x);
    let over_recorded = |i| tangents(recorded.value_and_gradient(&moving(x, i)).1);
    let rows = |row: &dyn Fn(usize) -> Vec<f64>| (0..x.len()).map(row).collect();
    vec![
        Found::hessian("forward over forward", rows(&forward)),
        Found::hessian("reverse over forward", rows(&over_forward)),
        Found::hessian("forward over reverse", rows(&reverse)),
        Found::hessian("reverse over reverse", rows(&over_reverse)),
        Found::hessian("forward over recorded", rows(&over_recorded)).in_lanes(),
        Found::hessian("forward over program", hessian_rows(&program, x)).in_lanes(),
    ]
}

/// Computes a function of singles.
fn in_singles(f: &Formula, x: &[f64]) -> Vec<Found> {
    let x: Vec<f32> = x.iter().map(|&x| x as f32).collect();
    let wide = |gradient: Vec<f32>| gradient.into_iter().map(f64::from).collect();
    let value = f64::from(f.eval(&x));
    let recorded = Recorded::new(f, x.len()).expect("a formula needs no values");
    let (replayed, by_replay) = recorded.value_and_gradient(&x);
    vec![
        Found::gradient("forward", (value, wide(forward_gradient(f, &x)))),
        Found::gradient("reverse", (value, wide(gradient(|x| f.eval(x), &x)))),
        Found::gradient("recorded", (replayed.into(), wide(by_replay))).in_lanes(),
    ]
}

impl Case {
    /// Describes the results that are wrong.
    fn mistakes(&self) -> Vec<String> {
        let mut found = Vec::new();
        if self.single {
            found.extend(in_singles(&self.formula, &self.x));
        } else {
            found.extend(first_derivatives(&self.formula, &self.x));
            found.extend(second_derivatives(&self.formula, &self.x));
        }
        found
            .iter()
            .flat_map(|found| self.mistakes_of(found))
            .collect()
    }

    fn mistakes_of(&self, found: &Found) -> Vec<String> {
        let values = found.value.iter().copied().zip([&self.value]);
        let slopes = found.gradient.iter().copied().zip(&self.gradient);
        let seconds = found
            .hessian
            .iter()
            .flatten()
            .copied()
            .zip(self.hessian.iter().flatten());
        let groups: [(&str, Vec<(f64, &Right)>); 3] = [
            ("value", values.collect()),
            ("gradient", slopes.collect()),
            ("Hessian", seconds.collect()),
        ];
        let mut mistakes = Vec::new();
        for (what, entries) in groups {
            // In lanes a computed zero hides an infinity, so a slope may be 0 instead of NaN.
            let hidden = |x: f64, right: &Right| {
                found.lanes && right.or_not_finite && x == 0.0 && what != "value"
            };
            let wrong = |&(x, right): &(f64, &Right)| !right.allows(x) && !hidden(x, right);
            if entries.iter().any(wrong) {
                let pairs: Vec<_> = entries.iter().map(|(x, right)| (x, right.bounds)).collect();
                mistakes.push(format!(
                    "{}\n    {}, {what}: {pairs:?}",
                    self.name, found.mode
                ));
            }
        }
        mistakes
    }
}

#[test]
fn every_report_is_right_in_every_mode() {
    let mistakes: Vec<String> = cases(true).iter().flat_map(Case::mistakes).collect();
    assert!(
        mistakes.is_empty(),
        "{} mistakes\n{}",
        mistakes.len(),
        mistakes.join("\n")
    );
}

#[test]
fn results_that_only_this_crate_documents_are_not_right_elsewhere() {
    for case in cases(false).iter().filter(|case| case.here) {
        assert!(
            !case.mistakes().is_empty(),
            "{} is right; remove `here`",
            case.name
        );
    }
}
