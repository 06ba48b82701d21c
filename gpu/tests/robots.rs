//! Robots of the built-in scenes, on a device and on the processor.

use crate::alike::{Begun, assert_alike, assert_alike_in, positions};
use crate::device::gpu;
use autodiff::Parameters;
use cosmic::geometry::Vector;
use cosmic::scene::{BUILTIN, Integrator, Scene};
use cosmic::world::{Robot, Span};
use cosmic_gpu::{OnGpu, PrintedRobots, RobotsOnGpu, Wanted};
use cosmic_tests::{laws, own_reference_folder, references};

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
    let Begun { world, robots } = Begun::new(&Scene::load("stability").unwrap());
    let moved = |k: usize| {
        let mut robot = robots[0].clone();
        robot.start.x[5] += Vector::upright(0.0, 0.001 * k as f64);
        robot
    };
    let shared: Vec<Robot<f64>> = (0..3).map(moved).collect();
    let own: Vec<Robot<f64>> = shared.iter().map(|robot| robot.map(|x| x)).collect();
    // One robot at a time.
    let device = OnGpu::new(gpu.with_memory(1));
    let span = Span::from_start(vec![0, 32]);
    let [of_shared, of_own] = [&shared, &own].map(|of| device.run(&world, of, &span).unwrap());
    let pairs = of_shared.iter().zip(&of_own).zip(&shared);
    for ((shared, own), Robot { start, .. }) in pairs {
        let [a, b] = [shared, own].map(positions);
        let apart = a.iter().zip(&b).map(|(a, b)| (a - b).abs());
        // The two programs may order sums differently: rounding of 32 steps.
        assert!(apart.fold(0.0, f64::max) < 1e-6);
        // The state at the start is observed too.
        assert!((shared.states[0].x[5].up() - start.x[5].up()).abs() < 1e-7);
    }
}

/// Work for a device that is lost ends with an error.
#[test]
fn a_lost_device_is_an_error() {
    let Some(gpu) = gpu() else { return };
    let Begun { world, robots } = Begun::new(&Scene::load("stability").unwrap());
    let device = OnGpu::new(gpu);
    let run = || device.run(&world, &robots, &Span::of_steps(32));
    run().unwrap();
    device.gpu().give_up();
    let error = run().unwrap_err();
    assert!(!error.is_empty());
}

/// In a watched span, the observations of a robot that was too fast are NaN, also those before.
#[test]
fn a_robot_that_is_too_fast_has_no_observations() {
    let Some(gpu) = gpu() else { return };
    let Begun { world, mut robots } = Begun::new(&Scene::load("stability").unwrap());
    // The last node is at the top; the lowest ones would stop where they touch the ground.
    let fast = robots[1].start.v.last_mut().unwrap();
    *fast = Vector::upright(1e5, 0.0);
    let span = Span {
        watched: true,
        ..Span::from_start(vec![4, 8])
    };
    let printed = PrintedRobots::new(&world, &robots, &span, Wanted::default(), 64).unwrap();
    let device = RobotsOnGpu::new(&gpu, printed).unwrap();
    let walked = device.run(&robots).unwrap();
    for (k, is_fast) in [false, true].into_iter().enumerate() {
        let here = world.run_one(&robots[k].map(|x| x as f32), &span);
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
    let whole = program.memory()[1];
    assert_eq!(program.spilled(), 0);
    for memory in [whole - 1, whole / 2, 0] {
        let spilled = Begun::new(&scene).printed(8, memory).program;
        assert!(spilled.memory()[1] <= memory && spilled.spilled() > 0);
        assert_alike_in(&gpu, "small", &scene, memory);
    }
}

/// The robots of the reference cases over 64 steps; each is simulated twice. Their contacts double an error every 13 steps, so
/// longer rollouts would compare rounding.
#[test]
fn reference_cases_walk_alike_on_a_device_and_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    let references = references(&own_reference_folder());
    assert!(references.len() > 10);
    for reference in references {
        let mut case = reference.case();
        case.scene.physics.steps = case.scene.physics.steps.max(64);
        let name = reference.path.file_stem().unwrap().to_string_lossy();
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

/// Laws, also those of a user, and a profile of the ground run on a device without a line written for them.
#[test]
fn laws_act_alike_on_a_device_and_on_the_processor() {
    let Some(gpu) = gpu() else { return };
    let registry = laws::registry();
    let forces = ["wind", "magnet", "actuator", "rope"];
    let mut worlds = forces
        .map(|name| (name, format!("physics.forces = [{name:?}]")))
        .to_vec();
    worlds.push(("mud", "physics.contact = \"mud\"".to_owned()));
    let formulas = "physics.forces = ['bar_formula', 'node_formula']\nbar_formula = {tension = 'a * stiffness * \
                    where(rate < 0, 2, 1) * rate + stiffness * max(length / rest_length - 1, 0)^1.5', a = 1e-3}\n\
                    node_formula.force_x = '0.01 * sin(40 * time + x) - 0.02 * vx * abs(vx)'";
    worlds.push(("formulas", formulas.to_owned()));
    // The feet of the robot stand on slopes.
    let points = "points = [[-0.2, 0.0], [-0.07, -0.02], [0.02, -0.01], [0.4, -0.05]]";
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
    #[allow(unsafe_code)]
    let program = unsafe { printed.program.with_source(source) };
    printed.program = program;
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
    #[allow(unsafe_code)]
    let program = unsafe { program.with_source(broken.clone()) };
    let Err(refused) = cosmic_gpu::Population::new(&gpu, program, true) else {
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
    let Begun { world, robots } = Begun::new(&implicit.unwrap());
    let printed = PrintedRobots::new(&world, &robots, &Span::of_steps(1), Wanted::default(), 64);
    let refused = printed.unwrap_err();
    assert!(
        refused.to_string().contains("solves linear equations"),
        "{refused}"
    );
}
