//! The implicit step in extreme cases: it does not explode, and it keeps momentum. Batches and other number types agree
//! with single rollouts. That its states and gradients are right is tested in `reference_rollouts.rs` and
//! `rollout_gradients.rs`.

use autodiff::Real;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::domain::{Domain, rollouts};
use cosmic::geometry::Vector;
use cosmic::scene::Scene;
use cosmic::simulator::Span;
use cosmic_lab::verify::stiff::{Extreme, extremes};
use cosmic_tests::{robot, states};

/// Stiffness, mass and time step over nine orders of magnitude, with and without dampers. The speed grows at most as much
/// as a heavy node can drive a light one, and momentum changes by at most 1e-9 of the largest impulse.
#[test]
fn extreme_robots_do_not_explode_and_keep_their_momentum() {
    let extremes = extremes();
    for extreme in &extremes {
        assert!(extreme.is_bounded(), "{extreme:?}");
        assert!(extreme.keeps_momentum(), "{extreme:?}");
    }
    let count = |of: fn(&Extreme) -> usize| extremes.iter().map(of).sum::<usize>();
    let (runs, refused) = (count(|of| of.runs), count(|of| of.refused));
    assert!(runs > 300 && refused > 0, "{runs} runs, {refused} refused");
}

/// A robot with a skeleton of 1e6 N/m stands, pushes and slides. In single precision it does the same for a while.
#[test]
fn a_stiff_robot_runs_in_single_precision() {
    let case = stiff("");
    let exact = states(&case);
    let (task, design) = (case.task(), case.own_design());
    let span = Span::from_start((0..=case.physics.steps).collect());
    let domains = [Domain::of(&task, case.start.clone())];
    let controller = case.controller.map(f32::lit);
    let single = rollouts(&[design.lift::<f32>()], &controller, &domains, &span).remove(0);
    let apart = exact.iter().zip(&single.states).map(|(exact, single)| {
        let pairs = exact.x.iter().zip(&single.x);
        (pairs.map(|(a, b)| a.distance(b.map(f64::from)))).fold(0.0, f64::max)
    });
    let apart = apart.fold(0.0, f64::max);
    // Positions are rounded at 1e-8 m. A stiffness of 1e6 N/m turns that into impulses of 2e-5 N s, which 90 steps add up.
    assert!(apart > 0.0 && apart < 1e-3, "{apart:e} m");
}

fn stiff(more: &str) -> Case {
    robot(&format!(
        "physics = {{integrator = 'implicit', contact = 'coulomb', friction = 0.6{more}}}\nmaterials.stiffness = \
         [1e-7, 1e6, 30.0]"
    ))
}

/// Several robots in one batch have the bits of single rollouts.
#[test]
fn a_batch_of_stiff_robots_has_the_bits_of_single_rollouts() {
    let case = stiff("");
    let (task, design) = (case.task(), case.own_design());
    let start = |k: usize| {
        let mut start = case.start.clone();
        for v in &mut start.v {
            *v = *v * (1.0 + 0.1 * k as f64);
        }
        Domain::of(&task, start)
    };
    let domains: Vec<_> = (0..9).map(start).collect();
    let span = Span::from_start(vec![case.physics.steps]);
    let together = rollouts(&[&design], &case.controller, &domains, &span);
    for (k, (domain, seen)) in domains.iter().zip(&together).enumerate() {
        let alone = task.rollout(&design, &case.controller, &domain.start, &span);
        assert_eq!(alone.states, seen.states, "robot {k}");
    }
}

/// A robot of `workshop` whose actuators pull and push with all their force from the first step on.
fn from_rest(seed: u8) -> Case {
    let mut scene = Scene::load("workshop").unwrap();
    scene.physics.steps = 60;
    let mut case = Case::of_scene(&scene, seed.into()).unwrap();
    let draws = unlike(case.lattice.edges.len(), seed.into());
    let material = |draw: f64| match draw {
        ..-0.3 => Material::Void,
        ..0.3 => Material::Skeleton,
        _ => Material::Actuator,
    };
    case.design = Design::Layout(draws.into_iter().map(material).collect());
    let weights = std::cell::Cell::new(0.7 * f64::from(seed));
    case.controller = case.controller.map(|_| {
        let place = weights.get();
        weights.set(place + 12.9898);
        0.5 * scattered(place)
    });
    case
}

/// A number without a pattern, between -1 and 1.
fn scattered(place: f64) -> f64 {
    (1e4 * place.sin()).sin()
}

fn unlike(count: usize, seed: f64) -> Vec<f64> {
    (0..count)
        .map(|k| scattered(12.9898 * k as f64 + seed))
        .collect()
}

/// The velocities of all nodes after each of these steps.
fn velocities(case: &Case, start: &[Vector<f64>], steps: &[usize]) -> Vec<Vec<Vector<f64>>> {
    let mut from = case.start.clone();
    from.v = start.to_vec();
    let span = Span::from_start(steps.to_vec());
    let seen = (case.task()).rollout(&case.own_design(), &case.controller, &from, &span);
    seen.states.into_iter().map(|state| state.v).collect()
}

fn apart(a: &[Vector<f64>], b: &[Vector<f64>]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Actuators at their limits have a kink at rest, and the contact decides whether a node rests. Neither lets rounding
/// decide: velocities of 1e-10 m/s at the start change those of later steps by little more.
#[test]
fn rounding_does_not_decide_how_a_robot_leaves_its_rest() {
    for seed in 0..6 {
        let case = from_rest(seed);
        let steps = [1, 2, 10, 60];
        let still = velocities(&case, &case.start.v, &steps);
        let fastest = still[0].iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(fastest > 0.1, "{fastest} m/s");
        for draw in 0..4 {
            let moved = unlike(2 * case.start.v.len(), 3.0 + f64::from(draw));
            let moved = moved.chunks(2).map(|v| Vector::new([v[0], v[1]]) * 1e-10);
            let moved = velocities(&case, &moved.collect::<Vec<_>>(), &steps);
            for (step, (still, moved)) in steps.iter().zip(still.iter().zip(&moved)) {
                let apart = apart(still, moved);
                assert!(apart < 1e-8, "seed {seed}, step {step}: {apart:e} m/s");
            }
        }
    }
}
