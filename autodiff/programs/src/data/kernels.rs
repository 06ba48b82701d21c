//! Evaluates a kernel, or its Jacobian, at many points at once.

use autodiff::Real;
use autodiff::internal::WIDEST;
use autodiff::simd::{Lane, Vectorized};

use crate::arrays::{Kernel, Pullback};

/// Evaluates a kernel at `count` points, several points at a time in SIMD lanes. For each `i = 0, 1, ...` it calls
/// `output(i, y)`, where `y` has the kernel's results at the point `input(i)`.
///
/// ```
/// use autodiff::Real;
/// use autodiff_programs::{Kernel, data, kernel};
///
/// struct Area;
/// #[kernel]
/// impl Kernel<2, 1> for Area {
///     fn eval<R: Real>(&self, [width, height]: [R; 2], _: &[R]) -> [R; 1] {
///         [width * height]
///     }
/// }
///
/// let sheets = [[1.0, 2.0], [3.0, 4.0]];
/// let mut areas = Vec::new();
/// data::values(&Area, sheets.len(), |i| sheets[i], |_, [area]| areas.push(area));
/// assert_eq!(areas, [2.0, 12.0]);
/// ```
pub fn values<R: Real, K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    count: usize,
    input: impl Fn(usize) -> [R; I],
    mut output: impl FnMut(usize, [R; O]),
) {
    let output = |i, at: LocalJacobian<'_, R, 0, O>| output(i, at.values());
    R::vectorize(Points::<_, _, _, I, O, 0> {
        kernel,
        count,
        input,
        output,
    });
}

/// Computes the Jacobian of a kernel at each of `count` points, several points at a time in SIMD lanes. For each `i =
/// 0, 1, ...` it calls `output(i, jacobian)` with the results and the partials at the point `input(i)`.
///
/// If each point picks its `I` inputs from many variables, the results are the rows of a sparse Jacobian with `I`
/// entries in each row. The cost per point is `I` forward directions, and no colouring of the columns is needed.
///
/// ```
/// use autodiff::Real;
/// use autodiff_programs::{Kernel, data, kernel};
///
/// struct Area;
/// #[kernel]
/// impl Kernel<2, 1> for Area {
///     fn eval<R: Real>(&self, [width, height]: [R; 2], _: &[R]) -> [R; 1] {
///         [width * height]
///     }
/// }
///
/// let sheets = [[1.0, 2.0], [3.0, 4.0]];
/// let mut rows = Vec::new();
/// data::jacobians(&Area, sheets.len(), |i| sheets[i], |_, area| rows.push(area.row(0)));
/// assert_eq!(rows, [[2.0, 1.0], [4.0, 3.0]]);
/// ```
pub fn jacobians<R: Real, K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    count: usize,
    input: impl Fn(usize) -> [R; I],
    output: impl FnMut(usize, LocalJacobian<'_, R, I, O>),
) {
    R::vectorize(Points::<_, _, _, I, O, I> {
        kernel,
        count,
        input,
        output,
    });
}

/// The values and partials of a kernel at one point.
#[derive(Clone, Copy, Debug)]
pub struct LocalJacobian<'a, R, const I: usize, const O: usize> {
    /// The partial derivative of each result with respect to each input. A lane holds the derivative at one point.
    partials: &'a [[[R; WIDEST]; I]; O],
    values: &'a [[R; WIDEST]; O],
    lane: usize,
}

impl<R: Real, const I: usize, const O: usize> LocalJacobian<'_, R, I, O> {
    #[inline(always)]
    #[track_caller]
    fn values(&self) -> [R; O] {
        let mut values = [R::zero(); O];
        for (o, value) in values.iter_mut().enumerate() {
            *value = self.value(o);
        }
        values
    }

    /// Returns the value of a result.
    #[inline(always)]
    #[track_caller]
    pub fn value(&self, result: usize) -> R {
        self.values[result][self.lane]
    }

    /// Returns the derivative of a result with respect to an input.
    #[inline(always)]
    #[track_caller]
    pub fn partial(&self, result: usize, input: usize) -> R {
        self.partials[result][input][self.lane]
    }

    /// Returns the derivatives of a result with respect to all inputs.
    #[inline(always)]
    #[track_caller]
    pub fn row(&self, result: usize) -> [R; I] {
        let mut row = [R::zero(); I];
        for (input, partial) in row.iter_mut().enumerate() {
            *partial = self.partial(result, input);
        }
        row
    }
}

/// Loads the inputs of the `L::N` points that begin with the point `first`. If there are fewer points up to `last`, the
/// remaining lanes repeat the point `last`. `rows` is working memory.
#[inline(always)]
fn gather<R: Real, L: Lane<R>, const I: usize>(
    input: &impl Fn(usize) -> [R; I],
    [first, last]: [usize; 2],
    rows: &mut [[R; WIDEST]; I],
) -> [L; I] {
    for lane in 0..L::N {
        let point = input((first + lane).min(last));
        for i in 0..I {
            rows[i][lane] = point[i];
        }
    }
    let mut x = [L::zero(); I];
    for i in 0..I {
        x[i] = L::load(&rows[i]);
    }
    x
}

/// Returns the rows of the identity matrix. A reverse sweep that takes them as cotangents gives the rows of the
/// Jacobian.
#[inline(always)]
fn identity<L: Real, const O: usize>() -> [[L; O]; O] {
    let mut rows = [[L::zero(); O]; O];
    for o in 0..O {
        rows[o][o] = L::one();
    }
    rows
}

/// A kernel without uniform inputs and the points at which it is evaluated. `J` is the number of inputs with respect to
/// which partials are computed: all of them (`I`) or none (0).
struct Points<'a, K, F, G, const I: usize, const O: usize, const J: usize> {
    kernel: &'a K,
    count: usize,
    input: F,
    output: G,
}

impl<R, K, F, G, const I: usize, const O: usize, const J: usize> Vectorized<R>
    for Points<'_, K, F, G, I, O, J>
where
    R: Real,
    K: Kernel<I, O>,
    F: Fn(usize) -> [R; I],
    G: FnMut(usize, LocalJacobian<'_, R, J, O>),
{
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) {
        const {
            assert!(
                K::UNIFORMS == 0,
                "the uniform inputs of a kernel at data points must be `Fixed`"
            );
        }
        let (mut rows, mut values) = ([[R::zero(); WIDEST]; I], [[R::zero(); WIDEST]; O]);
        let mut partials = [[[R::zero(); WIDEST]; J]; O];
        for first in (0..self.count).step_by(L::N) {
            let x = gather::<R, L, I>(&self.input, [first, self.count - 1], &mut rows);
            let y = self.kernel.eval(x, &[]);
            for o in 0..O {
                y[o].store(&mut values[o]);
            }
            if J > 0 {
                let y_bar = identity();
                let uniforms = &[];
                let by_x = self.kernel.vjp(Pullback {
                    x,
                    uniforms,
                    y,
                    y_bar,
                });
                for o in 0..O {
                    for j in 0..J {
                        by_x[o][j].store(&mut partials[o][j]);
                    }
                }
            }
            for lane in 0..L::N.min(self.count - first) {
                let jacobian = LocalJacobian {
                    partials: &partials,
                    values: &values,
                    lane,
                };
                (self.output)(first + lane, jacobian);
            }
        }
    }
}
