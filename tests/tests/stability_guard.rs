//! The guard: no absurd state of a delivered rollout goes unnoticed, however short.

use cosmic::case::Case;
use cosmic::design::{Material, one_hot};
use cosmic::error::Error;
use cosmic::laws::ContactLaw;
use cosmic::scene::{Integrator, Scene, VoidEdges};
use cosmic::simulator::{Cause, Divergence, Guarded, Span};

/// A robot of 2x2 nodes far from any trouble.
fn case(change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (2, 2);
    scene.controller.hidden = 2;
    scene.physics.steps = 300;
    scene.physics.speed_bound = None;
    change(&mut scene);
    Case::of_scene(&scene, 0).expect("any lattice starts so")
}

fn watched(span: &Span) -> Span {
    Span {
        watched: true,
        ..span.clone()
    }
}

fn guarded(case: &Case) -> Guarded {
    let mixture = case.own_mixture();
    let (task, controller, start) = (case.task(), &case.controller, &case.start);
    let span = Span::from_start(vec![0, 7, case.physics.steps]);
    let guarded = task.guarded(&mixture, controller, start, &span);
    // The guard does not change the states of a rollout, NaN for NaN.
    let plain = task.rollout(&mixture, controller, start, &span);
    assert_eq!(format!("{:?}", guarded.trajectory), format!("{plain:?}"));
    guarded
}

fn diverges(case: &Case) -> Divergence {
    guarded(case).divergence.expect("it is absurd")
}

#[test]
fn a_sane_rollout_is_delivered_as_it_is() {
    for (incline_deg, contact) in [(0.0, ContactLaw::infinite()), (15.0, ContactLaw::coulomb())] {
        for (integrator, substeps) in [
            (Integrator::SymplecticEuler, 1),
            (Integrator::SymplecticEuler, 3),
            (Integrator::Leapfrog, 2),
        ] {
            let case = case(|scene| {
                (scene.physics.incline_deg, scene.physics.contact) = (incline_deg, contact.clone());
                (scene.physics.integrator, scene.physics.substeps) = (integrator, substeps);
            });
            assert_eq!(guarded(&case).divergence, None);
        }
    }
}

/// A node falls at 2000 km/s, is stopped by the ground in the third step, and is as quiet as the
/// others ever after: no later state shows it.
#[test]
fn a_state_that_is_absurd_for_a_moment_is_found() {
    let mut case = case(|scene| {
        scene.materials.stiffness = [0.0; 3];
        scene.lattice.drop = 1e4;
    });
    case.start.v[3] = [0.0, -2e6].into();
    let results = case.evaluate(false, &[300]).expect("300 is the last");
    assert!(!results.trajectory[&300].is_absurd());
    let found = results.divergence.expect("steps 1 and 2 are absurd");
    assert_eq!(
        (found.step, found.node, &found.term),
        (0, 3, &Cause::Motion)
    );
    assert!(found.velocity[1] < -1e6 && found.position[1] > 0.0);
    assert_eq!(found, diverges(&case));
}

/// Farther than the trap, and not yet absurd: found to be sane by the second look.
#[test]
fn what_is_large_and_not_absurd_is_let_be() {
    let mut case = case(|scene| scene.materials.stiffness = [0.0; 3]);
    case.start.v[2] = [7e5, 0.0].into();
    assert_eq!(guarded(&case).divergence, None);
    case.start.v[2] = [0.0; 2].into();
    // The whole world is moved: the trap is set around the ground, sanity around the origin.
    case.physics.ground_height = 7e5;
    case.start.x.iter_mut().for_each(|x| x[1] += 7e5);
    assert_eq!(guarded(&case).divergence, None);
    case.physics.ground_height = 2e6;
    case.start.x.iter_mut().for_each(|x| x[1] += 2e6);
    assert_eq!(diverges(&case).step, 0);
}

/// A node drifts away: it takes the second block of the search to see it too far off.
#[test]
fn the_last_states_are_those_of_the_rollout() {
    let mut case = case(|scene| {
        scene.physics.incline_deg = 15.0;
        (scene.physics.damping, scene.physics.gravity) = (0.0, 0.0);
        (scene.physics.dt, scene.materials.stiffness) = (1.0, [0.0; 3]);
    });
    case.start.v[2] = [1e4, 1e4].into();
    let found = diverges(&case);
    // From 0.1 m on by 10 km a step.
    assert_eq!(
        (found.step, found.node, &found.term),
        (99, 2, &Cause::Motion)
    );
    let mixture = case.own_mixture();
    let span = Span::from_start(found.last.steps.clone());
    let task = case.task();
    let seen = task.rollout(&mixture, &case.controller, &case.start, &span);
    let states = seen.states;
    assert_eq!(states, found.last.states);
    assert_eq!(found.last.steps, (92..=100).collect::<Vec<_>>());
    let absurd: Vec<bool> = states.iter().map(|s| s.is_absurd()).collect();
    assert!(absurd[8] && !absurd[..8].contains(&true));
}

/// A rollout that begins late has the clock of its own steps, and so has the search.
#[test]
fn a_part_of_a_rollout_is_searched_by_its_own_clock() {
    let case = case(|scene| {
        (scene.physics.dt, scene.physics.damping) = (0.02, 0.0);
        (scene.controller.clocks, scene.controller.velocity_scale) = (1, 0.0);
        scene.physics.unstable_step = cosmic::scene::UnstableStep::Warn;
    });
    let mixture = case.own_mixture();
    let (task, controller, start) = (case.task(), &case.controller, &case.start);
    let mut found = 0;
    for first in [0, 25, 50, 100] {
        let span = Span {
            first,
            ..Span::from_start((1..=150).collect())
        };
        let guarded = task.guarded(&mixture, controller, start, &span);
        let seen = guarded.trajectory.states.iter();
        let absurd = seen.zip(1..).find(|(state, _)| state.is_absurd());
        let step = guarded.divergence.as_ref().map(|found| found.step);
        assert_eq!(step, absurd.map(|(_, steps)| first + steps - 1));
        if let Some(found) = guarded.divergence {
            let after = &found.last.states[found.last.states.len() - 1];
            let same = &guarded.trajectory.states[found.step - first];
            assert_eq!(format!("{after:?}"), format!("{same:?}"));
        }
        found += usize::from(step.is_some());
    }
    assert!(found > 0, "no part diverges");
}

/// Parts that are long enough to be misread, and parts that are not.
#[test]
fn parts_of_another_lattice_are_refused() {
    let (small, large) = (case(|_| {}), case(|scene| scene.lattice.columns = 3));
    let span = Span::from_start(vec![1]);
    let says = |mixture: &[[f64; 3]], controller, start| {
        let task = small.task();
        let run = || task.rollout(mixture, controller, start, &span);
        let refused = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
        let says = refused.expect_err("it is of another lattice");
        *says.downcast::<String>().expect("a sentence")
    };
    let of = small.own_mixture();
    let foreign = says(&of, &large.controller, &small.start);
    assert!(foreign.contains("what the controller sees of a robot of 4 nodes"));
    assert!(says(&of, &small.controller, &large.start).contains("initial positions of a robot"));
    let mut shifted = small.start.clone();
    let last = shifted.x.pop().expect("four nodes");
    shifted.v.insert(0, last);
    assert!(says(&of, &small.controller, &shifted).contains("initial positions"));
    let mut longer = small.controller.clone();
    longer.w2.extend([0.0; 2]);
    assert!(says(&of, &longer, &small.start).contains("second weights of a robot"));
}

#[test]
fn the_term_to_blame_is_named() {
    let mut broken = case(|_| {});
    broken.controller.b2[4] = f64::NAN;
    let found = diverges(&broken);
    assert_eq!(found.term, Cause::Controller { edge: 4 });
    assert!(broken.lattice.edges[4].contains(&found.node) && found.step == 0);
    let said = Error::from(&found).to_string();
    assert!(
        said.ends_with("mostly by the controller's output for edge 4"),
        "{said}"
    );

    let fall = case(|scene| scene.physics.gravity = -1e12);
    assert_eq!(diverges(&fall).term, Cause::Gravity);

    let mut stiff = case(|scene| scene.materials.stiffness = [1e12; 3]);
    stiff.start.x[1] = stiff.start.x[0];
    let found = diverges(&stiff);
    assert!(
        found
            .term
            .to_string()
            .starts_with("mostly by the spring of edge"),
        "{found:?}"
    );
}

/// Of the forces that a scene asks for beside Hooke's, the one that acts.
#[test]
fn richer_physics_are_blamed_for_what_they_do() {
    // 0.05 m off by Hooke's law alone the springs, of 1e-3 N/m, would do less than gravity.
    let soft = |scene: &mut Scene| scene.materials.stiffness = [1e-3; 3];
    let mut stiffening = case(|scene| {
        soft(scene);
        scene.physics.stiffening = 1e18;
    });
    stiffening.start.x[1][0] += 0.05;
    let found = diverges(&stiffening);
    assert!(
        found
            .term
            .to_string()
            .starts_with("mostly by the spring of edge"),
        "{found:?}"
    );

    let mut bent = case(|scene| {
        soft(scene);
        scene.lattice.columns = 3;
        scene.physics.bending_radius = 1e6;
    });
    bent.start.x[1][1] += 0.05;
    let found = diverges(&bent);
    let said = Error::from(&found).to_string();
    let expected = "mostly by the bending of the bar over nodes [";
    let (_, nodes) = said.split_once(expected).expect(&said);
    let mut nodes = nodes.trim_end_matches(']').split(", ");
    assert!(nodes.any(|node| node == found.node.to_string()), "{said}");
}

/// A file that shows it again, with what is known of it in its note.
#[test]
fn a_divergence_is_replayed_from_its_file() {
    let fall = case(|scene| scene.physics.gravity = -1e12);
    let found = diverges(&fall);
    let text = fall.diverged_json(&found);
    assert!(text.contains("mostly by gravity"), "{text}");
    let again = Case::parse("diverged.json", &text).expect("it is a case");
    let results = again.evaluate(false, &[]).expect("it lists its steps");
    assert_eq!(results.divergence, Some(found));
}

/// A node starts upwards at 30 m/s. One bound is above its speed after a step, the other one below.
#[test]
fn a_node_that_is_too_fast_is_found_and_replayed_with_its_bound() {
    let fast = |bound| {
        let mut case = case(|scene| scene.physics.speed_bound = bound);
        case.start.v[3] = [0.0, 30.0].into();
        case
    };
    assert_eq!(guarded(&fast(Some(35.0))).divergence, None);
    // A case without the key has no bound.
    let free = fast(None).to_json();
    assert!(!free.contains("speed_bound"));
    let free = Case::parse("free.json", &free).expect("it is a case");
    assert_eq!(guarded(&free).divergence, None);
    let bounded = fast(Some(10.0));
    let found = diverges(&bounded);
    assert_eq!((found.step, found.node), (0, 3));
    let (speed, bound) = (found.velocity.norm(), 10.0);
    assert_eq!(found.term, Cause::TooFast { speed, bound });
    let text = bounded.diverged_json(&found);
    assert!(
        text.contains("`physics.speed_bound` allows 10 m/s"),
        "{text}"
    );
    let again = Case::parse("diverged.json", &text).expect("it is a case");
    let results = again.evaluate(false, &[]).expect("it lists its steps");
    assert_eq!(results.divergence, Some(found));
}

/// In lanes, where one start goes wrong, it alone does, and shows it where it is watched: the rest
/// has the bits of single rollouts.
#[test]
fn several_starts_together_are_watched_one_by_one() {
    const WRONG: usize = 3;
    for contact in [ContactLaw::infinite(), ContactLaw::coulomb()] {
        let case = case(|scene| scene.physics.contact = contact.clone());
        let (task, mixture) = (case.task(), case.own_mixture());
        let mut starts = vec![case.start.clone(); 9];
        for (k, start) in starts.iter_mut().enumerate() {
            start.x[k % 4][0] += 1e-3 * k as f64;
        }
        // Of the upper row: the ground would stop it.
        starts[WRONG].v[3] = [2e6, 0.0].into();
        let span = Span::from_start(vec![0, 7, case.physics.steps]);
        for span in [watched(&span), span] {
            let together = task.rollout_many(&[&mixture], &case.controller, &starts, &span);
            for (k, start) in starts.iter().enumerate() {
                let alone = task.rollout(&mixture, &case.controller, start, &span);
                assert_eq!(format!("{:?}", together[k]), format!("{alone:?}"), "{k}");
                let guarded = task.guarded(&mixture, &case.controller, start, &span);
                assert_eq!(guarded.divergence.is_some(), k == WRONG, "{k}");
                let shows = span.watched && k == WRONG;
                assert_eq!(together[k].states[0].x[0][0].is_nan(), shows, "{k}");
            }
        }
    }
}

/// Robots of a layout each, in lanes and in pairs: what one has no use for is left out of none that
/// has, void edges and outputs of the controller alike, and changes no bit of the others.
#[test]
fn several_layouts_together_have_the_bits_of_each_alone() {
    const WRONG: usize = 5;
    for void_edges in [VoidEdges::Keep, VoidEdges::Drop] {
        let case = case(|scene| {
            scene.physics.void_edges = void_edges;
            scene.physics.bending_radius = 0.02;
        });
        let edges = case.lattice.edges.len();
        // Void, skeleton and actuator in turns, each layout from elsewhere on.
        let layout = |k: usize| {
            let material = |edge| Material::ALL[(edge * k + edge + k) % 3];
            one_hot(&(0..edges).map(material).collect::<Vec<_>>())
        };
        let layouts: Vec<_> = (0..12).map(layout).collect();
        let mut wrong = case.start.clone();
        wrong.v[3] = [2e6, 0.0].into();
        for count in [2, 3, 9, 12] {
            let start = |k: usize| if k == WRONG { &wrong } else { &case.start };
            let starts: Vec<_> = (0..count).map(start).collect();
            let span = Span::from_start(vec![0, 7, case.physics.steps]);
            let (task, layouts) = (case.task(), &layouts[..count]);
            for span in [watched(&span), span] {
                let together = task.rollout_many(layouts, &case.controller, &starts, &span);
                for k in 0..count {
                    let alone = task.rollout(&layouts[k], &case.controller, starts[k], &span);
                    assert_eq!(format!("{:?}", together[k]), format!("{alone:?}"), "{k}");
                }
                let shows = together.iter().any(|seen| seen.states[0].x[0][0].is_nan());
                assert_eq!(shows, span.watched && count > WRONG);
                let reached = |k: usize| &together[k].states[2];
                assert_ne!(reached(0), reached(1));
            }
        }
    }
}
