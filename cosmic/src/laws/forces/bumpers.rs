//! Nodes that do not pass through bars: a node that comes too near to a bar and the bar push each other apart.
//!
//! In the plane, two bars can only begin to cross when an end of one of them passes through the other. So bars do not pass
//! through one another if nodes do not pass through bars. In space, bars can still cross between their ends. The law acts on
//! pairs of a node and a bar that does not end at the node. A step is recorded once, so its pairs are fixed: they are all pairs that
//! are near enough at rest to meet later.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Compiled, Graph, Kernel, Program, Pullback};

use super::force::{Force, ForceParameters, LatticeForce, Pose, Pull, Step};
use super::stiffness::Stiffness;
use crate::geometry::{Axes, Matrix, Segment, Vector};
use crate::lattice::Lattice;
use crate::laws::law::{Law, StepInput, step_inputs};
use crate::settings::{above, within};
use crate::{Fields, in_both_dimensions, in_dimension, kernel};

/// A node that is nearer to a bar at rest than this share of the shortest bar lies on the bar, so they are not a pair.
const ON_BAR: f64 = 1e-3;
/// The share of the distance at rest below which a pair never pushes, so that no robot is under stress at rest.
const AT_REST: f64 = 0.5;
/// A product of stiffnesses, (N/m)^2, that keeps the stiffness of a contact finite if bar and node have stiffness 0.
const LEAST: f64 = 1e-24;
/// The number of arrays of impulses that the kernel [`Total`] adds to a sum.
const AT_ONCE: usize = 4;

crate::settings! {
    /// Nodes and bars that come too near push each other apart. In the plane, bars then do not pass through one another.
    struct Bumpers<R> {
        /// Stiffness of a contact. Bar and node give way too: their stiffnesses act in series with it.
        stiffness: R = 2000.0, allowed above(0.0, 1e10), unit "N/m", auto "5 times the stiffness of skeleton",
            source "beyond the paper";
        /// Distance below which a node and a bar push each other apart, divided by the length of the shortest bar. It is at
        /// most half of their distance at rest.
        distance: R = 0.15, allowed above(0.0, 1.0), source "beyond the paper";
        /// Largest distance at rest of a node and a bar that the law keeps apart, divided by the length of the shortest bar.
        reach: usize = 3, allowed within(1.0, 100.0), source "beyond the paper";
    }
}

impl Law for Bumpers {
    const NAME: &'static str = "bumpers";
}

impl LatticeForce for Bumpers {
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        let bumpers = BumperForce::new(self, lattice);
        (!bumpers.pairs.is_empty()).then(|| -> Arc<dyn Force> { Arc::new(bumpers) })
    }
}

/// The kernel of a contact between a node and a bar. The uniform inputs are the stiffness and the distance of [`Bumpers`].
#[derive(Clone, Copy, Debug)]
pub struct Bump<const D: usize = 2> {
    /// The length of the shortest bar, m.
    pub shortest: f64,
    /// The [softening](Lattice::softening) of lengths, m^2.
    pub softening: f64,
    /// The time for which node and bar push each other, s.
    pub dt: f64,
}

/// A node and a bar that may touch it.
#[derive(Clone, Copy, Debug, Fields)]
struct PairPose<T, const D: usize = 3> {
    /// The position of the node, m.
    node: Vector<T, D>,
    /// The positions of the ends of the bar, m.
    from: Vector<T, D>,
    to: Vector<T, D>,
    /// The stiffness of the bar, N/m.
    of_bar: T,
    /// The sum of the stiffnesses of the bars at the node, N/m.
    of_node: T,
    /// The largest distance at which the pair pushes, m.
    most: T,
}

/// A pair, and the factors of the impulses on the ends of its bar.
#[derive(Clone, Copy, Fields)]
struct SignedPair<T, const D: usize> {
    pair: PairPose<T, D>,
    of_from: T,
    of_to: T,
}

/// The impulses on the ends of a bar, N s. The node gets the opposite impulses.
#[derive(Clone, Copy, Fields)]
struct EndImpulses<T, const D: usize> {
    from: Vector<T, D>,
    to: Vector<T, D>,
}

/// What pushes a node away from a bar.
struct Overlap<R, const D: usize> {
    /// The unit vector from the nearest point of the bar to the node.
    away: Vector<R, D>,
    /// The place of that point along the bar, from 0 to 1.
    share: R,
    /// By how much the distance is too small, m; 0 if it is not.
    depth: R,
    /// The stiffness of the contact, N/m.
    stiffness: R,
}

impl<const D: usize> Bump<D> {
    /// The contact of a pair. At the distance where the push begins, and where the nearest point of the bar reaches one of
    /// its ends, derivatives are those of no contact and of the inner side (the conventions of `max` and `clamp`).
    #[inline(always)]
    fn touch<R: Real>(&self, law: [R; 2], near: &PairPose<R, D>) -> Overlap<R, D> {
        let ([stiffness, distance], softening) = (law, R::lit(self.softening));
        let bar = near.to - near.from;
        let to_node = near.node - near.from;
        let share = to_node.dot(bar) / (bar.dot(bar) + softening);
        let share = share.clamp(R::zero(), R::one());
        let apart = to_node - bar * share;
        let gap = apart.softened_norm(self.softening);
        let clearance = (distance * R::lit(self.shortest)).min(near.most);
        let (bar, node) = (near.of_bar, near.of_node);
        let all = stiffness * (bar + node) + bar * node + R::lit(LEAST);
        Overlap {
            away: apart / gap,
            share,
            depth: (clearance - gap).max(R::zero()),
            stiffness: stiffness * bar * node / all,
        }
    }

    /// The impulses on the two ends of the bar.
    #[inline(always)]
    fn impulses<R: Real>(&self, law: [R; 2], near: &PairPose<R, D>) -> EndImpulses<R, D> {
        let touch = self.touch(law, near);
        let push = -touch.away * (touch.stiffness * touch.depth * R::lit(self.dt));
        let last = push * touch.share;
        EndImpulses {
            from: push - last,
            to: last,
        }
    }

    /// The results of the kernel.
    #[inline(always)]
    fn scaled<R: Real>(&self, signed: SignedPair<R, D>, law: &[R]) -> EndImpulses<R, D> {
        let EndImpulses { from, to } = self.impulses([law[0], law[1]], &signed.pair);
        EndImpulses {
            from: from * signed.of_from,
            to: to * signed.of_to,
        }
    }
}

#[kernel]
impl Kernel<_, _> for Bump {
    const COMPILED: Compiled = Compiled::Seldom;
    const UNIFORMS: usize = 2;

    fn eval<R: Real>(&self, pair: SignedPair<R, 2>, law: &[R]) -> EndImpulses<R, 2> {
        self.scaled(pair, law)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
        self.emitted_vjp(at)
    }
}

#[kernel]
impl Kernel<_, _> for Bump<3> {
    const COMPILED: Compiled = Compiled::Seldom;
    const UNIFORMS: usize = 2;

    fn eval<R: Real>(&self, pair: SignedPair<R, 3>, law: &[R]) -> EndImpulses<R, 3> {
        self.scaled(pair, law)
    }
}

/// The kernel that passes on an impulse along an edge of a graph.
#[derive(Clone, Copy, Debug)]
struct Identity<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<D, D> for Identity<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, impulse: [R; D], _: &[R]) -> [R; D] {
            impulse
        }
    }
}

/// A kernel that adds five numbers.
#[derive(Clone, Copy, Debug)]
pub struct Total;

#[kernel]
impl Kernel<5, 1> for Total {
    const COMPILED: Compiled = Compiled::Seldom;

    fn eval<R: Real>(&self, [a, b, c, d, e]: [R; 5], _: &[R]) -> [R; 1] {
        [a + b + (c + d) + e]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 5, 1, M>) -> [[R; 5]; M] {
        self.emitted_vjp(at)
    }
}

/// Adds numbers to `sum`: for each list of `places`, its places in `x` say which number is added to each entry.
fn add_gathered(p: &mut Program, sum: Array, x: Array, places: &[Vec<Option<usize>>]) -> Array {
    let none = vec![None; sum.len()];
    places.chunks(AT_ONCE).fold(sum, |sum, chunk| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| p.gather(x, chunk.get(k).unwrap_or(&none)));
        let [sum] = p.map(Total, [sum, a, b, c, d], &[]);
        sum
    })
}

/// A node and an edge that does not end at the node.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    node: usize,
    edge: usize,
    /// The ends of the edge.
    ends: [usize; 2],
    /// The largest distance at which the pair pushes, m.
    most: f64,
}

/// The nodes and bars of a lattice that [`Bumpers`] keep apart.
#[derive(Clone, Debug)]
struct BumperForce {
    law: Bumpers,
    /// The length of the shortest bar, m.
    shortest: f64,
    /// The softening of lengths, m^2.
    softening: f64,
    pairs: Vec<Pair>,
}

impl BumperForce {
    fn new(law: &Bumpers, lattice: &Lattice) -> Self {
        let lengths = lattice.rest_length.iter().copied();
        let shortest = lengths.fold(f64::MAX, f64::min);
        let pair = |node: usize, edge: usize| {
            let ends = lattice.edges[edge];
            let [from, to] = ends.map(|end| lattice.positions[end]);
            let at_rest = Segment::new(from, to).distance_to(lattice.positions[node]);
            let is_near = (ON_BAR * shortest..=law.reach as f64 * shortest).contains(&at_rest);
            let most = AT_REST * at_rest;
            let pair = Pair {
                node,
                edge,
                ends,
                most,
            };
            (is_near && !ends.contains(&node)).then_some(pair)
        };
        let edges = 0..lattice.edges.len();
        let of_edge = |edge| (0..lattice.nodes()).filter_map(move |node| pair(node, edge));
        Self {
            law: law.clone(),
            shortest,
            softening: lattice.softening(),
            pairs: edges.flat_map(of_edge).collect(),
        }
    }

    fn bump<const D: usize>(&self, dt: f64) -> Bump<D> {
        Bump {
            shortest: self.shortest,
            softening: self.softening,
            dt,
        }
    }

    /// The two settings that the kernel reads.
    fn numbers(&self) -> [f64; 2] {
        [self.law.stiffness, self.law.distance]
    }

    /// All pairs, each with its numbers in a pose.
    fn in_pose<'a>(&'a self, pose: &'a Pose) -> impl Iterator<Item = (&'a Pair, PairPose<f64>)> {
        let mut of_nodes = vec![0.0; pose.lattice.nodes()];
        for (stiffness, ends) in pose.body.stiffness.iter().zip(&pose.lattice.edges) {
            for &end in ends {
                of_nodes[end] += stiffness;
            }
        }
        let near = move |pair: &'a Pair| PairPose {
            node: pose.state.x[pair.node],
            from: pose.state.x[pair.ends[0]],
            to: pose.state.x[pair.ends[1]],
            of_bar: pose.body.stiffness[pair.edge],
            of_node: of_nodes[pair.node],
            most: pair.most,
        };
        self.pairs.iter().map(move |pair| (pair, near(pair)))
    }

    /// The largest stiffness of a contact of each node in a pose, N/m.
    fn stiffest(&self, pose: &Pose) -> Vec<f64> {
        let mut stiffest = vec![0.0_f64; pose.lattice.nodes()];
        for (pair, near) in self.in_pose(pose) {
            let stiffness = self.bump(1.0).touch(self.numbers(), &near).stiffness;
            for node in pair.ends.into_iter().chain([pair.node]) {
                stiffest[node] = stiffest[node].max(stiffness);
            }
        }
        stiffest
    }
}

/// The sum of impulses at the nodes. `pairs` has the pairs and, for each of their two ends, the components of its
/// impulses: those on the end if it comes before the node of the pair, and the opposite ones otherwise.
fn at_nodes(
    p: &mut Program,
    nodes: usize,
    pairs: &[&Pair],
    impulses: [Axes<Array>; 2],
) -> Axes<Array> {
    let between = |pair: &Pair, end: usize| {
        let end = pair.ends[end];
        [end.min(pair.node), end.max(pair.node)]
    };
    let both = |pair: &&Pair| [0, 1].map(|end| between(pair, end));
    let mut links: Vec<[usize; 2]> = pairs.iter().flat_map(both).collect();
    links.sort_unstable();
    links.dedup();
    let graph = Graph::new(nodes, &links);
    // In each round, a link takes the impulse of one pair.
    let mut rounds: [Vec<Vec<Option<usize>>>; 2] = [vec![], vec![]];
    for (end, rounds) in rounds.iter_mut().enumerate() {
        let mut taken = vec![0; links.len()];
        for (k, pair) in pairs.iter().enumerate() {
            let link = links.binary_search(&between(pair, end));
            let link = link.expect("every pair has a link");
            if taken[link] == rounds.len() {
                rounds.push(vec![None; graph.slots()]);
            }
            rounds[taken[link]][graph.slot_of_edge()[link]] = Some(k);
            taken[link] += 1;
        }
    }
    let none = vec![None; graph.slots()];
    let dimension = impulses[0].dimension();
    let of_links = Axes::from_fn(dimension, |axis| {
        let start = p.gather(impulses[0].as_slice()[axis], &none);
        let ends = rounds.iter().zip(impulses);
        ends.fold(start, |sum, (rounds, impulse)| {
            add_gathered(p, sum, impulse.as_slice()[axis], rounds)
        })
    });
    in_dimension!(dimension, D => {
        let links = of_links.array::<D>();
        p.map_edges(&graph, Identity::<D>, [], &links, &[]).into()
    })
}

impl Force for BumperForce {
    /// The largest distance of each pair, then the two factors of its impulses.
    fn constants(&self) -> Vec<Vec<f64>> {
        let sign = |pair: &Pair, end: usize| match pair.ends[end] < pair.node {
            true => 1.0,
            false => -1.0,
        };
        let most = self.pairs.iter().map(|pair| pair.most).collect();
        let signs = [0, 1].map(|end| self.pairs.iter().map(|pair| sign(pair, end)).collect());
        [most].into_iter().chain(signs).collect()
    }

    fn inputs(&self) -> Vec<StepInput> {
        step_inputs(&self.law)
    }

    fn record(&self, p: &mut Program, step: &Step, given: &ForceParameters<Array>) -> Axes<Array> {
        let (graph, nodes) = (step.graph, step.graph.nodes());
        let in_use = graph.edge_of_slot();
        let has_bar = |edge: usize| in_use[graph.slot_of_edge()[edge]].is_some();
        let mut has_bars = vec![false; nodes];
        for node in graph.nodes_of_slot().into_iter().flatten().flatten() {
            has_bars[node] = true;
        }
        let exists = |pair: &Pair| has_bar(pair.edge) && has_bars[pair.node];
        let pairs = self.pairs.iter().enumerate();
        let (places, pairs): (Vec<Option<usize>>, Vec<&Pair>) = pairs
            .filter(|(_, pair)| exists(pair))
            .map(|(k, pair)| (Some(k), pair))
            .unzip();
        if pairs.is_empty() {
            let none = vec![None; nodes];
            return step.nodes.x.map(|x| p.gather(x, &none));
        }
        let of_pairs = |of: &dyn Fn(&Pair) -> usize| -> Vec<Option<usize>> {
            pairs.iter().map(|pair| Some(of(pair))).collect()
        };
        let node_places = of_pairs(&|pair| pair.node);
        let at =
            |p: &mut Program, places: &[Option<usize>]| step.nodes.x.map(|x| p.gather(x, places));
        let node = at(p, &node_places);
        let [from, to] = [0, 1].map(|end| at(p, &of_pairs(&|pair| pair.ends[end])));
        let slots = of_pairs(&|pair| graph.slot_of_edge()[pair.edge]);
        let of_bar = p.gather(step.stiffness, &slots);
        let of_nodes = p.sum_at_nodes(graph, step.stiffness);
        let of_node = p.gather(of_nodes, &node_places);
        let [most, of_from, of_to] = [0, 1, 2].map(|k| p.gather(given.constants[k], &places));
        let impulses = in_dimension!(step.dimension(), D => {
            let pair = PairPose {
                node: node.vector::<D>(),
                from: from.vector(),
                to: to.vector(),
                of_bar,
                of_node,
                most,
            };
            let signed = SignedPair { pair, of_from, of_to };
            let found = p.map(self.bump::<D>(step.dt), signed.array(), &given.inputs);
            let EndImpulses { from, to } = EndImpulses::<_, D>::of(found);
            [from.into(), to.into()]
        });
        at_nodes(p, nodes, &pairs, impulses)
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        let pull = |(pair, near): (&Pair, PairPose<f64>)| {
            let EndImpulses { from, to } = self.bump(1.0).impulses(self.numbers(), &near);
            let force = match pair.ends.iter().position(|&end| end == node) {
                Some(end) => [from, to][end],
                None => -(from + to),
            };
            Pull {
                part: format!("the contact of node {} with edge {}", pair.node, pair.edge),
                force,
            }
        };
        let here =
            |(pair, _): &(&Pair, PairPose<f64>)| pair.node == node || pair.ends.contains(&node);
        self.in_pose(pose).filter(here).map(pull).collect()
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let energy = |(_, near): (&Pair, PairPose<f64>)| {
            let touch = self.bump(1.0).touch(self.numbers(), &near);
            0.5 * touch.stiffness * touch.depth * touch.depth
        };
        Some(self.in_pose(pose).map(energy).sum())
    }

    /// Adds the stiffness of one contact to every node: its stiffest one.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for (node, k) in self.stiffest(pose).into_iter().enumerate() {
            stiffness.node(node, Matrix::onto(pose.lattice.dimension) * k);
        }
    }

    /// A contact is not stiffer than the bars of its node, so one contact adds at most as much as they do. Node and bar
    /// vibrate against each other, which doubles what the stiffness of the law alone adds to a node.
    fn any_design(&self, of_node: f64, _shortest: f64, lightest: f64) -> f64 {
        of_node.min(2.0 * self.law.stiffness / lightest)
    }
}
