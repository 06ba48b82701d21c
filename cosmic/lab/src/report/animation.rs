//! Rollouts as animations: a GIF, or a film that ffmpeg encodes.

use std::fs;
use std::io::{self, Write};
use std::process::{Child, Command, Stdio};
use std::thread;

use cosmic::error::{Error, Result};
use cosmic::geometry::{Range, Vector};
use cosmic::record::TrajectoryFile;
use cosmic::verdict::SKELETON_STRAINS;
use gif::{Encoder, Frame, Repeat};
use tiny_skia::{Pixmap, PremultipliedColorU8};

use super::files::RobotFiles;
use super::motion::{BEYOND, Motion, PAYLOAD, SKELETON, strained, strained_skeleton};
use super::picture::{Colour, PAPER, Picture};
use super::view::{EARTH, GOAL, MARK, View, label};
use crate::child;
use crate::table::decimals;

/// The width and height of a [`frame`] in pixels. `GIF_SIZE` and `FILM_SIZE` are the sizes of a GIF and of a film.
const FRAME_SIZE: [u16; 2] = [480, 240];
const GIF_SIZE: [u16; 2] = [800, 334];
const FILM_SIZE: [u16; 2] = [1600, 668];
/// The width of a [`frame`] in pixels.
pub const FRAME_WIDTH: usize = FRAME_SIZE[0] as usize;

/// The height of the picture of a frame, in the picture's own units. The picture is then scaled to the size of the
/// animation in pixels.
const ROWS: f64 = 240.0;
/// The height of the part of the world that a frame shows, as a multiple of the lattice's side.
const SIDES: f64 = 1.6;
/// Where the ground is, as a fraction of the frame's height from its upper edge.
const GROUND: f64 = 0.78;
/// The fraction of the frame's height that stays free above the robot.
const ABOVE: f64 = 0.1;

/// The pace of an animation: the time between two frames (`every`, in seconds), and the largest number of frames
/// (`most`). A rollout that needs more frames is shown faster.
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
/// How many seconds the last frame is shown.
const STAYS: f64 = 1.0;

/// A frame of an animation, not yet drawn: a state of a motion and a label. The label may be empty.
pub(super) struct Shot<'m> {
    motion: &'m Motion<'m>,
    index: usize,
    label: String,
}

/// Returns the frames of the first `seconds` seconds of a rollout. The label of each frame is the text `says`, then the
/// time, the distance travelled in metres and, for robots that take goals, the place of the goal in metres.
pub(super) fn shots<'m>(
    motion: &'m Motion<'m>,
    pace: Pace,
    seconds: f64,
    says: &str,
) -> Vec<Shot<'m>> {
    let every = pace.every.max(motion.duration().min(seconds) / pace.most);
    let along = |index: usize| {
        motion
            .ground()
            .along(motion.payload(&motion.states()[index]))
    };
    let shot = |index: usize| {
        let [time, metres] = [(motion.time(index), 1), (along(index) - along(0), 2)]
            .map(|(x, digits)| decimals(x, digits));
        let goal = motion.flag(index).map_or(String::new(), |flag| {
            format!("   to {} m", decimals(flag.along, 2))
        });
        let label = format!("{says}{time} s   {metres} m{goal}").replace('\u{2212}', "-");
        Shot {
            motion,
            index,
            label,
        }
    };
    let (_, moments) = motion.every(every);
    let moments = moments.into_iter();
    let within = moments.take_while(|index| motion.time(*index) <= seconds);
    within.map(shot).collect()
}

impl Shot<'_> {
    /// Draws the frame as pixels. Returns `None` if memory is short.
    fn draw(&self, size: [u16; 2]) -> Option<Pixmap> {
        let (motion, state) = (self.motion, &self.motion.states()[self.index]);
        let scale = f64::from(size[1]) / ROWS;
        let width = f64::from(size[0]) / scale;
        let x = motion.camera(self.index).forward();
        let height = SIDES * motion.robot.lattice.side();
        // The camera rises with a robot that jumps out of the frame.
        let jump = motion.top(self.index) - (GROUND - ABOVE) * height;
        let view = View {
            motion,
            // The ground below the robot appears in the lower part of the frame, in the middle of its width.
            corner: Vector::new([x, motion.floor(x).max(jump)]),
            origin: Vector::new([0.5 * width, GROUND * ROWS]),
            scale: ROWS / height,
        };
        let mut picture = Picture::default();
        let across = Range::new(x, x).widened(0.5 * width / view.scale);
        view.draw_ground(&mut picture, across);
        view.draw_marks(&mut picture, across);
        if let Some(flag) = motion.flag(self.index) {
            view.draw_flag(&mut picture, flag.foot, width);
        }
        view.draw_path(&mut picture, &motion.path()[..=self.index]);
        view.draw_robot(&mut picture, &motion.bars(state), motion.payload(state));
        picture.text([12.0, 24.0], &self.label[..], label(14.0));
        picture.to_pixels([width, ROWS], scale)
    }
}

/// Writes shots as a GIF at the pace [`GIF`].
///
/// # Errors
/// Errors of writing to `file`.
pub(super) fn write_gif(shots: &[Shot], file: &mut dyn Write) -> io::Result<()> {
    let palette = Palette::new();
    let [width, height] = GIF_SIZE;
    let mut encoder = Encoder::new(file, width, height, palette.shades.as_flattened())
        .map_err(io::Error::other)?;
    let endless = encoder.set_repeat(Repeat::Infinite);
    endless.map_err(io::Error::other)?;
    let pictures = shots.iter().map_while(|shot| shot.draw(GIF_SIZE));
    for (k, picture) in pictures.enumerate() {
        let is_last = k + 1 == shots.len();
        let seconds = if is_last { STAYS } else { GIF.every };
        let pixels = picture.pixels().iter();
        let frame = Frame {
            width,
            height,
            delay: (100.0 * seconds).round() as u16,
            buffer: pixels.map(|pixel| palette.index(pixel)).collect(),
            ..Frame::default()
        };
        encoder.write_frame(&frame).map_err(io::Error::other)?;
    }
    Ok(())
}

/// Encodes shots with ffmpeg as an MP4 film at the pace [`FILM`].
///
/// [`Error::Read`] if ffmpeg is not on the path or fails. If it fails, the error contains ffmpeg's message.
pub(super) fn film(shots: &[Shot]) -> Result<Vec<u8>> {
    let failed = |error| Error::reading("ffmpeg's film")(error);
    let folder = tempfile::tempdir().map_err(failed)?;
    let path = folder.path().join("film.mp4");
    let [width, height] = FILM_SIZE;
    let rate = 1.0 / FILM.every;
    let input = format!("-f rawvideo -pix_fmt rgba -s {width}x{height} -r {rate} -i -");
    // Players need the pixel format yuv420p, and the index at the beginning of the file.
    let output = "-f mp4 -pix_fmt yuv420p -movflags +faststart";
    let options = format!("-y -loglevel error {input} {output}");
    let child = Command::new("ffmpeg")
        .args(options.split(' '))
        .arg(&path)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    let child = child.map_err(|error| {
        let says = format!("{error}; a film needs ffmpeg on the path: install it, or use --gif");
        Error::reading("ffmpeg")(io::Error::other(says))
    })?;
    feed(child, shots)
        .and_then(|()| fs::read(&path))
        .map_err(failed)
}

/// Draws the frames and writes them to ffmpeg. Waits until ffmpeg has ended.
fn feed(mut ffmpeg: Child, shots: &[Shot]) -> io::Result<()> {
    let mut input = ffmpeg.stdin.take();
    let output = thread::spawn(move || ffmpeg.wait_with_output());
    let mut write = |frame: Pixmap| input.as_mut()?.write_all(frame.data()).ok();
    let frames = shots.iter().map_while(|shot| shot.draw(FILM_SIZE));
    // If ffmpeg stops reading, its standard error says why, so errors of writing are ignored here.
    let _all_written = frames.map(&mut write).all(|written| written.is_some());
    drop(input);
    let output = output.join().expect("waiting for a child does not panic")?;
    if output.status.success() {
        return Ok(());
    }
    let says = child::reason(&output.stderr);
    Err(io::Error::other(format!("ffmpeg: {says}")))
}

/// Draws one state of a rollout. Returns 240 rows of 480 pixels: the top row comes first, and each row runs from left
/// to right. A pixel is three bytes: red, green, blue. Returns `None` if memory is short.
///
/// # Panics
/// If the trajectory has no state `index`.
pub fn frame(robot: &RobotFiles, trajectory: &TrajectoryFile, index: usize) -> Option<Vec<u8>> {
    let motion = &Motion::new(robot, trajectory);
    let label = String::new();
    let shot = Shot {
        motion,
        index,
        label,
    };
    let drawn = shot.draw(FRAME_SIZE)?;
    Some(drawn.pixels().iter().flat_map(rgb).collect())
}

fn rgb(pixel: &PremultipliedColorU8) -> [u8; 3] {
    [pixel.red(), pixel.green(), pixel.blue()]
}

/// The number of shades between white and a colour. With fewer, edges look rough; with more, files become large.
const SHADES: u16 = 4;

/// The colour table of a GIF: all colours that frames use, each in many shades.
struct Palette {
    shades: Vec<[u8; 3]>,
    /// For every colour, the index of the nearest shade. Two colours count as equal if the upper five bits of their
    /// red, green and blue agree.
    nearest: Vec<u8>,
}

impl Palette {
    fn new() -> Self {
        let strains = (-6..=6).map(|k| strained(f64::from(k) / 6.0));
        let [sound, doubtful] = SKELETON_STRAINS;
        let between = |k: i32| sound + f64::from(k) / 4.0 * (doubtful - sound);
        let skeleton = (1..4).map(|k| strained_skeleton(between(k)));
        let colours = strains.chain(skeleton);
        let colours = colours.chain([SKELETON, PAYLOAD, MARK, BEYOND, GOAL]);
        let shade = |colour: Colour, k: u16| PAPER.mixed(colour, f64::from(k) / f64::from(SHADES));
        let shades = colours.flat_map(|colour| (1..=SHADES).map(move |k| shade(colour, k)));
        let shades = shades.chain([PAPER, EARTH]);
        let shades: Vec<[u8; 3]> = shades.map(|shade| shade.rgb).collect();
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
        let [r, g, b] = rgb(pixel);
        let bits = |c: u8| usize::from(c / 8);
        self.nearest[1024 * bits(r) + 32 * bits(g) + bits(b)]
    }
}
