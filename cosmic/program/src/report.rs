//! `cosmic report`.

use crate::arguments::Output;
use crate::output::answer_written;
use clap::Args;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic_lab::report::{self, Animations};
use std::path::PathBuf;

/// Draw a finished run, or a design alone: a page and pictures in its folder, of a run an animation
///
/// The animation is gait.gif, unless --mp4 alone asks for a film in its place. A design alone is a folder
/// with design.json and scene.toml only, or a design's file with scene.toml beside it.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The run's folder, or a design's folder or file
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Animate as GIF: 800 pixels wide, at most 250 pictures (the default)
    #[arg(long)]
    gif: bool,
    /// Animate as a film, MP4, 1600 pixels wide; ffmpeg has to be on the path
    #[arg(long)]
    mp4: bool,
    /// Show as well, in evolution.gif or evolution.mp4, how the robot walks from the first iteration to the last
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
        answer_written(&self.output, &written)
    }
}
