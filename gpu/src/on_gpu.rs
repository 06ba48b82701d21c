//! Populations of `cosmic` on a device.

use std::collections::VecDeque;
use std::num::NonZeroUsize;
use std::sync::{Arc, Mutex, PoisonError};

use autodiff::Var;
use cosmic::geometry::Vector;
use cosmic::lattice::{Body, State};
use cosmic::policy::Controller;
use cosmic::population::{Batch, GradientBatch, Populations, Refused, RobotGradient};
use cosmic::simulator::{PrintedRobots, Robots, Span, Surroundings, Trajectory, Wanted, Workgroup};
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::device::{Gpu, GpuError};
use crate::population::Population;
use crate::robots::{ByParts, Differentiated, Losses, Member, RobotsOnGpu};

/// The number of invocations that carry one robot.
pub const WORKGROUP: usize = 128;

/// The most programs that a device keeps.
const KEPT: usize = 32;

/// A device that simulates populations. It keeps the latest programs that it has compiled.
pub struct OnGpu {
    gpu: Gpu,
    compiled: Mutex<VecDeque<Compiled>>,
    /// The threads that prepare robots for the device.
    pool: ThreadPool,
}

/// A program that is compiled, with its text. Without `reverses`, only its forward sweep is.
struct Compiled {
    source: String,
    reverses: bool,
    population: Arc<Population>,
}

/// Robots of several populations that one program simulates.
struct Joined<'a> {
    device: RobotsOnGpu,
    /// For each robot, the number of its population, and its number there.
    members: Vec<[usize; 2]>,
    asked: Vec<&'a Batch>,
    /// Whether the robots share what their only population shares.
    shares: bool,
}

/// The robots of a part of the members.
struct Part {
    surroundings: Vec<Surroundings<f64>>,
    bodies: Vec<Body<f64>>,
    controllers: Vec<Controller<f64>>,
    starts: Vec<State<f64>>,
}

impl Part {
    fn robots(&self) -> Robots<'_, f64> {
        Robots {
            surroundings: &self.surroundings,
            bodies: &self.bodies,
            controllers: &self.controllers,
        }
    }
}

/// The losses of a part of the robots. A single robot comes twice.
struct OfPart<'a, L> {
    losses: &'a L,
    members: &'a [[usize; 2]],
}

impl<L> OfPart<'_, L> {
    fn number(&self, robot: usize) -> usize {
        self.members[robot % self.members.len()][1]
    }
}

impl<L: Losses> Losses for OfPart<'_, L> {
    fn numbers(&self, robot: usize) -> Vec<f64> {
        self.losses.numbers(self.number(robot))
    }
    fn robot(&self, robot: usize, numbers: &[Var<f64>]) -> Member<Var<f64>> {
        self.losses.robot(self.number(robot), numbers)
    }
    fn loss(&self, robot: usize, walk: &Trajectory<Var<f64>>) -> Var<f64> {
        self.losses.loss(self.number(robot), walk)
    }
    fn origin(&self, robot: usize) -> Option<&[Vector<f64>]> {
        self.losses.origin(self.number(robot))
    }
}

impl OnGpu {
    /// Prepares a device. Its work is prepared on this many threads, by default one per core.
    ///
    /// # Errors
    /// If the threads cannot be started.
    pub fn new(gpu: Gpu, threads: Option<NonZeroUsize>) -> Result<Self, GpuError> {
        let threads = threads.map_or(0, NonZeroUsize::get);
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        Ok(Self {
            gpu,
            compiled: Mutex::default(),
            pool: pool.map_err(|error| GpuError::Failed(error.to_string()))?,
        })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The robots of a population as a program, with which it can be joined to others. If `by` is `None`, only the forward
    /// sweep must fit a workgroup. Numbers that do not fit lie in a buffer.
    pub fn printed(&self, asked: &Batch, by: Option<Wanted>) -> Result<PrintedRobots, Refused> {
        let wanted = by.unwrap_or_default();
        let (shares, two) = (shares(asked), |count: usize| if count == 1 { 1 } else { 2 });
        let [surroundings, bodies, controllers] = match shares {
            true => [
                asked.surroundings.len(),
                asked.bodies.len(),
                asked.controllers.len(),
            ]
            .map(two),
            false => [2; 3],
        };
        let bodies = match bodies {
            1 => vec![asked.bodies[0].clone()],
            // Robots that differ, now or later, have one program: that of a robot that lacks nothing.
            _ => vec![asked.bodies[0].map(|_| 1.0); 2],
        };
        let robots = Robots {
            surroundings: &vec![asked.surroundings[0].clone(); surroundings],
            bodies: &bodies,
            controllers: &vec![asked.controllers[0].clone(); controllers],
        };
        let printed = |memory: usize| {
            let workgroup = Workgroup {
                invocations: WORKGROUP,
                memory,
            };
            let printed = (asked.simulator).printed(&robots, &asked.span, wanted, workgroup);
            printed.map_err(|error| error.to_string())
        };
        let whole = printed(usize::MAX)?;
        let reverses = usize::from(by.is_some());
        match self.gpu.memory_of_workgroup() {
            memory if whole.program.memory()[reverses] <= memory => Ok(whole),
            memory => printed(memory),
        }
    }

    /// The losses of a population and their gradients by any numbers. The robots of `asked` must have the values of those
    /// of `losses`.
    ///
    /// # Errors
    /// If the device stopped working, or cannot simulate such robots.
    pub fn differentiated(
        &self,
        asked: &Batch,
        by: Wanted,
        losses: &impl Losses,
    ) -> Result<Vec<Differentiated>, Refused> {
        self.pool.install(|| {
            let mut answers = Vec::with_capacity(asked.starts.len());
            for joined in self.joined(&[asked], &[by], true)? {
                for members in joined.parts(true) {
                    let part = joined.part(members);
                    let losses = OfPart { losses, members };
                    let found = joined
                        .device
                        .differentiated(&part.robots(), &part.starts, &losses);
                    answers.extend(found.map_err(refused)?.into_iter().take(members.len()));
                }
            }
            Ok(answers)
        })
    }

    /// Compiles a program, unless it is compiled already.
    fn compiled(
        &self,
        printed: &PrintedRobots,
        reverses: bool,
    ) -> Result<Arc<Population>, GpuError> {
        let program = &printed.program;
        let mut known = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        let same =
            |known: &&Compiled| known.source == program.source() && (known.reverses || !reverses);
        if let Some(known) = known.iter().find(same) {
            return Ok(Arc::clone(&known.population));
        }
        let population = Arc::new(match reverses {
            true => Population::new(&self.gpu, program.clone())?,
            false => Population::only_forward(&self.gpu, program.clone())?,
        });
        if known.len() == KEPT {
            known.pop_front();
        }
        known.push_back(Compiled {
            source: program.source().to_owned(),
            reverses,
            population: Arc::clone(&population),
        });
        Ok(population)
    }

    /// Joins populations that have the same program and the same span.
    fn joined<'a>(
        &self,
        asked: &[&'a Batch],
        wanted: &[Wanted],
        reverses: bool,
    ) -> Result<Vec<Joined<'a>>, Refused> {
        let mut joined: Vec<Joined> = Vec::new();
        for (p, (batch, wanted)) in asked.iter().zip(wanted).enumerate() {
            let is_same = |other: &&mut Joined| {
                let [first, _] = other.members[0];
                !other.shares
                    && !shares(batch)
                    && other.device.printed().wanted == *wanted
                    && is_alike(asked[first], batch)
            };
            let members = (0..batch.starts.len()).map(|k| [p, k]);
            if let Some(other) = joined.iter_mut().find(is_same) {
                other.members.extend(members);
                continue;
            }
            let printed = self.printed(batch, reverses.then_some(*wanted))?;
            let population = self.compiled(&printed, reverses).map_err(refused)?;
            joined.push(Joined {
                device: RobotsOnGpu::of(population, printed),
                members: members.collect(),
                asked: asked.to_vec(),
                shares: shares(batch),
            });
        }
        Ok(joined)
    }
}

/// Whether one program simulates the robots of both populations over the same span.
fn is_alike(a: &Batch, b: &Batch) -> bool {
    let kind = |batch: &Batch| {
        let Span {
            first,
            nodes,
            watched,
            cotangent_bound,
            metered,
            ..
        } = batch.span;
        let weighs = !batch.bodies[0].presence.is_empty();
        let identity = batch.simulator.identity();
        (
            identity,
            first,
            nodes,
            watched,
            cotangent_bound,
            metered,
            weighs,
        )
    };
    kind(a) == kind(b) && a.span.observed == b.span.observed
}

/// Whether the robots of a population share something.
fn shares(asked: &Batch) -> bool {
    asked.starts.len() > 1 && asked.bodies.len() == 1 && asked.controllers.len() == 1
}

fn refused(error: GpuError) -> Refused {
    match error {
        // The caller says that the device stopped working.
        GpuError::Failed(why) => why,
        error => error.told(&std::env::temp_dir()),
    }
}

impl Joined<'_> {
    /// The robots with these numbers. A single robot comes twice, so that it does not count as shared.
    fn part(&self, members: &[[usize; 2]]) -> Part {
        let members = match members {
            [only] => &[*only, *only],
            members => members,
        };
        if self.shares {
            let asked = self.asked[members[0][0]];
            let chosen = |k: &[usize; 2]| k[1];
            let numbers: Vec<usize> = members.iter().map(chosen).collect();
            return Part {
                surroundings: picked(&asked.surroundings, &numbers),
                bodies: picked(&asked.bodies, &numbers),
                controllers: picked(&asked.controllers, &numbers),
                starts: numbers.iter().map(|&k| asked.starts[k].clone()).collect(),
            };
        }
        let all = members.par_iter().map(|&[p, k]| (self.asked[p], k));
        Part {
            surroundings: (all.clone())
                .map(|(of, k)| of.surroundings[k % of.surroundings.len()].clone())
                .collect(),
            bodies: (all.clone())
                .map(|(of, k)| of.bodies[k % of.bodies.len()].clone())
                .collect(),
            controllers: (all.clone())
                .map(|(of, k)| of.controllers[k % of.controllers.len()].clone())
                .collect(),
            starts: all.map(|(of, k)| of.starts[k].clone()).collect(),
        }
    }

    /// The members in parts that fit the device.
    fn parts(&self, reverses: bool) -> impl Iterator<Item = &[[usize; 2]]> {
        self.members.chunks(self.device.room(reverses).max(2))
    }
}

/// The entries with these numbers if each robot has its own, otherwise the only entry.
fn picked<T: Clone>(list: &[T], numbers: &[usize]) -> Vec<T> {
    match list {
        [only] => vec![only.clone()],
        list => numbers.iter().map(|&k| list[k].clone()).collect(),
    }
}

/// Lists with room for an answer for each robot of each population.
fn places<T: Clone>(asked: &[&Batch]) -> Vec<Vec<Option<T>>> {
    asked
        .iter()
        .map(|asked| vec![None; asked.starts.len()])
        .collect()
}

fn filled<T>(places: Vec<Vec<Option<T>>>) -> Vec<Vec<T>> {
    let each = |list: Vec<Option<T>>| {
        let list = list.into_iter();
        list.map(|answer| answer.expect("every robot is in one part"))
            .collect()
    };
    places.into_iter().map(each).collect()
}

impl Populations for OnGpu {
    fn name(&self) -> String {
        self.gpu.adapter().name.clone()
    }

    fn check(&self, asked: &Batch, by: Option<Wanted>) -> Result<(), Refused> {
        let printed = self.printed(asked, by)?;
        let compiled = self.compiled(&printed, by.is_some());
        compiled.map(drop).map_err(refused)
    }

    fn rollouts(&self, asked: &[Batch]) -> Result<Vec<Vec<Trajectory<f64>>>, Refused> {
        self.pool.install(|| {
            let asked: Vec<&Batch> = asked.iter().collect();
            let wanted = vec![Wanted::default(); asked.len()];
            let mut answers = places(&asked);
            for joined in self.joined(&asked, &wanted, false)? {
                for members in joined.parts(false) {
                    let part = joined.part(members);
                    let walked = joined.device.rollouts(&part.robots(), &part.starts);
                    for (&[p, k], walked) in members.iter().zip(walked.map_err(refused)?) {
                        answers[p][k] = Some(walked);
                    }
                }
            }
            Ok(filled(answers))
        })
    }

    fn gradients(&self, asked: &[GradientBatch]) -> Result<Vec<Vec<RobotGradient>>, Refused> {
        self.pool.install(|| {
            let of: Vec<&Batch> = asked.iter().map(|asked| &asked.of).collect();
            let wanted: Vec<Wanted> = asked.iter().map(|asked| asked.by).collect();
            let mut answers = places(&of);
            for joined in self.joined(&of, &wanted, true)? {
                for members in joined.parts(true) {
                    let part = joined.part(members);
                    // A single robot comes twice.
                    let member = |k: usize| members[k % members.len()];
                    let losses = ByParts {
                        robots: part.robots(),
                        starts: &part.starts,
                        wanted: joined.device.printed().wanted,
                        by_start: false,
                        loss: |k: usize, walk: &Trajectory<Var<f64>>| {
                            asked[member(k)[0]].loss.loss_of(walk)
                        },
                        origin: |k: usize| {
                            let [p, k] = member(k);
                            asked[p].origins.get(k).map(Vec::as_slice)
                        },
                    };
                    let found = (joined.device)
                        .differentiated(&part.robots(), &part.starts, &losses)
                        .map_err(refused)?;
                    for (j, (&[p, k], found)) in members.iter().zip(found).enumerate() {
                        let (body, controller, _) = losses.split(j, &found.gradient);
                        answers[p][k] = Some(RobotGradient {
                            loss: found.loss,
                            trajectory: found.trajectory,
                            body,
                            controller,
                        });
                    }
                }
            }
            Ok(filled(answers))
        })
    }
}
