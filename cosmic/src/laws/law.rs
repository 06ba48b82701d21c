//! The trait [`Law`]: a name and settings, which contact laws and force laws have in common.

use std::fmt::Debug;

use autodiff_programs::Compiled;

use crate::settings::{Settings, StepInputs};

/// A contact law or a force law, with a name and settings. The settings are the fields of the type, as declared by
/// [`settings!`](crate::settings!). In a scene they are in a section with the name of the law.
pub trait Law:
    Settings + StepInputs<Of<f64> = Self> + Clone + Default + Debug + Send + Sync + 'static
{
    /// The name by which a scene chooses the law: lower case letters, digits and underscores.
    const NAME: &'static str;
    /// For what the kernels of the law are compiled, at most.
    const COMPILED: Compiled = Compiled::Fully;
}

/// The name of the coefficient of friction: the key of the scene, which contact laws that slip read.
pub(crate) const FRICTION: &str = "physics.friction";

/// An input of a step that is the same for all nodes and bars: a setting of a law, or gravity.
#[derive(Clone, Debug, PartialEq)]
pub struct StepInput {
    /// The key of the number in a scene, such as `mud.rate`.
    pub name: String,
    /// The value of the number in the scene, in the unit of the key.
    pub value: f64,
}

impl StepInput {
    /// The number with the key `name` in a scene, where it has the value `value`.
    pub fn new(name: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            value,
        }
    }
}

/// The settings of a law that are inputs of a step. Their names are full keys, such as `mud.rate`.
pub(super) fn step_inputs<L: Law>(law: &L) -> Vec<StepInput> {
    let input = |(key, value): (String, f64)| {
        let is_whole = key.contains('.');
        StepInput::new(
            if is_whole {
                key
            } else {
                format!("{}.{key}", L::NAME)
            },
            value,
        )
    };
    law.inputs().into_iter().map(input).collect()
}
