//! The energy that a robot needs to walk.

use serde::{Deserialize, Serialize};

use super::World;
use super::loads::BarLoad;
use crate::design::{Material, is_in_use};
use crate::lattice::Body;

crate::keys! {
    /// The mass of a robot, and the energy that its actuators give while it walks, without their losses.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Energy {
        /// Mass of all nodes with a bar or a payload. Half of each bar belongs to either of its nodes.
        mass: f64, "number", unit "kg", columns ["mass"];
        /// Mean power that all actuators give to the robot. An actuator that takes power counts as 0.
        power: f64, "number", unit "W", columns ["power"];
        /// Like `power`, less the power that actuators take from the robot.
        net_power: f64, "number", unit "W";
        /// Air that the cylinders take from the supply, as a volume at 1 bar: a chamber at every movement. `null`
        /// unless `[parts]` has a bore.
        air: Option<f64>, "number or `null`", unit "m3/s";
        /// Least power that presses this air from 1 bar to the pressure of the cylinders, without losses:
        /// p0 air ln((p0 + p) / p0), where p0 is 1 bar and p is `parts.pressure`. Compressors need about twice as much.
        air_power: Option<f64>, "number or `null`", unit "W";
        /// Energy per distance: `power` divided by the speed; `null` if the robot stays in place.
        per_metre: Option<f64>, "number or `null`", unit "J/m", columns ["per_metre"] decimals 2;
        /// Cost of transport: the energy per distance and weight; `null` also without gravity.
        cost_of_transport: Option<f64>, "number or `null`", columns ["cost_of_transport"] decimals 2;
    }
}

impl Energy {
    /// The power that the robot needs at least, W: the mechanical power, or the power that presses its air if that is more.
    pub fn needed(&self) -> f64 {
        self.air_power.map_or(self.power, |air| air.max(self.power))
    }

    /// This energy with the larger powers and the larger volume of air of two walks.
    pub fn worse(&self, other: &Self) -> Self {
        let larger = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::max);
        Self {
            power: self.power.max(other.power),
            air: larger(self.air, other.air),
            air_power: larger(self.air_power, other.air_power),
            ..*self
        }
    }
}

impl World {
    /// The energy of a robot from the loads of its bars in a walk of `steps` steps that moves it by `displacement`, m.
    pub fn energy_of(
        &self,
        layout: &[Material],
        bars: &[Option<BarLoad>],
        body: &Body<f64>,
        steps: usize,
        displacement: f64,
    ) -> Energy {
        let of_actuators = |of: fn(&BarLoad) -> f64| -> f64 {
            let bars = bars.iter().zip(layout);
            let actuators = bars.filter(|(_, m)| **m == Material::Actuator);
            (actuators.map(|(bar, _)| bar.as_ref().map_or(0.0, of))).sum()
        };
        let power = of_actuators(|bar| bar.given);
        let nodes = body.mass.iter().zip(is_in_use(&self.lattice, layout));
        let in_use = nodes.filter(|(_, is_in_use)| *is_in_use);
        let mass: f64 = in_use.map(|(mass, _)| mass).sum();
        let moves = displacement.abs() >= self.lattice.least_walk();
        let per_metre = moves.then(|| power * steps as f64 * self.physics.dt / displacement.abs());
        let weight = mass * self.step.mechanics.gravity.abs();
        let air = self.materials.parts.air(of_actuators(|bar| bar.travel));
        Energy {
            mass,
            power,
            net_power: of_actuators(|bar| bar.net),
            air,
            air_power: air.map(|air| self.materials.parts.air_power(air)),
            per_metre,
            cost_of_transport: per_metre
                .filter(|_| weight > 0.0)
                .map(|energy| energy / weight),
        }
    }
}
