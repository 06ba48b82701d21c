//! Fits stiffness and damping of an oscillator to observations of its motion, by Gauss-Newton
//! with the Jacobian taken through the whole integration.
//!
//! `cargo run -p cosmic-autodiff --example fit_ode`

use autodiff::{Real, VectorFunction, jacobian};

const STEP: f64 = 0.05;

/// Position and velocity of `x'' = -stiffness x - damping x'` after one step of the classical
/// Runge-Kutta method.
fn step<R: Real>([x, v]: [R; 2], [stiffness, damping]: [R; 2]) -> [R; 2] {
    let rate = |[x, v]: [R; 2]| [v, -(stiffness * x) - damping * v];
    let at = |k: [R; 2], h: f64| [x + R::lit(h) * k[0], v + R::lit(h) * k[1]];
    let k1 = rate([x, v]);
    let k2 = rate(at(k1, STEP / 2.0));
    let k3 = rate(at(k2, STEP / 2.0));
    let k4 = rate(at(k3, STEP));
    let mean = |i: usize| (k1[i] + R::lit(2.0) * (k2[i] + k3[i]) + k4[i]) / R::lit(6.0);
    at([mean(0), mean(1)], STEP)
}

/// The positions at every step, from rest at 1.
fn motion<R: Real>(parameters: [R; 2]) -> Vec<R> {
    let next = |state: &[R; 2]| Some(step(*state, parameters));
    let states = std::iter::successors(Some([R::one(), R::zero()]), next);
    states.take(100).map(|[x, _]| x).collect()
}

/// Model minus observation, as a function of the parameters.
struct Residual(Vec<f64>);

impl VectorFunction for Residual {
    fn eval<R: Real>(&self, parameters: &[R]) -> Vec<R> {
        let model = motion([parameters[0], parameters[1]]);
        let pairs = model.into_iter().zip(&self.0);
        pairs.map(|(model, &seen)| model - R::lit(seen)).collect()
    }
}

fn main() {
    let truth = [4.0, 0.3];
    let residual = Residual(motion(truth));
    let mut p = vec![3.0, 0.6];
    for iteration in 0..8 {
        let (r, rows) = (residual.eval(&p), jacobian(&residual, &p));
        println!(
            "{iteration}: {p:.9?}, squared error {:.1e}",
            f64::dot(&r, &r)
        );
        let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
        let (a, b) = (column(0), column(1));
        let (aa, ab, bb) = (f64::dot(&a, &a), f64::dot(&a, &b), f64::dot(&b, &b));
        let (ar, br, det) = (f64::dot(&a, &r), f64::dot(&b, &r), aa * bb - ab * ab);
        p[0] -= (bb * ar - ab * br) / det;
        p[1] -= (aa * br - ab * ar) / det;
    }
    assert!((p[0] - truth[0]).abs() + (p[1] - truth[1]).abs() < 1e-9);
}
