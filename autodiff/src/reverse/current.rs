//! Which recordings are current on this thread.
//!
//! A variable is `Copy + 'static` and so cannot hold its tape. It finds it through a stack of
//! frames, one per running [`enter`], innermost first. Rust has no generic thread-local, so the
//! frames are type-erased; a generation says both which recording it is and of which type.
//!
//! `cargo bench -p benches --bench tapes` justifies the unsafe code: with a `RefCell` around a
//! `Box<dyn Any>` every push would cost twice as much.
#![allow(unsafe_code)]

use std::any::TypeId;
use std::cell::Cell;
use std::marker::PhantomData;
use std::ptr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};

use super::arena::Arena;
use super::entries::Entry;
use crate::real::Real;

/// The generation of constants; no recording has it.
pub(super) const CONSTANT: u32 = 0;

/// The low bits of a generation count the recordings of its number type; the others name the type.
const COUNT_BITS: u32 = 24;
const TYPES: usize = 1 << (u32::BITS - COUNT_BITS);

/// The name of a number type within generations, from 1 on. All tapes of the type share it.
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

/// The recording that a frame refers to.
#[derive(Clone, Copy)]
struct CurrentRecording {
    /// `CONSTANT` where nothing is recorded.
    generation: u32,
    /// The capacity of `entries`.
    room: u32,
    /// The arena's entries, `Entry<R>`, where `R` is the type that the generation names.
    entries: *mut (),
    /// An `Arena<R>`.
    arena: *mut (),
    /// The frame of the recording around this one; null around the outermost.
    outer: *const Frame,
}

/// A running recording. It counts the entries itself, so that an operation writes the next one
/// without touching the arena; the length of the arena's vector is set in [`Frame::arena`].
#[derive(Clone)]
struct Frame {
    recording: Cell<CurrentRecording>,
    len: Cell<u32>,
}

thread_local! {
    /// The innermost frame itself, not its address: one load less in every operation. The outer
    /// frames lie on the stack, each in the [`enter`] that replaced it here.
    static INNERMOST: Frame = const {
        Frame {
            recording: Cell::new(CurrentRecording {
                generation: CONSTANT,
                room: 0,
                entries: ptr::null_mut(),
                arena: ptr::null_mut(),
                outer: ptr::null(),
            }),
            len: Cell::new(0),
        }
    };
}

impl Frame {
    /// Becomes a copy of another frame.
    fn set(&self, other: &Frame) {
        self.recording.set(other.recording.get());
        self.len.set(other.len.get());
    }

    /// Appends an entry and returns its index.
    ///
    /// # Safety
    /// The frame is of a recording of `R`, and no reference to its arena is alive.
    #[inline(always)]
    unsafe fn push<R: Real>(&self, entry: Entry<R>) -> u32 {
        if self.len.get() == self.recording.get().room {
            // SAFETY: the contract of this function.
            unsafe { self.grow::<R>() };
        }
        let len = self.len.get();
        let entries = self.recording.get().entries.cast::<Entry<R>>();
        // SAFETY: `len < room`, and both `room` and `entries` are up to date, because whoever moves
        // the entries does so through `Open`, which sets them when it is dropped.
        unsafe { entries.add(len as usize).write(entry) };
        self.len.set(len + 1);
        len
    }

    /// Makes room for one more entry.
    ///
    /// # Safety
    /// As for `push`.
    #[cold]
    #[inline(never)]
    unsafe fn grow<R: Real>(&self) {
        // SAFETY: the contract of this function.
        unsafe { self.arena::<R>() }.arena.make_room();
    }

    /// The arena, after setting the length of its vector to the number of entries pushed.
    ///
    /// # Safety
    /// The frame is of a recording of `R`, and while the result lives no other reference to the
    /// arena does: no code from outside `reverse` runs.
    unsafe fn arena<R: Real>(&self) -> Open<'_, R> {
        // SAFETY: the generation names `R`, so this is an `Arena<R>`; `enter` holds the exclusive
        // borrow it came from and does not touch it; by the contract above no other reference to
        // it is alive.
        let arena = unsafe { &mut *self.recording.get().arena.cast::<Arena<R>>() };
        // SAFETY: `push` has written the entries up to `len`, within the capacity.
        unsafe { arena.entries.set_len(self.len.get() as usize) };
        Open { frame: self, arena }
    }
}

/// A borrow of a frame's arena. When dropped, even by the panic of a full tape, it tells the frame
/// where the entries are now, and how many.
struct Open<'a, R: Real> {
    frame: &'a Frame,
    arena: &'a mut Arena<R>,
}

impl<R: Real> Drop for Open<'_, R> {
    fn drop(&mut self) {
        self.frame.recording.set(CurrentRecording {
            room: self.arena.room(),
            entries: self.arena.entries.as_mut_ptr().cast(),
            ..self.frame.recording.get()
        });
        self.frame.len.set(self.arena.entries.len() as u32);
    }
}

/// Takes a frame off the stack, also when the closure panics.
struct Leave<'a, R: Real>(&'a Frame, PhantomData<R>);

impl<R: Real> Drop for Leave<'_, R> {
    fn drop(&mut self) {
        INNERMOST.with(|innermost| {
            // SAFETY: `enter` made this frame, of a recording of `R`.
            drop(unsafe { innermost.arena::<R>() });
            innermost.set(self.0);
        });
    }
}

/// Runs `function` while the variables of `generation` are recorded in `arena`.
pub(super) fn enter<R: Real, T>(
    arena: &mut Arena<R>,
    generation: u32,
    function: impl FnOnce() -> T,
) -> T {
    let outer = INNERMOST.with(Frame::clone);
    let len = arena.entries.len() as u32;
    let recording = CurrentRecording {
        generation,
        room: len,
        entries: ptr::null_mut(),
        arena: ptr::from_mut(arena).cast(),
        outer: &raw const outer,
    };
    INNERMOST.with(|innermost| {
        innermost.recording.set(recording);
        innermost.len.set(len);
        // SAFETY: the frame is of a recording of `R`. Dropping this sets `entries` and `room`.
        drop(unsafe { innermost.arena::<R>() });
    });
    let _leave = Leave::<R>(&outer, PhantomData);
    function()
}

/// Appends an entry to the recording of `generation`, a variable's and not `CONSTANT`.
///
/// # Safety
/// `generation` was drawn for a recording of `R`.
///
/// # Panics
/// If that recording is not current on this thread.
#[inline(always)]
pub(super) unsafe fn push<R: Real>(generation: u32, entry: Entry<R>) -> u32 {
    // Two calls, not one with a reference to either frame: with that, recording takes two thirds
    // longer.
    INNERMOST.with(|innermost| {
        if innermost.recording.get().generation == generation {
            // SAFETY: the generation names `R`, and references to arenas live in `with` alone.
            unsafe { innermost.push(entry) }
        } else {
            // SAFETY: as above; the frame of a running `enter`.
            unsafe { (*further_out(generation)).push(entry) }
        }
    })
}

/// Calls `action` with the arena of `generation`, which is a variable's and not `CONSTANT`.
///
/// # Safety
/// `action` runs no code from outside `reverse`, so that no second `with` starts inside it, and
/// `generation` was drawn for a recording of `R`.
///
/// # Panics
/// If that recording is not current on this thread.
pub(super) unsafe fn with<R: Real, T>(
    generation: u32,
    action: impl FnOnce(&mut Arena<R>) -> T,
) -> T {
    INNERMOST.with(|innermost| {
        let frame = if innermost.recording.get().generation == generation {
            innermost
        } else {
            // SAFETY: the frame of a running `enter`.
            unsafe { &*further_out(generation) }
        };
        // SAFETY: the generation names `R`; the rest is the contract of this function.
        action(unsafe { frame.arena() }.arena)
    })
}

/// The frame of a recording that is not the innermost.
#[cold]
#[inline(never)]
fn further_out(generation: u32) -> *const Frame {
    let mut place = INNERMOST.with(|innermost| innermost.recording.get().outer);
    // SAFETY: a pointer in the list is null or the frame that an `enter` further up this thread's
    // stack keeps: `Leave` takes the one that points to it out before it dies, whichever way
    // `enter` ends.
    while let Some(frame) = unsafe { place.as_ref() } {
        if frame.recording.get().generation == generation {
            return place;
        }
        place = frame.recording.get().outer;
    }
    panic!(
        "a variable was used where its tape is not recording: on another thread, outside the \
         closure of `Tape::record`, or after its tape recorded again"
    )
}

#[cfg(test)]
mod tests {
    use super::{CONSTANT, COUNT_BITS, name_of, next_generation};
    use crate::dual::Dual;

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
