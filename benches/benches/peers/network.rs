//! Measures the computation of a network's loss over a mini-batch, with its gradient. The loss is a sum of squared errors,
//! and tanh is between the layers.

use ndarray::Array2;

use crate::task::{Task, Way, kept};

pub(crate) fn task(sizes: &'static [usize], points: usize) -> Task {
    let case: &'static Case = &kept([Case::new(sizes, points)])[0];
    Task {
        title: format!(
            "Value and gradient of a network's loss, layers of {sizes:?} on {points} points"
        ),
        source: include_str!("network.rs"),
        // The tolerance is for sums of up to 256 terms in a different order, through three layers.
        tolerance: 1e-12,
        ways: vec![
            Way::new("by hand", "ndarray", || hand::gradient(case)),
            Way::new("ours", "`data::Sum`", ours::gradient(case)),
            #[cfg(feature = "candle")]
            Way::new("candle", "`backward`", candle::gradient(case)),
        ],
    }
}

/// A network with tanh between its layers, and points with the values that it should return.
struct Case {
    sizes: &'static [usize],
    /// The parameters of all layers. Each layer has its matrix, row by row, and then its biases.
    parameters: Vec<f64>,
    x: Array2<f64>,
    targets: Vec<f64>,
}

impl Case {
    fn new(sizes: &'static [usize], points: usize) -> Self {
        let number = |i: usize| (0.618_033_988 * (i as f64 + 1.0)).fract() - 0.5;
        let numbers = |count: usize| (0..count).map(number);
        let parameters: usize = sizes.windows(2).map(|s| s[0] * s[1] + s[1]).sum();
        let x = Array2::from_shape_fn((points, sizes[0]), |(i, j)| number(i * sizes[0] + j));
        Self {
            parameters: numbers(parameters).map(|p| 0.3 * p).collect(),
            x,
            targets: numbers(points).collect(),
            sizes,
        }
    }

    /// Returns for each layer the number of inputs, the number of outputs, and the index of its first parameter.
    fn layers(&self) -> Vec<(usize, usize, usize)> {
        let mut first = 0;
        let sizes = self.sizes.windows(2);
        let layer = |s: &[usize]| {
            let begin = first;
            first += s[0] * s[1] + s[1];
            (s[0], s[1], begin)
        };
        sizes.map(layer).collect()
    }
}

/// Returns the value of the loss, followed by its gradient.
fn joined((value, gradient): (f64, Vec<f64>)) -> Vec<f64> {
    [vec![value], gradient].concat()
}

/// The loss by matrix products, with a hand-written reverse sweep.
mod hand {
    use ndarray::linalg::general_mat_mul;
    use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};

    use super::{Case, joined};

    pub(super) fn gradient(case: &Case) -> Vec<f64> {
        let weights = |(inputs, outputs, begin): (usize, usize, usize)| {
            let weights = &case.parameters[begin..][..inputs * outputs];
            ArrayView2::from_shape((outputs, inputs), weights)
                .expect("the slice has the length of the array")
        };
        let layers = case.layers();
        let mut numbers = vec![case.x.clone()];
        for &layer in &layers {
            let (inputs, outputs, begin) = layer;
            let biases = &case.parameters[begin + inputs * outputs..];
            let mut y =
                Array2::from_shape_fn((case.targets.len(), outputs), |(_, row)| biases[row]);
            general_mat_mul(
                1.0,
                &numbers[numbers.len() - 1],
                &weights(layer).t(),
                1.0,
                &mut y,
            );
            if outputs > 1 {
                y.mapv_inplace(f64::tanh);
            }
            numbers.push(y);
        }
        let mut bar = numbers[layers.len()].clone();
        let mut loss = 0.0;
        for (y, target) in bar.iter_mut().zip(&case.targets) {
            let gap = *y - target;
            (loss, *y) = (loss + gap * gap, 2.0 * gap);
        }
        let mut gradient = vec![0.0; case.parameters.len()];
        for (&layer, both) in layers.iter().zip(numbers.windows(2)).rev() {
            let (inputs, outputs, begin) = layer;
            if outputs > 1 {
                bar.zip_mut_with(&both[1], |bar, y| *bar *= 1.0 - y * y);
            }
            let (by_weights, rest) = gradient[begin..].split_at_mut(inputs * outputs);
            let mut by_weights =
                ArrayViewMut2::from_shape((outputs, inputs), by_weights).expect("as above");
            general_mat_mul(1.0, &bar.t(), &both[0], 0.0, &mut by_weights);
            let sums = bar.sum_axis(Axis(0));
            rest[..outputs]
                .iter_mut()
                .zip(sums)
                .for_each(|(to, sum)| *to = sum);
            if begin > 0 {
                bar = bar.dot(&weights(layer));
            }
        }
        joined((loss, gradient))
    }
}

/// The loss of one point as a summand. The library finds the layers and runs in lanes over the points.
mod ours {
    use autodiff::{Real, value_and_gradient};
    use autodiff_programs::data::{Sum, Summand};

    use super::{Case, joined};

    /// The squared error at one point. The last number of the datum is the target.
    #[derive(Clone)]
    struct Network(&'static [usize]);

    impl Summand for Network {
        fn eval<R: Real>(&self, parameters: &[R], datum: &[R]) -> R {
            let (x, target) = datum.split_at(self.0[0]);
            let (mut parameters, mut numbers) = (parameters, x.to_vec());
            for layer in 1..self.0.len() {
                let (inputs, outputs) = (self.0[layer - 1], self.0[layer]);
                let (weights, rest) = parameters.split_at(inputs * outputs);
                let row = |(weights, &bias): (&[R], &R)| {
                    let sum = R::dot(weights, &numbers) + bias;
                    if layer + 1 < self.0.len() {
                        sum.tanh()
                    } else {
                        sum
                    }
                };
                let rows = weights.chunks_exact(inputs).zip(&rest[..outputs]);
                (parameters, numbers) = (&rest[outputs..], rows.map(row).collect());
            }
            let gap = numbers[0] - target[0];
            gap * gap
        }
    }

    pub(super) fn gradient(case: &Case) -> impl Fn() -> Vec<f64> {
        let rows = case.x.rows().into_iter().zip(&case.targets);
        let data = rows.map(|(x, &target)| x.iter().copied().chain([target]).collect());
        let sum = Sum::new(Network(case.sizes), &data.collect::<Vec<Vec<f64>>>());
        move || joined(value_and_gradient(|p| sum.run(p), &case.parameters))
    }
}

/// Tensors of the crate candle. They are variables, and are kept from one gradient to the next.
#[cfg(feature = "candle")]
mod candle {
    use candle_core::{Device, Result, Tensor, Var};

    use super::Case;

    struct Network {
        layers: Vec<[Var; 2]>,
        x: Tensor,
        targets: Tensor,
    }

    impl Network {
        fn new(case: &Case) -> Result<Self> {
            let (cpu, points) = (&Device::Cpu, case.targets.len());
            let layer = |(inputs, outputs, begin)| {
                let (weights, rest) = case.parameters[begin..].split_at(inputs * outputs);
                let weights = Tensor::from_slice(weights, (outputs, inputs), cpu)?;
                let biases = Tensor::from_slice(&rest[..outputs], outputs, cpu)?;
                Ok([Var::from_tensor(&weights)?, Var::from_tensor(&biases)?])
            };
            let x: Vec<f64> = case.x.iter().copied().collect();
            Ok(Self {
                layers: case
                    .layers()
                    .into_iter()
                    .map(layer)
                    .collect::<Result<_>>()?,
                x: Tensor::from_vec(x, (points, case.sizes[0]), cpu)?,
                targets: Tensor::from_slice(&case.targets, (points, 1), cpu)?,
            })
        }

        fn gradient(&self) -> Result<Vec<f64>> {
            let mut x = self.x.clone();
            for (k, [weights, biases]) in self.layers.iter().enumerate() {
                x = x.matmul(&weights.t()?)?.broadcast_add(biases)?;
                if k + 1 < self.layers.len() {
                    x = x.tanh()?;
                }
            }
            let loss = (x - &self.targets)?.sqr()?.sum_all()?;
            let gradients = loss.backward()?;
            let mut all = vec![loss.to_scalar()?];
            for parameter in self.layers.iter().flatten() {
                let gradient = gradients
                    .get(parameter)
                    .expect("the loss depends on every parameter");
                all.extend(gradient.flatten_all()?.to_vec1::<f64>()?);
            }
            Ok(all)
        }
    }

    pub(super) fn gradient(case: &Case) -> impl Fn() -> Vec<f64> {
        let network = Network::new(case).expect("shapes agree");
        move || network.gradient().expect("shapes agree")
    }
}
