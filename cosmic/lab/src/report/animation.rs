//! Walks as animations: a GIF, or a film that ffmpeg encodes.

use std::fs;
use std::io::{self, Write};
use std::process::{Child, Command, Stdio};

use cosmic::error::{Error, Result};
use cosmic::record::TrajectoryFile;
use gif::{Encoder, Frame, Repeat};
use tiny_skia::PremultipliedColorU8;

use super::canvas::{Shot, Size, TICK};
use super::files::RobotFiles;
use super::motion::{BEYOND, Motion, PAYLOAD, SKELETON, strained};
use crate::child::Printing;
use crate::table::decimals;

/// Width and height of a [`frame`], of a GIF and of a film, pixels.
const FRAME_SIZE: Size = Size {
    width: 480,
    height: 240,
};
const GIF_SIZE: Size = Size {
    width: 800,
    height: 334,
};
const FILM_SIZE: Size = Size {
    width: 1600,
    height: 668,
};
/// The width of a [`frame`], pixels.
pub const FRAME_WIDTH: usize = FRAME_SIZE.width as usize;

/// Seconds from one picture to the next, and the most pictures of a walk; a longer one is shown faster.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    every: f64,
    most: f64,
}

pub(super) const GIF: Pace = Pace {
    every: 0.08,
    most: 250.0,
};
pub(super) const FILM: Pace = Pace {
    every: 0.04,
    most: 2000.0,
};
/// How long the last picture stays, s.
const STAYS: f64 = 1.0;

/// The shots of a walk from its start, for so many seconds at most; labels have the time and the metres along the
/// ground, after `says`.
pub(super) fn shots<'m>(
    motion: &'m Motion<'m>,
    pace: Pace,
    seconds: f64,
    says: &str,
) -> Vec<Shot<'m>> {
    let every = pace.every.max(motion.duration().min(seconds) / pace.most);
    let (_, moments) = motion.every(every);
    let along = |index: usize| {
        let payload = motion.states()[index].x[0];
        motion.ground().point_to_ground(payload).forward()
    };
    let shot = |index: usize| {
        let [time, metres] = [(motion.time(index), 1), (along(index) - along(0), 2)]
            .map(|(x, digits)| decimals(x, digits));
        let label = format!("{says}{time} s   {metres} m").replace('\u{2212}', "-");
        Shot {
            motion,
            index,
            label,
        }
    };
    let within = moments
        .into_iter()
        .take_while(|index| motion.time(*index) <= seconds);
    within.map(shot).collect()
}

/// Writes shots as a GIF in which each stays as long as the pace of a GIF says.
///
/// # Errors
/// Errors of writing to `file`.
pub(super) fn write_gif(shots: &[Shot], file: &mut dyn Write) -> io::Result<()> {
    let palette = Palette::new();
    let Size { width, height } = GIF_SIZE;
    let mut encoder = Encoder::new(file, width, height, palette.shades.as_flattened())
        .map_err(io::Error::other)?;
    encoder
        .set_repeat(Repeat::Infinite)
        .map_err(io::Error::other)?;
    let hundredths = |seconds: f64| (100.0 * seconds).round() as u16;
    for (k, shot) in shots.iter().enumerate() {
        let Some(picture) = shot.draw(GIF_SIZE) else {
            break;
        };
        let pixels = picture.pixels().iter();
        let stays = if k + 1 == shots.len() {
            STAYS
        } else {
            GIF.every
        };
        let frame = Frame {
            width,
            height,
            delay: hundredths(stays),
            buffer: pixels
                .map(|pixel| palette.index(pixel))
                .collect::<Vec<u8>>()
                .into(),
            ..Frame::default()
        };
        encoder.write_frame(&frame).map_err(io::Error::other)?;
    }
    Ok(())
}

/// Shots as a film, MP4, in which each stays as long as the pace of a film says; ffmpeg encodes it.
///
/// # Errors
/// [`Error::Read`] if there is no ffmpeg on the path, or with what it says if it fails.
pub(super) fn film(shots: &[Shot]) -> Result<Vec<u8>> {
    let failed = Error::reading("ffmpeg's film");
    let folder = match tempfile::tempdir() {
        Ok(folder) => folder,
        Err(error) => return Err(failed(error)),
    };
    let path = folder.path().join("film.mp4");
    let Size { width, height } = FILM_SIZE;
    let (size, rate) = (format!("{width}x{height}"), (1.0 / FILM.every).to_string());
    let given = [
        "-f", "rawvideo", "-pix_fmt", "rgba", "-s", &size, "-r", &rate, "-i", "-",
    ];
    // Players want this arrangement of colours, and the index at the beginning.
    let wanted = [
        "-f",
        "mp4",
        "-pix_fmt",
        "yuv420p",
        "-movflags",
        "+faststart",
    ];
    let child = Command::new("ffmpeg")
        .args(["-y", "-loglevel", "error"])
        .args(given)
        .args(wanted)
        .arg(&path)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let child = child.map_err(|error| {
        let says =
            format!("{error}; a film needs ffmpeg on the path: install it, or ask for --gif");
        Error::reading("ffmpeg")(io::Error::other(says))
    })?;
    feed(child, shots)
        .and_then(|()| fs::read(&path))
        .map_err(failed)
}

/// Hands the pictures over, and waits for the end.
fn feed(mut child: Child, shots: &[Shot]) -> io::Result<()> {
    let printing = Printing::of(&mut child);
    let mut pipe = child.stdin.take();
    let pictures = shots.iter().map_while(|shot| shot.draw(FILM_SIZE));
    // One that stops reading says why on its way out.
    for picture in pictures {
        if pipe
            .as_mut()
            .is_none_or(|pipe| pipe.write_all(picture.data()).is_err())
        {
            break;
        }
    }
    drop(pipe);
    let (printed, status) = (printing.end(), child.wait()?);
    if status.success() {
        return Ok(());
    }
    let says = printed.reason();
    Err(io::Error::other(format!("ffmpeg: {says}")))
}

/// One moment of a rollout as a picture of 240 rows of 480 pixels, from the top left, with red, green and blue of
/// each. `None` if there is no memory for it.
///
/// # Panics
/// If the trajectory has no state of that index.
pub fn frame(robot: &RobotFiles, trajectory: &TrajectoryFile, index: usize) -> Option<Vec<u8>> {
    let motion = &Motion::new(robot, trajectory);
    let label = String::new();
    let drawn = Shot {
        motion,
        index,
        label,
    }
    .draw(FRAME_SIZE)?;
    let pixels = drawn.pixels().iter();
    Some(
        pixels
            .flat_map(|p| [p.red(), p.green(), p.blue()])
            .collect(),
    )
}

/// Shades of a colour, on the way from white: fewer make edges rough, more make files large.
const SHADES: u16 = 4;

/// The colours of the picture in their shades from white, and for any colour the nearest of them.
struct Palette {
    shades: Vec<[u8; 3]>,
    /// Indices of shades by the upper five bits of red, green and blue.
    nearest: Vec<u8>,
}

impl Palette {
    fn new() -> Self {
        let strains = (-6..=6).map(|k| strained(f64::from(k) / 6.0));
        let colours = strains.chain([SKELETON, PAYLOAD, TICK, BEYOND]);
        let shade = |c: [u8; 3], k: u16| c.map(|c| 255 - ((255 - u16::from(c)) * k / SHADES) as u8);
        let shades = colours.flat_map(|colour| (1..=SHADES).map(move |k| shade(colour, k)));
        let shades: Vec<[u8; 3]> = shades.chain([[255; 3]]).collect();
        let middle = |bits: usize| (8 * (bits % 32) + 4) as i32;
        let nearest = |bits: usize| {
            let wanted = [bits / 1024, bits / 32, bits].map(middle);
            let off = |i: &usize| -> i32 {
                let square = |k: usize| (i32::from(shades[*i][k]) - wanted[k]).pow(2);
                (0..3).map(square).sum()
            };
            (0..shades.len()).min_by_key(off).unwrap_or(0) as u8
        };
        let nearest = (0..32 * 1024).map(nearest).collect();
        Self { shades, nearest }
    }

    fn index(&self, pixel: &PremultipliedColorU8) -> u8 {
        let bits = [pixel.red(), pixel.green(), pixel.blue()].map(|c| usize::from(c / 8));
        self.nearest[1024 * bits[0] + 32 * bits[1] + bits[2]]
    }
}
