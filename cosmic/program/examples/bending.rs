//! Bars that continue straight through a node resist bending there: an angular spring between the two edges in line.
//!
//! This force acts neither on single nodes nor along single bars. So the law finds the pairs of bars in a lattice, and
//! its force records what a step computes: a kernel over all pairs gives their torques, and a second kernel makes a couple
//! of forces on the ends of each bar from the torques at its ends.
//!
//! A bar of the stiffness `k` (N/m) whose section has the radius of gyration `r` (m) has the bending stiffness `E I / l =
//! k r^2`. At a node the halves of two bars act in series, so they resist an angle `a` between them with the torque `c sin
//! a`, where `c = 2 r^2 k_1 k_2 / (k_1 + k_2)`. A void edge bends freely.
//!
//! `cargo run --release -p cosmic-program --example bending -- optimize --iterations 8 --out runs/bending`

use std::process::ExitCode;
use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Kernel};
use cosmic::geometry::{Axes, Matrix, Vector};
use cosmic::lattice::Lattice;
use cosmic::laws::{
    Force, ForceParameters, LatticeForce, Law, Pose, Step, StepInput, Stiffness, on_lattice,
};
use cosmic::settings::within;
use cosmic::{Fields, kernel};
use cosmic_program::Program;

/// Two bars are in line if the cosine of the angle between them is larger than this. The largest such angle is about 8
/// degrees.
const IN_LINE: f64 = 0.99;
/// A stiffness, N/m, that keeps the angular stiffness finite if both bars have stiffness 0.
const LEAST: f64 = 1e-12;

cosmic::settings! {
    /// Bars that continue straight through a node resist bending there.
    struct Bending<R> {
        /// Radius of gyration of the bars' section.
        radius: R = 0.01, allowed within(0.0, 1.0), unit "m", source "an example";
    }
}

impl Law for Bending {
    const NAME: &'static str = "bending";
}

impl LatticeForce for Bending {
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        let (radius, softening) = (self.radius, lattice.softening());
        let pairs = pairs(lattice);
        (!pairs.is_empty()).then(|| -> Arc<dyn Force> {
            Arc::new(BentBars {
                radius,
                softening,
                pairs,
            })
        })
    }
}

/// Two bars in line while a step is computed.
#[derive(Clone, Copy, Fields)]
struct Bars<T> {
    /// The positions of their nodes, m.
    before: Vector<T, 2>,
    middle: Vector<T, 2>,
    after: Vector<T, 2>,
    /// Their stiffness, N/m.
    stiffness: [T; 2],
}

/// The kernel of the torque between two bars over a step, N m s.
struct Hinge {
    dt: f64,
    softening: f64,
}

impl Hinge {
    #[inline(always)]
    fn stiffness<R: Real>(radius: R, [first, second]: [R; 2]) -> R {
        R::lit(2.0) * radius * radius * first * second / (first + second + R::lit(LEAST))
    }
}

#[kernel]
impl Kernel<_, _> for Hinge {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, bars: Bars<R>, settings: &[R]) -> R {
        let (a, b) = (bars.middle - bars.before, bars.after - bars.middle);
        let ([ax, ay], [bx, by]) = (a.array(), b.array());
        let lengths = a.softened_norm(self.softening) * b.softened_norm(self.softening);
        let sine = (ax * by - ay * bx) / lengths;
        Self::stiffness(settings[0], bars.stiffness) * sine * R::lit(self.dt)
    }
}

/// The kernel of the couple of forces on the ends of a bar. The inputs are the vector along the bar (m), two torques that
/// turn it to the left, and two that turn it to the right. The result is the impulse on its first node; its second node
/// gets the opposite impulse.
struct Couple {
    softening: f64,
}

#[kernel]
impl Kernel<6, 2> for Couple {
    fn eval<R: Real>(&self, [dx, dy, left_0, left_1, right_0, right_1]: [R; 6], _: &[R]) -> [R; 2] {
        let square = dx * dx + dy * dy + R::lit(self.softening);
        let turn = (left_0 + left_1 - (right_0 + right_1)) / square;
        [turn * dy, -turn * dx]
    }
}

/// Two bars in line.
#[derive(Clone, Debug)]
struct Pair {
    /// The nodes, in line.
    nodes: [usize; 3],
    /// The edge between the first two nodes, then the edge between the last two.
    edges: [usize; 2],
}

/// Finds the pairs of a lattice at rest. At each of its ends, a bar belongs to at most one pair.
fn pairs(lattice: &Lattice) -> Vec<Pair> {
    let mut pairs = Vec::new();
    for middle in 0..lattice.nodes() {
        let away = |edge: usize| {
            let [i, j] = lattice.edges[edge];
            let other = if i == middle { j } else { i };
            let along = lattice.positions[other] - lattice.positions[middle];
            (other, along.unit())
        };
        let here = |&edge: &usize| lattice.edges[edge].contains(&middle);
        let mut left: Vec<usize> = (0..lattice.edges.len()).filter(here).collect();
        while let Some(first) = left.pop() {
            let (before, a) = away(first);
            let in_line = |&edge: &usize| -a.dot(away(edge).1) > IN_LINE;
            if let Some(k) = left.iter().position(in_line) {
                let second = left.remove(k);
                pairs.push(Pair {
                    nodes: [before, middle, away(second).0],
                    edges: [first, second],
                });
            }
        }
    }
    pairs
}

/// The force of [`Bending`] on one lattice.
#[derive(Clone, Debug)]
struct BentBars {
    radius: f64,
    softening: f64,
    pairs: Vec<Pair>,
}

impl Force for BentBars {
    fn inputs(&self) -> Vec<StepInput> {
        let name = "bending.radius".to_owned();
        let value = self.radius;
        vec![StepInput { name, value }]
    }

    fn record(
        &self,
        p: &mut autodiff_programs::Program,
        step: &Step,
        given: &ForceParameters<Array>,
    ) -> Axes<Array> {
        let slots = step.graph.slot_of_edge();
        let of_pairs = |of: &dyn Fn(&Pair) -> usize| -> Vec<Option<usize>> {
            self.pairs.iter().map(|pair| Some(of(pair))).collect()
        };
        let [before, middle, after] = [0, 1, 2].map(|k| {
            let nodes = of_pairs(&|pair| pair.nodes[k]);
            step.nodes.x.map(|x| p.gather(x, &nodes)).vector()
        });
        let stiffness = [0, 1].map(|k| {
            let bars = of_pairs(&|pair| slots[pair.edges[k]]);
            p.gather(step.stiffness, &bars)
        });
        let (dt, softening) = (step.dt, step.softening);
        let bars = Bars {
            before,
            middle,
            after,
            stiffness,
        };
        let [torque] = p.map(Hinge { dt, softening }, bars.array(), &given.inputs);
        // The pairs at both ends of every bar whose first bar it is, then those whose second bar it is.
        let mut at_ends = vec![vec![None; step.graph.slots()]; 4];
        for (k, pair) in self.pairs.iter().enumerate() {
            for (place, edge) in pair.edges.into_iter().enumerate() {
                let end = usize::from(pair.nodes[1] > pair.nodes[2 * place]);
                at_ends[2 * place + end][slots[edge]] = Some(k);
            }
        }
        let torques = [0, 1, 2, 3].map(|k| p.gather(torque, &at_ends[k]));
        let ends = step.nodes.x.array::<2>();
        let couples = p.map_edges(step.graph, Couple { softening }, ends, &torques, &[]);
        couples.into()
    }

    /// Adds a bound to each of the three nodes. If `g` has the derivatives of the angle with respect to their positions,
    /// displacements `u` change its square by at most the sum over the nodes of `|g_i| (|g_1| + |g_2| + |g_3|)` times the
    /// square of `u_i` along `g_i`.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for pair in &self.pairs {
            let x = pair.nodes.map(|node| pose.state.x[node]);
            let [a, b] = [x[1] - x[0], x[2] - x[1]]
                .map(|bar| bar.turned_left() / (bar.dot(bar) + self.softening));
            let turns = [a, -(a + b), b];
            let k = pair.edges.map(|edge| pose.body.stiffness[edge]);
            let angular = Hinge::stiffness(self.radius, k);
            let all: f64 = turns.iter().map(|turn| turn.norm()).sum();
            for (node, turn) in pair.nodes.into_iter().zip(turns) {
                if turn.norm() > 0.0 {
                    stiffness.node(node, Matrix::square(turn) * (angular * all / turn.norm()));
                }
            }
        }
    }

    /// The angular stiffness of a pair is at most `2 r^2` times the stiffness of one of its bars. So all pairs together add
    /// at most `12 (r / l)^2` times `of_node` to what each end of a bar adds to a squared frequency.
    fn any_design(&self, of_node: f64, shortest: f64, _lightest: f64) -> f64 {
        24.0 * (self.radius / shortest).powi(2) * of_node
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[physics]\nforces = [\"bending\"]";
    Program::new()
        .with_law(on_lattice::<Bending>())
        .with_scene("bending", scene)
        .run()
}
