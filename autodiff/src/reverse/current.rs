//! Which recordings are current on this thread.
//!
//! A variable is `Copy + 'static` and so cannot hold its tape. It finds it through a stack of
//! frames, one per running [`enter`], innermost first. Rust has no generic thread-local, so the
//! frames are type-erased; a generation says both which recording it is and of which type.
//!
//! `cargo bench -p benches --bench tapes` is what pays for the unsafe code: a RefCell around a
//! `Box<dyn Any>` would cost each operation its push again.
#![allow(unsafe_code)]

use std::any::TypeId;
use std::cell::Cell;
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use super::tape::Arena;
use crate::real::Real;

/// The generation of constants; no recording has it.
pub(super) const CONSTANT: u32 = 0;

/// Bits of a generation that count the recordings of its number type; the others name the type.
const COUNT_BITS: u32 = 24;
const TYPES: usize = 1 << (u32::BITS - COUNT_BITS);

/// The name of a number type within generations, from 1 on: the same for all tapes of the type.
pub(super) fn name_of<R: Real>() -> u32 {
    static NAMED: Mutex<Vec<TypeId>> = Mutex::new(Vec::new());
    let number = TypeId::of::<R>();
    let mut named = NAMED
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    let place = named.iter().position(|&n| n == number);
    let place = place.unwrap_or_else(|| {
        assert!(
            named.len() < TYPES - 1,
            "tapes of more than {} number types",
            TYPES - 1
        );
        named.push(number);
        named.len() - 1
    });
    place as u32 + 1
}

/// A generation that no other recording of this number type has had in its last 16 million.
pub(super) fn next_generation(name: u32) -> u32 {
    static COUNTS: [AtomicU32; TYPES] = [const { AtomicU32::new(0) }; TYPES];
    let count = COUNTS[name as usize].fetch_add(1, Ordering::Relaxed);
    name << COUNT_BITS | count & ((1 << COUNT_BITS) - 1)
}

#[derive(Clone, Copy)]
struct Frame {
    /// `CONSTANT` where nothing is recorded.
    generation: u32,
    /// An `Arena<R>`, where `R` is the type that the generation names.
    arena: *mut (),
    outer: *const Frame,
}

thread_local! {
    /// The innermost frame itself, not its address: one load less in every operation.
    static INNERMOST: Cell<Frame> = const {
        Cell::new(Frame { generation: CONSTANT, arena: ptr::null_mut(), outer: ptr::null() })
    };
}

/// Takes a frame off the stack, also when the closure panics.
struct Leave<'a>(&'a Frame);

impl Drop for Leave<'_> {
    fn drop(&mut self) {
        INNERMOST.set(*self.0);
    }
}

/// Runs `function` while the variables of `generation` are recorded in `arena`.
pub(super) fn enter<R: Real, T>(
    arena: &mut Arena<R>,
    generation: u32,
    function: impl FnOnce() -> T,
) -> T {
    let outer = INNERMOST.get();
    let _leave = Leave(&outer);
    INNERMOST.set(Frame {
        generation,
        arena: ptr::from_mut(arena).cast(),
        outer: &raw const outer,
    });
    function()
}

/// Calls `action` with the arena of `generation`, which is a variable's and not `CONSTANT`.
///
/// # Safety
/// `action` runs no code from outside `reverse`, so that no second `with` starts inside it, and
/// `generation` was drawn for a recording of `R`.
///
/// # Panics
/// If that recording is not current on this thread.
#[inline(always)]
pub(super) unsafe fn with<R: Real, T>(
    generation: u32,
    action: impl FnOnce(&mut Arena<R>) -> T,
) -> T {
    let arena = INNERMOST.with(|innermost| {
        let Frame {
            generation: current,
            arena,
            ..
        } = innermost.get();
        if current == generation {
            arena
        } else {
            further_out(generation)
        }
    });
    // SAFETY: the generation names `R`, so this is an `Arena<R>`; `enter` holds the exclusive
    // borrow it came from and does not touch it; by the contract above no other reference to it
    // is alive.
    action(unsafe { &mut *arena.cast::<Arena<R>>() })
}

/// The arena of a recording around the innermost.
#[cold]
#[inline(never)]
fn further_out(generation: u32) -> *mut () {
    let mut place = INNERMOST.get().outer;
    // SAFETY: a pointer in the list is null or the frame that an `enter` further up this thread's
    // stack keeps: `Leave` takes the one that points to it out before it dies, whichever way
    // `enter` ends.
    while let Some(frame) = unsafe { place.as_ref() } {
        if frame.generation == generation {
            return frame.arena;
        }
        place = frame.outer;
    }
    panic!(
        "a variable was used where its tape is not recording: on another thread, outside the \
         closure of `Tape::record`, or after its tape recorded again"
    )
}

#[cfg(test)]
mod tests {
    use super::{CONSTANT, COUNT_BITS, name_of, next_generation};
    use crate::forward::Dual;

    #[test]
    fn a_generation_names_its_number_type() {
        let (f64_name, f32_name) = (name_of::<f64>(), name_of::<f32>());
        assert_ne!(f64_name, f32_name);
        assert_ne!(f64_name, name_of::<Dual<f64, 1>>());
        assert_eq!(f64_name, name_of::<f64>());
        let generations = [f64_name, f64_name, f32_name].map(next_generation);
        assert_ne!(generations[0], generations[1]);
        assert!(generations.iter().all(|&g| g != CONSTANT));
        assert_eq!(
            generations.map(|g| g >> COUNT_BITS),
            [f64_name, f64_name, f32_name]
        );
    }
}
