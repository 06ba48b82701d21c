//! Reading a scene: TOML over its base, every value checked, every fault pointed at.

use super::base::Base;
use super::diagnostic::{Fault, SceneText, malformed};
use super::keys::sections;
use super::version::{FORMAT, VERSION};
use super::{Scene, TrussFile, check};
use crate::error::{Error, Result};
use crate::laws::{self, TOP_KEYS};
use crate::settings::{SettingValue, kind, within};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The key of a scene file that names its base.
const BASE: &str = "base";

/// What the files among the sources are.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Settings in place of a scene's own.
    Changes,
    /// A scene. What it lacks comes from its base, unless it states a version.
    Scene,
    /// The scene of a run, which must not lack anything.
    Run,
    /// The scene in a snapshot. No person edits it, so that one without a version may lack keys.
    Snapshot,
}

impl Scene {
    /// Reads a scene from TOML. Keys left out come from the scene that its key `base` names, from `earth` if
    /// the key is missing. A truss file that it names is read.
    ///
    /// # Errors
    /// [`Error::Malformed`], naming `file`, for anything that is not TOML,
    /// an unknown key, a value of the wrong type or out of its range, and settings that contradict
    /// one another; the errors of [`Truss::read`](crate::lattice::Truss::read).
    pub fn parse(file: &str, text: &str) -> Result<Scene> {
        Reader::over(Scene::paper(), Kind::Scene, &[SceneText::file(file, text)]).resolved()
    }

    /// As [`parse`](Scene::parse), for the scene of a run: every key of its version must be there.
    ///
    /// # Errors
    /// As [`Scene::parse`], and [`Error::Malformed`] if keys are missing.
    pub fn parse_of_run(file: &str, text: &str) -> Result<Scene> {
        Reader::over(Scene::paper(), Kind::Run, &[SceneText::file(file, text)]).resolved()
    }

    /// As [`parse_of_run`](Scene::parse_of_run), for the scene in a snapshot, whose truss, if it has one, is
    /// beside it.
    ///
    /// # Errors
    /// As [`Scene::parse_of_run`].
    pub(crate) fn parse_of_snapshot(text: &str, truss: Option<TrussFile>) -> Result<Scene> {
        let source = [SceneText::file("scene", text)];
        let mut reader = Reader::over(Scene::paper(), Kind::Snapshot, &source);
        let Some(truss) = truss else {
            return reader.resolved();
        };
        reader.scene.lattice.file = truss;
        reader.finished()
    }

    /// As [`parse`](Scene::parse), of a scene whose truss is at hand: no file is read.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub(crate) fn parse_with_truss(file: &str, text: &str, truss: TrussFile) -> Result<Scene> {
        let source = [SceneText::file(file, text)];
        let mut reader = Reader::over(Scene::paper(), Kind::Scene, &source);
        reader.scene.lattice.file = truss;
        reader.finished()
    }

    /// The scene with the settings of a TOML text in place of its own. The text must not name a base.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with(&self, file: &str, text: &str) -> Result<Scene> {
        Reader::over(self.clone(), Kind::Changes, &[SceneText::file(file, text)]).resolved()
    }

    /// The scene with single settings in place of its own, each a key and a TOML value such as
    /// `physics.gravity=9.81`; of several for one key the last counts. Words need no quotes:
    /// `physics.contact=coulomb`. Whether settings fit one another is checked after all of them.
    ///
    /// # Errors
    /// As [`Scene::parse`], naming `--set` and the setting in place of a file and a line.
    pub fn set(&self, settings: &[impl AsRef<str>]) -> Result<Scene> {
        if settings.is_empty() {
            return Ok(self.clone());
        }
        Reader::over(self.clone(), Kind::Changes, &options(settings)).resolved()
    }
}

/// Settings of the command line as sources.
pub(super) fn options(settings: &[impl AsRef<str>]) -> Vec<SceneText<'_>> {
    let settings = settings.iter();
    settings.map(|s| SceneText::option(s.as_ref())).collect()
}

/// The error for a setting that turned out wrong after reading, shown where the last of the sources
/// sets it; `None` where none does.
pub(super) fn pointed(
    sources: &[SceneText],
    key: &str,
    message: &str,
    remedy: &str,
) -> Option<Error> {
    let mut reader = Reader::over(Scene::paper(), Kind::Scene, sources);
    let KeyPlace { source, span } = reader.places.remove(key)?;
    let fault = Fault {
        source,
        span,
        message: message.to_owned(),
        allowed: remedy.to_owned(),
    };
    Some(malformed(sources, vec![fault]))
}

/// Reads sources one after the other into a scene.
struct Reader<'s, 't> {
    sources: &'s [SceneText<'t>],
    /// The one that is being read.
    source: usize,
    scene: Scene,
    kind: Kind,
    faults: Vec<Fault>,
    /// Where `section.key` was set last.
    places: HashMap<String, KeyPlace>,
}

/// A value's bytes in one of the sources.
#[derive(Clone, Default)]
struct KeyPlace {
    source: usize,
    span: Range<usize>,
}

impl<'s, 't> Reader<'s, 't> {
    /// A scene with the settings of all sources. A file that is a scene by itself replaces it by its base.
    fn over(scene: Scene, kind: Kind, sources: &'s [SceneText<'t>]) -> Self {
        let mut reader = Reader {
            sources,
            source: 0,
            scene,
            kind,
            faults: Vec::new(),
            places: HashMap::new(),
        };
        for source in 0..sources.len() {
            reader.source = source;
            reader.document();
        }
        reader
    }

    /// The scene with the truss that it names, if nothing is wrong with it.
    fn resolved(mut self) -> Result<Scene> {
        if self.faults.is_empty() {
            let folder = self.folder("lattice.file");
            self.scene.lattice.file.resolve(&folder)?;
        }
        self.finished()
    }

    /// The scene, if nothing is wrong with it.
    fn finished(mut self) -> Result<Scene> {
        if self.faults.is_empty() && !self.sources.is_empty() {
            self.conflicts();
        }
        if self.faults.is_empty() {
            return Ok(self.scene);
        }
        (self.faults).sort_by_key(|fault| (fault.source, fault.span.start));
        Err(malformed(self.sources, self.faults))
    }

    fn fault(&mut self, span: Range<usize>, message: String, allowed: String) {
        self.faults.push(Fault {
            source: self.source,
            span,
            message,
            allowed,
        });
    }

    fn document(&mut self) {
        let SceneText { file, text } = &self.sources[self.source];
        if file.is_none() && !text.contains('=') {
            let message = format!("`{text}` has no value");
            let allowed = "write SECTION.KEY=VALUE, as physics.gravity=9.81";
            return self.fault(0..text.len(), message, allowed.to_owned());
        }
        match DeTable::parse(text) {
            Ok(document) => {
                let version = match self.begin(document.get_ref()) {
                    Ok(version) => version,
                    Err(fault) => return self.faults.push(fault),
                };
                // Which laws there are, and so which sections, the physics say.
                let sections = document.get_ref().iter();
                let sections = sections.filter(|(name, _)| !TOP_KEYS.contains(&&**name.get_ref()));
                let (first, then): (Vec<_>, Vec<_>) =
                    sections.partition(|(name, _)| name.get_ref() == "physics");
                for (name, value) in first.into_iter().chain(then) {
                    self.section(name.get_ref(), name.span(), value);
                }
                if let Some(version) = version {
                    self.complete(version);
                }
            }
            Err(error) => {
                let message = format!("not TOML: {}", error.message().replace('\n', ", "));
                self.fault(error.span().unwrap_or(0..0), message, String::new());
            }
        }
    }

    /// Begins a file that is a scene by itself: with its base, or, if it has to be complete, with the defaults.
    /// Returns the version for which it has to be complete.
    fn begin(&mut self, document: &DeTable) -> std::result::Result<Option<u32>, Fault> {
        if self.kind == Kind::Changes || self.sources[self.source].file.is_none() {
            let mut stated = TOP_KEYS
                .iter()
                .filter_map(|key| document.get_key_value(*key));
            return match stated.next() {
                None => Ok(None),
                Some((key, _)) => Err(Fault {
                    source: self.source,
                    span: key.span(),
                    message: format!("`{}` cannot be changed here", key.get_ref()),
                    allowed: "it describes a whole scene file: set it at the top of that file"
                        .to_owned(),
                }),
            };
        }
        let base = self.base(document)?;
        let version = self.version(document)?;
        self.scene = match (version, base) {
            (None, base) => base.unwrap_or_default().scene(),
            (Some(_), Some(base)) => Scene {
                base,
                ..Scene::paper()
            },
            (Some(_), None) => Scene::paper(),
        };
        Ok(version)
    }

    /// The base that a scene names.
    fn base(&self, document: &DeTable) -> std::result::Result<Option<Base>, Fault> {
        let Some(value) = document.get(BASE) else {
            return Ok(None);
        };
        let name = value.get_ref().as_str();
        if let Some(base) = name.and_then(Base::named) {
            return Ok(Some(base));
        }
        let says = match name {
            Some(_) => "names no built-in scene:",
            None => "is not the name of a scene:",
        };
        let known = suggest(name.unwrap_or_default(), Base::names().into_iter());
        Err(self.wrong(BASE, value, says, known))
    }

    /// The version for which a scene has to be complete: the one that it states; 0 for a run's without one.
    fn version(&self, document: &DeTable) -> std::result::Result<Option<u32>, Fault> {
        let [format, version] = ["format", "version"].map(|key| document.get(key));
        let (format, version) = match (format, version) {
            (None, None) => return Ok((self.kind != Kind::Scene).then_some(0)),
            (Some(format), Some(version)) => (format, version),
            (Some(lone), None) | (None, Some(lone)) => {
                let says = "must not stand alone:".to_owned();
                let allowed =
                    format!("the scene of a run begins with format = {FORMAT:?} and a version");
                let key = if format.is_some() {
                    "format"
                } else {
                    "version"
                };
                return Err(self.wrong(key, lone, &says, allowed));
            }
        };
        if format.get_ref().as_str() != Some(FORMAT) {
            return Err(self.wrong(
                "format",
                format,
                "is wrong:",
                format!("allowed: {FORMAT:?}"),
            ));
        }
        let mut number = 0_usize;
        match number.read(version, &within(1.0, f64::from(VERSION))) {
            Ok(()) => Ok(Some(number as u32)),
            Err(misfit) => {
                let allowed = format!("this program reads versions up to {VERSION}");
                Err(self.wrong("version", version, &misfit.says, allowed))
            }
        }
    }

    /// A fault of the value of a key above the first section.
    fn wrong(&self, key: &str, value: &Spanned<DeValue>, says: &str, allowed: String) -> Fault {
        let text = &self.sources[self.source].text;
        let written = abridged(text.get(value.span()).unwrap_or_default());
        Fault {
            source: self.source,
            span: value.span(),
            message: format!("`{key}` {says} {written}"),
            allowed,
        }
    }

    /// Requires every key of a version. Newer keys have the values that they had in effect before.
    fn complete(&mut self, version: u32) {
        let is_lenient = self.kind == Kind::Snapshot && version == 0;
        let (places, mut missing) = (&self.places, Vec::new());
        self.scene.of_sections(|section, settings| {
            for field in settings.fields() {
                let path = format!("{section}.{}", field.key);
                if places.contains_key(&path) {
                    continue;
                }
                if field.since > version {
                    field.take_before();
                } else if !is_lenient {
                    missing.push(format!("`{path}`"));
                }
            }
        });
        /// The keys that a message names.
        const NAMED: usize = 3;
        let (named, others) = missing.split_at(NAMED.min(missing.len()));
        let message = match (named, others.len()) {
            ([], _) => return,
            ([one], _) => format!("{one} is missing"),
            (several, 0) => format!("{} are missing", several.join(", ")),
            (several, more) => format!("{} and {more} more keys are missing", several.join(", ")),
        };
        let allowed = "the scene of a run must hold every key of its version".to_owned();
        self.fault(0..0, message, allowed);
    }

    fn section(&mut self, name: &str, span: Range<usize>, value: &Spanned<DeValue>) {
        let known = sections(&mut self.scene);
        if known.iter().all(|section| section.name != name) {
            if let Some(remedy) = laws::choosing(name) {
                let message = format!("the law `{name}` is not chosen");
                return self.fault(span, message, remedy);
            }
            let owner = known.iter().find(|section| section.keys.contains(&name));
            let path = owner.map(|owner| format!("did you mean `{}.{name}`? ", owner.name));
            let names = known.iter().map(|section| section.name);
            let names = suggest(name, names.chain(TOP_KEYS));
            let hint = path.unwrap_or_default() + &names;
            return self.fault(span, format!("unknown section `{name}`"), hint);
        }
        let Some(table) = value.get_ref().as_table() else {
            let message = format!("`{name}` is {}, not a section", kind(value));
            let allowed = if self.sources[self.source].file.is_some() {
                format!("write [{name}] and its keys below")
            } else {
                format!("write {name}.KEY=VALUE")
            };
            return self.fault(value.span(), message, allowed);
        };
        for (key, value) in table {
            let path = format!("{name}.{}", key.get_ref());
            match self.scene.field(&path) {
                Some(field) => {
                    if let Err(misfit) = field.value.read(value, &field.limits) {
                        let allowed = format!("allowed: {}", field.allowed());
                        let text = &self.sources[self.source].text;
                        let written = text.get(misfit.span.clone()).unwrap_or_default();
                        let message = format!("`{path}` {} {}", misfit.says, abridged(written));
                        self.fault(misfit.span, message, allowed);
                    }
                    let (source, span) = (self.source, value.span());
                    self.places.insert(path, KeyPlace { source, span });
                }
                None => self.unknown_key(name, key.get_ref(), key.span()),
            }
        }
    }

    /// The folder of the file that set a key last; the process's own for the command line.
    fn folder(&self, key: &str) -> PathBuf {
        let file = self
            .places
            .get(key)
            .and_then(|place| self.sources[place.source].file);
        let folder = file.and_then(|file| Path::new(file).parent());
        folder.unwrap_or(Path::new("")).to_owned()
    }

    fn unknown_key(&mut self, name: &str, key: &str, span: Range<usize>) {
        let known = sections(&mut self.scene);
        let owner = known.iter().find(|other| other.keys.contains(&key));
        let keys = known.iter().filter(|section| section.name == name);
        let hint = match owner {
            Some(owner) => format!("belongs to [{}]", owner.name),
            None if TOP_KEYS.contains(&key) => "belongs above the first section".to_owned(),
            None => suggest(key, keys.flat_map(|section| &section.keys).copied()),
        };
        self.fault(span, format!("unknown key `{key}` in [{name}]"), hint);
    }

    /// Points a conflict at the first of its settings that the sources name.
    fn conflicts(&mut self) {
        for conflict in check::conflicts(&self.scene) {
            let mut keys = conflict.keys.iter();
            let place = keys.find_map(|key| self.places.get(*key));
            let KeyPlace { source, span } = place.cloned().unwrap_or_default();
            let [first, second] = conflict.keys;
            let hint = if first == second {
                String::new()
            } else {
                format!("see {first} and {second}")
            };
            self.source = source;
            self.fault(span, conflict.says, hint);
        }
    }
}

/// The known name nearest to a misspelt one, else all of them.
pub(super) fn suggest<'n>(wrong: &str, known: impl Iterator<Item = &'n str> + Clone) -> String {
    /// Jaro-Winkler similarity of two names that differ by a slip or two.
    const CLOSE: f64 = 0.8;
    let rate = |name: &&'n str| strsim::jaro_winkler(wrong, name);
    let best = known.clone().max_by(|a, b| rate(a).total_cmp(&rate(b)));
    match best.filter(|name| rate(name) > CLOSE) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("known: {}", known.collect::<Vec<_>>().join(", ")),
    }
}

/// The first line of what a file says, cut where it is long.
fn abridged(written: &str) -> String {
    const LONGEST: usize = 40;
    let line = written.lines().next().unwrap_or_default();
    let short: String = line.chars().take(LONGEST).collect();
    if short.len() < written.len() {
        short + "..."
    } else {
        short
    }
}
