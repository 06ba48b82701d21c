//! Goals: where a robot is to go. They are inputs of a rollout, and may change while the robot walks.

use std::ops::Range;

use autodiff::parameters::Walk;
use autodiff::{Parameters, Real};
use autodiff_programs::{Compiled, Kernel};

use crate::geometry::{Dimension, Vector};
use crate::{in_both_dimensions, in_dimension, kernel};

/// The goals of a robot, one after the other. A goal is a point in the ground's frame, measured from the world's origin:
/// along the ground, in space across, and normal to it, in metres.
///
/// Robots of one batch may have different goals, but change them at the same steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Goals<R = f64> {
    /// The first goal.
    pub first: Vector<R>,
    /// The later goals, each with the number of steps after which it replaces the goal before it, ascending.
    pub later: Vec<(usize, Vector<R>)>,
}

impl<R: Real> Parameters<R> for Goals<R> {
    type With<S: Real> = Goals<S>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Goals<S> {
        let first = walk.field("first", &self.first);
        let later = self.later.iter().enumerate();
        Goals {
            first,
            later: later
                .map(|(k, (steps, goal))| (*steps, walk.element(k, goal)))
                .collect(),
        }
    }
}

impl<R: Copy> Goals<R> {
    /// A goal that does not change.
    pub fn at(goal: Vector<R>) -> Self {
        Self {
            first: goal,
            later: Vec::new(),
        }
    }

    /// Adds a goal, which replaces the last one after this number of steps.
    ///
    /// # Panics
    /// If the last goal began later or at the same step.
    #[must_use]
    pub fn then(mut self, steps: usize, goal: Vector<R>) -> Self {
        let last = self.later.last().map_or(0, |&(steps, _)| steps);
        assert!(
            steps > last,
            "a goal begins after {steps} steps, and the goal before it after {last}"
        );
        self.later.push((steps, goal));
        self
    }

    /// All goals in order.
    pub fn iter(&self) -> impl Iterator<Item = Vector<R>> {
        let later = self.later.iter().map(|&(_, goal)| goal);
        std::iter::once(self.first).chain(later)
    }

    /// The number of goals.
    pub(crate) fn count(&self) -> usize {
        1 + self.later.len()
    }

    /// The numbers of steps after which the goals change.
    pub(crate) fn changes(&self) -> Vec<usize> {
        self.later.iter().map(|&(steps, _)| steps).collect()
    }

    /// The goals from this number of steps on. The first one is the goal that holds then.
    pub(crate) fn after(&self, steps: usize) -> Self {
        let place = self.place(steps);
        let first = self.iter().nth(place).expect("a goal holds at any time");
        let later = self.later[place..].iter();
        Self {
            first,
            later: later.map(|&(from, goal)| (from - steps, goal)).collect(),
        }
    }

    /// The index, among all goals, of the goal that holds in the step after `steps` steps.
    pub fn place(&self, steps: usize) -> usize {
        self.later.iter().filter(|(from, _)| *from <= steps).count()
    }

    /// Each goal with the steps in which it holds, in a rollout of `steps` steps. Goals that begin later are left out.
    pub fn times(&self, steps: usize) -> impl Iterator<Item = (Range<usize>, Vector<R>)> {
        let changes = self.later.iter().map(|&(from, _)| from);
        let from = [0].into_iter().chain(changes.clone());
        let to = changes.chain([usize::MAX]);
        let times = from.zip(to).map(move |(from, to)| from..to.min(steps));
        times
            .zip(self.iter())
            .take_while(|(time, _)| !time.is_empty())
    }
}

impl Goals {
    /// The input of a step with which it [picks](Pick) its goal: a pair of ones for the goal that holds, a pair of
    /// zeros for every other goal. A single goal needs no input. In space only the first number of a pair counts.
    pub(crate) fn holds(&self, steps: usize) -> impl Iterator<Item = [f64; 2]> {
        let (count, place) = (self.count(), self.place(steps));
        let legs = (0..count).map(move |k| [f64::from(u8::from(k == place)); 2]);
        legs.filter(move |_| count > 1)
    }
}

/// The kernel that multiplies the first goal of a rollout by 1 if it holds, or else by 0.
pub(crate) struct Hold;

#[kernel]
impl Kernel<2, 1> for Hold {
    const COMPILED: Compiled = Compiled::Narrow;

    fn eval<R: Real>(&self, [goal, holds]: [R; 2], _: &[R]) -> [R; 1] {
        [holds * goal]
    }
}

/// The kernel that adds another goal to such a sum, multiplied by 1 if it holds, or else by 0.
pub(crate) struct Pick;

#[kernel]
impl Kernel<3, 1> for Pick {
    const COMPILED: Compiled = Compiled::Narrow;

    fn eval<R: Real>(&self, [sum, goal, holds]: [R; 3], _: &[R]) -> [R; 1] {
        [sum + holds * goal]
    }
}

/// The kernel that computes the offset of a goal from a place.
pub(super) struct Offset;

#[kernel]
impl Kernel<2, 1> for Offset {
    const COMPILED: Compiled = Compiled::Narrow;

    fn eval<R: Real>(&self, [goal, place]: [R; 2], _: &[R]) -> [R; 1] {
        [goal - place]
    }
}

/// The kernel that computes how a robot observes a goal: the offset `d` of the goal, as `s d / sqrt(1 + s^2 |d|^2)` with
/// the scale `s`. A near goal is observed as `s d`, and of a far goal only the direction. The inputs are the component
/// of `d` in question and the other ones.
pub(crate) struct Towards {
    /// The scale of the goal, 1/m.
    pub(crate) scale: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<D, 1> for Towards {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, offset: [R; D], _: &[R]) -> [R; 1] {
            let (scale, mut scaled) = (R::lit(self.scale), offset);
            for k in 0..D {
                scaled[k] = scale * offset[k];
            }
            let mut square = R::one();
            for k in 0..D {
                square += scaled[k] * scaled[k];
            }
            [scaled[0] / square.sqrt()]
        }
    }
}

/// How a robot observes a goal with the offset `offset`: see [`Towards`].
pub(super) fn towards<R: Real>(dimension: Dimension, offset: Vector<R>, scale: f64) -> Vector<R> {
    let kernel = Towards { scale };
    let offset = dimension.list(offset);
    let seen: Vec<R> = in_dimension!(dimension, D => {
        let component = |first: usize| {
            let turned: [R; D] = std::array::from_fn(|k| offset[(first + k) % D]);
            kernel.eval(turned, &[])[0]
        };
        (0..D).map(component).collect()
    });
    dimension.vector(&seen)
}
