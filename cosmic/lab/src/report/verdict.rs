//! Verdicts as HTML.

use crate::table::escape;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::judge::verdict::{Item, Verdict};
use cosmic::lattice::Lattice;
use cosmic::outcome::Summary;
use cosmic::record::run::read_scene;
use std::path::Path;

/// Returns a verdict as a paragraph of HTML. Every item has the colour of its level.
pub(super) fn to_html(verdict: &Verdict) -> String {
    let hints = match &verdict.hints[..] {
        [] => String::new(),
        hints => format!("<p>What to try: {}.</p>\n", escape(&hints.join("; "))),
    };
    format!(
        "<p class=\"verdict {}\">{}</p>\n{hints}",
        verdict.level().name(),
        line(verdict)
    )
}

/// Returns a verdict as a line of HTML.
pub(super) fn line(verdict: &Verdict) -> String {
    let item = |Item { text, level, .. }: &Item| {
        format!("<span class=\"{}\">{}</span>", level.name(), escape(text))
    };
    verdict.line(item)
}

/// Returns the verdict on the robot of a finished run.
///
/// # Errors
/// The errors of reading the run's scene.
pub fn verdict_of(folder: &Path, summary: &Summary, registry: &Registry) -> Result<Verdict> {
    let scene = read_scene(folder, registry)?;
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    Ok(summary.measured(&scene, &lattice).verdict())
}
