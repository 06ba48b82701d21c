//! The parameters of a robot's steps: the numbers that a step reads and that stay constant during a rollout.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Program};

use super::surroundings::Surroundings;
use crate::geometry::{Axes, Dimension};
use crate::lattice::Body;
use crate::laws::{ForceParameters, StepInput};
use crate::policy::Goals;

/// The parameters of a robot's steps, except the parameters of its policy. `A` is the type of an array.
pub(super) struct StepParameters<A> {
    /// Stiffness of the edge in every slot of the graph, N/m.
    pub(super) stiffness: A,
    /// Rest length of the edge in every slot, m.
    pub(super) rest_length: A,
    /// Strain at full activation of the edge in every slot.
    pub(super) strain: A,
    /// The largest strain of the actuator material.
    pub(super) largest_strain: f64,
    /// 1 / mass of every node, 1/kg.
    pub(super) inverse_mass: A,
    /// The [presence](crate::lattice::Body::presence) of every node, from 0 to 1; `None` if all nodes are present.
    pub(super) presence: Option<A>,
    /// The activations of a step, one per slot of the graph, for robots that are driven by given activations. They take the
    /// place of a policy.
    pub(super) activation: Option<A>,
    /// For a robot without feedback: the positions and velocities that the policy sees in every step; `None` for a
    /// robot with feedback, whose policy sees the current ones.
    pub(super) seen: Option<[Axes<A>; 2]>,
    /// The components of the goals of the rollout in order, m. They are measured from the point of the ground from which
    /// positions are measured. Empty if the goal is a number of the controller.
    pub(super) goals: Vec<A>,
    /// The parameters of the mechanics.
    pub(super) mechanics: MechanicsParameters<A>,
}

/// The parameters of pushes and drifts. All but those of the forces are arrays of one number.
pub(super) struct MechanicsParameters<A> {
    /// The numbers of a [`Push`](crate::laws::kernels::Push).
    pub(super) push: Vec<A>,
    /// The number 1, for an integrator that drifts before it pushes.
    pub(super) one: Option<A>,
    /// The settings of the contact law.
    pub(super) contact: Vec<A>,
    /// The arrays that each force declares.
    pub(super) forces: Vec<ForceParameters<A>>,
}

/// Receives the list of a robot's parameters. A robot calls a method of this trait once for each parameter, always in
/// the same order. A [`Program`] declares an array for each parameter, [`Filled`] collects its numbers, and [`Named`] collects
/// the names of the surroundings.
pub(super) trait ParameterSink {
    type Number: Real;
    type Array;

    /// Adds a parameter that depends on the body. It has `len` numbers.
    fn of_body(
        &mut self,
        len: usize,
        numbers: impl Fn(&Body<Self::Number>) -> Vec<Self::Number>,
    ) -> Self::Array;

    /// Adds numbers of the surroundings to which robots can give other values, such as gravity. They have the names and, in
    /// the scene, the values of `inputs`. A step reads what `numbers` makes of their values.
    fn of_surroundings(
        &mut self,
        inputs: &[StepInput],
        numbers: impl Fn(&[Self::Number]) -> Vec<Self::Number>,
    ) -> Self::Array;

    /// Adds the components of the goal number `k` in `dimension`.
    fn of_goal(&mut self, k: usize, dimension: Dimension) -> Self::Array;

    /// Adds numbers that the caller gives for each start and each step: `len` for a step.
    fn of_step(&mut self, len: usize) -> Self::Array;

    /// Adds a parameter that is the same for all robots.
    fn shared(&mut self, numbers: &[f64]) -> Self::Array;

    /// Adds one number of the [surroundings](Self::of_surroundings). A step reads it as it is.
    fn number(&mut self, input: StepInput) -> Self::Array {
        self.of_surroundings(&[input], <[Self::Number]>::to_vec)
    }
}

/// Declares an array of the program for each parameter. It needs no numbers, so their type does not matter.
impl ParameterSink for Program {
    type Number = f64;
    type Array = Array;

    fn of_body(&mut self, len: usize, _: impl Fn(&Body<f64>) -> Vec<f64>) -> Array {
        self.parameter(len)
    }
    fn of_surroundings(
        &mut self,
        inputs: &[StepInput],
        numbers: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Array {
        let values: Vec<f64> = inputs.iter().map(|input| input.value).collect();
        self.parameter(numbers(&values).len())
    }
    fn of_goal(&mut self, _: usize, dimension: Dimension) -> Array {
        self.parameter(dimension.count())
    }
    fn of_step(&mut self, len: usize) -> Array {
        self.control(len)
    }
    fn shared(&mut self, numbers: &[f64]) -> Array {
        self.parameter(numbers.len())
    }
}

/// The numbers of the parameters, collected in the order of declaration. Each parameter has one list of numbers per
/// robot, or one list that all robots share.
pub(super) struct Filled<'a, R> {
    pub(super) bodies: &'a [Arc<Body<R>>],
    pub(super) surroundings: &'a [Arc<Surroundings<R>>],
    /// The numbers that the caller gives for each start: those of all steps, one step after the other.
    pub(super) of_steps: Vec<Vec<R>>,
    pub(super) numbers: Vec<Vec<Vec<R>>>,
}

impl<R: Real> ParameterSink for Filled<'_, R> {
    type Number = R;
    type Array = ();

    fn of_body(&mut self, _: usize, numbers: impl Fn(&Body<R>) -> Vec<R>) {
        let bodies = self.bodies.iter().map(|body| numbers(body));
        self.numbers.push(bodies.collect());
    }
    fn of_surroundings(&mut self, inputs: &[StepInput], numbers: impl Fn(&[R]) -> Vec<R>) {
        let values = |own: &Surroundings<R>| -> Vec<R> {
            inputs.iter().map(|input| own.value(&input.name)).collect()
        };
        let numbers = self.surroundings.iter().map(|own| numbers(&values(own)));
        self.numbers.push(numbers.collect());
    }
    fn of_goal(&mut self, k: usize, dimension: Dimension) {
        let goals = self.surroundings.iter().map(|own| own.goals.as_ref());
        let goal = |goals: Option<&Goals<R>>| goals.and_then(|goals| goals.iter().nth(k));
        let goals =
            goals.map(|goals| goal(goals).expect("robots that walk together have as many goals"));
        self.numbers
            .push(goals.map(|goal| dimension.list(goal)).collect());
    }
    fn of_step(&mut self, _: usize) {
        self.numbers.push(std::mem::take(&mut self.of_steps));
    }
    fn shared(&mut self, numbers: &[f64]) {
        let numbers = numbers.iter().map(|&x| R::lit(x)).collect();
        self.numbers.push(vec![numbers]);
    }
}

/// The names of the surroundings and their values in the scene, each once, in the order of declaration.
#[derive(Default)]
pub(super) struct Named(pub(super) Vec<StepInput>);

impl ParameterSink for Named {
    type Number = f64;
    type Array = ();

    fn of_body(&mut self, _: usize, _: impl Fn(&Body<f64>) -> Vec<f64>) {}
    fn of_surroundings(&mut self, inputs: &[StepInput], _: impl Fn(&[f64]) -> Vec<f64>) {
        for input in inputs {
            if self.0.iter().all(|other| other.name != input.name) {
                self.0.push(input.clone());
            }
        }
    }
    fn of_goal(&mut self, _: usize, _: Dimension) {}
    fn of_step(&mut self, _: usize) {}
    fn shared(&mut self, _: &[f64]) {}
}
