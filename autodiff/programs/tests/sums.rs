//! Sums of a million numbers in `f32`. A running sum of equal numbers would be off by up to a percent.

use autodiff::fused::dense_batch;
use autodiff::{Function, Real, Var, gradient, value_and_gradient};
use autodiff_programs::data::{Recorded, Sum, Summand};

const MANY: usize = 1_000_000;

/// Asserts that a number is right to 5e-6: some hundred roundings, as sums by parts and the sums over 128 points of each
/// lane have. A running sum of a million is off by 1e-3 and more.
#[track_caller]
fn assert_near(found: f32, expected: f64) {
    let error = f64::from(found) / expected - 1.0;
    assert!(error.abs() < 5e-6, "{found}, not {expected}");
}

/// A datum times a parameter.
#[derive(Clone)]
struct Scaled;

impl Summand for Scaled {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        shared[0] * datum[0]
    }
}

/// A layer of a network on each datum.
#[derive(Clone)]
struct Layer;

impl Summand for Layer {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let rows = shared.chunks(8).map(|row| R::dot(row, &[datum[0]; 8]));
        R::sum_of(&rows.collect::<Vec<_>>())
    }
}

/// A datum times a parameter, computed by a test that a recording cannot replay.
#[derive(Clone)]
struct Branching;

impl Summand for Branching {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        if datum[0].primal() > 0.0 {
            shared[0] * datum[0]
        } else {
            R::zero()
        }
    }
}

struct Identity;

impl Function for Identity {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        x[0]
    }
}

#[test]
fn sums_over_many_data_keep_their_digits() {
    let data = vec![[0.1]; MANY];
    let expected = 1e6 * f64::from(0.1_f32);
    let sum = Sum::new(Scaled, &data);
    let (value, slope) = value_and_gradient(|p| sum.run(p), &[1.0_f32]);
    assert_near(value, expected);
    assert_near(slope[0], expected);
    // Each of these data takes a recording of its own.
    let slow = Sum::new(Branching, &data[..MANY / 10]);
    let (value, slope) = value_and_gradient(|p| slow.run(p), &[1.0_f32]);
    assert_near(value, 0.1 * expected);
    assert_near(slope[0], 0.1 * expected);
    let layers = Sum::new(Layer, &data);
    let slopes = gradient(|p| layers.run(p), &[1.0_f32; 64]);
    slopes
        .iter()
        .for_each(|&slope| assert_near(slope, expected));
    let recorded = Recorded::new(&Identity, 1).expect("no values");
    assert_near(recorded.total(&[&vec![0.1_f32; MANY]]), expected);
}

/// The sum of the arguments, recorded.
struct Total;

impl Function for Total {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        R::sum_of(x)
    }
}

#[test]
fn recorded_sums_and_layers_of_many_numbers_keep_their_digits() {
    const TERMS: usize = 100_000;
    let recorded = Recorded::new(&Total, TERMS).expect("no values");
    let (value, slopes) = recorded
        .values_and_gradients(&[vec![0.1_f32; TERMS]])
        .remove(0);
    assert_near(value, 1e5 * f64::from(0.1_f32));
    assert_eq!(slopes, vec![1.0; TERMS]);
    // The biases of a layer get the sum of the cotangents of all vectors.
    let inputs = vec![Var::constant(0.1_f32); MANY];
    let layer = |b: &[Var<f32>]| {
        let y = dense_batch(&[Var::constant(0.0)], &inputs, b);
        Var::dot(&y, &inputs)
    };
    assert_near(gradient(layer, &[1.0])[0], 1e6 * f64::from(0.1_f32));
}
