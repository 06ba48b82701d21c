//! The items of a verdict about the walk: how fast and how straight it is, and what it needs from the ground.

use super::{HEADING, Item, Level, Measured, SURE_FOOTED, WALKS};
use crate::judge::{LOW_FRICTION, Reliability, Standstill};
use crate::numbers::brief;

impl Measured<'_> {
    /// The speed of the robot, or that it stays in place.
    pub(super) fn speed(&self) -> Option<Item> {
        let Some(displacement) = self.displacement else {
            return Some(Item::figure("its rollouts diverge", Level::Bad));
        };
        let still = self.standstill.filter(|_| self.is_far);
        // The time after a robot got stuck is not a part of its walk.
        let seconds = still.map_or(self.seconds, |still| still.since);
        let speed = format!("{} m/s", brief(displacement.abs() / seconds));
        if !self.is_far {
            // For other tasks, robots may have good reasons to stay or to go back.
            let back = if displacement < 0.0 { " backwards" } else { "" };
            return Some(Item::figure(format!("{speed}{back}"), Level::Good));
        }
        let lengths = displacement / self.length;
        if lengths.abs() < WALKS[1] {
            return Some(Item::figure("stays in place", Level::Bad));
        }
        if displacement < 0.0 {
            return Some(Item::figure(format!("{speed} backwards"), Level::Bad));
        }
        if let Some(Standstill { since, at }) = still {
            let says = format!("{speed} until it stands still at {at:.2} m after {since:.1} s");
            return Some(Item::figure(says, Level::Doubtful));
        }
        let is_unreliable = matches!(self.reliability, Reliability::Unreliable { .. });
        let level = match is_unreliable {
            true => Level::Doubtful,
            false => Level::from_on(WALKS, lengths),
        };
        let mut says = speed;
        if lengths < WALKS[0] {
            let (lengths, seconds) = (brief(lengths), brief(self.seconds));
            says += &format!(" (only {lengths} of its length in {seconds} s)");
        }
        if is_unreliable {
            says += ", unreliable";
        }
        Some(Item::figure(says, level))
    }

    /// The distance of a robot that should walk far and does, m. The other items of this page are about such robots.
    pub(super) fn walks(&self) -> Option<f64> {
        let is_walk = |displacement: &f64| self.is_far && *displacement >= WALKS[1] * self.length;
        self.displacement.filter(is_walk)
    }

    /// How far a robot in space is off its heading.
    pub(super) fn heading(&self) -> Option<Item> {
        let (displacement, (low, high)) = (self.walks()?, self.across?);
        let across = low.abs().max(high.abs());
        let angle = across.atan2(displacement).to_degrees();
        let level = match angle <= HEADING {
            true => Level::Good,
            false => Level::Doubtful,
        };
        let says = format!("it goes up to {} degrees off its heading", brief(angle));
        Some(Item::limit(says, level))
    }

    /// What remains of the distance on ground with less friction.
    pub(super) fn grip(&self) -> Option<Item> {
        let displacement = self.walks().filter(|_| self.slips && !self.is_undecided)?;
        let Some(slippery) = self.low_friction else {
            let says = format!("how far it walks with {LOW_FRICTION} of the friction is not known");
            return Some(Item::limit(says, Level::Doubtful));
        };
        let level = match slippery >= SURE_FOOTED * displacement {
            true => Level::Good,
            false => Level::Doubtful,
        };
        let says = format!(
            "with {LOW_FRICTION} of the friction it gets to {slippery:.2} m instead of {displacement:.2} m"
        );
        Some(Item::limit(says, level))
    }

    /// A remark about planar robots, which only a computer holds upright.
    pub(super) fn falls_over(&self) -> Option<Item> {
        let says = "a planar robot falls over sideways: it needs a guide or a second frame";
        self.is_planar.then(|| Item::remark(says))
    }
}
