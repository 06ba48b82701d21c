//! Compares robots on a device with the processor.

use std::sync::Arc;

use autodiff::{Parameters, Real, Tape, Var};
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::scene::Scene;
use cosmic::world::{Robot, Span, Trajectory, World};
use cosmic_gpu::{Gpu, GpuError, Losses, PrintedRobots, RobotsOnGpu, WORKGROUP, Wanted, Workgroup};

/// The mean of the positions of all nodes in all observed states: forward, and a little upward.
fn loss<R: Real>(trajectory: &Trajectory<R>) -> R {
    let mean = |state: &State<R>| {
        let sum =
            (state.x.iter()).fold(R::zero(), |sum, x| sum + x.forward() + R::lit(0.3) * x.up());
        sum * R::lit(1.0 / state.x.len() as f64)
    };
    trajectory.states.iter().map(mean).sum()
}

/// The robots from which an optimisation of a scene begins with two seeds.
pub(crate) struct Begun {
    pub(crate) world: World,
    pub(crate) robots: Vec<Robot<f64>>,
}

impl Begun {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self::of([0, 1].map(|seed| Case::of_scene(scene, seed).unwrap()))
    }

    pub(crate) fn of(cases: [Case; 2]) -> Self {
        let world = cases[0].world();
        let surroundings = Arc::new(world.surroundings());
        let robot = |case: &Case| case.robot().in_surroundings(Arc::clone(&surroundings));
        Self {
            robots: cases.iter().map(robot).collect(),
            world,
        }
    }

    pub(crate) fn printed(&self, steps: usize, memory: usize) -> PrintedRobots {
        let span = Span::from_start(vec![steps / 2, steps]);
        let wanted = Wanted {
            bodies: true,
            controllers: true,
            surroundings: false,
        };
        let workgroup = Workgroup {
            invocations: WORKGROUP,
            memory,
        };
        let printed = PrintedRobots::new(&self.world, &self.robots, &span, wanted, workgroup);
        printed.unwrap_or_else(|error| panic!("{error}"))
    }

    /// Compares the printed robots with rollouts in `f32` on the processor.
    pub(crate) fn compare(&self, gpu: &Gpu, printed: PrintedRobots) -> Result<Compared, GpuError> {
        let device = RobotsOnGpu::new(gpu, printed)?;
        let walked = device.run(&self.robots)?;
        let differentiated = device.differentiated(&self.robots, self)?;
        let mut compared = Compared {
            position: 0.0,
            cosine: 1.0,
        };
        for (k, (walked, found)) in walked.iter().zip(&differentiated).enumerate() {
            let (expected, slopes) = self.on_processor(k, device.printed().span());
            for (a, b) in positions(walked).into_iter().zip(expected) {
                let spacing = self.world.lattice().spacing;
                compared.position = f64::max(compared.position, (a - b).abs() / (10.0 * spacing));
            }
            let lists = self.lists(k, &found.gradient).into_iter();
            for (list, expected) in lists.zip(self.lists(k, &slopes)) {
                // A number that is zero stands for a part that the robot does not have, and has no slope here.
                let pairs = list.into_iter().zip(expected);
                let there = pairs.filter(|(_, expected)| *expected != 0.0);
                let (list, expected): (Vec<f64>, Vec<f64>) = there.unzip();
                compared.cosine = compared.cosine.min(cosine(&list, &expected));
            }
        }
        Ok(compared)
    }

    /// The robot with these numbers of its body, its controller and its start.
    fn with_numbers<R: Real>(&self, k: usize, numbers: &[R]) -> Robot<R> {
        let robot = &self.robots[k];
        let (of_body, rest) = numbers.split_at(robot.body.flatten().len());
        let mut controller = (*robot.controller).map(R::lit);
        let (of_controller, rest) = rest.split_at(controller.numbers().len());
        controller.numbers_mut().copy_from_slice(of_controller);
        let start = rest.split_at(rest.len() / 2);
        Robot {
            surroundings: robot.surroundings.map(R::lit),
            body: robot.body.with(of_body),
            controller: Arc::new(controller),
            start: State::from_flat(robot.start.dimension, start.into()),
        }
    }

    /// The slopes by stiffnesses, strains, masses, presence, controller, and the positions and velocities at the start.
    fn lists(&self, k: usize, slopes: &[f64]) -> [Vec<f64>; 7] {
        let slopes = self.with_numbers(k, slopes);
        let (body, start) = (&slopes.body, &slopes.start);
        [
            body.stiffness.clone(),
            body.strain.clone(),
            body.mass.clone(),
            body.presence.clone(),
            slopes.controller.numbers().to_vec(),
            self.flat_above(k, &start.x),
            self.flat_above(k, &start.v),
        ]
    }

    /// The coordinates of the nodes that are above the ground at the start. A node exactly on the ground is at the kink of
    /// the contact, where rounding decides the slope.
    fn flat_above(&self, k: usize, points: &[Vector<f64>]) -> Vec<f64> {
        let columns = self.world.flatten(&self.robots[k].start);
        let heights = &columns[points.len()..];
        let above = points.iter().zip(heights).filter(|(_, up)| **up > 1e-6);
        above.flat_map(|(point, _)| point.in_plane()).collect()
    }

    /// The positions of a member, and the slopes of its loss by its [numbers](Losses::numbers).
    fn on_processor(&self, k: usize, span: &Span) -> (Vec<f64>, Vec<f64>) {
        let numbers: Vec<f32> = self.numbers(k).iter().map(|&x| x as f32).collect();
        let of_body = self.robots[k].body.flatten().len();
        let (mut tape, mut places) = (Tape::new(), Vec::new());
        let result = tape.record(&numbers, |x: &[Var<f32>]| {
            // Parts that a robot does not have are left out only if their number is a constant zero.
            let or_zero = |(at, x): (usize, &Var<f32>)| match at < of_body && x.value() == 0.0 {
                true => Var::constant(0.0),
                false => *x,
            };
            let x: Vec<Var<f32>> = x.iter().enumerate().map(or_zero).collect();
            let walk = self.world.run_one(&self.with_numbers(k, &x), span);
            let values = positions(&walk).into_iter().map(|x| f64::from(x.value()));
            places = values.collect();
            loss(&walk)
        });
        let slopes = tape.pullback(&[result], &[1.0]).iter();
        (places, slopes.map(|&x| f64::from(x)).collect())
    }
}

impl Losses for Begun {
    fn numbers(&self, robot: usize) -> Vec<f64> {
        let robot = &self.robots[robot];
        let [x, v] = robot.start.to_flat();
        [
            &robot.body.flatten()[..],
            robot.controller.numbers(),
            &x,
            &v,
        ]
        .concat()
    }

    fn robot(&self, robot: usize, numbers: &[Var<f64>]) -> Robot<Var<f64>> {
        self.with_numbers(robot, numbers)
    }

    fn loss(&self, _: usize, walk: &Trajectory<Var<f64>>) -> Var<f64> {
        loss(walk)
    }
}

/// How well a device agrees with the processor.
#[derive(Debug)]
pub(crate) struct Compared {
    /// The largest difference of two positions, in ten spacings.
    pub(crate) position: f64,
    /// The smallest cosine between two groups of slopes.
    pub(crate) cosine: f64,
}

/// The coordinates of all nodes in all observed states.
pub(crate) fn positions<R: Real>(trajectory: &Trajectory<R>) -> Vec<R> {
    let nodes = trajectory.states.iter().flat_map(|state| &state.x);
    nodes.flat_map(|x| x.in_plane()).collect()
}

/// The cosine of the angle between two gradients.
fn cosine(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    match dot(a, a) * dot(b, b) {
        0.0 => 1.0,
        squares => dot(a, b) / squares.sqrt(),
    }
}

/// Asserts that a scene begins alike on a device and on the processor. Rounding in single precision moves positions by
/// about 3e-7 in 64 steps; in 256 steps contacts amplify it, and only the directions of gradients are compared.
#[track_caller]
pub(crate) fn assert_alike(gpu: &Gpu, name: &str, scene: &Scene) {
    assert_alike_in(gpu, name, scene, gpu.memory_of_workgroup());
}

/// Like [`assert_alike`], for workgroups with this much memory, in bytes.
#[track_caller]
pub(crate) fn assert_alike_in(gpu: &Gpu, name: &str, scene: &Scene, memory: usize) {
    let begun = Begun::new(scene);
    for (steps, most) in [(64, 1e-5), (256, f64::INFINITY)] {
        let printed = begun.printed(steps, memory);
        if printed.program.spilled() > 0 {
            println!(
                "{name}: {} numbers lie in a buffer",
                printed.program.spilled()
            );
        }
        let compared = begun.compare(gpu, printed);
        let compared = compared.unwrap_or_else(|error| panic!("{name}: {error}"));
        println!("{name}, {steps} steps: {compared:?}");
        assert!(
            compared.position < most && compared.cosine > 0.9999,
            "{name}: {compared:?}"
        );
    }
}
