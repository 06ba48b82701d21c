//! Compares robots on a device with the processor.

use autodiff::{Real, Tape, Var};
use cosmic::case::Case;
use cosmic::geometry::{Vector, flat, from_flat};
use cosmic::lattice::{Body, State};
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::simulator::{
    PrintedRobots, Robots, Simulator, Span, Surroundings, Trajectory, Wanted, Workgroup,
};
use cosmic_gpu::{Gpu, GpuError, RobotsOnGpu, WORKGROUP};

/// The mean of the positions of all nodes in all observed states: forward, and a little upward.
pub(crate) fn loss<R: Real>(trajectory: &Trajectory<R>) -> R {
    let mean = |state: &State<R>| {
        let sum = (state.x.iter()).fold(R::zero(), |sum, x| sum + x[0] + R::lit(0.3) * x[1]);
        sum * R::lit(1.0 / state.x.len() as f64)
    };
    trajectory.states.iter().map(mean).sum()
}

/// The robots from which an optimisation of a scene begins with two seeds.
pub(crate) struct Begun {
    pub(crate) simulator: Simulator,
    pub(crate) bodies: Vec<Body<f64>>,
    pub(crate) controllers: Vec<Controller<f64>>,
    pub(crate) starts: Vec<State<f64>>,
    pub(crate) surroundings: [Surroundings<f64>; 1],
    /// The distance of neighbouring nodes, m.
    pub(crate) spacing: f64,
}

impl Begun {
    pub(crate) fn new(scene: &Scene) -> Self {
        Self::of([0, 1].map(|seed| Case::of_scene(scene, seed).unwrap()))
    }

    pub(crate) fn of(cases: [Case; 2]) -> Self {
        let first = &cases[0];
        let simulator = first.task().simulator;
        Self {
            surroundings: [simulator.surroundings()],
            bodies: cases.iter().map(Case::body).collect(),
            controllers: cases.iter().map(|case| case.controller.clone()).collect(),
            starts: cases.iter().map(|case| case.start.clone()).collect(),
            spacing: first.lattice.spacing,
            simulator,
        }
    }

    pub(crate) fn robots(&self) -> Robots<'_, f64> {
        Robots {
            surroundings: &self.surroundings,
            bodies: &self.bodies,
            controllers: &self.controllers,
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
        let printed = (self.simulator).printed(&self.robots(), &span, wanted, workgroup);
        printed.unwrap_or_else(|error| panic!("{error}"))
    }

    /// Compares the printed robots with rollouts in `f32` on the processor.
    pub(crate) fn compare(&self, gpu: &Gpu, printed: PrintedRobots) -> Result<Compared, GpuError> {
        let device = RobotsOnGpu::new(gpu, printed)?;
        let walked = device.rollouts(&self.robots(), &self.starts)?;
        let gradients = device.gradients(&self.robots(), &self.starts, loss)?;
        let mut compared = Compared {
            position: 0.0,
            cosine: 1.0,
        };
        for (k, walked) in walked.iter().enumerate() {
            let (expected, slopes) = self.on_processor(k, device.printed().span());
            for (a, b) in positions(walked).into_iter().zip(expected) {
                compared.position =
                    f64::max(compared.position, (a - b).abs() / (10.0 * self.spacing));
            }
            let body = &gradients.bodies[k];
            let start = &gradients.starts[k];
            let lists = [
                &body.stiffness,
                &body.strain,
                &body.mass,
                &body.presence,
                &gradients.controllers[k],
                &self.flat_above(k, &start.x),
                &self.flat_above(k, &start.v),
            ];
            for (list, expected) in lists.into_iter().zip(&slopes) {
                // A number that is zero stands for a part that the robot does not have, and has no slope here.
                let pairs = list.iter().zip(expected);
                let there = pairs.filter(|(_, expected)| **expected != 0.0);
                let (list, expected): (Vec<f64>, Vec<f64>) = there.unzip();
                compared.cosine = compared.cosine.min(cosine(&list, &expected));
            }
        }
        Ok(compared)
    }

    /// The coordinates of the nodes that are above the ground at the start. A node exactly on the ground is at the kink of
    /// the contact, where rounding decides the slope.
    pub(crate) fn flat_above(&self, k: usize, points: &[Vector<f64>]) -> Vec<f64> {
        let columns = self.simulator.flatten(&self.starts[k]);
        let heights = &columns[points.len()..];
        let above = points.iter().zip(heights).filter(|(_, up)| **up > 1e-6);
        above.flat_map(|(point, _)| [point[0], point[1]]).collect()
    }

    /// The positions of a member, and the slopes of its loss by stiffnesses, strains, masses, presence, controller, and the
    /// positions and velocities at the start.
    pub(crate) fn on_processor(&self, k: usize, span: &Span) -> (Vec<f64>, Vec<Vec<f64>>) {
        let single = |x: f64| x as f32;
        let (body, start) = (self.bodies[k].map(single), self.starts[k].map(single));
        let controller = self.controllers[k].map(single);
        let lists = [
            &body.stiffness[..],
            &body.strain,
            &body.mass,
            &body.presence,
            controller.numbers(),
            &flat(&start.x),
            &flat(&start.v),
        ];
        let (mut tape, mut states) = (Tape::new(), Vec::new());
        let result = tape.record(&lists.concat(), |x| {
            let mut rest = x;
            let [stiffness, strain, mass, presence, of_policy, x, v] = lists.map(|list| {
                let (part, others) = rest.split_at(list.len());
                rest = others;
                part
            });
            // Parts that a robot does not have are left out only if their number is a constant zero.
            let or_zero = |list: &[Var<f32>]| -> Vec<Var<f32>> {
                let one = |x: &Var<f32>| {
                    if x.value() == 0.0 {
                        Var::constant(0.0)
                    } else {
                        *x
                    }
                };
                list.iter().map(one).collect()
            };
            let body = Body {
                stiffness: or_zero(stiffness),
                strain: or_zero(strain),
                largest_strain: body.largest_strain,
                mass: mass.to_vec(),
                presence: or_zero(presence),
                marker: body.marker.map(Var::constant),
            };
            let mut controller = controller.map(Var::constant);
            controller.numbers_mut().copy_from_slice(of_policy);
            let start = State {
                x: from_flat(x),
                v: from_flat(v),
            };
            let walked = (self.simulator).rollout(&body, &controller, &start, span);
            states = positions(&walked)
                .iter()
                .map(|x| f64::from(x.value()))
                .collect();
            loss(&walked)
        });
        let mut slopes = tape.pullback(&[result], &[1.0]);
        let parts = lists.map(|list| {
            let (part, others) = slopes.split_at(list.len());
            slopes = others;
            part.iter().map(|&x| f64::from(x)).collect::<Vec<f64>>()
        });
        let mut parts = parts.to_vec();
        for of_start in &mut parts[5..] {
            *of_start = self.flat_above(k, &from_flat(of_start));
        }
        (states, parts)
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
    nodes.flat_map(|x| [x[0], x[1]]).collect()
}

/// The cosine of the angle between two gradients.
pub(crate) fn cosine(a: &[f64], b: &[f64]) -> f64 {
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
