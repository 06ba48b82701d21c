//! The logarithm of a sum of exponentials, the largest taken out first.
//!
//! The sum is one variable of the logarithm. Its cotangent is that of every term, and is pulled back
//! through the kernel that computes a term, in lanes over terms.

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Kernel, Real, gradient_of};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, read, require, work};

#[derive(Deserialize)]
struct Input {
    x: Vec<f64>,
}

/// How many numbers are searched abreast.
const STRETCH: usize = 64;
/// At least as many as any register has lanes.
const WIDEST: usize = 16;

/// `exp(x - largest)`.
struct Exponential {
    largest: f64,
}

impl Kernel<1, 1> for Exponential {
    #[inline(always)]
    fn eval<R: Real>(&self, [x]: [R; 1]) -> [R; 1] {
        [(x - R::lit(self.largest)).exp()]
    }
}

/// The sum of a kernel over numbers.
struct Total<'a> {
    kernel: &'a Exponential,
    x: &'a [f64],
}

impl Vectorized<f64> for Total<'_> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lane<f64>>(self) -> f64 {
        let (mut sum, chunks) = (L::zero(), self.x.chunks_exact(L::N));
        let rest = chunks.remainder();
        for x in chunks {
            sum += self.kernel.eval([L::load(x)])[0];
        }
        let mut lanes = [0.0; WIDEST];
        sum.store(&mut lanes);
        let mut total = f64::sum(&lanes[..L::N]);
        for &x in rest {
            total += self.kernel.eval([x])[0];
        }
        total
    }
}

/// The cotangents of numbers, given that of the kernel at each.
struct Pullback<'a> {
    kernel: &'a Exponential,
    x: &'a [f64],
    bar: f64,
    x_bar: &'a mut [f64],
}

impl Vectorized<f64> for Pullback<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<f64>>(self) {
        let bar = L::splat(self.bar);
        for (x, x_bar) in self.x.chunks(L::N).zip(self.x_bar.chunks_mut(L::N)) {
            let [bar] = self.kernel.vjp([L::load_up_to(x)], [bar]);
            bar.store_up_to(x_bar);
        }
    }
}

/// The largest number.
fn largest(x: &[f64]) -> f64 {
    let (mut abreast, chunks) = ([f64::NEG_INFINITY; STRETCH], x.chunks_exact(STRETCH));
    let rest = chunks.remainder();
    for chunk in chunks {
        for (largest, &entry) in abreast.iter_mut().zip(chunk) {
            *largest = Real::max(entry, *largest);
        }
    }
    let entries = abreast.iter().chain(rest).copied();
    entries.fold(f64::NEG_INFINITY, f64::max)
}

/// The kernel of the terms, and their sum.
fn sum(x: &[f64]) -> (Exponential, f64) {
    let kernel = Exponential {
        largest: largest(x),
    };
    let total = f64::vectorize(Total { kernel: &kernel, x });
    (kernel, total)
}

/// The logarithm, given the sum.
fn logarithm<R: Real>(largest: f64, sum: R) -> R {
    R::lit(largest) + sum.ln()
}

fn primal(x: &[f64]) -> f64 {
    let (kernel, sum) = sum(x);
    logarithm(kernel.largest, sum)
}

fn gradient(x: &[f64]) -> Vec<f64> {
    let (kernel, sum) = sum(x);
    let bar = gradient_of(|sum| logarithm(kernel.largest, sum[0]), &[sum])[0];
    let mut gradient = vec![0.0; x.len()];
    f64::vectorize(Pullback {
        kernel: &kernel,
        x,
        bar,
        x_bar: &mut gradient,
    });
    gradient
}

/// Functions `primal` and `gradient`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { x } = read(input)?;
    require(!x.is_empty(), "one number at least")?;
    match function {
        "primal" => work(move || primal(&x)),
        "gradient" => work(move || gradient(&x)),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
