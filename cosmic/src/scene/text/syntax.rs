//! Parses TOML, and says what is wrong with a text that is not TOML.

use crate::reading::{ESCAPE, names_sign, not_a_frame, typographic_minus, with_decimal_point};
use crate::scene::diagnostic::Fault;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeTable;

/// Parses `text` as TOML. `source` is the index of its source and `file` the name of its file, for the error.
pub(super) fn parsed<'d>(
    source: usize,
    file: Option<&str>,
    text: &'d str,
) -> Result<Spanned<DeTable<'d>>, Fault> {
    let fault = |span: Range<usize>, message: String, allowed: String| Fault {
        source,
        span,
        message,
        allowed,
    };
    DeTable::parse(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        if let Some((span, number)) = decimal_comma(text, span.start) {
            let message = format!("`{}` is not a number", &text[span.clone()]);
            return fault(span, message, format!("use a decimal point: {number}"));
        }
        if let Some((span, number)) = typographic_minus(text, span.start) {
            let message = names_sign(&text[span.clone()]);
            return fault(span, message, format!("write {number}"));
        }
        if error.message() == "duplicate key"
            && let Some(line) = line_of_first(text, &span)
        {
            let message = format!("`{}` is there twice", &text[span.clone()]);
            return fault(
                span,
                message,
                format!("also in line {line}: remove one of them"),
            );
        }
        let message = format!("not TOML: {}", error.message().replace('\n', ", "));
        let allowed = if text.trim_start().starts_with('{') {
            "this is JSON; a scene is TOML, and `optimize --from` takes a run or its design.json"
        } else if let Some(remedy) = file.and_then(not_a_frame) {
            remedy
        } else if ["escape", "unicode"]
            .iter()
            .any(|word| message.contains(word))
        {
            ESCAPE
        } else {
            ""
        };
        fault(span, message, allowed.to_owned())
    })
}

/// The line in which a key begins that the text has again at `second`; `None` if it is not clear. It is the last earlier
/// line with this word without which the text has no such key twice.
fn line_of_first(text: &str, second: &Range<usize>) -> Option<usize> {
    let word = text.get(second.clone())?;
    let end = text[..second.start].rfind('\n').map_or(0, |end| end + 1);
    let mut starts = vec![0];
    starts.extend(text[..end].match_indices('\n').map(|(at, _)| at + 1));
    starts.retain(|at| *at < end);
    let is_it = |k: &usize| {
        let line = text[starts[*k]..].lines().next().unwrap_or_default();
        if !line.contains(word) {
            return false;
        }
        let span = starts[*k]..starts[*k] + line.len();
        let mut without = text.to_owned();
        without.replace_range(span.clone(), &" ".repeat(span.len()));
        !DeTable::parse(&without).is_err_and(|error| {
            error.message() == "duplicate key" && error.span().as_ref() == Some(second)
        })
    };
    (0..starts.len()).rev().find(is_it).map(|k| k + 1)
}

/// Finds the number around the decimal comma at byte `comma` of a text. Returns the place of the number, and the number
/// with a decimal point.
fn decimal_comma(text: &str, comma: usize) -> Option<(Range<usize>, String)> {
    let (before, after) = text.split_at_checked(comma)?;
    let is_part = |c: char| c.is_ascii_alphanumeric() || "+-.,".contains(c);
    let start = before.trim_end_matches(is_part).len();
    let end = text.len() - after.trim_start_matches(is_part).len();
    let number = with_decimal_point(&text[start..end])?;
    Some((start..end, number))
}
