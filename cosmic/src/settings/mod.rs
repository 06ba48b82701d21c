//! Settings: the keys of a scene file. Each key is declared once, with its type, default, range, unit, source and
//! meaning.

mod limits;
mod value;
mod field;
mod inputs;
mod expression;
mod declare;

#[doc(hidden)]
pub use autodiff::Real;
pub use expression::Expression;
pub(crate) use field::{AUTO, read_json};
pub use field::{Field, Settings, Values, holds};
pub use inputs::{InputField, StepInputs};
pub(crate) use limits::{DEVIATION, ITERATIONS, POSITIVE, SHARE, STEPS};
pub use limits::{Limits, above, within};
#[doc(hidden)]
pub use serde;
pub use value::{Filled, Misfit, Named, SettingValue, json, kind, member, misfit, word}; // for `settings!` in other crates
pub(crate) use value::{quoted, wrong_kind};
