//! The log-likelihood of points under a Gaussian mixture with a Wishart prior.

use std::f64::consts::PI;

use autodiff::{Function, Real, gradient};
use autodiff_programs::data::{Sum, Summand};
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::work::{Error, Prepared, flat, read, require, reusing, work};

/// The input from GradBench. Each component has a triangular factor `Q` of its inverse covariance. It is given by the
/// logarithms `q` of its diagonal and the part `l` below the diagonal, column by column.
#[derive(Deserialize)]
struct Input {
    d: usize,
    k: usize,
    x: Vec<Vec<f64>>,
    m: f64,
    gamma: f64,
    alpha: Vec<f64>,
    mu: Vec<Vec<f64>>,
    q: Vec<Vec<f64>>,
    l: Vec<Vec<f64>>,
}

/// The log-likelihood as a function of the parameters.
struct Mixture {
    shape: Shape,
    points: usize,
    m: f64,
    gamma: f64,
    likelihood: Sum<Likelihood>,
}

/// The numbers of dimensions and components.
#[derive(Clone, Copy, Debug)]
struct Shape {
    d: usize,
    k: usize,
}

impl Shape {
    /// Returns the number of entries of a triangular factor.
    #[inline(always)]
    fn factor(self) -> usize {
        self.d * (self.d + 1) / 2
    }

    /// Returns the number of arguments that [`Likelihood`] has for each component.
    #[inline(always)]
    fn packed(self) -> usize {
        1 + self.d + self.factor()
    }

    /// Returns a gradient in the form of the input, with a list for each kind of parameter.
    fn parts(self, gradient: &[f64]) -> Value {
        let Self { d, k } = self;
        let (alpha, rest) = gradient.split_at(k);
        let (mu, factors) = rest.split_at(k * d);
        let factors = factors.chunks(self.factor());
        let (q, l): (Vec<_>, Vec<_>) = factors.map(|factor| factor.split_at(d)).unzip();
        let mu: Vec<_> = mu.chunks(d).collect();
        json!({ "alpha": alpha, "mu": mu, "q": q, "l": l })
    }
}

/// The term of one point `x`: the logarithm of `sum_k exp(c_k - |Q_k (x - mu_k)|^2 / 2)`. The shared parameters are,
/// for each component `k`, the numbers `c`, `mu` and the lower triangle of `Q`, row by row.
#[derive(Clone, Debug)]
struct Likelihood(Shape);

impl Summand for Likelihood {
    fn eval<R: Real>(&self, shared: &[R], x: &[R]) -> R {
        let d = self.0.d;
        let (mut offset, mut y) = (vec![R::zero(); d], vec![R::zero(); d]);
        let mut exponents = vec![R::zero(); self.0.k];
        for k in 0..self.0.k {
            let component = &shared[k * self.0.packed()..][..self.0.packed()];
            let (mean, factor) = component[1..].split_at(d);
            for i in 0..d {
                offset[i] = x[i] - mean[i];
            }
            for i in 0..d {
                y[i] = R::dot(&factor[i * (i + 1) / 2..][..=i], &offset[..=i]);
            }
            exponents[k] = R::dot(&y, &y).fma(R::lit(-0.5), component[0]);
        }
        log_sum_exp(&mut exponents)
    }
}

/// Returns `ln sum exp(v)`. The largest entry, as a constant, is subtracted before the exponentials are taken, so that
/// they do not overflow. Overwrites `v`.
#[inline(always)]
fn log_sum_exp<R: Real>(v: &mut [R]) -> R {
    let mut largest = v[0];
    for &entry in &v[1..] {
        largest = entry.max(largest);
    }
    let largest = largest.detach();
    for entry in &mut *v {
        *entry -= largest;
    }
    for entry in &mut *v {
        *entry = entry.exp();
    }
    R::sum_of(v).ln() + largest
}

impl Function for Mixture {
    fn eval<R: Real>(&self, parameters: &[R]) -> R {
        let Shape { d, k } = self.shape;
        let (weights, rest) = parameters.split_at(k);
        let (means, factors) = rest.split_at(k * d);
        let mut packed = Vec::with_capacity(k * self.shape.packed());
        let mut prior = R::zero();
        let half_square = R::lit(0.5 * self.gamma * self.gamma);
        let parts = means.chunks(d).zip(factors.chunks(self.shape.factor()));
        for (&weight, (mean, factor)) in weights.iter().zip(parts) {
            let (logarithms, below) = factor.split_at(d);
            let diagonal: Vec<R> = logarithms.iter().map(|q| q.exp()).collect();
            let sum = R::sum_of(logarithms);
            let squares = R::dot(&diagonal, &diagonal) + R::dot(below, below);
            prior += R::lit(self.m) * sum - half_square * squares;
            packed.push(weight + sum);
            packed.extend_from_slice(mean);
            pack_rows(&mut packed, &diagonal, below);
        }
        let normaliser = log_sum_exp(&mut weights.to_vec());
        self.likelihood.run(&packed) - R::lit(self.points as f64) * normaliser
            + prior
            + R::lit(self.constant())
    }
}

/// Appends a lower triangle row by row. It is given by its diagonal and the part below the diagonal, column by column.
fn pack_rows<R: Real>(packed: &mut Vec<R>, diagonal: &[R], below: &[R]) {
    let d = diagonal.len();
    for (row, &last) in diagonal.iter().enumerate() {
        // Column j begins after j columns of lengths d - 1, d - 2, ...
        let entry = |j: usize| below[j * (2 * d - j - 1) / 2 + row - j - 1];
        packed.extend((0..row).map(entry));
        packed.push(last);
    }
}

impl Mixture {
    /// Returns the sum of all terms that do not depend on the parameters.
    fn constant(&self) -> f64 {
        let d = self.shape.d as f64;
        let freedom = d + self.m + 1.0;
        let gammas = (0..self.shape.d).map(|j| libm::lgamma(0.5 * (freedom - j as f64)));
        let log_gamma = 0.25 * d * (d - 1.0) * PI.ln() + gammas.sum::<f64>();
        let wishart = freedom * d * (self.gamma.ln() - 0.5 * 2.0_f64.ln()) - log_gamma;
        self.shape.k as f64 * wishart - 0.5 * self.points as f64 * d * (2.0 * PI).ln()
    }
}

impl Input {
    /// Returns the log-likelihood and all parameters: the weights, the means, and then for each factor `q` and `l`.
    fn mixture(self) -> Result<(Mixture, Vec<f64>), Error> {
        let Self { d, k, x, .. } = self;
        require(
            d > 0 && k > 0 && !x.is_empty(),
            "`d` and `k` must be 1 or more, and `x` must not be empty",
        )?;
        let components = [&self.mu, &self.q, &self.l].map(Vec::len);
        let fits = components == [k; 3] && self.alpha.len() == k;
        require(fits, "`alpha`, `mu`, `q` and `l` must have `k` entries")?;
        flat(&x, d, "each row of `x` must have `d` numbers")?;
        let mut parameters = self.alpha;
        parameters.extend(flat(&self.mu, d, "each row of `mu` must have `d` numbers")?);
        flat(&self.q, d, "each row of `q` must have `d` numbers")?;
        flat(
            &self.l,
            d * (d - 1) / 2,
            "each row of `l` must have d(d-1)/2 numbers",
        )?;
        for (q, l) in self.q.iter().zip(&self.l) {
            parameters.extend(q);
            parameters.extend(l);
        }
        let shape = Shape { d, k };
        let mixture = Mixture {
            shape,
            points: x.len(),
            m: self.m,
            gamma: self.gamma,
            likelihood: Sum::new(Likelihood(shape), &x),
        };
        Ok((mixture, parameters))
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let (mixture, parameters) = read::<Input>(input)?.mixture()?;
    let shape = mixture.shape;
    match function {
        "objective" => work(move || mixture.eval(&parameters)),
        "jacobian" => {
            let run = move |slope: &mut _| *slope = gradient(|x| mixture.eval(x), &parameters);
            reusing(Vec::new(), run, move |slope| shape.parts(slope))
        }
        _ => Error::function(function),
    }
}
