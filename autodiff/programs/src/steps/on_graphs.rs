//! The methods of [`Program`] that record operations on graphs.

use super::checks::Shape;
use super::mapped::{Edges, OfEdges, handles};
use super::operation::StepOperation;
use super::program::Program;
use crate::arrays::{Array, Equations, Graph, Kernel, NodeSum};

/// The operations on graphs. They panic like the others if an array belongs to another program.
impl Program {
    /// Maps a kernel over the edges of a graph and sums its results at the nodes, like springs that pull on masses.
    ///
    /// The first inputs of the kernel are differences. For each array of `ends`, which has one number per node, the
    /// input is the value at the edge's head minus the value at its tail. The other inputs are the edge's values in the
    /// arrays of `per_edge`, which have the slot layout of the [`Graph`]. Each result is added at the tail of the edge
    /// and subtracted at its head, so the outputs are arrays over the nodes. `uniforms` are those of [`map`](Program::map).
    ///
    /// ```
    /// use autodiff::{Real, Var, gradient};
    /// use autodiff_programs::{Graph, Kernel, Model, Program, Rollout, kernel};
    ///
    /// /// The heat that flows from the head to the tail of an edge in one step.
    /// #[derive(Clone, Copy)]
    /// struct Conduction;
    ///
    /// #[kernel]
    /// impl Kernel<2, 1> for Conduction {
    ///     fn eval<R: Real>(&self, [difference, conductivity]: [R; 2], _: &[R]) -> [R; 1] {
    ///         [conductivity * difference]
    ///     }
    /// }
    ///
    /// #[derive(Clone, Copy)]
    /// struct Sum;
    ///
    /// #[kernel]
    /// impl Kernel<2, 1> for Sum {
    ///     fn eval<R: Real>(&self, [a, b]: [R; 2], _: &[R]) -> [R; 1] {
    ///         [a + b]
    ///     }
    /// }
    ///
    /// /// The temperatures of three bodies in a row.
    /// #[derive(Clone)]
    /// struct Bar(Graph);
    ///
    /// impl Model for Bar {
    ///     fn record(&self, program: &mut Program) {
    ///         let conductivity = program.parameter(self.0.slots());
    ///         let t = program.state(self.0.nodes());
    ///         let [gain] = program.map_edges(&self.0, Conduction, [t], &[conductivity], &[]);
    ///         let [next] = program.map(Sum, [t, gain], &[]);
    ///         program.advance(t, next);
    ///     }
    /// }
    ///
    /// let graph = Graph::new(3, &[[0, 1], [1, 2]]);
    /// let bar = Rollout::new(Bar(graph.clone()), 1);
    /// let conductivity = graph.to_slots(&[0.5, 0.25]);
    /// assert_eq!(bar.run(&[0.0, 4.0, 8.0], &[&conductivity]), [2.0, 3.0, 7.0]);
    /// // The derivatives of the middle temperature with respect to the two conductivities.
    /// let middle = |k: &[Var<f64>]| {
    ///     let t = [0.0, 4.0, 8.0].map(Var::constant);
    ///     bar.run(&t, &[&graph.to_slots(k)])[1]
    /// };
    /// assert_eq!(gradient(middle, &[0.5, 0.25]), [-4.0, 4.0]);
    /// ```
    ///
    /// # Panics
    /// - If an array of `ends` does not have one number for each node.
    /// - If an array of `per_edge` does not have one number for each slot.
    /// - If the kernel has no results, or does not have one input for each array of `ends` and `per_edge`.
    /// - If `uniforms` does not have one array for each uniform input of the kernel, or one of these arrays does not have
    ///   exactly one number.
    /// - If an array belongs to another program.
    #[track_caller]
    pub fn map_edges<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        self.map_over_edges::<K, C, I, O, true>(graph, kernel, ends, per_edge, uniforms)
    }

    /// Like [`map_edges`](Program::map_edges), but results stay at their edges: the outputs are arrays over the
    /// slots, with zeros for ghosts.
    ///
    /// # Panics
    /// Like [`map_edges`](Program::map_edges).
    #[track_caller]
    pub fn map_each_edge<K, const C: usize, const I: usize, const O: usize>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        self.map_over_edges::<K, C, I, O, false>(graph, kernel, ends, per_edge, uniforms)
    }

    /// Implements [`map_edges`](Program::map_edges), which sums results at the nodes (`SUMS`), and
    /// [`map_each_edge`](Program::map_each_edge), which does not.
    #[track_caller]
    fn map_over_edges<K, const C: usize, const I: usize, const O: usize, const SUMS: bool>(
        &mut self,
        graph: &Graph,
        kernel: K,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
    ) -> [Array; O]
    where
        K: Kernel<I, O>,
    {
        let shape = Shape::of::<K, I, O>();
        (self.known()).check_edges(graph, [&ends, per_edge], uniforms, shape);
        let len = if SUMS { graph.nodes() } else { graph.slots() };
        let outputs = self.outputs(len, O);
        let edges = Edges {
            graph: graph.clone(),
            starts: self.starts,
            differences: C,
            sums: SUMS,
        };
        self.margin = self.margin.max(self.starts * graph.lead());
        let kernel = OfEdges::<K, C, I, O, SUMS>(kernel);
        let inputs = [&ends[..], per_edge].concat();
        self.push_kernel(kernel, [&inputs, uniforms], outputs, Some(edges))
    }

    /// Solves linear equations `A x = b` with `N` unknowns per node of a graph, and returns `x`: an array over the nodes for
    /// each unknown of a node. `A` must be symmetric and positive definite. It is a sum of blocks of `N` rows:
    /// - `nodes`: every node has a block, which acts on its unknowns;
    /// - `edges`: every edge has a block `S`, which acts on the difference of the unknowns of its ends. It adds `S` to the
    ///   blocks of both ends, and `-S` to the two blocks between them.
    ///
    /// Blocks are symmetric. Each has an array for each entry of its lower triangle, row by row: `[0, 0]`, `[1, 0]`,
    /// `[1, 1]`, `[2, 0]` and so on. Arrays of nodes have one number for each node, arrays of edges one for each
    /// [slot](Graph::slots). `b` has an array over the nodes for each unknown of a node.
    ///
    /// `held` may be empty. Otherwise some directions are held: the solution is 0 in these directions, and the equations hold
    /// in all others. So a wall keeps a node from moving through it, or a cell has a fixed temperature. `held` has a symmetric
    /// block for each node, as `nodes` does: the projection onto its held directions, which is `n n'` for one unit vector
    /// `n`. A block of zeros holds nothing. `held` has no derivative.
    ///
    /// The matrix is factorised as `L D L'` within a band. The nodes are ordered once, when the step is recorded, so that
    /// connected nodes are close. The reverse sweep solves once more with the same factor. If `A` is not positive definite,
    /// the solution can be inaccurate or NaN.
    ///
    /// Heat flows along a rod of four cells in implicit steps, which are stable however long they are. The heat that flows
    /// in a step depends on the temperatures after it:
    ///
    /// ```
    /// use autodiff::Real;
    /// use autodiff_programs::{Graph, Kernel, Model, Program, Rollout, kernel};
    ///
    /// #[derive(Clone)]
    /// struct Rod;
    ///
    /// impl Model for Rod {
    ///     fn record(&self, p: &mut Program) {
    ///         let graph = Graph::new(4, &[[0, 1], [1, 2], [2, 3]]);
    ///         // How much heat each cell holds per kelvin, and how much flows along an edge per kelvin and step.
    ///         let (capacity, conductance) = (p.parameter(4), p.parameter(graph.slots()));
    ///         let temperature = p.state(4);
    ///         let [heat] = p.map(Product, [capacity, temperature], &[]);
    ///         let [next] = p.solve(&graph, &[capacity], &[conductance], &[], [heat]);
    ///         p.advance(temperature, next);
    ///     }
    /// }
    ///
    /// #[derive(Clone)]
    /// struct Product;
    ///
    /// #[kernel]
    /// impl Kernel<2, 1> for Product {
    ///     fn eval<R: Real>(&self, [a, b]: [R; 2], _: &[R]) -> [R; 1] {
    ///         [a * b]
    ///     }
    /// }
    ///
    /// let graph = Graph::new(4, &[[0, 1], [1, 2], [2, 3]]);
    /// let conductance = graph.to_slots(&[50.0; 3]);
    /// let temperature = Rollout::new(Rod, 20).run(&[100.0, 0.0, 0.0, 0.0], &[&[1.0; 4], &conductance]);
    /// // All heat is still there, and is spread evenly.
    /// assert!(temperature.iter().all(|t: &f64| (t - 25.0).abs() < 1e-9));
    /// ```
    ///
    /// # Panics
    /// If an array has another length than is said above, if their numbers do not fit `N`, if the graph has no nodes, if
    /// directions are held and a node has more than four unknowns, or if an array belongs to another program.
    #[track_caller]
    pub fn solve<const N: usize>(
        &mut self,
        graph: &Graph,
        nodes: &[Array],
        edges: &[Array],
        held: &[Array],
        b: [Array; N],
    ) -> [Array; N] {
        self.known().check_solve(graph, [nodes, edges, &b, held]);
        let x = self.outputs(graph.nodes(), N);
        let solution = handles(&x);
        let equations = Equations {
            graph: graph.clone(),
            nodes: nodes.to_vec(),
            edges: edges.to_vec(),
            held: held.to_vec(),
            b: b.to_vec(),
            x,
        };
        self.operations.push(StepOperation::Solve(equations));
        solution
    }

    /// Sums numbers of edges at their ends: returns an array over the nodes, with the sum of `x` over all edges that begin
    /// or end at the node. `x` has one number for each [slot](Graph::slots).
    ///
    /// # Panics
    /// If `x` does not have one number for each slot, or belongs to another program.
    #[track_caller]
    pub fn sum_at_nodes(&mut self, graph: &Graph, x: Array) -> Array {
        self.known().check_node_sum(graph, x);
        let output = self.output(graph.nodes());
        let sum = NodeSum::new(graph, x, output);
        self.operations.push(StepOperation::NodeSum(sum));
        output
    }
}
