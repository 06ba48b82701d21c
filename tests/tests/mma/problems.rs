//! The optimisation problems of the reference files. Each is written once, for all number types `Real`.
//!
//! The beginning of a file's `statement` determines the problem; everything else is read from its `data`. A new kind of
//! problem is a function and a row in `KINDS`.

use autodiff::{Real, jacobian};
use serde::Deserialize;
use serde_json::Value;

/// An optimisation problem: the objective `f_0`, the constraints `f_1, ... f_m`, and their derivatives.
pub(crate) trait Problem {
    /// Returns the values of all functions at `x`, and a matrix with the gradient of each function as a row.
    fn linearise(&self, x: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>);
}

/// The functions of a problem, `f_0` to `f_m`, for all number types.
trait Values {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R>;
}

impl<F: Values> Problem for F {
    fn linearise(&self, x: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let rows = jacobian(|x| self.eval(x), x);
        (self.eval(x), rows.iter().map(<[f64]>::to_vec).collect())
    }
}

type Build = fn(Value) -> Result<Box<dyn Problem>, serde_json::Error>;

/// For each kind of problem: how its statement begins, and the function that builds it from the data.
const KINDS: [(&str, Build); 7] = [
    (
        "min C1*sum_j x_j ; g = sum_j A_j/x_j^3",
        build::<Cantilever>,
    ),
    (
        "min sum (x_j-t_j)^2 ; g_i = sum_j A_ij x_j + 0.1 A_ij^2",
        build::<Distance>,
    ),
    ("min sum_{j<n-1} b (x_{j+1}-x_j^2)^2", build::<Rosenbrock>),
    ("min sum al_j/x_j + be_j (x_j-t_j)^2", build::<Separable>),
    ("min sum x_j^2 ; g_i = sum_j (x_j-c_ij)^2", build::<Spheres>),
    ("x=(a,h); min C1*a*sqrt(1+h^2)", build::<TwoBar>),
    ("z (E x 3, row-major, x[3e+k])", build::<Volume>),
];

/// Builds the problem that a file states.
///
/// # Panics
/// If no kind has this statement, or the data do not fit the kind.
pub(crate) fn problem(statement: &str, data: Value) -> Box<dyn Problem> {
    let kind = KINDS.iter().find(|(start, _)| statement.starts_with(start));
    let Some((_, build)) = kind else {
        panic!("unknown problem {statement:?}; add it to KINDS");
    };
    build(data).unwrap_or_else(|error| panic!("the data of {statement:?} do not fit: {error}"))
}

fn build<F>(data: Value) -> Result<Box<dyn Problem>, serde_json::Error>
where
    F: Values + for<'a> Deserialize<'a> + 'static,
{
    Ok(Box::new(serde_json::from_value::<F>(data)?))
}

/// The sum of `term(j)` over `j` from 0 to `count - 1`.
fn sum<R: Real>(count: usize, term: impl Fn(usize) -> R) -> R {
    (0..count).fold(R::zero(), |sum, j| sum + term(j))
}

#[derive(Deserialize)]
struct Cantilever {
    #[serde(rename = "A")]
    moments: Vec<f64>,
    #[serde(rename = "C1")]
    weight: f64,
    #[serde(rename = "C2")]
    bound: f64,
}

impl Values for Cantilever {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let weight = R::lit(self.weight) * sum(x.len(), |j| x[j]);
        let deflection = sum(x.len(), |j| R::lit(self.moments[j]) / x[j].powi(3));
        vec![weight, deflection - R::lit(self.bound)]
    }
}

/// A problem that minimises the squared distance to a target, with slightly curved constraints.
#[derive(Deserialize)]
struct Distance {
    #[serde(rename = "t")]
    target: Vec<f64>,
    #[serde(rename = "A")]
    rows: Vec<Vec<f64>>,
    rhs: Vec<f64>,
}

impl Values for Distance {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let objective = sum(x.len(), |j| (x[j] - R::lit(self.target[j])).powi(2));
        let constraint = |(row, &rhs): (&Vec<f64>, &f64)| {
            let term =
                |j: usize| R::lit(row[j]) * x[j] + R::lit(0.1 * row[j] * row[j]) * x[j].powi(2);
            sum(x.len(), term) - R::lit(rhs)
        };
        let constraints = self.rows.iter().zip(&self.rhs).map(constraint);
        std::iter::once(objective).chain(constraints).collect()
    }
}

#[derive(Deserialize)]
struct Rosenbrock {
    a: f64,
    b: f64,
    #[serde(rename = "A")]
    row: Vec<f64>,
    rhs: f64,
}

impl Values for Rosenbrock {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let valley = |j: usize| {
            R::lit(self.b) * (x[j + 1] - x[j] * x[j]).powi(2) + (R::lit(self.a) - x[j]).powi(2)
        };
        let line = sum(x.len(), |j| R::lit(self.row[j]) * x[j]);
        vec![sum(x.len() - 1, valley), line - R::lit(self.rhs)]
    }
}

#[derive(Deserialize)]
struct Separable {
    al: Vec<f64>,
    be: Vec<f64>,
    t: Vec<f64>,
    #[serde(rename = "A")]
    linear: Vec<Vec<f64>>,
    #[serde(rename = "B")]
    square: Vec<Vec<f64>>,
    rhs: Vec<f64>,
}

impl Values for Separable {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let objective = sum(x.len(), |j| {
            R::lit(self.al[j]) / x[j] + R::lit(self.be[j]) * (x[j] - R::lit(self.t[j])).powi(2)
        });
        let constraint = |i: usize| {
            let (linear, square) = (&self.linear[i], &self.square[i]);
            let term = |j: usize| R::lit(linear[j]) * x[j] + R::lit(square[j]) * x[j] * x[j];
            sum(x.len(), term) - R::lit(self.rhs[i])
        };
        let constraints = (0..self.rhs.len()).map(constraint);
        std::iter::once(objective).chain(constraints).collect()
    }
}

#[derive(Deserialize)]
struct Spheres {
    #[serde(rename = "c")]
    centres: Vec<Vec<f64>>,
    r2: f64,
}

impl Values for Spheres {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let objective = sum(x.len(), |j| x[j] * x[j]);
        let constraint = |centre: &Vec<f64>| {
            sum(x.len(), |j| (x[j] - R::lit(centre[j])).powi(2)) - R::lit(self.r2)
        };
        let constraints = self.centres.iter().map(constraint);
        std::iter::once(objective).chain(constraints).collect()
    }
}

#[derive(Deserialize)]
struct TwoBar {
    #[serde(rename = "C1")]
    weight: f64,
    #[serde(rename = "C2")]
    stress: f64,
}

impl Values for TwoBar {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let (area, half) = (x[0], x[1]);
        let length = (R::one() + half * half).sqrt();
        let (vertical, horizontal) = (R::lit(8.0) / area, (area * half).recip());
        let stress = |sum: R| R::lit(self.stress) * length * sum - R::one();
        vec![
            R::lit(self.weight) * area * length,
            stress(vertical + horizontal),
            stress(vertical - horizontal),
        ]
    }
}

/// A problem with the four volume constraints of the design problem.
#[derive(Deserialize)]
struct Volume {
    w: Vec<[f64; 3]>,
    beta: f64,
    #[serde(rename = "Vlo")]
    volume_least: f64,
    #[serde(rename = "Vhi")]
    volume_most: f64,
    #[serde(rename = "Alo")]
    active_least: f64,
    #[serde(rename = "Ahi")]
    active_most: f64,
}

impl Values for Volume {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let edges = R::lit(self.w.len() as f64);
        let mixtures: Vec<[R; 3]> = x.chunks_exact(3).map(|z| self.mixture(z)).collect();
        let gain = sum(mixtures.len(), |e| {
            sum(3, |k| R::lit(self.w[e][k]) * mixtures[e][k])
        });
        let square = sum(x.len(), |j| x[j] * x[j]) / R::lit(x.len() as f64);
        let volume = sum(mixtures.len(), |e| mixtures[e][1] + mixtures[e][2]) / edges;
        let active = sum(mixtures.len(), |e| mixtures[e][2]) / edges;
        vec![
            R::lit(0.05) * square - gain / edges,
            volume - R::lit(self.volume_most),
            R::lit(self.volume_least) - volume,
            active - R::lit(self.active_most),
            R::lit(self.active_least) - active,
        ]
    }
}

impl Volume {
    fn mixture<R: Real>(&self, z: &[R]) -> [R; 3] {
        let weights = [0, 1, 2].map(|k| (R::lit(self.beta) * z[k]).exp());
        let total = weights[0] + weights[1] + weights[2];
        weights.map(|weight| weight / total)
    }
}
