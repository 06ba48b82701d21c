//! Robots of the built-in scenes, on a device and on the processor.

use autodiff::{Real, Tape, Var};
use cosmic::case::Case;
use cosmic::scene::{BUILTIN, Scene};
use cosmic::simulator::{PrintedRobots, Robots, Simulator, Span, Trajectory, Wanted};
use cosmic_gpu::{Gpu, RobotsOnGpu};

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

/// The robots from which an optimisation of the scene begins with a few seeds.
fn cases(scene: &Scene) -> Vec<Case> {
    (0..2)
        .map(|seed| Case::of_scene(scene, seed).unwrap())
        .collect()
}

/// The forward distance of the marker in all observed states, and a little of its height.
fn loss<R: Real>(trajectory: &Trajectory<R>) -> R {
    let states = trajectory.states.iter();
    let terms = states.map(|state| {
        let x = state
            .x
            .iter()
            .fold(R::zero(), |sum, x| sum + x[0] + R::lit(0.3) * x[1]);
        x * R::lit(1.0 / state.x.len() as f64)
    });
    terms.fold(R::zero(), |sum, x| sum + x)
}

/// The cosine of the angle between two gradients.
fn cosine(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    match dot(a, a) * dot(b, b) {
        0.0 => 1.0,
        squares => dot(a, b) / squares.sqrt(),
    }
}

#[test]
fn scenes_begin_alike_on_a_device_and_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    for name in BUILTIN.map(|scene| scene.name) {
        let scene = Scene::load(name).unwrap();
        let cases = cases(&scene);
        let first = &cases[0];
        let simulator = Simulator::new(&first.lattice, &first.physics, &first.observation);
        let bodies: Vec<_> = cases.iter().map(Case::body).collect();
        let controllers: Vec<_> = cases.iter().map(|case| case.controller.clone()).collect();
        let starts: Vec<_> = cases.iter().map(|case| case.start.clone()).collect();
        let surroundings = [simulator.surroundings()];
        let robots = Robots {
            surroundings: &surroundings,
            bodies: &bodies,
            controllers: &controllers,
        };
        let wanted = Wanted {
            bodies: true,
            controllers: true,
            surroundings: false,
        };
        for (steps, tolerance) in [(64, 1e-5), (256, f64::INFINITY)] {
            let span = Span::from_start(vec![steps / 2, steps]);
            let printed: PrintedRobots = simulator.printed(&robots, &span, wanted, 64).unwrap();
            println!(
                "{name}: {:?} bytes, {:?} barriers",
                printed.program.memory, printed.program.barriers
            );
            let device =
                RobotsOnGpu::new(&gpu, printed).unwrap_or_else(|error| panic!("{name}: {error}"));
            let gradients = device.gradients(&robots, &starts, loss).unwrap();
            let walked = device.rollouts(&robots, &starts).unwrap();
            for (k, case) in cases.iter().enumerate() {
                let single = |x: f64| x as f32;
                let (body, start) = (bodies[k].map(single), case.start.map(single));
                let lists = [&body.stiffness, &body.strain, &body.mass, &body.presence];
                let lists = lists.map(|list| list.len());
                let own: usize = lists.iter().sum();
                let numbers = [
                    &body.stiffness[..],
                    &body.strain,
                    &body.mass,
                    &body.presence,
                ]
                .concat();
                let of_policy = case.controller.map(single);
                let flat = [&numbers[..], of_policy.numbers()].concat();
                let mut tape = Tape::new();
                let (mut states, mut value) = (Vec::new(), None);
                let result = tape.record(&flat, |x| {
                    // A number that is zero stands for a part that the robot does not have, and is left out.
                    let or_zero = |x: &Var<f32>| {
                        if x.value() == 0.0 {
                            Var::constant(0.0)
                        } else {
                            *x
                        }
                    };
                    let of_body = x[..own].iter().map(or_zero);
                    let x: Vec<Var<f32>> = of_body.chain(x[own..].iter().copied()).collect();
                    let mut body = body.map(Var::constant);
                    let [stiffness, strain, mass, _] = lists;
                    body.stiffness.copy_from_slice(&x[..stiffness]);
                    body.strain.copy_from_slice(&x[stiffness..][..strain]);
                    body.mass.copy_from_slice(&x[stiffness + strain..][..mass]);
                    body.presence
                        .copy_from_slice(&x[stiffness + strain + mass..own]);
                    let mut controller = of_policy.map(Var::constant);
                    controller.numbers_mut().copy_from_slice(&x[own..]);
                    let trajectory =
                        simulator.rollout(&body, &controller, &start.map(Var::constant), &span);
                    states = trajectory
                        .states
                        .iter()
                        .flat_map(|s| s.x.iter().flat_map(|x| [x[0].value(), x[1].value()]))
                        .collect();
                    let loss = loss(&trajectory);
                    value = Some(loss.value());
                    loss
                });
                let expected: Vec<f64> = tape
                    .pullback(&[result], &[1.0])
                    .iter()
                    .map(|&x| f64::from(x))
                    .collect();
                let found: Vec<f64> = walked[k]
                    .states
                    .iter()
                    .flat_map(|s| s.x.iter().flat_map(|x| [x[0], x[1]]))
                    .collect();
                let error = states
                    .iter()
                    .zip(&found)
                    .map(|(a, b): (&f32, &f64)| (f64::from(*a) - b).abs())
                    .fold(0.0, f64::max);
                println!(
                    "{name} seed {k}, {steps} steps: positions differ by {error:e} m, losses {} and {}",
                    value.unwrap(),
                    gradients.losses[k]
                );
                assert!(error <= tolerance * first.lattice.spacing * 10.0, "{name}");
                let body = &gradients.bodies[k];
                let mut at = 0;
                let lists = [
                    ("stiffness", &body.stiffness),
                    ("strain", &body.strain),
                    ("mass", &body.mass),
                    ("presence", &body.presence),
                    ("controller", &gradients.controllers[k]),
                ];
                for (what, list) in lists {
                    let len = list.len();
                    let is_there = |k: &usize| what == "controller" || flat[at + k] != 0.0;
                    let there = (0..list.len()).filter(is_there);
                    let (list, expected): (Vec<f64>, Vec<f64>) =
                        there.map(|k| (list[k], expected[at + k])).unzip();
                    let like = cosine(&list, &expected);
                    assert!(like > 0.9999, "{name}, {what}: {like}");
                    at += len;
                }
            }
        }
    }
}
