//! Robot-steps per second against the number of robots, on a device and on the processor.

use std::error::Error;
use std::time::Instant;

use autodiff::wgsl::Placed;
use autodiff::{Real, Tape, Var};
use clap::Args;
use cosmic::case::Case;
use cosmic::lattice::{Body, State};
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::simulator::{Robots, Simulator, Span, Trajectory, Wanted};
use cosmic_gpu::{Gpu, Members, Population, WORKGROUP};
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
    simulator: Simulator,
    cases: Vec<Case>,
    bodies: Vec<Body<f64>>,
}

const SEEDS: usize = 16;

impl Drawn {
    fn new(scene: &Scene) -> cosmic::Result<Self> {
        let case = |seed| Case::of_scene(scene, seed);
        let cases = (0..SEEDS as u64)
            .map(case)
            .collect::<cosmic::Result<Vec<_>>>()?;
        Ok(Self {
            simulator: cases[0].task().simulator,
            bodies: cases.iter().map(Case::body).collect(),
            cases,
        })
    }
}

pub(crate) fn run(settings: &Settings) -> Result<(), Box<dyn Error>> {
    let scene = Scene::load(&settings.scene)?;
    let drawn = Drawn::new(&scene)?;
    let gpu = Gpu::open(settings.device.as_deref())?;
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

/// Robot-steps per second on the device, without the copies to and from it.
fn on_device(
    gpu: &Gpu,
    drawn: &Drawn,
    steps: usize,
    robots: usize,
    (work, shared): (Work, bool),
) -> Result<f64, Box<dyn Error>> {
    let surroundings = [drawn.simulator.surroundings()];
    let controllers: Vec<_> = drawn
        .cases
        .iter()
        .map(|case| case.controller.clone())
        .collect();
    let few = Robots {
        surroundings: &surroundings,
        bodies: &drawn.bodies,
        controllers: if shared {
            &controllers[..1]
        } else {
            &controllers
        },
    };
    let wanted = Wanted {
        bodies: work == Work::OfDesigns,
        controllers: work == Work::OfControllers,
        surroundings: false,
    };
    let mut span = Span::from_start(vec![steps / 2, steps]);
    span.nodes = 1;
    let printed = drawn.simulator.printed(&few, &span, wanted, WORKGROUP)?;
    // The numbers of the few robots are repeated.
    let repeated = |(list, placed): (Vec<f64>, &Placed)| -> Vec<f32> {
        let (len, count) = (placed.len, if placed.is_common { 1 } else { robots });
        let own = list.len() / len.max(1);
        let part = |k: usize| list[(k % own.max(1)) * len..][..len].iter();
        (0..count).flat_map(part).map(|&x| x as f32).collect()
    };
    let numbers = printed
        .numbers(&few)
        .into_iter()
        .zip(printed.program.parameters());
    let parameters: Vec<Vec<f32>> = numbers.map(repeated).collect();
    let single = |numbers: &[f64]| numbers.iter().map(|&x| x as f32).collect::<Vec<f32>>();
    let starts = single(&printed.starts(&[drawn.cases[0].start.clone()])).repeat(robots);
    let inputs = single(&printed.inputs);
    let members = Members {
        starts: &starts,
        parameters: &parameters,
        steps,
        inputs: &inputs,
        observed: &span.observed,
    };
    let mut population = Population::new(gpu, printed.program)?;
    population.memory = 8 << 30;
    let sweep = population.prepare(&members, work != Work::Forward);
    let cotangents = vec![1.0; robots * 2 * population.printed().entries()];
    let waited = || gpu.wait().expect("the device was lost");
    sweep.forward();
    waited();
    let seconds = shortest(|| {
        sweep.forward();
        if work != Work::Forward {
            sweep.reverse(&cotangents);
        }
        waited();
    });
    Ok((robots * steps) as f64 / seconds)
}

/// Robot-steps per second on all threads of the processor. Robots that share a controller run in the lanes of registers.
fn on_processor(drawn: &Drawn, steps: usize, robots: usize, work: Work, shared: bool) -> f64 {
    let single = |x: f64| x as f32;
    let bodies: Vec<Body<f32>> = drawn.bodies.iter().map(|body| body.map(single)).collect();
    let controllers: Vec<_> = drawn
        .cases
        .iter()
        .map(|case| case.controller.map(single))
        .collect();
    let start = drawn.cases[0].start.map(single);
    let mut span = Span::from_start(vec![steps / 2, steps]);
    span.nodes = 1;
    let at_once = if shared { 16 } else { 1 };
    let bundles = robots.div_ceil(at_once);
    // Enough for a fair mean; more robots take as much longer.
    let measured = bundles.min(16 * std::thread::available_parallelism().map_or(1, usize::from));
    let bundle = |k: usize| {
        let count = at_once.min(robots - k * at_once);
        let own: Vec<&Body<f32>> = (0..count)
            .map(|j| &bodies[(k * at_once + j) % SEEDS])
            .collect();
        let controller = &controllers[if shared { 0 } else { k % SEEDS }];
        if work == Work::Forward {
            let bodies: Vec<Body<f32>> = own.into_iter().cloned().collect();
            let starts = vec![start.clone(); count];
            rolled(&drawn.simulator, &bodies, controller, &starts, &span);
            return count;
        }
        let of_bodies = work == Work::OfDesigns;
        let flat: Vec<f32> = match of_bodies {
            true => own
                .iter()
                .flat_map(|body| [&body.stiffness[..], &body.strain, &body.mass].concat())
                .collect(),
            false => controller.numbers().to_vec(),
        };
        let mut tape = Tape::new();
        let loss = tape.record(&flat, |x: &[Var<f32>]| {
            let mut bodies: Vec<Body<Var<f32>>> =
                own.iter().map(|body| body.map(Var::constant)).collect();
            let mut controller = controller.map(Var::constant);
            if of_bodies {
                let mut rest = x;
                for body in &mut bodies {
                    for list in [&mut body.stiffness, &mut body.strain, &mut body.mass] {
                        let (part, others) = rest.split_at(list.len());
                        list.copy_from_slice(part);
                        rest = others;
                    }
                }
            } else {
                controller.numbers_mut().copy_from_slice(x);
            }
            let starts = vec![start.map(Var::constant); count];
            let all = rolled(&drawn.simulator, &bodies, &controller, &starts, &span);
            all.iter()
                .flat_map(|t| t.states.iter().map(|state| state.x[0][0]))
                .sum::<Var<f32>>()
        });
        tape.pullback(&[loss], &[1.0]);
        count
    };
    let mut done = 0;
    let seconds = shortest(|| done = (0..measured).into_par_iter().map(bundle).sum::<usize>());
    (done * steps) as f64 / seconds
}

/// Simulates robots with one controller on the processor.
fn rolled<R: Real>(
    simulator: &Simulator,
    bodies: &[Body<R>],
    controller: &Controller<R>,
    starts: &[State<R>],
    span: &Span,
) -> Vec<Trajectory<R>> {
    let robots = Robots {
        surroundings: &[simulator.surroundings()],
        bodies,
        controllers: std::slice::from_ref(controller),
    };
    simulator.rollouts(&robots, starts, span)
}
