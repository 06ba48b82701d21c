//! The passes of the co-design, and the letters that stand for passes in `schedule.cycle`.

use crate::settings::{Filled, Limits, SettingValue, json, misfit, word};
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::DeValue;

/// What one iteration of the co-design updates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// The design vectors. MMA updates them.
    Design,
    /// The controller's weights. Adam updates them.
    Controller,
}

impl Pass {
    /// The letter that stands for this pass in `schedule.cycle`.
    pub fn letter(self) -> char {
        match self {
            Pass::Design => 'd',
            Pass::Controller => 'c',
        }
    }
}

/// The passes that the letters of a cycle such as `"dcdc"` stand for; `None` if a letter has no meaning.
pub(super) fn cycle(letters: &str) -> Option<Vec<Pass>> {
    let pass = |letter| {
        [Pass::Design, Pass::Controller]
            .into_iter()
            .find(|pass| pass.letter() == letter)
    };
    letters.chars().map(pass).collect()
}

impl SettingValue for Vec<Pass> {
    fn allowed(&self, limits: &Limits) -> String {
        format!("a string of the letters d and c, its length {limits}")
    }

    fn toml(&self) -> String {
        let letters: String = self.iter().map(|pass| pass.letter()).collect();
        format!("{letters:?}")
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        let read = cycle(word(value)?).filter(|passes| passes.fits(limits));
        *self = read.ok_or_else(|| misfit(value, "cannot be"))?;
        Ok(())
    }

    fn fits(&self, limits: &Limits) -> bool {
        limits.contain(self.len() as f64)
    }
}
