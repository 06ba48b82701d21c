//! The final measurements of a robot that are done, so that an interrupted delivery goes on where it stopped.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The results of the final measurements that are done, by the names of the measurements.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Measurements(BTreeMap<String, Value>);

impl Measurements {
    /// True if no measurement is done.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Forgets all results, because the robot has changed.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

/// A series of final measurements that can be stopped, saved and continued.
pub struct Measuring<'a> {
    /// The number of rollouts for each of the quantiles, at least eight.
    pub rollouts: usize,
    /// The measurements that are done. They are not repeated.
    pub known: Measurements,
    /// Whether to stop. It is asked several times, and before the result of a measurement is kept: rollouts that were
    /// stopped have no result.
    pub is_stopped: &'a dyn Fn() -> bool,
    /// Gets the measurements that are done, whenever there is one more, to save them.
    pub keep: Option<&'a mut dyn FnMut(&Measurements)>,
}

impl Measuring<'_> {
    /// A whole series with this number of rollouts, which nothing stops and nobody saves.
    pub fn over(rollouts: usize) -> Self {
        Self {
            rollouts,
            known: Measurements::default(),
            is_stopped: &|| false,
            keep: None,
        }
    }

    /// `None` if the series is stopped.
    pub(super) fn go_on(&self) -> Option<()> {
        (!(self.is_stopped)()).then_some(())
    }

    /// The result of the measurement `name`; `None` if the series is stopped. If the result is not known yet, calls `measure`,
    /// and keeps what it returns unless the series is stopped.
    pub(super) fn known_or<T: Serialize + DeserializeOwned + PartialEq>(
        &mut self,
        name: &str,
        measure: impl FnOnce() -> T,
    ) -> Option<T> {
        let known = self.known.0.get(name).and_then(read);
        let found = known.unwrap_or_else(|| {
            let found = measure();
            let value = serde_json::to_value(&found).ok();
            // JSON has no infinity, the result of diverged rollouts. Such a measurement is repeated.
            let value = value.filter(|value| read(value).as_ref() == Some(&found));
            if let Some(value) = value.filter(|_| !(self.is_stopped)()) {
                self.known.0.insert(name.to_owned(), value);
                if let Some(keep) = &mut self.keep {
                    keep(&self.known);
                }
            }
            found
        });
        self.go_on()?;
        Some(found)
    }
}

fn read<T: DeserializeOwned>(value: &Value) -> Option<T> {
    T::deserialize(value).ok()
}
