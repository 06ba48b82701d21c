//! Rollouts of a [`Simulator`].

use std::borrow::Borrow;

use autodiff::Real;
use autodiff_programs::Rollout;

use super::effort::{Effort, Efforts};
use super::plan::{Planned, Robots, run_together, slices};
use super::prepare::{Simulator, Span};
use super::robot::Activations;
use super::surroundings::Surroundings;
use super::trajectory::{AbsentNodes, Trajectory};
use crate::lattice::{Body, State};
use crate::policy::{Controller, Goals};

impl Simulator {
    /// Simulates robots, each from its own start, and returns the observed states of each. States are in the world's
    /// frame. A trajectory can be differentiated with respect to every number of the robots and of the starts. A robot has
    /// the same bits in any batch. Robots that share one controller take less time together: they run in SIMD lanes and
    /// share each read of a weight.
    ///
    /// # Panics
    /// If bodies, controllers or starts do not fit the lattice, if there is neither one of them for all starts nor one for
    /// each, if the surroundings are from a simulator with other laws, if the span ends after the `physics.steps` that were
    /// given to [`new`](Self::new), or if the span observes no node.
    pub fn rollouts<R: Real>(
        &self,
        robots: &Robots<R>,
        starts: &[impl Borrow<State<R>>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        let starts: Vec<&State<R>> = starts.iter().map(Borrow::borrow).collect();
        robots.check(starts.len(), false);
        if robots.controllers.len() > 1 {
            let alone = |(k, start): (usize, &&State<R>)| {
                let (surroundings, body, controller) = robots.member(k);
                let robot = Robots::one(surroundings, body, controller);
                self.rollouts(&robot, &[*start], span)
            };
            return starts.iter().enumerate().flat_map(alone).collect();
        }
        let planned = self.planned(robots, &starts, span.metered);
        self.trajectories(&planned, robots, &starts, span)
    }

    /// Simulates one robot in the surroundings of the scene: a batch of one.
    ///
    /// # Panics
    /// Like [`rollouts`](Simulator::rollouts).
    pub fn rollout<R: Real>(
        &self,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        let surroundings = self.surroundings();
        let robot = Robots::one(&surroundings, body, controller);
        self.rollouts(&robot, &[start], span).remove(0)
    }

    /// Like [`rollouts`](Simulator::rollouts), for robots whose activations the caller gives in place of controllers, as in
    /// trajectory optimisation and reinforcement learning. `activations` has one list per start, with a number from -1 to 1
    /// for each step of the span and each edge: step by step, or once if the activations stay constant. The trajectories
    /// can be differentiated with respect to them too.
    ///
    /// # Panics
    /// Like [`rollouts`](Simulator::rollouts), and if the number of lists or their lengths are wrong.
    pub fn driven<R: Real>(
        &self,
        surroundings: &[Surroundings<R>],
        bodies: &[Body<R>],
        activations: &[&[R]],
        starts: &[impl Borrow<State<R>>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        let robots = Robots {
            surroundings,
            bodies,
            controllers: &[],
        };
        let starts: Vec<&State<R>> = starts.iter().map(Borrow::borrow).collect();
        robots.check(starts.len(), true);
        self.check(robots.bodies, &starts);
        self.fits("lists of activations", activations.len(), starts.len());
        let (edges, steps) = (self.lattice.edges.len(), span.steps());
        let model = (self.robot.for_bodies(robots.bodies))
            .metered(span.metered)
            .driven();
        let of_steps = activations.iter().map(|given| {
            let is_constant = given.len() == edges;
            let expected = if is_constant { edges } else { edges * steps };
            self.fits("activations", given.len(), expected);
            let of_step = |step| if is_constant { 0 } else { edges * step };
            let steps = (0..steps).map(|step| &given[of_step(step)..][..edges]);
            steps.flat_map(|step| model.graph.to_slots(step)).collect()
        });
        let numbers = self.numbers(&model, &robots, of_steps.collect());
        self.trajectories(&Planned { model, numbers }, &robots, &starts, span)
    }

    /// Simulates prepared robots in SIMD lanes.
    fn trajectories<R: Real>(
        &self,
        planned: &Planned<R>,
        robots: &Robots<R>,
        starts: &[&State<R>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        let flat = starts.iter().map(|start| self.flatten(start)).collect();
        let seen = planned.run(flat, self, span);
        let trajectory = |(k, seen): (usize, &Vec<R>)| {
            let (surroundings, body) = robots.body(k);
            self.trajectory(seen, span, surroundings, body, starts[k])
        };
        seen.iter().enumerate().map(trajectory).collect()
    }

    /// The goals in these surroundings.
    fn goals_in<R: Real>(&self, surroundings: &Surroundings<R>) -> Option<Goals<R>> {
        let goals = self.robot.goals.as_ref()?;
        let mut places = self.robot.goal_inputs().into_iter().map(|inputs| {
            let values = inputs.iter().map(|input| surroundings.value(&input.name));
            self.lattice.dimension.vector(&values.collect::<Vec<R>>())
        });
        let first = places.next()?;
        let changes = goals.later.iter().map(|&(steps, _)| steps);
        Some(Goals {
            first,
            later: changes.zip(places).collect(),
        })
    }

    /// Computes the activation of every edge in several states. `moments` has each state with its time (s).
    pub(crate) fn activations(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        moments: &[(&State<f64>, f64)],
    ) -> Vec<Vec<f64>> {
        self.check_controller(controller);
        let surroundings = self.surroundings();
        let robots = Robots::one(&surroundings, body, controller);
        let robot = self.robot.for_all_edges(robots.bodies);
        let numbers = self.numbers(&robot, &robots, Vec::new());
        let slots = robot.graph.slots();
        let start = |(state, time): &(&State<f64>, f64)| {
            let clock = self
                .robot
                .pairs_at(*time, (time / self.dt).round() as usize);
            let clock = clock.concat();
            [self.flatten(state), clock, vec![0.0; slots]].concat()
        };
        let starts: Vec<Vec<f64>> = moments.iter().map(start).collect();
        let first = robot.numbers_of_nodes() + 2 * robot.pairs();
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
        let still = AbsentNodes::of(body, start);
        let nodes = self.robot.graph.nodes().min(span.nodes);
        let of_nodes = 2 * self.lattice.dimension.count() * nodes;
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
