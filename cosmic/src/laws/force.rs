//! Forces on nodes: the terms of the push in a step.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Kernel, Program, Pullback};

use super::along_bars::AlongBars;
use super::law::{Law, StepInput};
use super::pose::{ForceParameters, Pose, Pull, Step};
use super::slopes::Tensions;
use super::stiffness::Stiffness;
use crate::geometry::Axes;
use crate::kernel;
use crate::lattice::Lattice;
use crate::settings::Settings;

/// A force on the nodes of one lattice.
///
/// Most forces act on [every node](super::NodeForce) or along [every bar](super::BarForce). Any other force implements
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

    /// This force as a force along bars; `None` if it is of another kind. An implicit step takes the impulses of other kinds
    /// from [`record`](Force::record), as if they did not change during the step.
    fn along_bars(&self) -> Option<&dyn AlongBars> {
        None
    }

    /// The forces on a node: one entry for each part of this force that acts on the node. Messages about robots that fly
    /// apart name the part with the largest force. The default has the force of every bar, and nothing for forces of another
    /// kind.
    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        (self.along_bars()).map_or_else(Vec::new, |bars| bars.pulls(pose, node))
    }

    /// The potential energy of this force in a pose, J; `None` if the force has none. The default is that of all bars.
    fn energy(&self, pose: &Pose) -> Option<f64> {
        self.along_bars()?.energy_of_all(pose)
    }

    /// The derivatives of the force at a pose, which determine the stable time step. By default, forces along bars take
    /// them from the derivatives of the tension. `None`, the default for other kinds, takes them from
    /// [`record`](Force::record), with the memory and the time of a matrix of all nodes.
    ///
    /// Override this method for a force that is stiffer in later poses, such as a contact that has not begun, or for large
    /// lattices. The result must not be smaller than the derivatives of what is recorded.
    fn stiffness(&self, pose: &Pose) -> Option<Stiffness> {
        Some(self.along_bars()?.stiffness(pose))
    }

    /// An upper bound, valid for every design, on what this force adds to a squared frequency, 1/s^2. `of_node` is the
    /// largest squared frequency of a single node that is held only by its bars (1/s^2); `shortest` is the length of
    /// the shortest bar (m), and `lightest` the smallest mass that a node may have (kg). Forces on single nodes return 0,
    /// because [`stiffness`](Force::stiffness) already reports what they add.
    fn any_design(&self, _of_node: f64, _shortest: f64, _lightest: f64) -> f64 {
        0.0
    }
}

/// A force law with its settings, as a trait object.
pub(crate) trait AnyForce: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn settings(&mut self) -> &mut dyn Settings;
    fn boxed(&self) -> Box<dyn AnyForce>;
    fn any(&self) -> &dyn Any;
    /// Prepares this law for a lattice. Returns the force, or `None` if the law has nothing to act on.
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>>;
}

/// A law for a force that acts neither on single nodes nor along single bars. The law finds the nodes and bars of a lattice
/// that its force acts on. [`on_lattice`](super::on_lattice) makes it a law that scenes choose by
/// `physics.forces = ["its_name"]`, with its settings in the section `[its_name]`.
pub trait LatticeForce: Law {
    /// Prepares this law for a lattice. Returns the force, or `None` if the law has nothing to act on.
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>>;
}

impl<L: LatticeForce> AnyForce for L {
    fn name(&self) -> &'static str {
        L::NAME
    }
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }
    fn boxed(&self) -> Box<dyn AnyForce> {
        Box::new(self.clone())
    }
    fn any(&self) -> &dyn Any {
        self
    }
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        LatticeForce::on(self, lattice)
    }
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

/// Records the tension of every bar with its slopes: the sum over all forces along bars.
pub(crate) fn tensions(
    p: &mut Program,
    step: &Step,
    forces: &[Arc<dyn Force>],
    given: &[ForceParameters<Array>],
) -> Tensions {
    let forces = forces.iter().zip(given);
    let bars = forces.filter_map(|(force, given)| Some((force.along_bars()?, given)));
    let sum = bars.fold(None, |before: Option<[Array; 3]>, (bars, given)| {
        let own = bars.record_tensions(p, step, given).array();
        Some(match before {
            Some(before) => [0, 1, 2].map(|k| p.map(Sum, [before[k], own[k]], &[])[0]),
            None => own,
        })
    });
    sum.expect("every robot has springs").into()
}
