//! Goals as inputs of a rollout: they may change while a robot walks, and the loss of errands reads them.

use autodiff::check::Verdict;
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::objective::{Errand, Loss};
use cosmic::policy::Goals;
use cosmic::random::{Purpose, stream};
use cosmic::scene::{GoalsSettings, Scene};
use cosmic::world::{Robot, Span, Trajectory, draw_goals};
use cosmic_lab::check::check_gradients_of;
use cosmic_tests::few_directions;

const SMALL: &str = "base = \"errand\"\nlattice.columns = 3\nlattice.rows = 2\nlattice.drop = 0.01\ncontroller.hidden = 6\n";
const CUBIC: &str = "lattice.kind = \"cubic\"\n";

/// A small robot that observes its goals, and its scene.
fn robot(settings: &str) -> (Scene, Case) {
    let text = format!("{SMALL}lattice.mirror = false\nlattice.payload = 0\n{settings}");
    let scene = Scene::parse("small", &text).unwrap();
    let case = Case::of_scene(&scene, 1).unwrap();
    (scene, case)
}

/// The robot of a case with these goals.
fn sent(case: &Case, goals: &Goals) -> Robot<f64> {
    case.robot().with_goals(goals.clone())
}

/// A rollout in which the goal changes is a rollout to the first goal, continued from its last state to the second one.
#[test]
fn a_goal_may_change_while_a_robot_walks() {
    let (_, case) = robot("");
    let [right, left] = [[1.5, 0.1], [-1.5, 0.1]].map(Vector::from);
    let walk = |goals: Goals, start: &State<f64>, first: usize, steps: usize| {
        let span = Span {
            first,
            ..Span::from_start(vec![steps])
        };
        let robot = sent(&case, &goals).from(start);
        case.world().run_one(&robot, &span).states.remove(0)
    };
    let half = walk(Goals::at(right), &case.start, 0, 300);
    let whole = walk(Goals::at(left), &half, 300, 200);
    let changed = walk(Goals::at(right).then(300, left), &case.start, 0, 500);
    let apart = |a: &State<f64>, b: &State<f64>| {
        let pairs = a.to_columns().into_iter().zip(b.to_columns());
        pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
    };
    // A state between two rollouts is rounded once more, when it is converted to the world's frame and back.
    assert!(apart(&changed, &whole) < 1e-11);
    assert!(apart(&changed, &walk(Goals::at(right), &case.start, 0, 500)) > 1e-3);
}

/// The gradients of the loss are right in every mode, while the payload is on its way to its goals.
#[test]
fn the_loss_of_errands_has_the_right_gradient() {
    for lattice in [
        "",
        "lattice.kind = \"cubic\"\nlattice.depth = 2\ncontroller.goal = [0.4, 0.7, 0.1]\n",
    ] {
        let (scene, case) = robot(&format!("{lattice}loss.window = 20\nloss.every = 8"));
        let loss = Errand::of_scene(&scene);
        let check = check_gradients_of(&loss, &case, 48, &few_directions());
        for group in &check.groups {
            let is_right = group.verdict == Verdict::Smooth;
            assert!(is_right, "{}, {}", group.name, group.report);
        }
    }
}

/// The loss of a robot whose payload starts where it is at rest, and then is at these places while its goals hold. A
/// place counts from the payload at rest, in metres along the ground.
fn loss_at((scene, case): (&Scene, &Case), goals: &Goals, along: [f64; 3]) -> f64 {
    let (loss, start) = (Errand::of_scene(scene), case.start.x[0].forward());
    let place = |&step: &usize| {
        let mut state = case.start.clone();
        let along = match step {
            0 => 0.0,
            _ => along[goals.place(step - 1)],
        };
        state.x[0] = Vector::from([start + along, 0.1]);
        state
    };
    let observed = loss.observed(scene.physics.steps);
    let states = observed.iter().map(place).collect();
    let mut seen = Trajectory::new(observed, states);
    seen.goals = Some(goals.clone());
    loss.loss(&seen)
}

/// The loss is the share of the way that is left: 1 for a payload that stays at the start, 0 for one that is at its
/// goal, 2 for one that goes as far the other way.
#[test]
fn the_loss_is_the_share_of_the_way_that_is_left() {
    let (scene, case) = robot("");
    let steps = scene.physics.steps;
    let changes: Vec<usize> = GoalsSettings::changes(steps).collect();
    let start = case.start.x[0].forward();
    let goals = Goals::at(Vector::from([start + 1.0, 0.1]));
    let goals = goals.then(changes[0], Vector::from([start, 0.1]));
    let goals = goals.then(changes[1], Vector::from([start - 2.0, 0.1]));
    let left = |along: [f64; 3]| loss_at((&scene, &case), &goals, along);
    for (along, expected) in [
        ([1.0, 0.0, -2.0], 0.0),
        ([0.0, 1.0, 0.0], 1.0),
        ([-1.0, 0.5, -1.0], (2.0 + 0.5 + 0.5) / 3.0),
    ] {
        // A mean of some hundred distances of order one.
        assert!(
            (left(along) - expected).abs() < 1e-13,
            "{along:?}: {}",
            left(along)
        );
    }
}

/// In space, distances are along the ground and across: this payload covers half of the way to a goal 0.5 m away.
#[test]
fn the_way_to_a_goal_in_space_is_along_and_across() {
    let (scene, case) = robot(&format!("{CUBIC}lattice.depth = 2"));
    let (loss, start) = (Errand::of_scene(&scene), case.start.x[0]);
    let goal = |share: f64| start + Vector::new([0.3 * share, -0.4 * share, 0.7]);
    let place = |&step: &usize| {
        let mut state = case.start.clone();
        if step > 0 {
            state.x[0] = goal(0.5);
        }
        state
    };
    let observed = loss.observed(scene.physics.steps);
    let states = observed.iter().map(place).collect();
    let mut seen = Trajectory::new(observed, states);
    seen.goals = Some(Goals::at(goal(1.0)));
    // A mean of some hundred distances of order one.
    assert!(
        (loss.loss(&seen) - 0.5).abs() < 1e-13,
        "{}",
        loss.loss(&seen)
    );
    // A payload that moves across at 0.25 m/s counts as 0.05 m farther away.
    for state in &mut seen.states {
        state.v[0] = Vector::new([0.0, 0.25, 3.0]);
    }
    assert!(
        (loss.loss(&seen) - 0.6).abs() < 1e-13,
        "{}",
        loss.loss(&seen)
    );
}

/// A robot in space whose sides are mirror images walks to a goal on the right as it walks to a goal on the left.
#[test]
fn a_mirrored_robot_in_space_walks_right_as_it_walks_left() {
    for policy in ["gaits", "mlp"] {
        let text = format!("{SMALL}{CUBIC}lattice.depth = 3\ncontroller.policy = \"{policy}\"");
        let case = Case::of_scene(&Scene::parse("mirrored", &text).unwrap(), 1).unwrap();
        let image = case.lattice.image().unwrap();
        let payload = case.start.x[case.lattice.payload[0].node];
        let walk = |across: f64| {
            let way = |along: f64, across: f64| payload + Vector::new([along, across, 0.0]);
            let goals = Goals::at(way(0.4, across)).then(60, way(-0.2, -across));
            let robot = sent(&case, &goals);
            (case.world().run_one(&robot, &Span::of_steps(120)).states).remove(0)
        };
        let (left, right) = (walk(0.6), walk(-0.6));
        let mut moved = 0.0_f64;
        for (node, &other) in image.nodes.iter().enumerate() {
            let [x, mirrored] = [left.x[node], right.x[other]];
            let turned = Vector::new([
                mirrored.forward(),
                2.0 * payload.sideways() - mirrored.sideways(),
                mirrored.up(),
            ]);
            // Rounding of positions near 0.3 m, amplified in 120 steps.
            assert!(x.distance(turned) < 1e-12, "{policy}: {x:?} {turned:?}");
            moved = moved.max(x.distance(right.x[node]));
        }
        assert!(moved > 1e-5, "{policy}: {moved}");
    }
}

/// A robot that is its own mirror image walks to a goal behind as it walks to a goal ahead, seen in a mirror.
#[test]
fn a_mirrored_robot_walks_back_as_it_walks_ahead() {
    let text = "base = \"errand\"\nlattice.columns = 3\nlattice.rows = 2\nlattice.drop = 0.01\ncontroller.hidden = 6";
    let scene = Scene::parse("mirrored", text).unwrap();
    let case = Case::of_scene(&scene, 1).unwrap();
    let image = case.lattice.image().unwrap();
    let middle = case.start.x[1].forward();
    let walk = |way: f64| {
        let goals = Goals::at(Vector::from([middle + way, 0.1]))
            .then(60, Vector::from([middle - way, 0.2]));
        let robot = sent(&case, &goals);
        (case.world().run_one(&robot, &Span::of_steps(120)).states).remove(0)
    };
    let (ahead, back) = (walk(1.0), walk(-1.0));
    let mut moved = 0.0_f64;
    for (node, &other) in image.nodes.iter().enumerate() {
        let [x, mirrored] = [ahead.x[node], back.x[other]];
        // Rounding of positions near 0.3 m, amplified in 120 steps.
        assert!((x.forward() - middle + (mirrored.forward() - middle)).abs() < 1e-12);
        assert!((x.up() - mirrored.up()).abs() < 1e-12);
        moved = moved.max(x.distance(back.x[node]));
    }
    assert!(moved > 1e-4, "{moved}");
}

/// Drawn goals are in the interval and apart from one another, and the first ones are on the side that is asked for.
#[test]
fn goals_are_drawn_in_the_interval_and_apart() {
    for (along, apart) in [
        ([-1.5, 1.5], 0.75),
        ([-0.5, 2.0], 0.625),
        ([0.5, 2.0], 0.375),
    ] {
        let (scene, case) = robot(&format!("goals.along = {along:?}"));
        let world = case.world();
        let start = case.start.x[0].forward();
        let mut stream = stream(7, Purpose::Goals);
        let mut places = Vec::new();
        for k in 0..200 {
            let goals = draw_goals(&world, &scene.goals, k % 2 == 0, &mut stream);
            let mut last = 0.0;
            for (k, point) in goals.iter().enumerate() {
                let place = point.forward() - start;
                assert!(along[0] <= place && place <= along[1], "{place}");
                // The place of the payload at the start is added and subtracted again.
                assert!((place - last).abs() > apart - 1e-12, "{last} {place}");
                if k == 0 && along[0] < -apart {
                    places.push(place);
                }
                last = place;
            }
        }
        let ahead = places.iter().filter(|place| **place > 0.0).count();
        assert_eq!(2 * ahead, places.len());
    }
}

/// In space, goals are also drawn across, as far as `goals.across` allows. Their places along the ground are then the same
/// as those of a robot that only walks ahead and back.
#[test]
fn goals_in_space_are_drawn_across() {
    let drawn = |across: &str| {
        let (scene, case) = robot(&format!(
            "{CUBIC}lattice.depth = 2\ngoals.across = {across}"
        ));
        let (world, start) = (case.world(), case.start.x[0]);
        let drawn = (0..100).flat_map(|k| {
            let goals = draw_goals(&world, &scene.goals, true, &mut stream(k, Purpose::Goals));
            goals.iter().map(|goal| goal - start).collect::<Vec<_>>()
        });
        drawn.collect::<Vec<_>>()
    };
    let (ahead, beside) = (drawn("[0, 0]"), drawn("[-0.5, 1.0]"));
    assert!(ahead.iter().all(|goal| goal.sideways() == 0.0));
    let across = beside.iter().map(|goal| goal.sideways());
    let (low, high) = across.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    assert!((-0.5..-0.45).contains(&low), "{low}");
    assert!((0.95..=1.0).contains(&high), "{high}");
    for (a, b) in ahead.chunks(3).zip(beside.chunks(3)) {
        assert_eq!(a[0].forward(), b[0].forward());
    }
}
