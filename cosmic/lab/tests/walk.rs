use crate::small::small;
use cosmic::case::Case;
use cosmic::error::Error;
use cosmic::policy::Goals;
use cosmic::scene::GoalKind;
use cosmic::simulator::Span;
use cosmic_lab::walk::{Leg, place, table, to_nine_goals, walk};

const STEPS: usize = 96;

/// A small robot that takes goals, on a slope.
fn robot(speed_bound: Option<f64>) -> Case {
    small([3, 3], |scene| {
        (scene.controller.goals, scene.controller.goal_scale) = (GoalKind::Given, 3.0);
        (scene.physics.steps, scene.physics.incline_deg) = (STEPS, 10.0);
        scene.physics.speed_bound = speed_bound;
    })
}

/// The position of the payload along the ground in a rollout of the library, after each of the steps `observed`.
fn along(case: &Case, goals: &Goals, observed: [usize; 2]) -> [f64; 2] {
    let task = case.task().with_goals(goals);
    let span = Span::from_start(observed.to_vec());
    let seen = (task.simulator).rollout(&case.body(), &case.controller, &case.start, &span);
    observed.map(|step| task.ground().along(seen.position(step)))
}

#[test]
fn a_walk_measures_the_ways_of_a_rollout() {
    let case = robot(None);
    let goals = Goals::at(place(&case, 0.4)).then(40, place(&case, -0.3));
    let found = walk(&case, &goals, STEPS).unwrap();
    let [middle, end] = along(&case, &goals, [40, STEPS]);
    let start = place(&case, 0.0).forward();
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
    let case = robot(None);
    let goals = Goals::at(place(&case, 0.4)).then(32, place(&case, -0.3));
    let [short, long] =
        [STEPS, 2 * STEPS].map(|steps| walk(&case, &goals, steps).unwrap().trajectory);
    assert_eq!(long.steps.last(), Some(&(2 * STEPS)));
    assert_eq!(long.states[..short.states.len()], short.states);
    // The second goal does not begin within this walk.
    assert_eq!(walk(&case, &goals, 32).unwrap().legs.len(), 1);
}

#[test]
fn nine_goals_are_equally_spaced_and_reached_in_single_rollouts() {
    let case = robot(None);
    let ways = to_nine_goals(&case, [-1.0, 1.0]).unwrap();
    let goals: Vec<f64> = ways.iter().map(|way| way.leg.goal).collect();
    let start = place(&case, 0.0).forward();
    for (k, way) in ways.iter().enumerate() {
        let goal = 0.25 * k as f64 - 1.0;
        let [begin, end] = along(&case, &Goals::at(place(&case, goal)), [0, STEPS]);
        // Distances are differences of a few numbers of about 1.
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} is not {b}, {goals:?}");
        near(way.leg.goal, goal);
        near(way.leg.way, (begin - start - goal).abs());
        near(way.leg.left, (end - start - goal).abs());
        assert_eq!(way.leg.ratio().is_none(), k == 4);
    }
    let shown = table(&[ways[4].leg]).to_text();
    assert!(shown.ends_with("  \u{2013}\n"), "{shown}");
}

/// A robot that diverges is an error of a walk, and a row of the table of nine ways.
#[test]
fn a_robot_that_diverges_is_named() {
    let case = robot(Some(0.01));
    let refused = walk(&case, &Goals::at(place(&case, 1.0)), STEPS).unwrap_err();
    assert!(matches!(refused, Error::Diverged { .. }), "{refused}");
    let ways = to_nine_goals(&case, [-1.0, 1.0]).unwrap();
    assert!(ways.iter().all(|way| way.path.is_empty()));
    let legs: Vec<Leg> = ways.iter().map(|way| way.leg).collect();
    assert_eq!(legs[0].way, 1.0);
    assert_eq!(table(&legs).to_text().matches("diverged").count(), 9 + 8);
}

#[test]
fn a_robot_with_a_fixed_goal_is_refused() {
    let case = small([3, 3], |scene| scene.physics.steps = STEPS);
    let refused = to_nine_goals(&case, [-1.0, 1.0]).unwrap_err().to_string();
    assert!(
        refused.contains("`controller.goals = \"given\"`"),
        "{refused}"
    );
}
