//! A neural ODE: a network learns the growth law of a population from hourly counts. The gradients go through the
//! one-minute steps between the counts.
//!
//! `cargo run -p cosmic-autodiff --example neural_ode`

use autodiff::{Real, Var, gradient};
use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};

/// A time step of one minute, in which the population grows at the rate that the network returns.
#[derive(Clone)]
struct Minute;
#[kernel]
impl Kernel<2, 1> for Minute {
    fn eval<R: Real>(&self, [x, rate]: [R; 2], _: &[R]) -> [R; 1] {
        [x + R::lit(1.0 / 60.0) * rate]
    }
}
impl Model for Minute {
    fn record(&self, program: &mut Program) {
        let (w1, b1) = (program.matrix(8, 1), program.parameter(8));
        let (w2, b2) = (program.matrix(1, 8), program.parameter(1));
        let x = program.state(1);
        let hidden = program.dense_tanh(w1, &[x], b1);
        let rate = program.dense(w2, &[hidden], b2);
        let [next] = program.map(Minute, [x, rate], &[]);
        program.advance(x, next);
    }
}

/// Returns the population that the network predicts after this number of minutes.
fn grown<R: Real>(weights: &[R], from: f64, minutes: usize) -> R {
    let parameters = [0..8, 8..16, 16..24, 24..25].map(|part| &weights[part]);
    Rollout::new(Minute, minutes).run(&[R::lit(from)], &parameters)[0]
}

/// Returns the population after this number of minutes under the true growth law, `x' = x (1 - x)` per hour.
fn counted(from: f64, minutes: f64) -> f64 {
    from / (from + (1.0 - from) * (-minutes / 60.0).exp())
}

fn main() {
    let mut weights: Vec<f64> = (0..25u16).map(|i| f64::from(i * i).sin()).collect();
    let (mut mean, mut square) = ([0.0; 25], [0.0; 25]);
    for _ in 0..1000 {
        let error = |weights: &[Var<f64>]| {
            let off = |from| grown(weights, from, 60) - counted(from, 60.0);
            let off = [0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5].map(off);
            Real::dot(&off, &off)
        };
        let gradient = gradient(error, &weights);
        for i in 0..25 {
            mean[i] += 0.1 * (gradient[i] - mean[i]);
            square[i] += 0.01 * (gradient[i] * gradient[i] - square[i]);
            weights[i] -= 0.02 * mean[i] / (square[i].sqrt() + 1e-8);
        }
    }
    let (network, law) = (grown(&weights, 0.1, 360), counted(0.1, 360.0));
    println!(
        "in six hours 0.1 grows to {network:.3} by the network and to {law:.3} by the true law"
    );
    assert!((network - law).abs() < 0.01);
}
