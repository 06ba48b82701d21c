//! Places in an arena, in the 32 bits that a variable has for one, and the marks beyond the last place.

/// In `Entry::parents`: no parent.
pub(super) const NONE: u32 = u32::MAX;
/// In `Entry::parents[0]`: an entry of many parents; `parents[1]` is an index into `LongEntries::linear`.
pub(super) const LINEAR: u32 = u32::MAX - 1;
/// In `Entry::parents[0]`: a choice by lanes; `parents[1]` is an index into `LongEntries::selects`.
pub(super) const SELECT: u32 = u32::MAX - 2;
/// In `Entry::parents[0]`: a number that depends on `parents[1]` but, because of a choice, passes it no
/// derivative.
pub(super) const STOPPED: u32 = u32::MAX - 3;
/// In `Entry::parents[0]`: the first output of `LongEntries::fused[parents[1]]`. The least of these marks:
/// every index of a parent is below it.
pub(super) const FUSED: u32 = u32::MAX - 4;

/// A place in an arena, in the 32 bits that a variable has for it.
pub(super) fn index(place: usize) -> u32 {
    if place >= FUSED as usize {
        full();
    }
    place as u32
}

#[cold]
fn full() -> ! {
    panic!(
        "the tape is full: one recording holds at most {FUSED} entries; \
         record shorter pieces and join them, as a rollout does"
    )
}

#[cfg(test)]
mod tests {
    use super::{FUSED, index};

    #[test]
    #[should_panic(expected = "the tape is full")]
    fn a_full_arena_says_so() {
        index(FUSED as usize);
    }
}
