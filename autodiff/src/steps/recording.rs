//! The methods of [`Program`] that record operations.

use super::operation::StepOperation;
use super::program::Program;
use crate::arrays::{
    Array, DenseLayer, EdgeMap, Gather, Graph, InLanes, Kernel, Layer, Map, Matrix, Parameter,
    UniformKernel, Weighted, repeated,
};
use crate::real::Real;

/// The operations. Each panics if it is given an array or a matrix of another program, unless this program has one
/// of the same shape in the same place, which cannot be distinguished.
impl<R: Real> Program<R> {
    fn assert_known_matrix(&self, matrix: Matrix) {
        let known = self.parameters.get(matrix.parameter);
        let is_known = matches!(known, Some(Parameter::Matrix(m)) if *m == matrix);
        assert!(is_known, "this matrix belongs to another program");
    }

    /// Maps a kernel over arrays of one length: element `k` of the outputs is the kernel at the elements `k` of `x`.
    ///
    /// Numbers that all elements share are [uniform inputs](Program::map_with).
    ///
    /// # Panics
    /// If the arrays differ in length, if one belongs to another program, or if the kernel has no inputs or no
    /// results.
    pub fn map<K, const I: usize, const O: usize>(&mut self, kernel: K, x: [Array; I]) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        self.map_with(kernel, x, &[])
    }

    /// [`map`](Program::map) for a kernel with [uniform inputs](UniformKernel): arrays of one number, which
    /// all elements share. The cotangent of a uniform input is the sum over all elements, in their order. It is only
    /// computed for inputs that carry derivatives.
    ///
    /// # Panics
    /// As [`map`](Program::map). Also if the number of uniform inputs is not that of the kernel, or one of them does
    /// not have one number.
    pub fn map_with<K, const I: usize, const O: usize>(
        &mut self,
        kernel: K,
        x: [Array; I],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: UniformKernel<I, O>,
    {
        self.assert_uniform(uniforms);
        let map = |outputs: &[Array]| {
            let map = Map::new(kernel, x, uniforms, arrays(outputs));
            StepOperation::Kernel(Box::new(InLanes(map)))
        };
        arrays(&self.map_by(&x, O, map))
    }

    pub(crate) fn assert_uniform(&self, arrays: &[Array]) {
        self.assert_known(arrays);
        let is_one = arrays.iter().all(|array| array.len() == 1);
        assert!(is_one, "a uniform input must be an array of one number");
    }

    /// Maps by the operation that `map` makes for the outputs, one for each of the results.
    pub(crate) fn map_by(
        &mut self,
        x: &[Array],
        results: usize,
        map: impl FnOnce(&[Array]) -> StepOperation<R>,
    ) -> Vec<Array> {
        self.assert_known(x);
        let len = x.first().expect("map: the kernel must have inputs").len();
        assert!(results > 0, "map: the kernel must have at least one result");
        assert!(
            x.iter().all(|a| a.len() == len),
            "map: the arrays must have the same length"
        );
        let outputs = self.outputs(len, results);
        self.operations.push(map(&outputs));
        outputs
    }

    /// `matrix * (x_0, x_1, ...) + bias`, where the arrays of `x` are one vector.
    ///
    /// # Panics
    /// If the columns of the matrix are not as many as the numbers of all arrays, if its rows are not as many as the
    /// numbers of the bias, or if one of them belongs to another program.
    pub fn dense(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer(matrix, x, bias, &vec![true; matrix.rows], false)
    }

    /// `tanh(matrix * (x_0, x_1, ...) + bias)`. Its slope is that of [`layer_tanh`](Real::layer_tanh), `1 - y^2`, in
    /// all modes, where `y` is the result.
    ///
    /// # Panics
    /// As [`dense`](Program::dense).
    pub fn dense_tanh(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer(matrix, x, bias, &vec![true; matrix.rows], true)
    }

    /// `tanh(matrix * (x_0, x_1, ...) + bias)` among zeros. The result is as long as `places` and has the entries of
    /// the layer, in order, where `places` is true.
    ///
    /// # Panics
    /// As [`dense`](Program::dense). Also if the number of true places is not the number of rows.
    pub fn dense_tanh_spread(
        &mut self,
        matrix: Matrix,
        x: &[Array],
        bias: Array,
        places: &[bool],
    ) -> Array {
        self.dense_layer(matrix, x, bias, places, true)
    }

    fn dense_layer(
        &mut self,
        matrix: Matrix,
        x: &[Array],
        bias: Array,
        places: &[bool],
        tanh: bool,
    ) -> Array {
        self.assert_known(x);
        self.assert_known(&[bias]);
        self.assert_known_matrix(matrix);
        let columns: usize = x.iter().map(|a| a.len()).sum();
        assert_eq!(
            columns, matrix.columns,
            "dense: the inputs together must be as long as the matrix has columns"
        );
        assert_eq!(
            bias.len(),
            matrix.rows,
            "dense: the bias must be as long as the matrix has rows"
        );
        let rows = places.iter().filter(|row| **row).count();
        assert_eq!(
            rows, matrix.rows,
            "dense: as many places must be true as the matrix has rows"
        );
        let output = self.output(places.len());
        // The last register of a spread output is written whole, so nothing else may follow in it.
        self.align(false);
        let places = repeated(places, self.starts);
        let layer = Layer {
            matrix,
            x,
            bias,
            output,
            places: &places,
            tanh,
        };
        let layer = DenseLayer::new(layer);
        self.operations.push(StepOperation::Dense(Box::new(layer)));
        output
    }

    /// Maps a kernel over the edges of a graph and sums its results at the nodes, as springs pull on masses.
    ///
    /// For each edge, the inputs of the kernel are first the differences of `ends`, which are arrays over the nodes:
    /// the value at the head minus the value at the tail. Then follow the values of `per_edge`, which are arrays in
    /// the slot layout of the [`Graph`]. Each result is added at the tail of the edge and subtracted at its head, so
    /// the outputs are arrays over the nodes.
    ///
    /// ```
    /// use autodiff::{Graph, Kernel, Model, Program, Real, Rollout, Var, gradient};
    ///
    /// /// The heat that flows from head to tail in a step.
    /// #[derive(Clone, Copy)]
    /// struct Conduction;
    ///
    /// impl Kernel<2, 1> for Conduction {
    ///     #[inline(always)]
    ///     fn eval<R: Real>(&self, [difference, conductivity]: [R; 2]) -> [R; 1] {
    ///         [conductivity * difference]
    ///     }
    /// }
    ///
    /// #[derive(Clone, Copy)]
    /// struct Sum;
    ///
    /// impl Kernel<2, 1> for Sum {
    ///     #[inline(always)]
    ///     fn eval<R: Real>(&self, [a, b]: [R; 2]) -> [R; 1] {
    ///         [a + b]
    ///     }
    /// }
    ///
    /// /// Temperatures of bodies in a row.
    /// #[derive(Clone)]
    /// struct Bar(Graph);
    ///
    /// impl Model for Bar {
    ///     fn record<R: Real>(&self, program: &mut Program<R>) {
    ///         let conductivity = program.parameter(self.0.slots());
    ///         let t = program.state(self.0.nodes());
    ///         let [gain] = program.map_edges(&self.0, Conduction, [t], &[conductivity]);
    ///         let [next] = program.map(Sum, [t, gain]);
    ///         program.advance(t, next);
    ///     }
    /// }
    ///
    /// let graph = Graph::new(3, &[[0, 1], [1, 2]]);
    /// let bar = Rollout::new(Bar(graph.clone()), 1);
    /// let conductivity = graph.to_slots(&[0.5, 0.25]);
    /// assert_eq!(bar.run(&[0.0, 4.0, 8.0], &[&conductivity]), [2.0, 3.0, 7.0]);
    /// // The derivative of the middle temperature by the conductivities of both edges.
    /// let middle = |k: &[Var<f64>]| {
    ///     let t = [0.0, 4.0, 8.0].map(Var::constant);
    ///     bar.run(&t, &[&graph.to_slots(k)])[1]
    /// };
    /// assert_eq!(gradient(middle, &[0.5, 0.25]), [-4.0, 4.0]);
    /// ```
    ///
    /// # Panics
    /// If an array of `ends` is not as long as the graph has nodes, if an array of `per_edge` is not as long as it has
    /// slots, if both together are not as many as the kernel's inputs, if an array belongs to another program, or if
    /// the kernel has no results.
    pub fn map_edges<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
    ) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        self.map_edges_with(graph, kernel, ends, per_edge, &[])
    }

    /// [`map_edges`](Program::map_edges) for a kernel with [uniform inputs](Program::map_with).
    ///
    /// # Panics
    /// As these two methods.
    pub fn map_edges_with<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: UniformKernel<I, O>,
    {
        self.assert_uniform(uniforms);
        let outputs = self.map_edges_by(graph, &ends, per_edge, O, |graph, outputs| {
            let map = EdgeMap::new(kernel, graph, ends, per_edge, uniforms, arrays(outputs));
            StepOperation::Kernel(Box::new(InLanes(map)))
        });
        arrays(&outputs)
    }

    /// Maps over edges by the operation that `map` makes for the graph of all starts and the outputs, one for each of
    /// the results.
    pub(crate) fn map_edges_by(
        &mut self,
        graph: &Graph,
        ends: &[Array],
        per_edge: &[Array],
        results: usize,
        map: impl FnOnce(&Graph, &[Array]) -> StepOperation<R>,
    ) -> Vec<Array> {
        self.assert_known(ends);
        self.assert_known(per_edge);
        let fits = ends.iter().all(|a| a.len() == graph.nodes());
        assert!(
            fits,
            "map_edges: an array of `ends` needs one value for each node"
        );
        let fits = per_edge.iter().all(|a| a.len() == graph.slots());
        assert!(
            fits,
            "map_edges: an array of `per_edge` needs one value for each slot"
        );
        let interleaved = graph.side_by_side(self.starts);
        self.margin = self.margin.max(interleaved.lead());
        let outputs = self.outputs(graph.nodes(), results);
        self.operations.push(map(&interleaved, &outputs));
        outputs
    }

    /// `x[index]` for every index, and zero for `None`. `&[Some(0); 8]` makes eight copies of a single number.
    ///
    /// # Panics
    /// If an index is out of range, or the array belongs to another program.
    pub fn gather(&mut self, x: Array, indices: &[Option<usize>]) -> Array {
        self.assert_known(&[x]);
        assert!(
            indices.iter().flatten().all(|&i| i < x.len()),
            "gather: an index is out of range"
        );
        let output = self.output(indices.len());
        self.operations
            .push(StepOperation::Gather(InLanes(Gather::new(
                x, indices, output,
            ))));
        output
    }

    /// Weights arrays entry by entry. The first result is one array: the `weights` times the offset of each array of
    /// `offsets` from its weighted mean, then the `weights` times each array of `values`, then `others` unchanged. The
    /// second result is the means of the arrays of `offsets`.
    ///
    /// The mean is `sum w x / sum w`, so an entry with weight 0 does not count. The mean is NaN if all weights are 0.
    ///
    /// ```
    /// use autodiff::{Model, Program, Real, Rollout};
    ///
    /// /// Moves every point by its weighted offset from the mean.
    /// #[derive(Clone)]
    /// struct Spread;
    ///
    /// impl Model for Spread {
    ///     fn record<R: Real>(&self, program: &mut Program<R>) {
    ///         let (weights, x) = (program.parameter(3), program.state(3));
    ///         let [offsets, _mean] = program.weighted(weights, &[x], &[], &[]);
    ///         program.advance(x, offsets);
    ///     }
    /// }
    ///
    /// let offsets = Rollout::new(Spread, 1).run(&[1.0, 3.0, 50.0], &[&[1.0, 1.0, 0.0]]);
    /// assert_eq!(offsets, [-1.0, 1.0, 0.0]);
    /// ```
    ///
    /// # Panics
    /// If an array of `offsets` or `values` is not as long as the weights, or an array belongs to another program.
    pub fn weighted(
        &mut self,
        weights: Array,
        offsets: &[Array],
        values: &[Array],
        others: &[Array],
    ) -> [Array; 2] {
        let weighed = [offsets, values].concat();
        self.assert_known(&[&[weights][..], &weighed, others].concat());
        assert!(
            weighed.iter().all(|array| array.len() == weights.len()),
            "weighted: an array needs one number for each weight"
        );
        let appended: usize = others.iter().map(|array| array.len()).sum();
        self.align(false);
        let lengths = [weighed.len() * weights.len() + appended, offsets.len(), 1];
        let outputs = lengths.map(|len| self.unaligned_output(len));
        let operation = Weighted::new(weights, [offsets, values], others, outputs);
        self.operations
            .push(StepOperation::Weighted(InLanes(operation)));
        [outputs[0], outputs[1]]
    }
}

/// As many handles as the kernel has results.
fn arrays<const O: usize>(handles: &[Array]) -> [Array; O] {
    std::array::from_fn(|k| handles[k])
}
