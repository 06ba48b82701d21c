//! A law: a term of the step with a name and settings.

use std::fmt::Debug;

use crate::settings::Settings;

/// A law's name and settings. The settings are the fields of the type, as
/// [`settings!`](crate::settings!) declares them; a scene has them in a section of the law's name.
pub trait Law: Settings + Clone + Default + Debug + Send + Sync + 'static {
    /// The name by which a scene chooses the law: lower case letters, digits and underscores.
    const NAME: &'static str;
}
