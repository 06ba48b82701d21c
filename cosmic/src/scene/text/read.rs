//! Reads a scene from TOML. Its base supplies missing keys. Every value is checked, and every error has its place.

use super::syntax::parsed;
use crate::error::{Error, Result, command};
use crate::reading::with_decimal_point;
use crate::registry::Registry;
use crate::scene::base::TOP_KEYS;
use crate::scene::diagnostic::{Fault, SceneText, malformed, suggest};
use crate::scene::keys::sections;
use crate::scene::{LatticeSettings, Scene, TrussFile, checks};
use crate::settings::{AUTO, Misfit, SettingValue, kind};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

impl Registry {
    /// Reads a scene from TOML. The scene that the key `base` names supplies missing keys; without this key it is
    /// `earth`. In the scene of a run, which states its format and its version, no key may be missing. If the scene
    /// names a truss file, the truss file is read too.
    ///
    /// # Errors
    /// [`Error::Malformed`], naming `file`, for text that is not TOML, an unknown key, a value of the wrong type or out
    /// of its range, and settings that contradict one another; the errors of
    /// [`Truss::read`](crate::lattice::Truss::read).
    pub fn parse(&self, file: &str, text: &str) -> Result<Scene> {
        self.parse_with(file, text, None)
    }

    /// Reads the scene in the text of a file, as [`parse`](Self::parse) does. Such a text must set a key: a file without one
    /// is empty by mistake.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a text that sets no key; the errors of [`parse`](Self::parse).
    pub fn parse_file(&self, file: &str, text: &str) -> Result<Scene> {
        let sets_a_key = |line: &str| {
            let line = line.trim_start();
            !line.is_empty() && !line.starts_with('#')
        };
        if text.lines().any(sets_a_key) {
            return self.parse(file, text);
        }
        let nothing = Fault {
            source: 0,
            span: 0..0,
            message: "the file sets no key, so it is neither a scene nor a sweep".to_owned(),
            allowed: format!(
                "write a key, as in physics.gravity = 3.7; all keys are printed by: {}",
                command("scene default")
            ),
        };
        Err(malformed(&[SceneText::file(file, text)], vec![nothing]))
    }

    /// Like [`parse`](Self::parse). If a truss is given, it takes the place of the truss file that the scene names.
    pub(crate) fn parse_with(
        &self,
        file: &str,
        text: &str,
        truss: Option<TrussFile>,
    ) -> Result<Scene> {
        let source = [SceneText::file(file, text)];
        let mut reader = Reader::over(self.blank(), false, &source);
        if let Some(mut truss) = truss {
            truss.know(self);
            reader.scene.lattice.file = truss;
        }
        reader.resolved()
    }

    /// The paper's scene, with this registry. Its settings may name the items of the registry.
    pub(crate) fn blank(&self) -> Scene {
        Scene::paper().knowing(self)
    }
}

impl Scene {
    /// Reads a scene from TOML, as [`Registry::parse`] does.
    ///
    /// # Errors
    /// The errors of [`Registry::parse`].
    pub fn parse(file: &str, text: &str) -> Result<Scene> {
        Registry::default().parse(file, text)
    }

    /// Changes this scene by the settings in a TOML text. The text must not name a base.
    ///
    /// # Errors
    /// The errors of [`Registry::parse`].
    pub fn with(&self, file: &str, text: &str) -> Result<Scene> {
        Reader::over(self.clone(), true, &[SceneText::file(file, text)]).resolved()
    }

    /// Replaces some settings of this scene. Each setting is a key with a TOML value, such as `physics.gravity=9.81`.
    /// Words need no quotes: `physics.contact=coulomb`. If a key is given several times, the last value counts. The
    /// settings are checked against one another after all replacements.
    ///
    /// # Errors
    /// The errors of [`Registry::parse`], which name `--set` and the setting instead of a file and a line.
    pub fn set(&self, settings: &[impl AsRef<str>]) -> Result<Scene> {
        if settings.is_empty() {
            return Ok(self.clone());
        }
        Reader::over(self.clone(), true, &options(settings)).resolved()
    }
}

/// The number of keys that the sections of a table set.
fn keys_below(table: &DeTable) -> usize {
    let keys =
        |(_, value): (_, &Spanned<DeValue>)| value.get_ref().as_table().map_or(1, DeTable::len);
    table.iter().map(keys).sum()
}

/// Makes a source from each `KEY=VALUE` of the option `--set`.
pub(in crate::scene) fn options(settings: &[impl AsRef<str>]) -> Vec<SceneText<'_>> {
    let settings = settings.iter();
    settings.map(|s| SceneText::option(s.as_ref())).collect()
}

/// The error for a setting whose value turned out to be wrong after the scene was read. The error points at the last
/// place that sets `key`. `None` if no source sets it.
pub(in crate::scene) fn pointed(
    registry: &Registry,
    sources: &[SceneText],
    key: &str,
    message: &str,
    remedy: &str,
) -> Option<Error> {
    let mut reader = Reader::over(registry.blank(), false, sources);
    let KeyPlace { source, span } = reader.places.remove(key)?;
    let fault = Fault {
        source,
        span,
        message: message.to_owned(),
        allowed: remedy.to_owned(),
    };
    Some(malformed(sources, vec![fault]))
}

/// Reads the sources of a scene, one after the other. Later sources override earlier ones.
pub(super) struct Reader<'s, 't> {
    pub(super) sources: &'s [SceneText<'t>],
    /// The index of the source that is being read.
    pub(super) source: usize,
    pub(super) scene: Scene,
    /// True if the sources only change a scene, so that none of them is a whole scene.
    pub(super) is_change: bool,
    pub(super) faults: Vec<Fault>,
    /// For each `section.key`, the place where it was set last.
    pub(super) places: HashMap<String, KeyPlace>,
    /// The names of laws in values that were refused. The sections of these laws are ignored.
    untaken: Vec<String>,
}

/// The place of a value: the index of its source, and its bytes in the text of the source.
#[derive(Clone, Default)]
pub(super) struct KeyPlace {
    pub(super) source: usize,
    pub(super) span: Range<usize>,
}

impl<'s, 't> Reader<'s, 't> {
    /// Reads all sources into `scene`, one after the other. If a source is the file of a whole scene, `scene` is first
    /// replaced by the base of this file.
    fn over(scene: Scene, is_change: bool, sources: &'s [SceneText<'t>]) -> Self {
        let mut reader = Self::new(scene, is_change, sources);
        for source in 0..sources.len() {
            reader.source = source;
            reader.document();
        }
        reader
    }

    /// Changes `scene` by the settings in `table`, a table in the text of `source`.
    pub(in crate::scene) fn changed(
        scene: Scene,
        source: &SceneText,
        table: &DeTable,
    ) -> Result<Scene> {
        let mut reader = Reader::new(scene, true, std::slice::from_ref(source));
        reader.table(table);
        reader.resolved()
    }

    /// A reader at the beginning of its sources. [`over`](Self::over) makes it and then reads all sources.
    fn new(scene: Scene, is_change: bool, sources: &'s [SceneText<'t>]) -> Self {
        Reader {
            sources,
            source: 0,
            scene,
            is_change,
            faults: Vec::new(),
            places: HashMap::new(),
            untaken: Vec::new(),
        }
    }

    /// Reads the truss that the scene names, unless errors were found already. Returns the scene, or the errors found.
    fn resolved(mut self) -> Result<Scene> {
        if self.faults.is_empty() {
            let folder = self.folder("lattice.file");
            self.scene.lattice.file.resolve(&folder)?;
            self.leave_to_truss();
        }
        self.finished()
    }

    /// A source that names a truss takes the lattice from it: what the base says about a generated lattice does not count.
    fn leave_to_truss(&mut self) {
        let is_set = |key: &str| self.places.contains_key(key);
        if !is_set("lattice.file") || !self.scene.lattice.is_truss() {
            return;
        }
        let (lattice, default) = (&mut self.scene.lattice, LatticeSettings::default());
        if !is_set("lattice.kind") {
            lattice.kind = default.kind;
        }
        if !is_set("lattice.payload") {
            lattice.payload = default.payload;
            self.scene.auto.remove("lattice.payload");
        }
    }

    /// Computes the settings that follow from the others, and checks for settings that contradict one another. Returns
    /// the scene, or the errors found.
    fn finished(mut self) -> Result<Scene> {
        if self.faults.is_empty() && !self.sources.is_empty() {
            self.conflicts(checks::size(&self.scene));
        }
        if self.faults.is_empty() && !self.sources.is_empty() {
            self.follow();
            self.conflicts(checks::conflicts(&self.scene));
        }
        if self.faults.is_empty() {
            return Ok(self.scene);
        }
        (self.faults).sort_by_key(|fault| (fault.source, fault.span.start));
        Err(malformed(self.sources, self.faults))
    }

    pub(super) fn fault(&mut self, span: Range<usize>, message: String, allowed: String) {
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
            let allowed = "write SECTION.KEY=VALUE, for example physics.gravity=9.81";
            return self.fault(0..text.len(), message, allowed.to_owned());
        }
        let document = match parsed(self.source, *file, text) {
            Ok(document) => document,
            Err(fault) => {
                let fault = self.of_value(&fault).unwrap_or(fault);
                return self.faults.push(fault);
            }
        };
        let keys = keys_below(document.get_ref());
        if file.is_none() && keys > 1 {
            let message = format!("a setting sets one key, and this one sets {keys}");
            let allowed = "write each key as a setting for itself";
            return self.fault(0..text.len(), message, allowed.to_owned());
        }
        self.table(document.get_ref());
    }

    /// A better fault for a text that is not TOML because the value of a key is missing or has no quotes: what the key
    /// allows. `None` for other texts.
    fn of_value(&self, fault: &Fault) -> Option<Fault> {
        let SceneText { file, text } = &self.sources[self.source];
        let start = text
            .get(..fault.span.start)?
            .rfind('\n')
            .map_or(0, |end| end + 1);
        let line = text[start..].lines().next()?;
        let (key, value) = line.split_once('=')?;
        let written = value.trim();
        if written.contains(['"', '\'', '[', '{', '#', '\\', '=']) {
            return None;
        }
        let at = start + key.len() + 1 + (value.len() - value.trim_start().len());
        let span = at..at + written.len();
        // What comes below may be wrong, too.
        let quoted = format!("{}\"{written}\"", &text[..at]);
        let quoted = [SceneText {
            file: *file,
            text: quoted.into(),
        }];
        let reader = Reader::over(self.scene.clone(), self.is_change, &quoted);
        let is_there = |other: &&Fault| other.span.start == at;
        let (message, allowed) = match reader.faults.iter().find(is_there) {
            Some(other) => {
                let key = other.message.split('`').nth(1)?;
                let says = match written {
                    "" => "has no value".to_owned(),
                    _ => format!("cannot be {}", abridged(written)),
                };
                (format!("`{key}` {says}"), other.allowed.clone())
            }
            None if reader.faults.is_empty() && !written.is_empty() => (
                format!("the word {} has no quotes", abridged(written)),
                format!("write \"{written}\""),
            ),
            None => return None,
        };
        Some(Fault {
            source: self.source,
            span,
            message,
            allowed,
        })
    }

    /// Reads the sections of a table. If the table is a whole scene, also reads the keys above the sections.
    fn table(&mut self, table: &DeTable) {
        let is_complete = match self.begin(table) {
            Ok(is_complete) => is_complete,
            Err(fault) => return self.faults.push(fault),
        };
        // The section `physics` is read first, because the laws that it names decide which other sections exist.
        let sections = table.iter();
        let sections = sections.filter(|(name, _)| !TOP_KEYS.contains(&&**name.get_ref()));
        let (first, then): (Vec<_>, Vec<_>) =
            sections.partition(|(name, _)| name.get_ref() == "physics");
        for (name, value) in first.into_iter().chain(then) {
            self.section(name.get_ref(), name.span(), value);
        }
        if is_complete {
            self.complete();
        }
    }

    fn section(&mut self, name: &str, span: Range<usize>, value: &Spanned<DeValue>) {
        let known = sections(&mut self.scene);
        if known.iter().all(|section| section.name != name) {
            if self.untaken.iter().any(|law| law == name) {
                return;
            }
            if let Some(remedy) = self.scene.registry().choosing(name) {
                let message = format!("the scene does not choose the law `{name}`");
                return self.fault(span, message, remedy);
            }
            let owner = known.iter().find(|section| section.keys.contains(&name));
            let path = owner.map(|owner| format!("did you mean `{}.{name}`?", owner.name));
            let names = known.iter().map(|section| section.name);
            let hint = path.unwrap_or_else(|| suggest(name, names.chain(TOP_KEYS)));
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
                Some(_) => self.key(path, value),
                None => self.unknown_key(name, key.get_ref(), key.span()),
            }
        }
    }

    /// Reads the value of a key of the scene.
    fn key(&mut self, path: String, value: &Spanned<DeValue>) {
        let forces = (path == "physics.forces").then(|| self.scene.physics.forces.clone());
        let Some(field) = self.scene.field(&path) else {
            return;
        };
        let is_auto = !field.auto.is_empty() && value.get_ref().as_str() == Some(AUTO);
        if is_auto {
            self.scene.auto.insert(path.clone());
        } else if let Err(misfit) = field.value.read(value, &field.limits) {
            let allowed = format!("allowed: {}", field.allowed());
            self.misfit(&path, value, misfit, allowed);
        }
        if !is_auto {
            self.scene.auto.remove(&path);
        }
        if let Some(before) = forces {
            self.scene.let_new_laws_follow(&before);
        }
        self.place(path, value);
    }

    /// Notes that the current source sets the key `path` by `value`.
    pub(super) fn place(&mut self, path: String, value: &Spanned<DeValue>) {
        let (source, span) = (self.source, value.span());
        self.places.insert(path, KeyPlace { source, span });
    }

    /// Records an error for a value that `path`, the key, does not allow.
    pub(super) fn misfit(
        &mut self,
        path: &str,
        value: &Spanned<DeValue>,
        misfit: Misfit,
        allowed: String,
    ) {
        if LAW_KEYS.contains(&path) {
            self.untaken.extend(words(value));
        }
        let Misfit { span, says } = misfit;
        let text = &self.sources[self.source].text;
        let written = text.get(span.clone()).unwrap_or_default();
        let message = format!("`{path}` {says} {}", abridged(written));
        let point = with_decimal_point(written);
        let point = point.map(|number| format!("; use a decimal point: {number}"));
        self.fault(span, message, allowed + &point.unwrap_or_default());
    }

    /// The folder of the file that set a key last. For a key that the command line set, this is the working directory.
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
}

/// The keys that choose laws. If a law has settings, the scene has a section with the name of the law.
const LAW_KEYS: [&str; 2] = ["physics.contact", "physics.forces"];

/// Returns the string in a value, or all strings if the value is an array.
fn words(value: &Spanned<DeValue>) -> Vec<String> {
    let entries = value.get_ref().as_array();
    let entries = entries.map_or(vec![value], |entries| entries.iter().collect());
    let words = entries
        .into_iter()
        .filter_map(|entry| entry.get_ref().as_str());
    words.map(str::to_owned).collect()
}

/// The first line of a text, cut off if it is long.
pub(super) fn abridged(written: &str) -> String {
    const LONGEST: usize = 40;
    let line = written.lines().next().unwrap_or_default();
    let short: String = line.chars().take(LONGEST).collect();
    if short.len() < written.len() {
        short + "..."
    } else {
        short
    }
}
