//! Replays a recorded function at a single point, in single numbers instead of lanes. The forward sweep stores an entry
//! for each operation, as a tape does, so that the reverse sweep need not know the operation.

use super::elementwise::{Function, single};
use super::plan::{Plan, Step};
use crate::pool::{self, Pooled};
use crate::real::{Mask, Real, of_floats};
use crate::record::arithmetic::{binary, holds, logic, number, unary};
use crate::record::operation::{Binary, Op, Place, Unary};

impl Plan {
    /// Returns the first result and its gradient at the inputs `x`. The recorded code must have no shared arguments.
    /// With the feature `data`, this crate compiles the replay for floats. Without it, each crate compiles the replays that
    /// it needs.
    pub(crate) fn value_and_gradient<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        if const { !R::IS_FLOAT } {
            return self.at_point(x);
        }
        type Replay<R> = fn(&Plan, &[R]) -> (R, Vec<R>);
        let replay: Replay<R> = of_floats(Self::double as Replay<f64>, Self::single as Replay<f32>);
        replay(self, x)
    }

    #[cfg_attr(feature = "data", inline(never))]
    #[cfg_attr(not(feature = "data"), inline)]
    fn double(&self, x: &[f64]) -> (f64, Vec<f64>) {
        self.at_point(x)
    }

    #[cfg_attr(feature = "data", inline(never))]
    #[cfg_attr(not(feature = "data"), inline)]
    fn single(&self, x: &[f32]) -> (f32, Vec<f32>) {
        self.at_point(x)
    }

    #[inline(always)]
    fn at_point<R: Real>(&self, x: &[R]) -> (R, Vec<R>) {
        let (mut sweep, zero) = (pool::take::<Sweep<R>>().unwrap_or_default(), R::zero());
        let (count, inputs) = (self.steps.len(), x.len());
        // Every value and entry is written before it is read, so old contents may stay.
        sweep.values.resize(count, zero);
        sweep.entries.resize(count, Entry::several());
        sweep.bars.clear();
        sweep.bars.resize(1 + count, zero);
        sweep.values[..inputs].copy_from_slice(x);
        sweep.forward(&self.steps, inputs);
        let result = self.results[0];
        sweep.bars[index(result) as usize] = R::one();
        sweep.reverse(&self.steps, inputs);
        let gradient = sweep.bars[1..=inputs].to_vec();
        let value = sweep.values[result.at()];
        pool::keep(sweep);
        (value, gradient)
    }
}

/// The partials of an operation with respect to at most two operands, and the indices of their cotangents.
#[derive(Clone, Copy)]
struct Entry<R> {
    partials: [R; 2],
    operands: [u32; 2],
}

/// The index of a cotangent that is not used. It stands for an operand that gets no cotangent.
const NONE: u32 = 0;
/// Marks an operation whose operands are read from the operation itself. It is not a function of one or two numbers, or it
/// has a partial of zero, whose product with an infinite cotangent would be NaN.
const SEVERAL: u32 = u32::MAX;

/// Returns the index of the cotangent of the number at `place`.
#[inline(always)]
fn index(place: Place) -> u32 {
    place.at() as u32 + 1
}

impl<R: Real> Entry<R> {
    /// The entry of an operation whose operands are read from the operation itself.
    #[inline(always)]
    fn several() -> Self {
        Self {
            partials: [R::zero(); 2],
            operands: [SEVERAL; 2],
        }
    }
}

/// The buffers of a replay.
struct Sweep<R> {
    /// The results of the operations.
    values: Vec<R>,
    entries: Vec<Entry<R>>,
    /// The cotangents of the results. The first number is not used; see [`NONE`].
    bars: Vec<R>,
}

impl<R> Default for Box<Sweep<R>> {
    fn default() -> Self {
        Box::new(Sweep {
            values: Vec::new(),
            entries: Vec::new(),
            bars: Vec::new(),
        })
    }
}

impl<R: Real> Pooled for Sweep<R> {
    fn bytes(&self) -> usize {
        let numbers = self.values.capacity() + self.bars.capacity();
        numbers * size_of::<R>() + self.entries.capacity() * size_of::<Entry<R>>()
    }
}

impl<R: Real> Sweep<R> {
    /// Computes all operations, which begin after the inputs.
    #[inline(always)]
    fn forward(&mut self, steps: &[Step], inputs: usize) {
        let (values, entries) = (
            &mut self.values[..steps.len()],
            &mut self.entries[..steps.len()],
        );
        for place in inputs..steps.len() {
            let value = |place: Place| values[place.at()];
            let entry = &mut entries[place];
            // Each arm writes the parts of the entry one by one. If it were a value, the compiler would compose it in
            // memory, and the processor would wait for these stores.
            values[place] = match *operation(&steps[place]) {
                Op::Unary(f, x) if f != Unary::Detach => {
                    let (result, partial) = one_operand(f, value(x));
                    entry.partials = [partial, R::zero()];
                    entry.operands = [index(x), NONE];
                    result
                }
                Op::Binary(f, [a, b]) if f != Binary::StraightThrough => {
                    let (result, partials) = two_operands(f, value(a), value(b));
                    entry.partials = partials;
                    entry.operands = [index(a), index(b)];
                    result
                }
                op => {
                    entry.operands[0] = SEVERAL;
                    several_operands(op, values)
                }
            };
        }
    }

    /// Pulls the cotangents of all operations back to the inputs.
    #[inline(always)]
    fn reverse(&mut self, steps: &[Step], inputs: usize) {
        let (bars, entries) = (&mut self.bars[..=steps.len()], &self.entries[..steps.len()]);
        for place in (inputs..steps.len()).rev() {
            let (bar, Entry { partials, operands }) = (bars[1 + place], entries[place]);
            if bar.is_zero() {
                continue;
            }
            if operands[0] == SEVERAL {
                reverse_several(*operation(&steps[place]), bar, &self.values, bars);
                continue;
            }
            for k in 0..2 {
                bars[operands[k] as usize] += R::chain(partials[k], bar);
            }
        }
    }
}

#[inline(always)]
fn operation(step: &Step) -> &Op {
    match step {
        Step::Single(op) => op,
        Step::Layer(_) | Step::Row => unreachable!("layers have shared arguments"),
    }
}

/// Returns the value and the partial of a function of one number. Only short functions are inlined.
#[inline(always)]
fn one_operand<R: Real>(f: Unary, x: R) -> (R, R) {
    match f {
        Unary::Neg | Unary::Recip | Unary::Sqrt | Unary::Abs => unary(f, x),
        _ => {
            let [value, partial, _] = single(Function::Unary(f), x, x);
            (value, partial)
        }
    }
}

/// Returns the value and the partials of a function of two numbers. Only short functions are inlined.
#[inline(always)]
fn two_operands<R: Real>(f: Binary, a: R, b: R) -> (R, [R; 2]) {
    match f {
        Binary::Add | Binary::Sub | Binary::Mul | Binary::Div => binary(f, a, b),
        _ => {
            let [value, by_a, by_b] = single(Function::Binary(f), a, b);
            (value, [by_a, by_b])
        }
    }
}

/// Returns the value of any other operation.
#[inline(never)]
fn several_operands<R: Real>(op: Op, values: &[R]) -> R {
    let value = |place: Place| values[place.at()];
    match op {
        Op::Constant(bits) => R::lit(f64::from_bits(bits)),
        Op::Always(always) => number(R::Mask::splat(always)),
        Op::Logic(f, [a, b]) => logic(f, value(a), value(b)),
        Op::Fma([a, b, c]) => value(a).fma(value(b), value(c)),
        Op::Select(mask, [a, b]) => R::select(holds(value(mask)), value(a), value(b)),
        Op::Dot([a, b], len) => {
            let product = |sum, j| value(a.at(j)).fma(value(b.at(j)), sum);
            (0..len as usize).fold(R::zero(), product)
        }
        Op::Sum(x, len) => (0..len as usize).fold(R::zero(), |sum, j| sum + value(x.at(j))),
        Op::Unary(_, x) => value(x).detach(),
        Op::Binary(_, [hard, soft]) => value(hard).straight_through(value(soft)),
        Op::Input(_) => unreachable!("the first operations, and no other, are the inputs"),
    }
}

/// Pulls back the cotangent of an operation whose operands are [`SEVERAL`].
#[inline(never)]
fn reverse_several<R: Real>(op: Op, bar: R, values: &[R], bars: &mut [R]) {
    let value = |place: Place| values[place.at()];
    let mut add = |place, part| bars[index(place) as usize] += part;
    match op {
        Op::Fma([a, b, c]) => {
            add(a, R::chain(value(b), bar));
            add(b, R::chain(value(a), bar));
            add(c, bar);
        }
        Op::Select(mask, [a, b]) => {
            let (mask, zero) = (holds(value(mask)), R::zero());
            add(a, R::select(mask, bar, zero));
            add(b, R::select(mask, zero, bar));
        }
        Op::Dot([a, b], len) => {
            for (a, b) in (0..len as usize).map(|j| (a.at(j), b.at(j))) {
                add(a, R::chain(value(b), bar));
                add(b, R::chain(value(a), bar));
            }
        }
        Op::Sum(x, len) => (0..len as usize).for_each(|j| add(x.at(j), bar)),
        Op::Binary(_, [_, soft]) => add(soft, bar),
        Op::Input(_) | Op::Constant(_) | Op::Always(_) | Op::Logic(..) | Op::Unary(..) => {}
    }
}
