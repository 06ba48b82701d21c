//! Converts positions in an arena to 32-bit indices, and defines marks: special values above all indices.

/// A value in `Entry::parents` that means: there is no parent.
pub(super) const NONE: u32 = u32::MAX;
/// A value in `Entry::parents[0]` that marks a linear entry with many parents. `parents[1]` is its index in
/// `LongEntries::linear`.
pub(super) const LINEAR: u32 = u32::MAX - 1;
/// A value in `Entry::parents[0]` that marks a select, lane by lane. `parents[1]` is its index in
/// `LongEntries::selects`.
pub(super) const SELECT: u32 = u32::MAX - 2;
/// A value in `Entry::parents[0]` that marks a number which depends on `parents[1]` but passes no derivative to it,
/// because of a choice.
pub(super) const STOPPED: u32 = u32::MAX - 3;
/// A value in `Entry::parents[0]` that marks the first output of the fused function `LongEntries::fused[parents[1]]`.
/// It is the smallest of these values; every index of a parent is smaller.
pub(super) const FUSED: u32 = u32::MAX - 4;

/// The kinds of entries, by the values of `Entry::parents`.
pub(super) enum Kind {
    /// An operation on the two parents. The second may be [`NONE`].
    Short([u32; 2]),
    /// See [`LINEAR`].
    Linear(u32),
    /// See [`SELECT`].
    Select(u32),
    /// See [`STOPPED`].
    Stopped(u32),
    /// See [`FUSED`].
    FirstOutput(u32),
    /// Another output of the fused function before this entry.
    LaterOutput,
}

impl Kind {
    #[inline(always)]
    pub(super) fn of(parents: [u32; 2]) -> Self {
        match parents {
            [NONE, _] => Self::LaterOutput,
            [LINEAR, place] => Self::Linear(place),
            [SELECT, place] => Self::Select(place),
            [STOPPED, parent] => Self::Stopped(parent),
            [FUSED, place] => Self::FirstOutput(place),
            _ => Self::Short(parents),
        }
    }
}

/// Converts a position in an arena to the index of a variable. Panics if the tape is full.
#[track_caller]
pub(super) fn index(place: usize) -> u32 {
    if place >= FUSED as usize {
        full();
    }
    place as u32
}

#[cold]
#[track_caller]
fn full() -> ! {
    panic!(
        "the tape is full: a recording holds at most {FUSED} entries; \
         record shorter pieces and join them, as a rollout does"
    )
}

#[cfg(test)]
mod tests {
    use super::{FUSED, index};

    #[test]
    #[should_panic(expected = "the tape is full")]
    fn a_full_arena_panics() {
        index(FUSED as usize);
    }
}
