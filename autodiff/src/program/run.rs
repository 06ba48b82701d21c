//! Running a recorded program, forward and in reverse.

use super::{Aligned, Array, Layout, Parameter, Program, WIDEST, copy_in, copy_out, joined};
use crate::real::Real;

impl<R: Real> Program<R> {
    /// Closes the recording: decides what the reverse sweep has to compute again. An operation
    /// runs again if something reads an output of it that is not kept: a later operation's
    /// reverse, or a later operation that itself runs again.
    pub(crate) fn finish(mut self) -> Self {
        assert!(
            self.next.iter().all(Option::is_some),
            "a part of the state is never advanced"
        );
        let mut read: Vec<Array> = Vec::new();
        self.rerun = vec![false; self.operations.len()];
        for (operation, rerun) in self.operations.iter().zip(&mut self.rerun).rev() {
            let lost = |a: &Array| !self.kept.contains(a) && read.contains(a);
            *rerun = operation.outputs().iter().any(lost);
            read.extend(operation.reverse_reads());
            if *rerun {
                read.extend(operation.inputs());
            }
        }
        self.layout = Layout {
            state: joined(self.states.iter().copied()),
            next: joined(self.next.iter().copied().flatten()),
            kept: joined(self.kept.iter().copied()),
            inputs: joined(self.inputs.iter().copied()),
        };
        self
    }

    /// A zeroed arena for values or cotangents, with room for reads past the last array.
    pub(crate) fn arena(&self) -> Aligned<R> {
        Aligned::zeros(self.arena_len + 2 * WIDEST + self.margin)
    }

    /// The number of scalars in a state.
    pub(crate) fn state_len(&self) -> usize {
        self.states.iter().map(|a| a.len).sum()
    }

    /// The number of scalars per step in the kept arrays.
    pub(crate) fn kept_len(&self) -> usize {
        self.kept.iter().map(|a| a.len).sum()
    }

    /// The number of scalars in the inputs of a step.
    pub(crate) fn input_len(&self) -> usize {
        self.inputs.iter().map(|a| a.len).sum()
    }

    /// Takes the parameters over, checking their shapes.
    pub(crate) fn load(&mut self, values: &mut [R], parameters: &[&[R]]) {
        assert_eq!(
            parameters.len(),
            self.parameters.len(),
            "a program's parameters differ in number"
        );
        for (at, (declared, given)) in self.parameters.iter().zip(parameters).enumerate() {
            let len = match declared {
                Parameter::Array(a) => a.len,
                Parameter::Matrix(m) => m.rows * m.columns,
            };
            assert_eq!(
                given.len(),
                len,
                "parameter {at} of a program differs in length"
            );
            if let Parameter::Array(a) = declared {
                values[a.range()].copy_from_slice(given);
            }
        }
        for operation in &mut self.operations {
            operation.load(parameters);
        }
    }

    /// Marks what carries derivatives: the state always does.
    pub(crate) fn set_active(&mut self, parameters: &[bool]) {
        let mut active = vec![false; self.arrays.len()];
        for (declared, &wanted) in self.parameters.iter().zip(parameters) {
            if let Parameter::Array(a) = declared {
                active[a.id] = wanted;
            }
        }
        for state in &self.states {
            active[state.id] = true;
        }
        for operation in &mut self.operations {
            operation.set_active(&active, parameters);
            for output in operation.outputs() {
                active[output.id] = true;
            }
        }
    }

    pub(crate) fn set_state(&self, values: &mut [R], state: &[R]) {
        copy_in(&self.layout.state, values, state);
    }

    pub(crate) fn set_inputs(&self, values: &mut [R], inputs: &[R]) {
        copy_in(&self.layout.inputs, values, inputs);
    }

    pub(crate) fn set_kept(&self, values: &mut [R], kept: &[R]) {
        copy_in(&self.layout.kept, values, kept);
    }

    pub(crate) fn push_state(&self, values: &[R], to: &mut Vec<R>) {
        copy_out(&self.layout.state, values, to);
    }

    pub(crate) fn push_kept(&self, values: &[R], to: &mut Vec<R>) {
        copy_out(&self.layout.kept, values, to);
    }

    /// Computes a step; the state becomes the next one.
    pub(crate) fn step(&mut self, values: &mut [R]) {
        for operation in &mut self.operations {
            operation.forward(values);
        }
        if let ([state], [next]) = (&self.layout.state[..], &self.layout.next[..]) {
            return values.copy_within(next.clone(), state.start);
        }
        for (state, next) in self.states.iter().zip(self.next.iter().flatten()) {
            values.copy_within(next.range(), state.start);
        }
    }

    /// The reverse of a step. `values` hold its state, inputs and kept arrays; `state_bar` goes
    /// from the cotangent of the next state to that of this one, and the bars of parameters grow
    /// by this step's part.
    pub(crate) fn reverse_step(
        &mut self,
        values: &mut [R],
        bars: &mut [R],
        state_bar: &mut Vec<R>,
    ) {
        for (operation, &rerun) in self.operations.iter_mut().zip(&self.rerun) {
            if rerun {
                operation.forward(values);
            }
        }
        bars[self.parameters_end..].fill(R::zero());
        let mut rest = &state_bar[..];
        for next in &self.layout.next {
            let (part, others) = rest.split_at(next.len());
            for (bar, &given) in bars[next.clone()].iter_mut().zip(part) {
                *bar += given;
            }
            rest = others;
        }
        for operation in self.operations.iter_mut().rev() {
            operation.reverse(values, bars);
        }
        state_bar.clear();
        copy_out(&self.layout.state, bars, state_bar);
    }

    /// The cotangents of all parameters after the last reverse step.
    pub(crate) fn parameter_bars(&mut self, bars: &[R]) -> Vec<Vec<R>> {
        let bar = |declared: &Parameter| match declared {
            Parameter::Array(a) => bars[a.range()].to_vec(),
            Parameter::Matrix(m) => vec![R::zero(); m.rows * m.columns],
        };
        let mut all: Vec<Vec<R>> = self.parameters.iter().map(bar).collect();
        for operation in &mut self.operations {
            operation.matrix_bars(&mut all);
        }
        all
    }
}
