//! What a setting can be.

/// An enumeration whose members have names in scene files.
pub trait Named: Copy + PartialEq + 'static {
    /// Every member with its name.
    const ALL: &'static [(&'static str, Self)];
}
