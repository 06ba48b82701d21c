//! Computes the Hessian of a logistic regression, and the derivative of its optimum with respect to the regularisation
//! weight.
use autodiff::implicit::{Residual, root};
use autodiff::{Dual, Real, Var, gradient, jvp, lit, value_gradient_hessian};
use nalgebra::{DMatrix, DVector};

#[derive(Clone)]
struct Data(Vec<[f64; 3]>); // two features and a label, -1 or 1

fn loss<R: Real>(data: &Data, w: &[R], weight: R) -> R {
    let loss = |&[a, b, y]: &[f64; 3]| (lit(-y) * (w[0] * lit(a) + w[1] * lit(b))).softplus();
    data.0.iter().map(loss).sum::<R>() + weight * R::dot(w, w)
}

impl Residual for Data {
    fn eval<R: Real>(&self, w: &[R], weight: &[R]) -> Vec<R> {
        gradient(|w| loss(self, w, Var::constant(weight[0])), w)
    }
}

/// The gradient and the Hessian of the loss.
fn derivatives(data: &Data, w: &DVector<f64>, weight: f64) -> (DVector<f64>, DMatrix<f64>) {
    let loss = |w: &[_]| loss(data, w, Var::lit(weight));
    let (_, gradient, hessian) = value_gradient_hessian(loss, w.as_slice());
    (gradient.into(), hessian.into())
}

fn optimum(data: &Data, weight: f64) -> DVector<f64> {
    (0..20).fold(DVector::zeros(2), |w, _| {
        let (gradient, hessian) = derivatives(data, &w, weight);
        w - hessian.lu().solve(&gradient).unwrap()
    })
}

fn main() {
    let datum = |i: f64| [i.sin(), i.cos(), (i.sin() + (9.0 * i).sin()).signum()];
    let data = Data((1..100).map(f64::from).map(datum).collect());
    let w = optimum(&data, 1.0);
    let root = |p: &[_]| root(data.clone(), &Dual::lits(w.as_slice()), p).unwrap();
    let by_weight = DVector::from(jvp(root, &[1.0], &[1.0]).1);
    println!("{w}{}{by_weight}", derivatives(&data, &w, 1.0).1);
    let difference = (optimum(&data, 1.0 + 1e-5) - optimum(&data, 1.0 - 1e-5)) / 2e-5;
    assert!((by_weight - difference).norm() < 1e-8);
}
