//! Rollouts in double-double.

use autodiff::{DoubleDouble, Dual, Function, Real, gradient};

use crate::common::largest_difference;
use crate::net::Loss;

fn wide(x: &[f64]) -> Vec<DoubleDouble> {
    x.iter().map(|&x| DoubleDouble::from(x)).collect()
}

#[test]
fn a_rollout_and_its_reverse_sweep_run_in_wide_numbers() {
    let loss = Loss::new(50);
    let x = loss.point();
    let exact = loss.eval(&wide(&x));
    // The tolerance is for 50 steps with about 20 rounding errors per number, which the network's feedback may amplify.
    assert!(largest_difference(&[DoubleDouble::from(loss.eval(&x))], &[exact]) < 1e-13);
    let slopes = gradient(|x| loss.eval(x), &wide(&x));
    assert!(largest_difference(&wide(&gradient(|x| loss.eval(x), &x)), &slopes) < 1e-12);

    // The same reverse sweep must agree with forward mode, in more digits than f64 has.
    let dual = |(i, &x)| Dual::<DoubleDouble, 1> {
        value: DoubleDouble::from(x),
        tangent: [DoubleDouble::from((i as f64).cos())],
    };
    let along: Vec<_> = x.iter().enumerate().map(dual).collect();
    let tangents: Vec<DoubleDouble> = along.iter().map(|x| x.tangent[0]).collect();
    let slope = loss.eval(&along).tangent[0];
    assert!(largest_difference(&[DoubleDouble::dot(&slopes, &tangents)], &[slope]) < 1e-28);
}
