//! Freezes plans. `plan.json` is written when a sweep is planned, and contains the program's version. It must not be
//! edited later; to detect edits, a copy is kept beside the claims. A plan is refused if it differs from its copy, or
//! if another version of the program made it.

use super::{PLAN, SweepPlan};
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::reading::read_whole;
use cosmic::record::files::{Format, is_used, make_folder, parse_json, write_json};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The format of a plan.
const FORMAT: Format = Format {
    name: "cosmic-sweep-plan",
    version: 2,
};

/// The path of the copy in the sweep's folder.
const COPY: &str = "claims/plan.json";

/// The version of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The content of a plan's file.
#[derive(Serialize)]
struct Content<'p> {
    cosmic_version: &'p str,
    #[serde(flatten)]
    plan: &'p SweepPlan,
}

#[derive(Deserialize)]
struct PlannedBy {
    cosmic_version: String,
}

impl SweepPlan {
    /// Writes the plan into a new or empty folder.
    ///
    /// # Errors
    /// The errors of [`check`](Self::check); [`Error::Usage`] for a folder that is not empty;
    /// [`Error::Write`].
    pub fn freeze(&self, folder: &Path, registry: &Registry) -> Result<()> {
        self.check(registry)?;
        match is_used(folder) {
            Ok(true) => {
                let folder = folder.display();
                Err(Error::Usage(format!(
                    "{folder}: the folder is not empty; name a new or empty folder"
                )))
            }
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(Error::reading(folder)(source))
            }
            Ok(false) | Err(_) => self.write(folder),
        }
    }

    /// Replaces the plan in a folder. The run of a scene and seed is kept if both plans contain it.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<()> {
        let copy = folder.join(COPY);
        make_folder(&folder.join("claims"))?;
        // The old copy is removed first: a plan without a copy is valid, but a plan that differs from its copy is not.
        match fs::remove_file(&copy) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                return Err(Error::writing(&copy)(source));
            }
            _ => {}
        }
        let content = Content {
            cosmic_version: VERSION,
            plan: self,
        };
        write_json(&folder.join(PLAN), FORMAT, &content)?;
        write_json(&copy, FORMAT, &content)
    }

    /// Reads the plan in the folder of a sweep.
    ///
    /// # Errors
    /// The errors of [`read_whole`] and [`parse_json`]; [`Error::Usage`] for a plan that was edited after
    /// it was written, or that another version of the program wrote.
    pub fn read(folder: &Path) -> Result<Self> {
        let [path, copy] = [PLAN, COPY].map(|name| folder.join(name));
        let refuse = |what: String| Err(Error::Usage(format!("{}: {what}", path.display())));
        let bytes = read_whole(&path)?;
        let PlannedBy { cosmic_version } = parse_json(&path, &bytes, FORMAT)?;
        if cosmic_version != VERSION {
            return refuse(format!(
                "`cosmic_version` is {cosmic_version}, but this program is {VERSION}; use version \
                 {cosmic_version}, or plan another sweep"
            ));
        }
        let plan: Self = parse_json(&path, &bytes, FORMAT)?;
        let before = copy.exists().then(|| read_whole(&copy)).transpose()?;
        if let Some(before) = before.filter(|before| *before != bytes) {
            let before: Self = parse_json(&copy, &before, FORMAT)?;
            if let Some([key, now, before]) = plan.edit(&before) {
                return refuse(format!(
                    "the plan was edited after it was frozen: `{key}` is {now}, but was {before}; undo the edit, or \
                     plan another sweep"
                ));
            }
        }
        match plan.check_shape() {
            Err(Error::Usage(what)) => refuse(what),
            checked => checked.map(|()| plan),
        }
    }

    /// Finds the first setting of this plan that was edited. `before` is the plan as it was frozen. Returns the
    /// setting's name, its value in this plan, and its value in `before`. Returns `None` if only the layout of the file
    /// differs.
    fn edit(&self, before: &Self) -> Option<[String; 3]> {
        if self == before {
            return None;
        }
        let pairs = self.settings().into_iter().zip(before.settings());
        let changed = pairs.into_iter().find(|(now, before)| now != before);
        let [key, now, before] = match changed {
            Some(([key, now], [_, before])) => [key, now, before],
            // No setting differs, so the text of a scene or the truss of a scene must differ.
            None => ["scenes", "written in another way", "as planned"].map(str::to_owned),
        };
        Some([key, now, before])
    }

    /// The names of all settings of the plan and of its scenes, and their values as text.
    fn settings(&self) -> Vec<[String; 2]> {
        let named = |(key, value): (&str, Value)| [key.to_owned(), value.to_string()];
        let scenes = self
            .scenes
            .iter()
            .map(|scene| json!([scene.name, scene.swept]));
        let own = [
            ("study", json!(self.study)),
            ("first_seed", json!(self.first_seed)),
            ("seeds", json!(self.seeds)),
            ("iterations", json!(self.iterations)),
            ("scenes", scenes.collect()),
        ];
        let mut settings: Vec<[String; 2]> = own.into_iter().map(named).collect();
        for planned in &self.scenes {
            for [key, value] in settings_of(&planned.scene.text) {
                settings.push([format!("{}: {key}", planned.name), value]);
            }
        }
        settings
    }
}

/// Returns the keys of a saved scene and their values. The text of a saved scene has one key on each line.
fn settings_of(text: &str) -> Vec<[String; 2]> {
    let mut section = String::new();
    let mut settings = Vec::new();
    for line in text.lines() {
        if let Some((key, value)) = line.split_once(" = ") {
            settings.push([format!("{section}{key}"), value.to_owned()]);
        } else {
            section = format!("{}.", line.trim_matches(['[', ']']));
        }
    }
    settings
}
