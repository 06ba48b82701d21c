//! Robot-steps per second against the number of robots, on a device and on the processor.

use std::error::Error;
use std::sync::Arc;
use std::time::Instant;

use autodiff::{Parameters, Real, Tape, Var};
use clap::Args;
use cosmic::case::Case;
use cosmic::lattice::Body;
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::world::{Robot, Span, Trajectory, World};
use cosmic_gpu::{Gpu, PrintedRobots, RobotsOnGpu, WORKGROUP, Wanted};
use rayon::prelude::*;

/// The settings of a measurement.
#[derive(Args)]
pub(crate) struct Settings {
    /// A built-in scene or a file
    #[arg(default_value = "earth")]
    scene: String,
    /// The numbers of robots
    #[arg(
        long,
        value_delimiter = ',',
        default_value = "1,16,64,256,1024,4096,16384"
    )]
    robots: Vec<usize>,
    /// The number of steps
    #[arg(long, default_value_t = 512)]
    steps: usize,
    /// Take the adapter with this text in its name
    #[arg(long)]
    device: Option<String>,
}

/// The work that is measured.
#[derive(Clone, Copy, PartialEq)]
enum Work {
    Forward,
    OfDesigns,
    OfControllers,
}

const WORK: [(Work, &str); 3] = [
    (Work::Forward, "forward"),
    (Work::OfDesigns, "gradients of designs"),
    (Work::OfControllers, "gradients of controllers"),
];

/// The robots of a measurement: designs and controllers of a few seeds, again and again.
struct Drawn {
    world: World,
    robots: Vec<Robot<f64>>,
}

const SEEDS: usize = 16;

impl Drawn {
    fn new(scene: &Scene) -> cosmic::Result<Self> {
        let cases = (0..SEEDS as u64).map(|seed| Case::of_scene(scene, seed));
        let cases = cases.collect::<cosmic::Result<Vec<_>>>()?;
        let world = cases[0].world();
        let surroundings = Arc::new(world.surroundings());
        let robot = |case: &Case| case.robot().in_surroundings(Arc::clone(&surroundings));
        Ok(Self {
            robots: cases.iter().map(robot).collect(),
            world,
        })
    }

    /// So many robots. They have their own controllers, or `shared` ones: those of the first.
    fn robots(&self, count: usize, shared: bool) -> Vec<Robot<f64>> {
        let robots = self.robots.iter().cycle().take(count).cloned();
        let first = &self.robots[0].controller;
        let robot = |robot: Robot<f64>| match shared {
            true => Robot {
                controller: Arc::clone(first),
                ..robot
            },
            false => robot,
        };
        robots.map(robot).collect()
    }
}

pub(crate) fn run(settings: &Settings) -> Result<(), Box<dyn Error>> {
    let scene = Scene::load(&settings.scene)?;
    let drawn = Drawn::new(&scene)?;
    let gpu = Gpu::open(settings.device.as_deref())?.with_memory(8 << 30);
    let cores = std::thread::available_parallelism()?;
    println!(
        "{}, {} steps; {}; processor: {cores} threads, f32",
        settings.scene,
        settings.steps,
        gpu.adapter().name
    );
    println!();
    println!(
        "| work | weights | robots | device, robot-steps/s | processor, robot-steps/s | ratio |"
    );
    println!("| --- | --- | --: | --: | --: | --: |");
    for (work, name) in WORK {
        for (shared, weights) in [(false, "own"), (true, "shared")] {
            for &robots in &settings.robots {
                let processor = on_processor(&drawn, settings.steps, robots, work, shared);
                match on_device(&gpu, &drawn, settings.steps, robots, (work, shared)) {
                    Ok(device) => println!(
                        "| {name} | {weights} | {robots} | {device:.3e} | {processor:.3e} | {:.2} |",
                        device / processor
                    ),
                    Err(error) => println!("| {name} | {weights} | {robots} | {error} | | |"),
                }
            }
        }
    }
    Ok(())
}

/// The shortest of a few measured times, s.
fn shortest(mut work: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..3).map(time).fold(f64::INFINITY, f64::min)
}

/// A rollout of which the payload is observed twice.
fn span(steps: usize) -> Span {
    Span {
        nodes: 1,
        ..Span::from_start(vec![steps / 2, steps])
    }
}

/// Robot-steps per second on the device, without the copies to and from it.
fn on_device(
    gpu: &Gpu,
    drawn: &Drawn,
    steps: usize,
    robots: usize,
    (work, shared): (Work, bool),
) -> Result<f64, Box<dyn Error>> {
    let robots = drawn.robots(robots, shared);
    let wanted = Wanted {
        bodies: work == Work::OfDesigns,
        controllers: work == Work::OfControllers,
        surroundings: false,
    };
    let printed = PrintedRobots::new(&drawn.world, &robots, &span(steps), wanted, WORKGROUP)?;
    let cotangents = vec![1.0; robots.len() * 2 * printed.program.entries()];
    let device = RobotsOnGpu::new(gpu, printed)?;
    let sweep = device.sweep(&robots, work != Work::Forward);
    let waited = || gpu.wait().expect("the device was lost");
    waited();
    let seconds = shortest(|| {
        sweep.forward();
        if work != Work::Forward {
            sweep.reverse(&cotangents);
        }
        waited();
    });
    Ok((robots.len() * steps) as f64 / seconds)
}

/// Robot-steps per second on all threads of the processor. Robots that share a controller run in the lanes of registers.
fn on_processor(drawn: &Drawn, steps: usize, robots: usize, work: Work, shared: bool) -> f64 {
    let at_once = if shared { 16 } else { 1 };
    let robots = drawn.robots(robots, shared);
    // Enough for a fair mean; more robots take as much longer.
    let measured = 16 * std::thread::available_parallelism().map_or(1, usize::from);
    let bundles: Vec<&[Robot<f64>]> = robots.chunks(at_once).take(measured).collect();
    let bundle = |robots: &&[Robot<f64>]| {
        let few = Few {
            world: &drawn.world,
            robots,
            span: span(steps),
        };
        match work {
            Work::Forward => {
                drop(few.rolled(|body| body.map(single), robots[0].controller.map(single)));
            }
            _ => few.differentiate(work),
        }
        robots.len()
    };
    let mut done = 0;
    let seconds = shortest(|| done = bundles.par_iter().map(bundle).sum::<usize>());
    (done * steps) as f64 / seconds
}

fn single(x: f64) -> f32 {
    x as f32
}

/// Robots with one controller that the processor simulates together.
struct Few<'a> {
    world: &'a World,
    robots: &'a [Robot<f64>],
    span: Span,
}

impl Few<'_> {
    /// Simulates the robots with these bodies and this controller.
    fn rolled<R: Real>(
        &self,
        mut body: impl FnMut(&Body<f64>) -> Body<R>,
        controller: Arc<Controller<R>>,
    ) -> Vec<Trajectory<R>> {
        let surroundings = Arc::new(self.world.surroundings());
        let robot = |robot: &Robot<f64>| Robot {
            body: Arc::new(body(&robot.body)),
            controller: Arc::clone(&controller),
            surroundings: Arc::clone(&surroundings),
            start: robot.start.map(R::lit),
        };
        let robots: Vec<Robot<R>> = self.robots.iter().map(robot).collect();
        self.world.run(&robots, &self.span)
    }

    /// Computes the gradient of a distance by the bodies or by the controller.
    fn differentiate(&self, work: Work) {
        let (of_bodies, controller) = (work == Work::OfDesigns, &self.robots[0].controller);
        let bodies = self.robots.iter().map(|robot| &robot.body);
        let numbers: Vec<f64> = match of_bodies {
            true => bodies.flat_map(|body| body.flatten()).collect(),
            false => controller.numbers().to_vec(),
        };
        let numbers: Vec<f32> = numbers.into_iter().map(single).collect();
        let mut tape = Tape::new();
        let loss = tape.record(&numbers, |mut x: &[Var<f32>]| {
            let mut controller = (**controller).map(Var::lit);
            if !of_bodies {
                controller.numbers_mut().copy_from_slice(x);
            }
            let body = |body: &Body<f64>| match of_bodies {
                true => {
                    let (own, others) = x.split_at(body.flatten().len());
                    x = others;
                    body.with(own)
                }
                false => body.map(Var::lit),
            };
            let walks = self.rolled(body, Arc::new(controller));
            let states = walks.iter().flat_map(|walk| &walk.states);
            states.map(|state| state.x[0].forward()).sum::<Var<f32>>()
        });
        tape.pullback(&[loss], &[1.0]);
    }
}
