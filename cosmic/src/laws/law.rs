//! A law: a term of the step with a name and settings.

use std::fmt::Debug;

use crate::settings::{Inputs, Settings};

/// A law's name and settings. The settings are the fields of the type, as
/// [`settings!`](crate::settings!) declares them; a scene has them in a section named after the law.
pub trait Law:
    Settings + Inputs<Of<f64> = Self> + Clone + Default + Debug + Send + Sync + 'static
{
    /// The name by which a scene chooses the law: lower case letters, digits and underscores.
    const NAME: &'static str;
}

/// A number of the step that is the same for all nodes and bars: a setting of a law, or gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct StepInput {
    /// Its key in a scene, such as `mud.rate`.
    pub name: String,
    /// Its value in the scene, in the key's unit.
    pub value: f64,
}

/// The settings of a law that are inputs of the step.
pub(super) fn step_inputs<L: Law>(law: &L) -> Vec<StepInput> {
    let input = |(key, value): (String, f64)| StepInput {
        name: if key.contains('.') {
            key
        } else {
            format!("{}.{key}", L::NAME)
        },
        value,
    };
    law.inputs().into_iter().map(input).collect()
}
