//! Moves arrays of a step from the memory of a workgroup to a buffer, if they do not fit.

/// The arrays in the order in which they are moved: those that a step reads or writes least come first.
const ORDER: [&str; 7] = [
    "kept",
    "parameter_bar",
    "carry",
    "parameter",
    "row_bar",
    "row",
    "scratch",
];

/// The arrays that are moved, with their lengths.
pub(super) struct Spill<'a>(Vec<(&'a str, usize)>);

impl<'a> Spill<'a> {
    /// Chooses the arrays to move, so that the others fit into `memory` bytes.
    pub(super) fn new(arrays: &[(&'a str, usize)], memory: usize) -> Self {
        let mut spill = Self(Vec::new());
        for name in ORDER {
            if spill.left(arrays) <= memory {
                break;
            }
            let moved = arrays.iter().find(|(known, _)| *known == name);
            spill.0.extend(moved);
        }
        spill
    }

    /// Whether an array is moved.
    pub(super) fn has(&self, name: &str) -> bool {
        self.0.iter().any(|(known, _)| *known == name)
    }

    /// The memory, in bytes, of those of these arrays that are not moved.
    pub(super) fn left(&self, arrays: &[(&str, usize)]) -> usize {
        let kept = arrays.iter().filter(|(name, _)| !self.has(name));
        kept.map(|(_, len)| 4 * len.max(&1)).sum()
    }

    /// How many numbers are moved.
    pub(super) fn len(&self) -> usize {
        self.0.iter().map(|(_, len)| len).sum()
    }

    /// The text of entry points with the moved arrays.
    pub(super) fn moved(&self, text: &str) -> String {
        if self.0.is_empty() {
            return text.to_owned();
        }
        let mut text = text.replace(
            "workgroupBarrier();",
            "storageBarrier();\nworkgroupBarrier();",
        );
        text = text.replace(
            "let own_at = ",
            &format!(
                "let spilled_at = member * {}u;\n    let own_at = ",
                self.len()
            ),
        );
        let mut start = 0;
        for (name, len) in &self.0 {
            text = replaced(&text, name, &format!("spilled[spilled_at + {start}u + "));
            start += len;
        }
        text
    }
}

/// Replaces the beginning `name[` of each access to an array by `access`.
fn replaced(text: &str, name: &str, access: &str) -> String {
    let pattern = format!("{name}[");
    let mut parts = text.split(&pattern);
    let mut result = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        // The name may be the end of another one.
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        match result.ends_with(is_word) {
            true => result += &pattern,
            false => result += access,
        }
        result += part;
    }
    result
}
