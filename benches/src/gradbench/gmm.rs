//! The log-likelihood of a Gaussian mixture: [`adbench`](crate::adbench::gmm)'s, its Wishart term with the
//! other sign.

use serde::Deserialize;
use serde_json::json;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, Work, flat, read, require};
use crate::adbench::Problem;
use crate::adbench::gmm::{Gmm, GmmInput, Wishart};

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

struct Mixture {
    gmm: Gmm,
    d: usize,
    k: usize,
}

struct Objective(Mixture);

impl Work for Objective {
    fn run(&mut self) {
        self.0.gmm.objective();
    }
    fn answer(&self) -> serde_json::Result<String> {
        serde_json::to_string(&self.0.gmm.value())
    }
}

struct Jacobian(Mixture);

impl Work for Jacobian {
    fn run(&mut self) {
        self.0.gmm.derivative();
    }
    fn answer(&self) -> serde_json::Result<String> {
        let Mixture { gmm, d, k } = &self.0;
        let (alpha, rest) = gmm.gradient().split_at(*k);
        let (mu, factors) = rest.split_at(k * d);
        let factors = factors
            .chunks(d * (d + 1) / 2)
            .map(|factor| factor.split_at(*d));
        let (q, l): (Vec<_>, Vec<_>) = factors.unzip();
        let mu: Vec<_> = mu.chunks(*d).collect();
        serde_json::to_string(&json!({ "alpha": alpha, "mu": mu, "q": q, "l": l }))
    }
}

impl Input {
    fn mixture(self) -> Result<Mixture, Refusal> {
        let Input { d, k, m, gamma, .. } = self;
        require(
            d > 0 && !self.x.is_empty(),
            "one dimension at least, and one point",
        )?;
        let lengths = [
            &self.alpha.len(),
            &self.mu.len(),
            &self.q.len(),
            &self.l.len(),
        ];
        require(
            k > 0 && lengths.iter().all(|&&len| len == k),
            "one of each for a component",
        )?;
        flat(&self.x, d, "the points are not of dimension d")?;
        let mut parameters = self.alpha;
        parameters.extend(flat(&self.mu, d, "the means are not of dimension d")?);
        flat(&self.q, d, "the diagonals are not of dimension d")?;
        flat(
            &self.l,
            d * (d - 1) / 2,
            "the lower parts are not of dimension d",
        )?;
        for (q, l) in self.q.iter().zip(&self.l) {
            parameters.extend(q);
            parameters.extend(l);
        }
        let input = GmmInput {
            dimension: d,
            components: k,
            parameters,
            points: self.x,
            wishart: Wishart {
                gamma,
                m,
                sign: 1.0,
            },
        };
        let gmm = Gmm::new(input);
        Ok(Mixture { gmm, d, k })
    }
}

/// Functions `objective` and `jacobian`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let mixture = read::<Input>(input)?.mixture()?;
    match function {
        "objective" => Ok(Box::new(Objective(mixture))),
        "jacobian" => Ok(Box::new(Jacobian(mixture))),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
