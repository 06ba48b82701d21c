//! A node in a pass of the implicit step, by name: what the kernels of `hold.rs` read and return. Yes is 1, and no is 0.

use autodiff::Real;
use autodiff_programs::Array;

use crate::Fields;
use crate::geometry::{Along, Symmetric, Vector};
use crate::laws::motion::{Motion, Particle};

/// The contacts of all nodes in a pass. Every field has a number for each node.
#[derive(Clone, Debug)]
pub(crate) struct NodeContacts<A> {
    pub(crate) ground: GroundBelow<A>,
    /// Whether the node is held: it cannot move into the ground or off it.
    pub(crate) is_held: A,
    /// Whether the node is also held along the ground.
    pub(crate) sticks: A,
    /// The time from the beginning of the step until the node meets the ground, s.
    pub(crate) impact: A,
    /// The mean velocity along the ground, m/s, of a node that stops there at the impact: one component, and in space a
    /// second one across.
    pub(crate) slip: Vec<A>,
    /// The drag of friction, kg: it gives the node the impulse `-drag (v - slip)` along the ground.
    pub(crate) drag: A,
    /// The speed, m/s, from which friction slows down a node that slid in the pass before; else 0.
    pub(crate) slid: A,
}

impl NodeContacts<Array> {
    /// What the kernel that ends a step reads. `moving` has the positions at the start of the step, and the velocities in it.
    pub(super) fn landing<const D: usize>(&self, moving: Motion) -> LandingNode<Array, D> {
        LandingNode {
            node: moving.particle(),
            segment: self.ground.segment,
            is_held: self.is_held,
            sticks: self.sticks,
            slip: Along::first_of(&self.slip),
            slid: self.slid,
        }
    }
}

/// The ground below a node in a pass.
#[derive(Clone, Copy, Debug, Fields)]
pub(crate) struct GroundBelow<T> {
    /// The number of the ground's segment that the node touches.
    pub(crate) segment: T,
    pub(crate) meeting: Meeting<T>,
}

/// How a node meets the segment of the ground that it touches.
#[derive(Clone, Copy, Debug, Fields)]
pub(crate) struct Meeting<T> {
    /// Whether the node meets the ground in this step and was not held before.
    pub(crate) is_new: T,
    /// The unit vector along the segment: its components forward and up, because a segment is inclined along the first axis.
    pub(crate) tangent: Vector<T, 2>,
    /// The height of the node above the segment, m.
    pub(crate) height: T,
}

/// A node, and the ground that it touched in the pass before.
#[derive(Clone, Copy, Fields)]
pub(crate) struct NodeAndGround<T, const D: usize> {
    /// The position, and the velocity in the step.
    pub(crate) node: Particle<T, D>,
    /// The number of the segment.
    pub(crate) segment: T,
    pub(crate) is_held: T,
}

/// A node at the beginning of a pass.
#[derive(Clone, Copy, Fields)]
pub(crate) struct NodeInPass<T, const D: usize> {
    /// The velocity at the start of the step, m/s.
    pub(crate) v: Vector<T, D>,
    /// The velocity in the pass before, m/s; in the first pass, the velocity with which the node would move without bars.
    pub(crate) moving: Vector<T, D>,
    pub(crate) meeting: Meeting<T>,
}

/// What the first pass decides about a node.
#[derive(Clone, Copy, Fields)]
pub(crate) struct FirstContact<T, const D: usize> {
    pub(crate) sticks: T,
    /// The time of impact, s.
    pub(crate) impact: T,
    /// The slip, m/s.
    pub(crate) slip: Along<T, D>,
    /// The change of velocity, m/s, if the node is held.
    pub(crate) change: Vector<T, D>,
}

impl<const D: usize> FirstContact<Array, D> {
    /// The contacts of all nodes in the first pass. `none` is a zero for every node.
    pub(crate) fn contacts(self, ground: GroundBelow<Array>, none: Array) -> NodeContacts<Array> {
        NodeContacts {
            ground,
            is_held: ground.meeting.is_new,
            sticks: self.sticks,
            impact: self.impact,
            slip: self.slip.list(),
            drag: none,
            slid: none,
        }
    }
}

/// A node at the beginning of a later pass, with what the pass before decided about it.
#[derive(Clone, Copy, Fields)]
pub(crate) struct NodeInNextPass<T, const D: usize> {
    pub(crate) now: NodeInPass<T, D>,
    /// 1 / mass, 1/kg.
    pub(crate) inverse_mass: T,
    pub(crate) was_held: T,
    pub(crate) stuck: T,
    pub(crate) was_new: T,
    /// The time of impact, s.
    pub(crate) impact: T,
    /// The slip, m/s.
    pub(crate) slip: Along<T, D>,
    /// The impulse that the ground gave the node, N s.
    pub(crate) reaction: Vector<T, D>,
    /// The node's block of the matrix of bars in the first pass, kg.
    pub(crate) bars: Symmetric<T, D>,
}

/// What a later pass decides about a node.
#[derive(Clone, Copy, Fields)]
pub(crate) struct NextContact<T, const D: usize> {
    pub(crate) is_held: T,
    pub(crate) sticks: T,
    /// The time of impact, s.
    pub(crate) impact: T,
    /// The slip, m/s.
    pub(crate) slip: Along<T, D>,
    /// The drag of friction, kg.
    pub(crate) drag: T,
    /// The speed from which friction slows the node down, m/s.
    pub(crate) slid: T,
    /// The change of velocity, m/s, if the node is held.
    pub(crate) change: Vector<T, D>,
}

impl<const D: usize> NextContact<Array, D> {
    /// The contacts of all nodes in a later pass.
    pub(crate) fn contacts(self, ground: GroundBelow<Array>) -> NodeContacts<Array> {
        NodeContacts {
            ground,
            is_held: self.is_held,
            sticks: self.sticks,
            impact: self.impact,
            slip: self.slip.list(),
            drag: self.drag,
            slid: self.slid,
        }
    }
}

/// A node while the velocities are solved for.
#[derive(Clone, Copy, Fields)]
pub(crate) struct HeldNode<T, const D: usize> {
    /// The change of velocity, m/s, if the node is held.
    pub(crate) change: Vector<T, D>,
    /// The velocity at the base of the linearisation, m/s.
    pub(crate) base: Vector<T, D>,
    /// The velocity without bars, m/s.
    pub(crate) free: Vector<T, D>,
    /// The impulse of the forces, N s.
    pub(crate) impulse: Vector<T, D>,
    /// 1 / mass, 1/kg.
    pub(crate) inverse_mass: T,
    /// The tangent of the ground.
    pub(crate) tangent: Vector<T, 2>,
    pub(crate) is_held: T,
    pub(crate) sticks: T,
    /// The slip, m/s.
    pub(crate) slip: Along<T, D>,
    /// The drag of friction, kg.
    pub(crate) drag: T,
}

/// The equation of a node's velocity.
#[derive(Clone, Copy, Fields)]
pub(crate) struct NodeEquation<T, const D: usize> {
    /// The right-hand side, N s.
    pub(crate) right: Vector<T, D>,
    /// The node's block of the matrix, kg.
    pub(crate) block: Symmetric<T, D>,
}

/// The equation of the velocity of a node that may be held.
#[derive(Clone, Copy, Fields)]
pub(crate) struct HeldEquation<T, const D: usize> {
    pub(crate) equation: NodeEquation<T, D>,
    /// The projection onto the directions in which the node is held.
    pub(crate) held: Symmetric<T, D>,
}

/// A node with the impulses that change its velocity.
#[derive(Clone, Copy, Fields)]
pub(crate) struct Balance<T, const D: usize> {
    /// The velocity in the step, m/s.
    pub(crate) moving: Vector<T, D>,
    /// The velocity without bars, m/s.
    pub(crate) free: Vector<T, D>,
    /// The impulse of the forces, N s.
    pub(crate) impulse: Vector<T, D>,
    /// 1 / mass, 1/kg.
    pub(crate) inverse_mass: T,
}

impl<R: Real, const D: usize> Balance<R, D> {
    /// The impulse that the forces do not explain, N s.
    #[inline(always)]
    pub(super) fn residual(self) -> Vector<R, D> {
        (self.moving - self.free) / self.inverse_mass - self.impulse
    }
}

/// A node at the end of a step. The fields after the node are those of [`NodeContacts`].
#[derive(Clone, Copy, Fields)]
pub(crate) struct LandingNode<T, const D: usize> {
    /// The position at the start of the step, and the velocity in the step.
    pub(crate) node: Particle<T, D>,
    pub(crate) segment: T,
    pub(crate) is_held: T,
    pub(crate) sticks: T,
    pub(crate) slip: Along<T, D>,
    pub(crate) slid: T,
}
