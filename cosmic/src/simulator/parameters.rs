//! The parameters of a robot's steps: numbers that no step changes.

use autodiff::{Array, Program, Real};

use super::surroundings::Surroundings;
use crate::lattice::Body;
use crate::laws::{Given, Particle};

/// The parameters of a robot's steps, without those of its policy.
pub(super) struct Parameters<A> {
    /// Stiffness of the edge in every slot of the graph, N/m.
    pub(super) stiffness: A,
    /// Rest length of the edge in every slot, m.
    pub(super) rest_length: A,
    /// Strain at full activation of the edge in every slot.
    pub(super) strain: A,
    /// 1 / mass of every node, 1/kg.
    pub(super) inverse_mass: A,
    /// How much every node belongs to the robot; `None` if all nodes belong to it.
    pub(super) presence: Option<A>,
    /// Activations that stay constant, one per slot of the graph, in place of a policy.
    pub(super) held: Option<A>,
    /// The nodes that the policy sees in place of the current ones.
    pub(super) seen: Option<Particle<A>>,
    /// The velocity that gravity adds, m/s, then the settings of the contact law: an array of one number each.
    pub(super) contact: Vec<A>,
    /// What each force declares.
    pub(super) forces: Vec<Given<A>>,
}

/// The robot describes its parameters once, to a `Road`: a [`Program`] declares arrays for them, and [`Filled`] collects
/// their numbers.
pub(super) trait Road {
    type Number: Real;
    type Array;

    /// An array of `len` numbers that depend on the body.
    fn of_body(
        &mut self,
        len: usize,
        numbers: impl Fn(&Body<Self::Number>) -> Vec<Self::Number>,
    ) -> Self::Array;

    /// An array of one number, which depends on the surroundings.
    fn of_surroundings(
        &mut self,
        number: impl Fn(&Surroundings<Self::Number>) -> Self::Number,
    ) -> Self::Array;

    /// An array of `len` numbers that each start is given.
    fn of_start(&mut self, len: usize) -> Self::Array;

    /// An array of numbers that all robots share.
    fn shared(&mut self, numbers: &[f64]) -> Self::Array;
}

/// Declares the parameters of a program.
impl<R: Real> Road for Program<R> {
    type Number = R;
    type Array = Array;

    fn of_body(&mut self, len: usize, _: impl Fn(&Body<R>) -> Vec<R>) -> Array {
        self.parameter(len)
    }
    fn of_surroundings(&mut self, _: impl Fn(&Surroundings<R>) -> R) -> Array {
        self.parameter(1)
    }
    fn of_start(&mut self, len: usize) -> Array {
        self.parameter(len)
    }
    fn shared(&mut self, numbers: &[f64]) -> Array {
        self.parameter(numbers.len())
    }
}

/// The numbers of the parameters, in the order of declaration. For each parameter, one list per robot, or one list that
/// all robots share.
pub(super) struct Filled<'a, R> {
    pub(super) bodies: &'a [Body<R>],
    pub(super) surroundings: &'a [Surroundings<R>],
    /// The numbers that each start is given.
    pub(super) of_starts: Vec<Vec<R>>,
    pub(super) numbers: Vec<Vec<Vec<R>>>,
}

impl<R: Real> Road for Filled<'_, R> {
    type Number = R;
    type Array = ();

    fn of_body(&mut self, _: usize, numbers: impl Fn(&Body<R>) -> Vec<R>) {
        self.numbers.push(self.bodies.iter().map(numbers).collect());
    }
    fn of_surroundings(&mut self, number: impl Fn(&Surroundings<R>) -> R) {
        let numbers = self.surroundings.iter().map(|s| vec![number(s)]);
        self.numbers.push(numbers.collect());
    }
    fn of_start(&mut self, _: usize) {
        self.numbers.push(std::mem::take(&mut self.of_starts));
    }
    fn shared(&mut self, numbers: &[f64]) {
        let numbers = numbers.iter().map(|&x| R::lit(x)).collect();
        self.numbers.push(vec![numbers]);
    }
}
