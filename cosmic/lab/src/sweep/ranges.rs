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

#[cfg(test)]
mod tests {
    use super::{in_ranges, parse_ranges};

    #[test]
    fn ranges_read_back() {
        for (numbers, text) in [
            (vec![3, 4, 5, 40], "3-5,40"),
            (vec![0, 2, 3], "0,2-3"),
            (vec![7], "7"),
        ] {
            assert_eq!(in_ranges(&numbers), text);
            let read = parse_ranges(text).unwrap();
            assert_eq!(read.into_iter().flatten().collect::<Vec<_>>(), numbers);
        }
        assert_eq!(in_ranges(&[]), "");
    }

    #[test]
    fn malformed_ranges_are_refused() {
        for text in ["", "3-", "-1", "5-3", "1,,2", "+1", "1 2", "a"] {
            assert_eq!(parse_ranges(text), None, "{text}");
        }
    }
}
