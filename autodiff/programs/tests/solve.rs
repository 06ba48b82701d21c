//! Linear equations on a graph, solved in every step, must agree with Gaussian elimination in plain code.

use crate::steps::{Step, Turn, assert_as_alone, assert_same};
use autodiff::{DoubleDouble, Real, Var};
use autodiff_programs::{Given, Graph, Kernel, Model, Program, Rollout, kernel};

/// A model with `N` unknowns per node. In every step, the solution of the equations becomes the new state.
#[derive(Clone)]
struct Solving<const N: usize> {
    nodes: usize,
    edges: Vec<[usize; 2]>,
    /// Nodes, and unit vectors along which the solution is 0. The vectors of a node are perpendicular.
    held: Vec<(usize, [f64; N])>,
}

/// How many numbers the lower triangle of a block has.
const fn entries(n: usize) -> usize {
    n * (n + 1) / 2
}

impl<const N: usize> Solving<N> {
    fn graph(&self) -> Graph {
        Graph::new(self.nodes, &self.edges)
    }

    /// The projections of the nodes onto their held directions: an array for each entry of the lower triangle. There are
    /// none if nothing is held.
    fn projections(&self) -> Vec<Vec<f64>> {
        if self.held.is_empty() {
            return Vec::new();
        }
        let mut projections = vec![vec![0.0; self.nodes]; entries(N)];
        for &(node, vector) in &self.held {
            for (row, column) in (0..N).flat_map(|row| (0..=row).map(move |column| (row, column))) {
                projections[entries(row) + column][node] += vector[row] * vector[column];
            }
        }
        projections
    }

    /// The lower triangles of symmetric blocks, which are positive definite if `least` is above 0: an array for each entry,
    /// with a number for each of `count` blocks. The blocks are `least I + T T'` for triangles `T`, whose numbers are in
    /// `given`.
    fn blocks<R: Real>(given: &[R], count: usize, least: f64) -> Vec<Vec<R>> {
        let entry =
            |row: usize, column: usize, k: usize| given[(entries(row) + column) * count + k];
        let mut blocks = Vec::new();
        for (row, column) in (0..N).flat_map(|row| (0..=row).map(move |column| (row, column))) {
            let of_block = (0..count).map(|k| {
                let terms = (0..=column).map(|c| entry(row, c, k) * entry(column, c, k));
                let on_diagonal = R::lit(if row == column { least } else { 0.0 });
                terms.fold(on_diagonal, |sum, term| sum + term)
            });
            blocks.push(of_block.collect());
        }
        blocks
    }
}

impl<const N: usize> Model for Solving<N> {
    fn record(&self, p: &mut Program) {
        let graph = self.graph();
        let nodes: Vec<_> = (0..entries(N)).map(|_| p.parameter(self.nodes)).collect();
        let edges: Vec<_> = (0..entries(N))
            .map(|_| p.parameter(graph.slots()))
            .collect();
        let x = [(); N].map(|()| p.state(self.nodes));
        let held: Vec<_> = (0..self.projections().len())
            .map(|_| p.parameter(self.nodes))
            .collect();
        let next = p.solve(&graph, &nodes, &edges, &held, x);
        for (x, next) in x.into_iter().zip(next) {
            let [next] = p.map(Turn, [next, x], &[]);
            p.advance(x, next);
        }
    }
}

impl<const N: usize> Step for Solving<N> {
    fn shapes(&self) -> Vec<usize> {
        let slots = self.graph().slots();
        vec![N * self.nodes, entries(N) * self.nodes, entries(N) * slots]
    }
    fn parameters<R: Real>(&self, given: &[&[R]]) -> Vec<Vec<R>> {
        let nodes = Self::blocks(given[0], self.nodes, 1.0);
        let edges = Self::blocks(given[1], self.graph().slots(), 0.0);
        let held = self.projections().into_iter();
        let held = held.map(|entry| entry.into_iter().map(R::lit).collect());
        [nodes, edges, held.collect()].concat()
    }
    fn written_out<R: Real>(&self, _: usize, state: &[R], given: &[&[R]]) -> Vec<R> {
        let (n, slots) = (N * self.nodes, self.graph().slot_of_edge().to_vec());
        let parameters = self.parameters(given);
        let (nodes, edges) = parameters.split_at(entries(N));
        // Each held direction has a multiplier: the force that holds it.
        let all = n + self.held.len();
        let mut a = vec![vec![R::zero(); all]; all];
        let of = |row: usize, column: usize| entries(row.max(column)) + row.min(column);
        for (row, column) in (0..N).flat_map(|row| (0..N).map(move |column| (row, column))) {
            let at = |node: usize, unknown: usize| unknown * self.nodes + node;
            for node in 0..self.nodes {
                a[at(node, row)][at(node, column)] += nodes[of(row, column)][node];
            }
            for (&[i, j], &slot) in self.edges.iter().zip(&slots) {
                let s = edges[of(row, column)][slot];
                for (from, to, s) in [(i, i, s), (j, j, s), (i, j, -s), (j, i, -s)] {
                    a[at(from, row)][at(to, column)] += s;
                }
            }
        }
        for (k, (node, vector)) in self.held.iter().enumerate() {
            for (unknown, &component) in vector.iter().enumerate() {
                let at = unknown * self.nodes + node;
                a[at][n + k] = R::lit(component);
                a[n + k][at] = R::lit(component);
            }
        }
        let mut b = state.to_vec();
        b.resize(all, R::zero());
        let x = eliminated(a, b);
        let pairs = x.iter().zip(state);
        pairs
            .map(|(&x, &old)| Kernel::eval(&Turn, [x, old], &[])[0])
            .collect()
    }
}

/// Solves `A x = b` by Gaussian elimination.
fn eliminated<R: Real>(mut a: Vec<Vec<R>>, mut b: Vec<R>) -> Vec<R> {
    for k in 0..b.len() {
        for i in k + 1..b.len() {
            let factor = a[i][k] / a[k][k];
            for j in k..b.len() {
                let term = factor * a[k][j];
                a[i][j] -= term;
            }
            let term = factor * b[k];
            b[i] -= term;
        }
    }
    for k in (0..b.len()).rev() {
        let known = (k + 1..b.len()).fold(R::zero(), |sum, j| sum + a[k][j] * b[j]);
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

/// A ladder of nodes with diagonals, and one node without edges.
fn ladder<const N: usize>(rungs: usize) -> Solving<N> {
    let mut edges = Vec::new();
    for k in 0..rungs {
        edges.push([2 * k, 2 * k + 1]);
        if k + 1 < rungs {
            edges.extend([
                [2 * k, 2 * k + 2],
                [2 * k + 1, 2 * k + 3],
                [2 * k, 2 * k + 3],
            ]);
        }
    }
    Solving {
        nodes: 2 * rungs + 1,
        edges,
        held: Vec::new(),
    }
}

#[test]
fn the_solution_is_that_of_gaussian_elimination() {
    assert_same(ladder::<1>(3));
    assert_same(ladder::<2>(2));
    if !cfg!(miri) {
        assert_same(ladder::<1>(9));
        assert_same(ladder::<3>(2));
        // A star: the order in which nodes are given is already the best.
        let edges = (1..6).map(|node| [0, node]).collect();
        assert_same(Solving::<2> {
            nodes: 6,
            edges,
            held: Vec::new(),
        });
    }
}

/// Bars between nodes of mass 1. In every step, the solution of the equations becomes the new state.
#[derive(Clone)]
struct Bars(Graph);

impl Model for Bars {
    fn record(&self, p: &mut Program) {
        let nodes = [(); 3].map(|()| p.parameter(self.0.nodes()));
        let edges = [(); 3].map(|()| p.parameter(self.0.slots()));
        let x = [(); 2].map(|()| p.state(self.0.nodes()));
        let next = p.solve(&self.0, &nodes, &edges, &[], x);
        x.into_iter()
            .zip(next)
            .for_each(|(x, next)| p.advance(x, next));
    }
}

/// The residual `|b - A x| / (|A| |x|)` of nodes on a grid, in largest norms. Bars connect all neighbours, or only those in
/// a row if the grid has one row.
fn residual<R: Real + Into<f64>>([columns, rows]: [usize; 2], stiffness: f64) -> f64 {
    let (nodes, mut edges, mut bars) = (columns * rows, Vec::new(), Vec::new());
    for (column, row) in (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row))) {
        for (right, up) in [(1, 0), (0, 1), (1, 1), (-1, 1)] {
            let (to, above) = (column as isize + right, row + up);
            if (0..columns as isize).contains(&to) && above < rows {
                edges.push([row * columns + column, above * columns + to as usize]);
                // The grid is a little irregular.
                let (sin, cos) =
                    ((up as f64).atan2(right as f64) + (edges.len() as f64).sin() / 9.0).sin_cos();
                bars.push([cos * cos, cos * sin, sin * sin].map(|k| R::lit(k * stiffness)));
            }
        }
    }
    let graph = Graph::new(nodes, &edges);
    let of_edges = [0, 1, 2].map(|k| bars.iter().map(|bar| bar[k]).collect::<Vec<R>>());
    let of_edges = of_edges.map(|entry| graph.to_slots(&entry));
    let mass = [1.0, 0.0, 1.0].map(|m| vec![R::lit(m); nodes]);
    let b: Vec<R> = (0..2 * nodes)
        .map(|k| R::lit((k as f64 + 0.5).sin()))
        .collect();
    let parameters: Vec<&[R]> = mass
        .iter()
        .chain(&of_edges)
        .map(|entry| &entry[..])
        .collect();
    let x = Rollout::new(Bars(graph.clone()), 1).run(&b, &parameters);

    let exact = |number: R| DoubleDouble::from(number.into());
    let mut rest: Vec<_> = (b.iter().zip(&x))
        .map(|(&b, &x)| exact(b) - exact(x))
        .collect();
    let mut norms = vec![1.0; 2 * nodes];
    for (&[i, j], bar) in edges.iter().zip(&bars) {
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let stretch = exact(x[column * nodes + j]) - exact(x[column * nodes + i]);
            let force = exact(bar[row + column]) * stretch;
            rest[row * nodes + i] += force;
            rest[row * nodes + j] -= force;
            for node in [i, j] {
                norms[row * nodes + node] += 2.0 * bar[row + column].into().abs();
            }
        }
    }
    let largest = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, f64::max);
    let rest = largest(&mut rest.iter().map(|&rest| f64::from(rest).abs()));
    let x = largest(&mut x.iter().map(|&x| x.into().abs()));
    rest / (largest(&mut norms.into_iter()) * x)
}

/// Edges are much stiffer than nodes are heavy, so the equations are badly conditioned: in x, most digits may be wrong. But
/// elimination without pivots is backward stable for a positive definite matrix, so the residual must be that of a
/// solution with a few rounding errors in each number of the matrix. It is at most 1 unit here; 4 units leave room
/// for another order of operations. In single precision, stiffer edges would make the matrix singular by rounding.
#[test]
fn the_residual_is_small_for_stiff_edges() {
    // 70, 82 and 18 unknowns do not fill whole blocks.
    let shapes = [[3, 3], [6, 6], [5, 7], [41, 1]];
    for &shape in &shapes[..if cfg!(miri) { 1 } else { shapes.len() }] {
        let double = residual::<f64>(shape, 1e9) / f64::EPSILON;
        let single = residual::<f32>(shape, 1e4) / f64::from(f32::EPSILON);
        assert!(
            double < 4.0 && single < 4.0,
            "{shape:?}: {double} units in double precision, {single} in single precision"
        );
    }
}

/// Node 1 is held along one direction, node 2 along two; nodes 1 and 2 share an edge.
fn held_ladder(rungs: usize) -> Solving<2> {
    let (sin, cos) = 0.4_f64.sin_cos();
    Solving {
        held: vec![
            (1, [cos, sin]),
            (2, [-sin, cos]),
            (2, [cos, sin]),
            (3, [0.0, 1.0]),
        ],
        ..ladder(rungs)
    }
}

#[test]
fn held_directions_are_those_of_lagrange_multipliers() {
    assert_same(held_ladder(2));
    if !cfg!(miri) {
        assert_same(held_ladder(5));
        assert_same(Solving::<1> {
            held: vec![(3, [1.0])],
            ..ladder(3)
        });
    }
}

/// Starts that have their own matrices must give the values and gradients of single rollouts, bit by bit.
#[test]
fn starts_with_their_own_matrices_run_together() {
    assert_starts_run_together(&ladder::<2>(if cfg!(miri) { 2 } else { 5 }));
    assert_starts_run_together(&held_ladder(2));
}

fn assert_starts_run_together(model: &Solving<2>) {
    let shapes = model.shapes();
    let runs: Vec<Vec<f64>> = (0..11)
        .map(|k| {
            let numbers = 0..shapes.iter().sum();
            numbers
                .map(|i| ((0.7 + k as f64) * i as f64 + 0.3).sin())
                .collect()
        })
        .collect();
    let rollout = Rollout::new(model.clone(), 3);
    assert_as_alone(&runs, |runs| {
        let starts: Vec<_> = runs.iter().map(|x| &x[..shapes[0]]).collect();
        let given = runs.iter().map(|x| {
            let (nodes, edges) = x[shapes[0]..].split_at(shapes[1]);
            model.parameters(&[nodes, edges])
        });
        let given: Vec<Vec<Vec<_>>> = given.collect();
        let of = |k: usize| given.iter().map(|given| &given[k][..]).collect::<Vec<_>>();
        let parameters: Vec<Vec<&[_]>> = (0..given[0].len()).map(of).collect();
        let parameters: Vec<_> = parameters.iter().map(|of| Given::Each(of)).collect();
        rollout.run_batch(&starts, &parameters)
    });
}

/// Results that stay at their edges, and are then summed at the nodes, are what [`Program::map_edges`] computes.
#[test]
fn results_stay_at_their_edges() {
    /// The impulse of a spring, with its stiffness as a uniform input.
    struct Spring;
    #[kernel]
    impl Kernel<3, 2> for Spring {
        const UNIFORMS: usize = 1;
        fn eval<R: Real>(&self, [d, e, rest]: [R; 3], k: &[R]) -> [R; 2] {
            [k[0] * (d - rest).sin(), d * e + rest]
        }
    }
    #[derive(Clone)]
    struct Springs(Solving<1>);
    impl Model for Springs {
        fn record(&self, p: &mut Program) {
            let graph = self.0.graph();
            let (rest, k) = (p.parameter(graph.slots()), p.parameter(1));
            let [x, y] = [(); 2].map(|()| p.state(self.0.nodes));
            let at_edges = p.map_each_edge(&graph, Spring, [x, y], &[rest], &[k]);
            let [dx, dy] = at_edges.map(|of_edge| p.sum_at_nodes(&graph, of_edge));
            for (state, sum) in [(x, dx), (y, dy)] {
                let [next] = p.map(Turn, [sum, state], &[]);
                p.advance(state, next);
            }
        }
    }
    impl Step for Springs {
        fn shapes(&self) -> Vec<usize> {
            vec![2 * self.0.nodes, self.0.graph().slots(), 1]
        }
        fn written_out<R: Real>(&self, _: usize, state: &[R], given: &[&[R]]) -> Vec<R> {
            let (x, y) = state.split_at(self.0.nodes);
            let mut sums = vec![R::zero(); state.len()];
            for (&[i, j], &slot) in self.0.edges.iter().zip(self.0.graph().slot_of_edge()) {
                let edge = [x[j] - x[i], y[j] - y[i], given[0][slot]];
                let [a, b] = Spring.eval(edge, given[1]);
                for node in [i, j] {
                    sums[node] += a;
                    sums[self.0.nodes + node] += b;
                }
            }
            let pairs = sums.into_iter().zip(state);
            let turned = pairs.map(|(sum, &state)| Kernel::eval(&Turn, [sum, state], &[])[0]);
            turned.collect()
        }
    }
    assert_same(Springs(ladder(3)));
    assert_same(Springs(ladder(4)));
}

/// An edge that was removed from a graph has no effect and no cotangent.
#[test]
fn a_removed_edge_does_not_act() {
    #[derive(Clone)]
    struct Removed(Graph);
    impl Model for Removed {
        fn record(&self, p: &mut Program) {
            let (node, edge) = (p.parameter(3), p.parameter(self.0.slots()));
            let x = p.state(3);
            let [next] = p.solve(&self.0, &[node], &[edge], &[], [x]);
            p.advance(x, next);
        }
    }
    let (all, less) = (Graph::new(3, &[[0, 1], [1, 2]]), Graph::new(3, &[[0, 1]]));
    let removed = all.without(&[false, true]);
    let gradient = |graph: &Graph, edges: usize| {
        let x = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.5, 0.7];
        autodiff::value_and_gradient(
            |x: &[Var<f64>]| {
                let edges = graph.to_slots(&x[6..6 + edges]);
                let rollout = Rollout::new(Removed(graph.clone()), 2);
                Var::sum_of(&rollout.run(&x[..3], &[&x[3..6], &edges]))
            },
            &x,
        )
    };
    let (value, slopes) = gradient(&removed, 2);
    assert_eq!((value, slopes.clone()), gradient(&less, 1));
    assert!(slopes[6] != 0.0 && slopes[7] == 0.0);
    assert_ne!(value, gradient(&all, 2).0);
}
