//! What one rollout tells about a robot: how far it gets, how its bars are loaded and the energy that it needs.

use std::f64::consts::TAU;

use super::evaluator::Evaluator;
use super::standstill::Standstill;
use crate::design::{Design, Mixture, Structure, volumes};
use crate::domain::Domain;
use crate::geometry::Vector;
use crate::policy::{Controller, frequency};
use crate::simulator::{BarLoad, Divergence, Energy, GuardedRollout, Loads, Span, Trajectory};

/// The states in [`ObservedRollout::trajectory`] are this number of steps apart.
const KEEP_EVERY: usize = 16;

/// A robot in one rollout from the unperturbed start.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedRollout {
    /// The states after every 16 steps, and the last state.
    pub trajectory: Trajectory<f64>,
    /// Where the rollout diverged, if it did.
    pub divergence: Option<Divergence>,
    /// The displacement of the payload along the axes of the ground, in metres; NaN for a diverged rollout.
    pub moved: Vector<f64>,
    /// Where and since when the robot stands still; `None` if it walks on to the end, or diverges.
    pub standstill: Option<Standstill>,
    /// How the bars are connected; `None` for an undecided design, which has no bars.
    pub structure: Option<Structure>,
    /// The loads of each edge over all steps, `None` for a void edge. Empty if `loads` is `None`.
    pub bars: Vec<Option<BarLoad>>,
    /// The loads of the robot; `None` for an undecided design and for a diverged rollout.
    pub loads: Option<Loads>,
    /// The energy that the robot needs; `None` if `loads` is `None`.
    pub energy: Option<Energy>,
    /// Mean share of solid material (skeleton and actuator) over the edges.
    pub volume: f64,
    /// Mean share of actuators over the edges.
    pub actuator_volume: f64,
}

impl Evaluator {
    /// Simulates a robot from the unperturbed start and measures the loads of its bars. `design` is in the form that is
    /// simulated.
    pub fn observe(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
    ) -> ObservedRollout {
        let (task, steps) = (&self.task, self.scene.physics.steps);
        let (simulator, body) = (&task.simulator, task.body(design));
        let kept = (0..steps).step_by(KEEP_EVERY).chain([steps]).collect();
        let span = Span::from_start(kept);
        let GuardedRollout {
            trajectory,
            divergence,
        } = simulator.guarded(&body, controller, &self.start, &span);
        let moved = match divergence {
            Some(_) => Vector::NAN,
            None => self.between(&self.start, &trajectory),
        };
        let standstill = match divergence {
            Some(_) => None,
            None => self.standstill(controller, &trajectory),
        };
        let structure = design.layout();
        let structure = structure.map(|layout| Structure::new(&task.lattice, layout));
        let layout = design.layout().filter(|_| divergence.is_none());
        let bars =
            layout.map(|layout| simulator.loads(layout, &body, controller, &self.start, steps));
        let bars = bars.unwrap_or_default();
        let [volume, actuator_volume] = volumes(&design.mixtures());
        ObservedRollout {
            loads: layout
                .map(|layout| simulator.loads_of(layout, &bars, &trajectory, &task.materials)),
            energy: layout.map(|layout| {
                simulator.energy_of(
                    layout,
                    &bars,
                    &body,
                    &task.materials,
                    steps,
                    moved.forward(),
                )
            }),
            trajectory,
            divergence,
            moved,
            standstill,
            structure,
            bars,
            volume,
            actuator_volume,
        }
    }

    /// The energy that a robot needs in another domain, per distance of `displacement` (m). `None` for an undecided design.
    pub(super) fn energy_in(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        Domain { task, start }: &Domain,
        displacement: f64,
    ) -> Option<Energy> {
        let (layout, steps) = (design.layout()?, task.physics.steps);
        let (simulator, body) = (&task.simulator, task.body(design));
        let bars = simulator.loads(layout, &body, controller, start, steps);
        Some(simulator.energy_of(layout, &bars, &body, &task.materials, steps, displacement))
    }

    /// Where and since when the robot of a full rollout stands still.
    fn standstill(
        &self,
        controller: &Controller<f64>,
        seen: &Trajectory<f64>,
    ) -> Option<Standstill> {
        let ground = self.task.ground();
        let times = seen
            .steps
            .iter()
            .map(|&step| step as f64 * self.scene.physics.dt);
        let places = seen
            .steps
            .iter()
            .map(|&step| ground.along(seen.position(step)));
        let period = TAU / frequency(&self.scene.controller, controller);
        Standstill::of(
            &times.collect::<Vec<_>>(),
            &places.collect::<Vec<_>>(),
            period,
            self.task.lattice.scale,
        )
    }
}
