//! A network's loss over a mini-batch, with its gradient: `batch::Sum` and `fused::dense_batch`, beside
//! matrix products called by hand from ndarray. Answers are compared before anything is timed.
//!
//! `cargo bench -p benches --bench mlp --features rivals`

use std::hint::black_box;
use std::time::Instant;

use autodiff::batch::{Sum, Summand};
use autodiff::fused::dense_batch;
use autodiff::{Real, Var, value_and_gradient_of};
use ndarray::linalg::general_mat_mul;
use ndarray::{Array2, ArrayView2, ArrayViewMut2, Axis};

/// Times that each way is measured, in turns; the least counts.
const ROUNDS: usize = 200;

fn main() {
    for (sizes, points) in [
        (vec![64, 128, 128, 1], 256),
        (vec![256, 256, 256, 1], 64),
        (vec![8, 16, 16, 1], 256),
    ] {
        compare(&Case::new(sizes, points));
    }
}

/// A network with tanh between its layers, and points with the values that it is to have there.
struct Case {
    sizes: Vec<usize>,
    /// For each layer its matrix, row by row, and its biases.
    parameters: Vec<f64>,
    x: Array2<f64>,
    targets: Vec<f64>,
}

impl Case {
    fn new(sizes: Vec<usize>, points: usize) -> Self {
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

    fn sum(&self) -> Sum<Network> {
        let rows = self.x.rows().into_iter().zip(&self.targets);
        let data: Vec<Vec<f64>> = rows
            .map(|(x, &target)| x.iter().copied().chain([target]).collect())
            .collect();
        Sum::new(Network(self.sizes.clone()), &data)
    }

    /// The inputs and outputs of each layer, and where its parameters begin.
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

/// The squared error at a point, whose target is the datum's last number.
#[derive(Clone)]
struct Network(Vec<usize>);

impl Summand for Network {
    fn scratch(&self) -> usize {
        self.0.iter().sum()
    }

    #[inline(always)]
    fn eval<R: Real>(&self, parameters: &[R], datum: &[R], scratch: &mut [R]) -> R {
        let (x, target) = datum.split_at(self.0[0]);
        scratch[..x.len()].copy_from_slice(x);
        let (mut parameters, mut numbers) = (parameters, scratch);
        for layer in 1..self.0.len() {
            let (inputs, outputs) = (self.0[layer - 1], self.0[layer]);
            let (weights, rest) = parameters.split_at(inputs * outputs);
            let (x, y) = numbers.split_at_mut(inputs);
            for row in 0..outputs {
                let sum = R::dot(&weights[row * inputs..][..inputs], x) + rest[row];
                y[row] = if layer + 1 < self.0.len() {
                    sum.tanh()
                } else {
                    sum
                };
            }
            (parameters, numbers) = (&rest[outputs..], y);
        }
        let gap = numbers[0] - target[0];
        gap * gap
    }
}

/// Layer by layer over all points, each an entry of the tape.
fn by_layers(case: &Case) -> (f64, Vec<f64>) {
    let loss = |parameters: &[Var<f64>]| {
        let mut x: Vec<Var<f64>> = case.x.iter().map(|&x| Var::lit(x)).collect();
        for (inputs, outputs, begin) in case.layers() {
            let (weights, rest) = parameters[begin..].split_at(inputs * outputs);
            x = dense_batch(weights, &x, &rest[..outputs]);
            if outputs > 1 {
                x.iter_mut().for_each(|x| *x = Real::tanh(*x));
            }
        }
        let targets = x.iter().zip(&case.targets);
        let gaps: Vec<Var<f64>> = targets.map(|(&x, &t)| x - Var::lit(t)).collect();
        Real::dot(&gaps, &gaps)
    };
    value_and_gradient_of(loss, &case.parameters)
}

fn by_hand(case: &Case) -> (f64, Vec<f64>) {
    let weights = |(inputs, outputs, begin): (usize, usize, usize)| {
        let weights = &case.parameters[begin..][..inputs * outputs];
        ArrayView2::from_shape((outputs, inputs), weights).expect("the length was taken")
    };
    let layers = case.layers();
    let mut numbers = vec![case.x.clone()];
    for &layer in &layers {
        let (inputs, outputs, begin) = layer;
        let biases = &case.parameters[begin + inputs * outputs..];
        let mut y = Array2::from_shape_fn((case.targets.len(), outputs), |(_, row)| biases[row]);
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
    (loss, gradient)
}

fn compare(case: &Case) {
    let sum = case.sum();
    let by_sum = || value_and_gradient_of(|p| sum.run(p), &case.parameters);
    type Way<'a> = (&'a str, &'a dyn Fn() -> (f64, Vec<f64>));
    let ways: [Way; 3] = [
        ("by hand, ndarray", &|| by_hand(case)),
        ("`batch::Sum`", &by_sum),
        ("`fused::dense_batch`", &|| by_layers(case)),
    ];
    let (loss, gradient) = ways[0].1();
    let scale = gradient.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
    for (name, way) in ways {
        let (other, slopes) = way();
        assert!(
            (other / loss - 1.0).abs() < 1e-12,
            "{name}: {other} and {loss}"
        );
        for (a, b) in gradient.iter().zip(slopes) {
            assert!((a - b).abs() < 1e-12 * scale, "{name}: {a} and {b}");
        }
    }
    let mut least = [f64::INFINITY; 3];
    for _ in 0..ROUNDS {
        for (least, (_, way)) in least.iter_mut().zip(ways) {
            let start = Instant::now();
            black_box(way());
            *least = least.min(start.elapsed().as_secs_f64());
        }
    }
    println!("{:?} on {} points", case.sizes, case.targets.len());
    for (time, (name, _)) in least.iter().zip(ways) {
        println!("  {name:22} {:8.1} us {:6.2}", time * 1e6, time / least[0]);
    }
}
