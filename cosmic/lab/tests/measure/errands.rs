use crate::small::small;
use cosmic::case::Case;
use cosmic::domain::draw_goals;
use cosmic::laws::ContactLaw;
use cosmic::policy::Goals;
use cosmic::random::{Purpose, stream_of};
use cosmic::scene::{GoalKind, GoalsSettings, MovedBody};
use cosmic::simulator::Span;
use cosmic_lab::measure::{Errand, Errands, Loops};
use cosmic_lab::walk::{place, walk};

const STEPS: usize = 300;

/// A small robot that takes goals and slides down a slope.
fn robot(speed_bound: Option<f64>) -> (Case, GoalsSettings) {
    let mut goals = GoalsSettings::default();
    let case = small([3, 3], |scene| {
        (scene.controller.goals, scene.controller.goal_scale) = (GoalKind::Given, 3.0);
        (scene.physics.steps, scene.physics.incline_deg) = (STEPS, 30.0);
        (scene.physics.contact, scene.physics.friction) = (ContactLaw::coulomb(), 0.2);
        scene.physics.speed_bound = speed_bound;
        goals = scene.goals.clone();
    });
    (case, goals)
}

fn measured((case, goals): &(Case, GoalsSettings), seed: u64) -> Errands {
    Errands::measure(case, goals, seed, &|| false).unwrap()
}

/// The goals of a sequence.
fn goals_of(case: &Case, settings: &GoalsSettings, errands: &[Errand]) -> Goals {
    let goal = |errand: &Errand| place(case, errand.goal);
    let later = settings.changes(STEPS).zip(&errands[1..]);
    later.fold(Goals::at(goal(&errands[0])), |goals, (steps, errand)| {
        goals.then(steps, goal(errand))
    })
}

#[test]
fn errands_are_the_legs_of_walks() {
    let robot = robot(None);
    let (case, settings) = &robot;
    let found = measured(&robot, 3).undisturbed;
    assert_eq!([found.closed.len(), found.open.len()], [16, 16]);
    // A goal is computed from the start and back, and its rounding grows on the way.
    let near = |a: Option<f64>, b: f64| assert!((a.unwrap() - b).abs() < 1e-9, "{a:?} is not {b}");
    for (k, errands) in found.closed.iter().enumerate() {
        assert_eq!(errands[0].ahead, k % 2 == 0);
        let goals = goals_of(case, settings, errands);
        let legs = walk(case, &goals, STEPS).unwrap().legs;
        assert_eq!(errands.len(), 3);
        for (errand, leg) in errands.iter().zip(&legs) {
            near(errand.ratio, leg.ratio().unwrap());
            assert_eq!(errand.ahead, leg.is_ahead);
        }
    }
    // In open loop, the library is told what the controller observes.
    let errands = &found.open[0];
    let task = case.task().with_goals(&goals_of(case, settings, errands));
    let task = task.without_feedback(&case.start);
    let span = Span::from_start(vec![0, 100]);
    let seen = task.rollout(&case.own_design(), &case.controller, &case.start, &span);
    let from = place(case, errands[0].goal).forward();
    let [way, left] = [0, 100].map(|step| (from - task.ground().along(seen.position(step))).abs());
    near(errands[0].ratio, left / way);
    assert_ne!(found.open, found.closed);
}

#[test]
fn disturbances_begin_after_the_start_and_change_walks_in_both_loops() {
    let found = measured(&robot(None), 3);
    let same = |k: fn(&Loops) -> &Vec<Vec<Errand>>, disturbed: &Loops| -> Vec<usize> {
        let pairs = k(&found.undisturbed).iter().zip(k(disturbed));
        let same = |(a, b): (&Vec<Errand>, &Vec<Errand>)| {
            assert_eq!(a[0].goal, b[0].goal);
            let pairs = a.iter().zip(b);
            pairs.take_while(|(a, b)| a == b).count()
        };
        pairs.map(same).collect()
    };
    for of in [
        (|loops| &loops.closed) as fn(&Loops) -> &Vec<Vec<Errand>>,
        |loops| &loops.open,
    ] {
        // A push comes during the first, the second or the third goal. The goals before do not notice it.
        let pushed = same(of, &found.pushed);
        assert!((0..3).all(|leg| pushed.contains(&leg)), "{pushed:?}");
        // The robot slides from the level ground onto the rough ground.
        let rough = same(of, &found.rough);
        assert!(rough.iter().all(|&leg| leg < 3), "{rough:?}");
        let lost = same(of, &found.lost);
        assert!(lost.iter().all(|&leg| leg == 0), "{lost:?}");
    }
}

/// Without gravity the speed of a push is 0. The two parts of the walk then join to the undisturbed one.
#[test]
fn a_push_of_no_speed_changes_nothing() {
    let (mut case, goals) = robot(None);
    (case.physics.gravity, case.moved) = (0.0, MovedBody::Nodes);
    let found = measured(&(case, goals), 3);
    let all = |loops: &Loops| [&loops.closed[..], &loops.open].concat().concat();
    let pairs = all(&found.undisturbed).into_iter().zip(all(&found.pushed));
    for (a, b) in pairs {
        // The state before a push is rounded once more, when it is converted to the world's frame and back, and this
        // rounding grows on the way.
        let apart = (a.ratio.unwrap() - b.ratio.unwrap()).abs();
        assert!(apart < 1e-9, "{a:?} is not {b:?}");
    }
    // The robots move, so that a wrong clock or a wrong start would be noticed.
    let moved = all(&found.undisturbed).into_iter();
    let moved = moved.filter(|errand| (errand.ratio.unwrap() - 1.0).abs() > 1e-4);
    assert!(moved.count() > 48);
}

#[test]
fn sequences_are_reproducible_and_no_robot_was_ranked_by_them() {
    let robot = robot(None);
    let (case, settings) = &robot;
    let found = measured(&robot, 3);
    assert_eq!(found, measured(&robot, 3));
    let firsts = |found: &Errands| -> Vec<f64> {
        let sequences = found.undisturbed.closed.iter();
        sequences.map(|errands| errands[0].goal).collect()
    };
    let unseen = firsts(&found);
    let other = firsts(&measured(&robot, 4));
    assert!(other.iter().all(|goal| !unseen.contains(goal)));
    let start = place(case, 0.0).forward();
    for purpose in [
        Purpose::Ranking,
        Purpose::Selection,
        Purpose::DomainRandomisation,
        Purpose::Judgement,
        Purpose::Variation,
    ] {
        let mut stream = stream_of(3, Purpose::Errands, purpose as u64);
        for k in 0..16 {
            let drawn = draw_goals(&case.task(), settings, 3, k % 2 == 0, &mut stream);
            let goal = drawn.iter().next().unwrap().forward() - start;
            assert!(!unseen.contains(&goal), "{purpose:?}");
        }
    }
}

/// A robot that diverges has no ratios, and its goals are ahead or behind as they follow one another.
#[test]
fn a_robot_that_diverges_reaches_no_goal() {
    let found = measured(&robot(Some(0.01)), 3);
    for errands in found.undisturbed.closed.iter().chain(&found.rough.open) {
        let mut before = 0.0;
        for errand in errands {
            assert_eq!(errand.ratio, None);
            assert_eq!(errand.ahead, errand.goal > before);
            before = errand.goal;
        }
    }
    let (case, goals) = robot(None);
    assert_eq!(Errands::measure(&case, &goals, 3, &|| true), None);
}
