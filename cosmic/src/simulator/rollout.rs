//! Rollouts of a [`Simulator`].

use std::borrow::Borrow;

use autodiff::{Real, Rollout};

use super::effort::{Effort, Efforts};
use super::plan::{Driving, Planned, run_together, slices};
use super::prepare::{Simulator, Span};
use super::robot::{Activations, Robot};
use super::surroundings::Surroundings;
use super::trajectory::{Still, Trajectory};
use crate::lattice::{Body, State};
use crate::policy::{Controller, Goals};

impl Simulator {
    /// Simulates a robot from the state `start` and returns the observed states. States are in the world's frame.
    ///
    /// # Panics
    /// If body, controller or state do not fit the lattice, if the span ends after the `physics.steps` that were given
    /// to [`new`](Self::new), or if the span observes no node.
    pub fn rollout<R: Real>(
        &self,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        self.rollout_in(&self.surroundings(), body, controller, start, span)
    }

    /// Like [`rollout`](Simulator::rollout), in other [surroundings](Surroundings). The trajectory can be
    /// differentiated with respect to them.
    ///
    /// # Panics
    /// Like [`rollout`](Simulator::rollout), and if the surroundings are from a simulator with other laws.
    pub fn rollout_in<R: Real>(
        &self,
        surroundings: &Surroundings<R>,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        let planned = self.planned(surroundings, body, controller, start);
        let seen = planned.metered(span).run(&self.flatten(start), self, span);
        self.trajectory(&seen, span, surroundings, body, start)
    }

    /// Simulates robots with one controller from several starts. `bodies` has one body for all starts, or one for each
    /// start. The result has the same bits as single [rollouts](Simulator::rollout). It takes less time, because the
    /// robots run in SIMD lanes and share each read of a weight.
    ///
    /// # Panics
    /// Like [`rollout`](Simulator::rollout), and if the number of bodies is neither one nor the number of starts.
    pub fn rollout_many<R: Real>(
        &self,
        bodies: &[Body<R>],
        controller: &Controller<R>,
        starts: &[impl Borrow<State<R>>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        self.rollout_many_in(&[self.surroundings()], bodies, controller, starts, span)
    }

    /// Like [`rollout_many`](Simulator::rollout_many), in other surroundings. `surroundings` has one entry for all
    /// starts, or one for each start.
    ///
    /// # Panics
    /// Like [`rollout_many`](Simulator::rollout_many); if the number of surroundings is neither one nor the number of
    /// starts; and if they are from a simulator with other laws.
    pub fn rollout_many_in<R: Real>(
        &self,
        surroundings: &[Surroundings<R>],
        bodies: &[Body<R>],
        controller: &Controller<R>,
        starts: &[impl Borrow<State<R>>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        if let ([surroundings], [body], [start]) = (surroundings, bodies, starts) {
            return vec![self.rollout_in(surroundings, body, controller, start.borrow(), span)];
        }
        let starts: Vec<&State<R>> = starts.iter().map(Borrow::borrow).collect();
        self.check(bodies, &starts);
        self.check_controller(controller);
        let model = self.robot.for_bodies(bodies).metered(span.metered);
        let numbers = self.numbers(&model, surroundings, bodies, Driving::By(controller));
        self.in_lanes(model, surroundings, bodies, &numbers, &starts, span)
    }

    /// The goals in these surroundings.
    fn goals_in<R: Real>(&self, surroundings: &Surroundings<R>) -> Option<Goals<R>> {
        let goals = self.robot.goals.as_ref()?;
        let goal = |k: usize| surroundings.goal(self.robot.mechanics.inputs.len(), k);
        let later = goals.later.iter().enumerate();
        Some(Goals {
            first: goal(0),
            later: later.map(|(k, &(steps, _))| (steps, goal(k + 1))).collect(),
        })
    }

    /// Simulates robots in SIMD lanes. `numbers` has the numbers of their parameters; `surroundings` and `bodies` have one
    /// entry for all starts, or one for each start.
    pub(super) fn in_lanes<R: Real>(
        &self,
        model: Robot,
        surroundings: &[Surroundings<R>],
        bodies: &[Body<R>],
        numbers: &[Vec<Vec<R>>],
        starts: &[&State<R>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        let trajectory = |(k, seen): (usize, &Vec<R>)| {
            let surroundings = &surroundings[k % surroundings.len()];
            self.trajectory(
                seen,
                span,
                surroundings,
                &bodies[k % bodies.len()],
                starts[k],
            )
        };
        if let [start] = starts {
            let parameters = numbers.iter().flatten().cloned().collect();
            let seen = Planned { model, parameters }.run(&self.flatten(start), self, span);
            return vec![trajectory((0, &seen))];
        }
        let flat = |start: &&State<R>| model.started(self.flatten(start));
        let flat: Vec<Vec<R>> = starts.iter().map(flat).collect();
        let rollout = self.plan(model, span);
        let seen = run_together(&rollout, &slices(&flat), numbers);
        seen.iter().enumerate().map(trajectory).collect()
    }

    /// Computes the activation of every edge in several states. `moments` has each state with its time (s).
    pub(crate) fn activations(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        moments: &[(&State<f64>, f64)],
    ) -> Vec<Vec<f64>> {
        let bodies = std::slice::from_ref(body);
        self.check_controller(controller);
        let robot = self.robot.for_all_edges(bodies);
        let surroundings = [self.surroundings()];
        let numbers = self.numbers(&robot, &surroundings, bodies, Driving::By(controller));
        let slots = robot.graph.slots();
        let start = |(state, time): &(&State<f64>, f64)| {
            let clock = self
                .robot
                .pairs_at(*time, (time / self.dt).round() as usize);
            let clock = clock.concat();
            [self.flatten(state), clock, vec![0.0; slots]].concat()
        };
        let starts: Vec<Vec<f64>> = moments.iter().map(start).collect();
        let first = 4 * robot.graph.nodes() + 2 * robot.pairs();
        let slot_of_edge = robot.graph.slot_of_edge().to_vec();
        let rollout = Rollout {
            entries: Some((first..first + slots).collect()),
            ..Rollout::new(Activations(robot), 1)
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
        surroundings: &Surroundings<R>,
        body: &Body<R>,
        start: &State<R>,
    ) -> Trajectory<R> {
        let still = Still::of(body, start);
        let of_nodes = 4 * self.robot.graph.nodes().min(span.nodes);
        let meters = self.robot.meters_if(span.metered);
        let states = || seen.chunks_exact(of_nodes + meters);
        let efforts = || Efforts {
            of_states: (states().map(|s| self.effort(&s[of_nodes..]))).collect(),
            body: body.clone(),
            dt: self.dt,
        };
        Trajectory {
            steps: span.observed.clone(),
            states: (states().map(|s| still.held(self.unflatten(&s[..of_nodes])))).collect(),
            efforts: span.metered.then(efforts),
            marker: body.marker.clone(),
            start: (body.marker.weights.first()).map_or(Vec::new(), |_| start.x.clone()),
            goals: (self.goals_in(surroundings)).map(|goals| goals.after(span.first)),
        }
    }

    /// The efforts of all edges, from their numbers in a flat state.
    pub(super) fn effort<R: Real>(&self, of_slots: &[R]) -> Effort<R> {
        Effort::of_slots(of_slots, self.robot.graph.slot_of_edge())
    }
}
