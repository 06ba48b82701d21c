//! The numbers of a robot that do not change in a rollout.

/// The numbers of a robot that a rollout does not change.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<R> {
    /// The stiffness of each edge, in N/m.
    pub stiffness: Vec<R>,
    /// For each edge, the relative change of its rest length at full activation (D8).
    pub strain: Vec<R>,
    /// The mass of each node, in kg.
    pub mass: Vec<R>,
    /// How much each node belongs to the robot, from 0 to 1: its weight in the mean position and in the observation.
    /// Empty if all nodes belong to the robot.
    pub presence: Vec<R>,
}

impl<R: Copy> Body<R> {
    /// This body with `f` applied to every number.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> Body<S> {
        let each = |numbers: &[R]| numbers.iter().map(|&x| f(x)).collect();
        Body {
            stiffness: each(&self.stiffness),
            strain: each(&self.strain),
            mass: each(&self.mass),
            presence: each(&self.presence),
        }
    }
}
