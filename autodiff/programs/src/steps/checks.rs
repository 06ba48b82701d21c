//! Checks of the arrays that a model passes to a [`Program`](super::Program).

use crate::arrays::{Array, Graph, Kernel, MOST_UNKNOWNS, assert_uniforms, triangle};

/// The arrays of a program.
#[derive(Clone, Copy)]
pub(super) struct Known<'a>(pub(super) &'a [Array]);

/// How many inputs, uniform inputs and results a kernel has.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub(super) inputs: usize,
    pub(super) uniforms: usize,
    pub(super) results: usize,
}

impl Shape {
    pub(super) fn of<K: Kernel<I, O>, const I: usize, const O: usize>() -> Self {
        Self {
            inputs: I,
            uniforms: K::UNIFORMS,
            results: O,
        }
    }
}

impl Known<'_> {
    /// # Panics
    /// If an array belongs to another program. This check is needed because steps read the inputs of operations without
    /// bounds checks.
    #[track_caller]
    pub(super) fn check(self, arrays: &[Array]) {
        let known = |array: &Array| self.0.get(array.id) == Some(array);
        assert!(
            arrays.iter().all(known),
            "an array belongs to another program; use only arrays that this program returned"
        );
    }

    #[track_caller]
    fn check_uniforms(self, arrays: &[Array], kernel: Shape) {
        self.check(arrays);
        let is_one = arrays.iter().all(|array| array.len() == 1);
        assert!(is_one, "each uniform input must be an array of one number");
        assert_uniforms(arrays.len());
        assert_eq!(
            arrays.len(),
            kernel.uniforms,
            "the number of uniform arrays must be the kernel's `UNIFORMS`"
        );
    }

    /// Returns the length of the inputs of a map.
    #[track_caller]
    pub(super) fn check_map(self, x: &[Array], uniforms: &[Array], kernel: Shape) -> usize {
        self.check_uniforms(uniforms, kernel);
        self.check(x);
        let first = x.first();
        let len = first
            .expect("map: the kernel must have at least one input")
            .len();
        assert!(
            kernel.results > 0,
            "map: the kernel must have at least one result"
        );
        assert!(
            x.iter().all(|a| a.len() == len),
            "map: all input arrays must have the same length"
        );
        len
    }

    #[track_caller]
    pub(super) fn check_edges(
        self,
        graph: &Graph,
        [ends, per_edge]: [&[Array]; 2],
        uniforms: &[Array],
        kernel: Shape,
    ) {
        self.check_uniforms(uniforms, kernel);
        self.check(ends);
        self.check(per_edge);
        assert!(
            kernel.results > 0,
            "map_edges: the kernel must have at least one result"
        );
        assert_eq!(
            ends.len() + per_edge.len(),
            kernel.inputs,
            "map_edges: the kernel must have one input for each array in `ends` and in `per_edge`"
        );
        let fits = ends.iter().all(|a| a.len() == graph.nodes());
        assert!(
            fits,
            "map_edges: each array of `ends` must have one number for each node"
        );
        let fits = per_edge.iter().all(|a| a.len() == graph.slots());
        assert!(
            fits,
            "map_edges: each array of `per_edge` must have one number for each slot"
        );
    }

    #[track_caller]
    pub(super) fn check_gather(self, x: Array, indices: &[Option<usize>]) {
        self.check(&[x]);
        assert!(
            indices.iter().flatten().all(|&i| i < x.len()),
            "gather: each index must be less than the length of `x`"
        );
    }

    #[track_caller]
    pub(super) fn check_node_sum(self, graph: &Graph, x: Array) {
        self.check(&[x]);
        assert_eq!(
            x.len(),
            graph.slots(),
            "sum_at_nodes: `x` must have one number for each slot"
        );
    }

    #[track_caller]
    pub(super) fn check_solve(self, graph: &Graph, [nodes, edges, b, held]: [&[Array]; 4]) {
        self.check(&[nodes, edges, b, held].concat());
        let entries = triangle(b.len()).len();
        assert!(
            nodes.len() == entries && edges.len() == entries && [0, entries].contains(&held.len()),
            "solve: blocks for {} unknowns per node have {entries} entries in their lower triangle",
            b.len()
        );
        let fits = |arrays: &[Array], len: usize| arrays.iter().all(|array| array.len() == len);
        assert!(
            [nodes, b, held]
                .iter()
                .all(|arrays| fits(arrays, graph.nodes())),
            "solve: each array of `nodes`, `b` and `held` must have one number for each node"
        );
        assert!(
            fits(edges, graph.slots()),
            "solve: each array of `edges` must have one number for each slot"
        );
        assert!(b.len() * graph.nodes() > 0, "solve: there must be unknowns");
        assert!(
            held.is_empty() || b.len() <= MOST_UNKNOWNS,
            "solve: nodes with held directions can have at most {MOST_UNKNOWNS} unknowns"
        );
    }
}
