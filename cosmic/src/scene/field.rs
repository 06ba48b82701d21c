//! What a setting can be: the kinds of value, the range allowed, and how it is written.

use super::Scene;
use super::optimisation::Pass;
use std::fmt;

/// An enumeration whose members have names in scene files.
pub trait Named: Copy + PartialEq + 'static {
    /// Every member with its name.
    const ALL: &'static [(&'static str, Self)];

    /// The member's name.
    fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(_, member)| *member == self);
        entry.map_or("", |(name, _)| name)
    }
}

/// A [`Named`] value in place, whatever its type.
pub(super) trait Choice {
    fn names(&self) -> Vec<&'static str>;
    fn name(&self) -> &'static str;
    /// Takes the member of that name; false where there is none.
    fn choose(&mut self, name: &str) -> bool;
}

impl<T: Named> Choice for T {
    fn names(&self) -> Vec<&'static str> {
        T::ALL.iter().map(|(name, _)| *name).collect()
    }

    fn name(&self) -> &'static str {
        Named::name(*self)
    }

    fn choose(&mut self, name: &str) -> bool {
        let entry = T::ALL.iter().find(|(known, _)| *known == name);
        entry.inspect(|(_, member)| *self = *member).is_some()
    }
}

/// One setting: its key, the range of its number or numbers, and where it lives in the scene.
pub(super) struct Field {
    pub(super) key: &'static str,
    pub(super) limits: Limits,
    pub(super) slot: fn(&mut Scene) -> Slot<'_>,
}

/// A section of a scene file.
pub(super) struct Section {
    pub(super) name: &'static str,
    /// The struct whose documentation the section is described by.
    pub(super) settings: &'static str,
    pub(super) fields: &'static [Field],
}

/// The finite numbers allowed: for arrays each entry, for a cycle its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    low: f64,
    high: f64,
    low_included: bool,
}

impl Limits {
    /// For values that are no numbers.
    pub(super) const NONE: Limits = within(f64::MIN, f64::MAX);

    /// False for NaN and infinities too.
    pub(super) fn contain(&self, x: f64) -> bool {
        x <= self.high && (x > self.low || self.low_included && x == self.low)
    }
}

/// From `low` to `high`, both allowed.
pub(super) const fn within(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: true,
    }
}

/// Above `low`, up to `high`.
pub(super) const fn above(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: false,
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if self.low_included {
            write!(f, "from {} to {}", Plain(self.low), Plain(self.high))
        } else {
            write!(
                f,
                "above {} and at most {}",
                Plain(self.low),
                Plain(self.high)
            )
        }
    }
}

/// A bound as people write it: `64`, not `64.0`; `1e9`, not `1000000000`.
struct Plain(f64);

impl fmt::Display for Plain {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let large = self.0.abs() >= 1e5;
        let text = if large {
            format!("{:e}", self.0)
        } else {
            format!("{:?}", self.0)
        };
        f.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

/// A setting in place. Reading, writing and describing a scene all go through it.
pub(super) enum Slot<'a> {
    Number(&'a mut f64),
    /// A number, or `"off"`.
    Bound(&'a mut Option<f64>),
    Numbers(&'a mut [f64]),
    Count(&'a mut usize),
    Counts(&'a mut [usize]),
    Flag(&'a mut bool),
    Choice(&'a mut dyn Choice),
    Cycle(&'a mut Vec<Pass>),
}

impl Slot<'_> {
    /// What may stand here, as a phrase.
    pub(super) fn allowed(&self, limits: &Limits) -> String {
        match self {
            Slot::Number(_) => format!("a number {limits}"),
            Slot::Bound(_) => format!("a number {limits}, or \"off\""),
            Slot::Numbers(values) => format!("{} numbers, each {limits}", values.len()),
            Slot::Count(_) => format!("a whole number {limits}"),
            Slot::Counts(values) => format!("{} whole numbers, each {limits}", values.len()),
            Slot::Flag(_) => "true or false".to_string(),
            Slot::Choice(choice) => {
                let names: Vec<_> = choice
                    .names()
                    .iter()
                    .map(|name| format!("{name:?}"))
                    .collect();
                names.join(" or ")
            }
            Slot::Cycle(_) => format!("letters d and c in quotes, their number {limits}"),
        }
    }
}

/// The TOML value. Numbers read back to the same bits: `{:?}` writes the shortest digits that do.
impl fmt::Display for Slot<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Slot::Number(value) => write!(f, "{value:?}"),
            Slot::Bound(Some(value)) => write!(f, "{value:?}"),
            Slot::Bound(None) => write!(f, "\"off\""),
            Slot::Numbers(values) => write!(f, "{values:?}"),
            Slot::Count(value) => write!(f, "{value}"),
            Slot::Counts(values) => write!(f, "{values:?}"),
            Slot::Flag(value) => write!(f, "{value}"),
            Slot::Choice(choice) => write!(f, "{:?}", choice.name()),
            Slot::Cycle(passes) => {
                let letters: String = passes.iter().map(|pass| pass.letter()).collect();
                write!(f, "{letters:?}")
            }
        }
    }
}

impl Pass {
    /// The letter that stands for the pass in `schedule.cycle`.
    pub fn letter(self) -> char {
        match self {
            Pass::Design => 'd',
            Pass::Controller => 'c',
        }
    }
}

/// The passes named by letters, or `None` where a letter names none.
pub(super) fn cycle(letters: &str) -> Option<Vec<Pass>> {
    let pass = |letter| {
        [Pass::Design, Pass::Controller]
            .into_iter()
            .find(|pass| pass.letter() == letter)
    };
    letters.chars().map(pass).collect()
}
