//! Emitted derivatives of kernels in which some values pass no derivative, or pass that of another value.

use autodiff::{Dual, Real, Tape, Var};
use autodiff_programs::{Kernel, Pullback, kernel};

use super::{Plain, assert_close};

/// A kernel in which some numbers are held constant, and some values have the derivative of other values.
#[derive(Clone, Copy)]
pub(crate) struct Held;

#[kernel]
impl Kernel<2, 3> for Held {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; 3] {
        let rounded = (x * y).straight_through(x * x.sin());
        let held = R::select(x.less(y), x, R::one()).detach();
        [
            x.detach() * y + rounded.sin(),
            rounded * y,
            (held * x).sin() + rounded * rounded.cos(),
        ]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 3, M>) -> [[R; 2]; M] {
        self.emitted_vjp(at)
    }
}

/// A kernel with infinities and NaN in operands that are not chosen, or where the cotangent is zero.
#[derive(Clone, Copy)]
pub(crate) struct Guarded {
    /// A number that is added under the square root of one result. It may be zero.
    pub(crate) width: f64,
}

const GUARDED: usize = 9;

#[kernel]
impl Kernel<2, GUARDED> for Guarded {
    fn eval<R: Real>(&self, [x, y]: [R; 2], _: &[R]) -> [R; GUARDED] {
        let zero = R::zero();
        let (positive, above) = (zero.less(x), R::lit(1e100).less_equal(x));
        let area = y * x;
        [
            area,
            R::select(positive, x.ln(), zero),
            R::select(positive, y * x.sqrt(), zero),
            R::select(above, x, area * area * area),
            R::select(above, x, R::lit(f64::INFINITY) * y),
            x.exp() * y,
            x.exp().ln(),
            (x * x + R::lit(self.width)).sqrt(),
            R::select(above, x, R::lit(f64::NAN) * y),
        ]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, GUARDED, M>) -> [[R; 2]; M] {
        self.emitted_vjp(at)
    }
}

/// Returns the cotangents of a kernel's inputs.
fn pulled_back<R: Real, K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    x: [R; I],
    y_bar: [R; O],
) -> [R; I] {
    let [x_bar] = kernel.vjp(Pullback::new(kernel, x, &[], [y_bar]));
    x_bar
}

/// Returns a kernel's first derivatives, and its second derivatives by forward over reverse mode.
fn derivatives<K, const I: usize, const O: usize>(
    kernel: &K,
    x: [f64; I],
    y_bar: [f64; O],
) -> Vec<f64>
where
    K: Kernel<I, O>,
{
    let mut all = pulled_back(kernel, x, y_bar).to_vec();
    let dual = std::array::from_fn(|i| Dual::<f64, I>::variable(x[i], i));
    for x_bar in pulled_back(kernel, dual, y_bar.map(Dual::constant)) {
        all.push(x_bar.value);
        all.extend(x_bar.tangent);
    }
    all
}

/// Returns second derivatives by reverse over reverse mode.
fn pulled_back_twice<K>(kernel: &K, x: [f64; 2], y_bar: [f64; 3]) -> Vec<f64>
where
    K: Kernel<2, 3>,
{
    let mut tape = Tape::new();
    let x_bar = tape.record(&x, |x| {
        pulled_back(kernel, [x[0], x[1]], y_bar.map(Var::constant))
    });
    let rows = x_bar.map(|x_bar| tape.pullback(&[x_bar], &[1.0]).to_vec());
    rows.concat()
}

#[test]
fn what_is_held_is_so_in_second_derivatives() {
    for x in [[0.3, 0.7], [1.2, -0.4]] {
        for y_bar in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, -2.0, 3.0]] {
            let expected = derivatives(&Plain(Held), x, y_bar);
            assert_close(&derivatives(&Held, x, y_bar), &expected);
            let expected = pulled_back_twice(&Plain(Held), x, y_bar);
            assert_close(&pulled_back_twice(&Held, x, y_bar), &expected);
        }
    }
}

/// Asserts that the emitted first and second derivatives agree with those of duals, none of which may be NaN.
fn assert_as_duals<K, const I: usize, const O: usize>(kernel: K, x: [f64; I], y_bar: [f64; O])
where
    K: Kernel<I, O> + Copy,
{
    let expected = derivatives(&Plain(kernel), x, y_bar);
    assert!(expected.iter().all(|e| !e.is_nan()), "{x:?}: {expected:?}");
    assert_close(&derivatives(&kernel, x, y_bar), &expected);
}

#[test]
fn a_cotangent_of_zero_passes_zero() {
    let guarded = Guarded { width: 0.0 };
    let points = [
        // Each point lists the results of the kernel whose derivatives by duals are finite there.
        (0.0, &[0, 1, 2, 3, 5][..]),
        (-1.0, &[0, 1, 2, 3, 5, 6, 7]),
        (0.5, &[0, 1, 2, 3, 5, 6, 7]),
        // At these points the exponential overflows, or underflows to 0.
        (800.0, &[0, 1, 2, 3]),
        (-800.0, &[0, 1, 2, 3, 5]),
        // At this point the square overflows.
        (1e200, &[0, 1, 2, 3, 4, 8]),
    ];
    for (x, known) in points {
        for &o in known {
            let mut y_bar = [0.0; GUARDED];
            y_bar[o] = -1.5;
            assert_as_duals(guarded, [x, 2.0], y_bar);
        }
    }
    let mut y_bar = [0.0; GUARDED];
    y_bar[..2].fill(1.0);
    assert_eq!(pulled_back(&guarded, [0.0, 2.0], y_bar), [2.0, 0.0]);
}
