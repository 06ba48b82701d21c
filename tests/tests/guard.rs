//! The guard checks the states of a rollout for absurd numbers. It finds every absurd state among those that the
//! rollout returns, even if only a single state is absurd.

use cosmic::case::Case;
use cosmic::design::{Design, Material, Mixture};
use cosmic::error::Error;
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::policy::{Block, Controller, blocks_of};
use cosmic::scene::{Integrator, Scene, UnstableStep, VoidEdges};
use cosmic::walk::{self, GuardedRollout};
use cosmic::world::{Robot, Span};
use cosmic_tests::laws;
use std::sync::Arc;

/// A robot of 2x2 nodes. `change` changes its scene; without a change, the robot does not diverge.
fn case(change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    scene.controller.hidden = 2;
    scene.physics.steps = 300;
    scene.physics.speed_bound = None;
    change(&mut scene);
    Case::of_scene(&scene, 0).expect("any lattice starts so")
}

/// A test of the guard: a change of the scene, a change of the case, and the expected result. The result is the step
/// and the node of the first state that is absurd or too fast, and the end of the message; `None` if no state is.
type Watched = (
    fn(&mut Scene),
    fn(&mut Case),
    Option<(usize, usize, &'static str)>,
);

fn unchanged<T>(_: &mut T) {}

/// Removes the stiffness of all springs, so that nodes do not hold each other.
fn loose(scene: &mut Scene) {
    scene.materials.stiffness = [0.0; 3];
}

/// Moves the robot up.
fn raise(case: &mut Case, height: f64) {
    case.start
        .x
        .iter_mut()
        .for_each(|x| *x = x.with_up(x.up() + height));
}

fn on_incline(scene: &mut Scene) {
    (scene.physics.incline_deg, scene.physics.contact) = (15.0, ContactLaw::coulomb());
}

/// Throws a node upwards at 30 m/s.
fn throw(case: &mut Case) {
    case.start.v[3] = [0.0, 30.0].into();
}

const BY_VELOCITY: &str = "mostly by the node's own velocity";

static WATCHED: [Watched; 17] = [
    (unchanged, unchanged, None),
    (|s| s.physics.substeps = 3, unchanged, None),
    (
        |s| s.physics.integrator = Integrator::Leapfrog,
        |case| case.scene.physics.substeps = 2,
        None,
    ),
    (on_incline, |case| case.scene.physics.substeps = 3, None),
    (
        on_incline,
        |case| case.scene.physics.integrator = Integrator::Leapfrog,
        None,
    ),
    // The first search reports this state, but it is not absurd: the second search accepts it.
    (loose, |case| case.start.v[2] = [7e5, 0.0].into(), None),
    (loose, |case| raise(case, 7e5), None),
    (
        loose,
        |case| raise(case, 2e6),
        Some((0, 0, "mostly by gravity")),
    ),
    // The node falls at 2000 km/s until the ground stops it in the third step. Then it is as slow as the other nodes,
    // so later states do not show that one was absurd.
    (
        |s| {
            loose(s);
            s.lattice.drop = 1e4;
        },
        |case| case.start.v[3] = [0.0, -2e6].into(),
        Some((0, 3, BY_VELOCITY)),
    ),
    // The node moves about 10 km in each step. It is too far away only in the second block of states that the guard
    // searches.
    (
        |s| {
            loose(s);
            (s.physics.damping, s.physics.gravity) = (0.0, 0.0);
            (s.physics.dt, s.physics.incline_deg) = (1.0, 15.0);
        },
        |case| case.start.v[2] = [1e4, 1e4].into(),
        Some((99, 2, BY_VELOCITY)),
    ),
    (
        unchanged,
        |case| case.controller.block_mut("b2")[4] = f64::NAN,
        Some((0, 1, "mostly by the controller's output for edge 4")),
    ),
    (
        |s| s.physics.gravity = -1e12,
        unchanged,
        Some((0, 0, "mostly by gravity")),
    ),
    (
        |s| s.materials.stiffness = [1e12; 3],
        |case| case.start.x[1] = case.start.x[0],
        Some((0, 1, "mostly by the spring of edge 3 [1, 3]")),
    ),
    // If a scene has more forces than Hooke's law, the message names the force that caused the divergence.
    (
        |s| {
            s.materials.stiffness = [1e9; 3];
            s.physics.forces =
                laws::forces("physics.forces = ['stiffening']\nstiffening.cubic = 1e6");
        },
        |case| case.start.x[1] += Vector::upright(0.05, 0.0),
        Some((0, 1, "mostly by the stiffening of edge 4 [1, 2]")),
    ),
    (unchanged, throw, None),
    (|s| s.physics.speed_bound = Some(35.0), throw, None),
    (
        |s| s.physics.speed_bound = Some(10.0),
        throw,
        Some((0, 3, "m/s; `physics.speed_bound` allows 10 m/s")),
    ),
];

fn guarded(case: &Case, span: &Span) -> GuardedRollout {
    let (world, robot) = (case.world(), case.robot());
    let guarded = walk::guarded(&world, &robot, span);
    // A guarded rollout has the same states as a plain one, including NaNs.
    let plain = world.run_one(&robot, span);
    assert_eq!(format!("{:?}", guarded.trajectory), format!("{plain:?}"));
    guarded
}

/// The guard finds every absurd state and names its cause, and the saved file reproduces it. The states of other
/// rollouts do not change.
#[test]
fn every_absurd_state_is_found_and_replayed() {
    let (mut wrong, mut replayed) = (Vec::new(), 0);
    for (k, (scene, change, expected)) in WATCHED.iter().enumerate() {
        let mut case = case(scene);
        change(&mut case);
        let span = Span::from_start(vec![0, 7, case.scene.physics.steps]);
        let found = guarded(&case, &span).divergence;
        let Some((step, node, words)) = *expected else {
            assert_eq!(found, None, "{k}");
            continue;
        };
        let found = found.unwrap_or_else(|| panic!("nothing is found in {k}"));
        let said = Error::from(&found).to_string();
        if (found.step, found.node) != (step, node) || !said.ends_with(words) {
            wrong.push(format!("{k}: {said}"));
        }
        // The report has the absurd state and up to eight states before it. All are states of the rollout.
        let steps: Vec<usize> = (found.step.saturating_sub(7)..=found.step + 1).collect();
        assert_eq!(found.last.steps, steps);
        let last = guarded(&case, &Span::from_start(steps)).trajectory;
        assert_eq!(
            format!("{:?}", last.states),
            format!("{:?}", found.last.states)
        );
        let (after, before) = last.states.split_last().expect("it has states");
        // The start is not checked.
        let mut before = before.iter().skip(usize::from(last.steps[0] == 0));
        assert!(!before.any(State::is_absurd), "{k}");
        let too_fast = case.scene.physics.speed_bound.is_some();
        assert_eq!(after.is_absurd(), !too_fast, "{k}");
        // A file that is made from the report replays the divergence and names its cause.
        let text = case.diverged_json(&found);
        assert!(text.contains(&found.term.to_string()), "{text}");
        // A case with NaN or with settings out of range cannot be read again.
        if Case::parse("case.json", &case.to_json()).is_err() {
            continue;
        }
        replayed += 1;
        let again = Case::parse("diverged.json", &text).expect("it is a case");
        let results = again.evaluate(false, &[]).expect("it lists its steps");
        assert_eq!(
            format!("{:?}", results.divergence),
            format!("{:?}", Some(found))
        );
    }
    assert!(wrong.is_empty() && replayed > 3, "{replayed}: {wrong:#?}");
}

/// If a rollout begins at a later time, the search for a divergence uses the same time.
#[test]
fn a_part_of_a_rollout_is_searched_by_its_own_clock() {
    let case = case(|scene| {
        (scene.physics.dt, scene.physics.damping) = (0.02, 0.0);
        (scene.controller.clocks, scene.controller.velocity_scale) = (1, 0.0);
        scene.physics.unstable_step = UnstableStep::Warn;
    });
    let mut found = 0;
    for first in [0, 25, 50, 100] {
        let span = Span {
            first,
            ..Span::from_start((1..=150).collect())
        };
        let GuardedRollout {
            trajectory,
            divergence,
        } = guarded(&case, &span);
        let absurd = trajectory.states.iter().position(State::is_absurd);
        let step = divergence.as_ref().map(|found| found.step - first);
        assert_eq!(step, absurd);
        if let Some(divergence) = divergence {
            let after = divergence.last.states.last();
            let same = Some(&trajectory.states[divergence.step - first]);
            assert_eq!(format!("{after:?}"), format!("{same:?}"));
            found += 1;
        }
    }
    assert!(found > 0, "no part diverges");
}

/// The guard refuses a controller or a start of another lattice, even if its arrays are long enough to be read by
/// mistake.
#[test]
fn parts_of_another_lattice_are_refused() {
    let (small, large) = (case(|_| {}), case(|scene| scene.lattice.columns = 3));
    let mut shifted = small.start.clone();
    let last = shifted.x.pop().expect("four nodes");
    shifted.v.insert(0, last);
    let numbers = [small.controller.numbers(), &[0.0; 2]].concat();
    let edges = small.lattice.edges.len();
    let blocks = blocks_of(&small.scene.controller, &small.lattice)
        .into_iter()
        .take(3);
    let shapes: Vec<Block> = blocks.chain([Block::biases("b2", edges + 2)]).collect();
    let longer = Controller::new(&shapes, numbers);
    let sees = "numbers of the controller in `w1` of a robot of 4 nodes";
    for (controller, start, says) in [
        (&large.controller, &small.start, sees),
        (
            &small.controller,
            &large.start,
            "initial positions of a robot",
        ),
        (&small.controller, &shifted, "initial positions"),
        (&longer, &small.start, "in `b2` of a robot"),
    ] {
        let world = small.world();
        let robot = world.robot(small.body(), controller.clone(), start);
        let run = || world.run_one(&robot, &Span::of_steps(1));
        let refused = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
        let said = refused.expect_err("it is of another lattice");
        let said = said.downcast::<String>().expect("a sentence");
        assert!(said.contains(says), "{said}");
    }
}

/// Robots that run together have the same bits as in single runs. If one of several starts diverges, only this start is
/// reported.
fn hold_together(
    case: &Case,
    designs: &[Design<Mixture<f64>>],
    starts: &[&State<f64>],
    wrong: usize,
) {
    let (world, own) = (case.world(), case.robot());
    let bodies = designs.iter().map(|design| Arc::new(world.body(design)));
    let robots = bodies.cycle().zip(starts).map(|(body, start)| Robot {
        body,
        ..own.from(start)
    });
    let robots: Vec<_> = robots.collect();
    let span = Span::from_start(vec![0, 7, case.scene.physics.steps]);
    for watched in [true, false] {
        let span = Span {
            watched,
            ..span.clone()
        };
        let together = world.run(&robots, &span);
        for (k, (robot, seen)) in robots.iter().zip(&together).enumerate() {
            let alone = world.run_one(robot, &span);
            assert_eq!(format!("{seen:?}"), format!("{alone:?}"), "{k}");
            let guarded = walk::guarded(&world, robot, &span);
            assert_eq!(guarded.divergence.is_some(), k == wrong, "{k}");
            let shows = watched && k == wrong;
            assert_eq!(seen.states[0].x[0].forward().is_nan(), shows, "{k}");
        }
        assert_ne!(together[0].states[2], together[1].states[2]);
    }
}

/// Gives a node of the upper row an absurd speed. (The ground would stop a node of the lower row.)
fn thrown(start: &State<f64>) -> State<f64> {
    let mut thrown = start.clone();
    thrown.v[3] = [2e6, 0.0].into();
    thrown
}

#[test]
fn several_starts_together_are_watched_one_by_one() {
    const WRONG: usize = 3;
    for contact in [ContactLaw::infinite(), ContactLaw::coulomb()] {
        let case = case(|scene| scene.physics.contact = contact);
        let mut starts = vec![case.start.clone(); 9];
        for (k, start) in starts.iter_mut().enumerate() {
            start.x[k % 4] += Vector::upright(1e-3 * k as f64, 0.0);
        }
        starts[WRONG] = thrown(&starts[WRONG]);
        let starts: Vec<_> = starts.iter().collect();
        hold_together(&case, &[case.own_design()], &starts, WRONG);
    }
}

/// Layouts that run together have the same bits as in single runs. The batch computes every void edge, and every output
/// of the controller, that at least one of the layouts needs.
#[test]
fn several_layouts_together_have_the_bits_of_each_alone() {
    const WRONG: usize = 5;
    for void_edges in [VoidEdges::Keep, VoidEdges::Drop] {
        let case = case(|scene| {
            scene.physics.void_edges = void_edges;
            scene.physics.forces =
                laws::forces("physics.forces = ['bending']\nbending.radius = 0.02");
        });
        let edges = case.lattice.edges.len();
        // The materials of the edges are void, skeleton and actuator in turn; each layout begins with another one.
        let layout = |k: usize| {
            let material = |edge| Material::ALL[(edge * k + edge + k) % 3];
            Design::Layout((0..edges).map(material).collect())
        };
        let layouts: Vec<_> = (0..12).map(layout).collect();
        let wrong = thrown(&case.start);
        for count in [2, 3, 9, 12] {
            let start = |k: usize| if k == WRONG { &wrong } else { &case.start };
            let starts: Vec<_> = (0..count).map(start).collect();
            hold_together(&case, &layouts[..count], &starts, WRONG);
        }
    }
}
