//! Fits the Lotka-Volterra model to observations. The gradient is computed in three ways: on a tape, by a rollout and
//! by dual numbers.
use autodiff::{Real, Var, jacobian, lit, vjp};
use autodiff_programs::{Kernel, Model, Program, Rollout, kernel};
use nalgebra::{DMatrix, DVector};
#[derive(Clone)]
struct Logarithms;
#[kernel]
impl Kernel<4, 1> for Logarithms {
    fn eval<R: Real>(&self, [u, other, growth, effect]: [R; 4], _: &[R]) -> [R; 1] {
        [u + lit(0.01) * (growth + effect * other.exp())]
    }
}
impl Model for Logarithms {
    fn record(&self, step: &mut Program) {
        let (u, growth, effect) = (step.state(2), step.parameter(2), step.parameter(2));
        let other = step.gather(u, &[Some(1), Some(0)]);
        let [next] = step.map(Logarithms, [u, other, growth, effect], &[]);
        step.advance(u, next);
    }
}
fn by_loop<R: Real>(p: &[R]) -> Vec<R> {
    let next = |u: &[R], i| Logarithms.eval([u[i], u[1 - i], p[i], p[2 + i]], &[])[0];
    let states = std::iter::successors(Some([R::zero(); 2]), |u| Some([next(u, 0), next(u, 1)]));
    states.take(800).flatten().collect()
}
fn main() {
    let mut rollout = Rollout::new(Logarithms, 799);
    rollout.observed = (0..800).collect();
    let by_rollout = |p: &[Var<_>]| rollout.run(&[Var::lit(0.0); 2], &[&p[..2], &p[2..]]);
    let seen = DVector::from(by_loop(&[1.5, -3.0, -1.0, 1.0]));
    let p = (0..8).fold(DVector::from(vec![1.4, -2.9, -0.9, 1.1]), |p, _| {
        let misfit = DVector::from(by_loop(p.as_slice())) - &seen;
        let j = DMatrix::from(jacobian(by_loop, p.as_slice()));
        let by_tape = vjp(by_loop, p.as_slice(), misfit.as_slice()).1;
        let by_rollout = vjp(by_rollout, p.as_slice(), misfit.as_slice()).1;
        let differ = |by| (DVector::from(by) - j.tr_mul(&misfit)).norm() > 1e-9;
        assert!(!differ(by_tape) && !differ(by_rollout));
        p - j.svd(true, true).solve(&misfit, 0.0).unwrap()
    });
    println!("The fitted parameters: {:?}", p.as_slice());
    assert!((p - DVector::from(vec![1.5, -3.0, -1.0, 1.0])).norm() < 1e-9);
}
