//! The laws, losses, policies, lattices and scenes that a program adds to the built-in ones.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// The word in a scene file that means: no item is chosen.
pub(crate) const OFF: &str = "off";

/// The laws, losses, policies, lattices and scenes that a program adds to the built-in ones. Functions that read
/// scenes, cases and runs take a registry. A scene keeps its registry, so that settings that are changed later may name
/// the same items. Clones of a registry share its items.
///
/// ```
/// use cosmic::Registry;
///
/// let registry = Registry::default().with_scene("moon", "physics.gravity = 1.62");
/// assert_eq!(registry.load("moon")?.physics.gravity, 1.62);
/// # Ok::<(), cosmic::Error>(())
/// ```
#[derive(Clone, Default)]
pub struct Registry(Arc<Vec<Item>>);

#[derive(Clone)]
struct Item {
    kind: &'static str,
    name: &'static str,
    value: Arc<dyn Any + Send + Sync>,
}

impl Registry {
    /// Adds an item. `kind` is the noun for such an item in messages, such as "policy".
    ///
    /// # Panics
    /// If the name is `off`, is in `built_in`, or belongs to another item of that kind.
    pub(crate) fn with<T: Any + Send + Sync>(
        mut self,
        kind: &'static str,
        built_in: &[&str],
        name: &'static str,
        value: T,
    ) -> Self {
        let is_taken = built_in.contains(&name) || self.names(kind).any(|other| other == name);
        assert!(!is_taken, "a {kind} named {name:?} exists already");
        assert!(name != OFF, "a {kind} cannot be called {name:?}");
        let value = Arc::new(value);
        Arc::make_mut(&mut self.0).push(Item { kind, name, value });
        self
    }

    /// All items of a kind, in the order in which they were added.
    pub(crate) fn all<T: Any>(&self, kind: &str) -> impl DoubleEndedIterator<Item = &T> {
        let items = self.0.iter().filter(move |item| item.kind == kind);
        items.filter_map(|item| item.value.downcast_ref())
    }

    /// The names of the items of a kind.
    pub(crate) fn names(&self, kind: &str) -> impl Iterator<Item = &'static str> {
        let items = self.0.iter().filter(move |item| item.kind == kind);
        items.map(|item| item.name)
    }

    /// The item of this kind with this name, if there is one.
    pub(crate) fn get<T: Any>(&self, kind: &str, name: &str) -> Option<&T> {
        let mut items = self.0.iter();
        let item = items.find(|item| item.kind == kind && item.name == name)?;
        item.value.downcast_ref()
    }
}

impl fmt::Debug for Registry {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let names = self.0.iter().map(|item| (item.kind, item.name));
        f.debug_list().entries(names).finish()
    }
}
