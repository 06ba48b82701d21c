//! Errors in the text of a scene, shown with line, column and caret.

use crate::error::Error;
use crate::reading::Position;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::borrow::Cow;
use std::ops::Range;

/// The largest number of errors that one report shows. A file that is not a scene can have thousands.
const SHOWN: usize = 10;

/// The command-line option that sets a key of a scene, as it is written before `KEY=VALUE`.
const OPTION: &str = "--set ";

/// A source: a text that sets keys of a scene. It is a file or an option `--set KEY=VALUE` of the command line.
pub(super) struct SceneText<'t> {
    /// The name of the file; `None` for an option.
    pub(super) file: Option<&'t str>,
    /// The text as TOML.
    pub(super) text: Cow<'t, str>,
}

impl<'t> SceneText<'t> {
    pub(super) fn file(name: &'t str, text: &'t str) -> Self {
        SceneText {
            file: Some(name),
            text: text.into(),
        }
    }

    /// Makes a source from the argument of `--set`. A word or a path needs no quotes: `physics.contact=coulomb`.
    pub(super) fn option(setting: &'t str) -> Self {
        let is_word = |value: &str| {
            // Paths need these signs: the folders of a sweep have names such as `tiny+friction=0.6-0`.
            let letters = |c: char| c.is_alphanumeric() || "_-./+=,~".contains(c);
            let begins = value.starts_with(char::is_alphabetic);
            let is_path = ["/", "./", "../"]
                .iter()
                .any(|begin| value.starts_with(begin));
            (begins || is_path)
                && value.chars().all(letters)
                && !["true", "false", "nan", "inf"].contains(&value)
        };
        let text = match setting.split_once('=') {
            Some((key, value)) if is_word(value.trim()) => {
                format!("{key}=\"{}\"", value.trim()).into()
            }
            _ => setting.into(),
        };
        SceneText { file: None, text }
    }
}

/// An error in a source of a scene.
pub(super) struct Fault {
    /// The index of the source in the list of sources.
    pub(super) source: usize,
    /// The bytes of the text that the caret points at.
    pub(super) span: Range<usize>,
    /// The problem in a sentence, with the wrong value.
    pub(super) message: String,
    /// The allowed values, or a hint. May be empty.
    pub(super) allowed: String,
}

/// A hint for a misspelt name: the known name that is most similar, or all known names if none is similar.
pub(super) fn suggest<'n>(wrong: &str, known: impl Iterator<Item = &'n str> + Clone) -> String {
    /// Names that differ by one or two typing errors have a Jaro-Winkler similarity above this number.
    const CLOSE: f64 = 0.8;
    let rate = |name: &&'n str| strsim::jaro_winkler(wrong, name);
    let best = known.clone().max_by(|a, b| rate(a).total_cmp(&rate(b)));
    match best.filter(|name| rate(name) > CLOSE) {
        Some(name) => format!("did you mean `{name}`?"),
        None if best.is_none() => "none is defined".to_owned(),
        None => format!("known: {}", known.collect::<Vec<_>>().join(", ")),
    }
}

/// Joins all faults to one error. Its report shows them in the order of the sources.
pub(super) fn malformed(sources: &[SceneText], mut faults: Vec<Fault>) -> Error {
    faults.sort_by_key(|fault| (fault.source, fault.span.start));
    let shown = faults.iter().take(SHOWN);
    let mut report: Vec<_> = shown
        .map(|fault| show(&sources[fault.source], fault))
        .collect();
    if faults.len() > SHOWN {
        report.push(format!("... and {} more", faults.len() - SHOWN));
    }
    let first = faults.swap_remove(0);
    let source = &sources[first.source];
    let before = source.text.get(..first.span.start);
    let Position { line, column } = Position::after(before.unwrap_or(&source.text));
    Error::Malformed {
        file: source.file.unwrap_or(OPTION.trim()).to_string(),
        line,
        column,
        message: first.message,
        allowed: first.allowed,
        report: report.join("\n\n"),
    }
}

/// The report of one fault: the message, and the source line with a caret. A fault in an option shows the option as the
/// user wrote it, without file and line.
fn show(source: &SceneText, fault: &Fault) -> String {
    let given = source.file.map_or(OPTION, |_| "");
    let text = format!("{given}{}", source.text);
    let span = fault.span.start + given.len()..fault.span.end + given.len();
    let mut annotation = AnnotationKind::Primary.span(span);
    if !fault.allowed.is_empty() {
        annotation = annotation.label(fault.allowed.as_str());
    }
    let snippet = Snippet::source(text.as_str()).path(source.file);
    let report = [Level::ERROR
        .primary_title(fault.message.as_str())
        .element(snippet.annotation(annotation))];
    Renderer::plain().render(&report)
}
