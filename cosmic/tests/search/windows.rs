use crate::small::{after, begun};
use cosmic::inputs::{InputBlock, Inputs};
use cosmic::objective::of_scene;
use cosmic::policy::{TEMPO, frequency};
use cosmic::scene::{Scene, TaskKind};
use cosmic::search::{CoDesign, Progress, Variables, Window};
use cosmic::world::Span;

/// A robot that only learns to walk, in windows of 64 steps.
const LEARNS: &str = "
    base = 'stability'
    [lattice]
    columns = 3
    rows = 3
    [start]
    kind = 'layout'
    layout = 'filled'
    [physics]
    steps = 512
    contact = 'coulomb'
    friction = 1.0
    damping = 2.0
    [controller]
    clock = 'learned'
    omega = 20.0
    hidden = 6
    [volume]
    solid = [0.0, 1.0]
    actuator = [0.0, 1.0]
    [schedule]
    iterations = 16
    attraction_from = 0
    snap_at = 0
    window = 0.128
    horizon = [128, 128]
    [loss]
    window = 64
    [gradient]
    cotangent_bound = 'off'
";

fn scene() -> Scene {
    Scene::parse("learns", LEARNS).unwrap()
}

/// The mean of the losses over a window that begins in the middle of a walk, in every task, against a finite difference along a
/// direction: in the controller, and in the shares of the materials.
#[test]
fn the_gradient_of_a_window_agrees_with_differences() {
    for task in [
        TaskKind::Far,
        TaskKind::Back,
        TaskKind::Reach,
        TaskKind::Climb,
        TaskKind::Economy,
    ] {
        let mut scene = scene();
        scene.objective.task = task;
        let (codesign, progress) = begun(&scene);
        let evaluator = codesign.evaluator();
        let window = Window::of_scene(evaluator).unwrap();
        let (design, first) = (codesign.design(&progress), 100);
        let world = &evaluator.world;
        let robots = [world.nominal(&evaluator.start)];
        let walk = world.run(
            &world.robots::<f64>(&[(&design, &robots[0])], &progress.controller),
            &Span::of_steps(first),
        );
        let variations = [robots[0].clone(), world.nominal(walk[0].at(first))];
        let shares = |k: usize| [0.1, 0.5 + 0.1 * (k as f64).sin(), 0.4];
        let inputs = Inputs {
            z: (0..world.lattice().edges.len()).map(shares).collect(),
            controller: progress.controller.clone(),
            start: evaluator.start.clone(),
        };
        for (variables, block) in [
            (Variables::Controller(&design), InputBlock::Controller),
            (Variables::Shares, InputBlock::Z),
        ] {
            let slope_at =
                |inputs: &_| window.slope(evaluator, variables, inputs, &variations, first);
            let (slope, ends) = slope_at(&inputs);
            assert_eq!(ends.len(), variations.len());
            let direction = (0..slope.gradient.len()).map(|k| (k as f64).cos());
            let direction: Vec<f64> = direction.collect();
            let h = 1e-5;
            let [more, less] = [h, -h].map(|h| {
                let mut inputs = inputs.clone();
                let mut numbers = inputs.get(&[block]);
                let moved = numbers.iter_mut().zip(&direction);
                moved.for_each(|(x, d)| *x += h * d);
                inputs.set(&[block], &numbers);
                slope_at(&inputs).0.loss / evaluator.loss.unit(world.lattice().scale)
            });
            let difference = (more - less) / (2.0 * h);
            let products = slope.gradient.iter().zip(&direction);
            let slope: f64 = products.map(|(g, d)| g * d).sum();
            // Losses of 1e-2 to 1 are rounded at 1e-16 and divided by 2h, which makes 1e-11. The truncation error is a share
            // of about h^2 times the square of the largest derivative of a tanh along the direction, 1e3: 1e-7 with a margin
            // of 10.
            let off = (difference - slope).abs();
            assert!(
                off < 1e-6 * slope.abs() + 1e-10,
                "{task:?}: {difference} {slope}"
            );
            assert!(slope != 0.0, "{task:?}");
        }
    }
}

/// Windows follow each other: the robots of the next one stand where the last one ended, and begin anew after a whole walk.
#[test]
fn robots_walk_on_until_their_walk_ends() {
    let scene = scene();
    let steps = 64;
    let (_, progress) = after(&scene, 1, 0);
    // Eight windows fill the 512 steps of a walk. An iteration has six.
    assert_eq!(progress.contenders.len(), 8);
    for contender in &progress.contenders {
        let walkers = &contender.walkers;
        assert_eq!(
            (walkers.walks, walkers.steps, walkers.states.len()),
            (1, 6 * steps, 8)
        );
    }
    let (_, progress) = after(&scene, 2, 0);
    let walkers = &progress.contenders[0].walkers;
    assert_eq!((walkers.walks, walkers.steps), (2, 4 * steps));
}

/// The clocks of contenders differ, all of them learn, and the one that goes on is at least as good as the first one.
#[test]
fn the_best_contender_goes_on() {
    let scene = scene();
    let (codesign, before) = after(&scene, 3, 0);
    let settings = &scene.controller;
    let clocks = before
        .contenders
        .iter()
        .map(|c| frequency(settings, &c.controller));
    let clocks: Vec<f64> = clocks.collect();
    assert!(
        clocks[5] > 2.0 * clocks[1] && clocks[7] < 0.8 * clocks[1],
        "{clocks:?}"
    );
    let (_, progress) = after(&scene, 4, 0);
    assert!(progress.contenders.is_empty());
    assert!(progress.controller.block(TEMPO)[0].is_finite());
    // The first contender alone, for as many updates.
    let merit = |progress: &Progress| codesign.evaluate(progress).merit;
    let first = {
        let mut alone = before.clone();
        alone.contenders.truncate(1);
        let mut codesign = CoDesign::new(&scene).unwrap();
        codesign.iterate(&mut alone);
        alone
    };
    assert!(
        merit(&progress) >= merit(&first),
        "{} {}",
        merit(&progress),
        merit(&first)
    );
}

#[test]
fn robots_learn_in_windows() {
    let scene = scene();
    for seed in 0..3 {
        let (codesign, first) = after(&scene, 0, seed);
        let (_, last) = after(&scene, 16, seed);
        let along = |progress: &Progress| codesign.evaluate(progress).along();
        // The robot is 0.2 m long.
        assert!(
            along(&last) > along(&first) + 0.2,
            "{} {}",
            along(&first),
            along(&last)
        );
    }
}

/// A run that is interrupted in any iteration continues with the same bits, during the contest too, and with any number of threads.
#[test]
fn neither_interruptions_nor_threads_change_a_bit() {
    let scene = scene();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| after(&scene, 6, 1).1)
    };
    let alone = run(1);
    assert!(alone == run(3));
    let mut codesign = CoDesign::new(&scene).unwrap();
    let mut progress = codesign.begin(1).unwrap();
    for _ in 0..6 {
        codesign.iterate(&mut progress);
        let text = serde_json::to_string(&progress).unwrap();
        progress = serde_json::from_str(&text).unwrap();
    }
    assert!(progress == alone);
}

/// Losses that may not be cut are those over the whole walk: a loss of a program, and goals that are given.
#[test]
fn some_losses_are_not_cut() {
    let own = CoDesign::with_loss(&scene(), crate::small::Up).unwrap();
    let mut progress = own.begin(0).unwrap();
    let mut own = own;
    own.iterate(&mut progress);
    assert!(progress.contenders.is_empty() && progress.walkers.states.is_empty());
    let mut given = scene();
    (given.controller.goals, given.objective.task) =
        (cosmic::scene::GoalKind::Given, TaskKind::Reach);
    let evaluator = cosmic::judge::Evaluator::new(&given, of_scene(&given)).unwrap();
    assert!(Window::of_scene(&evaluator).is_none());
}
