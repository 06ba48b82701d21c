//! The sum of a kernel's results over the elements of arrays of variables.

use crate::arrays::Kernel;
use crate::real::{Fused, Real};
use crate::simd::{Lane, Vectorized, WIDEST};

/// The sum of a kernel's results over the elements of arrays of one length, in lanes; on the reverse tape
/// one entry. Unlike the data of a [`Sum`](super::Sum), every number is a variable.
///
/// ```
/// use autodiff::{Kernel, Real, data, gradient_of};
///
/// #[derive(Clone)]
/// struct Exponential;
/// impl Kernel<1, 1> for Exponential {
///     #[inline(always)]
///     fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
///         [x.exp()]
///     }
/// }
///
/// let softmax = gradient_of(|x| data::total(Exponential, [x]).ln(), &[0.0, 0.0, 2f64.ln()]);
/// assert_eq!(softmax, [0.25, 0.25, 0.5]);
/// ```
///
/// # Panics
/// If the arrays differ in length.
pub fn total<R: Real, K: Kernel<I, 1> + Sync, const I: usize>(kernel: K, x: [&[R]; I]) -> R {
    let len = x.first().map_or(0, |x| x.len());
    let one_length = x.iter().all(|x| x.len() == len);
    assert!(one_length, "the arrays of a total differ in length");
    R::fused(Total(kernel), &x)[0]
}

/// A total as a function of `I` slices.
struct Total<K, const I: usize>(K);

impl<K: Kernel<I, 1> + Sync, const I: usize> Fused for Total<K, I> {
    type Saved<R: Real> = Vec<Vec<R>>;

    #[inline(always)]
    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        vec![R::vectorize(Value { of: self, inputs })]
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Vec<Vec<R>>) {
        let saved = inputs.iter().map(|x| x.to_vec()).collect();
        (self.eval(inputs), saved)
    }

    fn reverse<R: Real>(&self, x: &mut Vec<Vec<R>>, y_bar: &[R], _: &[bool]) -> Vec<Vec<R>> {
        let x_bar = x.iter().map(|x| vec![R::zero(); x.len()]).collect();
        R::vectorize(Pullback {
            of: self,
            x,
            bar: y_bar[0],
            x_bar,
        })
    }
}

/// The inputs of `L::N` elements, or fewer, from `first` on; beyond the last they are zeros.
#[inline(always)]
fn load<R: Real, L: Lane<R>, const I: usize>(inputs: &[impl AsRef<[R]>], first: usize) -> [L; I] {
    let mut x = [L::zero(); I];
    for i in 0..I {
        x[i] = L::load_up_to(&inputs[i].as_ref()[first..]);
    }
    x
}

struct Value<'a, R, K, const I: usize> {
    of: &'a Total<K, I>,
    inputs: &'a [&'a [R]],
}

impl<R: Real, K: Kernel<I, 1>, const I: usize> Vectorized<R> for Value<'_, R, K, I> {
    type Output = R;
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> R {
        let len = self.inputs.first().map_or(0, |x| x.len());
        let whole = len - len % L::N;
        let (mut sum, mut lanes) = (L::zero(), [R::zero(); WIDEST]);
        for first in (0..whole).step_by(L::N) {
            sum += self.of.0.eval::<L>(load(self.inputs, first))[0];
        }
        sum.store(&mut lanes);
        let mut total = R::sum_of(&lanes[..L::N]);
        if whole < len {
            let [rest] = self.of.0.eval::<L>(load(self.inputs, whole));
            rest.store(&mut lanes);
            total += R::sum_of(&lanes[..len - whole]);
        }
        total
    }
}

struct Pullback<'a, R, K, const I: usize> {
    of: &'a Total<K, I>,
    x: &'a [Vec<R>],
    bar: R,
    x_bar: Vec<Vec<R>>,
}

impl<R: Real, K: Kernel<I, 1>, const I: usize> Vectorized<R> for Pullback<'_, R, K, I> {
    type Output = Vec<Vec<R>>;
    #[inline(always)]
    fn run<L: Lane<R>>(mut self) -> Vec<Vec<R>> {
        let (len, bar) = (self.x.first().map_or(0, Vec::len), L::splat(self.bar));
        for first in (0..len).step_by(L::N) {
            let x_bar = self.of.0.vjp(load(self.x, first), [bar]);
            for i in 0..I {
                x_bar[i].store_up_to(&mut self.x_bar[i][first..]);
            }
        }
        self.x_bar
    }
}
