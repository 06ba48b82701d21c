//! Trains a network of 12 neurons by Adam to recognise points on a ring.
use autodiff::{Real, gradient};
use autodiff_programs::data::{Sum, Summand};

/// Returns the log-odds that the point `[x, y]` is on the ring. Each neuron has four numbers in `net`: the weight of x,
/// the weight of y, the bias and the output weight. The last number of `net` is the output bias.
#[inline(always)]
fn log_odds<R: Real>(net: &[R], [x, y]: [R; 2]) -> R {
    let mut sum = net[48];
    for neuron in net.chunks_exact(4) {
        sum += neuron[3] * (neuron[0] * x + neuron[1] * y + neuron[2]).tanh();
    }
    sum
}

#[derive(Clone)]
struct CrossEntropy;
impl Summand for CrossEntropy {
    fn eval<R: Real>(&self, net: &[R], datum: &[R]) -> R {
        (-datum[2] * log_odds(net, [datum[0], datum[1]])).softplus() // labels are -1 or 1
    }
}

fn main() {
    let point = |i| [i % 30, i / 30].map(|k| f64::from(k) / 10.0 - 1.45);
    let label = |[x, y]: [f64; 2]| [x, y, (0.3 - (x.hypot(y) - 0.9).abs()).signum()];
    let data: Vec<_> = (0..900).map(point).map(label).collect();
    let loss = Sum::new(CrossEntropy, &data);
    let mut net: Vec<_> = (1..50).map(|i| 2.0 * f64::from(i * i).sin()).collect();
    let mut moments = [[0.0, 1.0]; 49];
    for _ in 0..1500 {
        let slope = gradient(|net| loss.run(net), &net);
        for ((x, m), slope) in net.iter_mut().zip(&mut moments).zip(slope) {
            *m = [0.9 * m[0] + 0.1 * slope, 0.99 * m[1] + 0.01 * slope.powi(2)];
            *x -= 0.03 * m[0] / m[1].sqrt();
        }
    }
    println!("mean cross entropy {:.4}", loss.run(&net) / 900.0);
    assert!(loss.run(&net) < 45.0);
}
