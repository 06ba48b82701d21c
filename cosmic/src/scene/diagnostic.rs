//! Faults in a scene file, shown with line, column and caret.

use crate::error::Error;
use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};
use std::ops::Range;

/// Faults shown in full; a file that is no scene at all can have thousands.
const SHOWN: usize = 10;

/// One thing wrong with a scene file.
pub(super) struct Fault {
    /// The bytes to point at.
    pub(super) span: Range<usize>,
    /// What is wrong, with the value.
    pub(super) message: String,
    /// What is allowed there, or a hint; may be empty.
    pub(super) allowed: String,
}

/// The error for one or more faults of a file.
pub(super) fn malformed(file: &str, source: &str, mut faults: Vec<Fault>) -> Error {
    faults.sort_by_key(|fault| fault.span.start);
    let mut report: Vec<_> = faults
        .iter()
        .take(SHOWN)
        .map(|fault| show(file, source, fault))
        .collect();
    if faults.len() > SHOWN {
        report.push(format!("... and {} more", faults.len() - SHOWN));
    }
    let first = faults.first();
    let (line, column) = position(source, first.map_or(0, |fault| fault.span.start));
    Error::Malformed {
        file: file.to_string(),
        line,
        column,
        message: first.map_or(String::new(), |fault| fault.message.clone()),
        report: report.join("\n\n"),
    }
}

/// One fault over its source line.
fn show(file: &str, source: &str, fault: &Fault) -> String {
    let annotation = AnnotationKind::Primary.span(fault.span.clone());
    let annotation = if fault.allowed.is_empty() {
        annotation
    } else {
        annotation.label(fault.allowed.as_str())
    };
    let snippet = Snippet::source(source).path(file).annotation(annotation);
    let report = [Level::ERROR
        .primary_title(fault.message.as_str())
        .element(snippet)];
    Renderer::plain().render(&report)
}

/// Line and column of a byte, both from 1, the column in characters.
fn position(source: &str, byte: usize) -> (usize, usize) {
    let before = source.get(..byte).unwrap_or(source);
    let line = before.rsplit('\n').next().unwrap_or(before);
    (before.matches('\n').count() + 1, line.chars().count() + 1)
}

/// The error for a file that is not text, at the first byte that is none.
pub(super) fn not_text(file: &str, bytes: &[u8]) -> Error {
    let text = String::from_utf8_lossy(bytes);
    let valid = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
    let (line, column) = position(&text, valid.len());
    let byte = bytes.get(valid.len()).copied().unwrap_or_default();
    let message = format!("the byte 0x{byte:02x} is not UTF-8 text");
    let place = format!("{file}:{line}:{column}");
    let report = format!("error: {message}\n --> {place}\n  = allowed: a scene is UTF-8 text");
    Error::Malformed {
        file: file.to_string(),
        line,
        column,
        message,
        report,
    }
}
