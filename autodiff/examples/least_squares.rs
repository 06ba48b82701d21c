//! Fits a damped oscillation to observations by Levenberg-Marquardt, with nalgebra.
use autodiff::{Real, value_and_jacobian};
use nalgebra::{DMatrix, DVector};

/// The residuals `a exp(-b t) cos(c t) - y` at observations `(t, y)`.
struct Residuals(Vec<(f64, f64)>);

impl Residuals {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let model = |t: R| x[0] * (-x[1] * t).exp() * (x[2] * t).cos();
        let residual = |&(t, y): &_| model(R::lit(t)) - R::lit(y);
        self.0.iter().map(residual).collect()
    }
}

fn main() {
    let observe = |t: f64| (t, 2.0 * (-0.3 * t).exp() * (1.7 * t).cos());
    let times = (0..60).map(|i| 0.1 * f64::from(i));
    let problem = Residuals(times.map(observe).collect());
    let (mut x, mut damping) = (DVector::from(vec![1.0, 0.0, 1.5]), 0.01);
    for _ in 0..12 {
        let (r, j) = value_and_jacobian(|x| problem.eval(x), x.as_slice());
        let (r, j) = (DVector::from(r), DMatrix::from(j));
        let normal = j.tr_mul(&j) + DMatrix::identity(3, 3) * damping;
        let better = &x - normal.cholesky().unwrap().solve(&j.tr_mul(&r));
        println!("|r| = {:.3e}, damping {damping:.0e}", r.norm());
        if DVector::from(problem.eval(better.as_slice())).norm() < r.norm() {
            (x, damping) = (better, 0.1 * damping);
        } else {
            damping *= 10.0;
        }
    }
    assert!((x - DVector::from(vec![2.0, 0.3, 1.7])).norm() < 1e-12);
}
