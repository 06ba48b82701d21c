//! `cosmic report`.

use crate::arguments::Output;
use crate::output::{answer_written, note};
use clap::Args;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::record::Summary;
use cosmic_lab::report::{self, Animations, verdict_of};
use std::path::PathBuf;

/// Make a page, pictures and an animation of a finished run in its folder
///
/// The animation is gait.gif; with only --mp4 it is a film instead. RUN can also be a design without a run: a folder
/// with only design.json and scene.toml, or a design file with scene.toml beside it. Such a design gets no animation.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of the run, or the folder or file of a design
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Make an animated GIF, 800 pixels wide with at most 250 frames (the default)
    #[arg(long)]
    gif: bool,
    /// Make an MP4 film, 1600 pixels wide; needs ffmpeg on the path
    #[arg(long)]
    mp4: bool,
    /// Also make evolution.gif or evolution.mp4: the robot walking, from the first iteration to the last
    #[arg(long)]
    evolution: bool,
    #[command(flatten)]
    output: Output,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let animations = Animations {
            gif: self.gif,
            mp4: self.mp4,
            evolution: self.evolution,
        };
        let written = report::write(&self.run, &animations, registry)?;
        if !self.output.quiet && !self.output.json {
            self.note_verdict(registry);
        }
        answer_written(&self.output, &written)
    }

    /// Prints the verdict on standard error, if this is a run.
    fn note_verdict(&self, registry: &Registry) {
        if let Ok(summary) = Summary::read(&self.run)
            && let Ok(verdict) = verdict_of(&self.run, &summary, registry)
        {
            note(&format!("verdict: {}", verdict.to_text()));
        }
    }
}
