//! The type [`Body`]: stiffnesses, strains and masses of a robot.

/// The numbers of a robot that stay constant during a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Body<R> {
    /// The stiffness of each edge, in N/m.
    pub stiffness: Vec<R>,
    /// For each edge, the relative change of its rest length at full activation (D8).
    pub strain: Vec<R>,
    /// The mass of each node, in kg.
    pub mass: Vec<R>,
    /// The presence of each node, from 0 to 1: its weight in the mean position and in the observation. A node without a
    /// bar has presence 0. Empty if all nodes have presence 1.
    pub presence: Vec<R>,
}

impl<R: Copy> Body<R> {
    /// A copy of the body with `f` applied to every number.
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
