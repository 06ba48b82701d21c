//! Recording what a step does with its arrays.

use super::{
    Array, Graph, Matrix, Parameter, Program, WIDEST, dense, edges, gather, map, repeated, sum,
};
use crate::kernel::Adjoint;
use crate::real::Real;

/// The operations. Each panics where this program has no such array or matrix as a handle stands
/// for. A handle of another program that stands for one in the same place, of the same shape, is
/// not told from this one's.
impl<R: Real> Program<R> {
    fn know_matrix(&self, matrix: Matrix) {
        let known = self.parameters.get(matrix.parameter);
        let is_known = matches!(known, Some(Parameter::Matrix(m)) if *m == matrix);
        assert!(is_known, "a matrix is of another program");
    }

    /// Maps a kernel over arrays of one length.
    ///
    /// A number that all elements share is an array of one, spread by [`gather`](Program::gather):
    ///
    /// ```
    /// # use autodiff::{Adjoint, Kernel, Model, Program, Real, Rollout};
    /// # #[derive(Clone)]
    /// # struct Decay;
    /// impl Kernel<2, 1> for Decay {
    ///     #[inline(always)]
    ///     fn eval<R: Real>(&self, [x, rate]: [R; 2]) -> [R; 1] {
    ///         [x - rate * x]
    ///     }
    /// }
    /// # impl Adjoint<2, 1> for Decay {}
    /// impl Model for Decay {
    ///     fn record<R: Real>(&self, program: &mut Program<R>) {
    ///         let (rate, x) = (program.parameter(1), program.state(3));
    ///         let rates = program.gather(rate, &[Some(0); 3]);
    ///         let [next] = program.map(Decay, [x, rates]);
    ///         program.advance(x, next);
    ///     }
    /// }
    /// assert_eq!(Rollout::new(Decay, 2).run(&[4.0, 8.0, 12.0], &[&[0.5]]), [1.0, 2.0, 3.0]);
    /// ```
    ///
    /// # Panics
    /// If the arrays differ in length or there is none, or one is of another program; if the kernel has
    /// no results.
    pub fn map<K, const I: usize, const O: usize>(&mut self, kernel: K, x: [Array; I]) -> [Array; O]
    where
        K: Adjoint<I, O>,
    {
        self.know(&x);
        let len = x.first().expect("map: a kernel without inputs").len();
        assert!(O > 0, "map: a kernel without results");
        assert!(
            x.iter().all(|a| a.len() == len),
            "map: the arrays differ in length"
        );
        let outputs = self.outputs(len);
        self.operations
            .push(Box::new(map::Map::new(kernel, x, outputs)));
        outputs
    }

    /// `matrix * (x_0, x_1, ...) + bias`.
    ///
    /// # Panics
    /// Unless the matrix has as many columns as the arrays have numbers together and as many rows
    /// as the bias, or if one of them is of another program.
    pub fn dense(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer((matrix, bias), x, &vec![true; matrix.rows], false)
    }

    /// `tanh(matrix * (x_0, x_1, ...) + bias)`.
    ///
    /// # Panics
    /// As [`dense`](Program::dense).
    pub fn dense_tanh(&mut self, matrix: Matrix, x: &[Array], bias: Array) -> Array {
        self.dense_layer((matrix, bias), x, &vec![true; matrix.rows], true)
    }

    /// The entries of `tanh(matrix * (x_0, x_1, ...) + bias)` set out among zeros: in their order
    /// at the places that are true.
    ///
    /// # Panics
    /// As [`dense`](Program::dense), and unless as many places are true as the matrix has rows.
    pub fn dense_tanh_spread(
        &mut self,
        (matrix, bias): (Matrix, Array),
        x: &[Array],
        places: &[bool],
    ) -> Array {
        self.dense_layer((matrix, bias), x, places, true)
    }

    fn dense_layer(
        &mut self,
        (matrix, bias): (Matrix, Array),
        x: &[Array],
        places: &[bool],
        tanh: bool,
    ) -> Array {
        self.know(x);
        self.know(&[bias]);
        self.know_matrix(matrix);
        let columns: usize = x.iter().map(|a| a.len()).sum();
        assert_eq!(
            columns, matrix.columns,
            "dense: inputs and matrix columns differ"
        );
        assert_eq!(
            bias.len(),
            matrix.rows,
            "dense: bias and matrix rows differ"
        );
        let rows = places.iter().filter(|row| **row).count();
        assert_eq!(rows, matrix.rows, "dense: places and matrix rows differ");
        let [output] = self.outputs(places.len());
        // The last lane of one that is set out is written whole.
        self.align(false);
        let places = repeated(places, self.starts);
        let entries = |parameter: &Parameter| match parameter {
            Parameter::Array(_) | Parameter::Control(_) => 0,
            Parameter::Matrix(m) => m.len(),
        };
        let numbers = self.parameters.iter().map(entries).sum();
        let layer = dense::Dense::new((matrix, bias, numbers), x, (output, &places), tanh);
        self.operations.push(Box::new(layer));
        output
    }

    /// Maps a kernel over the edges of a graph and sums its results up at their nodes.
    ///
    /// The kernel's inputs are, per edge, the differences of `ends` (the value at the head less
    /// that at the tail, of arrays over the nodes) and then `per_edge` (arrays in the slot layout
    /// of the [`Graph`]). Each result counts plus at the edge's tail and minus at its head: the
    /// outputs are arrays over the nodes.
    ///
    /// # Panics
    /// Unless the arrays of `ends` are as long as the graph has nodes, those per edge as it has
    /// slots, and both together as many as the kernel's inputs; or if one is of another program.
    pub fn map_edges<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        (ends, per_edge): ([Array; C], &[Array]),
    ) -> [Array; O]
    where
        K: Adjoint<I, O>,
    {
        self.know(&ends);
        self.know(per_edge);
        let fits = ends.iter().all(|a| a.len() == graph.nodes());
        assert!(fits, "map_edges: an array of ends has one value per node");
        let fits = per_edge.iter().all(|a| a.len() == graph.slots());
        assert!(fits, "map_edges: an array per edge has one value per slot");
        let interleaved = graph.side_by_side(self.starts);
        self.margin = self.margin.max(interleaved.lead());
        // Lanes of edges reach past the nodes, but not into what the operation writes.
        let reach = interleaved.nodes() + WIDEST * self.starts;
        for end in ends.iter().filter(|a| !a.parameter) {
            self.ends[1] = self.ends[1].max(sum(end.start, reach));
        }
        let outputs = self.outputs(graph.nodes());
        let map = edges::EdgeMap::new(kernel, &interleaved, (ends, per_edge), outputs);
        self.operations.push(Box::new(map));
        outputs
    }

    /// `x[index]` for every index, and zero where there is none: with `&[Some(0); 8]` an array of
    /// one number becomes one of eight of it.
    ///
    /// # Panics
    /// If an index is out of range, or the array of another program.
    pub fn gather(&mut self, x: Array, indices: &[Option<usize>]) -> Array {
        self.know(&[x]);
        assert!(
            indices.iter().flatten().all(|&i| i < x.len()),
            "gather: an index is out of range"
        );
        let [output] = self.outputs(indices.len());
        self.operations
            .push(Box::new(gather::Gather::new(x, indices, output)));
        output
    }
}
