//! Steps as programs, against the same steps written out.

use crate::net::{taken_from, weighted_squares};
use autodiff::{Dual, Function, Kernel, Model, Real, Rollout, gradient};

// Miri is slow: as few as suffice.
pub(crate) const STEPS: usize = if cfg!(miri) { 2 } else { 5 };

/// A step, as a program and written out.
pub(crate) trait Step: Model {
    /// Lengths of the state and of the parameters.
    fn shapes(&self) -> Vec<usize>;
    /// The parameters as the program takes them.
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        given.iter().map(|part| part.to_vec()).collect()
    }
    /// The inputs of all steps: the same in each.
    fn inputs(&self) -> Vec<f64> {
        Vec::new()
    }
    fn written_out<R: Real>(&self, state: &[R], parameters: &[&[R]]) -> Vec<R>;
}

struct Steps<M> {
    model: M,
    as_program: bool,
}

impl<M: Step> Function for Steps<M> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let shapes = self.model.shapes().into_iter();
        let parts: Vec<&[R]> = shapes.map(taken_from(x)).collect();
        let (start, given) = (parts[0], &parts[1..]);
        let last = match self.as_program {
            true => self.rollout(start, given),
            false => (0..STEPS).fold(start.to_vec(), |state, _| {
                self.model.written_out(&state, given)
            }),
        };
        weighted_squares(&last)
    }
}

impl<M: Step> Steps<M> {
    fn rollout<R: Real>(&self, start: &[R], given: &[&[R]]) -> Vec<R> {
        let parameters = self.model.parameters(given);
        let parameters: Vec<&[R]> = parameters.iter().map(Vec::as_slice).collect();
        let rollout = Rollout {
            inputs: self.model.inputs().repeat(STEPS).into(),
            ..Rollout::new(self.model.clone(), STEPS)
        };
        rollout.run(start, &parameters)
    }
}

#[track_caller]
fn assert_close(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    let size = b.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        // The same terms in another order: some hundreds of them.
        assert!((a - b).abs() <= 1e-13 * size, "{a} and {b} of {size}");
    }
}

/// Value, gradient and the derivative of the gradient in one direction, of both.
#[track_caller]
pub(crate) fn assert_same(model: impl Step) {
    let len = model.shapes().iter().sum();
    let x: Vec<f64> = (0..len).map(|i| (1.3 * i as f64 + 0.4).sin()).collect();
    let along: Vec<Dual<f64, 1>> = (x.iter().rev().zip(&x))
        .map(|(&tangent, &value)| Dual {
            value,
            tangent: [tangent],
        })
        .collect();
    let of = |as_program| Steps {
        model: model.clone(),
        as_program,
    };
    let (program, plain) = (of(true), of(false));
    assert_close(&[program.eval(&x)], &[plain.eval(&x)]);
    let [ours, plains] =
        [&program, &plain].map(|steps| (steps.eval(&along), gradient(|x| steps.eval(x), &x)));
    assert_close(&ours.0.tangent, &plains.0.tangent);
    assert_close(&ours.1, &plains.1);
    let second = |steps: &Steps<_>| -> Vec<f64> {
        let gradient = gradient(|x| steps.eval(x), &along);
        gradient.iter().map(|g| g.tangent[0]).collect()
    };
    assert_close(&second(&program), &second(&plain));
}

/// A rotation of `(x, y)`.
#[derive(Clone, Copy)]
pub(crate) struct Turn;

impl Kernel<2, 1> for Turn {
    fn eval<R: Real>(&self, [x, y]: [R; 2]) -> [R; 1] {
        [x * R::lit(0.9) + y.sin() * R::lit(0.3)]
    }
}
