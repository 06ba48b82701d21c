//! Svanberg's cantilever beam: the lightest beam of five hollow square segments whose tip sinks by no more than is
//! allowed (Svanberg 1987, section 6). The optimum is 1.340.

use autodiff::{Real, jacobian, lit};
use cosmic_optimiser::mma::{self, Options, Variant};
use cosmic_optimiser::{OptimiserError, Problem, Status};

/// The weight, and the deflection of the tip minus the allowed one, for the heights of the segments.
fn beam<R: Real>(x: &[R]) -> Vec<R> {
    let moments = [61.0, 37.0, 19.0, 7.0, 1.0];
    let height: R = x.iter().copied().sum();
    let deflection: R = (x.iter().zip(moments))
        .map(|(x, moment)| lit(moment) / x.powi(3))
        .sum();
    vec![lit(0.0624) * height, deflection - lit(1.0)]
}

fn main() -> Result<(), OptimiserError> {
    let mut problem = Problem::new(&[1.0; 5], &[10.0; 5], beam, |x| {
        jacobian(beam, x).into_vec()
    });
    for variant in [Variant::Plain, Variant::Conservative] {
        let options = Options {
            variant,
            ..Options::default()
        };
        let solution = mma::minimise(&mut problem, &[5.0; 5], &options)?;
        println!(
            "{variant:?}: weight {:.6} with heights {:.3?} after {} iterations",
            solution.objective, solution.point, solution.iterations
        );
        assert_eq!(solution.status, Status::Converged);
        assert!((solution.objective - 1.339_956).abs() < 1e-5);
    }
    Ok(())
}
