//! Emitted derivatives where something passes no derivative, or another's.

use autodiff::{Adjoint, Dual, Kernel, Memory, Partials, Real, Tape, Var, hessian};

use super::{Plain, assert_close, summed};

/// Numbers held constant, and values with the derivative of others.
#[derive(Clone, Copy)]
pub(crate) struct Held;

impl Kernel<2, 3> for Held {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y]: [R; 2]) -> [R; 3] {
        let rounded = (x * y).straight_through(x * x.sin());
        let held = R::select(x.lt(y), x, R::one()).detach();
        [
            x.detach() * y + rounded.sin(),
            rounded * y,
            (held * x).sin() + rounded * rounded.cos(),
        ]
    }
}

/// A choice keeps a partial that is infinite or NaN from what passes nothing.
#[derive(Clone, Copy)]
pub(crate) struct Guarded;

impl Kernel<2, 2> for Guarded {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        [R::select(R::zero().lt(x), x.ln(), R::zero()), y * x]
    }
}

/// A kernel's first derivatives, and second ones forward over reverse and reverse over reverse.
fn derivatives<K, const I: usize, const O: usize>(
    kernel: &K,
    x: [f64; I],
    y_bar: [f64; O],
) -> Vec<f64>
where
    K: Adjoint<I, O>,
{
    let mut all = kernel.vjp(x, y_bar).to_vec();
    let dual = std::array::from_fn(|i| Dual::<f64, I>::variable(x[i], i));
    for x_bar in kernel.vjp(dual, y_bar.map(Dual::constant)) {
        all.push(x_bar.value);
        all.extend(x_bar.tangent);
    }
    let mut tape = Tape::new();
    let x_bar = tape.record(&x, |x| {
        kernel.vjp(std::array::from_fn(|i| x[i]), y_bar.map(Var::constant))
    });
    for x_bar in x_bar {
        all.extend(tape.pullback(&[x_bar], &[1.0]));
    }
    all
}

#[test]
fn what_is_held_is_so_in_second_derivatives() {
    for x in [[0.3, 0.7], [1.2, -0.4]] {
        for y_bar in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, -2.0, 3.0]] {
            let expected = derivatives(&Plain(Held), x, y_bar);
            assert_close(&derivatives(&Held, x, y_bar), &expected);
        }
        let nested = x.map(|x| Dual::<f64, 1>::variable(x, 0));
        let ((values, rows), (expected, expected_rows)) =
            (Held.partials(nested), Plain(Held).partials(nested));
        for o in 0..3 {
            let parts = |y: Dual<f64, 1>| [y.value, y.tangent[0]];
            assert_close(&parts(values[o]), &parts(expected[o]));
            for i in 0..2 {
                assert_close(&parts(rows[o][i]), &parts(expected_rows[o][i]));
            }
        }
    }
}

#[test]
fn what_is_held_is_so_in_the_second_derivatives_of_a_rollout() {
    let (expected, x) = summed(Plain(Held), Memory::All);
    let (emitted, _) = summed(Held, Memory::All);
    let (expected, emitted) = (hessian(&expected, &x), hessian(&emitted, &x));
    for (g, e) in emitted.concat().iter().zip(expected.concat()) {
        // Eighteen kernels' roundings in another order, each grown by the steps that follow.
        assert!((g - e).abs() <= 1e-12 * e.abs(), "{g} and {e}");
    }
    assert!(expected[0][0] != 0.0, "{expected:?}");
}

/// Holds first and second derivatives against those of duals, which say NaN nowhere.
fn assert_as_duals<K, const I: usize, const O: usize>(kernel: K, x: [f64; I], y_bar: [f64; O])
where
    K: Adjoint<I, O> + Copy,
{
    let expected = derivatives(&Plain(kernel), x, y_bar);
    assert!(expected.iter().all(|e| !e.is_nan()), "{x:?}: {expected:?}");
    assert_close(&derivatives(&kernel, x, y_bar), &expected);
}

#[test]
fn a_choice_guards_a_logarithm() {
    for x in [[0.0, 2.0], [-1.0, 2.0], [0.5, 2.0]] {
        for y_bar in [[1.0, 1.0], [0.0, 1.0], [1.0, 0.0]] {
            assert_as_duals(Guarded, x, y_bar);
        }
    }
    assert_eq!(Guarded.vjp([0.0, 2.0], [1.0, 1.0]), [2.0, 0.0]);
}
