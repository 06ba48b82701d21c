//! The log-likelihood of a Gaussian mixture, with a Wishart term.

use std::f64::consts::PI;
use std::path::Path;

use autodiff::data::{Sum, Summand};
use autodiff::{Function, Real, Tape};
use serde_json::{Value, json};

use super::Problem;
use super::input::{self, Error, Tokens};

/// An instance, with memory for its results.
pub struct Gmm {
    mixture: Mixture,
    /// Weights, means and factors, in the order of the file.
    parameters: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
    /// Recorded anew for every derivative, in the same memory.
    tape: Tape<f64>,
}

/// What an instance is made of.
#[derive(Clone, Debug)]
pub struct GmmInput {
    /// The number of dimensions.
    pub dimension: usize,
    /// The number of components.
    pub components: usize,
    /// The weights of all components, their means, then their factors: each the logarithms of its
    /// diagonal and the part below, column by column.
    pub parameters: Vec<f64>,
    /// The points.
    pub points: Vec<Vec<f64>>,
    /// The Wishart term's parameters.
    pub wishart: Wishart,
}

/// The parameters of the Wishart term.
#[derive(Clone, Copy, Debug)]
pub struct Wishart {
    /// The inverse of the scale.
    pub gamma: f64,
    /// Degrees of freedom, those beyond the dimension and one.
    pub m: f64,
    /// 1 where the term is the logarithm of a density; -1 in ADBench, which has it the other way round.
    pub sign: f64,
}

/// The objective as a function of the parameters.
struct Mixture {
    shape: Shape,
    points: usize,
    wishart: Wishart,
    likelihood: Sum<Likelihood>,
}

/// The number of dimensions and of components.
#[derive(Clone, Copy, Debug)]
struct Shape {
    dimension: usize,
    components: usize,
}

impl Shape {
    /// The entries of a factor.
    fn factor(self) -> usize {
        self.dimension * (self.dimension + 1) / 2
    }

    /// Numbers of a component in the arguments of [`Likelihood`].
    #[inline(always)]
    fn packed(self) -> usize {
        1 + self.dimension + self.dimension * (self.dimension + 1) / 2
    }
}

/// A point's logarithm of `sum_k exp(c_k - |Q_k (x - mu_k)|^2 / 2)`. The shared numbers are, per
/// component, `c`, `mu` and the lower triangle of `Q` row by row.
#[derive(Clone, Debug)]
struct Likelihood(Shape);

impl Summand for Likelihood {
    fn eval<R: Real>(&self, shared: &[R], x: &[R]) -> R {
        let d = self.0.dimension;
        let (mut offset, mut y) = (vec![R::zero(); d], vec![R::zero(); d]);
        let mut exponents = vec![R::zero(); self.0.components];
        for k in 0..self.0.components {
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

/// `ln sum exp(v)`, the largest entry held constant and taken out first. Destroys `v`.
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
        let Shape {
            dimension: d,
            components,
        } = self.shape;
        let (weights, rest) = parameters.split_at(components);
        let (means, factors) = rest.split_at(components * d);
        let mut packed = Vec::with_capacity(components * self.shape.packed());
        let mut prior = R::zero();
        let Wishart { gamma, m, sign } = self.wishart;
        let (half_square, m) = (R::lit(0.5 * sign * gamma * gamma), R::lit(sign * m));
        let parts = means.chunks(d).zip(factors.chunks(self.shape.factor()));
        for (&weight, (mean, factor)) in weights.iter().zip(parts) {
            let (logarithms, below) = factor.split_at(d);
            let diagonal: Vec<R> = logarithms.iter().map(|q| q.exp()).collect();
            let sum = R::sum_of(logarithms);
            let squares = R::dot(&diagonal, &diagonal) + R::dot(below, below);
            prior += m * sum - half_square * squares;
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

/// Appends the rows of a lower triangle whose part below the diagonal comes column by column.
fn pack_rows<R: Real>(packed: &mut Vec<R>, diagonal: &[R], below: &[R]) {
    let d = diagonal.len();
    for (row, &last) in diagonal.iter().enumerate() {
        // Column j begins after its j predecessors, of lengths d - 1, d - 2, ...
        let entry = |j: usize| below[j * (2 * d - j - 1) / 2 + row - j - 1];
        packed.extend((0..row).map(entry));
        packed.push(last);
    }
}

impl Mixture {
    /// The terms that depend on no parameter.
    fn constant(&self) -> f64 {
        let d = self.shape.dimension as f64;
        let Wishart { gamma, m, sign } = self.wishart;
        let freedom = d + m + 1.0;
        let wishart = freedom * d * (gamma.ln() - 0.5 * 2.0_f64.ln())
            - log_gamma_of_dimension(0.5 * freedom, self.shape.dimension);
        let components = self.shape.components as f64;
        sign * components * wishart - 0.5 * self.points as f64 * d * (2.0 * PI).ln()
    }
}

/// The logarithm of the gamma function of dimension `d`.
fn log_gamma_of_dimension(a: f64, d: usize) -> f64 {
    let terms = (1..=d).map(|j| log_gamma(a + 0.5 * (1.0 - j as f64)));
    0.25 * (d * (d - 1)) as f64 * PI.ln() + terms.sum::<f64>()
}

/// The logarithm of the gamma function, for positive arguments: Stirling's series, from an
/// argument that is large enough for it.
fn log_gamma(x: f64) -> f64 {
    const LARGE: f64 = 16.0;
    /// `B_2k / (2k (2k - 1))`.
    const SERIES: [f64; 6] = [
        1.0 / 12.0,
        -1.0 / 360.0,
        1.0 / 1260.0,
        -1.0 / 1680.0,
        1.0 / 1188.0,
        -691.0 / 360360.0,
    ];
    let (mut large, mut product) = (x, 1.0);
    while large < LARGE {
        product *= large;
        large += 1.0;
    }
    let inverse_square = 1.0 / (large * large);
    let series = SERIES
        .iter()
        .rev()
        .fold(0.0, |sum, c| sum * inverse_square + c)
        / large;
    (large - 0.5) * large.ln() - large + 0.5 * (2.0 * PI).ln() + series - product.ln()
}

impl Gmm {
    /// An instance.
    ///
    /// # Panics
    /// If there are not as many parameters as the shape has, or points of another dimension.
    pub fn new(input: GmmInput) -> Self {
        let shape = Shape {
            dimension: input.dimension,
            components: input.components,
        };
        assert_eq!(input.parameters.len(), shape.components * shape.packed());
        let mixture = Mixture {
            shape,
            points: input.points.len(),
            likelihood: Sum::new(Likelihood(shape), &input.points),
            wishart: input.wishart,
        };
        Self {
            mixture,
            parameters: input.parameters,
            value: 0.0,
            gradient: Vec::new(),
            tape: Tape::new(),
        }
    }

    /// Reads an instance.
    ///
    /// # Errors
    /// If the file cannot be read or is not in the format.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = input::read(path)?;
        let mut tokens = Tokens::new(path, &text);
        let (dimension, components, points) = (tokens.count()?, tokens.count()?, tokens.count()?);
        let shape = Shape {
            dimension,
            components,
        };
        let parameters = components.checked_mul(shape.packed());
        let parameters = parameters.ok_or_else(|| tokens.error("is too large"))?;
        let input = GmmInput {
            dimension,
            components,
            parameters: tokens.numbers(parameters)?,
            points: (0..points)
                .map(|_| tokens.numbers(dimension))
                .collect::<Result<_, _>>()?,
            wishart: Wishart {
                gamma: tokens.next()?,
                m: tokens.next::<u32>()?.into(),
                sign: -1.0,
            },
        };
        tokens.end()?;
        Ok(Self::new(input))
    }

    /// The value that was found last.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// The gradient that was found last.
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}

impl Problem for Gmm {
    fn objective(&mut self) {
        self.value = self.mixture.eval(&self.parameters);
    }

    fn derivative(&mut self) {
        let (tape, mixture) = (&mut self.tape, &self.mixture);
        let value = tape.record(&self.parameters, |x| mixture.eval(x));
        self.value = value.value();
        self.gradient.clear();
        let gradient = tape.pullback(&[value], &[1.0]);
        self.gradient.extend_from_slice(gradient);
    }

    fn answer(&self) -> Value {
        json!({ "objective": self.value, "gradient": self.gradient })
    }
}

#[cfg(test)]
mod tests {
    use super::log_gamma;

    #[test]
    fn log_gamma_knows_factorials_and_the_square_root_of_pi() {
        let mut factorial = 1.0_f64;
        for n in 1..30 {
            let error = log_gamma(f64::from(n)) - factorial.ln();
            // A few roundings of terms near n ln n.
            assert!(
                error.abs() <= 1e-14 * factorial.ln().max(1.0),
                "{n}: {error:e}"
            );
            factorial *= f64::from(n);
        }
        let half = log_gamma(0.5) - 0.5 * std::f64::consts::PI.ln();
        assert!(half.abs() <= 1e-14, "{half:e}");
    }
}
