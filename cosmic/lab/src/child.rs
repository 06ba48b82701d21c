//! Child processes.

/// The last line of a failed child's standard error, which usually gives the reason.
pub(crate) fn reason(error: &[u8]) -> String {
    let text = String::from_utf8_lossy(error);
    let last = text.lines().rev().find(|line| !line.trim().is_empty());
    last.unwrap_or("it failed without a message").to_owned()
}
