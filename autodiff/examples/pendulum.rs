//! Optimal control: finds the torques that swing a pendulum up, by gradients through the whole motion.
//!
//! `cargo run -p cosmic-autodiff --example pendulum`

use autodiff::{Real, value_and_gradient};

const STEPS: usize = 80;
const STEP: f64 = 0.05;

/// Returns the final angle, measured from hanging down, and the final angular velocity. The pendulum starts at rest.
/// Its weight and its length are the units.
fn swing<R: Real>(torques: &[R]) -> [R; 2] {
    let (mut angle, mut velocity, step) = (R::zero(), R::zero(), R::lit(STEP));
    for &torque in torques {
        velocity += (torque - angle.sin()) * step;
        angle += velocity * step;
    }
    [angle, velocity]
}

/// Returns how far the pendulum is from standing still at the top in the end, plus the cost of the torques.
fn cost<R: Real>(torques: &[R]) -> R {
    let [angle, velocity] = swing(torques);
    let missed = R::one() + angle.cos() + R::lit(0.5) * velocity * velocity;
    missed + R::lit(1e-3 * STEP) * R::dot(torques, torques)
}

fn main() {
    // The torques do not start at zero: while the pendulum hangs still without a torque, the gradient is zero.
    let mut torques = vec![0.1; STEPS];
    let (mut mean, mut square) = (vec![0.0; STEPS], vec![0.0; STEPS]);
    for iteration in 0..500 {
        let (cost, gradient) = value_and_gradient(cost, &torques);
        if iteration % 100 == 0 {
            println!("{iteration}: cost {cost:.5}");
        }
        // Adam (Kingma and Ba 2014), without its bias correction for the first steps.
        for i in 0..STEPS {
            mean[i] += 0.1 * (gradient[i] - mean[i]);
            square[i] += 0.01 * (gradient[i] * gradient[i] - square[i]);
            torques[i] -= 0.01 * mean[i] / (square[i].sqrt() + 1e-8);
        }
    }
    let [angle, velocity] = swing(&torques);
    let strongest = torques.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
    println!("ends at {angle:.3} rad, {velocity:.3} rad/s; the strongest torque is {strongest:.2}");
    assert!((angle.cos() + 1.0).abs() < 1e-2 && velocity.abs() < 0.1);
}
