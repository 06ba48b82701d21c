//! [`Robot`]: a robot in its surroundings. [`Variation`]: how it differs from its design and from the scene.

use std::sync::Arc;

use autodiff::{Parameters, Real};

use super::surroundings::Surroundings;
use crate::lattice::{Body, State};
use crate::policy::{Controller, Goals};

/// A robot in its surroundings, at the start of a [walk](super::World::run). A batch is a slice of robots. What they share is an
/// [`Arc`]: robots that share a controller walk together in SIMD lanes, and what all robots of a batch share is computed once.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Robot<R> {
    /// Stiffnesses, strains and masses.
    pub body: Arc<Body<R>>,
    /// The controller, or the activations themselves ([`Controller::given`]).
    pub controller: Arc<Controller<R>>,
    /// Gravity, friction, the settings of laws, and the goals.
    pub surroundings: Arc<Surroundings<R>>,
    /// Initial positions and velocities in the world's frame.
    pub start: State<R>,
}

impl<R: Real> Robot<R> {
    /// This robot from another start.
    #[must_use]
    pub fn from(&self, start: &State<R>) -> Self {
        Self {
            start: start.clone(),
            ..self.clone()
        }
    }

    /// This robot with these surroundings.
    #[must_use]
    pub fn in_surroundings(self, surroundings: impl Into<Arc<Surroundings<R>>>) -> Self {
        Self {
            surroundings: surroundings.into(),
            ..self
        }
    }

    /// This robot with these goals in place of those before.
    ///
    /// # Panics
    /// Like [`Surroundings::with_goals`].
    #[must_use]
    pub fn with_goals(self, goals: Goals<R>) -> Self {
        let surroundings = (*self.surroundings).clone().with_goals(goals);
        self.in_surroundings(surroundings)
    }

    /// True if the other robot can walk in the same lanes: the two have the same step, and they share one controller, or both
    /// have given activations.
    pub(super) fn walks_with(&self, other: &Self) -> bool {
        let share = Arc::ptr_eq(&self.controller, &other.controller);
        (share || self.controller.activations().is_some()) && self.steps_like(other)
    }

    /// True if the other robot has the same step: both have a policy, or both have given activations; their goals change at
    /// the same steps; and they have the same largest strain.
    pub(super) fn steps_like(&self, other: &Self) -> bool {
        let [own, of_other] = [self, other].map(|robot| robot.controller.activations().is_some());
        own == of_other
            && self.surroundings.change_with(&other.surroundings)
            && self.body.largest_strain == other.body.largest_strain
    }
}

/// One for each robot, or a single one if all robots share it.
pub(super) fn shared<T>(of_robots: impl Iterator<Item = Arc<T>>) -> Vec<Arc<T>> {
    let mut all: Vec<Arc<T>> = of_robots.collect();
    if all.windows(2).all(|pair| Arc::ptr_eq(&pair[0], &pair[1])) {
        all.truncate(1);
    }
    all
}

/// How a robot and its surroundings differ from the design and from the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Variation {
    /// The factor on the stiffness of each edge. Empty for a robot with the stiffnesses of its design.
    pub stiffness: Vec<f64>,
    /// The factor on the mass of each node. Empty for a robot with the masses of its design.
    pub mass: Vec<f64>,
    /// The numbers of the surroundings.
    pub surroundings: Arc<Surroundings<f64>>,
    /// Initial positions and velocities.
    pub start: State<f64>,
}

impl Variation {
    /// True if the robot is built as designed.
    pub(super) fn is_as_designed(&self) -> bool {
        self.stiffness.is_empty() && self.mass.is_empty()
    }
}
