//! The messages of panics, and the lines that they name.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, Location, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// The file and the line of the thread's last panic.
    static LAST: Cell<Option<(String, u32)>> = const { Cell::new(None) };
}

/// Sets a panic hook that notes the place of every panic and passes the panic on.
fn note_places() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |info| {
            LAST.set(info.location().map(|at| (at.file().to_owned(), at.line())));
            before(info);
        }));
    });
}

/// Asserts that a closure, which must be on the line of this call, panics and that the panic names this line. Returns
/// the message.
#[track_caller]
pub(crate) fn assert_named<T>(action: impl FnOnce() -> T) -> Refusal {
    note_places();
    let (here, message) = (Location::caller(), panic_message(action));
    let named = LAST.take().expect("every panic has a place");
    assert_eq!(named, (here.file().to_owned(), here.line()), "{message}");
    Refusal(message)
}

/// The message of a panic.
pub(crate) struct Refusal(pub(crate) String);

impl Refusal {
    /// Asserts that the message contains these words.
    #[track_caller]
    pub(crate) fn says(self, words: &str) -> Self {
        assert!(self.0.contains(words), "{}, not {words}", self.0);
        self
    }
}

/// Returns the message with which an action panics.
#[track_caller]
pub(crate) fn panic_message<T>(action: impl FnOnce() -> T) -> String {
    let mut action = Some(action);
    message(&mut || _ = action.take().map(|action| action()))
}

/// Behind a pointer, so that this is compiled once.
#[track_caller]
fn message(action: &mut dyn FnMut()) -> String {
    let caught = catch_unwind(AssertUnwindSafe(action));
    let panic = caught.expect_err("misuse must panic");
    match panic.downcast::<String>() {
        Ok(message) => *message,
        Err(panic) => (*panic.downcast::<&str>().expect("a panic with a sentence")).into(),
    }
}

/// Asserts that an action panics with a message that contains these words.
#[track_caller]
pub(crate) fn assert_refused<T>(words: &str, action: impl FnOnce() -> T) {
    let message = panic_message(action);
    assert!(message.contains(words), "{message}, not {words}");
}
