//! Losses and gradients of a population of robots.

use std::sync::Arc;

use autodiff::{Tape, Var};
use cosmic::geometry::Vector;
use cosmic::lattice::{Body, State};
use cosmic::policy::Controller;
use cosmic::simulator::{PrintedRobots, Robots, Surroundings, Trajectory};
use rayon::prelude::*;

use crate::device::{Gpu, GpuError};
use crate::population::{Cotangents, Members, Population, Sweep};

/// Robots on a device.
pub struct RobotsOnGpu {
    population: Arc<Population>,
    printed: PrintedRobots,
    inputs: Vec<f32>,
    /// The numbers of steps after which the program observes the state.
    observed: Vec<usize>,
}

/// The results of a gradient, for each member.
#[derive(Clone, Debug)]
pub struct Gradients {
    /// The losses.
    pub losses: Vec<f64>,
    /// The trajectories.
    pub trajectories: Vec<Trajectory<f64>>,
    /// The cotangents of the bodies, if they were wanted when the step was printed.
    pub bodies: Vec<Body<f64>>,
    /// The cotangents of the controllers' numbers, if they were wanted.
    pub controllers: Vec<Vec<f64>>,
    /// The cotangents of the states at the start, as the numbers of the program.
    pub starts: Vec<f32>,
}

/// What a loss says of one member.
struct Lost {
    value: f64,
    trajectory: Trajectory<f64>,
    /// The cotangents of the observed numbers.
    seen: Vec<f32>,
    /// The cotangents of the body's numbers through the loss alone; empty if those of bodies are not wanted.
    body: Vec<f64>,
}

impl RobotsOnGpu {
    /// Compiles the printed step of robots for a device.
    ///
    /// # Errors
    /// If it is too large for the device, or its driver refuses it.
    pub fn new(gpu: &Gpu, printed: PrintedRobots) -> Result<Self, GpuError> {
        let population = Population::new(gpu, printed.program.clone())?;
        Ok(Self::of(Arc::new(population), printed))
    }

    /// Robots whose program is compiled already.
    pub(crate) fn of(population: Arc<Population>, printed: PrintedRobots) -> Self {
        Self {
            population,
            inputs: printed.inputs.iter().map(|&x| x as f32).collect(),
            observed: (printed.span().observed.iter().copied())
                .filter(|&step| step > 0)
                .collect(),
            printed,
        }
    }

    /// The printed robots.
    pub fn printed(&self) -> &PrintedRobots {
        &self.printed
    }

    /// The largest number of members that fit the device at once.
    pub fn room(&self, reverses: bool) -> usize {
        let steps = self.observed.last().copied().unwrap_or(0);
        self.population.room(steps, self.observed.len(), reverses)
    }

    /// The numbers of the state at the start that belong to the observed numbers; empty if the start is not observed. The
    /// program observes only later states.
    fn at_start(&self, start: &State<f64>) -> Vec<f64> {
        if self.printed.span().observed.first() != Some(&0) {
            return Vec::new();
        }
        let flat = self.printed.starts(std::slice::from_ref(start));
        let nodes = start.x.len();
        let observed = self.printed.span().nodes.min(nodes);
        let of_nodes = (0..4).flat_map(|k| (0..observed).map(move |node| k * nodes + node));
        let entries = of_nodes.chain(4 * nodes..flat.len());
        entries.map(|entry| f64::from(flat[entry] as f32)).collect()
    }

    /// Runs robots forward and returns the sweep. With `reverses`, it can be followed by a reverse sweep.
    pub fn sweep(&self, robots: &Robots<f64>, starts: &[State<f64>], reverses: bool) -> Sweep<'_> {
        let numbers = self.numbers(robots, starts.len());
        let single = |start: &State<f64>| single(self.printed.starts(std::slice::from_ref(start)));
        let starts: Vec<Vec<f32>> = starts.par_iter().map(single).collect();
        let members = Members {
            starts: &starts.concat(),
            parameters: &numbers,
            steps: self.observed.last().copied().unwrap_or(0),
            inputs: &self.inputs,
            observed: &self.observed,
        };
        let sweep = self.population.prepare(&members, reverses);
        sweep.forward();
        sweep
    }

    /// The numbers of the parameters of all members.
    fn numbers(&self, robots: &Robots<f64>, members: usize) -> Vec<Vec<f32>> {
        let own = [
            robots.surroundings.len(),
            robots.bodies.len(),
            robots.controllers.len(),
        ];
        if members == 1 || own != [members; 3] {
            return (self.printed.numbers(robots).into_iter().map(single)).collect();
        }
        // Nothing is shared, so that each member's numbers can be collected on its own.
        let of_member = |k: usize| -> Vec<Vec<f32>> {
            let (surroundings, body, controller) = of_member(robots, k);
            let lists = self
                .printed
                .numbers_of_one(surroundings, body, controller)
                .into_iter();
            lists.map(single).collect()
        };
        let all: Vec<Vec<Vec<f32>>> = (0..members).into_par_iter().map(of_member).collect();
        let placed = self.printed.program.parameters.par_iter().enumerate();
        let joined = placed.map(|(p, placed)| match placed.is_common {
            true => all[0][p].clone(),
            false => {
                let mut joined = Vec::with_capacity(members * placed.len);
                all.iter().for_each(|lists| joined.extend(&lists[p]));
                joined
            }
        });
        joined.collect()
    }

    /// Simulates robots. If the span is watched, the observed numbers of a robot that exceeded a bound are NaN.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn rollouts(
        &self,
        robots: &Robots<f64>,
        starts: &[State<f64>],
    ) -> Result<Vec<Trajectory<f64>>, GpuError> {
        let sweep = self.sweep(robots, starts, false);
        let seen = sweep.observed()?;
        let exceeded = match self.printed.span().watched {
            true => sweep.exceeded()?,
            false => vec![false; starts.len()],
        };
        let parts = seen.par_chunks(seen.len() / starts.len()).enumerate();
        let trajectory = |(k, part): (usize, &[f32])| {
            let value = |&x: &f32| if exceeded[k] { f64::NAN } else { f64::from(x) };
            let mut seen = self.at_start(&starts[k]);
            seen.extend(part.iter().map(value));
            let (surroundings, body, _) = of_member(robots, k);
            self.printed
                .trajectory(&seen, surroundings, body, &starts[k])
        };
        Ok(parts.map(trajectory).collect())
    }

    /// Returns the losses of all members and their gradients. The loss is computed on the processor, from the states that
    /// the span observes, and differentiated there.
    ///
    /// # Errors
    /// If the device is lost.
    pub fn gradients(
        &self,
        robots: &Robots<f64>,
        starts: &[State<f64>],
        loss: impl Fn(&Trajectory<Var<f64>>) -> Var<f64> + Sync,
    ) -> Result<Gradients, GpuError> {
        self.gradients_by(robots, starts, |_| None, |_, seen| loss(seen))
    }

    /// Like [`gradients`](Self::gradients), with a loss for each member. `origin` are the positions from which the
    /// displacement of a member counts, if they are not its start.
    pub(crate) fn gradients_by<'o>(
        &self,
        robots: &Robots<f64>,
        starts: &[State<f64>],
        origin: impl Fn(usize) -> Option<&'o [Vector<f64>]> + Sync,
        loss: impl Fn(usize, &Trajectory<Var<f64>>) -> Var<f64> + Sync,
    ) -> Result<Gradients, GpuError> {
        let sweep = self.sweep(robots, starts, true);
        let seen = sweep.observed()?;
        let lost = |(k, part): (usize, &[f32])| {
            let (surroundings, body, _) = of_member(robots, k);
            let member = (surroundings, body, &starts[k], origin(k));
            self.lost(part, member, |seen| loss(k, seen))
        };
        let parts = seen.par_chunks(seen.len() / starts.len()).enumerate();
        let lost: Vec<Lost> = parts.map(lost).collect();
        let cotangents: Vec<f32> = lost.iter().flat_map(|lost| &lost.seen).copied().collect();
        sweep.reverse(&cotangents);
        let bars = sweep.cotangents()?;
        let members = (0..starts.len()).into_par_iter();
        let of_members = members.map(|k| self.pulled_back(robots, k, &bars, &lost[k].body));
        let (bodies, controllers) = of_members.unzip();
        let (losses, trajectories) = lost
            .into_iter()
            .map(|lost| (lost.value, lost.trajectory))
            .unzip();
        Ok(Gradients {
            losses,
            trajectories,
            bodies,
            controllers,
            starts: bars.starts,
        })
    }

    /// Computes the loss of a member and differentiates it.
    fn lost(
        &self,
        seen: &[f32],
        (surroundings, body, start, origin): OfLoss,
        loss: impl Fn(&Trajectory<Var<f64>>) -> Var<f64>,
    ) -> Lost {
        let mut numbers: Vec<f64> = seen.iter().map(|&x| f64::from(x)).collect();
        if self.printed.wanted.bodies {
            numbers.extend(body.numbers());
        }
        let (mut tape, mut trajectory) = (Tape::new(), None);
        let value = tape.record(&numbers, |x| {
            let (seen, of_body) = x.split_at(seen.len());
            let at_start = self.at_start(start).into_iter().map(Var::constant);
            let seen: Vec<_> = at_start.chain(seen.iter().copied()).collect();
            let body = match of_body {
                [] => body.map(Var::constant),
                of_body => body.with_numbers(of_body),
            };
            let surroundings = surroundings.map(Var::constant);
            let start = start.map(Var::constant);
            let mut walked = self.printed.trajectory(&seen, &surroundings, &body, &start);
            if let (Some(origin), false) = (origin, walked.start.is_empty()) {
                walked.start = origin.iter().map(|x| x.map(Var::constant)).collect();
            }
            trajectory = Some(walked.map(|x| x.value()));
            loss(&walked)
        });
        let bars = tape.pullback(&[value], &[1.0]);
        Lost {
            value: value.value(),
            trajectory: trajectory.expect("it was just computed"),
            seen: bars[..seen.len()].iter().map(|&x| x as f32).collect(),
            body: bars[seen.len()..].to_vec(),
        }
    }

    /// Pulls the cotangents of a member's parameters back to its body and its controller. `direct` are cotangents of the
    /// body's numbers that are added.
    fn pulled_back(
        &self,
        robots: &Robots<f64>,
        k: usize,
        bars: &Cotangents,
        direct: &[f64],
    ) -> (Body<f64>, Vec<f64>) {
        let (surroundings, body, controller) = of_member(robots, k);
        let wanted = self.printed.wanted;
        let mut flat = Vec::new();
        if wanted.bodies {
            flat.extend(body.numbers());
        }
        let own = flat.len();
        if wanted.controllers {
            flat.extend(controller.numbers());
        }
        let mut tape = Tape::new();
        let numbers = tape.record(&flat, |x| {
            let (of_body, of_controller) = x.split_at(own);
            let body = match wanted.bodies {
                true => body.with_numbers(of_body),
                false => body.map(Var::constant),
            };
            let mut of_policy = controller.map(Var::constant);
            if wanted.controllers {
                of_policy.numbers_mut().copy_from_slice(of_controller);
            }
            self.printed
                .numbers_of_one(&surroundings.map(Var::constant), &body, &of_policy)
        });
        let (mut outputs, mut cotangents) = (Vec::new(), Vec::new());
        for (list, bars) in numbers.into_iter().zip(&bars.parameters) {
            if !bars.is_empty() {
                cotangents.extend(
                    bars[k * list.len()..][..list.len()]
                        .iter()
                        .map(|&x| f64::from(x)),
                );
                outputs.extend(list);
            }
        }
        let mut gradient = tape.pullback(&outputs, &cotangents).to_vec();
        for (g, direct) in gradient.iter_mut().zip(direct) {
            *g += direct;
        }
        let (of_body, of_controller) = gradient.split_at(own);
        let body = match wanted.bodies {
            true => body.with_numbers(of_body),
            false => body.map(|_| 0.0),
        };
        let controller = match wanted.controllers {
            true => of_controller.to_vec(),
            false => vec![0.0; controller.numbers().len()],
        };
        (body, controller)
    }
}

/// What a loss of a member depends on, besides the observed numbers: surroundings, body, start, and the positions from
/// which the displacement counts.
type OfLoss<'a> = (
    &'a Surroundings<f64>,
    &'a Body<f64>,
    &'a State<f64>,
    Option<&'a [Vector<f64>]>,
);

fn single(numbers: Vec<f64>) -> Vec<f32> {
    numbers.into_iter().map(|x| x as f32).collect()
}

/// The surroundings, the body and the controller of a member.
fn of_member<'a, R>(
    robots: &Robots<'a, R>,
    k: usize,
) -> (&'a Surroundings<R>, &'a Body<R>, &'a Controller<R>) {
    let Robots {
        surroundings,
        bodies,
        controllers,
    } = *robots;
    (
        &surroundings[k % surroundings.len()],
        &bodies[k % bodies.len()],
        &controllers[k % controllers.len()],
    )
}
