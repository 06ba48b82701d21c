//! [`Surroundings`]: gravity, friction and the settings of laws, as numbers that can be varied.

use std::sync::Arc;

use autodiff::{Parameters, Real};

use crate::geometry::{Dimension, Vector};
use crate::laws::StepInput;
use crate::policy::Goals;

/// The surroundings of robots: gravity, friction and the settings of a scene's laws. Each number has the name of its
/// key in the scene, such as `physics.gravity`, `physics.friction` (with Coulomb contact) or
/// `mud.rate`. Goals that are inputs of a walk belong to them too, such as `goal.0.along`
/// ([`with_goals`](Surroundings::with_goals)).
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
    dimension: Dimension,
    /// The numbers of steps after which the goals change; `None` if the goal is a number of the controller.
    changes: Option<Arc<[usize]>>,
}

impl<R: Real> Surroundings<R> {
    /// The surroundings with the values of a scene, which are constants. `goals` are those of the scene if goals are inputs
    /// of a walk.
    pub(super) fn of_scene(
        inputs: &Arc<[StepInput]>,
        dimension: Dimension,
        goals: Option<Goals>,
    ) -> Self {
        let of_laws = Self {
            inputs: Arc::clone(inputs),
            numbers: inputs.iter().map(|input| R::lit(input.value)).collect(),
            dimension,
            changes: None,
        };
        goals.map_or(of_laws.clone(), |goals| {
            of_laws.and_goals(&goals.map(R::lit))
        })
    }

    /// The name and value of each number.
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

    /// These surroundings with goals in place of those before. Their numbers have the names `goal.0.along`, in space
    /// `goal.0.across`, `goal.0.above`, `goal.1.along` and so on, in metres, so that a walk can be differentiated with respect
    /// to them.
    ///
    /// # Panics
    /// If the goal is a number of the controller (`controller.goals = "fixed"`).
    #[must_use]
    pub fn with_goals(&self, goals: &Goals<R>) -> Self {
        let before = self.changes.as_ref();
        let before = before.expect("goals of a rollout need `controller.goals = \"given\"`");
        let of_laws = self.inputs.len() - self.dimension.count() * (1 + before.len());
        let of_laws = Self {
            inputs: self.inputs[..of_laws].into(),
            numbers: self.numbers[..of_laws].to_vec(),
            ..self.clone()
        };
        of_laws.and_goals(goals)
    }

    /// These surroundings, which have no goals, and goals.
    fn and_goals(&self, goals: &Goals<R>) -> Self {
        let (mut inputs, mut numbers) = (self.inputs.to_vec(), self.numbers.clone());
        for (k, goal) in goals.iter().enumerate() {
            inputs.extend(goal_inputs(self.dimension, k, goal.map(R::primal)));
            numbers.extend(self.dimension.components(goal));
        }
        Self {
            inputs: inputs.into(),
            numbers,
            dimension: self.dimension,
            changes: Some(goals.later.iter().map(|&(steps, _)| steps).collect()),
        }
    }

    /// The goals; `None` if the goal is a number of the controller.
    pub fn goals(&self) -> Option<Goals<R>> {
        let changes = self.changes.as_ref()?;
        let of_goal = self.dimension.count();
        let first = self.numbers.len() - of_goal * (1 + changes.len());
        let places = self.numbers[first..].chunks_exact(of_goal);
        let mut places = places.map(|place| self.dimension.vector(place));
        Some(Goals {
            first: places.next()?,
            later: changes.iter().copied().zip(places).collect(),
        })
    }

    /// True if the goals of the other surroundings are as many and change at the same steps.
    pub(super) fn change_with(&self, other: &Self) -> bool {
        self.changes == other.changes
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
        if let Some(goals) = self.goals() {
            to = to.with_goals(&goals);
        }
        for (name, value) in self.iter() {
            if let Some(place) = to.find(name) {
                to.numbers[place] = value;
            }
        }
        to
    }

    /// True if the surroundings have numbers with the names of `inputs`.
    pub(super) fn fits(&self, inputs: &[StepInput]) -> bool {
        let names = self.inputs.iter().map(|input| &input.name);
        names.eq(inputs.iter().map(|input| &input.name))
    }
}

/// The numbers of goal `k`: their names, and their values in the scene, m.
pub(super) fn goal_inputs(dimension: Dimension, k: usize, goal: Vector<f64>) -> Vec<StepInput> {
    let components = dimension.names().iter().zip(dimension.components(goal));
    components
        .map(|(name, value)| StepInput::new(format!("goal.{k}.{name}"), value))
        .collect()
}
