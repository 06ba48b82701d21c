//! Requested rollouts of robots.

use crate::arrays::{Arrays, Number, Others, Sizes, flattened};
use crate::kind::{Kind, Mixing};
use crate::work::{Stop, group_size};
use autodiff::{Parameters, Real};
use cosmic::error::Error;
use cosmic::lattice::State;
use cosmic::walk;
use cosmic::world::{Robot, Span, Trajectory};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Requested rollouts: the arrays of robots, and the observed steps.
pub(crate) struct Asked<'a, R> {
    pub(crate) kind: &'a Kind,
    pub(crate) arrays: Arrays<R>,
    /// How rows of `z` become bodies: one for each robot, or one for all.
    mixing: Vec<Mixing>,
    shared: Shared,
    pub(crate) count: usize,
    /// The robots whose inputs are not finite.
    pub(crate) lost: Vec<bool>,
    pub(crate) span: Span,
}

/// What all robots of a request share, because they share the arrays that determine it.
struct Shared {
    body: bool,
    controller: bool,
    surroundings: bool,
}

impl Shared {
    fn new<R: Number>(sizes: &Sizes, arrays: &Arrays<R>) -> Self {
        let Others {
            driven,
            goals,
            physics,
        } = &sizes.others;
        // The first of the arrays of positions and velocities at the start, and the first of the others.
        let start = 1 + sizes.blocks.len();
        let others = arrays.are_shared(start + 2..arrays.len());
        Self {
            body: arrays.are_shared(0..1) && (others || physics.is_empty()),
            controller: match driven {
                Some(_) => others,
                None => arrays.are_shared(1..start),
            },
            surroundings: others || *goals == 0 && physics.is_empty(),
        }
    }
}

impl<'a, R: Number> Asked<'a, R> {
    /// Numbers of `arrays` that are not finite become 0, and their robots are lost. There may be more robots than the arrays
    /// have, if these robots share all arrays.
    pub(crate) fn new(
        kind: &'a Kind,
        mut arrays: Arrays<R>,
        count: usize,
        span: Span,
    ) -> PyResult<Self> {
        let lost = arrays.clean(count);
        let projection = kind.projection_of(arrays.z(), &lost)?;
        let robots = arrays.z().chunks(kind.sizes.edges);
        Ok(Self {
            mixing: robots.map(|z| Mixing::new(projection, z)).collect(),
            shared: Shared::new(&kind.sizes, &arrays),
            kind,
            arrays,
            count,
            lost,
            span,
        })
    }

    /// The robot whose arrays have the numbers `row`. What it shares with the robot `like` is shared. Plain numbers, forward
    /// mode and reverse mode all use this function, so that they see the same robot.
    pub(crate) fn robot<S: Real>(
        &self,
        robot: usize,
        row: &[S],
        like: Option<&Robot<S>>,
    ) -> Robot<S> {
        let (kind, row) = (self.kind, self.kind.sizes.split(row));
        let mixing = &self.mixing[robot % self.mixing.len()];
        let Shared {
            body,
            controller,
            surroundings,
        } = self.shared;
        let like = |is_shared: bool| like.filter(|_| is_shared);
        Robot {
            body: like(body).map_or_else(
                || Arc::new(kind.body(mixing, &row)),
                |like| Arc::clone(&like.body),
            ),
            controller: like(controller).map_or_else(
                || Arc::new(kind.controller(&row)),
                |like| Arc::clone(&like.controller),
            ),
            surroundings: like(surroundings).map_or_else(
                || Arc::new(kind.surroundings(&row)),
                |like| Arc::clone(&like.surroundings),
            ),
            start: State::from_flat(kind.sizes.dimension, row.start),
        }
    }

    /// These robots, with `f` applied to every number of their arrays.
    pub(crate) fn robots<S: Real>(
        &self,
        robots: Range<usize>,
        f: impl Fn(R) -> S,
    ) -> Vec<Robot<S>> {
        let mut all: Vec<Robot<S>> = Vec::with_capacity(robots.len());
        for robot in robots {
            let row: Vec<S> = self.arrays.row(robot).into_iter().map(&f).collect();
            all.push(self.robot(robot, &row, all.last()));
        }
        all
    }

    /// True if several robots can walk in the same lanes.
    fn share_lanes(&self) -> bool {
        self.shared.controller || self.kind.sizes.others.driven.is_some()
    }

    /// Simulates robots. Returns one list: for each robot, its observed positions and then its observed velocities.
    pub(crate) fn seen<S: Real>(&self, robots: &[Robot<S>]) -> Vec<S> {
        let walks = self.kind.world.run(robots, &self.span);
        let numbers = walks.chunks(1).flat_map(|walk| flattened(walk).concat());
        numbers.collect()
    }

    /// Simulates all robots and writes their positions and velocities into the arrays `x` and `v`. A robot that
    /// diverges gets NaN from its first absurd state on (see [`State::absurd_node`]). Robots that have not begun when
    /// the work is stopped get NaN.
    ///
    /// Returns the number of the first robot whose last state is absurd.
    pub(crate) fn fill(&self, [x, v]: [&mut [R]; 2], stop: &Stop) -> Option<usize> {
        let robots = self.count;
        let together = group_size(robots, self.share_lanes());
        let length = together * x.len() / robots;
        let places = x.chunks_mut(length).zip(v.chunks_mut(length)).enumerate();
        // Each thread copies the states of its robots into the arrays and then drops them, to save memory.
        let step = |(group, (x, v)): (usize, (&mut [R], &mut [R]))| {
            if stop.load(Ordering::Relaxed) {
                x.fill(R::lit(f64::NAN));
                v.fill(R::lit(f64::NAN));
                return None;
            }
            let first = group * together;
            let group = self.robots(first..(first + together).min(robots), |x| x);
            write(&self.kind.world.run(&group, &self.span), [x, v]).map(|robot| first + robot)
        };
        match robots {
            1 => places.map(step).next().flatten(),
            _ => places.par_bridge().filter_map(step).min(),
        }
    }

    /// Repeats the rollout of a robot in double precision, to find where and why it diverges. The reason is only known for a
    /// robot with a controller in the physics of the scene.
    pub(crate) fn divergence(&self, robot: usize) -> Error {
        let not_again = || {
            Error::NoFigure("the rollout diverged in single but not in double precision".to_owned())
        };
        let world = &self.kind.world;
        let again = self.robots(robot..robot + 1, Into::into).remove(0);
        let Others {
            driven, physics, ..
        } = &self.kind.sizes.others;
        if driven.is_none() && physics.is_empty() {
            let guarded = walk::guarded(world, &again, &self.span);
            return (guarded.divergence.as_ref()).map_or_else(not_again, Error::from);
        }
        let every = self.span.observing((0..=self.span.steps()).collect());
        let walk = world.run_one(&again, &every);
        let mut states = walk.states.iter().enumerate();
        states
            .find_map(|(k, state)| Some((k, state, state.absurd_node()?)))
            .map_or_else(not_again, |(k, state, node)| Error::Diverged {
                step: self.span.first + k.saturating_sub(1),
                node,
                position: state.x[node],
                velocity: state.v[node],
                cause: match (driven.is_some(), physics.is_empty()) {
                    (true, true) => "under the given activations",
                    (false, _) => "under the given physics",
                    (true, false) => "under the given activations and physics",
                }
                .to_owned(),
            })
    }
}

/// Writes the positions and velocities of robots into `x` and `v`. If a robot diverged, NaN replaces its states from the
/// first absurd state on. Returns the place of the first robot whose last state is absurd.
pub(crate) fn write<R: Number>(walks: &[Trajectory<R>], [x, v]: [&mut [R]; 2]) -> Option<usize> {
    let length = x.len() / walks.len();
    let places = x.chunks_exact_mut(length).zip(v.chunks_exact_mut(length));
    for (walk, (x, v)) in walks.iter().zip(places) {
        let [of_x, of_v] = flattened(std::slice::from_ref(walk));
        x.copy_from_slice(&of_x);
        v.copy_from_slice(&of_v);
        if is_absurd(walk) {
            let first = walk.states.iter().position(is_absurd_state);
            let first = first.unwrap_or_default() * length / walk.states.len();
            x[first..].fill(R::lit(f64::NAN));
            v[first..].fill(R::lit(f64::NAN));
        }
    }
    walks.iter().position(is_absurd)
}

fn is_absurd<R: Number>(walk: &Trajectory<R>) -> bool {
    walk.states.last().is_some_and(is_absurd_state)
}

fn is_absurd_state<R: Number>(state: &State<R>) -> bool {
    let state: State<f64> = state.map(Into::into);
    state.is_absurd()
}

/// True if the last state is absurd. `seen` contains the numbers that the function [`seen`] returned.
pub(crate) fn ends_absurd<R: Number>(seen: &[R], sizes: &Sizes) -> bool {
    let length = sizes.points().iter().product::<usize>();
    let (x, v) = seen.split_at(seen.len() / 2);
    let last = [x, v].map(|half| &half[half.len() - length..]);
    is_absurd_state(&State::from_flat(sizes.dimension, last))
}
