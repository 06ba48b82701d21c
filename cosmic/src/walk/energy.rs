//! The energy that a robot needs to walk, and the loads and the energy of a walk together.

use serde::{Deserialize, Serialize};

use super::loads::{BarLoad, Loads, bar_loads};
use crate::design::{Design, Material, Mixture, is_present};
use crate::lattice::Body;
use crate::world::{Robot, Span, Trajectory, World};

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
    /// The energy of a robot from the loads of its bars in a walk of `steps` steps that moves it by `displacement`, m.
    pub fn of(
        world: &World,
        layout: &[Material],
        bars: &[Option<BarLoad>],
        body: &Body<f64>,
        steps: usize,
        displacement: f64,
    ) -> Self {
        let of_actuators = |of: fn(&BarLoad) -> f64| -> f64 {
            let bars = bars.iter().zip(layout);
            let actuators = bars.filter(|(_, m)| **m == Material::Actuator);
            (actuators.map(|(bar, _)| bar.as_ref().map_or(0.0, of))).sum()
        };
        let power = of_actuators(|bar| bar.given);
        let nodes = body.mass.iter().zip(is_present(world.lattice(), layout));
        let present = nodes.filter(|(_, is_present)| *is_present);
        let mass: f64 = present.map(|(mass, _)| mass).sum();
        let moves = displacement.abs() >= world.lattice().least_walk();
        let per_metre =
            moves.then(|| power * steps as f64 * world.physics().dt / displacement.abs());
        let weight = mass * world.mechanics().gravity.abs();
        let air = world.materials().parts.air(of_actuators(|bar| bar.travel));
        Self {
            mass,
            power,
            net_power: of_actuators(|bar| bar.net),
            air,
            air_power: air.map(|air| world.materials().parts.air_power(air)),
            per_metre,
            cost_of_transport: per_metre
                .filter(|_| weight > 0.0)
                .map(|energy| energy / weight),
        }
    }

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

/// The loads of a layout and the energy that it needs in one walk.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadsAndEnergy {
    /// The loads of each edge; `None` for a void edge.
    pub bars: Vec<Option<BarLoad>>,
    /// The loads of the robot.
    pub loads: Loads,
    /// The energy that it needs.
    pub energy: Energy,
}

impl LoadsAndEnergy {
    /// The loads and the energy of a layout over all steps of a span, in a walk that does not diverge and moves the robot by
    /// `displacement` along the ground (m). Bars that pass through each other are counted in the states `seen` of this
    /// walk. `None` for an undecided design.
    pub fn of(
        world: &World,
        design: &Design<Mixture<f64>>,
        robot: &Robot<f64>,
        span: &Span,
        seen: &Trajectory<f64>,
        displacement: f64,
    ) -> Option<Self> {
        let (layout, steps) = (design.layout()?, span.steps());
        let bars = bar_loads(world, layout, robot, span);
        Some(Self {
            loads: Loads::of(world, layout, &bars, seen),
            energy: Energy::of(world, layout, &bars, &robot.body, steps, displacement),
            bars,
        })
    }
}
