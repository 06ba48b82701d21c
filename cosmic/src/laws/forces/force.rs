//! Forces on nodes: the terms of the push in a step.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Graph, Kernel, Program, Pullback};

use super::stiffness::Stiffness;
use crate::geometry::{Axes, Dimension, Ground, Vector};
use crate::kernel;
use crate::lattice::{Body, Lattice, State};
use crate::laws::bars::{EdgeNumbers, Tensions};
use crate::laws::law::{Law, StepInput};
use crate::laws::motion::Motion;
use crate::settings::Settings;

/// The arrays that a step computes forces from. Vectors are in the ground's frame.
pub struct Step<'a> {
    /// The edges. Each edge has a slot: its place in the arrays that have a number for every edge.
    pub graph: &'a Graph,
    /// Positions (m) and velocities (m/s) of the nodes.
    pub nodes: Motion,
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
    /// The time, s, for every node; `None` unless a force [needs it](Force::needs_time).
    pub time: Option<Array>,
    /// The duration of the push, s. A force gives the nodes its impulse over this time.
    pub dt: f64,
    /// The [softening](Lattice::softening) of lengths, m^2.
    pub softening: f64,
    /// The largest strain of the actuator material.
    pub largest_strain: f64,
    /// The unit vector opposite to gravity.
    pub vertical: Vector<f64>,
}

impl Step<'_> {
    /// Whether the robot moves in the plane or in space.
    pub fn dimension(&self) -> Dimension {
        self.nodes.dimension()
    }

    /// The arrays of the edges that a force along bars reads.
    pub(super) fn numbers(&self) -> EdgeNumbers<Array> {
        EdgeNumbers {
            activation: self.activation,
            stiffness: self.stiffness,
            rest_length: self.rest_length,
            strain: self.strain,
        }
    }
}

/// A robot at one moment, for computations that are not part of a step. Vectors are in the ground's frame.
#[derive(Clone, Debug)]
pub struct Pose<'a> {
    /// Nodes and edges.
    pub lattice: &'a Lattice,
    /// Stiffness, strains and masses.
    pub body: &'a Body<f64>,
    /// Positions and velocities.
    pub state: State<f64>,
    /// The controller's output for every edge; empty if the actuators are idle.
    pub activation: &'a [f64],
    /// The time, s.
    pub time: f64,
    /// The unit vector opposite to gravity.
    pub vertical: Vector<f64>,
}

impl<'a> Pose<'a> {
    /// The pose of a robot with idle actuators at time 0. `state` is in the world's frame.
    pub fn idle(
        lattice: &'a Lattice,
        body: &'a Body<f64>,
        state: &State<f64>,
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

/// The force that a part of a law, such as one spring, exerts on one node.
#[derive(Clone, Debug)]
pub struct Pull {
    /// The name of the part as a noun phrase, such as "the spring of edge 3 [1, 2]". Messages contain it.
    pub part: String,
    /// The force, N, in the ground's frame.
    pub force: Vector<f64>,
}

/// The arrays that a force gets in a step because it has declared them in [`Force::constants`] and [`Force::inputs`].
#[derive(Clone, Debug, Default)]
pub struct ForceParameters<A> {
    /// The arrays of [`Force::constants`].
    pub constants: Vec<A>,
    /// The numbers of [`Force::inputs`], each as an array of one number. Kernels take them as
    /// [uniform inputs](autodiff_programs::Kernel::UNIFORMS).
    pub inputs: Vec<A>,
}

/// A bar whose target is its rest length.
#[derive(Clone, Copy, Debug)]
pub struct RestingBar {
    /// The stiffness of the bar's material, N/m.
    pub stiffness: f64,
    /// The rest length, m.
    pub rest_length: f64,
    /// The length minus the target length, m.
    pub off: f64,
    /// The largest strain of the actuator material.
    pub largest_strain: f64,
}

/// A force on the nodes of one lattice.
///
/// Most forces act on [every node](crate::laws::NodeForce) or along [every bar](crate::laws::BarForce). Any other force implements
/// this trait, and its law is a [`LatticeForce`].
pub trait Force: Debug + Send + Sync {
    /// The arrays of constant numbers that this force needs in a step. [`record`](Force::record) gets them as
    /// [`ForceParameters::constants`].
    fn constants(&self) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// The settings of this force that are inputs of a step. A rollout can be differentiated with respect to them, and
    /// they may differ between the robots of a batch.
    fn inputs(&self) -> Vec<StepInput> {
        Vec::new()
    }

    /// True if [`record`](Force::record) reads [`Step::time`].
    fn needs_time(&self) -> bool {
        false
    }

    /// Records the impulses of this force on all nodes over a step (N s).
    fn record(&self, p: &mut Program, step: &Step, given: &ForceParameters<Array>) -> Axes<Array>;

    /// This force as tensions of bars. `None` if it does not act along bars: an implicit step then takes its impulses from
    /// [`record`](Force::record), as if they did not change during the step.
    fn along_bars(&self) -> Option<&dyn AlongBars> {
        None
    }

    /// The forces on a node: one entry for each part of this force that acts on the node. Messages about robots that fly
    /// apart name the part with the largest force.
    fn pulls(&self, _pose: &Pose, _node: usize) -> Vec<Pull> {
        Vec::new()
    }

    /// The potential energy of this force in a pose, J; `None` if the force has none.
    fn energy(&self, _pose: &Pose) -> Option<f64> {
        None
    }

    /// Adds the derivatives of the force at a pose to `stiffness`. They determine the stable time step.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness);

    /// An upper bound, valid for every design, on what this force adds to a squared frequency, 1/s^2. `of_node` is the
    /// largest squared frequency of a single node that is held only by its bars (1/s^2); `shortest` is the length of
    /// the shortest bar (m), and `lightest` the smallest mass that a node may have (kg). Forces on single nodes and along
    /// bars return 0, because [`stiffen`](Force::stiffen) and [`AlongBars`] report what they add.
    fn any_design(&self, _of_node: f64, _shortest: f64, _lightest: f64) -> f64 {
        0.0
    }
}

/// A [`Force`] that acts along bars.
pub trait AlongBars {
    /// Records the tension of every bar under this force alone, with its slopes.
    fn record_tensions(
        &self,
        p: &mut Program,
        step: &Step,
        given: &ForceParameters<Array>,
    ) -> Tensions;

    /// The tension of the bar of an edge under this force alone, N.
    fn tension(&self, pose: &Pose, edge: usize) -> f64;

    /// The stiffness of a bar under this force alone, N/m.
    fn stiffness(&self, bar: RestingBar) -> f64;

    /// The damping of a bar by this force alone, N s/m: the derivative of the tension with respect to the rate of the
    /// bar's length.
    fn damping(&self, bar: RestingBar) -> f64;
}

/// A law for a force that acts neither on single nodes nor along single bars. The law finds the nodes and bars of a lattice
/// that its force acts on. [`on_lattice`](crate::laws::on_lattice) makes it a law that scenes choose by
/// `physics.forces = ["its_name"]`, with its settings in the section `[its_name]`.
pub trait LatticeForce: Law {
    /// Prepares this law for a lattice. Returns the force, or `None` if the law has nothing to act on.
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>>;
}

/// A force law with its settings, as a trait object.
pub(crate) trait AnyForce: Any + Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn settings(&mut self) -> &mut dyn Settings;
    fn boxed(&self) -> Box<dyn AnyForce>;
    /// Prepares this law for a lattice. Returns the force, or `None` if the law has nothing to act on.
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>>;
}

/// A force law with its settings, and the way in which it becomes a force on a lattice.
#[derive(Clone, Debug)]
pub(crate) struct ForceLaw<L> {
    pub(crate) law: L,
    on: fn(&L, &Lattice) -> Option<Arc<dyn Force>>,
}

impl<L: Law> ForceLaw<L> {
    /// The law with its default settings.
    pub(super) fn boxed(on: fn(&L, &Lattice) -> Option<Arc<dyn Force>>) -> Box<dyn AnyForce> {
        let law = L::default();
        Box::new(Self { law, on })
    }
}

impl<L: Law> AnyForce for ForceLaw<L> {
    fn name(&self) -> &'static str {
        L::NAME
    }
    fn settings(&mut self) -> &mut dyn Settings {
        &mut self.law
    }
    fn boxed(&self) -> Box<dyn AnyForce> {
        Box::new(self.clone())
    }
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        (self.on)(&self.law, lattice)
    }
}

/// A law for any other force than those on single nodes or along single bars.
pub(crate) fn on_lattice<L: LatticeForce>() -> Box<dyn AnyForce> {
    ForceLaw::boxed(L::on)
}

/// A kernel that adds two numbers.
#[derive(Clone, Copy, Debug)]
pub struct Sum;

#[kernel]
impl Kernel<2, 1> for Sum {
    fn eval<R: Real>(&self, [a, b]: [R; 2], _: &[R]) -> [R; 1] {
        [a + b]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 2, 1, M>) -> [[R; 2]; M] {
        self.emitted_vjp(at)
    }
}

/// Records the sum of vectors at nodes, such as impulses: of `impulses` and of what came before, if there is any.
pub(crate) fn add(
    p: &mut Program,
    before: Option<Axes<Array>>,
    impulses: Axes<Array>,
) -> Axes<Array> {
    let Some(before) = before else {
        return impulses;
    };
    before.zip_with(impulses, |before, impulse| {
        p.map(Sum, [before, impulse], &[])[0]
    })
}

/// Records the tension of every bar, with its slopes: the sum over all forces along bars.
///
/// # Panics
/// If no force acts along bars.
pub(crate) fn tensions(
    p: &mut Program,
    step: &Step,
    forces: &[Arc<dyn Force>],
    given: &[ForceParameters<Array>],
) -> Tensions {
    let mut sum: Option<Tensions> = None;
    for (force, given) in forces.iter().zip(given) {
        let Some(force) = force.along_bars() else {
            continue;
        };
        let own = force.record_tensions(p, step, given);
        let mut add = |before, own| p.map(Sum, [before, own], &[])[0];
        sum = Some(match sum {
            Some(before) => Tensions {
                tension: add(before.tension, own.tension),
                by_length: add(before.by_length, own.by_length),
                by_rate: add(before.by_rate, own.by_rate),
            },
            None => own,
        });
    }
    sum.expect("every robot has springs")
}
