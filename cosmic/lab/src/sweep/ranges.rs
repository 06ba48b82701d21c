//! Lists of run numbers as text, in the syntax of job arrays: `3-17,40`.

use std::fmt::Write;
use std::ops::RangeInclusive;

/// Writes ascending numbers as ranges, such as `3-17,40`. The text is empty if there are no numbers.
pub fn in_ranges(numbers: &[usize]) -> String {
    let mut text = String::new();
    for run in numbers.chunk_by(|a, b| a + 1 == *b) {
        if !text.is_empty() {
            text.push(',');
        }
        let (first, last) = (run[0], run[run.len() - 1]);
        let written = if first == last {
            write!(text, "{first}")
        } else {
            write!(text, "{first}-{last}")
        };
        written.expect("writing to a string cannot fail");
    }
    text
}

/// Reads ranges in the syntax of [`in_ranges`], in any order. Returns `None` for any other text.
pub fn parse_ranges(text: &str) -> Option<Vec<RangeInclusive<usize>>> {
    let range = |part: &str| {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last) = (number(first)?, number(last)?);
        (first <= last).then_some(first..=last)
    };
    text.split(',').map(range).collect()
}

/// Parses a number that consists of digits only. The standard parser would also accept a `+`.
fn number(text: &str) -> Option<usize> {
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    digits.then(|| text.parse().ok()).flatten()
}
