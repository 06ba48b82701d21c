//! The verb of a [`World`]: it lets robots walk.

use std::ops::{ControlFlow, Range};

use autodiff::Real;
use autodiff_programs::Rollout;

use super::base::World;
use super::effort::{Effort, Efforts};
use super::plan::{run_together, slices};
use super::robot::Robot;
use super::span::Span;
use super::step::Activations;
use super::trajectory::{AbsentNodes, Trajectory, WATCHED};
use crate::lattice::State;
use crate::policy::Controller;

/// The number of states that a walk which shows every state keeps in memory at a time.
const BLOCK: usize = 64;

impl World {
    /// Simulates robots and returns the observed states of each. States are in the world's frame. A trajectory can be
    /// differentiated with respect to every number of the robots. A robot has the same bits in any batch. Robots that share
    /// one controller take less time together: they walk in SIMD lanes and share each read of a weight.
    ///
    /// # Panics
    /// If robots do not fit the lattice, if their surroundings are from a world with other laws, if the span ends after the
    /// `physics.steps` that were given to [`new`](Self::new), or if the span observes no node.
    pub fn run<R: Real>(&self, robots: &[Robot<R>], span: &Span) -> Vec<Trajectory<R>> {
        let groups = robots.chunk_by(Robot::walks_with);
        groups
            .flat_map(|group| self.run_group(group, span))
            .collect()
    }

    /// Simulates robots that walk together.
    fn run_group<R: Real>(&self, robots: &[Robot<R>], span: &Span) -> Vec<Trajectory<R>> {
        let planned = self.planned(robots, span);
        let starts = robots.iter().map(|robot| self.flatten(&robot.start));
        let seen = planned.run(starts.collect(), self, span);
        let pairs = seen.iter().zip(robots);
        pairs
            .map(|(seen, robot)| self.trajectory(seen, span, robot))
            .collect()
    }

    /// Simulates one robot: a batch of one.
    ///
    /// # Panics
    /// Like [`run`](Self::run).
    pub fn run_one<R: Real>(&self, robot: &Robot<R>, span: &Span) -> Trajectory<R> {
        self.run(std::slice::from_ref(robot), span).remove(0)
    }

    /// Simulates all steps of a span. After each step, calls `show` with the number of steps so far and the new state; if the
    /// span is metered, also with the efforts of the bars in the step. Ends early if `show` returns `Break`. Keeps only a
    /// block of states in memory at a time.
    pub(crate) fn each_state(
        &self,
        robot: &Robot<f64>,
        span: &Span,
        mut show: impl FnMut(usize, State<f64>, Option<Effort<f64>>) -> ControlFlow<()>,
    ) {
        let of_nodes = self.step.numbers_of_nodes();
        let size = of_nodes + self.step.meters_if(span.metered);
        // Every node of every state is needed, and nothing is watched.
        let part = |first: usize, observed: Vec<usize>| Span {
            first,
            nodes: usize::MAX,
            watched: false,
            ..span.observing(observed)
        };
        let planned = |block: &Span| {
            let first = block.first - span.first;
            self.planned(&[self.during(robot, first..first + block.steps())], block)
        };
        // Only activations that are given step by step differ from block to block.
        let is_driven = robot.controller.activations().is_some();
        let mut of_walk = None;
        let still = AbsentNodes::of(&robot.body, &robot.start);
        // States are kept as flat arrays in the ground's frame, so that the next block continues from identical bits.
        let mut flat = self.flatten(&robot.start);
        let steps = span.first..span.first + span.steps();
        for first in steps.clone().step_by(BLOCK) {
            let block = part(first, (1..=BLOCK.min(steps.end - first)).collect());
            let known = of_walk.take().filter(|_| !is_driven);
            let of_block = known.unwrap_or_else(|| planned(&block));
            let seen = of_block.run(vec![flat], self, &block).remove(0);
            of_walk = Some(of_block);
            for (k, raw) in seen.chunks_exact(size).enumerate() {
                let (of_nodes, efforts) = raw.split_at(of_nodes);
                let state = still.held(self.unflatten(of_nodes));
                let effort = span.metered.then(|| self.effort(efforts));
                if show(first + k + 1, state, effort).is_break() {
                    return;
                }
            }
            flat = seen[seen.len() - size..].to_vec();
        }
    }

    /// This robot during some steps of a walk. Of activations that are given step by step, it keeps those of these steps.
    pub(crate) fn during(&self, robot: &Robot<f64>, steps: Range<usize>) -> Robot<f64> {
        let edges = self.lattice.edges.len();
        match robot.controller.activations() {
            Some(given) if given.len() != edges => {
                let given = given[edges * steps.start..edges * steps.end].to_vec();
                Robot {
                    controller: Controller::given(given).into(),
                    ..robot.clone()
                }
            }
            _ => robot.clone(),
        }
    }

    /// Computes the activation of every edge in several states. `moments` has each state with its time (s). The robot's start
    /// is not read. Given activations must be constant.
    pub(crate) fn activations(
        &self,
        robot: &Robot<f64>,
        moments: &[(&State<f64>, f64)],
    ) -> Vec<Vec<f64>> {
        let robots = std::slice::from_ref(robot);
        let step = (self.step_of(robots)).for_all_edges(&[std::sync::Arc::clone(&robot.body)]);
        let numbers = self.numbers(&step, robots, 1);
        let slots = step.graph.slots();
        let start = |(state, time): &(&State<f64>, f64)| {
            let clock = step.pairs_at(*time, (time / self.physics.dt).round() as usize);
            let clock = clock.concat();
            [self.flatten(state), clock, vec![0.0; slots]].concat()
        };
        let starts: Vec<Vec<f64>> = moments.iter().map(start).collect();
        let first = step.numbers_of_nodes() + 2 * step.pairs();
        let slot_of_edge = step.graph.slot_of_edge().to_vec();
        let rollout = Rollout {
            entries: Some((first..first + slots).collect()),
            ..Rollout::new(Activations(step), 1)
        };
        let seen = run_together(&rollout, &slices(&starts), &numbers);
        let of_edges = |seen: Vec<f64>| slot_of_edge.iter().map(|&slot| seen[slot]).collect();
        seen.into_iter().map(of_edges).collect()
    }

    /// Converts the observed states to a trajectory. `seen` has the states as flat arrays, one after the other.
    pub(super) fn trajectory<R: Real>(
        &self,
        seen: &[R],
        span: &Span,
        robot: &Robot<R>,
    ) -> Trajectory<R> {
        let Robot { body, start, .. } = robot;
        let still = AbsentNodes::of(body, start);
        let nodes = self.step.graph.nodes().min(span.nodes);
        let of_nodes = 2 * self.lattice.dimension.count() * nodes;
        let meters = self.step.meters_if(span.metered);
        let states = || seen.chunks_exact(of_nodes + meters);
        let efforts = || Efforts {
            of_states: (states().map(|s| self.effort(&s[of_nodes..]))).collect(),
            body: (**body).clone(),
            dt: self.physics.dt,
        };
        Trajectory {
            steps: span.observed.clone(),
            states: (states().map(|s| still.held(self.unflatten(&s[..of_nodes])))).collect(),
            efforts: span.metered.then(efforts),
            marker: body.marker.clone(),
            start: (body.marker.weights.first()).map_or(Vec::new(), |_| start.x.clone()),
            goals: (robot.surroundings.goals.as_ref()).map(|goals| goals.after(span.first)),
        }
    }

    /// The efforts of all edges, from their numbers in a flat state.
    pub(super) fn effort<R: Real>(&self, of_slots: &[R]) -> Effort<R> {
        Effort::of_slots(of_slots, self.step.graph.slot_of_edge())
    }

    /// A limit for the cheap watch of a rollout. If the absolute value of a number of some state exceeds it, every state
    /// is checked exactly. Positions (m) and velocities (m/s) share the limit. With a bound on speeds, a valid position
    /// may exceed it; the exact check then finds no error.
    pub(super) fn watched(&self) -> f64 {
        // If both components of a velocity are below this number, the speed is below the bound.
        let component = |bound: f64| bound / 2f64.sqrt();
        self.physics
            .speed_bound
            .map_or(WATCHED, |bound| component(bound).min(WATCHED))
    }
}
