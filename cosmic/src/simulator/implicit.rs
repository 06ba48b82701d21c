//! The implicit step: bars pull with the forces that they will have at the end of the step, and nodes that touch the
//! ground are held while the velocities are solved for. It stays stable with stiff bars.
//!
//! A step is implicit Euler, solved by Newton's method; each of its iterations is a *pass*. Vectors and blocks are those
//! of `tests/data/implicit/README.md`, which has the equations and compares this step with others.

use std::sync::Arc;

use autodiff::{Array, Kernel, Program, Real};

use super::effort::{BarTension, Meter};
use super::parameters::Parameters;
use crate::geometry::Vector;
use crate::kernel;
use crate::laws::{
    AnyContact, Equation, FindGround, FirstPass, Flat, Force, FreeEquation, GroundBelow, Impulse,
    Linear, Motion, NextPass, NodeContacts, Particle, Push, Reaction, Step, Terrain, add,
};

/// An implicit step of all nodes, as it is recorded.
pub(super) struct Implicit<'a> {
    pub(super) contact: &'a dyn AnyContact,
    /// The profile of the ground; `None` if the ground is a straight line.
    pub(super) terrain: Option<&'a Terrain>,
    pub(super) forces: &'a [Arc<dyn Force>],
    /// The number of passes, each of which solves linear equations.
    pub(super) passes: usize,
    pub(super) given: &'a Parameters<Array>,
    /// The nodes at the start of the step, and what forces read besides. Its `dt` is the duration of the step.
    pub(super) step: &'a Step<'a>,
}

/// The arrays that every pass of a step reads.
struct Start {
    /// The velocity that nodes would have without bars, m/s.
    free: Vector<Array, 2>,
    /// The largest friction, as a multiple of the impulse out of the ground; `None` in a world without ground.
    grip: Option<Array>,
    /// A zero for every node.
    none: Array,
}

/// The results of a pass.
struct Pass {
    /// The velocity with which nodes move in the step, m/s.
    moving: Vector<Array, 2>,
    /// The contacts; `None` in a world without ground.
    contacts: Option<NodeContacts<Array>>,
    /// The impulse of the ground on each node, N s. Off the ground it is the error of the solution.
    reaction: Vector<Array, 2>,
    /// The sum of the blocks of each node's bars, kg.
    of_bars: [Array; 3],
    /// The bars, linearised at the base.
    bars: Bars,
    /// The positions of the base, m.
    base: Vector<Array, 2>,
    /// By how much the velocities differ from those of the base, m/s.
    change: Vector<Array, 2>,
}

/// The bars, linearised at a base.
struct Bars {
    /// The impulse of each bar on its first node, N s.
    impulse: Vector<Array, 2>,
    /// The lower triangle of the matrix by which a change of velocity changes the impulse, kg.
    slopes: [Array; 3],
    /// The numbers of the forces that do not act along bars.
    others: Vec<usize>,
}

impl Implicit<'_> {
    /// Records the step, and returns the nodes after it. If a meter is given, it is advanced.
    pub(super) fn record(&self, p: &mut Program, meter: Option<&mut Meter>) -> Motion {
        let nodes = self.nodes();
        let free = Vector::new(p.map(FreeVelocity, nodes.v.array(), &self.given.mechanics.push));
        // The kernel of the grip does not read its input; a rest length has no derivative.
        let any = p.gather(self.step.rest_length, &[Some(0)]);
        let has_ground = self.contact.has_ground();
        let grip = has_ground.then(|| self.contact.grip(p, any, &self.given.mechanics.contact));
        let none = p.gather(any, &vec![None; self.step.graph.nodes()]);
        let start = Start { free, grip, none };
        let first = Particle { v: free, ..nodes };
        let mut pass = self.pass(p, first, &start, None);
        for _ in 1..self.passes {
            let moved = p.map(NewPosition(self.step.dt), both(nodes.x, pass.moving), &[]);
            let base = Particle {
                x: Vector::new(moved),
                v: pass.moving,
            };
            pass = self.pass(p, base, &start, Some(&pass));
        }
        pass.moving = self.balanced(p, &start, &pass);
        if let Some(meter) = meter {
            *meter = self.metered(p, &pass, *meter);
        }
        let Particle { x, v } = self.land(p, &pass);
        let (x, v) = (x.array().into(), v.array().into());
        Motion { x, v }
    }

    /// The velocities with which nodes move. If no node is held, they are shifted so that the momentum of the robot is
    /// exact: with stiff bars, the rounding of the solution is large compared with the momentum of light nodes.
    fn balanced(&self, p: &mut Program, start: &Start, pass: &Pass) -> Vector<Array, 2> {
        let nodes = self.step.graph.nodes();
        let ([rx, ry], [wx, wy]) = (pass.reaction.array(), pass.moving.array());
        let [mass, ax, ay] = p.map(PerMass, [rx, ry, self.step.inverse_mass], &[]);
        let is_held = pass
            .contacts
            .map_or(start.none, |contacts| contacts.is_held);
        let [_, means] = p.weighted(mass, &[ax, ay, is_held], &[], &[]);
        let [ax, ay, is_held] = [0, 1, 2].map(|k| p.gather(means, &vec![Some(k); nodes]));
        Vector::new(p.map(SubtractMean, [wx, wy, ax, ay, is_held], &[]))
    }

    /// Records a pass about the positions and velocities of `base`. `before` is the pass before.
    fn pass(
        &self,
        p: &mut Program,
        base: Particle<Array, 2>,
        start: &Start,
        before: Option<&Pass>,
    ) -> Pass {
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
        let solved = self.solve(
            p,
            [base.v, free, impulses, change],
            contacts.as_ref(),
            &bars,
        );
        let change = sum(p, change, solved);
        let moving = sum(p, base.v, change);
        let impulses = self.impulses(p, base, &bars, change);
        let reaction = Vector::new(p.map(Reaction, self.balance(moving, free, impulses), &[]));
        Pass {
            moving,
            contacts,
            reaction,
            of_bars: match before {
                Some(before) => before.of_bars,
                None => bars.slopes.map(|entry| p.sum_at_nodes(graph, entry)),
            },
            bars,
            base: base.x,
            change,
        }
    }

    /// Records the meter after a step whose last pass is `pass`. The impulses are those with which bars act on the nodes in
    /// this pass.
    fn metered(&self, p: &mut Program, pass: &Pass, before: Meter) -> Meter {
        let ([jx, jy], [xx, xy, yy]) = (pass.bars.impulse.array(), pass.bars.slopes);
        let (graph, per_edge) = (self.step.graph, [jx, jy, xx, xy, yy]);
        let impulse: [Array; 2] =
            p.map_each_edge(graph, Impulse, pass.change.array(), &per_edge, &[]);
        let pulled = BarTension {
            dt: self.step.dt,
            softening: self.step.softening,
        };
        let [tension] = p.map_each_edge(graph, pulled, pass.base.array(), &impulse, &[]);
        let moving = p.map(Mean, both(self.nodes().v, pass.moving), &[]);
        before.after(p, graph, moving.into(), impulse.into(), tension)
    }

    /// The inputs of the kernel [`Reaction`].
    fn balance(
        &self,
        moving: Vector<Array, 2>,
        free: Vector<Array, 2>,
        impulses: Vector<Array, 2>,
    ) -> [Array; 7] {
        let ([wx, wy, fx, fy], [jx, jy]) = (both(moving, free), impulses.array());
        [wx, wy, fx, fy, jx, jy, self.step.inverse_mass]
    }

    /// The nodes at the start of the step.
    fn nodes(&self) -> Particle<Array, 2> {
        in_plane(self.step.nodes)
    }

    /// The step with the nodes at a base.
    fn at(&self, base: Particle<Array, 2>) -> Step<'_> {
        Step {
            nodes: Motion {
                x: base.x.array().into(),
                v: base.v.array().into(),
            },
            ..*self.step
        }
    }

    /// Linearises the bars at a base, which is the start of the step if `from_start` is true.
    fn bars(&self, p: &mut Program, base: Particle<Array, 2>, from_start: bool) -> Bars {
        let (at, mut sum, mut others) = (self.at(base), None, Vec::new());
        for (k, force) in self.forces.iter().enumerate() {
            match force.record_slopes(p, &at, &self.given.mechanics.forces[k], sum) {
                Some(tensions) => sum = Some(tensions),
                None => others.push(k),
            }
        }
        let tensions = sum.expect("every robot has springs");
        let linear = Linear {
            dt: at.dt,
            softening: at.softening,
            lead: if from_start { 1.0 } else { 0.0 },
        };
        let [jx, jy, slopes @ ..] = p.map_each_edge(
            at.graph,
            linear,
            both(base.x, base.v),
            &tensions.array(),
            &[],
        );
        Bars {
            impulse: Vector::new([jx, jy]),
            slopes,
            others,
        }
    }

    /// The impulses on all nodes (N s), if their velocities differ by `change` from the base: those of the bars, then those
    /// of forces that do not act along bars.
    fn impulses(
        &self,
        p: &mut Program,
        base: Particle<Array, 2>,
        bars: &Bars,
        change: Vector<Array, 2>,
    ) -> Vector<Array, 2> {
        let ([jx, jy], [xx, xy, yy]) = (bars.impulse.array(), bars.slopes);
        let per_edge = [jx, jy, xx, xy, yy];
        let of_bars = p.map_edges(self.step.graph, Impulse, change.array(), &per_edge, &[]);
        let at = self.at(base);
        (bars.others.iter()).fold(Vector::new(of_bars), |sum, &k| {
            let own = self.forces[k].record(p, &at, &self.given.mechanics.forces[k]);
            self::sum(p, sum, Vector::new(own.array()))
        })
    }

    /// Decides which nodes are held in a pass that begins with the velocity `moving`. Returns the contacts, and the change
    /// of velocity that brings held nodes to the ground. `none` is a zero for every node.
    fn contacts(
        &self,
        p: &mut Program,
        [grip, none]: [Array; 2],
        moving: Vector<Array, 2>,
        before: Option<&Pass>,
    ) -> (NodeContacts<Array>, Vector<Array, 2>) {
        let (v, dt) = (self.nodes().v, self.step.dt);
        let before = before.and_then(|pass| Some((pass, pass.contacts?)));
        let last = before.map_or([none; 2], |(_, contacts)| {
            [contacts.ground.segment, contacts.is_held]
        });
        let ground = self.ground(p, moving, last);
        let ([vx, vy, wx, wy], [tx, ty]) = (both(v, moving), ground.tangent.array());
        let node = [vx, vy, wx, wy, ground.is_new, tx, ty, ground.height];
        let Some((pass, contacts)) = before else {
            let first = p.map(FirstPass { dt }, node, &[grip]);
            let [sticks, impact, slip, ex, ey] = first;
            let contacts = NodeContacts {
                ground,
                is_held: ground.is_new,
                sticks,
                impact,
                slip,
                drag: none,
                slid: none,
            };
            return (contacts, Vector::new([ex, ey]));
        };
        let [vx, vy, wx, wy, is_new, tx, ty, height] = node;
        let ([jx, jy], [xx, xy, yy]) = (pass.reaction.array(), pass.of_bars);
        let node = [
            vx,
            vy,
            wx,
            wy,
            is_new,
            tx,
            ty,
            height,
            self.step.inverse_mass,
            contacts.is_held,
            contacts.sticks,
            contacts.ground.is_new,
            contacts.impact,
            contacts.slip,
            jx,
            jy,
            xx,
            xy,
            yy,
        ];
        let next = p.map(NextPass { dt }, node, &[grip]);
        let [is_held, sticks, impact, slip, drag, slid, ex, ey] = next;
        let contacts = NodeContacts {
            ground,
            is_held,
            sticks,
            impact,
            slip,
            drag,
            slid,
        };
        (contacts, Vector::new([ex, ey]))
    }

    /// Finds the ground below every node. `last` has the segment and `is_held` of the pass before.
    fn ground(
        &self,
        p: &mut Program,
        moving: Vector<Array, 2>,
        last: [Array; 2],
    ) -> GroundBelow<Array> {
        let ([x, y, wx, wy], [segment, is_held]) = (both(self.nodes().x, moving), last);
        let (node, dt) = ([x, y, wx, wy, segment, is_held], self.step.dt);
        let [segment, is_new, tx, ty, height] = match self.terrain.cloned() {
            None => p.map(FindGround { ground: Flat, dt }, node, &[]),
            Some(ground) => p.map(FindGround { ground, dt }, node, &[]),
        };
        GroundBelow {
            segment,
            is_new,
            tangent: Vector::new([tx, ty]),
            height,
        }
    }

    /// Solves for the velocities. The vectors are the base, the velocity without bars, the impulses and the change of held
    /// nodes. Returns the change of velocity that is left.
    fn solve(
        &self,
        p: &mut Program,
        [base, free, impulses, change]: [Vector<Array, 2>; 4],
        contacts: Option<&NodeContacts<Array>>,
        bars: &Bars,
    ) -> Vector<Array, 2> {
        let graph = self.step.graph;
        let Some(contacts) = contacts else {
            let balance = self.balance(base, free, impulses);
            let [bx, by, block @ ..] = p.map(FreeEquation, balance, &[]);
            return Vector::new(p.solve(graph, &block, &bars.slopes, &[], [bx, by]));
        };
        let [vx, vy, fx, fy, jx, jy, inverse_mass] = self.balance(base, free, impulses);
        let ([ex, ey], [tx, ty]) = (change.array(), contacts.ground.tangent.array());
        let node = [
            ex,
            ey,
            vx,
            vy,
            fx,
            fy,
            jx,
            jy,
            inverse_mass,
            tx,
            ty,
            contacts.is_held,
            contacts.sticks,
            contacts.slip,
            contacts.drag,
        ];
        let [bx, by, xx, xy, yy, held @ ..] = p.map(Equation, node, &[]);
        Vector::new(p.solve(graph, &[xx, xy, yy], &bars.slopes, &held, [bx, by]))
    }

    /// Records the end of the step: nodes move with the velocity of the last pass.
    fn land(&self, p: &mut Program, last: &Pass) -> Particle<Array, 2> {
        let (x, moving, dt) = (self.nodes().x, last.moving, self.step.dt);
        let Some(contacts) = last.contacts else {
            return Particle {
                x: Vector::new(p.map(NewPosition(dt), both(x, moving), &[])),
                v: moving,
            };
        };
        let [x, y, wx, wy] = both(x, moving);
        let node = [
            x,
            y,
            wx,
            wy,
            contacts.ground.segment,
            contacts.is_held,
            contacts.sticks,
            contacts.slip,
            contacts.slid,
        ];
        let (contact, terrain) = (self.contact, self.terrain);
        let end = contact.land(p, dt, terrain, node, &self.given.mechanics.contact);
        in_plane(end)
    }
}

/// The nodes of a planar robot.
fn in_plane(nodes: Motion) -> Particle<Array, 2> {
    Particle {
        x: Vector::new(nodes.x.array()),
        v: Vector::new(nodes.v.array()),
    }
}

/// Records the sum of two vectors of each node.
fn sum(p: &mut Program, a: Vector<Array, 2>, b: Vector<Array, 2>) -> Vector<Array, 2> {
    Vector::new(add(p, Some(a.array().into()), b.array().into()).array())
}

/// The components of two vectors, one after the other.
fn both(a: Vector<Array, 2>, b: Vector<Array, 2>) -> [Array; 4] {
    let ([ax, ay], [bx, by]) = (a.array(), b.array());
    [ax, ay, bx, by]
}

/// The kernel of the velocity without bars: damping, then the velocity that gravity adds. The uniform inputs are those of a
/// [`Push`].
struct FreeVelocity;

#[kernel]
impl Kernel<2, 2> for FreeVelocity {
    const UNIFORMS: usize = Push::<f64, 2>::COUNT;

    fn eval<R: Real>(&self, v: [R; 2], push: &[R]) -> [R; 2] {
        let Push { gravity, decay } = Push::<R, 2>::of(push);
        Vector::new(v).fma(decay, gravity).array()
    }
}

/// The kernel of a position after a step of this duration (s), from the position and the velocity in the step.
struct NewPosition(f64);

#[kernel]
impl Kernel<4, 2> for NewPosition {
    fn eval<R: Real>(&self, node: [R; 4], _: &[R]) -> [R; 2] {
        let (node, _) = Particle::<R, 2>::split(&node);
        node.after(R::lit(self.0)).x.array()
    }
}

/// The kernel of the mean of two vectors.
struct Mean;

#[kernel]
impl Kernel<4, 2> for Mean {
    fn eval<R: Real>(&self, [vx, vy, wx, wy]: [R; 4], _: &[R]) -> [R; 2] {
        // A closure in a `map` would not be inlined, so its instructions would be calls.
        let half = R::lit(0.5);
        [half * (vx + wx), half * (vy + wy)]
    }
}

/// The kernel of a node's mass (kg) and its change of velocity by an impulse, from the impulse (N s) and 1 / mass.
struct PerMass;

#[kernel]
impl Kernel<3, 3> for PerMass {
    fn eval<R: Real>(&self, [jx, jy, inverse_mass]: [R; 3], _: &[R]) -> [R; 3] {
        [inverse_mass.recip(), jx * inverse_mass, jy * inverse_mass]
    }
}

/// The kernel that subtracts a mean velocity from the velocity of a node, unless some node is held: then the mean of
/// `is_held`, the last input, is above 0.
struct SubtractMean;

#[kernel]
impl Kernel<5, 2> for SubtractMean {
    fn eval<R: Real>(&self, [wx, wy, ax, ay, is_held]: [R; 5], _: &[R]) -> [R; 2] {
        let (moving, mean) = (Vector::new([wx, wy]), Vector::new([ax, ay]));
        let holds = R::zero().less(is_held);
        Vector::select(holds, moving, moving - mean).array()
    }
}
