//! Forces: the terms of a step that push nodes.

use std::fmt::Debug;
use std::sync::Arc;

use autodiff::{AnyProgram, Array, Graph, Kernel, Pullback, Real};

use super::law::StepInput;
use super::motion::Particle;
use super::stiffness::Stiffness;
use crate::geometry::{Ground, Vector};
use crate::lattice::{Body, Lattice, State};
use crate::settings::Settings;

/// The arrays of a step when forces are taken. Vectors are in the ground's frame.
pub struct Step<'a, const D: usize = 2> {
    /// The edges, and the slots in which arrays along them lie.
    pub graph: &'a Graph,
    /// Positions (m) and velocities (m/s) of the nodes.
    pub nodes: Particle<Array, D>,
    /// 1 / mass of every node, 1/kg.
    pub inverse_mass: Array,
    /// The controller's output for every slot.
    pub activation: Array,
    /// Stiffness of the edge in every slot, N/m.
    pub stiffness: Array,
    /// Rest length of the edge in every slot, m.
    pub rest_length: Array,
    /// Strain at full activation of the edge in every slot.
    pub strain: Array,
    /// The time, s, for every node; there if a force [asks for it](Force::needs_time).
    pub time: Option<Array>,
    /// For how long the forces push, s.
    pub dt: f64,
    /// The unit vector against gravity.
    pub vertical: Vector<f64, D>,
}

/// A robot at an instant, in the ground's frame, for questions that are not asked in every step.
#[derive(Clone, Debug)]
pub struct Pose<'a, const D: usize = 2> {
    /// Nodes and edges.
    pub lattice: &'a Lattice<D>,
    /// Stiffness, strains and masses.
    pub body: &'a Body<f64>,
    /// Positions and velocities.
    pub state: State<f64, D>,
    /// The controller's output for every edge; empty for idle actuators.
    pub activation: &'a [f64],
    /// The time, s.
    pub time: f64,
    /// The unit vector against gravity.
    pub vertical: Vector<f64, D>,
}

impl<'a, const D: usize> Pose<'a, D> {
    /// A robot in a state of the world's frame, its actuators idle, at the start.
    pub fn idle(
        lattice: &'a Lattice<D>,
        body: &'a Body<f64>,
        state: &State<f64, D>,
        ground: &Ground,
    ) -> Self {
        Self {
            lattice,
            body,
            state: state.to_ground(ground),
            activation: &[],
            time: 0.0,
            vertical: ground.vertical(),
        }
    }
}

/// The force of a part of a law on one node.
#[derive(Clone, Debug)]
pub struct Pull<const D: usize = 2> {
    /// The part, as a sentence names it: "the spring of edge 3 [1, 2]".
    pub part: String,
    /// The force, N, in the ground's frame.
    pub force: Vector<f64, D>,
}

/// The parameters of a step that a force declares.
#[derive(Clone, Debug, Default)]
pub struct Given<A> {
    /// [`Force::constants`].
    pub constants: Vec<A>,
    /// [`Force::inputs`], each an array of one number: [uniform inputs](autodiff::arrays::Uniforms) of kernels.
    pub inputs: Vec<A>,
}

/// A force on the nodes of one lattice.
///
/// Most are a [force on every node](super::NodeForce) or [along every bar](super::BarForce). What
/// is neither implements this trait: `laws/bending.rs` is an example.
pub trait Force: Debug + Send + Sync {
    /// Arrays of numbers that no step changes, which [`record`](Force::record) is given.
    fn constants(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// The settings by which a rollout can be differentiated, and in which robots of one batch may differ.
    fn inputs(&self) -> Vec<StepInput> {
        Vec::new()
    }

    /// True if [`Step::time`] is read.
    fn needs_time(&self) -> bool {
        false
    }

    /// Records the impulses on all nodes over a step, N s: those of the forces before it, if there are
    /// any, plus its own.
    fn record(
        &self,
        p: &mut AnyProgram,
        step: &Step,
        given: &Given<Array>,
        before: Option<Vector<Array>>,
    ) -> Vector<Array>;

    /// The force of each part on a node.
    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull>;

    /// The force with which the bar of an edge pulls its ends together by this force, N.
    fn tension(&self, _pose: &Pose, _edge: usize) -> f64 {
        0.0
    }

    /// The potential energy, J, of which the force is the slope; `None` if it has none.
    fn energy(&self, pose: &Pose) -> Option<f64>;

    /// Adds the slopes of the force to those of a pose: they decide which time step is stable.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness);

    /// The stiffness of a bar, N/m, whose material has the stiffness `k`, where its length is off by
    /// so much from the target.
    fn bar_stiffness(&self, _k: f64, _rest_length: f64, _off: f64) -> f64 {
        0.0
    }

    /// A bound on the square of the frequencies, 1/s^2, that the force adds in any design: `of_node` is
    /// the largest that a node has by its bars alone, `shortest` the length of the shortest bar (m). What a
    /// force adds to single nodes is known from [`stiffen`](Force::stiffen).
    fn any_design(&self, _of_node: f64, _shortest: f64) -> f64 {
        0.0
    }
}

/// A force law with its settings, behind a pointer.
pub(crate) trait AnyForce: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn settings(&mut self) -> &mut dyn Settings;
    fn boxed(&self) -> Box<dyn AnyForce>;
    /// The force on a lattice; `None` if nothing is there for it to act on.
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>>;
}

/// A sum.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum;

impl Kernel<2, 1> for Sum {
    #[inline(always)]
    fn eval<R: Real>(&self, [a, b]: [R; 2]) -> [R; 1] {
        [a + b]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 1, M>) -> [[R; 2]; M] {
        self.emitted_vjp(at)
    }
}

/// Impulses and those before them.
pub(super) fn add<const D: usize>(
    p: &mut AnyProgram,
    before: Option<Vector<Array, D>>,
    impulses: Vector<Array, D>,
) -> Vector<Array, D> {
    let Some(before) = before else {
        return impulses;
    };
    before.zip_with(impulses, |before, impulse| p.map(Sum, [before, impulse])[0])
}
