//! Symbols that have values: their operations are computed at once, and not recorded.

use std::any::Any;
use std::cell::RefCell;

use autodiff::internal::Restored;

use super::operation::{Op, Place};

/// Computes operations with numbers of a type that the code on symbols does not know.
pub(super) trait Compute: Any {
    /// Computes an operation and returns the place of its result.
    fn push(&mut self, op: Op) -> Place;
    fn is_zero(&self, place: Place) -> bool;
    fn primal(&self, place: Place) -> f64;
    /// Whether a mask is true in any lane.
    fn any(&self, mask: Place) -> bool;
}

thread_local! {
    static CURRENT: RefCell<Option<Box<dyn Compute>>> = const { RefCell::new(None) };
}

/// Runs code whose symbols have values. Returns its result and the values.
pub(super) fn with<C: Compute, T>(values: C, code: impl FnOnce() -> T) -> (T, Box<C>) {
    let _outer = Restored::set(&CURRENT, Some(Box::new(values)));
    let result = code();
    let values: Option<Box<dyn Any>> = CURRENT.take().map(|values| values as _);
    let values = values.and_then(|values| values.downcast().ok());
    (result, values.expect("the values that were set"))
}

/// Calls `work` with the values of the current symbols, if they have values. Symbols that the values are made of are
/// recorded as usual meanwhile.
pub(super) fn current<T>(work: impl FnOnce(&mut dyn Compute) -> T) -> Option<T> {
    let mut values = CURRENT.take()?;
    let result = work(&mut *values);
    CURRENT.set(Some(values));
    Some(result)
}
