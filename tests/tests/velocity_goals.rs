//! Goals that are velocities: how a robot observes them, batches, and the loss of errands.

use crate::goals::loss_at;

use std::f64::consts::TAU;

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Real};
use cosmic::case::Case;
use cosmic::domain::{Domain, rollouts};
use cosmic::geometry::{Vector, weighted_mean};
use cosmic::lattice::State;
use cosmic::objective::{Errand, Loss};
use cosmic::policy::{Goal, Goals};
use cosmic::scene::Scene;
use cosmic::simulator::Span;

const POINT: Goal = Goal::Point(Vector::new([0.8, 0.1]));
const BACK: Goal = Goal::Velocity(-0.3);

/// A small robot that observes its goals, and its scene.
fn robot() -> (Scene, Case) {
    let scene = Scene::load("errand").unwrap().set(&[
        "lattice.columns=3",
        "lattice.rows=2",
        "lattice.payload=0",
        "lattice.mirror=false",
        "controller.hidden=6",
        "loss.window=20",
        "loss.every=8",
    ]);
    let scene = scene.unwrap();
    let case = Case::of_scene(&scene, 1).unwrap();
    (scene, case)
}

/// The state of the robot after `steps` steps from `start`, which it reaches after `first` steps.
fn walked(
    case: &Case,
    goals: &Goals,
    start: &State<f64>,
    [first, steps]: [usize; 2],
) -> State<f64> {
    let span = Span {
        first,
        ..Span::from_start(vec![steps])
    };
    let task = case.task().with_goals(goals);
    let mut seen = task.rollout(&case.own_design(), &case.controller, start, &span);
    seen.states.remove(0)
}

fn apart(a: &State<f64>, b: &State<f64>) -> f64 {
    let pairs = a.to_columns().into_iter().zip(b.to_columns());
    pairs.fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()))
}

/// In every step, a velocity is observed as a point that is ahead of the mean position: as far as the robot would come
/// at this velocity in one and a half periods of its clock.
#[test]
fn a_velocity_is_a_point_that_keeps_ahead() {
    let (_, case) = robot();
    let lead = 1.5 * TAU / case.observation.omega;
    let far = walked(&case, &Goals::at(POINT), &case.start, [0, 200]);
    for (first, start) in [(0, &case.start), (200, &far)] {
        for velocity in [0.4, -0.1] {
            let mean = weighted_mean(&start.x, &case.body().presence);
            let point = mean + Vector::new([velocity * lead, 0.0]);
            let [by_velocity, by_point, other] = [
                Goals::at(Goal::Velocity(velocity)),
                Goals::at(point),
                Goals::at(Goal::Velocity(-velocity)),
            ]
            .map(|goals| walked(&case, &goals, start, [first, 1]));
            // The offset is rounded differently; everything else is the same.
            let same = apart(&by_velocity, &by_point);
            assert!(same < 1e-14, "{same:e}");
            assert!(apart(&by_velocity, &other) > 1e-7);
        }
    }
}

/// A rollout in which a point is followed by a velocity, or the other way round, is a rollout to the first goal, continued
/// from its last state to the second one. Robots of one batch may have goals of both kinds.
#[test]
fn points_and_velocities_may_follow_one_another() {
    let (_, case) = robot();
    let sequences = [[POINT, BACK], [BACK, POINT]].map(|[first, second]| {
        let half = walked(&case, &Goals::at(first), &case.start, [0, 100]);
        let whole = walked(&case, &Goals::at(second), &half, [100, 100]);
        let goals = Goals::at(first).then(100, second);
        let changed = walked(&case, &goals, &case.start, [0, 200]);
        // A state between two rollouts is rounded once more, when it is converted to the world's frame and back.
        assert!(apart(&changed, &whole) < 1e-11);
        (goals, changed)
    });
    let tasks = sequences
        .each_ref()
        .map(|(goals, _)| case.task().with_goals(goals));
    let domains = [0, 1, 0, 0, 1].map(|k| Domain::of(&tasks[k], case.start.clone()));
    let span = Span::from_start(vec![200]);
    let together = rollouts(&[case.own_design()], &case.controller, &domains, &span);
    for (k, seen) in [0, 1, 0, 0, 1].into_iter().zip(together) {
        assert_eq!(seen.states[0], sequences[k].1);
    }
    assert!(apart(&sequences[0].1, &sequences[1].1) > 1e-4);
}

/// The loss of errands in a rollout with a velocity and then a point, as a function of the velocity and the point.
struct ByGoals<'a> {
    case: &'a Case,
    loss: Errand,
}

impl Function for ByGoals<'_> {
    fn eval<R: Real>(&self, numbers: &[R]) -> R {
        let goals = Goals::at(BACK).then(24, POINT);
        let simulator = self.case.task().with_goals(&goals).simulator;
        let surroundings = simulator.surroundings().with("goal.0.along", numbers[0]);
        let surroundings = surroundings.with("goal.1.along", numbers[1]);
        let body = self.case.body().map(R::lit);
        let controller = self.case.controller.map(R::lit);
        let start = self.case.start.map(R::lit);
        let span = Span::from_start((0..=48).collect());
        let seen = simulator.rollout_in(&surroundings, &body, &controller, &start, &span);
        self.loss.loss(&seen)
    }
}

#[test]
fn the_loss_has_the_right_gradient_by_a_velocity() {
    let (scene, case) = robot();
    let loss = Errand::of_scene(&scene);
    let by_goals = ByGoals { case: &case, loss };
    // Contacts cause kinks, which differences with a relative step of 1e-2 would cross.
    let options = Options {
        largest_step: 1e-5,
        ..Options::default()
    };
    let report = check_gradient(&by_goals, &[-0.3, 0.8], &options);
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
}

/// The loss of a velocity is 0 if the payload has the mean velocity, 1 if it stays, and 2 if it moves as fast the other
/// way. The way to a point begins where the velocity before it leads.
#[test]
fn the_loss_of_a_velocity_compares_mean_velocities() {
    let (scene, case) = robot();
    let steps = scene.physics.steps;
    let changes: Vec<usize> = scene.goals.changes(steps).collect();
    let seconds = |steps: usize| steps as f64 * scene.physics.dt;
    let start = case.start.x[0].forward();
    // The velocities lead 1 m ahead and 2 m back, and the point between them is at the start.
    let goals = Goals::at(Goal::Velocity(1.0 / seconds(changes[0])));
    let goals = goals.then(changes[0], Vector::new([start, 0.1]));
    let goals = goals.then(
        changes[1],
        Goal::Velocity(-2.0 / seconds(steps - changes[1])),
    );
    let left = |along: [f64; 3]| loss_at((&scene, &case), &goals, along);
    for (along, expected) in [
        ([1.0, 0.0, -2.0], 0.0),
        ([0.0, 0.5, 0.5], (1.0 + 0.5 + 1.0) / 3.0),
        ([-1.0, 0.0, -1.0], (2.0 + 0.0 + 0.5) / 3.0),
    ] {
        let left = left(along);
        // A mean of some hundred distances of order one.
        assert!((left - expected).abs() < 1e-13, "{along:?}: {left}");
    }
}
