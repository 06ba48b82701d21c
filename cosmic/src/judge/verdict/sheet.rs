//! The items of a verdict that compare a robot with the data sheets of its parts.

use super::{Item, Level, MUSCLE_POWERS, Measured};
use crate::numbers::brief;
use crate::scene::{DataSheet, SLENDERNESS};
use crate::walk::Magnitude;

/// The factor by which a number may exceed that of a data sheet, whose numbers are rounded.
const ROUNDED: f64 = 1.01;

impl Measured<'_> {
    /// The items about the parts.
    pub(super) fn parts(&self) -> [Option<Item>; 5] {
        [
            self.muscle_power(),
            self.muscle_force(),
            self.muscle_speed(),
            self.muscle_length(),
            self.thickness(),
        ]
    }

    /// The mass by which the power of a muscle is judged: its own, or the mean mass of a bar with its share of the nodes.
    fn muscle_mass(&self) -> Option<f64> {
        let mean = || Some((self.energy?.mass - self.payload) / self.bars.max(1) as f64);
        self.sheet.mass.or_else(mean)
    }

    fn muscle_power(&self) -> Option<Item> {
        let (power, mass) = (self.loads?.power.p99, self.muscle_mass()?);
        let level = Level::up_to(MUSCLE_POWERS, power / mass);
        let limit = match level {
            Level::Bad => MUSCLE_POWERS[1],
            _ => MUSCLE_POWERS[0],
        };
        let says = format!(
            "one muscle gives {} W of {} W ({} of {} W/kg)",
            brief(power),
            brief(limit * mass),
            brief(power / mass),
            brief(limit)
        );
        (power > 0.0).then(|| Item::limit(says, level))
    }

    fn muscle_force(&self) -> Option<Item> {
        let DataSheet {
            force, is_cylinder, ..
        } = self.sheet;
        let of = if is_cylinder { "of about" } else { "of" };
        let says = ["muscles pull or push with", of];
        against(says, "N", self.loads?.force, force?)
    }

    fn muscle_speed(&self) -> Option<Item> {
        let DataSheet { speed, .. } = self.sheet;
        let says = ["muscles move at", "of"];
        against(says, "m/s", self.loads?.speed, speed?)
    }

    fn muscle_length(&self) -> Option<Item> {
        let device = self.sheet.length?;
        let bar = self.structure?.shortest_actuator?;
        let (least, room) = (device.least, device.room(bar));
        let says = format!("a bar of {} m leaves {} m", brief(bar), brief(room));
        Some(if room < least {
            let muscle = match device.is_stated {
                true => format!("that is {} m long", brief(least)),
                false => format!("with a stroke of {} m", brief(least)),
            };
            let says = format!("{says} for a muscle {muscle}");
            Item::limit(says, Level::Bad)
        } else if device.is_stated {
            Item::limit(
                format!("{says} for a muscle of {} m", brief(least)),
                Level::Good,
            )
        } else {
            // Most devices are longer than twice their stroke.
            let level = Level::from_on([2.0 * least, least], room);
            let says = format!("{says} for a muscle with a stroke of {} m", brief(least));
            Item::limit(says, level)
        })
    }

    fn thickness(&self) -> Option<Item> {
        let thickness = self.sheet.thickness?;
        let bar = self.structure?.shortest_skeleton?;
        let says = format!("a bar of {} m is {} m thick", brief(bar), brief(thickness));
        Some(Item::limit(
            says,
            Level::from_on(SLENDERNESS, bar / thickness),
        ))
    }
}

/// Judges a number of a walk by the limit of a data sheet: it is good if it never exceeds the limit, and doubtful if it
/// exceeds it in at most 1 % of the time. `says` has the words before either number.
fn against([says, of]: [&str; 2], unit: &str, found: Magnitude, limit: f64) -> Option<Item> {
    let Magnitude { peak, p99 } = found;
    let most = ROUNDED * limit;
    let level = if peak <= most {
        Level::Good
    } else if p99 <= most {
        Level::Doubtful
    } else {
        // NaN is bad too.
        Level::Bad
    };
    let mut text = format!("{says} {} {unit} {of} {} {unit}", brief(peak), brief(limit));
    if level != Level::Good {
        text += &format!(" (99 %: {} {unit})", brief(p99));
    }
    (peak > 0.0).then(|| Item::limit(text, level))
}
