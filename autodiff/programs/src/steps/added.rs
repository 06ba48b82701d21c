//! Operations on arrays that other crates add. The step does not know their types, so each is a trait object.

use std::any::Any;

use autodiff::Real;
use autodiff::internal::of_floats;

use crate::arrays::{
    Added, AddedArrays, Array, ArrayOperation, Bars, InLanes, Operation, StepValues,
};
use crate::record::replay::computed;
use crate::record::symbol::Symbol;

/// A recorded operation of another crate.
pub struct AddedOperation {
    operation: Box<dyn AnyOperation>,
    pub arrays: AddedArrays,
}

impl AddedOperation {
    pub(super) fn new(operation: impl ArrayOperation, arrays: AddedArrays) -> Self {
        Self {
            operation: Box::new(operation),
            arrays,
        }
    }

    /// The operation, if it has this type.
    pub fn of_type<T: ArrayOperation>(&self) -> Option<&T> {
        let operation: &dyn Any = &*self.operation;
        operation.downcast_ref()
    }

    /// The operation with numbers of type `R`. It is compiled for floats, in the crate that records it. All other number
    /// types take the place of symbols.
    pub(super) fn compiled<R: Real>(self) -> Box<dyn Operation<R>> {
        if const { !R::IS_FLOAT } {
            return Box::new(OnSymbols::new(self));
        }
        type CompileFn<R> = fn(Box<dyn AnyOperation>, AddedArrays) -> Box<dyn Operation<R>>;
        let compile: CompileFn<R> = of_floats(
            <dyn AnyOperation>::double as CompileFn<f64>,
            <dyn AnyOperation>::single as CompileFn<f32>,
        );
        compile(self.operation, self.arrays)
    }
}

/// An operation of any type.
trait AnyOperation: Any + Send {
    fn double(self: Box<Self>, arrays: AddedArrays) -> Box<dyn Operation<f64>>;
    fn single(self: Box<Self>, arrays: AddedArrays) -> Box<dyn Operation<f32>>;
    fn of_symbols(self: Box<Self>, arrays: AddedArrays) -> Box<dyn Operation<Symbol>>;
}

impl<T: ArrayOperation> AnyOperation for T {
    fn double(self: Box<Self>, arrays: AddedArrays) -> Box<dyn Operation<f64>> {
        Box::new(InLanes(Added::new(*self, arrays)))
    }
    fn single(self: Box<Self>, arrays: AddedArrays) -> Box<dyn Operation<f32>> {
        Box::new(InLanes(Added::new(*self, arrays)))
    }
    fn of_symbols(self: Box<Self>, arrays: AddedArrays) -> Box<dyn Operation<Symbol>> {
        Box::new(InLanes(Added::new(*self, arrays)))
    }
}

/// An operation that runs on symbols, which stand for numbers of any type.
struct OnSymbols {
    /// The operation. Its row has only its own arrays.
    operation: Box<dyn Operation<Symbol>>,
    /// The inputs of the step, each once, and the outputs.
    inputs: Vec<Array>,
    outputs: Vec<Array>,
    /// The number of inputs' numbers, and that of outputs'.
    lens: [usize; 2],
}

impl OnSymbols {
    fn new(of: AddedOperation) -> Self {
        let AddedArrays { inputs, outputs } = of.arrays;
        let mut known: Vec<Array> = Vec::new();
        let mut end = 0;
        let mut place = |array: &Array, id: usize| {
            end += array.len;
            Array {
                id,
                parameter: false,
                start: end - array.len,
                ..*array
            }
        };
        let mut places: Vec<Array> = Vec::new();
        let mut own = Vec::new();
        for input in &inputs {
            let id = known.iter().position(|array| array == input);
            let id = id.unwrap_or_else(|| {
                places.push(place(input, known.len()));
                known.push(*input);
                known.len() - 1
            });
            own.push(places[id]);
        }
        let own_outputs = outputs.iter().enumerate();
        let own_outputs: Vec<Array> = own_outputs
            .map(|(k, output)| place(output, known.len() + k))
            .collect();
        let len = |arrays: &[Array]| arrays.iter().map(|array| array.len).sum();
        let arrays = AddedArrays {
            inputs: own,
            outputs: own_outputs,
        };
        Self {
            lens: [len(&known), len(&outputs)],
            operation: of.operation.of_symbols(arrays),
            inputs: known,
            outputs,
        }
    }

    /// The numbers of the inputs.
    fn given<R: Real>(&self, values: StepValues<R>) -> Vec<R> {
        let numbers = self.inputs.iter().map(|&input| values.get(input));
        numbers.collect::<Vec<&[R]>>().concat()
    }
}

impl<R: Real> Operation<R> for OnSymbols {
    fn outputs(&self) -> Vec<Array> {
        self.outputs.clone()
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let given = self.given(StepValues { parameters, row });
        let [inputs, outputs] = self.lens;
        let results = computed(given, |given| {
            let mut row = [given, &vec![Symbol::lit(0.0); outputs]].concat();
            self.operation.forward(&[], &mut row);
            row.split_off(inputs)
        });
        let begin = self.outputs[0].start;
        row[begin..begin + outputs].copy_from_slice(&results);
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        let [inputs, outputs] = self.lens;
        let places = self.outputs[0].start..self.outputs[0].start + outputs;
        let given = [self.given(*values), values.row[places.clone()].to_vec()];
        let of_bars = StepValues {
            parameters: &*bars.parameters,
            row: &*bars.row,
        };
        let of_bars = [self.given(of_bars), bars.row[places].to_vec()];
        let given = [given, of_bars].concat().concat();
        let x_bar = computed(given, |given| {
            let (row, bars) = given.split_at(inputs + outputs);
            let mut bars = bars.to_vec();
            let values = StepValues {
                parameters: &[],
                row,
            };
            let of_row = &mut Bars {
                parameters: &mut [],
                row: &mut bars,
            };
            self.operation.reverse(&values, of_row);
            bars.truncate(inputs);
            bars
        });
        let mut x_bar = &x_bar[..];
        for &input in &self.inputs {
            let (own, rest) = x_bar.split_at(input.len);
            bars.get_mut(input).copy_from_slice(own);
            x_bar = rest;
        }
    }

    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) -> bool {
        let active: Vec<bool> = self.inputs.iter().map(|input| arrays[input.id]).collect();
        self.operation.set_active(&active, &[])
    }
}
