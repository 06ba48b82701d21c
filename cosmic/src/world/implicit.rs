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
use crate::geometry::{Along, Axes, Dimension, Symmetric, Vector};
use crate::laws::kernels::{Equation, FirstPass, Flat, Impulse, Linear, NextPass, Push, Terrain};
use crate::laws::{
    AnyContact, Balance, FindGround, FirstContact, Force, FreeEquation, GroundBelow, HeldEquation,
    HeldNode, LinearBar, Motion, NextContact, NodeAndGround, NodeContacts, NodeEquation,
    NodeInNextPass, NodeInPass, Reaction, Step, add, tensions,
};
use crate::policy::weighted;
use crate::{Fields, in_both_dimensions, in_dimension, kernel};

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

/// The velocities of all nodes, and the impulses that change them.
#[derive(Clone, Copy)]
struct Balanced {
    /// The velocity in the step, m/s.
    moving: Axes<Array>,
    /// The velocity without bars, m/s.
    free: Axes<Array>,
    /// The impulses of the forces, N s.
    impulses: Axes<Array>,
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
}

impl Bars {
    /// What the kernel [`Impulse`] reads of each bar.
    fn linear<const D: usize>(&self) -> LinearBar<Array, D> {
        LinearBar {
            impulse: self.impulse.vector(),
            slopes: Symmetric::first_of(&self.slopes),
        }
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
        in_dimension!(self.dimension(), D => p.map(FreeVelocity::<D>, v.array(), push).into())
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
        let (mass, mut averaged) = in_dimension!(self.dimension(), D => {
            let pushed = PushedMass { impulse: pass.reaction.vector::<D>(), inverse_mass };
            let pushed = p.map(PerMass::<D>, pushed.array(), &[]);
            let MassAndChange { mass, change } = MassAndChange::<_, D>::of(pushed);
            (mass, change.list())
        });
        let contacts = pass.contacts.as_ref();
        averaged.push(contacts.map_or(start.none, |contacts| contacts.is_held));
        let [_, means] = weighted(p, mass, [&averaged, &[], &[]]);
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
        let at_base = Balanced {
            moving: base.v,
            free,
            impulses,
        };
        let solved = match &contacts {
            Some(contacts) => self.solve(p, at_base, change, contacts, &bars),
            None => self.solve_free(p, at_base, &bars),
        };
        let change = add(p, Some(change), solved);
        let moving = add(p, Some(base.v), change);
        let impulses = self.impulses(p, base, &bars, change);
        let at_end = Balanced {
            moving,
            free,
            impulses,
        };
        let reaction = in_dimension!(self.dimension(), D => {
            p.map(Reaction::<D>, self.balance::<D>(at_end).array(), &[]).into()
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
        let (graph, dt, softening) = (self.step.graph, self.step.dt, self.step.softening);
        let moving = (self.step.nodes.v).zip_with(pass.moving, |v, w| p.map(Mean, [v, w], &[])[0]);
        in_dimension!(self.dimension(), D => {
            let (change, linear) = (pass.change.array::<D>(), pass.bars.linear::<D>().list());
            let impulse = p.map_each_edge(graph, Impulse::<D>, change, &linear, &[]);
            let (base, pulled) = (pass.base.array::<D>(), BarTension::<D> { dt, softening });
            let [tension] = p.map_each_edge(graph, pulled, base, &impulse, &[]);
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
        let at = self.at(base);
        let tensions = tensions(p, &at, self.forces, &self.given.mechanics.forces).list();
        let (dt, softening) = (at.dt, at.softening);
        let lead = if from_start { 1.0 } else { 0.0 };
        in_dimension!(self.dimension(), D => {
            let (linear, ends) = (Linear::<D> { dt, softening, lead }, base.particle::<D>());
            let ends = ends.array::<{ 2 * D }>();
            let linear = p.map_each_edge(at.graph, linear, ends, &tensions, &[]);
            let LinearBar { impulse, slopes } = LinearBar::<_, D>::of(linear);
            Bars { impulse: impulse.into(), slopes: slopes.list() }
        })
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
        let of_bars: Axes<Array> = in_dimension!(self.dimension(), D => {
            let (change, linear) = (change.array::<D>(), bars.linear::<D>().list());
            p.map_edges(self.step.graph, Impulse::<D>, change, &linear, &[]).into()
        });
        let at = self.at(base);
        let forces = self.forces.iter().zip(&self.given.mechanics.forces);
        let others = forces.filter(|(force, _)| force.along_bars().is_none());
        others.fold(of_bars, |sum, (force, given)| {
            let own = force.record(p, &at, given);
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
        let dt = self.step.dt;
        let before = before.and_then(|pass| Some((pass, pass.contacts.as_ref()?)));
        let last = before.map_or([none; 2], |(_, contacts)| {
            [contacts.ground.segment, contacts.is_held]
        });
        let ground = self.ground(p, moving, last);
        in_dimension!(self.dimension(), D => {
            let now = NodeInPass {
                v: self.step.nodes.v.vector::<D>(),
                moving: moving.vector(),
                meeting: ground.meeting,
            };
            let Some((pass, contacts)) = before else {
                let first = p.map(FirstPass::<D> { dt }, now.array(), &[grip]);
                let first = FirstContact::<_, D>::of(first);
                return (first.contacts(ground, none), first.change.into());
            };
            let node = NodeInNextPass {
                now,
                inverse_mass: self.step.inverse_mass,
                was_held: contacts.is_held,
                stuck: contacts.sticks,
                was_new: contacts.ground.meeting.is_new,
                impact: contacts.impact,
                slip: Along::first_of(&contacts.slip),
                reaction: pass.reaction.vector(),
                bars: Symmetric::first_of(&pass.of_bars),
            };
            let next = NextContact::<_, D>::of(p.map(NextPass::<D> { dt }, node.array(), &[grip]));
            (next.contacts(ground), next.change.into())
        })
    }

    /// Finds the ground below every node. `segment` and `is_held` are those of the pass before.
    fn ground(
        &self,
        p: &mut Program,
        moving: Axes<Array>,
        [segment, is_held]: [Array; 2],
    ) -> GroundBelow<Array> {
        let dt = self.step.dt;
        let base = Motion {
            v: moving,
            ..self.step.nodes
        };
        in_dimension!(self.dimension(), D => {
            let node = NodeAndGround { node: base.particle::<D>(), segment, is_held };
            // The condition is constant, so that no kernel in space is compiled for terrain.
            GroundBelow::of(match self.terrain.cloned() {
                Some(ground) if const { D == 2 } => p.map(FindGround::<_, D> { ground, dt }, node.array(), &[]),
                _ => p.map(FindGround::<_, D> { ground: Flat, dt }, node.array(), &[]),
            })
        })
    }

    /// The arrays of the kernels [`Reaction`] and [`FreeEquation`].
    fn balance<const D: usize>(&self, nodes: Balanced) -> Balance<Array, D> {
        Balance {
            moving: nodes.moving.vector(),
            free: nodes.free.vector(),
            impulse: nodes.impulses.vector(),
            inverse_mass: self.step.inverse_mass,
        }
    }

    /// Solves for the velocities of nodes at the base. `change` is the change of velocity of held nodes. Returns the change
    /// of velocity that is left.
    fn solve(
        &self,
        p: &mut Program,
        at_base: Balanced,
        change: Axes<Array>,
        contacts: &NodeContacts<Array>,
        bars: &Bars,
    ) -> Axes<Array> {
        in_dimension!(self.dimension(), D => {
            let node = HeldNode {
                change: change.vector::<D>(),
                base: at_base.moving.vector(),
                free: at_base.free.vector(),
                impulse: at_base.impulses.vector(),
                inverse_mass: self.step.inverse_mass,
                tangent: contacts.ground.meeting.tangent,
                is_held: contacts.is_held,
                sticks: contacts.sticks,
                slip: Along::first_of(&contacts.slip),
                drag: contacts.drag,
            };
            let equation = p.map(Equation::<D>, node.array(), &[]);
            let HeldEquation { equation, held } = HeldEquation::<_, D>::of(equation);
            self.solution(p, equation, bars, &held.list())
        })
    }

    /// Like [`solve`](Self::solve), in a world without ground.
    fn solve_free(&self, p: &mut Program, at_base: Balanced, bars: &Bars) -> Axes<Array> {
        in_dimension!(self.dimension(), D => {
            let node = self.balance::<D>(at_base).array();
            let equation = NodeEquation::<_, D>::of(p.map(FreeEquation::<D>, node, &[]));
            self.solution(p, equation, bars, &[])
        })
    }

    /// The solution of the equations of all nodes. `held` are the projections onto the directions in which nodes are held.
    fn solution<const D: usize>(
        &self,
        p: &mut Program,
        equation: NodeEquation<Array, D>,
        bars: &Bars,
        held: &[Array],
    ) -> Axes<Array>
    where
        Axes<Array>: From<[Array; D]>,
    {
        let NodeEquation { right, block } = equation;
        p.solve(
            self.step.graph,
            &block.list(),
            &bars.slopes,
            held,
            right.array(),
        )
        .into()
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
        let (moving, settings) = (Motion { x, v: moving }, &self.given.mechanics.contact);
        self.contact
            .land(p, dt, self.terrain, moving, contacts, settings)
    }
}

/// The kernel of the velocity without bars: damping, then the velocity that gravity adds. The uniform inputs are those of a
/// [`Push`].
struct FreeVelocity<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for FreeVelocity<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = Push::<f64, D>::COUNT;

        fn eval<R: Real>(&self, v: Vector<R, D>, push: &[R]) -> Vector<R, D> {
            let Push { gravity, decay } = Push::of(push);
            v.fma(decay, gravity)
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

/// A node that gets an impulse.
#[derive(Clone, Copy, Fields)]
struct PushedMass<T, const D: usize> {
    /// The impulse, N s.
    impulse: Vector<T, D>,
    /// 1 / mass, 1/kg.
    inverse_mass: T,
}

/// The mass of a node, kg, and its change of velocity by an impulse, m/s.
#[derive(Clone, Copy, Fields)]
struct MassAndChange<T, const D: usize> {
    mass: T,
    change: Vector<T, D>,
}

/// The kernel of a node's mass and its change of velocity.
struct PerMass<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for PerMass<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: PushedMass<R, D>, _: &[R]) -> MassAndChange<R, D> {
            let PushedMass { impulse, inverse_mass } = node;
            MassAndChange { mass: inverse_mass.recip(), change: impulse * inverse_mass }
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
