//! Runs operations once, with numbers of any type, also with symbols.

use autodiff::{Mask, Real};

use super::plan::{Plan, Step};
use crate::record::arithmetic::{binary_value, unary_value};
use crate::record::computed::{self, Compute};
use crate::record::operation::{Logic, Op, Place, Run};
use crate::record::symbol::Symbol;

/// The result of an operation.
#[derive(Clone, Copy)]
enum Value<R: Real> {
    Number(R),
    Mask(R::Mask),
}

impl Plan {
    /// Returns the results for these inputs and shared arguments.
    ///
    /// # Panics
    /// If the recording has layers. A kernel has none, because it has too few shared arguments.
    pub(crate) fn evaluate<R: Real>(&self, x: &[R], shared: &[R]) -> Vec<R> {
        let mut values = Evaluation {
            shared: shared.to_vec(),
            values: Vec::with_capacity(self.steps.len()),
        };
        for step in &self.steps {
            let value = match *step {
                Step::Single(Op::Input(k)) => Value::Number(x[k as usize]),
                Step::Single(op) => values.of(op),
                Step::Nothing => Value::Number(R::zero()),
                Step::Layer(_) => unreachable!("a recorded kernel has no layers"),
            };
            values.values.push(value);
        }
        let results = self.results.iter();
        results.map(|&place| values.number(place)).collect()
    }
}

/// Runs code on symbols that have values of type `R`: each of its operations is computed at once, so the code may ask for
/// values. The symbols that the code gets stand for the `given` numbers. Returns the values of the symbols that it returns.
pub(crate) fn computed<R: Real>(
    given: Vec<R>,
    code: impl FnOnce(&[Symbol]) -> Vec<Symbol>,
) -> Vec<R> {
    let symbols: Vec<Symbol> = (0..given.len()).map(Symbol::shared).collect();
    let values = Evaluation {
        shared: given,
        values: Vec::new(),
    };
    let (results, values) = computed::with(values, || code(&symbols));
    let results = results.into_iter();
    results.map(|symbol| values.number(symbol.0)).collect()
}

struct Evaluation<R: Real> {
    shared: Vec<R>,
    values: Vec<Value<R>>,
}

impl<R: Real> Evaluation<R> {
    fn number(&self, place: Place) -> R {
        if place.is_shared() {
            return self.shared[place.at()];
        }
        match self.values[place.at()] {
            Value::Number(number) => number,
            Value::Mask(_) => unreachable!("a mask is not a number"),
        }
    }

    fn mask(&self, place: Place) -> R::Mask {
        match self.values[place.at()] {
            Value::Mask(mask) => mask,
            Value::Number(_) => unreachable!("a number is not a mask"),
        }
    }

    fn run(&self, run: Run, len: u32) -> Vec<R> {
        let places = (0..len as usize).map(|k| run.at(k));
        places.map(|place| self.number(place)).collect()
    }

    fn of(&self, op: Op) -> Value<R> {
        let number = |place| self.number(place);
        Value::Number(match op {
            Op::Input(_) => unreachable!("inputs have values"),
            Op::Constant(bits) => R::lit(f64::from_bits(bits)),
            Op::Unary(f, x) => unary_value(f, number(x)),
            Op::Binary(f, [a, b]) => binary_value(f, number(a), number(b)),
            Op::Fma([a, b, c]) => number(a).fma(number(b), number(c)),
            Op::Select(mask, [a, b]) => R::select(self.mask(mask), number(a), number(b)),
            Op::Dot([a, b], len) => R::dot(&self.run(a, len), &self.run(b, len)),
            Op::Sum(run, len) => R::sum_of(&self.run(run, len)),
            Op::Always(value) => return Value::Mask(R::Mask::splat(value)),
            Op::Logic(f, [a, b]) => {
                return Value::Mask(match f {
                    Logic::Less => number(a).less(number(b)),
                    Logic::LessEqual => number(a).less_equal(number(b)),
                    Logic::And => self.mask(a) & self.mask(b),
                    Logic::Or => self.mask(a) | self.mask(b),
                    Logic::Not => !self.mask(a),
                });
            }
        })
    }
}

impl<R: Real> Compute for Evaluation<R> {
    fn push(&mut self, op: Op) -> Place {
        let value = self.of(op);
        self.values.push(value);
        Place::own(self.values.len() - 1)
    }
    fn is_zero(&self, place: Place) -> bool {
        self.number(place).is_zero()
    }
    fn primal(&self, place: Place) -> f64 {
        self.number(place).primal()
    }
    fn any(&self, mask: Place) -> bool {
        self.mask(mask).any()
    }
}
