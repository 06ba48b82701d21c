use autodiff::Parameters;
use cosmic::case::Case;
use cosmic::lattice::State;
use cosmic::policy::{Controller, Goals};
use cosmic::scene::Scene;
use cosmic::walk;
use cosmic::world::{Robot, Span, Trajectory, World};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// A scene whose robots get their goals.
fn scene() -> Scene {
    let text = "base = \"errand\"\nlattice.columns = 3\nlattice.rows = 2\nphysics.steps = 60";
    Scene::parse("small", text).unwrap()
}

/// Its world, and a robot there.
fn with_goals() -> (World, Robot<f64>) {
    let case = Case::of_scene(&scene(), 1).unwrap();
    (case.world(), case.robot())
}

/// A batch may mix robots that share lanes with robots that cannot: with other controllers, with given activations, and with
/// goals that change at other steps. Each walks as it does alone.
#[test]
fn a_robot_has_the_same_bits_in_any_batch() {
    let (world, robot) = with_goals();
    let goal = robot.surroundings.goals.as_ref().unwrap().first;
    let changing = |steps: usize| Goals::at(goal).then(steps, goal * -1.0);
    let with = |goals: &Goals| robot.clone().with_goals(goals.clone());
    let scaled = robot.surroundings.as_ref().clone();
    let scaled = scaled.scaled("physics.gravity", 0.5);
    let negative = robot.controller.map(|x| -x);
    let edges = world.lattice().edges.len();
    let robots = [
        robot.clone(),
        robot.clone().in_surroundings(scaled),
        Robot {
            controller: negative,
            ..robot.clone()
        },
        with(&changing(20)),
        with(&changing(30)),
        Robot {
            controller: Controller::given(vec![0.5; edges]).into(),
            ..robot.clone()
        },
        Robot {
            controller: Controller::given(vec![-0.5; 60 * edges]).into(),
            ..robot.clone()
        },
        robot.clone(),
    ];
    let span = Span::from_start(vec![40, 60]);
    let together = world.run(&robots, &span);
    let alone: Vec<_> = (robots.iter())
        .map(|robot| world.run_one(robot, &span))
        .collect();
    assert_eq!(together, alone);
    assert_eq!(together[0], together[7]);
    for k in 1..7 {
        assert_ne!(together[k].states, together[k - 1].states, "robot {k}");
    }
}

/// A recorded step is that of all its robots.
#[test]
fn robots_with_different_steps_are_not_recorded_together() {
    let (world, robot) = with_goals();
    let goal = robot.surroundings.goals.as_ref().unwrap().first;
    let later = |steps: usize| {
        let goals = Goals::at(goal).then(steps, goal * -1.0);
        robot.clone().with_goals(goals)
    };
    let mut stretched = (*robot.body).clone();
    stretched.largest_strain *= 2.0;
    let given = Controller::given(vec![0.5; world.lattice().edges.len()]);
    let others = [
        later(20),
        Robot {
            body: stretched.into(),
            ..robot.clone()
        },
        Robot {
            controller: given.into(),
            ..robot.clone()
        },
    ];
    let span = Span::of_steps(60);
    for other in others {
        let recorded = |robots: &[Robot<f64>]| {
            let recorded = AssertUnwindSafe(|| drop(world.recorded(robots, &span, false)));
            catch_unwind(recorded).map_err(|panic| *panic.downcast::<String>().unwrap())
        };
        assert_eq!(recorded(&[other.clone(), other.clone()]), Ok(()));
        let refused = recorded(&[robot.clone(), robot.clone(), other]).unwrap_err();
        assert!(
            refused.starts_with("robots 1 and 2 have different steps"),
            "{refused}"
        );
    }
    // Controllers are numbers of the robots.
    let own = Robot {
        controller: robot.controller.map(|x| -x),
        ..robot.clone()
    };
    let _ = world.recorded(&[robot.clone(), own], &span, false);
}

/// In open loop the policy sees one state, so a push does not change what the robot does.
#[test]
fn an_open_loop_is_a_span() {
    let (world, robot) = with_goals();
    let activations = |from: f64, open_loop: bool| {
        let mut start = robot.start.clone();
        start.v.iter_mut().for_each(|v| *v = v.with_forward(from));
        let span = Span {
            open_loop: open_loop.then(|| robot.start.clone()),
            metered: true,
            ..Span::of_steps(60)
        };
        let walk = world.run_one(&robot.from(&start), &span);
        walk.effort(60).activation.clone()
    };
    assert_eq!(activations(0.0, true), activations(1.0, true));
    assert_ne!(activations(0.0, false), activations(1.0, false));
}

/// Surroundings of one world fit another one whose steps read other numbers: leapfrog steps read no damping.
#[test]
fn surroundings_fit_a_world_with_other_steps() {
    let scene = Scene::parse("small", "lattice.columns = 3\nlattice.rows = 2").unwrap();
    let case = Case::of_scene(&scene, 1).unwrap();
    let world = case.world();
    let mut leapfrog = scene.physics.clone();
    leapfrog.integrator = cosmic::scene::Integrator::Leapfrog;
    let other = world.with_physics(&leapfrog, &scene.controller);
    let mut light = world.nominal(&case.start);
    light.surroundings = (*light.surroundings)
        .clone()
        .scaled("physics.gravity", 0.5)
        .into();
    let there =
        |world: &World| world.robots::<f64>(&[(&case.own_design(), &light)], &case.controller);
    for world in [&world, &other] {
        let robot = there(world).remove(0);
        let halved = 0.5 * scene.physics.gravity;
        assert_eq!(robot.surroundings.value("physics.gravity"), halved);
        let _ = world.run_one(&robot, &Span::of_steps(2));
    }
}

/// The guard repeats the walk that diverged, not another one: an open loop stays one.
#[test]
fn a_divergence_in_open_loop_is_found_in_open_loop() {
    let (world, robot) = with_goals();
    let span = Span {
        open_loop: Some(robot.start.clone()),
        ..Span::from_start((0..=60).collect())
    };
    let [open, closed] = [span.open_loop.clone(), None].map(|open_loop| {
        let span = Span {
            open_loop,
            ..span.clone()
        };
        world.run_one(&robot, &span)
    });
    let speeds = open.states.iter().flat_map(|state| state.speeds());
    let mut scene = scene();
    scene.physics.speed_bound = Some(0.9 * speeds.fold(0.0, f64::max));
    let world = world.with_physics(&scene.physics, &scene.controller);
    let guarded = walk::guarded(&world, &robot, &span);
    let last = guarded
        .divergence
        .expect("a node is faster than the bound")
        .last;
    let states = |walk: &Trajectory<f64>| -> Vec<State<f64>> {
        last.steps
            .iter()
            .map(|&step| walk.at(step).clone())
            .collect()
    };
    assert_eq!(last.states, states(&open));
    assert_ne!(last.states, states(&closed));
}
