//! What one rollout tells about a robot: how far it gets, how its bars are loaded and the energy that it needs.

use std::f64::consts::TAU;

use super::evaluator::Evaluator;
use super::standstill::Standstill;
use crate::design::{Design, Mixture, Structure, volumes};
use crate::geometry::Vector;
use crate::policy::{Controller, frequency};
use crate::walk::{self, BarLoad, Divergence, Energy, GuardedRollout, Loads, LoadsAndEnergy};
use crate::world::{KEEP_EVERY, Trajectory, Variation, kept_steps};

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

/// A rollout from the unperturbed start.
struct Walk {
    seen: GuardedRollout,
    /// The displacement along the axes of the ground, in metres; NaN if it diverges.
    moved: Vector<f64>,
    /// `None` for an undecided design and if it diverges.
    measured: Option<LoadsAndEnergy>,
}

impl Evaluator {
    /// Simulates a robot from the unperturbed start and measures the loads of its bars. `design` is in the form that is
    /// simulated.
    pub fn observe(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
    ) -> ObservedRollout {
        let Walk {
            seen,
            moved,
            measured,
        } = self.walk(KEEP_EVERY, design, controller);
        let GuardedRollout {
            trajectory,
            divergence,
        } = seen;
        let standstill = match divergence {
            Some(_) => None,
            None => self.standstill(controller, &trajectory),
        };
        let structure = design.layout();
        let structure = structure.map(|layout| Structure::new(self.world.lattice(), layout));
        let [volume, actuator_volume] = volumes(&design.mixtures());
        ObservedRollout {
            loads: measured.as_ref().map(|measured| measured.loads.clone()),
            energy: measured.as_ref().map(|measured| measured.energy),
            bars: measured.map_or(Vec::new(), |measured| measured.bars),
            trajectory,
            divergence,
            moved,
            standstill,
            structure,
            volume,
            actuator_volume,
        }
    }

    /// Simulates a robot from the unperturbed start. Keeps the states after `every` steps.
    fn walk(
        &self,
        every: usize,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
    ) -> Walk {
        let world = &self.world;
        let span = (self.rollouts).observing(kept_steps(world.physics().steps, every));
        let robot = world.robot(world.body(design), controller.clone(), &self.start);
        let seen = walk::guarded(world, &robot, &span);
        if seen.divergence.is_some() {
            return Walk {
                seen,
                moved: Vector::NAN,
                measured: None,
            };
        }
        let kept = &seen.trajectory;
        let moved = self.between(&self.start, kept);
        let measured = LoadsAndEnergy::of(world, design, &robot, &span, kept, moved.forward());
        Walk {
            seen,
            moved,
            measured,
        }
    }

    /// The loads and the energy of a robot with half the time step, from the unperturbed start. `None` for an undecided
    /// design and for a rollout that diverges.
    pub(super) fn at_half_step(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
    ) -> Option<LoadsAndEnergy> {
        design.layout()?;
        let world = (self.world).with_physics(&self.half_step(), &self.scene.controller);
        // The states are those of the same times.
        let finer = self.in_world(world);
        finer.walk(2 * KEEP_EVERY, design, controller).measured
    }

    /// The energy that a robot with a variation needs, per distance of `displacement` (m). `None` for an undecided design.
    pub(super) fn energy_in(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variation: &Variation,
        displacement: f64,
    ) -> Option<Energy> {
        let (layout, world) = (design.layout()?, &self.world);
        let steps = world.physics().steps;
        let robot = world.robots(&[(design, variation)], controller).remove(0);
        let bars = walk::bar_loads(world, layout, &robot, &self.rollouts.observing(vec![steps]));
        Some(Energy::of(
            world,
            layout,
            &bars,
            &robot.body,
            steps,
            displacement,
        ))
    }

    /// Where and since when the robot of a full rollout stands still.
    fn standstill(
        &self,
        controller: &Controller<f64>,
        seen: &Trajectory<f64>,
    ) -> Option<Standstill> {
        let ground = self.world.ground();
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
            self.world.lattice().scale,
        )
    }
}
