//! Losses and gradients of a population of robots.

use std::sync::Arc;

use autodiff::{Parameters, Real, Tape, Var};
use cosmic::world::{Robot, Trajectory};
use rayon::prelude::*;

use crate::device::{Gpu, GpuError};
use crate::population::{Cotangents, Members, Population, Sweep};
use crate::printed::PrintedRobots;

/// Robots on a device.
pub struct RobotsOnGpu {
    population: Arc<Population>,
    printed: PrintedRobots,
    inputs: Vec<f32>,
    /// The numbers of steps after which the program observes the state.
    observed: Vec<usize>,
}

/// The losses of the robots of a population, and the numbers by which they are differentiated.
pub trait Losses: Sync {
    /// The numbers by which the loss of a robot is differentiated.
    fn numbers(&self, robot: usize) -> Vec<f64>;

    /// The robot as a function of these numbers. Bodies, controllers or surroundings that were not
    /// [wanted](crate::Wanted) when the step was printed count as constant in the rollout. If cotangents are
    /// bounded, those of an observed start are added after the bound.
    fn robot(&self, robot: usize, numbers: &[Var<f64>]) -> Robot<Var<f64>>;

    /// The loss of a walk.
    fn loss(&self, robot: usize, walk: &Trajectory<Var<f64>>) -> Var<f64>;
}

/// The loss of a robot and its gradient by the numbers of [`Losses`].
#[derive(Clone, Debug)]
pub struct Differentiated {
    /// The loss.
    pub loss: f64,
    /// The trajectory.
    pub trajectory: Trajectory<f64>,
    /// The gradient.
    pub gradient: Vec<f64>,
}

/// What a loss says of one member.
struct Lost {
    value: f64,
    trajectory: Trajectory<f64>,
    /// The cotangents of the observed numbers.
    seen: Vec<f32>,
    /// The gradient through the loss alone, at constant observed numbers.
    direct: Vec<f64>,
}

impl RobotsOnGpu {
    /// Compiles the printed step of robots for a device.
    ///
    /// # Errors
    /// If it is too large for the device, or its driver refuses it.
    pub fn new(gpu: &Gpu, printed: PrintedRobots) -> Result<Self, GpuError> {
        let population = Population::new(gpu, printed.program.clone(), true)?;
        Ok(Self::of(Arc::new(population), printed))
    }

    /// Robots whose program is compiled already.
    pub(crate) fn of(population: Arc<Population>, printed: PrintedRobots) -> Self {
        Self {
            population,
            inputs: printed
                .recorded
                .rollout()
                .inputs
                .iter()
                .map(|&x| x as f32)
                .collect(),
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
    fn at_start<R: Real>(&self, robot: &Robot<R>) -> Vec<R> {
        if self.printed.span().observed.first() != Some(&0) {
            return Vec::new();
        }
        let flat = self.printed.recorded.start(robot);
        let nodes = robot.start.x.len();
        let observed = self.printed.span().nodes.min(nodes);
        let parts = 2 * robot.start.dimension.count();
        let of_nodes = (0..parts).flat_map(|k| (0..observed).map(move |node| k * nodes + node));
        let entries = of_nodes.chain(parts * nodes..flat.len());
        entries.map(|entry| flat[entry]).collect()
    }

    /// Runs robots forward and returns the sweep. With `reverses`, it can be followed by a reverse sweep.
    ///
    /// # Panics
    /// Like [`run`](Self::run).
    pub fn sweep(&self, robots: &[Robot<f64>], reverses: bool) -> Sweep<'_> {
        let numbers = self.numbers(robots);
        let start = |robot: &Robot<f64>| single(self.printed.recorded.start(robot));
        let starts: Vec<Vec<f32>> = robots.par_iter().map(start).collect();
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

    /// The numbers of the parameters of all robots.
    fn numbers(&self, robots: &[Robot<f64>]) -> Vec<Vec<f32>> {
        let parameters = self.printed.program.parameters();
        let of = |robot: &Robot<f64>| -> Vec<Vec<f32>> {
            let lists = self.printed.numbers_of_one(robot).into_iter();
            lists.map(single).collect()
        };
        let first = of(&robots[0]);
        // Neighbours that share everything have the same numbers.
        let alike: Vec<&[Robot<f64>]> = robots.chunk_by(share_all).collect();
        let own = |alike: &&[Robot<f64>]| {
            let mut lists = of(&alike[0]);
            let common = (0..lists.len()).filter(|&p| parameters[p].is_common);
            for p in common {
                assert!(
                    are_same(&lists[p], &first[p]),
                    "these robots share other numbers than those for which the program was printed"
                );
                lists[p] = Vec::new();
            }
            lists
        };
        let all: Vec<Vec<Vec<f32>>> = alike.par_iter().map(own).collect();
        let placed = parameters.par_iter().enumerate();
        let joined = placed.map(|(p, placed)| match placed.is_common {
            true => first[p].clone(),
            false => {
                let mut joined = Vec::with_capacity(robots.len() * placed.len);
                for (alike, lists) in alike.iter().zip(&all) {
                    alike.iter().for_each(|_| joined.extend(&lists[p]));
                }
                joined
            }
        });
        joined.collect()
    }

    /// Simulates robots and returns the observed states of each. If the span is watched, the observed numbers of a robot
    /// that exceeded a bound are NaN.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// If there is no robot, or if the robots differ in numbers that those for which the program was printed share.
    pub fn run(&self, robots: &[Robot<f64>]) -> Result<Vec<Trajectory<f64>>, GpuError> {
        let sweep = self.sweep(robots, false);
        let seen = sweep.observed()?;
        let exceeded = match self.printed.span().watched {
            true => sweep.exceeded()?,
            false => vec![false; robots.len()],
        };
        let trajectory = |(k, robot): (usize, &Robot<f64>)| {
            let value = |&x: &f32| if exceeded[k] { f64::NAN } else { f64::from(x) };
            let mut numbers = self.at_start(robot);
            numbers.extend(self.seen_of(k, &seen).iter().map(value));
            self.printed.recorded.trajectory(&numbers, robot)
        };
        Ok(robots.par_iter().enumerate().map(trajectory).collect())
    }

    /// The observed numbers of a member among those of all members.
    fn seen_of<'a>(&self, k: usize, seen: &'a [f32]) -> &'a [f32] {
        let count = self.observed.len() * self.printed.program.entries();
        &seen[k * count..][..count]
    }

    /// Returns the losses of all members and their gradients by any numbers. The losses are computed on the processor, from
    /// the states that the span observes, and differentiated there. `robots` must have the values of the robots of `losses`.
    ///
    /// # Errors
    /// If the device is lost.
    ///
    /// # Panics
    /// Like [`run`](Self::run).
    pub fn differentiated(
        &self,
        robots: &[Robot<f64>],
        losses: &impl Losses,
    ) -> Result<Vec<Differentiated>, GpuError> {
        let sweep = self.sweep(robots, true);
        let seen = sweep.observed()?;
        let members = (0..robots.len()).into_par_iter();
        let lost = members.map(|k| self.lost(k, self.seen_of(k, &seen), losses));
        let lost: Vec<Lost> = lost.collect();
        let cotangents: Vec<f32> = lost.iter().flat_map(|lost| &lost.seen).copied().collect();
        sweep.reverse(&cotangents);
        let bars = sweep.cotangents()?;
        let found = lost.into_par_iter().enumerate();
        let found = found.map(|(k, lost)| self.pulled_back(k, lost, losses, &bars));
        Ok(found.collect())
    }

    /// Computes the loss of a member and differentiates it.
    fn lost(&self, k: usize, seen: &[f32], losses: &impl Losses) -> Lost {
        let mut numbers: Vec<f64> = seen.iter().map(|&x| f64::from(x)).collect();
        numbers.extend(losses.numbers(k));
        let (mut tape, mut trajectory) = (Tape::new(), None);
        let value = tape.record(&numbers, |x| {
            let (seen, own) = x.split_at(seen.len());
            let robot = losses.robot(k, own);
            let seen = [&self.at_start(&robot), seen].concat();
            let walk = (self.printed.recorded).trajectory(&seen, &robot);
            trajectory = Some(walk.map(|x| x.value()));
            losses.loss(k, &walk)
        });
        let bars = tape.pullback(&[value], &[1.0]);
        Lost {
            value: value.value(),
            trajectory: trajectory.expect("it was just computed"),
            seen: bars[..seen.len()].iter().map(|&x| x as f32).collect(),
            direct: bars[seen.len()..].to_vec(),
        }
    }

    /// Pulls the cotangents of a member's parameters and of its start back to the numbers of the losses.
    fn pulled_back(
        &self,
        k: usize,
        lost: Lost,
        losses: &impl Losses,
        bars: &Cotangents,
    ) -> Differentiated {
        let (mut tape, mut cotangents) = (Tape::new(), Vec::new());
        let outputs = tape.record(&losses.numbers(k), |own| {
            let robot = losses.robot(k, own);
            let numbers = self.printed.numbers_of_one(&robot);
            let start = self.printed.recorded.start(&robot);
            let mut outputs = Vec::new();
            let lists = numbers.into_iter().zip(&bars.parameters);
            let lists = lists.filter(|(_, bars)| !bars.is_empty());
            for (list, bars) in lists.chain([(start, &bars.starts)]) {
                let own = &bars[k * list.len()..][..list.len()];
                cotangents.extend(own.iter().map(|&x| f64::from(x)));
                outputs.extend(list);
            }
            outputs
        });
        let gradient = tape.pullback(&outputs, &cotangents).iter();
        Differentiated {
            loss: lost.value,
            trajectory: lost.trajectory,
            gradient: gradient
                .zip(lost.direct)
                .map(|(g, direct)| g + direct)
                .collect(),
        }
    }
}

/// True if two robots share everything but their starts.
fn share_all(a: &Robot<f64>, b: &Robot<f64>) -> bool {
    share_build(a, b) && Arc::ptr_eq(&a.surroundings, &b.surroundings)
}

/// True if two robots share their body and their controller.
pub(crate) fn share_build(a: &Robot<f64>, b: &Robot<f64>) -> bool {
    Arc::ptr_eq(&a.body, &b.body) && Arc::ptr_eq(&a.controller, &b.controller)
}

/// True if two lists have the same bits, so that NaN equals itself.
fn are_same(a: &[f32], b: &[f32]) -> bool {
    bytemuck::cast_slice::<f32, u32>(a) == bytemuck::cast_slice::<f32, u32>(b)
}

fn single(numbers: Vec<f64>) -> Vec<f32> {
    numbers.into_iter().map(|x| x as f32).collect()
}
