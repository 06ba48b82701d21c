use crate::small::{begun, tiny};
use cosmic::codesign::{At, CoDesign, Progress, Schedule, Slope, Sought};
use cosmic::inputs::{CONTROLLER, DESIGN, Inputs};
use cosmic::projection::Projection;
use cosmic::scene::{GradientPrecision, HorizonMode, Scene};
use cosmic::simulator::stability::Vibration;
use cosmic::task::{Horizon, Task};

/// With two goals, the gradients of the loss with respect to design and controller agree with finite differences.
/// The robot falls freely, so that the loss has no kinks.
#[test]
fn the_gradient_for_two_goals_agrees_with_differences() {
    let mut scene = tiny();
    (scene.lattice.drop, scene.controller.two_goals) = (1.0, true);
    scene.controller.goal_scale = 1.0;
    let (evaluator, progress) = begun(&scene);
    let inputs = evaluator.inputs(&progress);
    let horizon = Horizon::head(24);
    let start = &evaluator.start;
    let sought = Sought::Design(Projection::Performance);
    let value = |inputs: &Inputs<f64>| {
        let design = sought.design(&evaluator.task, &inputs.z);
        evaluator.losses_of(&evaluator.task, &[design], inputs, start, &horizon)[0].0
    };
    for blocks in [DESIGN, CONTROLLER] {
        let (_, gradient) = inputs.differentiate(blocks, |inputs| {
            let design = sought.design(&evaluator.task, &inputs.z);
            evaluator.losses_of(&evaluator.task, &[design], inputs, start, &horizon)[0].0
        });
        let numbers = inputs.get(blocks);
        let direction: Vec<f64> = (0..numbers.len()).map(|k| (k as f64).cos()).collect();
        let at = |h: f64| {
            let moved = numbers.iter().zip(&direction).map(|(x, d)| x + h * d);
            let mut inputs = inputs.clone();
            inputs.set(blocks, &moved.collect::<Vec<_>>());
            value(&inputs)
        };
        let slope: f64 = gradient.iter().zip(&direction).map(|(g, d)| g * d).sum();
        let h = 1e-5;
        let difference = (at(h) - at(-h)) / (2.0 * h);
        // The absolute error is 1e-12: positions of 0.1 m are rounded at 1e-17, and differences are divided by
        // h. The relative truncation error is h^2 beta^2 = 4e-8.
        assert!((difference - slope).abs() < 1e-7 * slope.abs() + 1e-11);
        assert!(slope != 0.0);
    }
}

/// The gradient with respect to the design over `steps` steps, averaged over the domains of the first iteration.
fn slope_in_domains(scene: &Scene, steps: usize) -> Slope {
    let (evaluator, progress) = begun(scene);
    let mut at = evaluator.point(&progress, &Schedule::at(scene, 1));
    at.horizon = Horizon::head(steps);
    let [slope] = evaluator.slopes([Sought::Design(Projection::Performance)], &at);
    slope
}

/// A robot whose controller does not observe the goal moves the same way for both goals, in every domain. So the
/// losses for the two goals cancel.
#[test]
fn both_goals_have_the_same_robot() {
    let mut scene = tiny();
    (scene.controller.two_goals, scene.controller.goal_scale) = (true, 0.0);
    scene.robust.samples = 3;
    let slope = slope_in_domains(&scene, 20);
    assert_eq!(slope.loss, 0.0);
    // Two gradients cancel. They come from numbers below 1 that are rounded at 1e-16.
    assert!(slope.gradient.iter().all(|g| g.abs() < 1e-14));
}

#[test]
fn displacements_are_measured_from_the_start_of_the_domain() {
    let mut scene = tiny();
    (scene.robust.samples, scene.robust.start) = (2, 0.5);
    let slope = slope_in_domains(&scene, 1);
    // Springs that are stretched by half a metre accelerate nodes to 50 m/s. In a step of 2 ms, the payload then
    // moves less than 0.1 m.
    assert!(slope.displacement.abs() < 0.1, "{}", slope.displacement);
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
    let design = double.evaluator().design(&progress);
    let at = At {
        domains: Vec::new(),
        inputs: double.evaluator().inputs(&progress),
        horizon: Horizon::head(24),
    };
    for sought in [
        Sought::Design(Projection::Performance),
        Sought::Design(Projection::Stability),
        Sought::Controller(&design),
    ] {
        let [[a], [b]] =
            [&double, &single].map(|codesign| codesign.evaluator().slopes([sought], &at));
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

/// Two gradients in one call have the same bits as two calls, also over domains and with two goals.
#[test]
fn gradients_computed_together_are_bit_identical_to_single_ones() {
    let check = |scene: &Scene, mode: HorizonMode| {
        let (evaluator, progress) = begun(scene);
        let at = At {
            horizon: Horizon {
                mode,
                ..Horizon::head(20)
            },
            ..evaluator.point(&progress, &Schedule::at(scene, 1))
        };
        let both = [Projection::Performance, Projection::Stability].map(Sought::Design);
        let together = evaluator.slopes(both, &at);
        let alone = both.map(|sought| evaluator.slopes([sought], &at).into_iter().next());
        assert_eq!(together.clone().map(Some), alone);
        assert_ne!(together[0].gradient, together[1].gradient);
        assert_eq!(evaluator.design_slopes(&at), together.map(Some));
    };
    let mut scene = tiny();
    scene.start.tilt = 0.2;
    check(&scene, HorizonMode::Head);
    check(&scene, HorizonMode::Tail);
    scene.gradient.precision = GradientPrecision::F32;
    check(&scene, HorizonMode::Head);
    scene.controller.two_goals = true;
    scene.robust.samples = 2;
    scene.gradient.precision = GradientPrecision::F64;
    check(&scene, HorizonMode::Head);
}

/// The largest frequency of a vibration of the task's robot, in 1/s.
fn frequency(codesign: &CoDesign, progress: &Progress, task: &Task) -> f64 {
    let body = task.body(&codesign.evaluator().design(progress));
    let rest = &task.lattice.positions;
    Vibration::new(&task.lattice, &body, &task.physics, rest).largest_frequency()
}

#[test]
fn time_steps_are_checked_for_the_robots_that_are_drawn() {
    let mut scene = tiny();
    let alone = CoDesign::new(&scene).unwrap();
    let progress = alone.begin(0).unwrap();
    let nominal = (
        alone.step_check(&progress),
        frequency(&alone, &progress, &alone.evaluator().task),
    );
    (scene.robust.samples, scene.robust.stiffness) = (32, 0.4);
    let drawing = CoDesign::new(&scene).unwrap();
    let progress = drawing.begin(0).unwrap();
    let check = drawing.step_check(&progress);
    let drawn = drawing
        .evaluator()
        .domains(&progress, &Schedule::at(&scene, 1));
    let drawn = drawn
        .iter()
        .map(|w| frequency(&drawing, &progress, &w.task));
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
