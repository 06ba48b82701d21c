//! nalgebra differentiated: how likely observations are under a Gaussian process, by a Cholesky
//! factorisation, and the settings that make them likeliest.
//!
//! `cargo run -p cosmic-autodiff --example gaussian_process --features nalgebra`

use autodiff::nalgebra::{Element, vector};
use autodiff::{Function, Real, value_and_gradient};
use nalgebra::DMatrix;

/// Places and what was seen there.
struct Observations {
    places: Vec<f64>,
    seen: Vec<f64>,
}

/// Minus the logarithm of the likelihood, without its constant, by the logarithms of `[length
/// scale, noise]` (Rasmussen and Williams 2006, equation 2.30).
impl Function for Observations {
    fn eval<R: Real>(&self, settings: &[R]) -> R {
        let [length, noise] = [settings[0].exp(), settings[1].exp()];
        let covariance = |i: usize, j: usize| {
            let apart = R::lit(self.places[i] - self.places[j]) / length;
            let own = if i == j { noise * noise } else { R::zero() };
            Element((R::lit(-0.5) * apart * apart).exp() + own)
        };
        let count = self.places.len();
        let factors = DMatrix::from_fn(count, count, covariance).cholesky();
        let factors = factors.expect("noise keeps a covariance positive definite");
        let seen: Vec<R> = self.seen.iter().map(|&y| R::lit(y)).collect();
        let seen = vector(&seen);
        let misfit = seen.dot(&factors.solve(&seen)) + factors.ln_determinant();
        R::lit(0.5) * misfit.0
    }
}

fn main() {
    let places: Vec<f64> = (0..30).map(|i| 0.2 * f64::from(i)).collect();
    // A wave, and something that looks like noise of size 0.1.
    let rough = |x: f64| 0.14 * (1e4 * x * x).sin();
    let seen = places.iter().map(|&x| (1.3 * x).sin() + rough(x)).collect();
    let observations = Observations { places, seen };
    let mut settings = vec![-1.0, -1.0];
    for iteration in 0..50 {
        let (cost, gradient) = value_and_gradient(&observations, &settings);
        let slope = gradient[0].hypot(gradient[1]);
        if iteration % 10 == 0 {
            println!("{iteration}: {cost:.6}, slope {slope:.1e}");
        }
        let step = 0.02 / (1.0 + 0.1 * slope);
        (0..2).for_each(|i| settings[i] -= step * gradient[i]);
    }
    let [length, noise] = [settings[0].exp(), settings[1].exp()];
    println!("length scale {length:.3}, noise {noise:.3}");
    assert!((0.05..0.2).contains(&noise) && (0.5..3.0).contains(&length));
}
