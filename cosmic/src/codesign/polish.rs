//! Polishing: local search over the materials of single edges after the snap.
//!
//! The snap destroys gaits that need mixed materials, and the materials that it gives to some edges are decided by
//! noise. Once every edge has one material, rollouts show whether another material is better. Each edge has two other
//! materials, so there are too many possible changes to test all of them in full rollouts. So the gradient with respect
//! to the shares of the materials selects some changes, short rollouts select a quarter of these, and full rollouts
//! choose the best one.

use super::evaluator::Evaluator;
use super::progress::Progress;
use super::reach::Reached;
use super::schedule::Schedule;
use super::slope::Slope;
use super::slopes::Sought;
use crate::design::{Design, LayoutRules, Material, flipped};
use crate::projection::Holds;

/// Of the layouts that took a short rollout, the best ones take a full rollout: one in every this many.
const HEAT: usize = 4;

/// Polishes a layout with the current controller: tries other materials for single edges, and keeps the layout with the
/// best full rollout. Returns the result of that rollout; `None` if no rollout was needed.
pub(super) fn polish(
    evaluator: &Evaluator,
    rules: &LayoutRules,
    progress: &mut Progress,
    now: &Schedule,
) -> Option<Reached> {
    let (true, Some(layout)) = (now.polishes(), progress.design.layout()) else {
        return None;
    };
    let finalists = finalists(evaluator, rules, progress, now, layout);
    let (best, reached) = evaluator.farthest(layout.to_vec(), finalists, &progress.controller);
    if best != layout {
        progress.design = Design::Layout(best);
        // The candidates are controllers that were measured with the robot before the change.
        progress.candidates.clear();
    }
    reached
}

/// Selects layouts for full rollouts in two steps. The gradient selects the changes with the largest predicted gain;
/// short rollouts then select the best quarter of these.
fn finalists(
    evaluator: &Evaluator,
    rules: &LayoutRules,
    progress: &Progress,
    now: &Schedule,
    layout: &[Material],
) -> Vec<Vec<Material>> {
    let Evaluator { scene, task, .. } = evaluator;
    let schedule = &scene.schedule;
    let [Slope { gradient, .. }] =
        evaluator.slopes([Sought::Shares], &evaluator.point(progress, now));
    if !gradient.iter().all(|slope| slope.is_finite()) {
        return Vec::new();
    }
    let (slopes, _) = gradient.as_chunks();
    let holds = Holds::new(&scene.projection, &task.lattice);
    let cost = |edge: usize, from: Material, to: Material| {
        let slope = |m: Material| m.of(&slopes[edge]);
        (!holds.is_held(edge, to)).then(|| slope(to) - slope(from))
    };
    let (bounds, trials) = (now.volume_bounds(), schedule.polish_trials);
    let tried = flipped(layout, &bounds, rules, trials, cost);
    let mut short = task.clone();
    short.physics.steps = schedule.horizon[0].min(schedule.horizon[1]);
    let reached = evaluator.reached(&tried, &progress.controller, &short);
    let merits = reached.iter().map(|r| r.merit);
    let mut ranked: Vec<_> = merits.zip(tried).collect();
    // The sort is stable, so of equally good layouts the first wins. A diverged rollout (NaN) comes last.
    let merit = |m: f64| if m.is_nan() { f64::NEG_INFINITY } else { m };
    ranked.sort_by(|a, b| merit(b.0).total_cmp(&merit(a.0)));
    ranked.truncate(ranked.len().div_ceil(HEAT));
    ranked.into_iter().map(|(_, layout)| layout).collect()
}

#[cfg(test)]
mod tests {
    use super::polish;
    use crate::codesign::Progress;
    use crate::codesign::schedule::Schedule;
    use crate::codesign::tests::{LIVELY, after};
    use crate::design::{Material, VolumeBounds, filled, volumes};
    use crate::scene::Scene;

    fn scene(more: &str) -> Scene {
        let polished = "
            iterations = 16
            snap_trials = 0
            settle = 0.25
            polish_every = 2
        ";
        let mut scene = Scene::parse("polished", &[LIVELY, polished, more].concat()).unwrap();
        // The controller does not change.
        scene.adam.fine_rate = 0.0;
        scene
    }

    /// The number of edges in which two layouts differ.
    fn changes(a: &Progress, b: &Progress) -> usize {
        let [a, b] = [a, b].map(|p| p.design.layout().unwrap());
        a.iter().zip(b).filter(|(a, b)| a != b).count()
    }

    #[test]
    fn a_polish_changes_one_edge_if_that_gives_a_better_robot() {
        let scene = scene("");
        let mut found = 0;
        for seed in 0..4 {
            let (codesign, mut progress) = after(&scene, 9, seed);
            assert!(!progress.candidates.is_empty());
            let (before, merit) = (
                progress.clone(),
                codesign.evaluator.evaluate(&progress).merit,
            );
            let now = Schedule::at(&scene, 10);
            polish(&codesign.evaluator, &codesign.rules, &mut progress, &now);
            let reached = codesign.evaluator.evaluate(&progress).merit;
            if progress == before {
                continue;
            }
            found += 1;
            assert!(reached > merit, "{reached} <= {merit}");
            assert_eq!(changes(&before, &progress), 1);
            assert_eq!(progress.controller, before.controller);
            assert!(progress.candidates.is_empty());
            let [solid, actuators] = volumes(&codesign.evaluator.design(&progress).mixtures());
            let bounds = VolumeBounds::widened(&scene.volume, scene.volume.widening);
            assert!(bounds.solid.contains(solid) && bounds.actuator.contains(actuators));
        }
        assert!(found > 0, "no robot became better");
    }

    /// A polished robot never walks less far than the same robot without polish. The controller does not change, so the
    /// robots differ only by the polish.
    #[test]
    fn polished_robots_get_farther_and_without_trials_nothing_is_polished() {
        let far = |trials: &str, seed| {
            let scene = scene(trials);
            let (codesign, at_snap) = after(&scene, 7, seed);
            let (_, progress) = after(&scene, scene.schedule.iterations, seed);
            let flips = changes(&at_snap, &progress);
            (flips, codesign.evaluator.deliver(&progress).along)
        };
        let mut better = 0;
        for seed in 0..4 {
            let (none, plain) = far("polish_trials = 0", seed);
            let (flips, polished) = far("polish_trials = 8", seed);
            assert_eq!(none, 0);
            // One edge may change before each of the updates 8, 10, 12 and 14. There is no polish in the last two
            // updates, because the controller settles.
            assert!(flips <= 4, "{flips} edges");
            assert!(polished >= plain, "{polished} < {plain}");
            better += usize::from(polished > plain);
        }
        assert!(better > 0, "nothing was polished");
    }

    #[test]
    fn a_held_material_is_not_tried() {
        let mut scene = scene("polish_trials = 100");
        let wrong = |scene: &Scene| {
            let (codesign, progress) = after(scene, scene.schedule.iterations, 1);
            let held = filled(&codesign.task().lattice);
            let materials = progress.design.layout().unwrap();
            let differs = |(&m, own): (&Material, Material)| m.is_solid() && m != own;
            materials.iter().zip(held).filter(|&p| differs(p)).count()
        };
        assert!(wrong(&scene) > 0);
        scene.projection.hold_materials = 1.0;
        assert_eq!(wrong(&scene), 0);
    }
}
