//! The library `cosmic` for JavaScript, which calls these functions. Requests and answers are JSON.
//!
//! 1. `input(bytes)` returns the address at which the caller writes the request in UTF-8.
//! 2. `ask()` carries out the request and returns the length of the answer: `{"ok": …}`, or `{"error": "…"}`.
//! 3. `answer()` returns the address of the answer.
//!
//! A panic ends in a trap. After a trap, the caller may only call `answer()` and `length()`, which return the message
//! of the panic. Every function may move the memory, so the caller must create its views of the memory again after each
//! call.

mod view;
mod packed;
mod gains;
mod work;
mod evolve;
mod session;
mod request;

use std::cell::RefCell;

thread_local! {
    static INPUT: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<String> = const { RefCell::new(String::new()) };
    static SESSION: RefCell<session::Session> = RefCell::default();
}

/// Makes room for a request of `bytes` bytes and returns its address.
#[unsafe(no_mangle)]
pub extern "C" fn input(bytes: usize) -> *mut u8 {
    INPUT.with_borrow_mut(|input| {
        input.clear();
        input.resize(bytes, 0);
        input.as_mut_ptr()
    })
}

/// Carries out the request. Returns the length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> usize {
    std::panic::set_hook(Box::new(|panic| ANSWER.set(panic.to_string())));
    let request = INPUT.take();
    // Clear the last answer, because after a trap without a panic there must be no message.
    ANSWER.take();
    ANSWER.set(SESSION.with_borrow_mut(|session| request::answer(session, &request)));
    length()
}

/// Returns the address of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// Returns the length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn length() -> usize {
    ANSWER.with_borrow(String::len)
}
