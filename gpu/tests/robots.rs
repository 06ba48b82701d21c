//! Robots of the built-in scenes, on a device and on the processor.

use std::path::PathBuf;

use autodiff::{Real, Tape, Var};
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::geometry::{Vector, flat, from_flat};
use cosmic::lattice::{Body, Lattice, State};
use cosmic::laws::{Contact, Impact, Law, Node, NodeForce, contact, on_nodes};
use cosmic::policy::Controller;
use cosmic::population::{Batch, Populations};
use cosmic::scene::{BUILTIN, Integrator, Scene};
use cosmic::settings::within;
use cosmic::simulator::{
    PrintedRobots, Robots, Simulator, Span, Surroundings, Trajectory, Wanted, Workgroup,
};
use cosmic_gpu::{Gpu, GpuError, OnGpu, RobotsOnGpu};

/// Opens a device. Without one, the tests say so and end.
fn gpu() -> Option<Gpu> {
    match Gpu::open(std::env::var("COSMIC_GPU").ok().as_deref()) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            println!("SKIPPED: {error}");
            None
        }
    }
}

/// The mean of the positions of all nodes in all observed states: forward, and a little upward.
fn loss<R: Real>(trajectory: &Trajectory<R>) -> R {
    let mean = |state: &State<R>| {
        let sum = (state.x.iter()).fold(R::zero(), |sum, x| sum + x[0] + R::lit(0.3) * x[1]);
        sum * R::lit(1.0 / state.x.len() as f64)
    };
    trajectory.states.iter().map(mean).sum()
}

/// The robots from which an optimisation of a scene begins with two seeds.
struct Begun {
    simulator: Simulator,
    bodies: Vec<Body<f64>>,
    controllers: Vec<Controller<f64>>,
    starts: Vec<State<f64>>,
    surroundings: [Surroundings<f64>; 1],
    /// The distance of neighbouring nodes, m.
    spacing: f64,
}

impl Begun {
    fn new(scene: &Scene) -> Self {
        Self::of([0, 1].map(|seed| Case::of_scene(scene, seed).unwrap()))
    }

    fn of(cases: [Case; 2]) -> Self {
        let first = &cases[0];
        let simulator = Simulator::new(&first.lattice, &first.physics, &first.observation);
        Self {
            surroundings: [simulator.surroundings()],
            bodies: cases.iter().map(Case::body).collect(),
            controllers: cases.iter().map(|case| case.controller.clone()).collect(),
            starts: cases.iter().map(|case| case.start.clone()).collect(),
            spacing: first.lattice.spacing,
            simulator,
        }
    }

    fn robots(&self) -> Robots<'_, f64> {
        Robots {
            surroundings: &self.surroundings,
            bodies: &self.bodies,
            controllers: &self.controllers,
        }
    }

    fn printed(&self, steps: usize, memory: usize) -> PrintedRobots {
        let span = Span::from_start(vec![steps / 2, steps]);
        let wanted = Wanted {
            bodies: true,
            controllers: true,
            surroundings: false,
        };
        let workgroup = Workgroup {
            invocations: 64,
            memory,
        };
        let printed = (self.simulator).printed(&self.robots(), &span, wanted, workgroup);
        printed.unwrap_or_else(|error| panic!("{error}"))
    }

    /// Compares the printed robots with rollouts in `f32` on the processor.
    fn compare(&self, gpu: &Gpu, printed: PrintedRobots) -> Result<Compared, GpuError> {
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
    fn flat_above(&self, k: usize, points: &[Vector<f64>]) -> Vec<f64> {
        let columns = self.simulator.flatten(&self.starts[k]);
        let heights = &columns[points.len()..];
        let above = points.iter().zip(heights).filter(|(_, up)| **up > 1e-6);
        above.flat_map(|(point, _)| [point[0], point[1]]).collect()
    }

    /// The positions of a member, and the slopes of its loss by stiffnesses, strains, masses, presence, controller, and the
    /// positions and velocities at the start.
    fn on_processor(&self, k: usize, span: &Span) -> (Vec<f64>, Vec<Vec<f64>>) {
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
struct Compared {
    /// The largest difference of two positions, in ten spacings.
    position: f64,
    /// The smallest cosine between two groups of slopes.
    cosine: f64,
}

/// The coordinates of all nodes in all observed states.
fn positions<R: Real>(trajectory: &Trajectory<R>) -> Vec<R> {
    let nodes = trajectory.states.iter().flat_map(|state| &state.x);
    nodes.flat_map(|x| [x[0], x[1]]).collect()
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
fn assert_alike(gpu: &Gpu, name: &str, scene: &Scene) {
    assert_alike_in(gpu, name, scene, gpu.memory_of_workgroup());
}

/// Like [`assert_alike`], for workgroups with this much memory, in bytes.
#[track_caller]
fn assert_alike_in(gpu: &Gpu, name: &str, scene: &Scene, memory: usize) {
    let begun = Begun::new(scene);
    for (steps, most) in [(64, 1e-5), (256, f64::INFINITY)] {
        let printed = begun.printed(steps, memory);
        if printed.program.spilled > 0 {
            println!(
                "{name}: {} numbers lie in a buffer",
                printed.program.spilled
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

#[test]
fn scenes_begin_alike_on_a_device_and_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    for name in BUILTIN.map(|scene| scene.name) {
        let scene = Scene::load(name).unwrap();
        // Implicit steps are refused, as another test checks.
        if scene.physics.integrator != Integrator::Implicit {
            assert_alike(&gpu, name, &scene);
        }
    }
}

/// One robot from several starts walks like several equal robots, also if the population is divided.
#[test]
fn robots_may_share_body_and_controller() {
    let Some(gpu) = gpu() else { return };
    let begun = Begun::new(&Scene::load("stability").unwrap());
    let moved = |k: usize| {
        let mut start = begun.starts[0].clone();
        start.x[5] += Vector::upright(0.0, 0.001 * k as f64);
        start
    };
    let shared = Batch {
        simulator: begun.simulator.clone(),
        span: Span::from_start(vec![0, 32]),
        surroundings: begun.surroundings.to_vec(),
        bodies: begun.bodies[..1].to_vec(),
        controllers: begun.controllers[..1].to_vec(),
        starts: (0..3).map(moved).collect(),
    };
    let own = Batch {
        bodies: vec![shared.bodies[0].clone(); 3],
        controllers: vec![shared.controllers[0].clone(); 3],
        ..shared.clone()
    };
    // Two robots at a time.
    let device = OnGpu::new(gpu.with_memory(1), None).unwrap();
    let walked = device.rollouts(&[shared.clone(), own]).unwrap();
    let pairs = walked[0].iter().zip(&walked[1]).zip(&shared.starts);
    for ((shared, own), start) in pairs {
        let [a, b] = [shared, own].map(positions);
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
        // The two programs may order sums differently: rounding of 32 steps.
        assert!(apart.fold(0.0, f64::max) < 1e-6);
        // The state at the start is observed too.
        assert!((shared.states[0].x[5][1] - start.x[5][1]).abs() < 1e-7);
    }
}

/// In a watched span, the observations of a robot that was too fast are NaN, also those before.
#[test]
fn a_robot_that_is_too_fast_has_no_observations() {
    let Some(gpu) = gpu() else { return };
    let mut begun = Begun::new(&Scene::load("stability").unwrap());
    // The last node is at the top; the lowest ones would stop where they touch the ground.
    let fast = begun.starts[1].v.last_mut().unwrap();
    *fast = Vector::upright(1e5, 0.0);
    let span = Span {
        watched: true,
        ..Span::from_start(vec![4, 8])
    };
    let printed = begun
        .simulator
        .printed(&begun.robots(), &span, Wanted::default(), 64)
        .unwrap();
    let device = RobotsOnGpu::new(&gpu, printed).unwrap();
    let walked = device.rollouts(&begun.robots(), &begun.starts).unwrap();
    for (k, is_fast) in [false, true].into_iter().enumerate() {
        let single = |x: f64| x as f32;
        let here = begun.simulator.rollout(
            &begun.bodies[k].map(single),
            &begun.controllers[k].map(single),
            &begun.starts[k].map(single),
            &span,
        );
        assert!(positions(&here).iter().all(|x| x.is_nan() == is_fast));
        assert!(positions(&walked[k]).iter().all(|x| x.is_nan() == is_fast));
    }
}

/// Numbers of a step that do not fit the memory of a workgroup lie in a buffer: some of them, or all.
#[test]
fn numbers_may_lie_in_a_buffer() {
    let Some(gpu) = gpu() else { return };
    let scene = "base = \"earth\"\nlattice.columns = 3\nlattice.rows = 3";
    let scene = Scene::parse("small", scene).unwrap();
    let program = Begun::new(&scene).printed(8, usize::MAX).program;
    let whole = program.memory[1];
    assert_eq!(program.spilled, 0);
    for memory in [whole - 1, whole / 2, 0] {
        let spilled = Begun::new(&scene).printed(8, memory).program;
        assert!(spilled.memory[1] <= memory && spilled.spilled > 0);
        assert_alike_in(&gpu, "small", &scene, memory);
    }
}

/// The robots of the reference cases over 64 steps; each is simulated twice. Their contacts double an error every 13 steps, so
/// longer rollouts would compare rounding.
#[test]
fn reference_cases_walk_alike_on_a_device_and_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/reference");
    let files = std::fs::read_dir(folder).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    let is_case = |path: &PathBuf| path.extension().is_some_and(|is| is == "json");
    let mut files: Vec<PathBuf> = files.filter(is_case).collect();
    files.sort();
    assert!(files.len() > 10);
    for path in files {
        let mut case = Case::read(&path).unwrap();
        case.physics.steps = case.physics.steps.max(64);
        let name = path.file_stem().unwrap().to_string_lossy();
        let begun = Begun::of([case.clone(), case]);
        let printed = begun.printed(64, gpu.memory_of_workgroup());
        let compared = begun.compare(&gpu, printed).unwrap();
        println!("{name}: {compared:?}");
        // Two nodes that coincide are joined by a bar whose direction is rounding only.
        let (position, cosine) = match name.starts_with("coincident") {
            true => (1e-3, 0.999),
            false => (1e-5, 0.9999),
        };
        assert!(compared.position < position, "{name}: {compared:?}");
        assert!(compared.cosine > cosine, "{name}: {compared:?}");
    }
}

cosmic::settings! {
    /// A wind that blows in gusts, stronger higher up.
    struct Gusts<R> {
        /// Drag of a node.
        drag: R = 0.02, allowed within(0.0, 10.0), unit "N s/m", source "an example";
    }
}

impl Law for Gusts {
    const NAME: &'static str = "gusts";
}

impl NodeForce for Gusts {
    const NEEDS_TIME: bool = true;

    #[inline(always)]
    fn force<R: Real, const D: usize>(gusts: &Gusts<R>, node: Node<R, D>) -> Vector<R, D> {
        let air = Vector::upright(node.x.up() * (node.time * R::lit(3.0)).sin(), R::zero());
        (air - node.v) * gusts.drag
    }
}

cosmic::settings! {
    /// Mud, which slows down every node that touches it.
    struct Mud<R> {
        /// Rate at which a velocity along the ground decays.
        rate: R = 300.0, allowed within(0.0, 1e5), unit "1/s", source "an example";
    }
}

impl Law for Mud {
    const NAME: &'static str = "mud";
}

impl Contact for Mud {
    #[inline(always)]
    fn respond<R: Real, const D: usize>(mud: &Mud<R>, impact: Impact<R, D>) -> Vector<R, D> {
        impact.velocity.along() * (-mud.rate * impact.rest).exp()
    }
}

cosmic::settings! {
    /// A magnet, which pulls the first nodes of the lattice.
    struct Magnet<R> {
        /// Position: distance along the ground, and height above it.
        place: [R; 2] = [1.0, 0.5], allowed within(-1e3, 1e3), unit "m", source "an example";
        /// Pull at a distance of a metre.
        pull: R = 0.2, allowed within(0.0, 1e3), unit "N", source "an example";
    }
}

impl Law for Magnet {
    const NAME: &'static str = "magnet";
}

impl NodeForce for Magnet {
    fn weight(&self, node: usize, _: &Lattice) -> f64 {
        f64::from(u8::from(node < 3))
    }

    #[inline(always)]
    fn force<R: Real, const D: usize>(magnet: &Magnet<R>, node: Node<R, D>) -> Vector<R, D> {
        let [along, above] = magnet.place;
        let d = Vector::upright(along, above) - node.x;
        d * (node.weight * magnet.pull / (d.dot(d) + R::lit(0.09)))
    }
}

/// Laws, also those of a user, and a profile of the ground run on a device without a line written for them.
#[test]
fn laws_act_alike_on_a_device_and_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    let registry = (Registry::default().with_law(on_nodes::<Gusts>()))
        .with_law(on_nodes::<Magnet>())
        .with_law(contact::<Mud>());
    let forces = ["gusts", "magnet", "actuator", "rope", "buckle"];
    let mut worlds = forces
        .map(|name| (name, format!("physics.forces = [{name:?}]")))
        .to_vec();
    worlds.push(("mud", "physics.contact = \"mud\"".to_owned()));
    // The feet of the robot stand on slopes.
    let points = "points = [[-0.1, 0.0], [0.03, -0.02], [0.12, -0.01], [0.5, -0.05]]";
    worlds.push((
        "slopes",
        format!("[ground]\nprofile = \"points\"\n{points}"),
    ));
    for (name, world) in worlds {
        let lattice = "lattice.columns = 3\nlattice.rows = 3";
        let scene = format!("base = \"stability\"\n{lattice}\n{world}");
        assert_alike(&gpu, name, &registry.parse(name, &scene).unwrap());
    }
}

/// An error in the adjoint of the kernel with the longest text is seen.
#[test]
fn a_planted_error_is_seen() {
    let Some(gpu) = gpu() else { return };
    let begun = Begun::new(&Scene::load("stability").unwrap());
    let mut printed = begun.printed(64, usize::MAX);
    let mut source = printed.program.source().to_owned();
    let adjoints = source.match_indices("fn adjoint_").map(|(at, _)| at);
    let body = |at: usize| at + source[at..].find("\n}").expect("a function ends");
    let (start, end) = adjoints
        .map(|at| (at, body(at)))
        .max_by_key(|(at, end)| end - at)
        .expect("there are kernels");
    let result = start + source[start..end].rfind(">(").expect("it returns an array") + 2;
    source.insert_str(result, "1.5f * ");
    // SAFETY: no index and no loop has changed.
    printed.program = unsafe { printed.program.with_source(source) };
    let compared = begun.compare(&gpu, printed).unwrap();
    println!("with an error: {compared:?}");
    assert!(compared.cosine < 0.999, "{compared:?}");
}

/// The message about a program that the driver refuses names a file with its text.
#[test]
fn a_refused_program_is_written_to_a_file() {
    let Some(gpu) = gpu() else { return };
    let begun = Begun::new(&Scene::load("stability").unwrap());
    let program = begun.printed(8, usize::MAX).program;
    let broken = program.source().replace("fn forward(", "fn no_forward(");
    // SAFETY: no index and no loop has changed.
    let program = unsafe { program.with_source(broken.clone()) };
    let Err(refused) = cosmic_gpu::Population::new(&gpu, program) else {
        panic!("a program without an entry point was accepted");
    };
    let folder = tempfile::tempdir().unwrap();
    let said = refused.told(folder.path());
    println!("{said}");
    assert!(said.contains("the driver of the GPU refused"), "{said}");
    let (_, path) = said.rsplit_once("the program is in ").expect(&said);
    assert_eq!(std::fs::read_to_string(path).unwrap(), broken);
}

/// What does not fit is refused with the numbers.
#[test]
fn what_does_not_fit_is_refused() {
    let Some(gpu) = gpu() else { return };
    let begun = Begun::new(&Scene::load("large").unwrap());
    let refused = begun
        .compare(&gpu, begun.printed(8, usize::MAX))
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("bytes of a workgroup's memory"),
        "{refused}"
    );
    let implicit = Scene::parse(
        "implicit",
        "lattice.columns = 3\nlattice.rows = 2\nphysics.integrator = \"implicit\"",
    );
    let begun = Begun::new(&implicit.unwrap());
    let span = Span::from_start(vec![1]);
    let refused = begun
        .simulator
        .printed(&begun.robots(), &span, Wanted::default(), 64)
        .unwrap_err();
    assert!(
        refused.to_string().contains("solves linear equations"),
        "{refused}"
    );
}
