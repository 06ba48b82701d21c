//! The logarithm of a sum of exponentials, the largest taken out first.
//!
//! The sum of a block is a rollout over stretches of it, whose state is a stretch of partial sums. Blocks
//! are small enough for the nearest caches: of each only the sum is kept, and its cotangent is pulled
//! back through the block by a call of its own.

use autodiff::{Kernel, Model, Program, Real, Rollout, VectorFunction, gradient_of, vjp};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, read, require, work};

#[derive(Deserialize)]
struct Input {
    x: Vec<f64>,
}

/// Numbers of a stretch, and of a block.
const STRETCH: usize = 512;
const BLOCK: usize = 16 * STRETCH;

/// `sum + exp(x - largest)`.
struct AddExponential;

impl Kernel<3, 1> for AddExponential {
    #[inline(always)]
    fn eval<R: Real>(&self, [sum, x, largest]: [R; 3]) -> [R; 1] {
        [sum + (x - largest).exp()]
    }
}

/// Adds the exponentials of a stretch to the partial sums.
#[derive(Clone)]
struct Exponentials;

impl Model for Exponentials {
    fn record<R: Real>(&self, program: &mut Program<R>) {
        let largest = program.parameter(STRETCH);
        let x = program.control(STRETCH);
        let sums = program.state(STRETCH);
        let [next] = program.map(AddExponential, [sums, x, largest]);
        program.advance(sums, next);
    }
}

/// The sum of the exponentials of a block, given the largest number of all.
struct BlockSum {
    largest: f64,
}

impl VectorFunction for BlockSum {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let largest = R::lit(self.largest);
        let (whole, rest) = x.split_at(x.len() / STRETCH * STRETCH);
        let start = [R::zero(); STRETCH];
        let rollout = Rollout::new(Exponentials, whole.len() / STRETCH);
        let sums = rollout.run(&start, &[&[largest; STRETCH], whole]);
        let mut sum = R::sum(&sums);
        for &entry in rest {
            sum += (entry - largest).exp();
        }
        vec![sum]
    }
}

/// The largest number. The whole stretches are searched abreast.
fn largest(x: &[f64]) -> f64 {
    let (whole, rest) = x.split_at(x.len() / STRETCH * STRETCH);
    let mut abreast = [f64::NEG_INFINITY; STRETCH];
    for stretch in whole.chunks_exact(STRETCH) {
        for (largest, &entry) in abreast.iter_mut().zip(stretch) {
            *largest = Real::max(entry, *largest);
        }
    }
    abreast
        .iter()
        .chain(rest)
        .copied()
        .fold(abreast[0], f64::max)
}

/// The sums of all blocks.
fn sums(x: &[f64]) -> (BlockSum, Vec<f64>) {
    let block = BlockSum {
        largest: largest(x),
    };
    let sums = x.chunks(BLOCK).map(|x| block.eval(x)[0]).collect();
    (block, sums)
}

/// The logarithm, given the sums of all blocks.
fn logarithm<R: Real>(largest: f64, sums: &[R]) -> R {
    R::lit(largest) + R::sum(sums).ln()
}

fn primal(x: &[f64]) -> f64 {
    let (block, sums) = sums(x);
    logarithm(block.largest, &sums)
}

fn gradient(x: &[f64]) -> Vec<f64> {
    let (block, sums) = sums(x);
    let bars = gradient_of(|sums| logarithm(block.largest, sums), &sums);
    let mut gradient = Vec::with_capacity(x.len());
    for (x, bar) in x.chunks(BLOCK).zip(bars) {
        gradient.extend(vjp(&block, x, &[bar]).1);
    }
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
