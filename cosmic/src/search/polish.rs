//! Polishing: local search over the materials of single edges after the snap.
//!
//! The snap destroys gaits that need mixed materials, and the materials that it gives to some edges are decided by
//! noise. Once every edge has one material, rollouts show whether another material is better. Each edge has two other
//! materials, so there are too many possible changes to test all of them in full rollouts. So the gradient with respect
//! to the shares of the materials selects some changes, short rollouts select a quarter of these, and full rollouts
//! choose the best one. Where controllers learn in windows, this is how the body is designed.

use super::begin::CoDesign;
use super::progress::Progress;
use super::schedule::Schedule;
use super::slope::Slope;
use super::slopes::Variables;
use crate::design::{Design, Material, flipped};
use crate::judge::Reached;

/// Of the layouts that took a short rollout, the best ones take a full rollout: one in every this many.
const HEAT: usize = 4;

impl CoDesign {
    /// Polishes a layout with the current controller: tries other materials for single edges, and keeps the layout with the
    /// best full rollout. Returns the result of that rollout; `None` if no rollout was needed.
    pub(super) fn polish(&self, progress: &mut Progress, now: &Schedule) -> Option<Reached> {
        let (true, Some(layout)) = (now.polishes(), progress.design.layout()) else {
            return None;
        };
        let finalists = self.finalists(progress, now, layout);
        let (best, reached) = self.evaluator.best_layout(
            layout.to_vec(),
            finalists,
            &progress.controller,
            progress.seed,
        );
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
        &self,
        progress: &Progress,
        now: &Schedule,
        layout: &[Material],
    ) -> Vec<Vec<Material>> {
        let (evaluator, world) = (&self.evaluator, self.world());
        let schedule = &self.scene().schedule;
        let Slope { gradient, .. } = self.share_slopes(progress, now);
        if !gradient.iter().all(|slope| slope.is_finite()) {
            return Vec::new();
        }
        let (slopes, _) = gradient.as_chunks();
        let cost = |edge: usize, from: Material, to: Material| {
            let slope = |m: Material| m.of(&slopes[edge]);
            (!world.projector().is_held(edge, to)).then(|| slope(to) - slope(from))
        };
        let (bounds, trials) = (now.volume_bounds(), schedule.polish_trials);
        let tried = flipped(layout, &bounds, &self.rules, trials, cost);
        let [first, last] = schedule.horizon;
        let designs: Vec<_> = tried.iter().cloned().map(Design::Layout).collect();
        let short = evaluator.in_world(world.shortened(first.min(last)));
        let reached = short.reached(&designs, &progress.controller);
        let merits = reached.iter().map(|r| r.merit);
        let mut ranked: Vec<_> = merits.zip(tried).collect();
        // The sort is stable, so of equally good layouts the first wins. A diverged rollout (NaN) comes last.
        let merit = |m: f64| if m.is_nan() { f64::NEG_INFINITY } else { m };
        ranked.sort_by(|a, b| merit(b.0).total_cmp(&merit(a.0)));
        ranked.truncate(ranked.len().div_ceil(HEAT));
        ranked.into_iter().map(|(_, layout)| layout).collect()
    }

    /// The gradient with respect to the shares of the materials. A controller that learns in windows has a gait, and the next
    /// window shows it: changes that this gradient selects bring more than those of a horizon from rest
    /// (`studies/gaits.md`).
    fn share_slopes(&self, progress: &Progress, now: &Schedule) -> Slope {
        let at = self.point(progress, now);
        let Some(window) = &self.window else {
            let [slope] = self.evaluator.slopes([Variables::Shares], &at);
            return slope;
        };
        let (_, first, variations) = self.next_window(&progress.walkers, window, progress.seed);
        let (evaluator, inputs) = (&self.evaluator, &at.inputs);
        let (slope, _) = window.slope(evaluator, Variables::Shares, inputs, &variations, first);
        slope
    }
}
