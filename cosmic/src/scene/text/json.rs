//! Reads the settings of a scene from JSON, as a case has them.

use serde_json::Value;

use super::whole::are_missing;
use crate::scene::Scene;
use crate::settings::{Field, Limits, read_json};

/// A setting of a scene with its value in JSON.
pub(crate) struct JsonSetting {
    /// The key, such as `physics.dt`.
    pub(crate) key: String,
    /// The place of the value in its file, such as `scene.physics.dt`.
    pub(crate) place: String,
    pub(crate) value: Value,
}

/// The keys whose ranges hold only in scenes, because a case has the robot itself: its nodes, its steps, its controller,
/// and a goal that may count from another origin. A key that ends with a dot stands for a section.
const OF_ROBOT: [&str; 4] = [
    "lattice.",
    "physics.steps",
    "controller.hidden",
    "controller.goal",
];

impl Scene {
    /// Changes settings, also those that only cases have.
    ///
    /// # Errors
    /// A sentence about an unknown key or about a value that its key does not allow. It begins with the place of the value.
    pub(crate) fn give(&mut self, given: &[JsonSetting]) -> Result<(), String> {
        // The section `physics` is read first, because the laws that it names decide which other sections exist.
        let is_physics = |given: &&JsonSetting| given.key.starts_with("physics.");
        let (physics, others): (Vec<_>, Vec<_>) = given.iter().partition(is_physics);
        for JsonSetting { key, place, value } in physics.into_iter().chain(others) {
            let is_free = OF_ROBOT.iter().any(|own| match own.strip_suffix('.') {
                Some(_) => key.starts_with(own),
                None => key == own,
            });
            match self.field_of_cases(key) {
                Some(field) if is_free => {
                    let limits = Limits::NONE;
                    read_json(Field { limits, ..field }, place, value)?;
                }
                Some(field) => read_json(field, place, value)?,
                None => {
                    let says = self.value(key).err().map(|error| error.to_string());
                    return Err(format!("`{place}`: {}", says.unwrap_or_default()));
                }
            }
        }
        Ok(())
    }

    /// Checks that all keys of a case are among these.
    ///
    /// # Errors
    /// A sentence that names the first missing keys.
    pub(crate) fn complete(&mut self, given: &[JsonSetting]) -> Result<(), String> {
        let mut missing = Vec::new();
        self.of_sections(|section, settings| {
            let paths = settings.fields_of_cases().into_iter();
            let paths = paths.map(|field| format!("{section}.{}", field.key));
            missing.extend(paths.filter(|path| given.iter().all(|given| given.key != *path)));
        });
        let missing: Vec<String> = missing.iter().map(|path| format!("`{path}`")).collect();
        are_missing(&missing).map_or(Ok(()), |says| Err(format!("`scene`: {says}")))
    }
}
