//! Reads whole files. A limit protects from sources that never end, such as `/dev/zero`. Also reads JSON: errors name
//! the key and the place of the wrong value.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::value::RawValue;

use crate::error::{Error, Result};

/// The largest number of bytes that are read from a source without a known size, such as a pipe. It is enough for a
/// hundred designs of the paper's size.
const STREAM: u64 = 1 << 26;

/// The byte order mark that some editors put before a text. It is ignored.
pub const MARK: &str = "\u{feff}";

/// Reads all bytes of a regular file, or up to 64 MiB of a pipe or a device.
///
/// # Errors
/// [`Error::Read`], and [`Error::Usage`] for a stream with more bytes.
pub fn read_whole(path: &Path) -> Result<Vec<u8>> {
    let regular = path.metadata().is_ok_and(|about| about.is_file());
    read_at_most(path, if regular { u64::MAX } else { STREAM })
}

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// [`Error::Read`], and [`Error::Usage`] for a longer file.
pub(crate) fn read_at_most(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = |file: File| file.take(most.saturating_add(1)).read_to_end(&mut bytes);
    let length = File::open(path)
        .and_then(read)
        .map_err(Error::reading(path))?;
    if length as u64 > most {
        let path = path.display();
        return Err(Error::Usage(format!(
            "{path}: the file is too long; at most {most} bytes are read"
        )));
    }
    Ok(bytes)
}

/// Reads a value from JSON text, which may be a part of a file. Messages name `file`. `lines` is the number of lines of
/// the file before the text, so that messages have the line numbers of the file.
///
/// # Errors
/// [`Error::Malformed`] with the line, the column and the keys of the wrong value.
pub fn from_json<T: DeserializeOwned>(file: &str, lines: usize, json: &[u8]) -> Result<T> {
    let json = decoded(file, lines, json)?;
    let json = json.strip_prefix(MARK).unwrap_or(json).as_bytes();
    let refused = |keys: &str, error: &serde_json::Error| {
        let (place, message) = fault(json, keys, error);
        let message = match not_a_frame(file) {
            Some(remedy) if message == NOT_JSON => format!("{NOT_JSON}; {remedy}"),
            _ => message,
        };
        let line = lines + place.line;
        malformed(file, Position { line, ..place }, &message)
    };
    let mut from = serde_json::Deserializer::from_slice(json);
    let value = serde_path_to_error::deserialize(&mut from).map_err(|error| {
        let keys = error.path().to_string();
        refused(&keys, &error.into_inner())
    })?;
    let end = from.end().map_err(|error| refused(ROOT, &error));
    end.map(|()| value)
}

/// The message for a text that does not begin as JSON of this project does.
const NOT_JSON: &str = "this is not JSON";

/// For the name of a file in a format in which other programs write frames: what this project reads instead.
pub(crate) fn not_a_frame(file: &str) -> Option<&'static str> {
    let format = Path::new(file).extension()?.to_str()?.to_ascii_lowercase();
    ["obj", "csv"].contains(&&format[..]).then_some(
        "a scene is TOML, and its `lattice.file` names a JSON file with `nodes` and `edges`; ten lines of Python in \
         docs/extending.md, under Lattices, make one from OBJ or CSV",
    )
}

/// The text of a file, or of the part of a file that begins after `lines` lines. Refuses zero bytes, which a crash of the
/// machine can leave in place of the end of a file, and text in UTF-16 or UTF-32, which editors and shells of Windows
/// write. Such text begins with a byte order mark, or with a letter of ASCII in two or four bytes.
fn decoded<'b>(file: &str, lines: usize, bytes: &'b [u8]) -> Result<&'b str> {
    let refused = |before: &str, says: &str| {
        let place = Position::after(before);
        let line = lines + place.line;
        Err(malformed(file, Position { line, ..place }, says))
    };
    let wide = "the file is UTF-16 or UTF-32 text; save it as UTF-8";
    if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] = *bytes {
        return refused("", wide);
    }
    // Most files have no zero byte. Blocks without an early end are searched with wide registers.
    let has_zero = |block: &[u8]| block.iter().fold(false, |found, byte| found | (*byte == 0));
    if bytes.chunks(256).any(has_zero) {
        let zero = bytes.iter().take_while(|byte| **byte != 0).count();
        let (before, rest) = bytes.split_at(zero);
        // Even in UTF-32, a text never has four zero bytes in a row.
        let is_cut =
            rest.windows(4).any(|four| four == [0; 4]) || rest.iter().all(|byte| *byte == 0);
        if is_cut {
            let says = "zero bytes begin here: the file is truncated or damaged";
            return refused(&String::from_utf8_lossy(before), says);
        }
    }
    if let [0, _, ..] | [_, 0, ..] = *bytes {
        return refused("", wide);
    }
    str::from_utf8(bytes).or_else(|_| {
        // Points at the first byte that is not UTF-8.
        let valid = bytes.utf8_chunks().next().map_or("", |chunk| chunk.valid());
        let byte = bytes.get(valid.len()).copied().unwrap_or_default();
        let says = format!("the byte 0x{byte:02x} is not UTF-8 text; save the file as UTF-8");
        refused(valid, &says)
    })
}

/// The text of a file. Messages name `file`.
///
/// # Errors
/// [`Error::Malformed`] for bytes that are not UTF-8, and for zero bytes.
pub fn text_of<'b>(file: &str, bytes: &'b [u8]) -> Result<&'b str> {
    decoded(file, 0, bytes)
}

/// Describes an error in a JSON text: its place and its message. `keys` is the path of the wrong value.
fn fault(json: &[u8], keys: &str, error: &serde_json::Error) -> (Position, String) {
    // serde_json reports column 0 for an empty text, but columns count from 1.
    let (line, column) = (error.line(), error.column().max(1));
    let place = Position { line, column };
    if json.trim_ascii().is_empty() {
        return (place, "the file is empty".to_owned());
    }
    // serde_json calls a number that the end of the text cuts off an invalid number.
    let is_cut_number = json.last().is_some_and(|last| b"-+.eE".contains(last))
        && error.to_string().starts_with("invalid number");
    if error.is_eof() || is_cut_number {
        let says = "the text ends too early: the file is truncated or damaged";
        return (place, with_keys(keys, says));
    }
    if let Some((column, says)) = wrong_sign(json, place).filter(|_| error.is_syntax()) {
        return (Position { line, column }, with_keys(keys, &says));
    }
    match not_finite(json, place).filter(|_| error.is_syntax()) {
        None if error.is_syntax() && !json.trim_ascii_start().starts_with(b"{") => {
            (place, NOT_JSON.to_owned())
        }
        None => (place, sentence(keys, error)),
        Some((column, word)) => {
            let says =
                format!("{word} is not a JSON number; write null for a number that is not finite");
            (Position { line, column }, with_keys(keys, &says))
        }
    }
}

/// If the word at `place` stands for a number that is not finite, such as `-Infinity`, returns the column of its first
/// letter, and the word.
fn not_finite(json: &[u8], place: Position) -> Option<(usize, &str)> {
    let line = json
        .split(|&byte| byte == b'\n')
        .nth(place.line.checked_sub(1)?)?;
    let is_part = |byte: &u8| byte.is_ascii_alphanumeric() || b"+-".contains(byte);
    let before = line.get(..place.column - 1)?;
    let start = before.iter().rposition(|byte| !is_part(byte));
    let start = start.map_or(0, |last| last + 1);
    let rest = &line[start..];
    let end = rest.iter().position(|byte| !is_part(byte));
    let word = str::from_utf8(&rest[..end.unwrap_or(rest.len())]).ok()?;
    let bare = word.trim_start_matches(['+', '-']).to_ascii_lowercase();
    let known = ["nan", "inf", "infinity"].contains(&bare.as_str());
    known.then_some((start + 1, word))
}

/// Replaces a decimal comma in a number by a decimal point: `9,81` becomes `9.81`. Returns `None` for text that is not
/// such a number.
pub fn with_decimal_point(text: &str) -> Option<String> {
    let text = text.trim().trim_matches(['"', '\'']);
    let (whole, rest) = text.split_once(',')?;
    let number = format!("{whole}.{rest}");
    let is_digit = |c: char| c.is_ascii_digit();
    let is_number = whole.ends_with(is_digit) && rest.starts_with(is_digit);
    (is_number && number.parse::<f64>().is_ok()).then_some(number)
}

/// The remedy for a path in which TOML reads a backslash as the beginning of an escape.
pub(crate) const ESCAPE: &str =
    "in double quotes, `\\` begins an escape; write a path in single quotes, or with /";

/// The signs that text programs put in place of the minus sign of a keyboard.
const TYPOGRAPHIC: [char; 4] = ['\u{2212}', '\u{2010}', '\u{2011}', '\u{2013}'];

/// Finds a number with a typographic minus sign around byte `place` of a text. Returns the bytes of the number, and the
/// number with the minus sign of the keyboard.
pub(crate) fn typographic_minus(text: &str, place: usize) -> Option<(Range<usize>, String)> {
    let (before, after) = text.split_at_checked(place)?;
    let is_part =
        |c: char| c.is_ascii_alphanumeric() || "+-.".contains(c) || TYPOGRAPHIC.contains(&c);
    let start = before.trim_end_matches(is_part).len();
    let end = text.len() - after.trim_start_matches(is_part).len();
    let number = text[start..end].replace(TYPOGRAPHIC, "-");
    let is_it = number != text[start..end] && number.parse::<f64>().is_ok();
    is_it.then_some((start..end, number))
}

/// Says why a word with a typographic minus sign is not a number.
pub(crate) fn names_sign(word: &str) -> String {
    let sign = word.chars().find(|c| TYPOGRAPHIC.contains(c));
    let sign = sign.map_or(0, u32::from);
    format!("`{word}` is not a number: its sign is the character U+{sign:04X}")
}

/// If the number at `place` of a JSON text has a typographic minus sign, returns the column of the number, and a sentence.
fn wrong_sign(json: &[u8], place: Position) -> Option<(usize, String)> {
    let line = str::from_utf8(json)
        .ok()?
        .lines()
        .nth(place.line.checked_sub(1)?)?;
    let at = (0..place.column)
        .rev()
        .find(|at| line.is_char_boundary(*at))?;
    let (span, number) = typographic_minus(line, at)?;
    let says = names_sign(&line[span.clone()]);
    Some((span.start + 1, format!("{says}; write {number}")))
}

/// Adds a line and a column to an error about a JSON text. The place is the beginning of a value: the first words in
/// backquotes in the error's message, such as `z[3]`, are taken as its path. If there is no such value, the error is
/// returned unchanged.
pub fn placed(file: &str, text: &str, error: Error) -> Error {
    let message = error.to_string();
    match message.split('`').nth(1).and_then(|keys| place(text, keys)) {
        Some(place) => {
            let named = message.strip_prefix(&format!("{file}: "));
            malformed(file, place, named.unwrap_or(&message))
        }
        None => error,
    }
}

/// A place in a text. Lines and columns count from 1. Columns are counted in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Position {
    pub(crate) line: usize,
    pub(crate) column: usize,
}

impl Position {
    /// The place right after the text `before`.
    pub(crate) fn after(before: &str) -> Self {
        let line = before.rsplit('\n').next().unwrap_or_default();
        Position {
            line: 1 + before.matches('\n').count(),
            column: 1 + line.chars().count(),
        }
    }
}

/// The place where a value of a JSON text begins; `None` if there is no such value. `keys` is the path of the value,
/// such as `z[3]`.
fn place(text: &str, keys: &str) -> Option<Position> {
    let text = text.strip_prefix(MARK).unwrap_or(text);
    let mut value: &RawValue = serde_json::from_str(text).ok()?;
    for key in keys.split(['.', '[']) {
        value = match key.strip_suffix(']') {
            None => parsed::<HashMap<String, &RawValue>>(value)?.remove(key)?,
            Some(index) => parsed::<Vec<&RawValue>>(value)?
                .into_iter()
                .nth(index.parse().ok()?)?,
        };
    }
    let before = &text[..value.get().as_ptr().addr() - text.as_ptr().addr()];
    Some(Position::after(before))
}

/// Parses the entries of an object or an array, but not the values of the entries.
fn parsed<'t, T: Deserialize<'t>>(value: &'t RawValue) -> Option<T> {
    serde_json::from_str(value.get()).ok()
}

/// The path by which `serde_path_to_error` refers to the whole value.
const ROOT: &str = ".";

/// Makes the message of an error: the path of the value, then the text of serde_json without the place at its end.
fn sentence(keys: &str, error: &serde_json::Error) -> String {
    let text = error.to_string();
    let what = text
        .rsplit_once(" at line ")
        .map_or(&text[..], |(what, _)| what);
    let what = match what.split_once(", expected ") {
        _ if what == "trailing characters" && keys != ROOT => "too many values".to_owned(),
        None if what == "number out of range" => {
            format!("{what}: the largest number is {:e}", f64::MAX)
        }
        Some((found, expected)) => format!("{found}, expected {}", in_words(expected)),
        None => what.to_owned(),
    };
    with_keys(keys, &what)
}

/// A message with the path of the value in front of it.
fn with_keys(keys: &str, what: &str) -> String {
    // If the text is truncated, the path ends with `?` for the key that was not read.
    let keys = keys.strip_suffix('?').unwrap_or(keys);
    match keys.strip_suffix('.').unwrap_or(keys) {
        "" | ROOT => what.to_owned(),
        keys => format!("`{keys}`: {what}"),
    }
}

/// Converts the name of a Rust type to words that a user understands.
pub(crate) fn in_words(expected: &str) -> &str {
    match expected {
        "usize" | "u64" | "u32" | "u8" => "a whole number from 0 on",
        "a nonzero usize" => "a whole number from 1 on",
        "f64" => "a number",
        "a sequence" => "a list",
        "a map" => "an object",
        name if name.starts_with("struct ") => "an object",
        other => other,
    }
}

/// An [`Error::Malformed`] with this message about a place in `file`.
pub(crate) fn malformed(file: &str, place: Position, message: &str) -> Error {
    let Position { line, column } = place;
    Error::Malformed {
        file: file.to_owned(),
        line,
        column,
        message: message.to_owned(),
        allowed: String::new(),
        report: format!("error: {message}\n --> {file}:{line}:{column}"),
    }
}
