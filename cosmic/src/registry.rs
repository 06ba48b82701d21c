//! Laws, losses, scenes and lattices that a program adds to those of the model: by name, for the whole process.

use std::sync::{PoisonError, RwLock};

/// The word of a scene that chooses no item.
pub(crate) const OFF: &str = "off";

/// Items that scenes may name, in the order in which they were added.
pub(crate) struct Registry<T>(RwLock<Vec<(&'static str, T)>>);

impl<T: Clone> Registry<T> {
    pub(crate) const fn new() -> Self {
        Self(RwLock::new(Vec::new()))
    }

    /// Adds an item; `kind` names it in the message.
    ///
    /// # Panics
    /// If the name is taken.
    pub(crate) fn add(&self, kind: &str, name: &'static str, item: T) {
        // No item is ever half added: a lock that a panic left behind is as good as any.
        let mut items = self.0.write().unwrap_or_else(PoisonError::into_inner);
        let is_taken = items.iter().any(|(taken, _)| *taken == name);
        assert!(!is_taken, "there is a {kind} {name:?} already");
        items.push((name, item));
    }

    /// The item of a name.
    pub(crate) fn get(&self, name: &str) -> Option<T> {
        let items = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let found = items.iter().find(|(other, _)| *other == name);
        found.map(|(_, item)| item.clone())
    }

    /// Every item with its name.
    pub(crate) fn all(&self) -> Vec<(&'static str, T)> {
        let items = self.0.read().unwrap_or_else(PoisonError::into_inner);
        items.clone()
    }
}
