use crate::small::small;
use cosmic::case::Case;
use cosmic::geometry::{Ground, Vector};
use cosmic::policy::Goals;
use cosmic::scene::{GoalKind, LatticeKind};
use cosmic::world::Span;
use cosmic_lab::walk::{place, walk};

const STEPS: usize = 96;

/// A small robot that takes goals, on a slope.
fn robot() -> Case {
    small([3, 3], |scene| {
        (scene.controller.goals, scene.controller.goal_scale) = (GoalKind::Given, 3.0);
        (scene.physics.steps, scene.physics.incline_deg) = (STEPS, 10.0);
    })
}

/// The position of the payload in a rollout of the library, after each of the steps `observed`.
fn places(case: &Case, goals: &Goals, observed: [usize; 2]) -> [Vector<f64>; 2] {
    let robot = case.robot().with_goals(goals.clone());
    let span = Span::from_start(observed.to_vec());
    let seen = (case.world()).run_one(&robot, &span);
    observed.map(|step| seen.position(step))
}

#[test]
fn a_walk_measures_the_ways_of_a_rollout() {
    let case = robot();
    let goals = Goals::at(place(&case, [0.4, 0.0])).then(40, place(&case, [-0.3, 0.0]));
    let found = walk(&case, &goals, STEPS).unwrap();
    let ground = Ground::from(&case.scene.physics);
    let [middle, end] = places(&case, &goals, [40, STEPS]).map(|place| ground.along(place));
    let start = place(&case, [0.0, 0.0]).forward();
    let expected = [
        (0.4, [0, 40], (0.4, middle - start)),
        (-0.3, [40, STEPS], (middle - start + 0.3, end - start)),
    ];
    // Distances are differences of a few numbers below 1.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} is not {b}");
    assert_eq!(found.legs.len(), 2);
    for (leg, (goal, steps, (way, at))) in found.legs.iter().zip(expected) {
        near(leg.goal, goal);
        assert_eq!(
            [leg.from, leg.until],
            steps.map(|step| step as f64 * case.scene.physics.dt)
        );
        near(leg.way, way.abs());
        near(leg.left, (at - goal).abs());
        assert_eq!(leg.ratio(), Some(leg.left / leg.way));
    }
    assert!(found.trajectory.steps.contains(&40));
    near(found.path[found.path.len() - 1][1], end - start);
}

/// A walk may be longer than the rollouts of the scene. It begins like a shorter one.
#[test]
fn a_walk_may_be_longer_than_the_scene_says() {
    let case = robot();
    let goals = Goals::at(place(&case, [0.4, 0.0])).then(32, place(&case, [-0.3, 0.0]));
    let [short, long] =
        [STEPS, 2 * STEPS].map(|steps| walk(&case, &goals, steps).unwrap().trajectory);
    assert_eq!(long.steps.last(), Some(&(2 * STEPS)));
    assert_eq!(long.states[..short.states.len()], short.states);
    // The second goal does not begin within this walk.
    assert_eq!(walk(&case, &goals, 32).unwrap().legs.len(), 1);
}

/// In space, the way to a goal and the distance that is left are along and across.
#[test]
fn a_walk_in_space_measures_along_and_across() {
    let case = small([3, 3], |scene| {
        (scene.lattice.kind, scene.lattice.depth) = (LatticeKind::Cubic, 2);
        (scene.controller.goals, scene.controller.goal_scale) = (GoalKind::Given, 3.0);
        scene.physics.steps = STEPS;
    });
    let goals = Goals::at(place(&case, [0.3, -0.4])).then(40, place(&case, [0.3, 0.1]));
    let found = walk(&case, &goals, STEPS).unwrap();
    let [middle, end] = places(&case, &goals, [40, STEPS]);
    let [first, second] = &found.legs[..] else {
        panic!("there are two goals")
    };
    // Distances are differences of a few numbers below 1.
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} is not {b}");
    for (leg, across) in [(first, -0.4), (second, 0.1)] {
        near(leg.goal, 0.3);
        near(leg.across.unwrap(), across);
    }
    near(first.way, 0.5);
    let away = |at: Vector<f64>, across: f64| {
        let off = at - place(&case, [0.3, across]);
        off.forward().hypot(off.sideways())
    };
    near(first.left, away(middle, -0.4));
    near(second.way, away(middle, 0.1));
    near(second.left, away(end, 0.1));
}
