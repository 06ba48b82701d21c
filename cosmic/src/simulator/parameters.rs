//! What a robot's steps are given and none of them changes.

/// The parameters of a robot's steps, which no step changes: arrays and matrices of a program, or
/// the numbers in them.
pub(super) struct Parameters<A, M = A> {
    /// Stiffness of the edge in every slot of the graph, N/m.
    pub(super) stiffness: A,
    /// Rest length of the edge in every slot, m.
    pub(super) rest_length: A,
    /// Strain at full activation of the edge in every slot.
    pub(super) strain: A,
    /// 1 / mass of every node, 1/kg.
    pub(super) inverse_mass: A,
    /// The source of the activations.
    pub(super) drive: Drive<A, M>,
    /// For each force, the arrays that it wants.
    pub(super) constants: Vec<Vec<A>>,
}

/// The source of a robot's activations.
pub(super) enum Drive<A, M = A> {
    /// No activations: no edge has an actuator.
    Idle,
    /// A controller.
    Network(Network<A, M>),
    /// Activations that stay constant, one per slot of the graph.
    Held(A),
}

/// The folded controller: of its first layer the sensed columns, of its
/// second the rows of the actuators.
pub(super) struct Network<A, M = A> {
    pub(super) w1: M,
    pub(super) b1: A,
    pub(super) w2: M,
    pub(super) b2: A,
}

impl<T> Parameters<T> {
    /// All of them, in the order in which a robot declares them.
    pub(super) fn in_order(self) -> Vec<T> {
        let each = [
            self.stiffness,
            self.rest_length,
            self.strain,
            self.inverse_mass,
        ];
        let drive = match self.drive {
            Drive::Idle => Vec::new(),
            Drive::Network(n) => vec![n.w1, n.b1, n.w2, n.b2],
            Drive::Held(activation) => vec![activation],
        };
        let rest = self.constants.into_iter().flatten();
        each.into_iter().chain(drive).chain(rest).collect()
    }
}
