//! Formatting of numbers for people, and escaping of texts for HTML, SVG and CSV.

/// Formats a number with `places` decimals and a typographic minus sign. A number that rounds to zero has no sign.
pub fn decimals(x: f64, places: usize) -> String {
    let text = format!("{x:.places$}");
    let is_zero = text.chars().all(|c| "-0.".contains(c));
    text.replace('-', if is_zero { "" } else { "\u{2212}" })
}

/// Formats a number for programs to read, with at most `places` decimals, without an exponent and without trailing
/// zeros.
pub fn plain(x: f64, places: usize) -> String {
    let text = format!("{x:.places$}");
    let text = match text.split_once('.') {
        Some(_) => text.trim_end_matches('0').trim_end_matches('.'),
        None => &text,
    };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Formats a duration in seconds as minutes and seconds, with hours if there are any.
pub fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match hours {
        0 => format!("{minutes}:{seconds:02}"),
        _ => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}

/// Formats a number with three significant digits.
pub(super) fn three_digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !x.is_finite() {
        return "failed".to_owned();
    }
    if !(0.01..1e4).contains(&x.abs()) {
        return format!("{x:.1e}");
    }
    let digits = 2 - x.abs().log10().floor() as i32;
    let text = format!("{x:.*}", digits.max(0) as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Escapes the special characters of HTML and SVG in a text.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Converts a text to HTML. A passage between two backticks is marked as code.
pub fn prose(text: &str) -> String {
    let mut html = String::new();
    let mut rest = text;
    while let Some((before, (code, after))) = rest
        .split_once('`')
        .and_then(|(before, after)| Some((before, after.split_once('`')?)))
    {
        html += &format!("{}<code>{}</code>", escape(before), escape(code));
        rest = after;
    }
    html + &escape(rest)
}

/// Writes a text as a cell of CSV: in quotes if it contains a comma, a quote or a line break.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
