//! A step of randomly drawn operations, both as a program and in plain code.

use autodiff::Real;
use autodiff_programs::{Array, Graph, Kernel, Matrix, Model, Program, kernel};

use super::weighted::Weighted;
use crate::steps::{STEPS, Step, Turn};

/// A kernel with three inputs, a uniform input and two results, which stay small. It has each kind of operation.
#[derive(Clone, Copy)]
struct Cross;

#[kernel]
impl Kernel<3, 2> for Cross {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [x, y, z]: [R; 3], u: &[R]) -> [R; 2] {
        let least = R::select(x.less(y), x, y);
        let sum = least.fma(z, R::dot(&[u[0], x], &[y, z]));
        let other = R::sum_of(&[y, -z, u[0].sin()]);
        [sum / (R::one() + sum * sum), R::lit(0.3) * other]
    }
}

/// A kernel that computes forces of an edge, which stay small, from two differences of its ends.
#[derive(Clone, Copy)]
struct Tug;

#[kernel]
impl Kernel<3, 3> for Tug {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, [dx, dy, k]: [R; 3], u: &[R]) -> [R; 3] {
        let length = (dx * dx + dy * dy + k * k + R::one()).sqrt();
        let pull = R::lit(0.1) * k / length;
        [pull * dx / length, pull * dy / length, pull * u[0]]
    }
}

/// An operation of a step, or the declaration of a part of the state or of an input. Operations name arrays by their
/// numbers. The arrays of the parameters have the first numbers.
#[derive(Clone, Debug)]
pub(crate) enum Operation {
    Part(Part),
    Turn([usize; 2]),
    Cross {
        of: [usize; 3],
        uniform: usize,
    },
    Gather {
        from: usize,
        indices: Vec<Option<usize>>,
    },
    /// A layer of a network. It uses the next matrix of the list.
    Layer(Layer),
    Tug {
        ends: [usize; 2],
        per_edge: usize,
        uniform: usize,
    },
    /// Weights an offset and a value and appends another array. The last result gathers some of these numbers.
    Weighted {
        weights: usize,
        of: [usize; 2],
        other: usize,
    },
}

impl Operation {
    /// The number of arrays that the operation adds.
    fn results(&self) -> usize {
        match self {
            Self::Cross { .. } => 2,
            Self::Tug { .. } | Self::Weighted { .. } => 3,
            _ => 1,
        }
    }
}

#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) seen: Vec<usize>,
    pub(crate) bias: usize,
    pub(crate) tanh: bool,
}

/// What a parameter that is an array is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Plain,
    /// It has a different value in every step.
    Control,
    /// Its numbers are positive.
    Weights,
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
    /// The kinds and lengths of the parameters that are arrays.
    pub(crate) parameters: Vec<(Kind, usize)>,
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
            next += operation.results();
        }
        states
    }

    pub(crate) fn is_parameter(&self, array: usize) -> bool {
        array < self.parameters.len()
    }

    pub(crate) fn has(&self, of: impl FnMut(&Operation) -> bool) -> bool {
        self.operations.iter().any(of)
    }

    /// Returns the numbers of those arrays that are uniform inputs.
    pub(crate) fn uniforms(&self) -> impl Iterator<Item = usize> {
        let operations = self.operations.iter();
        operations.filter_map(|operation| match operation {
            &Operation::Cross { uniform, .. } | &Operation::Tug { uniform, .. } => Some(uniform),
            _ => None,
        })
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
        let parameter = |&(kind, len): &(Kind, usize)| match kind {
            Kind::Control => p.control(len),
            _ => p.parameter(len),
        };
        let mut arrays: Vec<Array> = parameters.map(parameter).collect();
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
                Operation::Cross { of, uniform } => {
                    let uniform = [arrays[*uniform]];
                    arrays.extend(p.map(Cross, of.map(|k| arrays[k]), &uniform));
                }
                Operation::Gather { from, indices } => {
                    arrays.push(p.gather(arrays[*from], indices));
                }
                Operation::Layer(layer) => {
                    arrays.push(layer.record(p, matrices.next().unwrap(), &arrays));
                }
                &Operation::Tug {
                    ends,
                    per_edge,
                    uniform,
                } => {
                    let [per_edge, uniform] = [per_edge, uniform].map(|k| [arrays[k]]);
                    let ends = ends.map(|k| arrays[k]);
                    arrays.extend(p.map_edges(&self.graph, Tug, ends, &per_edge, &uniform));
                }
                &Operation::Weighted { weights, of, other } => {
                    let inputs = [weights, of[0], of[1], other].map(|k| arrays[k]);
                    let (len, appended) = (inputs[0].len(), inputs[3].len());
                    let outputs = p.operation(Weighted, &inputs, &[2 * len + appended, 1]);
                    let some = p.gather(outputs[0], &some_weighted(len));
                    arrays.extend(outputs.into_iter().chain([some]));
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

    fn written_out<R: Real>(&self, matrix: &[R], arrays: &[Vec<R>]) -> Vec<R> {
        let seen: Vec<R> = self.seen.iter().flat_map(|&k| arrays[k].clone()).collect();
        let rows = arrays[self.bias].iter().enumerate().map(|(row, &bias)| {
            let sum = R::dot(&matrix[row * seen.len()..][..seen.len()], &seen) + bias;
            if self.tanh { sum.tanh() } else { sum }
        });
        rows.collect()
    }
}

impl Step for Drawn {
    fn shapes(&self) -> Vec<usize> {
        let matrices = self.matrices.iter().map(|[rows, columns]| rows * columns);
        let parameters = self.parameters.iter().map(|&(kind, len)| match kind {
            Kind::Control => STEPS * len,
            _ => len,
        });
        let parameters = parameters.chain(matrices);
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
        let arrays = arrays
            .iter()
            .zip(&self.parameters)
            .map(|(array, &(kind, _))| {
                let number = |&x: &R| match kind {
                    Kind::Weights => x * x + R::lit(0.2),
                    _ => x,
                };
                array.iter().map(number).collect()
            });
        arrays.chain(scaled).collect()
    }

    fn inputs(&self) -> Vec<f64> {
        let inputs = parts(&self.operations).filter(|part| !part.is_state);
        let len: usize = inputs.map(|part| part.len).sum();
        (0..len).map(|i| 0.1 * i as f64 - 0.3).collect()
    }

    fn written_out<R: Real>(&self, step: usize, mut state: &[R], given: &[&[R]]) -> Vec<R> {
        let mut arrays = self.parameters(given);
        let mut matrices = arrays.split_off(self.parameters.len()).into_iter();
        for (array, &(kind, len)) in arrays.iter_mut().zip(&self.parameters) {
            if kind == Kind::Control {
                *array = array[step * len..][..len].to_vec();
            }
        }
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
                Operation::Cross { of, uniform } => {
                    let uniform = &arrays[*uniform];
                    let cross = |i| Kernel::eval(&Cross, of.map(|k| arrays[k][i]), uniform);
                    let both: Vec<[R; 2]> = (0..arrays[of[0]].len()).map(cross).collect();
                    arrays.extend([0, 1].map(|k| both.iter().map(|y| y[k]).collect()));
                }
                Operation::Gather { from, indices } => {
                    let pick = |i: &Option<usize>| i.map_or(R::zero(), |i| arrays[*from][i]);
                    arrays.push(indices.iter().map(pick).collect());
                }
                Operation::Layer(layer) => {
                    arrays.push(layer.written_out(&matrices.next().unwrap(), &arrays));
                }
                &Operation::Tug {
                    ends,
                    per_edge,
                    uniform,
                } => {
                    let ends = ends.map(|k| &arrays[k][..]);
                    arrays.extend(self.tugs(ends, &arrays[per_edge], &arrays[uniform]));
                }
                &Operation::Weighted { weights, of, other } => {
                    let [offset, value] = of.map(|k| &arrays[k]);
                    arrays.extend(weighted(&arrays[weights], offset, value, &arrays[other]));
                }
            }
        }
        self.next.iter().flat_map(|&k| arrays[k].clone()).collect()
    }
}

impl Drawn {
    /// Returns the sums of the forces at each node. Only the edges that the graph has contribute.
    fn tugs<R: Real>(&self, ends: [&[R]; 2], per_edge: &[R], uniform: &[R]) -> [Vec<R>; 3] {
        let mut sums = [(); 3].map(|()| vec![R::zero(); self.graph.nodes()]);
        let slots = self.graph.slot_of_edge().iter().zip(&self.edges);
        for (&slot, &([tail, head], _)) in slots.filter(|(_, (_, without))| !without) {
            let [dx, dy] = ends.map(|end| end[head] - end[tail]);
            let tugs = Kernel::eval(&Tug, [dx, dy, per_edge[slot]], uniform);
            for (sums, tug) in sums.iter_mut().zip(tugs) {
                sums[tail] += tug;
                sums[head] -= tug;
            }
        }
        sums
    }
}

/// The places that a step gathers from arrays of this length that are weighted: half of them in each array.
fn some_weighted(len: usize) -> Vec<Option<usize>> {
    (0..len).map(|i| Some(i + i % 2 * len)).collect()
}

fn weighted<R: Real>(weights: &[R], offset: &[R], value: &[R], other: &[R]) -> [Vec<R>; 3] {
    let mean = R::dot(offset, weights) / R::sum_of(weights);
    let offset = offset.iter().map(|&x| x - mean);
    let both = offset
        .chain(value.iter().copied())
        .zip(weights.iter().cycle());
    let all = both.map(|(x, &weight)| weight * x);
    let all: Vec<R> = all.chain(other.iter().copied()).collect();
    let some = some_weighted(weights.len()).into_iter().flatten();
    let some = some.map(|i| all[i]).collect();
    [all, vec![mean], some]
}
