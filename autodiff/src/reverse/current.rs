//! The recordings that are running on this thread.
//!
//! A variable is `Copy + 'static`, so it cannot hold a reference to its tape. It finds the tape through a stack of
//! frames, innermost first: one frame for each running [`enter`]. Rust has no generic thread-locals, so the frames are
//! type-erased. A generation number identifies both the recording and its number type.
//!
//! The unsafe code is worth it: with a `RefCell` around a `Box<dyn Any>`, every push took twice as long.
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

/// The generation of constants. No recording has it.
pub(super) const CONSTANT: u32 = 0;

/// The number of low bits of a generation that count the recordings of a number type. The other bits identify the type.
const COUNT_BITS: u32 = 24;
const TYPES: usize = 1 << (u32::BITS - COUNT_BITS);

/// Returns the number that identifies the number type `R` in generations. Types are counted from 1, and all tapes of a
/// type share its number.
///
/// # Panics
/// If there is no number left.
#[track_caller]
pub(super) fn name_of<R: Real>() -> u32 {
    static NAMED: Mutex<Vec<TypeId>> = Mutex::new(Vec::new());
    let number = TypeId::of::<R>();
    let mut named = NAMED
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner());
    if let Some(place) = named.iter().position(|&n| n == number) {
        return place as u32 + 1;
    }
    assert!(
        named.len() < TYPES - 1,
        "this process has recorded on tapes of {} number types, which is the maximum; \
         use fewer number types, for example fewer widths of `Dual` and fewer nestings",
        TYPES - 1
    );
    named.push(number);
    named.len() as u32
}

/// Returns a generation that none of the last 16 million recordings of this number type had.
pub(super) fn next_generation(name: u32) -> u32 {
    static COUNTS: [AtomicU32; TYPES] = [const { AtomicU32::new(0) }; TYPES];
    let count = COUNTS[name as usize].fetch_add(1, Ordering::Relaxed);
    name << COUNT_BITS | count & ((1 << COUNT_BITS) - 1)
}

/// The recording to which a frame of the stack refers.
#[derive(Clone, Copy)]
struct CurrentRecording {
    /// The generation of the running recording; `CONSTANT` if nothing is being recorded.
    generation: u32,
    /// How many entries still fit before the arena must grow.
    room: u32,
    /// The entries of the arena, of type `Entry<R>`. The generation identifies `R`.
    entries: *mut (),
    /// The arena, of type `Arena<R>`.
    arena: *mut (),
    /// The frame of the enclosing recording; null for the outermost recording.
    outer: *const Frame,
}

/// A running recording. The frame counts the entries itself, so that an operation can append an entry without accessing
/// the arena. The length of the arena's vector is only updated by [`Frame::arena`].
#[derive(Clone)]
struct Frame {
    recording: Cell<CurrentRecording>,
    len: Cell<u32>,
}

thread_local! {
    /// The innermost frame. It is stored here by value, because reaching it through a pointer would cost every
    /// operation another load. The outer frames are on the stack, each in the [`enter`] that replaced it here.
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
    /// Copies the fields of another frame into this one.
    fn set(&self, other: &Frame) {
        self.recording.set(other.recording.get());
        self.len.set(other.len.get());
    }

    /// Appends an entry and returns its index.
    ///
    /// # Safety
    /// The frame must belong to a recording of `R`, and no reference to its arena may be alive.
    #[inline(always)]
    unsafe fn push<R: Real>(&self, entry: Entry<R>) -> u32 {
        if self.len.get() == self.recording.get().room {
            // SAFETY: guaranteed by the caller.
            unsafe { self.grow::<R>() };
        }
        let len = self.len.get();
        let entries = self.recording.get().entries.cast::<Entry<R>>();
        // SAFETY: `len < room`. Both `room` and `entries` are up to date, because entries only move through `Open`,
        // which updates both when it is dropped.
        unsafe { entries.add(len as usize).write(entry) };
        self.len.set(len + 1);
        len
    }

    /// Makes room for at least one more entry.
    ///
    /// # Safety
    /// The frame must belong to a recording of `R`, and no reference to its arena may be alive.
    #[cold]
    #[inline(never)]
    unsafe fn grow<R: Real>(&self) {
        // SAFETY: guaranteed by the caller.
        unsafe { self.arena::<R>() }.arena.make_room();
    }

    /// Returns the arena, after setting the length of its vector to the number of entries pushed.
    ///
    /// # Safety
    /// The frame must belong to a recording of `R`. While the result lives, there must be no other reference to the
    /// arena, and no code from outside `reverse` may run.
    unsafe fn arena<R: Real>(&self) -> Open<'_, R> {
        // SAFETY: the generation identifies `R`, so this is an `Arena<R>`. `enter` holds the exclusive borrow of it and
        // does not touch it. The caller guarantees that no other reference to it is alive.
        let arena = unsafe { &mut *self.recording.get().arena.cast::<Arena<R>>() };
        // SAFETY: `push` has written all entries up to `len`, which is within the capacity.
        unsafe { arena.entries.set_len(self.len.get() as usize) };
        Open { frame: self, arena }
    }
}

/// A borrow of a frame's arena. When it is dropped (even if a full tape panics), it updates the frame's pointer to the
/// entries, their number, and the room.
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

/// When dropped, removes the innermost frame from the stack. This also happens if the closure panics.
struct Leave<'a, R: Real>(&'a Frame, PhantomData<R>);

impl<R: Real> Drop for Leave<'_, R> {
    fn drop(&mut self) {
        INNERMOST.with(|innermost| {
            // SAFETY: `enter` created this frame for a recording of `R`.
            drop(unsafe { innermost.arena::<R>() });
            innermost.set(self.0);
        });
    }
}

/// Runs `function`. Meanwhile, operations on variables of `generation` are recorded in `arena`.
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
        // SAFETY: the frame belongs to a recording of `R`. Dropping the result sets `entries` and `room`.
        drop(unsafe { innermost.arena::<R>() });
    });
    let _leave = Leave::<R>(&outer, PhantomData);
    function()
}

/// Appends an entry to the recording of `generation`, which must not be `CONSTANT`.
///
/// # Safety
/// `generation` must belong to a recording of `R`.
///
/// # Panics
/// If that recording is not running on this thread.
#[inline(always)]
#[track_caller]
pub(super) unsafe fn push<R: Real>(generation: u32, entry: Entry<R>) -> u32 {
    // There are two calls of `Frame::push` because one call on a reference to either frame would make recording take two
    // thirds longer.
    let pushed = INNERMOST.with(|innermost| {
        if innermost.recording.get().generation == generation {
            // SAFETY: the generation identifies `R`, and references to arenas live only in `with`.
            Some(unsafe { innermost.push(entry) })
        } else {
            None
        }
    });
    match pushed {
        Some(index) => index,
        // SAFETY: the same holds for the frame of an outer `enter`, which is still running.
        None => unsafe { (*further_out(generation)).push(entry) },
    }
}

/// Calls `action` with the arena of `generation`, which must not be `CONSTANT`.
///
/// # Safety
/// `generation` must belong to a recording of `R`. `action` must not run code from outside `reverse`, so that no second
/// `with` starts inside it.
///
/// # Panics
/// If that recording is not running on this thread.
#[track_caller]
pub(super) unsafe fn with<R: Real, T>(
    generation: u32,
    action: impl FnOnce(&mut Arena<R>) -> T,
) -> T {
    let innermost = INNERMOST.with(|innermost| {
        let is_innermost = innermost.recording.get().generation == generation;
        is_innermost.then_some(ptr::from_ref(innermost))
    });
    let frame = match innermost {
        Some(frame) => frame,
        None => further_out(generation),
    };
    // SAFETY: the frame is this thread's innermost one, or belongs to an outer `enter` that is still running. The
    // generation identifies `R`. The caller guarantees the rest.
    action(unsafe { (*frame).arena() }.arena)
}

/// Returns the frame of the recording with this generation, which must enclose the innermost recording.
///
/// # Panics
/// If there is no such frame.
#[cold]
#[inline(never)]
#[track_caller]
fn further_out(generation: u32) -> *const Frame {
    let mut place = INNERMOST.with(|innermost| innermost.recording.get().outer);
    // SAFETY: each pointer is null or points to a frame in an `enter` further up this thread's stack. However that
    // `enter` ends, `Leave` first removes the frame that points to it.
    while let Some(frame) = unsafe { place.as_ref() } {
        if frame.recording.get().generation == generation {
            return place;
        }
        place = frame.recording.get().outer;
    }
    panic!(
        "a variable was used where its tape is not recording; use it only on its own thread, inside the \
         closure of the `Tape::record` call that created it"
    )
}
