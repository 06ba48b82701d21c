use crate::small::{Up, records, tiny};
use cosmic::Registry;
use cosmic::codesign::Record;
use cosmic::record::files::read_json;
use cosmic::record::multistart::{FORMAT, Halving, Rung, SEARCH, Standing, folder_of, median};
use cosmic::record::{RunPlan, Search, history, optimise};
use cosmic::scene::{GoalKind, Scene};
use std::num::NonZeroUsize;

/// A rung for starts with these merits and the seeds 3, 4, and so on.
fn rung(merits: &[Option<f64>], keep: f64) -> Rung {
    let standing = |(seed, &merit)| Standing {
        seed,
        displacement: None,
        merit,
    };
    Rung::new(40, (3..).zip(merits).map(standing).collect(), keep)
}

#[test]
fn the_best_share_continues_and_the_rest_is_dropped() {
    let rungs = vec![rung(&[Some(0.5), None, Some(2.0), Some(0.5)], 0.5)];
    let order: Vec<u64> = rungs[0].standings.iter().map(|s| s.seed).collect();
    assert_eq!((order, rungs[0].kept), (vec![5, 3, 6, 4], 2));
    let search = Halving { rungs };
    let dropped = [5, 3, 6, 4].map(|seed| search.dropped_at(seed));
    assert_eq!(dropped, [None, None, Some(40), Some(40)]);
    // At least one start continues.
    for (starts, keep, kept) in [(2, 0.0, 1), (2, 1.0, 2), (10, 0.7, 7)] {
        assert_eq!(rung(&vec![None; starts], keep).kept, kept);
    }
}

#[test]
fn the_snap_does_not_count_in_the_median() {
    let mut scene = tiny();
    scene.schedule.iterations = 4;
    (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 4);
    let rows = records(&scene);
    let reached = |row: &Record| row.displacement_horizon;
    assert_eq!(rows[3].displacement_horizon, None);
    assert_eq!(median(&rows, 1, reached), rows[2].displacement_horizon);
    assert_eq!(median(&rows, 8, reached), median(&rows[..3], 8, reached));
    assert_eq!(median(&rows[3..], 8, reached), None);
}

/// Starts are ranked by their merit. Their displacements would give another order.
#[test]
fn starts_are_ranked_by_a_user_s_loss_and_by_the_worse_of_two_goals() {
    let mut scene = tiny();
    scene.search.rungs = [4, 20, 20];
    (scene.search.keep, scene.search.window) = ([0.5; 3], 3);
    let check = |scene: &Scene| {
        let folder = tempfile::tempdir().unwrap();
        let plan = RunPlan {
            starts: NonZeroUsize::new(6).unwrap(),
            search: Search::Halving,
            ..RunPlan::new("tiny", scene.clone(), 0)
        };
        optimise(folder.path(), &plan, &mut ()).unwrap();
        let search: Halving = read_json(&folder.path().join(SEARCH), FORMAT).unwrap();
        let standings = &search.rungs[0].standings;
        let merit = |s: &Standing| s.merit.unwrap();
        assert!(standings.is_sorted_by(|a, b| merit(a) >= merit(b)));
        for s in standings {
            let rows = history::read(&folder_of(folder.path(), s.seed), 4).unwrap();
            assert_eq!(s.merit, median(&rows, 3, |row| row.merit_horizon));
        }
        let far = |s: &Standing| s.displacement.unwrap();
        assert!(
            !standings.is_sorted_by(|a, b| far(a) >= far(b)),
            "{standings:?}"
        );
    };
    let mut two = scene.clone();
    (two.controller.goals, two.controller.goal_scale) = (GoalKind::Two, 3.0);
    check(&two);
    let own = scene.knowing(&Registry::default().with_loss("up", Up));
    check(&own.set(&["objective.own_loss=up"]).unwrap());
}
