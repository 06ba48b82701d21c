//! [`Surroundings`]: gravity, friction and the settings of laws, as numbers that can be varied.

use std::sync::Arc;

use autodiff::Real;

use crate::laws::StepInput;

/// The surroundings of robots: gravity, friction and the settings of a scene's laws. Each number has the name of its
/// key in the scene, such as `physics.gravity`, `physics.friction` (with Coulomb contact) or
/// `mud.rate`. Goals that are inputs of a rollout belong to them too, such as `goal.0.along`
/// ([`with_goals`](super::Simulator::with_goals)).
///
/// [`Simulator::surroundings`](super::Simulator::surroundings) returns the values of the scene, and
/// [`Simulator::rollouts`](super::Simulator::rollouts) accepts other values. If a number is a variable, the rollout
/// can be differentiated with respect to it:
///
/// ```
/// use autodiff::{Var, gradient};
/// use cosmic::case::Case;
/// use cosmic::scene::Scene;
/// use cosmic::simulator::{Robots, Span};
///
/// let scene = Scene::parse("small", "lattice.columns = 3\nlattice.rows = 2\nphysics.contact = 'coulomb'")?;
/// let case = Case::of_scene(&scene, 1)?;
/// let simulator = case.task().simulator;
/// let span = Span::from_start(vec![100]);
/// // The distance of the payload after 100 steps, as a function of friction and gravity.
/// let distance = |numbers: &[Var<f64>]| {
///     let surroundings = simulator.surroundings();
///     let surroundings = surroundings.with("physics.friction", numbers[0]);
///     let surroundings = surroundings.with("physics.gravity", numbers[1]);
///     let body = case.body().map(Var::constant);
///     let controller = case.controller.map(Var::constant);
///     let start = case.start.map(Var::constant);
///     let robot = Robots::one(&surroundings, &body, &controller);
///     let trajectories = simulator.rollouts(&robot, &[start], &span);
///     trajectories[0].payload(0).x.forward()
/// };
/// let [by_friction, by_gravity] = gradient(distance, &[2.5, 4.8])[..] else { unreachable!() };
/// assert!(by_friction.is_finite() && by_gravity.is_finite());
/// # Ok::<(), cosmic::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings<R> {
    /// The name of each number, and its value in the scene.
    inputs: Arc<[StepInput]>,
    /// The current values, in the order of `inputs`.
    numbers: Vec<R>,
}

impl<R: Real> Surroundings<R> {
    /// The surroundings with the values of a scene, which are constants.
    pub(super) fn of_scene(inputs: &Arc<[StepInput]>) -> Self {
        Self {
            inputs: Arc::clone(inputs),
            numbers: inputs.iter().map(|input| R::lit(input.value)).collect(),
        }
    }

    /// The name and value of each number.
    pub fn iter(&self) -> impl Iterator<Item = (&str, R)> {
        let names = self.inputs.iter().map(|input| &*input.name);
        names.zip(self.numbers.iter().copied())
    }

    /// A copy of the surroundings with the value `value` for the number `name`. The value has the unit of the key of
    /// that name.
    ///
    /// # Panics
    /// If no law of the scene has a number of this name.
    #[must_use]
    pub fn with(mut self, name: &str, value: R) -> Self {
        let place = self.place(name);
        self.numbers[place] = value;
        self
    }

    /// The value of the number `name`.
    ///
    /// # Panics
    /// Like [`with`](Self::with).
    pub fn value(&self, name: &str) -> R {
        self.numbers[self.place(name)]
    }

    fn place(&self, name: &str) -> usize {
        let place = self.inputs.iter().position(|input| input.name == name);
        place.unwrap_or_else(|| {
            let names: Vec<&str> = self.iter().map(|(name, _)| name).collect();
            panic!(
                "the surroundings have no numeric setting `{name}`; expected one of {}",
                names.join(", ")
            )
        })
    }

    /// A copy of the surroundings with `f` applied to every number.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> Surroundings<S> {
        Surroundings {
            inputs: Arc::clone(&self.inputs),
            numbers: self.numbers.iter().map(|&x| f(x)).collect(),
        }
    }

    /// True if the surroundings have numbers with the names of `inputs`.
    pub(super) fn fits(&self, inputs: &[StepInput]) -> bool {
        let names = self.inputs.iter().map(|input| &input.name);
        names.eq(inputs.iter().map(|input| &input.name))
    }
}
