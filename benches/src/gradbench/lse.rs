//! The logarithm of a sum of exponentials, the largest taken out first.
//!
//! The sum is a rollout over stretches of the vector, whose state is a stretch of partial sums.

use autodiff::{Function, Kernel, Model, Program, Real, Rollout, gradient};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, read, require, work};

#[derive(Deserialize)]
struct Input {
    x: Vec<f64>,
}

/// Numbers of a stretch: enough for lanes, few enough to stay in the nearest cache.
const STRETCH: usize = 512;

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

struct LogSumExp;

impl Function for LogSumExp {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let (whole, rest) = x.split_at(x.len() / STRETCH * STRETCH);
        let largest = largest(whole, rest);
        let start = [R::zero(); STRETCH];
        let rollout = Rollout::new(Exponentials, whole.len() / STRETCH);
        let sums = rollout.run(&start, &[&[largest; STRETCH], whole]);
        let mut sum = R::sum(&sums);
        for &entry in rest {
            sum += (entry - largest).exp();
        }
        largest + sum.ln()
    }
}

/// The largest number, as a constant: which it is does not matter to the derivative. The whole
/// stretches are searched abreast.
fn largest<R: Real>(whole: &[R], rest: &[R]) -> R {
    let mut abreast = [R::lit(f64::NEG_INFINITY); STRETCH];
    for stretch in whole.chunks_exact(STRETCH) {
        for (largest, entry) in abreast.iter_mut().zip(stretch) {
            *largest = entry.detach().max(*largest);
        }
    }
    let entries = abreast.iter().chain(rest);
    entries.fold(abreast[0], |largest, entry| entry.detach().max(largest))
}

/// Functions `primal` and `gradient`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { x } = read(input)?;
    require(!x.is_empty(), "one number at least")?;
    match function {
        "primal" => work(move || LogSumExp.eval(&x)),
        "gradient" => work(move || gradient(&LogSumExp, &x)),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
