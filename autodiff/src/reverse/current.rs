//! Which recordings are current on this thread.
//!
//! A variable is `Copy + 'static` and so cannot hold its tape. It finds it through a stack of
//! frames, one per running [`enter`], innermost first. Rust has no generic thread-local, so the
//! frames are type-erased and keyed by type and generation.
#![allow(unsafe_code)] // A RefCell around a Box<dyn Any> would cost each operation its push again.

use std::any::TypeId;
use std::cell::Cell;
use std::ptr;

use super::tape::Arena;
use crate::real::Real;

struct Frame {
    generation: u32,
    number: TypeId,
    /// An `Arena<R>`, where `number` is the type id of `R`.
    arena: *mut (),
    outer: *const Frame,
}

thread_local! {
    static INNERMOST: Cell<*const Frame> = const { Cell::new(ptr::null()) };
}

/// Takes a frame off the stack, also when the closure panics.
struct Leave(*const Frame);

impl Drop for Leave {
    fn drop(&mut self) {
        INNERMOST.set(self.0);
    }
}

/// Runs `function` while the variables of `generation` are recorded in `arena`.
pub(super) fn enter<R: Real, T>(
    arena: &mut Arena<R>,
    generation: u32,
    function: impl FnOnce() -> T,
) -> T {
    let frame = Frame {
        generation,
        number: TypeId::of::<R>(),
        arena: ptr::from_mut(arena).cast(),
        outer: INNERMOST.get(),
    };
    let _leave = Leave(frame.outer);
    INNERMOST.set(&raw const frame);
    function()
}

/// Calls `action` with the arena of `generation`.
///
/// # Safety
/// `action` runs no code from outside `reverse`, so that no second `with` starts inside it.
///
/// # Panics
/// If that recording is not current on this thread.
#[inline(always)]
pub(super) unsafe fn with<R: Real, T>(
    generation: u32,
    action: impl FnOnce(&mut Arena<R>) -> T,
) -> T {
    let mut place = INNERMOST.get();
    // SAFETY: a pointer in the list is null or a frame of an `enter` that runs further up this
    // thread's stack: `Leave` takes it out before the frame dies, whichever way `enter` ends.
    while let Some(frame) = unsafe { place.as_ref() } {
        if frame.generation == generation && frame.number == TypeId::of::<R>() {
            // SAFETY: the type id says that this is an `Arena<R>`; `enter` holds the exclusive
            // borrow it came from and does not touch it; by the contract above no other
            // reference to it is alive.
            return action(unsafe { &mut *frame.arena.cast::<Arena<R>>() });
        }
        place = frame.outer;
    }
    stale()
}

#[cold]
fn stale() -> ! {
    panic!(
        "a variable was used where its tape is not recording: on another thread, outside the \
         closure of `Tape::record`, or after its tape recorded again"
    )
}
