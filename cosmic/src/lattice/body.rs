//! What a rollout does not change.

/// The robot as the simulator sees it; a rollout does not change it.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<R> {
    /// Stiffness per edge, N/m.
    pub stiffness: Vec<R>,
    /// Relative change of length per edge at full activation (D8).
    pub strain: Vec<R>,
    /// Mass per node, kg.
    pub mass: Vec<R>,
    /// How much each node belongs to the robot, from 0 to 1: that much it counts in the mean position, and
    /// is observed. Empty if all nodes do.
    pub presence: Vec<R>,
}

impl<R: Copy> Body<R> {
    /// The same body with every number replaced by a function of it.
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
