//! What a setting can be: the kinds of value, the range allowed, and how it is written.

use super::pass::Pass;
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

/// A setting in place, with all that its declaration says of it.
pub(super) struct Field<'a> {
    pub(super) key: &'static str,
    /// What it means, in sentences.
    pub(super) doc: &'static str,
    /// The unit; empty for a pure number, a name or a truth value.
    pub(super) unit: &'static str,
    /// Where the default comes from: the paper, a decision (D1 to D11), an experiment.
    pub(super) source: &'static str,
    pub(super) limits: Limits,
    pub(super) slot: Slot<'a>,
}

impl Field<'_> {
    /// What may stand at the key, as a phrase.
    pub(super) fn allowed(&self) -> String {
        self.slot.allowed(&self.limits)
    }
}

/// A section of a scene file; [`settings`](super::settings) declares it.
pub(super) trait Settings {
    /// What the section is about, in a sentence.
    fn about(&self) -> &'static str;
    /// Its settings, in the order in which they are written.
    fn fields(&mut self) -> Vec<Field<'_>>;
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

/// Numbers of an iteration; 0 is before the first one.
pub(super) const ITERATIONS: Limits = within(0.0, 1e5);
/// Lengths of rollouts and of parts of them.
pub(super) const STEPS: Limits = within(1.0, 1e6);
/// Factors and costs that have no natural bound.
pub(super) const POSITIVE: Limits = above(0.0, 1e6);
/// Shares of a whole.
pub(super) const SHARE: Limits = within(0.0, 1.0);
/// Shares by which a positive number is off and stays positive.
pub(super) const DEVIATION: Limits = within(0.0, 0.99);

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

/// The value of a setting in place. Reading and writing a scene both go through it.
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

/// A type that a setting can have.
pub(super) trait SettingType {
    fn slot(&mut self) -> Slot<'_>;
}

impl SettingType for f64 {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Number(self)
    }
}

impl SettingType for Option<f64> {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Bound(self)
    }
}

impl<const N: usize> SettingType for [f64; N] {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Numbers(self)
    }
}

impl SettingType for usize {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Count(self)
    }
}

impl<const N: usize> SettingType for [usize; N] {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Counts(self)
    }
}

impl SettingType for bool {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Flag(self)
    }
}

impl<T: Named> SettingType for T {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Choice(self)
    }
}

impl SettingType for Vec<Pass> {
    fn slot(&mut self) -> Slot<'_> {
        Slot::Cycle(self)
    }
}
