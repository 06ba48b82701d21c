//! A step of randomly drawn operations, both as a program and in plain code.

use autodiff::{Array, Graph, Kernel, Matrix, Model, Program, Real, kernel};

use crate::steps::{Step, Turn};

/// A kernel with three inputs and two results, which stay small.
#[derive(Clone, Copy)]
struct Cross;

#[kernel]
impl Kernel<3, 2> for Cross {
    fn eval<R: Real>(&self, [x, y, z]: [R; 3], _: &[R]) -> [R; 2] {
        let sum = x * y + z;
        [sum / (R::one() + sum * sum), R::lit(0.5) * (y - z)]
    }
}

/// A kernel that computes the force of an edge, which stays small.
#[derive(Clone, Copy)]
struct Tug;

#[kernel]
impl Kernel<2, 1> for Tug {
    fn eval<R: Real>(&self, [d, k]: [R; 2], _: &[R]) -> [R; 1] {
        let pull = k * d;
        [pull / (R::one() + pull * pull) * R::lit(0.1)]
    }
}

/// An operation of a step, or the declaration of a part of the state or of an input. Operations name arrays by their
/// numbers. The arrays of the parameters have the first numbers.
#[derive(Clone, Debug)]
pub(crate) enum Operation {
    Part(Part),
    Turn([usize; 2]),
    Cross([usize; 3]),
    Gather {
        from: usize,
        indices: Vec<Option<usize>>,
    },
    /// A layer of a network. It uses the next matrix of the list.
    Layer(Layer),
    Tug {
        end: usize,
        per_edge: usize,
    },
}

#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) seen: Vec<usize>,
    pub(crate) bias: usize,
    pub(crate) tanh: bool,
}

/// A part of the state, or an input.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    pub(crate) len: usize,
    pub(crate) is_state: bool,
}

/// Returns the parts that are declared among the operations, in order.
pub(crate) fn parts(operations: &[Operation]) -> impl Iterator<Item = &Part> {
    operations.iter().filter_map(|operation| match operation {
        Operation::Part(part) => Some(part),
        _ => None,
    })
}

/// A step that consists of drawn operations.
#[derive(Clone, Debug)]
pub(crate) struct Drawn {
    pub(crate) graph: Graph,
    /// The edges, each with a flag that is true if the graph leaves the edge out.
    pub(crate) edges: Vec<([usize; 2], bool)>,
    /// The lengths of the parameters that are arrays.
    pub(crate) parameters: Vec<usize>,
    /// The rows and columns of each matrix.
    pub(crate) matrices: Vec<[usize; 2]>,
    pub(crate) operations: Vec<Operation>,
    /// The numbers of the arrays that become the next state.
    pub(crate) next: Vec<usize>,
}

/// Returns a factor that keeps sums over the columns of order one.
fn scale<R: Real>([_, columns]: [usize; 2]) -> R {
    R::lit(1.0 / columns.max(1) as f64)
}

impl Drawn {
    /// Returns the numbers of those arrays that are parts of the state.
    pub(crate) fn states(&self) -> Vec<usize> {
        let mut next = self.parameters.len();
        let mut states = Vec::new();
        for operation in &self.operations {
            if let Operation::Part(Part { is_state: true, .. }) = operation {
                states.push(next);
            }
            next += match operation {
                Operation::Cross(_) => 2,
                _ => 1,
            };
        }
        states
    }

    pub(crate) fn is_parameter(&self, array: usize) -> bool {
        array < self.parameters.len()
    }

    pub(crate) fn layers(&self) -> impl Iterator<Item = &Layer> {
        self.operations
            .iter()
            .filter_map(|operation| match operation {
                Operation::Layer(layer) => Some(layer),
                _ => None,
            })
    }

    /// Returns how many numbers a state has.
    pub(crate) fn state_len(&self) -> usize {
        let states = parts(&self.operations).filter(|part| part.is_state);
        states.map(|part| part.len).sum()
    }
}

impl Model for Drawn {
    fn record(&self, p: &mut Program) {
        let parameters = self.parameters.iter();
        let mut arrays: Vec<Array> = parameters.map(|&len| p.parameter(len)).collect();
        let shapes = self.matrices.iter();
        let matrices: Vec<_> = shapes
            .map(|&[rows, columns]| p.matrix(rows, columns))
            .collect();
        let mut matrices = matrices.into_iter();
        let mut states = Vec::new();
        for operation in &self.operations {
            match operation {
                Operation::Part(part) if part.is_state => {
                    states.push(p.state(part.len));
                    arrays.extend(states.last());
                }
                Operation::Part(part) => arrays.push(p.input(part.len)),
                Operation::Turn(both) => arrays.extend(p.map(Turn, both.map(|k| arrays[k]), &[])),
                Operation::Cross(all) => arrays.extend(p.map(Cross, all.map(|k| arrays[k]), &[])),
                Operation::Gather { from, indices } => {
                    arrays.push(p.gather(arrays[*from], indices));
                }
                Operation::Layer(layer) => {
                    arrays.push(layer.record(p, matrices.next().unwrap(), &arrays));
                }
                &Operation::Tug { end, per_edge } => {
                    let (ends, per_edge) = ([arrays[end]], [arrays[per_edge]]);
                    arrays.extend(p.map_edges(&self.graph, Tug, ends, &per_edge, &[]));
                }
            }
        }
        for (state, &next) in states.into_iter().zip(&self.next) {
            p.advance(state, arrays[next]);
        }
    }
}

impl Layer {
    fn record(&self, p: &mut Program, matrix: Matrix, arrays: &[Array]) -> Array {
        let seen: Vec<Array> = self.seen.iter().map(|&k| arrays[k]).collect();
        let bias = arrays[self.bias];
        match self.tanh {
            true => p.dense_tanh(matrix, &seen, bias),
            false => p.dense(matrix, &seen, bias),
        }
    }

    fn written_out<R: Real>(
        &self,
        (matrix, shape): (&[R], [usize; 2]),
        arrays: &[Vec<R>],
    ) -> Vec<R> {
        let seen: Vec<R> = self.seen.iter().flat_map(|&k| arrays[k].clone()).collect();
        let rows = (0..shape[0]).map(|row| {
            let weights = &matrix[row * seen.len()..][..seen.len()];
            let sum = R::dot(weights, &seen) * scale::<R>(shape) + arrays[self.bias][row];
            if self.tanh { sum.tanh() } else { sum }
        });
        rows.collect()
    }
}

impl Step for Drawn {
    fn shapes(&self) -> Vec<usize> {
        let matrices = self.matrices.iter().map(|[rows, columns]| rows * columns);
        let parameters = self.parameters.iter().copied().chain(matrices);
        std::iter::once(self.state_len())
            .chain(parameters)
            .collect()
    }

    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        let (arrays, matrices) = given.split_at(self.parameters.len());
        let scaled = matrices.iter().zip(&self.matrices).map(|(matrix, &shape)| {
            let entries = matrix.iter().map(|&entry| entry * scale::<R>(shape));
            entries.collect()
        });
        arrays.iter().map(|a| a.to_vec()).chain(scaled).collect()
    }

    fn inputs(&self) -> Vec<f64> {
        let inputs = parts(&self.operations).filter(|part| !part.is_state);
        let len: usize = inputs.map(|part| part.len).sum();
        (0..len).map(|i| 0.1 * i as f64 - 0.3).collect()
    }

    fn written_out<R: Real>(&self, mut state: &[R], given: &[&[R]]) -> Vec<R> {
        let (arrays, matrices) = given.split_at(self.parameters.len());
        let mut matrices = matrices.iter().copied().zip(self.matrices.iter().copied());
        let mut arrays: Vec<Vec<R>> = arrays.iter().map(|a| a.to_vec()).collect();
        let mut inputs = self.inputs().into_iter().map(R::lit);
        for operation in &self.operations {
            match operation {
                Operation::Part(part) if part.is_state => {
                    arrays.push(state.split_off(..part.len).unwrap().to_vec());
                }
                Operation::Part(part) => {
                    arrays.push(inputs.by_ref().take(part.len).collect());
                }
                &Operation::Turn([x, y]) => {
                    let both = arrays[x].iter().zip(&arrays[y]);
                    let turned = both.map(|(&x, &y)| Kernel::eval(&Turn, [x, y], &[])[0]);
                    arrays.push(turned.collect());
                }
                &Operation::Cross(all) => {
                    let cross = |i| Kernel::eval(&Cross, all.map(|k| arrays[k][i]), &[]);
                    let both: Vec<[R; 2]> = (0..arrays[all[0]].len()).map(cross).collect();
                    arrays.extend([0, 1].map(|k| both.iter().map(|y| y[k]).collect()));
                }
                Operation::Gather { from, indices } => {
                    let pick = |i: &Option<usize>| i.map_or(R::zero(), |i| arrays[*from][i]);
                    arrays.push(indices.iter().map(pick).collect());
                }
                Operation::Layer(layer) => {
                    arrays.push(layer.written_out(matrices.next().unwrap(), &arrays));
                }
                &Operation::Tug { end, per_edge } => {
                    arrays.push(self.tugs(&arrays[end], &arrays[per_edge]));
                }
            }
        }
        self.next.iter().flat_map(|&k| arrays[k].clone()).collect()
    }
}

impl Drawn {
    /// Returns the sum of the forces at each node. Only the edges that the graph has contribute.
    fn tugs<R: Real>(&self, end: &[R], per_edge: &[R]) -> Vec<R> {
        let mut sums = vec![R::zero(); self.graph.nodes()];
        let slots = self.graph.slot_of_edge().iter().zip(&self.edges);
        for (&slot, &([tail, head], _)) in slots.filter(|(_, (_, without))| !without) {
            let [tug] = Kernel::eval(&Tug, [end[head] - end[tail], per_edge[slot]], &[]);
            sums[tail] += tug;
            sums[head] -= tug;
        }
        sums
    }
}
