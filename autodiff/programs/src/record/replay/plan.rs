//! The plan of a replay. The plan groups dot products that together form a layer of a network.

use autodiff::Real;
use autodiff::internal::{Line, Strided};

use crate::record::operation::{Op, Place, Run};
use crate::record::recording::{Recording, record};
use crate::record::symbol::Symbol;

/// The steps of a replay, in the order of the recording. Numbers that differ from point to point are called "own", in
/// contrast to "shared" arguments.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(super) steps: Vec<Step>,
    /// The lines of the steps in the source code.
    pub(super) lines: Vec<Line>,
    /// The places of the results. A result is either a step or a shared argument. Shared arguments are numbered as in
    /// `read`.
    pub(crate) results: Vec<Place>,
    pub(super) layers: Vec<ReplayedLayer>,
    /// The shared arguments that are results or are read outside of layers. Shared places in `steps` and `results` are
    /// indices into this list. `None` if there are no layers; then these places are indices into all shared arguments.
    pub(super) read: Option<Vec<usize>>,
    /// For each input, whether a result depends on it. Empty if this is not known.
    is_read: Vec<bool>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// A single operation.
    Single(Op),
    /// The layer with this index. The step belongs to its first row, but computes the whole layer.
    Layer(usize),
    /// Nothing remains to be done: the operation is a row of a layer that is already computed, or no result depends on it.
    Nothing,
}

/// A matrix-vector product: dot products of rows of shared numbers with a vector of own numbers. Own numbers differ
/// from point to point.
#[derive(Clone, Copy, Debug)]
pub(super) struct ReplayedLayer {
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// The place of the dot product for the first row. The dot product of each further row is `step` places later.
    pub(super) first: usize,
    pub(super) step: usize,
    /// The index of the first matrix entry among the shared arguments. The distance between rows is `stride`.
    pub(super) weights: usize,
    pub(super) stride: usize,
    /// The run of own numbers by which the matrix is multiplied. They differ from point to point.
    pub(super) own: Run,
}

/// A layer must have at least this many rows and entries. For smaller layers, transposing the own numbers takes more
/// time than the matrix product saves.
const LEAST_ROWS: usize = 4;
const LEAST_ENTRIES: usize = 64;
/// A new row is compared with this many of the most recent layers, to find its layer.
const OPEN: usize = 4;

impl ReplayedLayer {
    /// Returns a layer of one row if `op` is a dot product of adjacent shared numbers with own numbers, which differ
    /// from point to point.
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

    /// Adds a later row to the layer and returns true. Returns false if the row has another vector of own numbers, is
    /// not at the same distance as the rows before, overlaps the row before, or depends on an earlier row.
    fn take(&mut self, row: &Self) -> bool {
        if (row.own, row.columns) != (self.own, self.columns) || row.weights < self.weights {
            return false;
        }
        let (step, stride) = (row.first - self.first, row.weights - self.weights);
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

    /// The place of the dot product that belongs to a row.
    pub(super) fn place(&self, row: usize) -> usize {
        self.first + row * self.step
    }

    /// Returns the matrix, which lies among the shared arguments.
    pub(super) fn matrix<R: Real>(self, shared: &[R]) -> Strided<'_, R> {
        Strided::by_rows(&shared[self.weights..], self.stride)
    }
}

/// Finds the layers and returns them in the order of their first rows.
fn layers(ops: &[Op]) -> Vec<ReplayedLayer> {
    let mut layers: Vec<ReplayedLayer> = Vec::new();
    let rows = ops.iter().enumerate();
    for row in rows.filter_map(|(place, &op)| ReplayedLayer::of_row(place, op)) {
        // The rows of several layers may alternate, so compare with several recent layers.
        let mut last = layers.iter_mut().rev().take(OPEN);
        if !last.any(|layer| layer.take(&row)) {
            layers.push(row);
        }
    }
    layers.retain(ReplayedLayer::is_worth_it);
    layers
}

impl Plan {
    /// Records `code`, which takes the given numbers of inputs and of shared arguments. Returns `None` if the code asks
    /// for values or calls a function with its own derivative, because then the operations do not represent the code.
    pub(crate) fn record(
        [inputs, shared]: [usize; 2],
        code: impl FnOnce(&[Symbol], &[Symbol]) -> Vec<Symbol>,
    ) -> Option<Self> {
        Self::record_in(Recording::default(), [inputs, shared], code)
    }

    fn record_in(
        recording: Recording,
        [inputs, shared]: [usize; 2],
        code: impl FnOnce(&[Symbol], &[Symbol]) -> Vec<Symbol>,
    ) -> Option<Self> {
        let (results, recording) = record(recording, || {
            let inputs: Vec<Symbol> = (0..inputs).map(Symbol::input).collect();
            let shared: Vec<Symbol> = (0..shared).map(Symbol::shared).collect();
            code(&inputs, &shared)
        });
        let results = results.iter().map(|symbol| symbol.0).collect();
        (!recording.unfit).then(|| Self::new(recording, results))
    }

    /// Like [`record`](Self::record), for code without layers. Each subexpression is computed once, products with zero are
    /// zero, and what no result depends on is not computed.
    pub(crate) fn record_simplified(
        [inputs, shared]: [usize; 2],
        code: impl FnOnce(&[Symbol], &[Symbol]) -> Vec<Symbol>,
    ) -> Option<Self> {
        let recording = Recording::simplified(&[], &[]);
        let mut plan = Self::record_in(recording, [inputs, shared], code)?;
        let mut is_read = vec![false; plan.steps.len()];
        let own = |place: &&Place| !place.is_shared();
        (plan.results.iter().filter(own)).for_each(|place| is_read[place.at()] = true);
        for place in (inputs..plan.steps.len()).rev() {
            match plan.steps[place] {
                Step::Single(op) if is_read[place] => {
                    let operands = op.operands();
                    (operands.iter().filter(own)).for_each(|place| is_read[place.at()] = true);
                }
                _ => plan.steps[place] = Step::Nothing,
            }
        }
        plan.is_read = is_read[..inputs].to_vec();
        Some(plan)
    }

    fn new(recording: Recording, mut results: Vec<Place>) -> Self {
        let layers = layers(&recording.ops);
        let mut steps: Vec<Step> = recording.ops.into_iter().map(Step::Single).collect();
        for (number, layer) in layers.iter().enumerate() {
            for row in 0..layer.rows {
                steps[layer.place(row)] = Step::Nothing;
            }
            steps[layer.first] = Step::Layer(number);
        }
        let read = (!layers.is_empty()).then(|| count_read(&mut steps, &mut results));
        Self {
            steps,
            lines: recording.lines,
            results,
            layers,
            read,
            is_read: Vec::new(),
        }
    }

    /// False if no result depends on the input.
    pub(crate) fn reads(&self, input: usize) -> bool {
        self.is_read.get(input).is_none_or(|is_read| *is_read)
    }
}

/// Lists the shared arguments that are results or are read outside of layers, and returns this list. Changes the shared
/// places in `steps` and `results` to indices into the list.
fn count_read(steps: &mut [Step], results: &mut [Place]) -> Vec<usize> {
    let mut read = Vec::new();
    each_shared_run(steps, results, |run, len| {
        // If a run has gaps, the numbers in the gaps are included, so that it stays a run.
        read.extend(run.first.at()..=run.at(len as usize - 1).at());
        run
    });
    read.sort_unstable();
    read.dedup();
    let count = |at| read.partition_point(|&read| read < at);
    each_shared_run(steps, results, |run, _| Run {
        first: Place::shared(count(run.first.at())),
        ..run
    });
    read
}

/// Replaces, by the result of `f`, each run of shared places that is read outside of layers, and each result that is a
/// shared place.
fn each_shared_run(steps: &mut [Step], results: &mut [Place], mut f: impl FnMut(Run, u32) -> Run) {
    let mut replaced = |run: Run, len| {
        if run.first.is_shared() {
            f(run, len)
        } else {
            run
        }
    };
    for step in steps {
        if let Step::Single(op) = step {
            *op = op.with_operands(&mut replaced);
        }
    }
    for result in results {
        let alone = Run {
            first: *result,
            step: 1,
        };
        *result = replaced(alone, 1).first;
    }
}
