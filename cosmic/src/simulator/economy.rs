//! The energy that a robot needs to walk.

use serde::{Deserialize, Serialize};

use super::Simulator;
use super::loads::BarLoad;
use crate::design::{Material, is_in_use};
use crate::keys::keys;
use crate::lattice::Body;

keys! {
    /// The mass of a robot, and the energy that its actuators give while it walks, without their losses.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Energy {
        /// Mass of all nodes with a bar or a payload. Half of each bar belongs to either of its nodes.
        mass: f64, "number", unit "kg";
        /// Mean power of all actuators together, where they give power to the robot.
        power: f64, "number", unit "W";
        /// Energy per distance, `null` if the robot stays in place.
        per_metre: Option<f64>, "number or `null`", unit "J/m";
        /// Cost of transport: the energy per distance and weight; `null` also without gravity.
        cost_of_transport: Option<f64>, "number or `null`";
    }
}

/// A robot that moves by less than this stays in place, m.
const LEAST: f64 = 0.01;

impl Simulator {
    /// The energy of a robot from the loads of its bars in a rollout of `steps` steps that moves it by `displacement`, m.
    pub fn energy_of(
        &self,
        layout: &[Material],
        bars: &[Option<BarLoad>],
        body: &Body<f64>,
        steps: usize,
        displacement: f64,
    ) -> Energy {
        let of_actuators = bars
            .iter()
            .zip(layout)
            .filter(|(_, m)| **m == Material::Actuator);
        let power: f64 = of_actuators
            .map(|(bar, _)| bar.map_or(0.0, |bar| bar.given))
            .sum();
        let nodes = body.mass.iter().zip(is_in_use(&self.lattice, layout));
        let in_use = nodes.filter(|(_, is_in_use)| *is_in_use);
        let mass: f64 = in_use.map(|(mass, _)| mass).sum();
        let moves = displacement.abs() >= LEAST;
        let per_metre = moves.then(|| power * steps as f64 * self.dt / displacement.abs());
        let weight = mass * self.robot.mechanics.inputs[0].value.abs();
        Energy {
            mass,
            power,
            per_metre,
            cost_of_transport: per_metre
                .filter(|_| weight > 0.0)
                .map(|energy| energy / weight),
        }
    }
}
