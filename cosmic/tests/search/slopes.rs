use crate::small::{begun, tiny};
use autodiff::Real;
use cosmic::inputs::{CONTROLLER, DESIGN, Inputs};
use cosmic::judge::Evaluator;
use cosmic::objective::{AnyLoss, LossOf, loss_of};
use cosmic::projection::Projection;
use cosmic::scene::{GradientPrecision, MovedBody, Named, Scene, TaskKind};
use cosmic::search::{CoDesign, GradientPoint, Progress, Schedule, Slope, Variables};
use cosmic::world::stability::Vibration;
use cosmic::world::{Span, Variation};

/// The loss of the robot with which the optimisation of a scene begins, as a function of its inputs.
fn loss_at<R: Real>(evaluator: &Evaluator, inputs: &Inputs<R>, horizon: &Span) -> R
where
    dyn AnyLoss: LossOf<R>,
{
    let world = &evaluator.world;
    let design = Variables::Design(Projection::Performance).design(world, &inputs.z);
    loss_of(
        world,
        &inputs.robot(world, &design),
        &*evaluator.loss,
        horizon,
    )
}

/// The slopes of the loss over 24 steps along a direction in the design and along one in the controller. Each must
/// agree with a finite difference.
fn slopes_agree_with_differences(scene: &Scene) -> [f64; 2] {
    let (codesign, progress) = begun(scene);
    let evaluator = codesign.evaluator();
    let (inputs, horizon) = (codesign.inputs(&progress), Span::of_steps(24));
    [DESIGN, CONTROLLER].map(|blocks| {
        let loss = |inputs: &Inputs<_>| loss_at(evaluator, inputs, &horizon);
        let (_, gradient) = inputs.differentiate(blocks, loss);
        let numbers = inputs.get(blocks);
        let direction: Vec<f64> = (0..numbers.len()).map(|k| (k as f64).cos()).collect();
        let at = |h: f64| {
            let moved = numbers.iter().zip(&direction).map(|(x, d)| x + h * d);
            let mut inputs = inputs.clone();
            inputs.set(blocks, &moved.collect::<Vec<_>>());
            loss_at(evaluator, &inputs, &horizon)
        };
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let h = 1e-5;
        let difference = (at(h) - at(-h)) / (2.0 * h);
        // The absolute error is 1e-12: positions of 0.1 m are rounded at 1e-17, and differences are divided by
        // h. The relative truncation error is h^2 beta^2 = 4e-8.
        let off = (difference - slope).abs();
        assert!(off < 1e-7 * slope.abs() + 1e-11, "{difference} {slope}");
        slope
    })
}

/// The weights of the centre of mass and of the present nodes depend on the design, and the gradients contain that.
/// The lowest nodes stand on the ground, so that the centre of mass can move.
#[test]
fn gradients_for_every_body_agree_with_differences() {
    for &(name, body) in MovedBody::ALL {
        for task in [TaskKind::Far, TaskKind::Reach, TaskKind::Climb] {
            let mut scene = tiny();
            (scene.objective.body, scene.objective.task) = (body, task);
            scene.start.tilt = 0.2;
            let slopes = slopes_agree_with_differences(&scene);
            assert!(slopes.iter().all(|slope| *slope != 0.0), "{name}");
        }
    }
}

/// Bars pull equally on both of their ends. So in free fall no design and no controller moves the centre of mass
/// along the ground, but they move the payload and the mean of the nodes.
#[test]
fn bars_do_not_move_the_centre_of_mass() {
    let slope = |body| {
        let mut scene = tiny();
        (scene.lattice.drop, scene.objective.body) = (1.0, body);
        // With `one_piece`, the masses of nodes that are only partly present would count less.
        (scene.start.tilt, scene.design.one_piece) = (0.2, false);
        let slope = slope_in_variations(&scene, 24);
        slope.gradient.iter().map(|g| g.abs()).fold(0.0, f64::max)
    };
    let [payload, mass, nodes] = [MovedBody::Payload, MovedBody::Mass, MovedBody::Nodes].map(slope);
    assert!(payload > 1e-5 && nodes > 1e-5, "{payload} {nodes}");
    // The gradient is a sum of numbers as large as the gradient for the payload, which cancel up to rounding.
    assert!(mass < 1e-9 * payload, "{mass} {payload}");
}

/// The gradient with respect to the design over `steps` steps, averaged over the variations of the first iteration.
fn slope_in_variations(scene: &Scene, steps: usize) -> Slope {
    let (codesign, progress) = begun(scene);
    let mut at = codesign.point(&progress, &Schedule::at(scene, 1));
    at.horizon = Span::of_steps(steps);
    let variables = [Variables::Design(Projection::Performance)];
    let [slope] = codesign.evaluator().slopes(variables, &at);
    slope
}

#[test]
fn displacements_are_measured_from_the_start_of_the_variation() {
    let mut scene = tiny();
    (scene.robust.samples, scene.robust.spread) = (2, 5.0);
    scene.physics.dt = 1e-6;
    let slope = slope_in_variations(&scene, 1);
    // The payload starts up to a centimetre away from its nominal place. In a step this short it moves far less.
    assert!(slope.displacement.abs() < 1e-6, "{}", slope.displacement);
    assert!(slope.displacement != 0.0);
}

#[test]
fn gradients_in_f32_agree_with_gradients_in_f64() {
    let mut scene = tiny();
    // A tilted start mixes all materials in different shares, so the gradient has no zeros.
    scene.start.tilt = 0.2;
    let double = CoDesign::new(&scene).unwrap();
    scene.gradient.precision = GradientPrecision::F32;
    let single = CoDesign::new(&scene).unwrap();
    let progress = double.begin(1).unwrap();
    let design = double.design(&progress);
    let at = GradientPoint {
        sticks: false,
        variations: Vec::new(),
        inputs: double.inputs(&progress),
        horizon: Span::of_steps(24),
    };
    for variables in [
        Variables::Design(Projection::Performance),
        Variables::Design(Projection::Stability),
        Variables::Controller(&design),
    ] {
        let [[a], [b]] =
            [&double, &single].map(|codesign| codesign.evaluator().slopes([variables], &at));
        let off: f64 = (a.gradient.iter().zip(&b.gradient))
            .map(|(a, b)| (a - b).powi(2))
            .sum();
        let norm: f64 = a.gradient.iter().map(|g| g * g).sum();
        // The expected relative error is 24 * 100^(1/2) * 6e-8: 24 steps, and in each about 100 operations that
        // round at 6e-8 with random signs. It is not 0, because the two gradients have different number types.
        let (share, tolerance) = ((off / norm).sqrt(), 1.5e-5);
        assert!(share > 0.0 && share < tolerance, "{share}");
        assert!(norm > 0.0);
        // Displacements are about 0.3 m and have the same relative error.
        assert!((a.displacement - b.displacement).abs() < 0.3 * tolerance);
    }
}

/// Two gradients in one call have the same bits as two calls, also over variations.
#[test]
fn gradients_computed_together_are_bit_identical_to_single_ones() {
    let check = |scene: &Scene| {
        let (codesign, progress) = begun(scene);
        let evaluator = codesign.evaluator();
        let at = GradientPoint {
            sticks: false,
            horizon: Span::of_steps(20),
            ..codesign.point(&progress, &Schedule::at(scene, 1))
        };
        let both = [Projection::Performance, Projection::Stability].map(Variables::Design);
        let together = evaluator.slopes(both, &at);
        let alone = both.map(|variables| evaluator.slopes([variables], &at).into_iter().next());
        assert_eq!(together.clone().map(Some), alone);
        assert_ne!(together[0].gradient, together[1].gradient);
        assert_eq!(evaluator.design_slopes(&at), together.map(Some));
    };
    let mut scene = tiny();
    scene.start.tilt = 0.2;
    check(&scene);
    scene.gradient.precision = GradientPrecision::F32;
    check(&scene);
    scene.robust.samples = 2;
    scene.gradient.precision = GradientPrecision::F64;
    check(&scene);
}

/// The largest frequency of a vibration of a robot with a variation, in 1/s.
fn frequency(codesign: &CoDesign, progress: &Progress, variation: &Variation) -> f64 {
    let (world, design) = (codesign.world(), codesign.design(progress));
    let robot = world
        .robots(&[(&design, variation)], &progress.controller)
        .remove(0);
    let rest = &world.lattice().positions;
    Vibration::new(world.lattice(), &robot.body, world.physics(), rest)
        .fastest()
        .0
}

#[test]
fn time_steps_are_checked_for_the_robots_that_are_drawn() {
    let mut scene = tiny();
    let alone = CoDesign::new(&scene).unwrap();
    let (progress, evaluator) = (alone.begin(0).unwrap(), alone.evaluator());
    let as_designed = evaluator.world.nominal(&evaluator.start);
    let nominal = (
        alone.step_check(&progress),
        frequency(&alone, &progress, &as_designed),
    );
    (scene.robust.samples, scene.robust.spread) = (32, 4.0);
    let drawing = CoDesign::new(&scene).unwrap();
    let progress = drawing.begin(0).unwrap();
    let check = drawing.step_check(&progress);
    let (_, drawn) = drawing.variations(&progress, &Schedule::at(&scene, 1));
    let drawn = drawn.iter().map(|v| frequency(&drawing, &progress, v));
    let fastest = drawn.fold(0.0, f64::max);
    let faster = scene.robust.faster();
    assert!(nominal.1 < fastest && fastest < faster * nominal.1);
    // Both sides are products and quotients of the same numbers, but rounded in another order.
    let is = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-14;
    assert!(is(
        check.bound.frequency,
        faster * nominal.0.bound.frequency
    ));
    let [any, any_drawn] = [nominal.0, check].map(|check| check.any_design.unwrap());
    // The longest stable time step of the damped symplectic Euler method is nearly proportional to 1 / frequency.
    assert!(any_drawn < any / (0.97 * faster), "{any_drawn} of {any}");
}

/// Robots learn goals from rest and, in the other iterations, while they are on their way to another goal. Half of the
/// goals are ahead of the payload, half behind it. A rollout fits into the scene's steps, whatever the horizon is.
#[test]
fn robots_get_their_goals_at_rest_or_on_their_way() {
    let mut scene = Scene::load("errand").unwrap();
    scene = scene.set(&["lattice.columns=3", "lattice.rows=3"]).unwrap();
    for (horizon, longest) in [(64, 100), (250, 50)] {
        scene.physics.steps = 300;
        (scene.schedule.horizon, scene.loss.window) = ([horizon; 2], 16);
        let codesign = CoDesign::new(&scene).unwrap();
        let mut progress = codesign.begin(0).unwrap();
        let payload = codesign.world().lattice().payload[0].node;
        for iteration in 0..6 {
            progress.iteration = iteration;
            let now = Schedule::at(&scene, iteration + 1);
            let (first, variations) = codesign.variations(&progress, &now);
            assert_eq!(first == 0, iteration % 3 == 0);
            assert!(
                first == 0 || (longest / 2..=longest).contains(&first),
                "{first}"
            );
            let mut ahead = 0;
            for variation in &variations {
                let moves = variation.start.v.iter().any(|v| v.norm() > 0.0);
                assert_eq!(moves, first > 0);
                let goal = variation.surroundings.goals.as_ref().unwrap().first;
                ahead += usize::from(goal.forward() > variation.start.x[payload].forward());
            }
            assert_eq!((ahead, variations.len()), (4, 8));
        }
    }
}

/// A payload that is too heavy to be lifted sticks to the ground. Its gradient is zero, so after three such passes the
/// gradient of the centre of mass replaces it. A payload that moves keeps its own.
#[test]
fn a_payload_that_sticks_gets_the_gradient_of_the_centre_of_mass() {
    let mut scene = tiny();
    let slope_after = |flat: usize, scene: &Scene| {
        let codesign = CoDesign::new(scene).unwrap();
        let mut progress = codesign.begin(0).unwrap();
        progress.flat = flat;
        let at = codesign.point(&progress, &Schedule::at(scene, 1));
        let design = codesign.design(&progress);
        let variables = [Variables::Controller(&design)];
        let [slope] = codesign.evaluator().slopes(variables, &at);
        slope
    };
    let slope_of = |scene: &Scene| slope_after(3, scene);
    scene.physics.payload_mass = 100.0;
    let early = slope_after(2, &scene);
    assert!(!early.stuck && early.gradient.iter().all(|&g| g == 0.0));
    let stuck = slope_of(&scene);
    assert!(
        stuck.stuck && stuck.displacement == 0.0,
        "{}",
        stuck.displacement
    );
    scene.objective.body = MovedBody::Mass;
    let of_mass = slope_of(&scene);
    assert!(!of_mass.stuck);
    assert_eq!(stuck.gradient, of_mass.gradient);
    assert!(stuck.gradient.iter().any(|&g| g != 0.0));
    (scene.objective.body, scene.physics.payload_mass) = (MovedBody::Payload, 0.0);
    assert!(!slope_of(&scene).stuck);
}
