//! Fits the phases of a schedule into another number of iterations.

use super::Scene;
use super::keys::allowed_instead;
use crate::error::{Error, Result};
use std::num::NonZeroUsize;
use std::slice::from_mut;

/// The iterations in the value of a key.
type Iterations = fn(&mut Scene) -> &mut [usize];

/// Every key with iterations except `schedule.iterations`.
const PHASES: [(&str, Iterations); 4] = [
    ("schedule.snap_at", |scene| {
        from_mut(&mut scene.schedule.snap_at)
    }),
    ("schedule.attraction_from", |scene| {
        from_mut(&mut scene.schedule.attraction_from)
    }),
    ("schedule.horizon_over", |scene| {
        &mut scene.schedule.horizon_over
    }),
    ("binarisation.threshold_over", |scene| {
        &mut scene.binarisation.threshold_over
    }),
];

impl Scene {
    /// This scene with the phases of its schedule fitted into this number of iterations. Every iteration in its settings
    /// keeps its share of the run, rounded down, but at least 1 if it was above 0. Values that follow from others ("auto")
    /// follow the new number. With the scene's own number of iterations, nothing changes.
    ///
    /// # Errors
    /// [`Error::Usage`] for more iterations than `schedule.iterations` allows.
    pub fn fitted(&self, iterations: NonZeroUsize) -> Result<Self> {
        self.stretched(0, iterations)
    }

    /// Like [`fitted`](Self::fitted), for a run that begins after the snap: its fine-tuning gets this number of iterations.
    /// The phases before it keep their iterations, so those that follow from others become numbers.
    ///
    /// # Errors
    /// Like [`fitted`](Self::fitted).
    pub fn fitted_after_snap(&self, iterations: NonZeroUsize) -> Result<Self> {
        self.stretched(self.schedule.snap_at, iterations)
    }

    /// This scene with this number of iterations after the iteration `fixed`. Earlier iterations stay where they are.
    fn stretched(&self, fixed: usize, iterations: NonZeroUsize) -> Result<Self> {
        let last = fixed.saturating_add(iterations.get());
        if last == self.schedule.iterations {
            return Ok(self.clone());
        }
        if let Some(allowed) = allowed_instead("schedule.iterations", last as f64) {
            return Err(Error::Usage(format!(
                "the schedule cannot have {last} iterations; `schedule.iterations` allows {allowed}; ask for fewer iterations"
            )));
        }
        let old = self.schedule.iterations.saturating_sub(fixed);
        let mut scene = self.clone();
        scene.auto.remove("schedule.iterations");
        for (key, of) in PHASES {
            if fixed > 0 {
                scene.auto.remove(key);
            }
            // A number that nothing reads stays as it is. Otherwise the user is warned about a change without effect.
            if scene.when_read(key, self).is_none() {
                for at in of(&mut scene) {
                    *at = moved(*at, fixed, [old, iterations.get()]);
                }
            }
        }
        scene.schedule.iterations = last;
        scene.follow();
        scene.check().map(|()| scene)
    }
}

/// The new number of the iteration `at` if the part of a run after the iteration `fixed` gets a new length.
fn moved(at: usize, fixed: usize, [old, new]: [usize; 2]) -> usize {
    if at <= fixed || old == 0 {
        return at;
    }
    // The product of two allowed numbers does not fit into 32 bits.
    let behind = (at - fixed) as u64 * new as u64 / old as u64;
    fixed + (behind as usize).max(1)
}
