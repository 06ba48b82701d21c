//! The loads and the energy at half the time step: a verdict judges the worse, and doubts a robot whose loads change.

use super::{Item, Level, Measured};
use crate::judge::STEADY;
use crate::numbers::{brief, percent};
use crate::walk::{Energy, Loads};

/// The loads and the energy of the unperturbed walk at half the time step, to compare with those at the scene's time step.
#[derive(Clone, Copy, Debug)]
pub struct HalfStep<'m> {
    /// The loads at half the time step.
    pub loads: &'m Loads,
    /// The energy at half the time step.
    pub energy: Energy,
    /// The energy of the same walk at the scene's time step.
    pub own_energy: Energy,
}

/// A quantity at the scene's time step and at half of it.
struct Compared {
    name: &'static str,
    unit: &'static str,
    own: f64,
    half: f64,
}

impl Compared {
    /// The difference as a share of the number at the scene's time step.
    fn change(&self) -> f64 {
        match self.own == self.half {
            true => 0.0,
            false => (self.half - self.own).abs() / self.own.abs(),
        }
    }
}

impl Measured<'_> {
    /// The loads, each at the time step at which it is worse.
    pub(super) fn worse_loads(&self) -> Option<Loads> {
        let own = self.loads?;
        Some(match &self.half_step {
            Some(half) => own.worse(half.loads),
            None => own.clone(),
        })
    }

    /// The energy, with the powers and the air at the time step at which the robot needs more.
    pub(super) fn worse_energy(&self) -> Option<Energy> {
        let own = self.energy?;
        Some(match &self.half_step {
            Some(half) => own.worse(&half.energy),
            None => own,
        })
    }

    /// Whether the loads and the energy depend on the time step.
    pub(super) fn at_half_step(&self) -> Option<Item> {
        let own = self.loads?;
        let Some(half) = &self.half_step else {
            let says = "how its loads depend on the time step is not known";
            return Some(Item::limit(says, Level::Doubtful));
        };
        let all = compared(own, half);
        let most = all
            .iter()
            .max_by(|a, b| a.change().total_cmp(&b.change()))?;
        let level = Level::up_to([STEADY, f64::INFINITY], most.change());
        let says = match level {
            Level::Good => format!(
                "loads and power change by up to {} at half the time step",
                percent(most.change())
            ),
            _ => format!(
                "{} is {}{unit} at half the time step and {}{unit} at the scene's",
                most.name,
                brief(most.half),
                brief(most.own),
                unit = most.unit
            ),
        };
        Some(Item::limit(says, level))
    }
}

/// What a verdict judges by its size: muscles, the pushes on bars, and the power.
fn compared(
    own: &Loads,
    HalfStep {
        loads,
        energy,
        own_energy,
    }: &HalfStep,
) -> Vec<Compared> {
    let compared = |name, unit, own, half| Compared {
        name,
        unit,
        own,
        half,
    };
    let safeties = own.euler_safety.zip(loads.euler_safety);
    let safety = safeties.map(|(own, half)| compared("the Euler safety", "", own, half));
    let always = [
        compared(
            "the force of a muscle",
            " N",
            own.force.peak,
            loads.force.peak,
        ),
        compared(
            "the speed of a muscle",
            " m/s",
            own.speed.peak,
            loads.speed.peak,
        ),
        // The peak of the power depends on the time step, so the verdict judges the 99 % quantile.
        compared(
            "the power of a muscle",
            " W",
            own.power.p99,
            loads.power.p99,
        ),
        compared(
            "the push on a bar",
            " N",
            own.compression,
            loads.compression,
        ),
        compared(
            "the power that it needs",
            " W",
            own_energy.needed(),
            energy.needed(),
        ),
    ];
    always.into_iter().chain(safety).collect()
}
