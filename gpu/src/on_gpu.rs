//! Batches of robots on a device.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use autodiff::Var;
use cosmic::lattice::{Body, State};
use cosmic::policy::Controller;
use cosmic::world::{
    PrintedRobots, Robots, Simulator, Span, Surroundings, Trajectory, Wanted, Workgroup,
};
use rayon::prelude::*;

use crate::device::{Gpu, GpuError};
use crate::population::Population;
use crate::robots::{Differentiated, Losses, Member, RobotsOnGpu};

/// The number of invocations that carry one robot.
pub const WORKGROUP: usize = 128;

/// The most programs that a device keeps.
const KEPT: usize = 32;

/// Robots that one simulator simulates over one span, each from its own start.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The simulator.
    pub simulator: Simulator,
    /// The span of the rollouts.
    pub span: Span,
    /// One for all robots, or one for each.
    pub surroundings: Vec<Surroundings<f64>>,
    /// One for all robots, or one for each.
    pub bodies: Vec<Body<f64>>,
    /// One for all robots, or one for each.
    pub controllers: Vec<Controller<f64>>,
    /// The start of each robot.
    pub starts: Vec<State<f64>>,
}

/// The reason why a device cannot simulate a batch, as a sentence without a full stop.
pub type Refused = String;

/// A device that simulates batches of robots. It divides a batch that does not fit into parts, and keeps the latest
/// programs that it has compiled.
pub struct OnGpu {
    gpu: Gpu,
    compiled: Mutex<VecDeque<Compiled>>,
}

/// A program that is compiled, with its text. Without `reverses`, only its forward sweep is.
struct Compiled {
    source: String,
    reverses: bool,
    population: Arc<Population>,
}

impl Batch {
    fn robots(&self) -> Robots<'_, f64> {
        Robots {
            surroundings: &self.surroundings,
            bodies: &self.bodies,
            controllers: &self.controllers,
        }
    }

    /// Whether the robots share their body and their controller.
    fn shares(&self) -> bool {
        self.starts.len() > 1 && self.bodies.len() == 1 && self.controllers.len() == 1
    }

    /// The robots with these numbers. A single robot comes twice, so that it does not count as shared.
    fn part(&self, members: Range<usize>) -> Self {
        let numbers = match members.len() {
            1 => vec![members.start; 2],
            _ => members.collect(),
        };
        let shares = self.shares();
        Self {
            simulator: self.simulator.clone(),
            span: self.span.clone(),
            surroundings: picked(&self.surroundings, &numbers, shares),
            bodies: picked(&self.bodies, &numbers, shares),
            controllers: picked(&self.controllers, &numbers, shares),
            starts: picked(&self.starts, &numbers, false),
        }
    }
}

/// The entries with these numbers. If all robots have the only entry, it is returned once where robots share entries.
fn picked<T: Clone + Send + Sync>(list: &[T], numbers: &[usize], shares: bool) -> Vec<T> {
    match list {
        [only] if shares => vec![only.clone()],
        list => {
            let numbers = numbers.par_iter();
            numbers.map(|&k| list[k % list.len()].clone()).collect()
        }
    }
}

/// The losses of a part of the robots. A single robot comes twice.
struct OfPart<'a, L> {
    losses: &'a L,
    members: Range<usize>,
}

impl<L> OfPart<'_, L> {
    fn number(&self, robot: usize) -> usize {
        self.members.start + robot % self.members.len()
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
}

impl OnGpu {
    /// Prepares a device.
    pub fn new(gpu: Gpu) -> Self {
        Self {
            gpu,
            compiled: Mutex::default(),
        }
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Computes the rollouts of a batch. If its span is watched, all observations of a robot that exceeded a bound are NaN.
    ///
    /// # Errors
    /// If the device stopped working, or cannot simulate such robots.
    pub fn rollouts(&self, asked: &Batch) -> Result<Vec<Trajectory<f64>>, Refused> {
        let device = self.device(asked, None)?;
        let mut walks = Vec::with_capacity(asked.starts.len());
        for members in parts(&device, asked, false) {
            let part = asked.part(members.clone());
            let walked = device.rollouts(&part.robots(), &part.starts);
            walks.extend(walked.map_err(refused)?.into_iter().take(members.len()));
        }
        Ok(walks)
    }

    /// The losses of a batch and their gradients by any numbers. The robots of `asked` must have the values of those of
    /// `losses`.
    ///
    /// # Errors
    /// If the device stopped working, or cannot simulate such robots.
    pub fn differentiated(
        &self,
        asked: &Batch,
        by: Wanted,
        losses: &impl Losses,
    ) -> Result<Vec<Differentiated>, Refused> {
        let device = self.device(asked, Some(by))?;
        let mut answers = Vec::with_capacity(asked.starts.len());
        for members in parts(&device, asked, true) {
            let part = asked.part(members.clone());
            let count = members.len();
            let losses = OfPart { losses, members };
            let found = device.differentiated(&part.robots(), &part.starts, &losses);
            answers.extend(found.map_err(refused)?.into_iter().take(count));
        }
        Ok(answers)
    }

    /// The compiled program of a batch. If `by` is `None`, it has only the forward sweep.
    fn device(&self, asked: &Batch, by: Option<Wanted>) -> Result<RobotsOnGpu, Refused> {
        let printed = self.printed(asked, by)?;
        let population = self.compiled(&printed, by.is_some()).map_err(refused)?;
        Ok(RobotsOnGpu::of(population, printed))
    }

    /// Prints the program of a batch. If `by` is `None`, only the forward sweep must fit a workgroup. Numbers that do not
    /// fit lie in a buffer.
    fn printed(&self, asked: &Batch, by: Option<Wanted>) -> Result<PrintedRobots, Refused> {
        let wanted = by.unwrap_or_default();
        // Robots that differ, now or later, have one program: that of a robot that lacks nothing.
        let (count, body) = match asked.shares() {
            true => (1, asked.bodies[0].clone()),
            false => (2, asked.bodies[0].map(|_| 1.0)),
        };
        let surroundings = count.max(asked.surroundings.len().min(2));
        let robots = Robots {
            surroundings: &vec![asked.surroundings[0].clone(); surroundings],
            bodies: &vec![body; count],
            controllers: &vec![asked.controllers[0].clone(); count],
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
        let population = Arc::new(Population::new(&self.gpu, program.clone(), reverses)?);
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
}

/// The numbers of the robots, in parts that fit the device.
fn parts(
    device: &RobotsOnGpu,
    asked: &Batch,
    reverses: bool,
) -> impl Iterator<Item = Range<usize>> + use<> {
    let (count, room) = (asked.starts.len(), device.room(reverses).max(2));
    (0..count)
        .step_by(room)
        .map(move |first| first..(first + room).min(count))
}

fn refused(error: GpuError) -> Refused {
    match error {
        // The caller says that the device stopped working.
        GpuError::Failed(why) => why,
        error => error.told(&std::env::temp_dir()),
    }
}
