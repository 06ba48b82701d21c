//! [`Surroundings`]: gravity, friction and the settings of laws, as numbers that can be varied.

use std::sync::Arc;

use autodiff::{Parameters, Real};

use crate::laws::StepInput;
use crate::policy::Goals;

/// The surroundings of robots: gravity, friction and the settings of a scene's laws, and the [goals](Self::goals) if they are
/// inputs of a walk. Each number has the name of its key in the scene, such as `physics.gravity`, `physics.friction` (with
/// Coulomb contact) or `mud.rate`.
///
/// [`World::surroundings`](super::World::surroundings) returns the values of the scene, and a [`Robot`](super::Robot) may
/// have other ones. If a number is a variable, the walk can be differentiated with respect to it:
///
/// ```
/// use autodiff::{Parameters, Var, gradient};
/// use cosmic::case::Case;
/// use cosmic::scene::Scene;
/// use cosmic::world::Span;
///
/// let scene = Scene::parse("small", "lattice.columns = 3\nlattice.rows = 2\nphysics.contact = 'coulomb'")?;
/// let case = Case::of_scene(&scene, 1)?;
/// let (world, robot) = (case.world(), case.robot());
/// // The distance of the payload after 100 steps, as a function of friction and gravity.
/// let distance = |numbers: &[Var<f64>]| {
///     let surroundings = world.surroundings();
///     let surroundings = surroundings.with("physics.friction", numbers[0]);
///     let surroundings = surroundings.with("physics.gravity", numbers[1]);
///     let robot = robot.map(Var::constant).in_surroundings(surroundings);
///     let walk = world.run(&[robot], &Span::of_steps(100)).remove(0);
///     walk.payload(0).x.forward()
/// };
/// let [by_friction, by_gravity] = gradient(distance, &[2.5, 4.8])[..] else { unreachable!() };
/// assert!(by_friction.is_finite() && by_gravity.is_finite());
/// # Ok::<(), cosmic::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Surroundings<R> {
    /// The name of each number, and its value in the scene.
    inputs: Arc<[StepInput]>,
    /// The current values, in the order of `inputs`.
    numbers: Vec<R>,
    /// The goals; `None` if the goal is a number of the controller (`controller.goals = "fixed"`).
    pub goals: Option<Goals<R>>,
}

impl<R: Real> Surroundings<R> {
    /// The surroundings with the values of a scene, which are constants. `goals` are those of the scene if goals are inputs
    /// of a walk.
    pub(super) fn of_scene(inputs: &Arc<[StepInput]>, goals: Option<&Goals>) -> Self {
        Self {
            inputs: Arc::clone(inputs),
            numbers: inputs.iter().map(|input| R::lit(input.value)).collect(),
            goals: goals.map(|goals| goals.map(R::lit)),
        }
    }

    /// The name and value of each number, without the goals.
    pub fn iter(&self) -> impl Iterator<Item = (&str, R)> {
        let names = self.inputs.iter().map(|input| &*input.name);
        names.zip(self.numbers.iter().copied())
    }

    /// These surroundings with the value `value` for the number `name`. The value has the unit of the key of that name.
    ///
    /// # Panics
    /// If no law of the scene has a number of this name.
    #[must_use]
    pub fn with(mut self, name: &str, value: R) -> Self {
        let place = self.place(name);
        self.numbers[place] = value;
        self
    }

    /// These surroundings with the number `name` multiplied by `factor`. They do not change if they have no such number.
    #[must_use]
    pub fn scaled(mut self, name: &str, factor: R) -> Self {
        if let Some(place) = self.find(name) {
            self.numbers[place] *= factor;
        }
        self
    }

    /// These surroundings with goals in place of those before.
    ///
    /// # Panics
    /// If the goal is a number of the controller (`controller.goals = "fixed"`).
    #[must_use]
    pub fn with_goals(mut self, goals: Goals<R>) -> Self {
        let before = self.goals.replace(goals);
        before.expect("goals of a rollout need `controller.goals = \"given\"`");
        self
    }

    /// True if robots with these and with the other surroundings can walk together: both have goals, which change at the
    /// same steps, or neither has.
    pub(super) fn change_with(&self, other: &Self) -> bool {
        self.goals.as_ref().map(Goals::changes) == other.goals.as_ref().map(Goals::changes)
    }

    /// The value of the number `name`.
    ///
    /// # Panics
    /// Like [`with`](Self::with).
    pub fn value(&self, name: &str) -> R {
        self.numbers[self.place(name)]
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|input| input.name == name)
    }

    fn place(&self, name: &str) -> usize {
        self.find(name).unwrap_or_else(|| {
            let names: Vec<&str> = self.iter().map(|(name, _)| name).collect();
            panic!(
                "the surroundings have no numeric setting `{name}`; expected one of {}",
                names.join(", ")
            )
        })
    }

    /// These surroundings for another world, whose steps may read other numbers: leapfrog steps, for example, do not read the
    /// damping. A number that these surroundings lack has its value in the other world.
    pub(super) fn adapted(&self, mut to: Self) -> Self {
        if let Some(goals) = &self.goals {
            to = to.with_goals(goals.clone());
        }
        for (name, value) in self.iter() {
            if let Some(place) = to.find(name) {
                to.numbers[place] = value;
            }
        }
        to
    }

    /// True if the surroundings have numbers with the names of `inputs`, and goals if `has_goals` is true.
    pub(super) fn fits(&self, inputs: &[StepInput], has_goals: bool) -> bool {
        let names = self.inputs.iter().map(|input| &input.name);
        self.goals.is_some() == has_goals && names.eq(inputs.iter().map(|input| &input.name))
    }
}
