//! Where the numbers of a program lie: in the memory of a workgroup and in the buffers.

use std::ops::Range;

use autodiff_programs::Array;
use autodiff_programs::internal::{Parameter, Parts};

/// A parameter of a printed program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// How many numbers it has.
    pub len: usize,
    /// For a matrix, its rows and columns. Buffers have its columns one after the other.
    pub matrix: Option<[usize; 2]>,
    /// Whether all members share it. It then lies in the buffer `of_all`, otherwise in each member's part of `own`.
    pub is_common: bool,
    /// The first number in that buffer or part.
    pub start: usize,
    /// For a matrix of which the reverse sweep reads the columns, the first number of a copy that has its rows one after
    /// the other, in the same buffer: neighbouring invocations then read neighbouring numbers.
    pub rows_from: Option<usize>,
    /// The first number of its cotangents in each member's part of the buffer `bars`; `None` if they are not wanted.
    pub bar: Option<usize>,
}

impl Placed {
    /// Where the numbers lie, counted from the beginning of the member's part, for each number in the order in which a
    /// [`Rollout`](autodiff_programs::Rollout) takes them.
    pub fn places(&self) -> impl Iterator<Item = usize> {
        self.order().map({
            let start = self.start;
            move |at| start + at
        })
    }

    /// Like [`places`](Self::places), for the cotangents; empty if they are not wanted.
    pub fn bars(&self) -> impl Iterator<Item = usize> {
        let bar = self.bar;
        let order = bar.map(|bar| self.order().map(move |at| bar + at));
        order.into_iter().flatten()
    }

    /// Like [`places`](Self::places), for the copy of a matrix; empty without one.
    pub fn places_of_copy(&self) -> Range<usize> {
        self.rows_from.map_or(0..0, |start| start..start + self.len)
    }

    /// The beginning of the expression for a number of the parameter in its buffer, up to the number's place.
    pub(super) fn expression(&self) -> String {
        self.expression_from(self.start)
    }

    fn expression_from(&self, start: usize) -> String {
        match self.is_common {
            true => format!("of_all[{start}u"),
            false => format!("own[own_at + {start}u"),
        }
    }

    fn order(&self) -> impl Iterator<Item = usize> + use<> {
        let [rows, columns] = self.matrix.unwrap_or([1, self.len]);
        (0..rows).flat_map(move |r| (0..columns).map(move |c| c * rows + r))
    }
}

pub(super) struct Memory {
    pub(super) parameters: Vec<Placed>,
    /// For each parameter that is an array, the array and the parameter's index.
    arrays: Vec<(Array, usize)>,
    /// For each number of a row, whether it carries derivatives.
    active: Vec<bool>,
    /// The lengths of a member's part of `own`, of `of_all`, and of a member's part of `bars`.
    pub(super) lengths: [usize; 3],
    /// How many cotangents of parameters, except matrices, the workgroup holds.
    pub(super) bars_of_arrays: usize,
}

impl Memory {
    /// `common` and `wanted` say for each parameter whether all members share it, and whether its cotangents are wanted.
    pub(super) fn new(program: &Parts, common: &[bool], wanted: &[bool]) -> Self {
        let [mut own, mut shared, mut bars] = [0; 3];
        let (mut parameters, mut arrays) = (Vec::new(), Vec::new());
        for (k, parameter) in program.parameters.iter().enumerate() {
            let (len, matrix) = match *parameter {
                Parameter::Array(array) => {
                    arrays.push((array, k));
                    (array.len(), None)
                }
                Parameter::Matrix(m) => (m.shape().iter().product(), Some(m.shape())),
                Parameter::Control(_) => unreachable!("controls are refused"),
            };
            let end = if common[k] { &mut shared } else { &mut own };
            parameters.push(Placed {
                len,
                matrix,
                is_common: common[k],
                start: *end,
                rows_from: None,
                bar: None,
            });
            *end += len;
        }
        // The cotangents of arrays come first, as they lie in the memory of a workgroup.
        let is_array = |placed: &Placed| placed.matrix.is_none();
        let mut bars_of_arrays = 0;
        for of_arrays in [true, false] {
            for (placed, _) in parameters
                .iter_mut()
                .zip(wanted)
                .filter(|(_, wanted)| **wanted)
            {
                if is_array(placed) == of_arrays {
                    placed.bar = Some(bars);
                    bars += placed.len;
                }
            }
            if of_arrays {
                bars_of_arrays = bars;
            }
        }
        Self {
            parameters,
            arrays,
            active: vec![false; program.ends[1]],
            lengths: [own, shared, bars],
            bars_of_arrays,
        }
    }

    /// Marks an array of the row as one that carries derivatives.
    pub(super) fn activate(&mut self, array: Array) {
        self.active[array.range()].fill(true);
    }

    /// Whether the cotangents of an array are needed.
    pub(super) fn is_active(&self, array: Array) -> bool {
        match array.is_parameter() {
            true => self.of_array(array).bar.is_some(),
            false => self.active[array.range()].contains(&true),
        }
    }

    /// Whether the cotangents of a parameter are wanted.
    pub(super) fn is_wanted(&self, parameter: usize) -> bool {
        self.parameters[parameter].bar.is_some()
    }

    fn of_array(&self, array: Array) -> &Placed {
        let known = self
            .arrays
            .iter()
            .find(|(known, _)| known.start() == array.start() && !known.is_empty());
        let (_, parameter) = known.expect("every parameter has a place");
        &self.parameters[*parameter]
    }

    /// The place of the first cotangent of a parameter that is an array.
    pub(super) fn bar_of_parameter(&self, array: Array) -> usize {
        self.of_array(array)
            .bar
            .expect("only wanted cotangents are read")
    }

    /// The beginning of the expression for an entry of a matrix, up to the number of the entry: `own[own_at + 12u`.
    pub(super) fn matrix(&self, parameter: usize) -> String {
        self.parameters[parameter].expression()
    }

    /// Gives a matrix a copy that has its rows one after the other.
    pub(super) fn copy_rows(&mut self, parameter: usize) {
        let (placed, [own, of_all, _]) = (&mut self.parameters[parameter], &mut self.lengths);
        let end = if placed.is_common { of_all } else { own };
        if placed.rows_from.is_none() {
            placed.rows_from = Some(*end);
            *end += placed.len;
        }
    }

    /// Like [`matrix`](Self::matrix), for the transpose: the copy of the rows.
    pub(super) fn transpose(&self, parameter: usize) -> String {
        let placed = &self.parameters[parameter];
        let from = placed
            .rows_from
            .expect("the rows of this matrix are copied");
        placed.expression_from(from)
    }

    /// The parameters that are arrays, with their places.
    pub(super) fn arrays(&self) -> impl Iterator<Item = (Array, &Placed)> {
        let arrays = self.arrays.iter();
        arrays.map(|&(array, parameter)| (array, &self.parameters[parameter]))
    }
}
