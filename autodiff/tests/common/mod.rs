//! Helpers that the tests share, also those of `cosmic-autodiff-programs`: derivatives of one function in every mode, and comparisons.

use std::path::Path;

use autodiff::{Dual, Function, Real, Tape, gradient, hessian_vector, jvp};

use crate::in_lanes::values_and_gradients;

mod formula;
mod refusal;

pub(crate) use formula::{Formula, Sym, Truth, formula, formulas};
pub(crate) use refusal::{Refusal, assert_named, assert_refused, panic_message};

/// Reads the rows of all tables in a folder of `tests/data`, without the comments.
pub(crate) fn rows<T>(folder: &str, row: impl Fn(&str) -> T) -> Vec<T> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(folder);
    let files = std::fs::read_dir(folder).expect("the folder of tables");
    let paths = files.map(|file| file.expect("a folder entry").path());
    let tables = paths.filter(|path| path.extension().is_some_and(|e| e == "txt"));
    let read = |path| std::fs::read_to_string(path).expect("a readable table");
    let text: String = tables.map(read).collect();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(row).collect()
}

/// Returns a vector of zeros with a one at index `one`.
pub(crate) fn unit<R: Real>(len: usize, one: usize) -> Vec<R> {
    let mut unit = vec![R::zero(); len];
    unit[one] = R::one();
    unit
}

/// Returns the gradient by forward mode, one direction at a time.
pub(crate) fn forward_gradient<R: Real>(function: &impl Function, x: &[R]) -> Vec<R> {
    let along = |i: usize| jvp(|x| vec![function.eval(x)], x, &unit(x.len(), i)).1[0];
    (0..x.len()).map(along).collect()
}

/// Returns the rows of the Hessian, each by a product with a unit vector. Unlike [`hessian`](autodiff::hessian), this
/// needs no number types beyond those that [`gradients`] needs, which keeps compilation short.
pub(crate) fn hessian_rows<R: Real>(function: &impl Function, x: &[R]) -> Vec<Vec<R>> {
    let row = |i| hessian_vector(|x| function.eval(x), x, &unit(x.len(), i)).1;
    (0..x.len()).map(row).collect()
}

/// Returns the gradient in several modes, with their names: forward mode, reverse mode, and each of these two inside
/// another mode. An outer mode must not change the results of the inner mode.
pub(crate) fn gradients(function: &impl Function, x: &[f64]) -> Vec<(&'static str, Vec<f64>)> {
    let duals: Vec<Dual<f64, 1>> = x.iter().map(|&x| Dual::variable(x, 0)).collect();
    let primal = |gradient: Vec<Dual<f64, 1>>| gradient.iter().map(|g| g.value).collect();
    let mut tape = Tape::new();
    vec![
        ("forward", forward_gradient(function, x)),
        ("reverse", gradient(|x| function.eval(x), x)),
        (
            "forward in forward",
            primal(forward_gradient(function, &duals)),
        ),
        (
            "reverse in forward",
            primal(gradient(|x| function.eval(x), &duals)),
        ),
        (
            "forward in reverse",
            tape.record(x, |x| {
                forward_gradient(function, x)
                    .iter()
                    .map(|g| g.value())
                    .collect()
            }),
        ),
        (
            "reverse in reverse",
            tape.record(x, |x| {
                gradient(|x| function.eval(x), x)
                    .iter()
                    .map(|g| g.value())
                    .collect()
            }),
        ),
    ]
}

/// The slope of a function with respect to its first argument, in forward or in reverse mode.
struct Slope<'a, F>(&'a F, bool);

impl<F: Function> Function for Slope<'_, F> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        match self.1 {
            true => forward_gradient(self.0, x)[0],
            false => gradient(|x| self.0.eval(x), x)[0],
        }
    }
}

/// Returns the second derivative with respect to the first argument in all nestings of two modes, with their names.
pub(crate) fn second_derivatives(function: &impl Function, x: &[f64]) -> [(&'static str, f64); 5] {
    let [of_forward, of_reverse] = [true, false].map(|forward| Slope(function, forward));
    [
        ("forward over forward", forward_gradient(&of_forward, x)[0]),
        ("forward over reverse", forward_gradient(&of_reverse, x)[0]),
        (
            "reverse over forward",
            gradient(|x| of_forward.eval(x), x)[0],
        ),
        (
            "reverse over reverse",
            gradient(|x| of_reverse.eval(x), x)[0],
        ),
        ("of the Hessian", hessian_rows(function, x)[0][0]),
    ]
}

/// Asserts that every mode returns exactly this gradient. NaN counts as equal to NaN.
#[track_caller]
pub(crate) fn assert_gradient(function: &impl Function, x: &[f64], expected: &[f64]) {
    for (mode, gradient) in gradients(function, x) {
        let same = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
        let same = gradient.iter().zip(expected).all(same);
        assert!(same, "{mode} at {x:?}: {gradient:?}, expected {expected:?}");
    }
}

/// Asserts for each point that every mode returns exactly the given gradient, and so do lanes except for rounding.
#[track_caller]
pub(crate) fn assert_gradients<const N: usize>(
    function: impl FnOnce(&[Sym]) -> Sym,
    rows: &[([f64; N], [f64; N])],
) {
    let rows = rows.iter().map(|(x, expected)| [&x[..], &expected[..]]);
    assert_rows(&formula(N, function), &rows.collect::<Vec<_>>());
}

/// Not generic, so that this is compiled once.
#[track_caller]
fn assert_rows(function: &Formula, rows: &[[&[f64]; 2]]) {
    for &[x, expected] in rows {
        assert_gradient(function, x, expected);
        // In lanes, a multiply-add is rounded once. A computed zero and a NaN have conventions of their own there.
        if x.iter().chain(expected).any(|number| number.is_nan()) {
            continue;
        }
        let many = values_and_gradients(function, &vec![x.to_vec(); 9]);
        for (found, &expected) in many
            .iter()
            .flat_map(|(_, slopes)| slopes.iter().zip(expected))
        {
            let close = (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs();
            let same = *found == expected || expected.is_finite() && close;
            assert!(same, "in lanes at {x:?}: {many:?}, expected {expected:?}");
        }
    }
}

/// Asserts that each number is close to the expected one. The tolerance is relative to the expected number, or absolute
/// if that is below 1.
#[track_caller]
pub(crate) fn assert_close<R: Real + Into<f64>>(got: &[R], expected: &[R], tolerance: f64) {
    assert_eq!(got.len(), expected.len());
    for (&got, &expected) in got.iter().zip(expected) {
        let (error, size): (f64, f64) = ((got - expected).into(), expected.into());
        let allowed = tolerance * size.abs().max(1.0);
        assert!(error.abs() <= allowed, "{got:?}, not {expected:?}");
    }
}

/// Returns the largest difference between a number and the expected one, relative to the largest expected number.
pub(crate) fn largest_difference<R: Real + Into<f64>>(got: &[R], expected: &[R]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let size = |x: R| x.into().abs();
    let differences = got.iter().zip(expected).map(|(&g, &e)| size(g - e));
    // A NaN counts as the largest difference.
    let error = differences.max_by(f64::total_cmp).unwrap_or(0.0);
    error / expected.iter().map(|&e| size(e)).fold(0.0, f64::max)
}

/// Returns the central difference quotients of all values with respect to one argument. The values are taken at the
/// distance `h` on both sides.
pub(crate) fn differences<R: Real>(
    values: impl Fn(&[R]) -> Vec<R>,
    x: &[R],
    argument: usize,
    h: f64,
) -> Vec<R> {
    let h = R::lit(h);
    let [above, below] = [h, -h].map(|h| {
        let mut x = x.to_vec();
        x[argument] += h;
        values(&x)
    });
    let pairs = above.into_iter().zip(below);
    pairs.map(|(a, b)| (a - b) / (h + h)).collect()
}
