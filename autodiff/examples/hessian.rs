//! A Hessian: the shape of a hanging chain by Newton's method, and the tones it swings with.
//!
//! `cargo run -p cosmic-autodiff --example hessian`

use autodiff::{Function, Real, gradient, hessian};
use nalgebra::{DMatrix, DVector};

const WEIGHTS: usize = 11;

/// Energy of weights on springs between hooks at (0, 0) and (1, 0), by `x0, y0, x1, y1, …`.
struct Chain;

impl Function for Chain {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (mut energy, mut last) = (R::zero(), [R::zero(); 2]);
        for at in x.chunks(2).chain([&[R::one(), R::zero()][..]]) {
            let length = (at[0] - last[0]).hypot(at[1] - last[1]);
            let stretch = length - R::lit(1.5 / (WEIGHTS + 1) as f64);
            energy += R::lit(500.0) * stretch * stretch + at[1];
            last = [at[0], at[1]];
        }
        energy
    }
}

fn main() {
    // From a shallow arc.
    let mut x = vec![0.0; 2 * WEIGHTS];
    for i in 0..WEIGHTS {
        let at = (i + 1) as f64 / (WEIGHTS + 1) as f64;
        (x[2 * i], x[2 * i + 1]) = (at, -at * (1.0 - at));
    }
    for iteration in 0..12 {
        let slopes = DVector::from_vec(gradient(&Chain, &x));
        let (energy, slope) = (Chain.eval(&x), slopes.amax());
        println!("{iteration}: energy {energy:.9}, slope {slope:.1e}");
        // Far from the minimum the Hessian alone would lead astray.
        let damping = DMatrix::identity(x.len(), x.len()) * slope;
        let factors = (DMatrix::from(hessian(&Chain, &x)) + damping).lu();
        let step = factors.solve(&slopes).expect("a regular Hessian");
        x.iter_mut().zip(&step).for_each(|(x, step)| *x -= step);
    }
    assert!(gradient(&Chain, &x).iter().all(|g| g.abs() < 1e-9));

    let mut stiffness = DMatrix::from(hessian(&Chain, &x)).symmetric_eigenvalues();
    stiffness.as_mut_slice().sort_by(f64::total_cmp);
    println!(
        "lowest tones, in units of the weights' own: {:.4?}",
        &stiffness.map(f64::sqrt).as_slice()[..4]
    );
}
