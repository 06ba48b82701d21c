//! Thread-locals that are set for one scope.

use std::cell::RefCell;
use std::thread::LocalKey;

/// Restores the earlier value of a thread-local when it is dropped, also while a panic unwinds.
pub(crate) struct Restored<T: Default + 'static> {
    key: &'static LocalKey<RefCell<T>>,
    before: T,
}

impl<T: Default> Restored<T> {
    /// Sets the value until the result is dropped.
    #[must_use]
    pub(crate) fn set(key: &'static LocalKey<RefCell<T>>, value: T) -> Self {
        let before = key.replace(value);
        Self { key, before }
    }
}

impl<T: Default> Drop for Restored<T> {
    fn drop(&mut self) {
        self.key.set(std::mem::take(&mut self.before));
    }
}
