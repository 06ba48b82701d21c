//! Draws random steps.

use autodiff_programs::Graph;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::step::{Drawn, Kind, Layer, Operation, Part, parts};

/// Draws a random step, array by array.
struct Draw {
    rng: ChaCha8Rng,
    /// The lengths that new arrays may have: the number of nodes, the number of slots of the graph, one other length,
    /// and the length of uniform inputs.
    lens: [usize; 4],
    /// The kinds of the first arrays, which are parameters.
    kinds: Vec<Kind>,
    /// The lengths of the arrays drawn so far.
    arrays: Vec<usize>,
    matrices: Vec<[usize; 2]>,
}

impl Draw {
    fn below(&mut self, end: usize) -> usize {
        self.rng.random_range(0..end)
    }

    fn one_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    fn len(&mut self) -> usize {
        let k = self.below(self.lens.len());
        self.lens[k]
    }

    /// Draws the lengths of `count` new arrays.
    fn new_arrays(&mut self, count: usize) -> Vec<usize> {
        let lens: Vec<usize> = (0..count).map(|_| self.len()).collect();
        self.arrays.extend(&lens);
        lens
    }

    fn any(&mut self) -> usize {
        self.below(self.arrays.len())
    }

    /// Draws one of the arrays that have this length, if there is one.
    fn of(&mut self, len: usize) -> Option<usize> {
        let all = (0..self.arrays.len()).filter(|&k| self.arrays[k] == len);
        let all: Vec<usize> = all.collect();
        (!all.is_empty()).then(|| all[self.below(all.len())])
    }

    /// Draws a uniform input. The first parameter is drawn often, because every start of a batch has its own.
    fn uniform(&mut self) -> Option<usize> {
        let first = !self.kinds.is_empty() && self.arrays[0] == 1 && self.one_in(2);
        if first { Some(0) } else { self.of(1) }
    }

    fn weighted(&mut self) -> Option<Operation> {
        let all = self.kinds.iter().zip(&self.arrays).enumerate();
        let mut all = all.filter(|&(_, (&kind, &len))| kind == Kind::Weights && len > 0);
        let (weights, (_, &len)) = all.next_back()?;
        let (of, other) = ([self.of(len)?, self.of(len)?], self.any());
        self.arrays.extend([2 * len + self.arrays[other], 1, len]);
        Some(Operation::Weighted { weights, of, other })
    }

    /// Draws the declaration of a part of the state or of an input.
    fn part(&mut self, is_state: bool) -> Operation {
        let [len] = self.new_arrays(1)[..] else {
            unreachable!("one was asked for");
        };
        Operation::Part(Part { len, is_state })
    }

    /// Draws the parts that are declared before all operations. At least one of them is a part of the state.
    fn parts(&mut self) -> Vec<Operation> {
        let count = 1 + self.below(4);
        let state = self.below(count);
        let part = |k| {
            let is_state = k == state || !self.one_in(3);
            self.part(is_state)
        };
        (0..count).map(part).collect()
    }

    /// Draws an operation. Returns `None` if no array has the length that the operation needs.
    fn operation(&mut self) -> Option<Operation> {
        match self.below(7) {
            0 => {
                let len = self.len();
                self.turn(len)
            }
            1 => {
                let len = self.len();
                let of = [self.of(len)?, self.of(len)?, self.of(len)?];
                let uniform = self.uniform()?;
                self.arrays.extend([len; 2]);
                Some(Operation::Cross { of, uniform })
            }
            2 => {
                let from = self.any();
                let len = self.arrays[from];
                let indices = (0..self.new_arrays(1)[0])
                    .map(|_| (len > 0 && !self.one_in(4)).then(|| self.below(len)));
                let indices = indices.collect();
                Some(Operation::Gather { from, indices })
            }
            3 => Some(Operation::Layer(self.layer())),
            4 => {
                let is_state = self.one_in(2);
                Some(self.part(is_state))
            }
            5 => self.weighted(),
            _ => {
                let [nodes, slots, ..] = self.lens;
                let ends = [self.of(nodes)?, self.of(nodes)?];
                let (per_edge, uniform) = (self.of(slots)?, self.uniform()?);
                self.arrays.extend([nodes; 3]);
                Some(Operation::Tug {
                    ends,
                    per_edge,
                    uniform,
                })
            }
        }
    }

    fn turn(&mut self, len: usize) -> Option<Operation> {
        let both = [self.of(len)?, self.of(len)?];
        self.arrays.push(len);
        Some(Operation::Turn(both))
    }

    fn layer(&mut self) -> Layer {
        let bias = self.any();
        let rows = self.arrays[bias];
        let seen: Vec<usize> = (0..1 + self.below(3)).map(|_| self.any()).collect();
        let columns = seen.iter().map(|&k| self.arrays[k]).sum();
        self.matrices.push([rows, columns]);
        self.arrays.push(rows);
        Layer {
            seen,
            bias,
            tanh: self.one_in(2),
        }
    }

    /// Draws the arrays that become the next state. These are arrays that exist already, or new ones side by side in
    /// the order of the states.
    fn next(&mut self, states: &[usize], operations: &mut Vec<Operation>) -> Vec<usize> {
        let side_by_side = self.one_in(2);
        let next = states.iter().map(|&len| {
            if side_by_side {
                operations.extend(self.turn(len));
                self.arrays.len() - 1
            } else {
                self.of(len).expect("the state itself")
            }
        });
        next.collect()
    }
}

impl Drawn {
    /// Draws the step that belongs to a seed.
    pub(crate) fn new(seed: u64) -> Self {
        let mut draw = Draw {
            rng: ChaCha8Rng::seed_from_u64(seed),
            lens: [0; 4],
            kinds: Vec::new(),
            arrays: Vec::new(),
            matrices: Vec::new(),
        };
        let nodes = [1, 4, 8, 11, 16][draw.below(5)];
        // The sum over a node's edges is computed for up to four directions at once.
        let directions = [2, 6][draw.below(2)];
        let heads = |tail| (tail + 1..nodes).take(directions);
        let all = (0..nodes).flat_map(|tail| heads(tail).map(move |head| [tail, head]));
        let ends: Vec<[usize; 2]> = all.filter(|_| !draw.one_in(3)).collect();
        // The first seventeen edges fill whole registers.
        let first = [0, 17][draw.below(2)];
        let without = (0..ends.len()).map(|edge| edge < first || draw.one_in(3));
        let without: Vec<bool> = without.collect();
        let graph = Graph::new(nodes, &ends).without(&without);
        draw.lens = [nodes, graph.slots(), [0, 3, 16, 17][draw.below(4)], 1];
        let kinds = [Kind::Plain, Kind::Control, Kind::Weights];
        draw.kinds = (0..draw.below(4)).map(|_| kinds[draw.below(3)]).collect();
        let lens = draw.new_arrays(draw.kinds.len());
        let parameters = draw.kinds.iter().copied().zip(lens).collect();
        let mut operations = draw.parts();
        let more = 0..1 + draw.below(8);
        operations.extend(more.filter_map(|_| draw.operation()));
        let states = parts(&operations).filter(|part| part.is_state);
        let states: Vec<usize> = states.map(|part| part.len).collect();
        Self {
            next: draw.next(&states, &mut operations),
            graph,
            edges: ends.into_iter().zip(without).collect(),
            parameters,
            matrices: draw.matrices,
            operations,
        }
    }
}
