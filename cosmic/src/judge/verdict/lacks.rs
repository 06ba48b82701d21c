//! What a robot lacks: muscles, bars that hold its shape, the volumes that its scene asks for, and measurements.

use super::{Item, Level, Measured};
use crate::geometry::Range;
use crate::numbers::percent;

impl Measured<'_> {
    /// The items about what the robot lacks.
    pub(super) fn lacks(&self) -> Vec<Item> {
        let [solid, actuator] = self.in_bounds();
        let items = [
            self.muscles(),
            self.floppy_modes(),
            solid,
            actuator,
            self.is_known(self.structure.is_some(), "how its bars are connected"),
            self.is_known(self.loads.is_some(), "the load of its bars"),
            self.is_known(self.energy.is_some(), "the energy that it needs"),
        ];
        items.into_iter().flatten().collect()
    }

    /// How many of the steps ahead of the robot its payload passes.
    pub(super) fn passes(&self) -> Option<Item> {
        let displacement = self.displacement.filter(|_| self.is_far)?;
        let all = self.risers.len();
        let risers = self.risers.iter();
        let passed = risers.filter(|riser| riser.along <= displacement).count();
        let steps = if all == 1 { "step" } else { "steps" };
        (all > 0).then(|| Item::figure(format!("passes {passed} of {all} {steps}"), Level::Good))
    }

    fn muscles(&self) -> Option<Item> {
        let [_, actuator] = self.volumes;
        let has_none = actuator == 0.0 && !self.is_undecided;
        has_none.then(|| Item::limit("it has no muscles", Level::Bad))
    }

    fn floppy_modes(&self) -> Option<Item> {
        let modes = self.structure?.floppy_modes?;
        Some(match modes {
            0 => Item::limit("no floppy modes", Level::Good),
            1 => Item::limit("1 floppy mode, which no bar resists", Level::Doubtful),
            _ => Item::limit(
                format!("{modes} floppy modes, which no bar resists"),
                Level::Doubtful,
            ),
        })
    }

    /// The shares of solid edges and of actuators that miss their bounds.
    fn in_bounds(&self) -> [Option<Item>; 2] {
        let judged = |share: f64, Range { low, high }: Range, what: &str| {
            // A share is a quotient of whole numbers, so it is inside by rounding if it equals a bound.
            let is_inside = share >= low - 1e-9 && share <= high + 1e-9;
            let says = || {
                let [share, low, high] = [share, low.max(0.0), high.min(1.0)].map(percent);
                let says = format!("{share} of its edges are {what} (bounds: {low} to {high})");
                Item::limit(says, Level::Doubtful)
            };
            (!is_inside && !self.is_undecided).then(says)
        };
        let of = |k: usize, bounds: Range, what: &str| judged(self.volumes[k], bounds, what);
        [
            of(0, self.bounds.solid, "solid"),
            of(1, self.bounds.actuator, "muscles"),
        ]
    }

    /// A doubt about something that was not measured. An undecided design has nothing to measure yet.
    fn is_known(&self, is_known: bool, what: &str) -> Option<Item> {
        let doubt = || Item::limit(format!("{what} is not known"), Level::Doubtful);
        (!is_known && !self.is_undecided).then(doubt)
    }
}
