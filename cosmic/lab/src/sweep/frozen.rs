//! `plan.json`: written when a sweep is planned, with the program's version and a hash of both; a plan that was
//! edited, or made by another version, is refused.

use super::{PLAN, PlannedScene, SweepPlan, UnreadPlan};
use crate::files::write_text;
use cosmic::error::{Error, Result};
use cosmic::reading::read_whole;
use cosmic::record::files::{Format, is_used, make_folder, parse_json};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The format of a plan.
const FORMAT: Format = Format {
    name: "cosmic-sweep-plan",
    version: 2,
};

/// The copy of the plan: it says what was edited in `plan.json`.
const COPY: &str = "claims/plan.json";

/// The version of this program.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The content that the hash covers.
#[derive(Serialize)]
struct Content<'p> {
    cosmic_version: &'p str,
    #[serde(flatten)]
    plan: &'p UnreadPlan,
}

/// The hash and the version in the file.
#[derive(Deserialize)]
struct Seal {
    hash: String,
    cosmic_version: String,
}

impl SweepPlan {
    /// Writes the plan into a new or empty folder.
    ///
    /// # Errors
    /// The errors of [`check`](Self::check); [`Error::Usage`] for a folder that holds something;
    /// [`Error::Write`].
    pub fn freeze(&self, folder: &Path) -> Result<()> {
        self.check()?;
        match is_used(folder) {
            Ok(true) => {
                let folder = folder.display();
                Err(Error::Usage(format!("{folder}: the folder is not empty")))
            }
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(Error::reading(folder)(source))
            }
            Ok(false) | Err(_) => self.write(folder),
        }
    }

    /// Replaces the plan of a folder. Runs of scenes and seeds that both plans have are kept.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<()> {
        let [path, copy] = [PLAN, COPY].map(|name| folder.join(name));
        make_folder(&folder.join("claims"))?;
        // Without a copy a plan is whole, so that nobody reads two that differ.
        match fs::remove_file(&copy) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                return Err(Error::writing(&copy)(source));
            }
            _ => {}
        }
        let text = sealed(&content(&self.saved(), VERSION));
        write_text(&path, &text)?;
        write_text(&copy, &text)
    }
}

impl UnreadPlan {
    /// Every setting: its name and its value.
    fn settings(&self) -> Vec<[String; 2]> {
        let names = self.scenes.iter().map(|planned| &planned.name[..]);
        let null = || "null".to_owned();
        let study = self.study.as_ref();
        let python = study.and_then(|study| study.python.clone());
        let own = [
            [
                "study",
                &study.map_or_else(null, |study| study.kind.clone()),
            ],
            ["python", &python.unwrap_or_else(null)],
            ["scenes", &names.collect::<Vec<_>>().join(", ")],
            ["first_seed", &self.first_seed.to_string()],
            ["seeds", &self.seeds.to_string()],
            [
                "iterations",
                &self.iterations.map_or_else(null, |n| n.to_string()),
            ],
        ];
        let own = own.map(|setting| setting.map(str::to_owned)).into_iter();
        let of_scenes = self.scenes.iter();
        let of_scenes = of_scenes.flat_map(|PlannedScene { name, scene, .. }| {
            let settings = settings_of(&scene.text).into_iter();
            settings.map(move |[key, value]| [format!("{name}: {key}"), value])
        });
        own.chain(of_scenes).collect()
    }
}

/// The keys and the values of a saved scene, which has one on each line.
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

impl<S: DeserializeOwned> SweepPlan<S> {
    /// The plan of a folder.
    ///
    /// # Errors
    /// Those of [`read_whole`] and [`parse_json`]; [`Error::Usage`] for a plan that was edited, or
    /// frozen by another version of the program.
    pub fn read(folder: &Path) -> Result<Self> {
        let [path, copy] = [PLAN, COPY].map(|name| folder.join(name));
        let bytes = read_whole(&path)?;
        let before = copy.exists().then(|| read_whole(&copy)).transpose()?;
        let is_before = before.as_ref().is_none_or(|before| *before == bytes);
        if !(is_before && is_intact(&bytes)) {
            let before = before.map(|before| parse_json::<UnreadPlan>(&copy, &before, FORMAT));
            compare(&path, &bytes, before)?;
        }
        let plan: Self = parse_json(&path, &bytes, FORMAT)?;
        plan.check_shape()
            .map(|()| plan)
            .map_err(|error| match error {
                Error::Usage(what) => Error::Usage(format!("{}: {what}", path.display())),
                error => error,
            })
    }
}

/// The content of a plan's file as JSON.
fn content(plan: &UnreadPlan, cosmic_version: &str) -> String {
    let content = Content {
        cosmic_version,
        plan,
    };
    serde_json::to_string(&content).expect("plain numbers and string keys serialise")
}

/// What a file begins with, up to its hash.
fn head() -> String {
    let Format { name, version } = FORMAT;
    format!("{{\"format\":\"{name}\",\"version\":{version},\"hash\":\"")
}

/// The file with a content: format and hash in front.
fn sealed(content: &str) -> String {
    let (head, hash, rest) = (head(), hash(content.as_bytes()), &content[1..]);
    format!("{head}{hash}\",{rest}\n")
}

/// True for a file as this version writes it, whose content has its hash. Nothing needs to be parsed.
fn is_intact(bytes: &[u8]) -> bool {
    let (head, own) = (head(), format!("\"cosmic_version\":\"{VERSION}\","));
    let rest = bytes.strip_prefix(head.as_bytes());
    let Some((said, rest)) = rest.and_then(|rest| rest.split_at_checked(16)) else {
        return false;
    };
    let content = rest
        .strip_prefix(b"\",")
        .and_then(|rest| rest.strip_suffix(b"\n"));
    content.is_some_and(|content| {
        let found = fnv(fnv(FNV_BASIS, b"{"), content);
        content.starts_with(own.as_bytes()) && said == format!("{found:016x}").as_bytes()
    })
}

/// Says in what a plan differs from the one that was frozen. A file that is only laid out otherwise passes.
fn compare(path: &Path, bytes: &[u8], before: Option<Result<UnreadPlan>>) -> Result<()> {
    let refuse = |what: String| Err(Error::Usage(format!("{}: {what}", path.display())));
    let seal: Seal = parse_json(path, bytes, FORMAT)?;
    let version = &seal.cosmic_version;
    if version != VERSION {
        return refuse(format!(
            "`cosmic_version` is {version}, where this program is {VERSION}; use the one that planned it, or \
             plan another sweep"
        ));
    }
    let now: UnreadPlan = parse_json(path, bytes, FORMAT)?;
    if let Some(before) = before.transpose()? {
        let mut pairs = now.settings().into_iter().zip(before.settings());
        if let Some(([key, now], [_, before])) = pairs.find(|(now, before)| now != before) {
            return refuse(format!(
                "edited after it was frozen: `{key}` is {now}, where it was {before}; put it back, or \
                 plan another sweep"
            ));
        }
    }
    let found = hash(content(&now, VERSION).as_bytes());
    if found == seal.hash {
        return Ok(());
    }
    refuse(format!(
        "edited after it was frozen: its settings have the hash {found}, where `hash` is {}; put it back, or \
         plan another sweep",
        seal.hash
    ))
}

fn hash(bytes: &[u8]) -> String {
    format!("{:016x}", fnv(FNV_BASIS, bytes))
}

const FNV_BASIS: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a with 64 bits: it finds what happens to a file by accident, and needs no other crate.
fn fnv(start: u64, bytes: &[u8]) -> u64 {
    let step = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    bytes.iter().fold(start, step)
}

#[cfg(test)]
mod tests {
    use super::{COPY, PLAN, content, hash, sealed};
    use crate::sweep::plan::tests::plan;
    use crate::sweep::{PlanOutline, SweepPlan, UnreadPlan};
    use cosmic::Registry;
    use std::fs;
    use std::path::Path;

    fn read(folder: &Path) -> SweepPlan {
        let plan = UnreadPlan::read(folder).unwrap();
        plan.whole(&Registry::default()).unwrap()
    }

    fn refusal(folder: &Path, text: &str) -> String {
        fs::write(folder.join(PLAN), text).unwrap();
        let error = PlanOutline::read(folder).unwrap_err().to_string();
        assert!(error.contains("plan.json: "), "{error}");
        error
    }

    #[test]
    fn a_frozen_plan_reads_back_and_a_study_may_replace_it() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let mut plan = plan(&["a", "b"], 0);
        plan.freeze(folder).unwrap();
        assert_eq!(read(folder), plan);
        let outline = PlanOutline::read(folder).unwrap();
        assert_eq!((outline.runs(), &outline.name(4)[..]), (6, "b-1"));
        plan.scenes[0].scene.physics.gravity = 5.0;
        plan.write(folder).unwrap();
        assert_eq!(read(folder), plan);
    }

    #[test]
    fn an_edited_plan_and_one_of_another_version_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let plan = plan(&["a"], 0);
        plan.freeze(folder).unwrap();
        let text = fs::read_to_string(folder.join(PLAN)).unwrap();
        // Laid out otherwise it is the same.
        fs::write(folder.join(PLAN), text.replace(",\"seeds\"", ", \"seeds\"")).unwrap();
        assert_eq!(read(folder), plan);
        let edited = text.replace("\"seeds\":3", "\"seeds\":4");
        assert!(refusal(folder, &edited).contains("`seeds` is 4, where it was 3"));
        let old = sealed(&content(&plan.saved(), "0.0.9"));
        assert!(refusal(folder, &old).contains("`cosmic_version` is 0.0.9, where this"));
        // Without the copy the hash gives it away.
        fs::remove_file(folder.join(COPY)).unwrap();
        assert!(refusal(folder, &edited).contains("where `hash` is "));
        fs::write(folder.join(PLAN), text).unwrap();
        assert_eq!(read(folder), plan);
    }

    /// The hashes that the authors of FNV give.
    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(hash(b""), "cbf29ce484222325");
        assert_eq!(hash(b"foobar"), "85944171f73967e8");
    }
}
