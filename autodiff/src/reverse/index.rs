//! Places in an arena as 32-bit indices of variables, and the marks beyond the last place.

/// In `Entry::parents`: no parent.
pub(super) const NONE: u32 = u32::MAX;
/// In `Entry::parents[0]`: an entry with many parents. `parents[1]` is an index into `LongEntries::linear`.
pub(super) const LINEAR: u32 = u32::MAX - 1;
/// In `Entry::parents[0]`: a choice in each lane. `parents[1]` is an index into `LongEntries::selects`.
pub(super) const SELECT: u32 = u32::MAX - 2;
/// In `Entry::parents[0]`: a number that depends on `parents[1]` but passes no derivative because of a choice.
pub(super) const STOPPED: u32 = u32::MAX - 3;
/// In `Entry::parents[0]`: the first output of `LongEntries::fused[parents[1]]`. This is the smallest mark, and
/// every index of a parent is smaller.
pub(super) const FUSED: u32 = u32::MAX - 4;

/// A place in an arena as the index of a variable.
pub(super) fn index(place: usize) -> u32 {
    if place >= FUSED as usize {
        full();
    }
    place as u32
}

#[cold]
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
