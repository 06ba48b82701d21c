//! The type [`Trajectory`], which has the observed states of a rollout, and the test whether a state is absurd.

use autodiff::{Parameters, Real};

use super::effort::{Effort, Efforts};
use crate::geometry::Vector;
use crate::lattice::{Body, Marker, State};
use crate::policy::Goals;

/// The smallest absurd value: a state is absurd if a component of a position (m) or of a velocity (m/s) has this
/// absolute value or more.
const ABSURD: f64 = 1e6;
/// The limit on the components of states in a watched rollout. It is smaller than [`ABSURD`], because these states are
/// checked in the ground's frame, which may be rotated relative to the world's frame.
pub(super) const WATCHED: f64 = 0.5 * ABSURD;

/// The observed states of a rollout, in the world's frame.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Trajectory<R> {
    /// The number of steps before each state, ascending. A state with 0 steps before it is the start.
    pub steps: Vec<usize>,
    /// The states: one for each entry of `steps`.
    pub states: Vec<State<R>>,
    /// The point whose displacement counts.
    pub marker: Marker<R>,
    /// The positions of the nodes at the start of the rollout. Empty if the marker is the payload, which does not need
    /// them.
    pub start: Vec<Vector<R>>,
    /// The goals of the robot, which change after a number of steps of this rollout; `None` if the goal is a number of the
    /// controller.
    pub goals: Option<Goals<R>>,
    /// Activations, forces and work of the bars; `None` unless the loss [reads them](crate::objective::Loss::reads_efforts).
    pub efforts: Option<Efforts<R>>,
}

/// The position and the velocity of the payload in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PayloadState<R> {
    /// The position, in metres.
    pub x: Vector<R>,
    /// The velocity, in m/s.
    pub v: Vector<R>,
}

impl<R> Trajectory<R> {
    /// A trajectory whose marker is node 0. `steps` has the number of steps before each state.
    pub fn new(steps: Vec<usize>, states: Vec<State<R>>) -> Self {
        Self {
            steps,
            states,
            marker: Marker {
                payload: 0,
                weights: Vec::new(),
            },
            start: Vec::new(),
            goals: None,
            efforts: None,
        }
    }

    /// The number of steps before the last state.
    ///
    /// # Panics
    /// If the trajectory is empty.
    pub fn last_step(&self) -> usize {
        *self
            .steps
            .last()
            .expect("a trajectory must have at least one state")
    }

    /// The observed state after this number of steps.
    ///
    /// # Panics
    /// If that state was not observed. A loss declares beforehand which states it observes.
    pub fn at(&self, step: usize) -> &State<R> {
        &self.states[self.index(step)]
    }

    /// The robot to which the [efforts](Self::efforts) belong: its stiffnesses, strains and masses.
    ///
    /// # Panics
    /// If the loss does not declare that it reads efforts.
    pub fn robot(&self) -> &Body<R> {
        &self.metered().body
    }

    /// The efforts of the bars in the step that ends at the observed state after this number of steps.
    ///
    /// # Panics
    /// If that state was not observed, or if the loss does not declare that it reads efforts.
    pub fn effort(&self, step: usize) -> &Effort<R> {
        &self.metered().of_states[self.index(step)]
    }

    fn metered(&self) -> &Efforts<R> {
        let efforts = self.efforts.as_ref();
        efforts.expect("a loss that reads efforts must return true in `reads_efforts`")
    }

    fn index(&self, step: usize) -> usize {
        match self.steps.binary_search(&step) {
            Ok(index) => index,
            Err(_) => panic!(
                "the state after {step} steps was not observed; the observed steps are {:?}",
                self.steps
            ),
        }
    }
}

impl<R: Copy> Trajectory<R> {
    /// This trajectory if `finer` of its steps count as one. All its states must lie at the end of such a longer step.
    pub(crate) fn in_longer_steps(mut self, finer: usize) -> Self {
        self.steps.iter_mut().for_each(|step| *step /= finer);
        if let Some(goals) = &mut self.goals {
            goals.later.iter_mut().for_each(|(step, _)| *step /= finer);
        }
        if let Some(efforts) = &mut self.efforts {
            efforts.dt *= finer as f64;
        }
        self
    }
}

impl<R: Real> Trajectory<R> {
    /// The position and the velocity of the payload in the observed state `k`, which is `states[k]`. The lattice decides
    /// which node is the payload; it need not be node 0. States always have this node, whatever a loss returns in
    /// [`nodes`](crate::objective::Loss::nodes).
    ///
    /// # Panics
    /// If there are not so many observed states.
    pub fn payload(&self, k: usize) -> PayloadState<R> {
        let (state, node) = (&self.states[k], self.marker.payload);
        PayloadState {
            x: state.x[node],
            v: state.v[node],
        }
    }

    /// The position of the [marker](Marker) after this number of steps, in metres: the position that losses for
    /// distance read.
    ///
    /// # Panics
    /// If that state was not observed.
    pub fn position(&self, step: usize) -> Vector<R> {
        self.marker.place(&self.start, self.at(step))
    }

    /// The velocity of the [marker](Marker) after this number of steps, in m/s.
    ///
    /// # Panics
    /// If that state was not observed.
    pub fn velocity(&self, step: usize) -> Vector<R> {
        self.marker.velocity(self.at(step))
    }
}

/// The nodes with presence 0, each with the position at which it stays. No bar pulls on these nodes, and the controller
/// does not see them. In the simulation they fall, so they are put back afterwards.
pub(super) struct AbsentNodes<R>(Vec<(usize, Vector<R>)>);

impl<R: Real> AbsentNodes<R> {
    pub(super) fn of(body: &Body<R>, start: &State<R>) -> Self {
        let nodes = body.presence.iter().zip(&start.x).enumerate();
        // The primal decides, so that forward and reverse mode see the same robot as plain numbers do.
        let still = nodes.filter(|(_, (presence, _))| presence.primal() == 0.0);
        Self(still.map(|(node, (_, x))| (node, *x)).collect())
    }

    /// Puts the nodes with presence 0 back to their positions, at rest. The state has all nodes, or
    /// only the first nodes.
    pub(super) fn held(&self, mut state: State<R>) -> State<R> {
        for &(node, x) in &self.0 {
            if node < state.x.len() {
                (state.x[node], state.v[node]) = (x, Vector::zero());
            }
        }
        state
    }
}

impl State<f64> {
    /// The first node that is absurd: one of its coordinates (m) or velocity components (m/s) is NaN, or has an
    /// absolute value of at least 1e6.
    pub fn absurd_node(&self) -> Option<usize> {
        // Comparisons with NaN are false, so a NaN is absurd too.
        let sane = |vector: &Vector<f64>| vector.array().iter().all(|c| c.abs() < ABSURD);
        let mut nodes = self.x.iter().zip(&self.v);
        nodes.position(|(x, v)| !(sane(x) && sane(v)))
    }

    /// The speed of every node, m/s.
    pub fn speeds(&self) -> impl Iterator<Item = f64> {
        self.v.iter().map(|v| v.norm())
    }

    /// The first node whose speed is above `bound` (m/s), with its speed (m/s).
    pub(crate) fn too_fast(&self, bound: f64) -> Option<(usize, f64)> {
        let mut speeds = self.speeds().enumerate();
        speeds.find(|(_, speed)| *speed > bound)
    }

    /// True if a node of this state is [absurd](State::absurd_node).
    pub fn is_absurd(&self) -> bool {
        self.absurd_node().is_some()
    }
}
