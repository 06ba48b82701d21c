//! The library `cosmic` behind functions that JavaScript calls: a request goes in as JSON, an answer
//! comes out as JSON, with an array of numbers beside it.
//!
//! 1. `input(bytes)` is the address at which the caller writes the request, UTF-8.
//! 2. `ask()` carries it out and returns the length of the answer: `{"ok": …}`, or `{"error": "…"}` with a
//!    sentence.
//! 3. `answer()` is the address of the answer, `numbers()` that of the array of `f32`, `count()` its length.
//!
//! A panic ends in a trap; `answer()` and `length()` then have its message, and nothing else may be called.
//! Every one of them may move memory: the caller takes its views anew after each.

mod view;
mod session;
mod request;

use std::cell::RefCell;

thread_local! {
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<String> = const { RefCell::new(String::new()) };
    static SESSION: RefCell<session::Session> = RefCell::default();
}

/// Where a request of so many bytes is to be written.
#[unsafe(no_mangle)]
pub extern "C" fn input(bytes: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        input.resize(bytes, 0);
        input.as_mut_ptr()
    })
}

/// Carries out the request that was written. Returns the length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> usize {
    std::panic::set_hook(Box::new(|panic| ANSWER.set(panic.to_string())));
    let request = INPUT.take();
    // A trap without a panic leaves no message.
    ANSWER.take();
    ANSWER.set(SESSION.with_borrow_mut(|session| request::answer(session, &request)));
    length()
}

/// Where the answer is.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// The length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn length() -> usize {
    ANSWER.with_borrow(String::len)
}

/// Where the numbers of the answer are.
#[unsafe(no_mangle)]
pub extern "C" fn numbers() -> *const f32 {
    SESSION.with_borrow(|session| session.numbers.as_ptr())
}

/// How many numbers there are.
#[unsafe(no_mangle)]
pub extern "C" fn count() -> usize {
    SESSION.with_borrow(|session| session.numbers.len())
}
