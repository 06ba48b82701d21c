//! Any number of robots on a device.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use autodiff::{Parameters, Var};
use cosmic::world::{Robot, Span, Trajectory, World};

use crate::device::{Gpu, GpuError};
use crate::population::Population;
use crate::printed::{PrintedRobots, Wanted, Workgroup};
use crate::robots::{Differentiated, Losses, RobotsOnGpu, share_build};

/// The number of invocations that carry one robot.
pub const WORKGROUP: usize = 128;

/// The most programs that a device keeps.
const KEPT: usize = 32;

/// The reason why a device cannot simulate robots, as a sentence without a full stop.
pub type Refused = String;

/// A device that simulates any number of robots. It divides robots that do not fit at once into parts, and keeps the latest
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

/// The losses of the robots from number `first` on.
struct Later<'a, L> {
    losses: &'a L,
    first: usize,
}

impl<L: Losses> Losses for Later<'_, L> {
    fn numbers(&self, robot: usize) -> Vec<f64> {
        self.losses.numbers(self.first + robot)
    }
    fn robot(&self, robot: usize, numbers: &[Var<f64>]) -> Robot<Var<f64>> {
        self.losses.robot(self.first + robot, numbers)
    }
    fn loss(&self, robot: usize, walk: &Trajectory<Var<f64>>) -> Var<f64> {
        self.losses.loss(self.first + robot, walk)
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

    /// Simulates robots and returns the observed states of each, as [`World::run`] does. If the span is watched, all
    /// observations of a robot that exceeded a bound are NaN.
    ///
    /// # Errors
    /// If the device stopped working, or cannot simulate such robots.
    ///
    /// # Panics
    /// If there is no robot.
    pub fn run(
        &self,
        world: &World,
        robots: &[Robot<f64>],
        span: &Span,
    ) -> Result<Vec<Trajectory<f64>>, Refused> {
        let device = self.device(world, robots, span, None)?;
        let mut walks = Vec::with_capacity(robots.len());
        for part in robots.chunks(device.room(false)) {
            walks.extend(device.run(part).map_err(refused)?);
        }
        Ok(walks)
    }

    /// The losses of robots and their gradients by any numbers. `robots` must have the values of the robots of `losses`.
    ///
    /// # Errors
    /// If the device stopped working, or cannot simulate such robots.
    ///
    /// # Panics
    /// Like [`run`](Self::run).
    pub fn differentiated(
        &self,
        world: &World,
        robots: &[Robot<f64>],
        span: &Span,
        by: Wanted,
        losses: &impl Losses,
    ) -> Result<Vec<Differentiated>, Refused> {
        let device = self.device(world, robots, span, Some(by))?;
        let mut answers = Vec::with_capacity(robots.len());
        for part in robots.chunks(device.room(true)) {
            let first = answers.len();
            let found = device.differentiated(part, &Later { losses, first });
            answers.extend(found.map_err(refused)?);
        }
        Ok(answers)
    }

    /// The compiled program of robots. If `by` is `None`, it has only the forward sweep.
    fn device(
        &self,
        world: &World,
        robots: &[Robot<f64>],
        span: &Span,
        by: Option<Wanted>,
    ) -> Result<RobotsOnGpu, Refused> {
        let printed = self.printed(world, robots, span, by)?;
        let population = self.compiled(&printed, by.is_some()).map_err(refused)?;
        Ok(RobotsOnGpu::of(population, printed))
    }

    /// Prints the program of robots. If `by` is `None`, only the forward sweep must fit a workgroup. Numbers that do not
    /// fit lie in a buffer.
    fn printed(
        &self,
        world: &World,
        robots: &[Robot<f64>],
        span: &Span,
        by: Option<Wanted>,
    ) -> Result<PrintedRobots, Refused> {
        let (wanted, robots) = (by.unwrap_or_default(), examples(robots));
        let printed = |memory: usize| {
            let workgroup = Workgroup {
                invocations: WORKGROUP,
                memory,
            };
            let printed = PrintedRobots::new(world, &robots, span, wanted, workgroup);
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

/// One or two robots that share what all of these robots share, for the program of these robots. Robots that differ, now or
/// later, have one program: that of a robot that lacks nothing.
fn examples(robots: &[Robot<f64>]) -> Vec<Robot<f64>> {
    let first = &robots[0];
    let share = robots.iter().all(|robot| share_build(first, robot));
    if share && robots.len() > 1 {
        let is_other = |robot: &&Robot<f64>| !Arc::ptr_eq(&robot.surroundings, &first.surroundings);
        let other = robots.iter().find(is_other);
        return [first].into_iter().chain(other).cloned().collect();
    }
    let example = || Robot {
        body: first.body.map(|_| 1.0),
        ..first.map(|x| x)
    };
    vec![example(), example()]
}

fn refused(error: GpuError) -> Refused {
    match error {
        // The caller says that the device stopped working.
        GpuError::Failed(why) => why,
        error => error.told(&std::env::temp_dir()),
    }
}
