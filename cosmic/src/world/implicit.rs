//! The implicit step: bars pull with the forces that they will have at the end of the step, and nodes that touch the
//! ground are held while the velocities are solved for. It stays stable with stiff bars.
//!
//! A step is implicit Euler, solved by Newton's method; each of its iterations is a *pass*. Vectors and blocks are those
//! of `tests/data/implicit/README.md`, which has the equations and compares this step with others.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Compiled, Kernel, Program};

use super::effort::{BarTension, Meter};
use super::parameters::StepParameters;
use crate::geometry::{Axes, Dimension, Vector, inputs, outputs};
use crate::laws::{
    AnyContact, Equation, FindGround, FirstPass, Flat, Force, FreeEquation, GroundBelow, Impulse,
    Linear, Motion, NextPass, NodeContacts, Push, Reaction, Step, Terrain, add,
};
use crate::policy::weighted;
use crate::{in_both_dimensions, in_dimension, kernel};

/// An implicit step of all nodes, as it is recorded.
pub(super) struct Implicit<'a> {
    pub(super) contact: &'a dyn AnyContact,
    /// The profile of the ground; `None` if the ground is a straight line or a plane.
    pub(super) terrain: Option<&'a Terrain>,
    pub(super) forces: &'a [Arc<dyn Force>],
    /// The number of passes, each of which solves linear equations.
    pub(super) passes: usize,
    pub(super) given: &'a StepParameters<Array>,
    /// The nodes at the start of the step, and what forces read besides. Its `dt` is the duration of the step.
    pub(super) step: &'a Step<'a>,
}

/// The arrays that every pass of a step reads.
struct Start {
    /// The velocity that nodes would have without bars, m/s.
    free: Axes<Array>,
    /// The largest friction, as a multiple of the impulse out of the ground; `None` in a world without ground.
    grip: Option<Array>,
    /// A zero for every node.
    none: Array,
}

/// The results of a pass.
struct Pass {
    /// The velocity with which nodes move in the step, m/s.
    moving: Axes<Array>,
    /// The contacts; `None` in a world without ground.
    contacts: Option<NodeContacts<Array>>,
    /// The impulse of the ground on each node, N s. Off the ground it is the error of the solution.
    reaction: Axes<Array>,
    /// The sum of the blocks of each node's bars, kg: the lower triangle.
    of_bars: Vec<Array>,
    /// The bars, linearised at the base.
    bars: Bars,
    /// The positions of the base, m.
    base: Axes<Array>,
    /// By how much the velocities differ from those of the base, m/s.
    change: Axes<Array>,
}

/// The bars, linearised at a base.
struct Bars {
    /// The impulse of each bar on its first node, N s.
    impulse: Axes<Array>,
    /// The lower triangle of the matrix by which a change of velocity changes the impulse, kg.
    slopes: Vec<Array>,
    /// The numbers of the forces that do not act along bars.
    others: Vec<usize>,
}

impl Bars {
    /// The inputs of the kernel [`Impulse`] after the change of velocity.
    fn linear(&self) -> Vec<Array> {
        [self.impulse.as_slice(), &self.slopes].concat()
    }
}

impl Implicit<'_> {
    /// Records the step, and returns the nodes after it. If a meter is given, it is advanced.
    pub(super) fn record(&self, p: &mut Program, meter: Option<&mut Meter>) -> Motion {
        let nodes = self.step.nodes;
        let free = self.free(p);
        // The kernel of the grip does not read its input; a rest length has no derivative.
        let any = p.gather(self.step.rest_length, &[Some(0)]);
        let has_ground = self.contact.has_ground();
        let grip = has_ground.then(|| self.contact.grip(p, any, &self.given.mechanics.contact));
        let none = p.gather(any, &vec![None; self.step.graph.nodes()]);
        let start = Start { free, grip, none };
        let first = Motion { v: free, ..nodes };
        let mut pass = self.pass(p, first, &start, None);
        for _ in 1..self.passes {
            let base = Motion {
                x: self.moved(p, pass.moving),
                v: pass.moving,
            };
            pass = self.pass(p, base, &start, Some(&pass));
        }
        pass.moving = self.balanced(p, &start, &pass);
        if let Some(meter) = meter {
            *meter = self.metered(p, &pass, *meter);
        }
        self.land(p, &pass)
    }

    fn dimension(&self) -> Dimension {
        self.step.dimension()
    }

    /// The velocities that nodes would have without bars, m/s.
    fn free(&self, p: &mut Program) -> Axes<Array> {
        let (v, push) = (self.step.nodes.v, &self.given.mechanics.push);
        in_dimension!(self.dimension(), D => p.map(FreeVelocity, v.array::<D>(), push).into())
    }

    /// The positions of the nodes if they move with these velocities in the step, m.
    fn moved(&self, p: &mut Program, moving: Axes<Array>) -> Axes<Array> {
        let position = NewPosition(self.step.dt);
        (self.step.nodes.x).zip_with(moving, |x, v| p.map(position, [x, v], &[])[0])
    }

    /// The velocities with which nodes move. If no node is held, they are shifted so that the momentum of the robot is
    /// exact: with stiff bars, the rounding of the solution is large compared with the momentum of light nodes.
    fn balanced(&self, p: &mut Program, start: &Start, pass: &Pass) -> Axes<Array> {
        let (nodes, inverse_mass) = (self.step.graph.nodes(), self.step.inverse_mass);
        let per_mass = in_dimension!(self.dimension(), D => {
            let impulse = inputs::<_, { D + 1 }>(&[pass.reaction], &[inverse_mass]);
            p.map(PerMass, impulse, &[]).to_vec()
        });
        let contacts = pass.contacts.as_ref();
        let is_held = contacts.map_or(start.none, |contacts| contacts.is_held);
        let averaged = [&per_mass[1..], &[is_held]].concat();
        let [_, means] = weighted(p, per_mass[0], [&averaged, &[], &[]]);
        let mut mean = |k: usize| p.gather(means, &vec![Some(k); nodes]);
        let count = self.dimension().count();
        let (means, is_held) = (Axes::from_fn(self.dimension(), &mut mean), mean(count));
        (pass.moving).zip_with(means, |v, mean| {
            p.map(SubtractMean, [v, mean, is_held], &[])[0]
        })
    }

    /// Records a pass about the positions and velocities of `base`. `before` is the pass before.
    fn pass(&self, p: &mut Program, base: Motion, start: &Start, before: Option<&Pass>) -> Pass {
        let (graph, free) = (self.step.graph, start.free);
        let bars = self.bars(p, base, before.is_none());
        let held = start
            .grip
            .map(|grip| self.contacts(p, [grip, start.none], base.v, before));
        let (contacts, change) = match held {
            Some((contacts, change)) => (Some(contacts), change),
            None => (None, base.v.map(|_| start.none)),
        };
        let impulses = self.impulses(p, base, &bars, change);
        let vectors = [change, base.v, free, impulses];
        let solved = match &contacts {
            Some(contacts) => self.solve(p, vectors, contacts, &bars),
            None => self.solve_free(p, [base.v, free, impulses], &bars),
        };
        let change = add(p, Some(change), solved);
        let moving = add(p, Some(base.v), change);
        let impulses = self.impulses(p, base, &bars, change);
        let (balance, inverse_mass) = ([moving, free, impulses], [self.step.inverse_mass]);
        let reaction = in_dimension!(self.dimension(), D => {
            let node = inputs::<_, { 3 * D + 1 }>(&balance, &inverse_mass);
            Axes::from(p.map::<_, { 3 * D + 1 }, D>(Reaction, node, &[]))
        });
        let of_bars = |entry: &Array| p.sum_at_nodes(graph, *entry);
        Pass {
            moving,
            contacts,
            reaction,
            of_bars: match before {
                Some(before) => before.of_bars.clone(),
                None => bars.slopes.iter().map(of_bars).collect(),
            },
            bars,
            base: base.x,
            change,
        }
    }

    /// Records the meter after a step whose last pass is `pass`. The impulses are those with which bars act on the nodes in
    /// this pass.
    fn metered(&self, p: &mut Program, pass: &Pass, before: Meter) -> Meter {
        let (graph, per_edge) = (self.step.graph, pass.bars.linear());
        let pulled = BarTension {
            dt: self.step.dt,
            softening: self.step.softening,
        };
        let moving = (self.step.nodes.v).zip_with(pass.moving, |v, w| p.map(Mean, [v, w], &[])[0]);
        in_dimension!(self.dimension(), D => {
            let impulse: [Array; D] =
                p.map_each_edge(graph, Impulse::<D>, pass.change.array::<D>(), &per_edge, &[]);
            let [tension] =
                p.map_each_edge::<_, D, { 2 * D }, 1>(graph, pulled, pass.base.array(), &impulse, &[]);
            before.after(p, graph, moving, impulse.into(), tension)
        })
    }

    /// The step with the nodes at a base.
    fn at(&self, nodes: Motion) -> Step<'_> {
        Step {
            nodes,
            ..*self.step
        }
    }

    /// Linearises the bars at a base, which is the start of the step if `from_start` is true.
    fn bars(&self, p: &mut Program, base: Motion, from_start: bool) -> Bars {
        let (at, mut sum, mut others) = (self.at(base), None, Vec::new());
        for (k, force) in self.forces.iter().enumerate() {
            match force.record_slopes(p, &at, &self.given.mechanics.forces[k], sum) {
                Some(tensions) => sum = Some(tensions),
                None => others.push(k),
            }
        }
        let tensions = sum.expect("every robot has springs").array();
        let (dt, softening) = (at.dt, at.softening);
        let lead = if from_start { 1.0 } else { 0.0 };
        let dimension = self.dimension();
        let linear = in_dimension!(dimension, D => {
            let linear = Linear::<D> { dt, softening, lead };
            p.map_each_edge::<_, { 2 * D }, { 2 * D + 3 }, { D + D * (D + 1) / 2 }>(
                at.graph, linear, base.axes(), &tensions, &[],
            ).to_vec()
        });
        let (impulse, slopes) = linear.split_at(dimension.count());
        let [impulse] = outputs(dimension, impulse);
        Bars {
            impulse,
            slopes: slopes.to_vec(),
            others,
        }
    }

    /// The impulses on all nodes (N s), if their velocities differ by `change` from the base: those of the bars, then those
    /// of forces that do not act along bars.
    fn impulses(
        &self,
        p: &mut Program,
        base: Motion,
        bars: &Bars,
        change: Axes<Array>,
    ) -> Axes<Array> {
        let (graph, per_edge) = (self.step.graph, bars.linear());
        let of_bars: Axes<Array> = in_dimension!(self.dimension(), D => {
            p.map_edges(graph, Impulse::<D>, change.array::<D>(), &per_edge, &[]).into()
        });
        let at = self.at(base);
        (bars.others.iter()).fold(of_bars, |sum, &k| {
            let own = self.forces[k].record(p, &at, &self.given.mechanics.forces[k]);
            add(p, Some(sum), own)
        })
    }

    /// Decides which nodes are held in a pass that begins with the velocity `moving`. Returns the contacts, and the change
    /// of velocity that brings held nodes to the ground. `none` is a zero for every node.
    fn contacts(
        &self,
        p: &mut Program,
        [grip, none]: [Array; 2],
        moving: Axes<Array>,
        before: Option<&Pass>,
    ) -> (NodeContacts<Array>, Axes<Array>) {
        let (vectors, dt) = ([self.step.nodes.v, moving], self.step.dt);
        let before = before.and_then(|pass| Some((pass, pass.contacts.as_ref()?)));
        let last = before.map_or([none; 2], |(_, contacts)| {
            [contacts.ground.segment, contacts.is_held]
        });
        let ground = self.ground(p, moving, last);
        let [tx, ty] = ground.tangent;
        let mut others = vec![ground.is_new, tx, ty, ground.height];
        let dimension = self.dimension();
        let Some((pass, contacts)) = before else {
            let first = in_dimension!(dimension, D => {
                let node = inputs::<_, { 2 * D + 4 }>(&vectors, &others);
                p.map(FirstPass::<D> { dt }, node, &[grip]).to_vec()
            });
            let (own, change) = first.split_at(first.len() - dimension.count());
            let contacts = NodeContacts {
                is_held: ground.is_new,
                ground,
                sticks: own[0],
                impact: own[1],
                slip: own[2..].to_vec(),
                drag: none,
                slid: none,
            };
            let [change] = outputs(dimension, change);
            return (contacts, change);
        };
        others.extend([
            self.step.inverse_mass,
            contacts.is_held,
            contacts.sticks,
            contacts.ground.is_new,
            contacts.impact,
        ]);
        let reaction = pass.reaction.as_slice();
        others.extend([&contacts.slip, reaction, &pass.of_bars].concat());
        let next = in_dimension!(dimension, D => {
            let node = inputs::<_, { 4 * D + 8 + D * (D + 1) / 2 }>(&vectors, &others);
            p.map(NextPass::<D> { dt }, node, &[grip]).to_vec()
        });
        let (own, change) = next.split_at(next.len() - dimension.count());
        let (slip, friction) = own[3..].split_at(dimension.count() - 1);
        let contacts = NodeContacts {
            ground,
            is_held: own[0],
            sticks: own[1],
            impact: own[2],
            slip: slip.to_vec(),
            drag: friction[0],
            slid: friction[1],
        };
        let [change] = outputs(dimension, change);
        (contacts, change)
    }

    /// Finds the ground below every node. `last` has the segment and `is_held` of the pass before.
    fn ground(&self, p: &mut Program, moving: Axes<Array>, last: [Array; 2]) -> GroundBelow<Array> {
        let (vectors, dt) = ([self.step.nodes.x, moving], self.step.dt);
        let flat = FindGround { ground: Flat, dt };
        let [segment, is_new, tx, ty, height] = match (self.dimension(), self.terrain.cloned()) {
            (Dimension::Space, _) => p.map(flat, inputs::<_, 8>(&vectors, &last), &[]),
            (Dimension::Plane, None) => p.map(flat, inputs::<_, 6>(&vectors, &last), &[]),
            (Dimension::Plane, Some(ground)) => {
                let node = inputs::<_, 6>(&vectors, &last);
                p.map(FindGround { ground, dt }, node, &[])
            }
        };
        GroundBelow {
            segment,
            is_new,
            tangent: [tx, ty],
            height,
        }
    }

    /// Solves for the velocities. The vectors are the change of held nodes, the base, the velocity without bars, and the
    /// impulses. Returns the change of velocity that is left.
    fn solve(
        &self,
        p: &mut Program,
        vectors: [Axes<Array>; 4],
        contacts: &NodeContacts<Array>,
        bars: &Bars,
    ) -> Axes<Array> {
        let ([tx, ty], graph) = (contacts.ground.tangent, self.step.graph);
        let mut others = vec![self.step.inverse_mass, tx, ty];
        others.extend([contacts.is_held, contacts.sticks]);
        others.extend(&contacts.slip);
        others.push(contacts.drag);
        in_dimension!(self.dimension(), D => {
            let node = inputs::<_, { 5 * D + 5 }>(&vectors, &others);
            let equation: [Array; D * (D + 2)] = p.map(Equation::<D>, node, &[]);
            let (b, blocks) = equation.split_at(D);
            let (block, held) = blocks.split_at(blocks.len() / 2);
            let b: [Array; D] = inputs(&[], b);
            p.solve(graph, block, &bars.slopes, held, b).into()
        })
    }

    /// Like [`solve`](Self::solve), in a world without ground.
    fn solve_free(&self, p: &mut Program, vectors: [Axes<Array>; 3], bars: &Bars) -> Axes<Array> {
        in_dimension!(self.dimension(), D => {
            let node = inputs::<_, { 3 * D + 1 }>(&vectors, &[self.step.inverse_mass]);
            let equation: [Array; D + D * (D + 1) / 2] = p.map(FreeEquation, node, &[]);
            let (b, block) = equation.split_at(D);
            let b: [Array; D] = inputs(&[], b);
            p.solve(self.step.graph, block, &bars.slopes, &[], b).into()
        })
    }

    /// Records the end of the step: nodes move with the velocity of the last pass.
    fn land(&self, p: &mut Program, last: &Pass) -> Motion {
        let (x, moving, dt) = (self.step.nodes.x, last.moving, self.step.dt);
        let Some(contacts) = &last.contacts else {
            return Motion {
                x: self.moved(p, moving),
                v: moving,
            };
        };
        let mut own = vec![contacts.ground.segment, contacts.is_held, contacts.sticks];
        own.extend(&contacts.slip);
        own.push(contacts.slid);
        let (moving, settings) = (Motion { x, v: moving }, &self.given.mechanics.contact);
        self.contact
            .land(p, dt, self.terrain, moving, &own, settings)
    }
}

/// The kernel of the velocity without bars: damping, then the velocity that gravity adds. The uniform inputs are those of a
/// [`Push`].
struct FreeVelocity;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<D, D> for FreeVelocity {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = Push::<f64, D>::COUNT;

        fn eval<R: Real>(&self, v: [R; D], push: &[R]) -> [R; D] {
            let Push { gravity, decay } = Push::<R, D>::of(push);
            Vector::new(v).fma(decay, gravity).array()
        }
    }
}

/// The kernel of a component of a position after a step of this duration (s), from the components of the position and of
/// the velocity in the step.
#[derive(Clone, Copy)]
struct NewPosition(f64);

#[kernel]
impl Kernel<2, 1> for NewPosition {
    const COMPILED: Compiled = Compiled::Seldom;

    fn eval<R: Real>(&self, [x, v]: [R; 2], _: &[R]) -> [R; 1] {
        [R::lit(self.0).fma(v, x)]
    }
}

/// The kernel of the mean of two numbers.
struct Mean;

#[kernel]
impl Kernel<2, 1> for Mean {
    const COMPILED: Compiled = Compiled::Seldom;

    fn eval<R: Real>(&self, [a, b]: [R; 2], _: &[R]) -> [R; 1] {
        [R::lit(0.5) * (a + b)]
    }
}

/// The kernel of a node's mass (kg) and its change of velocity by an impulse, from the impulse (N s) and 1 / mass.
struct PerMass;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ D + 1 }, { D + 1 }> for PerMass {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, x: [R; D + 1], _: &[R]) -> [R; D + 1] {
            let mut results = [x[D].recip(); D + 1];
            let impulse = Vector::<R, D>::first_of(&x);
            (impulse * x[D]).write(&mut results[1..]);
            results
        }
    }
}

/// The kernel that subtracts a component of a mean velocity from that of the velocity of a node, unless some node is held:
/// then the mean of `is_held`, the last input, is above 0.
struct SubtractMean;

#[kernel]
impl Kernel<3, 1> for SubtractMean {
    const COMPILED: Compiled = Compiled::Seldom;

    fn eval<R: Real>(&self, [moving, mean, is_held]: [R; 3], _: &[R]) -> [R; 1] {
        let holds = R::zero().less(is_held);
        [R::select(holds, moving, moving - mean)]
    }
}
