//! What a replay does for a recording: its operations one by one, and layers of networks at once.

use std::collections::HashMap;

use crate::product::Strided;
use crate::record::operation::{Op, Run};

/// The work of a replay, in the order of the recording.
pub(super) struct Plan {
    pub(super) steps: Vec<Step>,
    pub(super) layers: Vec<Layer>,
    /// The shared arguments whose cotangents single operations add to.
    pub(super) read: Vec<usize>,
    /// For each of the shared arguments, how many of those lie before it.
    pub(super) numbers: Vec<usize>,
}

#[derive(Clone, Copy)]
pub(super) enum Step {
    /// An operation by itself.
    Single(Op),
    /// The first row of the layer of this number, with which all of them are computed.
    Layer(usize),
    /// Another row of a layer.
    Row,
}

/// Dot products of rows of shared numbers with the same own numbers: a matrix times a vector.
#[derive(Clone, Copy)]
pub(super) struct Layer {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// The place of the first row's product, and the distance between two.
    pub(super) first: usize,
    pub(super) step: usize,
    /// Where the matrix begins among the shared arguments, and the distance between two rows.
    pub(super) weights: usize,
    pub(super) stride: usize,
    /// The own numbers.
    pub(super) own: Run,
}

/// The fewest rows and the fewest entries of a layer: fewer are not worth the transposition of the own
/// numbers.
const LEAST_ROWS: usize = 4;
const LEAST_ENTRIES: usize = 32;

impl Layer {
    /// A dot product as a layer of one row, if it is of shared numbers side by side and own numbers.
    fn of_row(place: usize, op: Op) -> Option<Self> {
        let Op::Dot([a, b], len) = op else {
            return None;
        };
        let (row, own) = if a.is_row() { (a, b) } else { (b, a) };
        (row.is_row() && !own.first.is_shared()).then_some(Self {
            rows: 1,
            columns: len as usize,
            first: place,
            step: 1,
            weights: row.first.at(),
            stride: len as usize,
            own,
        })
    }

    /// Takes a later row of the same length with the same own numbers, unless it is out of line, or
    /// overlaps with the row before, or one of the own numbers is the product of a row before.
    fn take(&mut self, row: &Self) -> bool {
        let (step, stride) = (
            row.first - self.first,
            row.weights.checked_sub(self.weights),
        );
        let Some(stride) = stride else { return false };
        if self.rows == 1 {
            (self.step, self.stride) = (step, stride);
        }
        let last = self.own.at(self.columns - 1).at();
        let fits = step == self.rows * self.step
            && stride == self.rows * self.stride
            && self.stride >= self.columns
            && last < self.first;
        self.rows += usize::from(fits);
        fits
    }

    fn is_worth_it(&self) -> bool {
        self.rows >= LEAST_ROWS && self.rows * self.columns >= LEAST_ENTRIES
    }

    /// The matrix among the shared arguments.
    pub(super) fn matrix<R>(self, shared: &[R]) -> Strided<'_, R> {
        Strided {
            numbers: &shared[self.weights..],
            row: self.stride,
            column: 1,
        }
    }

    fn row_places(&self) -> impl Iterator<Item = usize> + use<> {
        let (first, step) = (self.first, self.step);
        (0..self.rows).map(move |row| first + row * step)
    }
}

/// The layers in the order of their first rows.
fn layers(ops: &[Op]) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    let mut open = HashMap::new();
    for (place, &op) in ops.iter().enumerate() {
        if let Some(row) = Layer::of_row(place, op) {
            let number = open.entry((row.own, row.columns)).or_insert(layers.len());
            if !layers
                .get_mut(*number)
                .is_some_and(|layer| layer.take(&row))
            {
                *number = layers.len();
                layers.push(row);
            }
        }
    }
    layers.retain(Layer::is_worth_it);
    layers
}

impl Plan {
    /// The plan of a recording with this many shared arguments.
    pub(super) fn new(ops: &[Op], shared: usize) -> Self {
        let layers = layers(ops);
        let mut steps: Vec<Step> = ops.iter().copied().map(Step::Single).collect();
        for (number, layer) in layers.iter().enumerate() {
            for place in layer.row_places() {
                steps[place] = Step::Row;
            }
            steps[layer.first] = Step::Layer(number);
        }
        let mut is_read = vec![layers.is_empty(); shared];
        if !layers.is_empty() {
            mark_read(&steps, &mut is_read);
        }
        let read: Vec<usize> = (0..shared).filter(|&at| is_read[at]).collect();
        let before = |count: &mut usize, is_read: &bool| {
            *count += usize::from(*is_read);
            Some(*count - usize::from(*is_read))
        };
        Self {
            steps,
            layers,
            read,
            numbers: is_read.iter().scan(0, before).collect(),
        }
    }
}

/// Marks the shared arguments that single operations read.
fn mark_read(steps: &[Step], is_read: &mut [bool]) {
    for step in steps {
        if let Step::Single(op) = step {
            let operands = op.operands().into_iter();
            let shared = operands.filter(|place| place.is_shared());
            shared.for_each(|place| is_read[place.at()] = true);
        }
    }
}
