//! Numbers as text for people. Lines of the terminal, tables and pages format their numbers here.

/// The number if it is finite, otherwise `None`.
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// A number with `places` decimals. A number that rounds to zero has no sign. The minus sign is that of the keyboard, so
/// that people can paste the number into a scene or a command.
pub fn fixed(x: f64, places: usize) -> String {
    let text = format!("{x:.places$}");
    let is_zero = text.chars().all(|c| "-0.".contains(c));
    match text.strip_prefix('-') {
        Some(zero) if is_zero => zero.to_owned(),
        _ => text,
    }
}

/// A number for programs to read, with at most `places` decimals, without an exponent and without trailing zeros.
pub fn plain(x: f64, places: usize) -> String {
    let text = fixed(x, places);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// The number that `x` is with `digits` significant digits.
pub fn rounded(x: f64, digits: usize) -> f64 {
    let text = format!("{x:.*e}", digits - 1);
    text.parse().unwrap_or(x)
}

/// The value of a setting as text, with at most five significant digits of every number.
pub fn shortened(value: &str) -> String {
    let ends = ['[', ']', ',', ' '];
    let shortened = |part: &str| {
        let text = part.trim_end_matches(ends);
        match text.parse() {
            Ok(x) if text.len() > 7 => part.replacen(text, &rounded(x, 5).to_string(), 1),
            _ => part.to_owned(),
        }
    };
    value.split_inclusive(ends).map(shortened).collect()
}

/// A number with two significant digits, or as a whole number from 10 on.
pub fn brief(x: f64) -> String {
    if x == 0.0 {
        // Without the sign of a negative zero.
        return "0".to_owned();
    }
    if !x.is_finite() {
        return format!("{x}");
    }
    // From 9.95 on, one decimal would round to 10.0.
    let digits = 1 - (x.abs() * 1.005).log10().floor() as i32;
    format!("{x:.*}", digits.clamp(0, 12) as usize)
}

/// A number with three significant digits, without trailing zeros. From 1000 on it is a whole number. Below 0.01 and from
/// 1e4 on it has two significant digits and an exponent.
pub fn short(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !(0.01..1e4).contains(&x.abs()) {
        return format!("{x:.1e}");
    }
    let digits = 2 - x.abs().log10().floor() as i32;
    plain(x, digits.max(0) as usize)
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    format!("{} %", brief(100.0 * share))
}

/// A mass: in grams below 100 g.
pub fn mass(kg: f64) -> String {
    match kg {
        kg if kg < 0.0995 => format!("{} g", brief(1e3 * kg)),
        kg => format!("{} kg", brief(kg)),
    }
}

/// A count with its noun, such as "1 run" or "2 runs".
pub fn counted(count: usize, thing: &str) -> String {
    match count {
        1 => format!("1 {thing}"),
        _ => format!("{count} {thing}s"),
    }
}

/// A duration in seconds as minutes and seconds, with hours if there are any.
pub fn clock(seconds: f64) -> String {
    let seconds = seconds.round() as u64;
    let (hours, minutes, seconds) = (seconds / 3600, seconds / 60 % 60, seconds % 60);
    match hours {
        0 => format!("{minutes}:{seconds:02}"),
        _ => format!("{hours}:{minutes:02}:{seconds:02}"),
    }
}
