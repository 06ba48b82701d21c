//! The constraints of a design update.

use autodiff::Real;

use super::begin::CoDesign;
use super::progress::Progress;
use super::schedule::Schedule;
use crate::inputs::{DESIGN, Inputs};
use crate::objective::{Measures, measures};
use crate::projection::Projection;
use crate::scene::BinarisationMethod;

/// Factor on the inequalities in MMA (found by experiment).
const ROW_SCALE: f64 = 10.0;

/// The constraints `f <= 0` with their values `f` and the gradients of `f`: the four volume bounds, then the
/// binarisation measures if the scene treats them as constraints.
#[derive(Default)]
pub(super) struct Constraints {
    pub(super) values: Vec<f64>,
    pub(super) jacobian: Vec<Vec<f64>>,
}

impl CoDesign {
    /// The binarisation measures of the mixtures that the performance projection makes of the design vectors `z` (D10).
    fn measured<R: Real>(&self, z: &[[R; 3]]) -> Measures<R> {
        let mixtures = self
            .world()
            .projector()
            .mixtures(Projection::Performance, z);
        measures(&mixtures, self.scene().projection.delta)
    }

    /// True if terms of the augmented Lagrangian bound the binarisation measures, false if constraints bound them.
    pub(super) fn is_augmented(&self) -> bool {
        self.scene().binarisation.method == BinarisationMethod::Augmented
    }

    /// Returns the constraints of a design update, and the gradient of the terms of the augmented Lagrangian. This
    /// gradient is empty if the binarisation measures are constraints. The volumes and the measures are computed from
    /// the mixtures after the performance projection (D10). All constraints are multiplied by [`ROW_SCALE`].
    pub(super) fn rows_and_terms(
        &self,
        inputs: &Inputs<f64>,
        progress: &Progress,
        now: &Schedule,
    ) -> (Constraints, Vec<f64>) {
        let thresholds = now.thresholds(&progress.first_measures);
        if self.is_augmented() {
            let [solid, actuator, (_, terms)] = inputs.differentiate_each(DESIGN, |inputs| {
                let measures = self.measured(&inputs.z);
                let terms = progress.lagrangian.terms(&measures, &thresholds);
                [measures.volume, measures.actuator_volume, terms]
            });
            return (self.volume_rows(&[solid, actuator], now), terms);
        }
        let [solid, actuator, measures @ ..] = inputs.differentiate_each(DESIGN, |inputs| {
            let measures = self.measured(&inputs.z);
            let [a, b, c, d] = measures.constrained();
            [measures.volume, measures.actuator_volume, a, b, c, d]
        });
        let mut rows = self.volume_rows(&[solid, actuator], now);
        for ((value, mut gradient), threshold) in measures.into_iter().zip(thresholds) {
            gradient.iter_mut().for_each(|g| *g *= ROW_SCALE);
            rows.values.push(ROW_SCALE * (value - threshold));
            rows.jacobian.push(gradient);
        }
        (rows, Vec::new())
    }

    /// The constraints for the volume bounds. `volumes` has the volume of solid material and the volume of actuators,
    /// each with its gradient.
    fn volume_rows(&self, volumes: &[(f64, Vec<f64>); 2], now: &Schedule) -> Constraints {
        let bounds = now.volume_bounds();
        let row =
            |gradient: &[f64], sign: f64| gradient.iter().map(|g| sign * ROW_SCALE * g).collect();
        let mut rows = Constraints::default();
        for ((value, gradient), bound) in volumes.iter().zip([bounds.solid, bounds.actuator]) {
            rows.values.extend([
                ROW_SCALE * (value - bound.high),
                ROW_SCALE * (bound.low - value),
            ]);
            rows.jacobian
                .extend([row(gradient, 1.0), row(gradient, -1.0)]);
        }
        rows
    }
}
