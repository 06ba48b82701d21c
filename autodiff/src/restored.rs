//! Sets a thread-local variable for the duration of a scope.

use std::cell::RefCell;
use std::thread::LocalKey;

/// A guard for a thread-local variable. When it is dropped, also while a panic unwinds, it restores the variable's
/// earlier value.
pub struct Restored<T: Default + 'static> {
    key: &'static LocalKey<RefCell<T>>,
    before: T,
}

impl<T: Default> Restored<T> {
    /// Sets the thread-local variable until the returned guard is dropped.
    #[must_use]
    pub fn set(key: &'static LocalKey<RefCell<T>>, value: T) -> Self {
        let before = key.replace(value);
        Self { key, before }
    }
}

impl<T: Default> Drop for Restored<T> {
    fn drop(&mut self) {
        self.key.set(std::mem::take(&mut self.before));
    }
}
