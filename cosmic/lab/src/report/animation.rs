//! A rollout as an animation: a GIF. It has no text: the page of the run shows times and distances.

use std::io::{self, Write};

use cosmic::geometry::{Range, Vector};
use cosmic::judge::verdict::SKELETON_STRAINS;
use cosmic::record::TrajectoryFile;
use gif::{Encoder, Frame, Repeat};
use tiny_skia::{Pixmap, PremultipliedColorU8};

use super::eye::Eye;
use super::files::RobotFiles;
use super::motion::{BEYOND, DrawnMotion, PAYLOAD, SKELETON, strained, strained_skeleton};
use super::picture::{Colour, PAPER, Picture};
use super::view::{EARTH, GOAL, MARK, SHADOW, View};

/// The width and height of a [`frame`] in pixels. `GIF_SIZE` is the size of a GIF.
const FRAME_SIZE: [u16; 2] = [480, 240];
const GIF_SIZE: [u16; 2] = [800, 334];
/// The width of a [`frame`] in pixels.
pub const FRAME_WIDTH: usize = FRAME_SIZE[0] as usize;

/// The height of the picture of a frame, in the picture's own units. The picture is then scaled to the size of the
/// animation in pixels.
const ROWS: f64 = 240.0;
/// The height of the part of the world that a frame shows, as a multiple of the lattice's side.
const SIDES: f64 = 1.6;
/// Where the ground is, as a fraction of the frame's height from its upper edge.
const GROUND: f64 = 0.78;
/// How much higher the ground is in a view from above, as a fraction of the frame's height.
const LIFTED: f64 = 0.3;
/// The fraction of the frame's height that stays free above the robot.
const ABOVE: f64 = 0.1;

/// The time between two frames of a GIF, in seconds, and the largest number of frames. A rollout that needs more frames
/// is shown faster.
const EVERY: f64 = 0.08;
const MOST: f64 = 250.0;
/// How many seconds the last frame is shown.
const STAYS: f64 = 1.0;

/// Draws the state `index` of a motion as pixels. Returns `None` if memory is short.
fn draw(motion: &DrawnMotion, index: usize, size: [u16; 2]) -> Option<Pixmap> {
    let state = &motion.states()[index];
    let scale = f64::from(size[1]) / ROWS;
    let width = f64::from(size[0]) / scale;
    let camera = motion.camera(index);
    let x = camera.forward();
    let height = SIDES * motion.robot.lattice.side();
    let eye = Eye::of(motion.robot.lattice.dimension);
    let ground = GROUND - LIFTED * eye.tilt();
    // The camera rises with a robot that jumps out of the frame.
    let jump = motion.top(index) - (ground - ABOVE) * height / eye.flat();
    let view = View {
        motion,
        eye,
        // The ground below the robot appears in the lower part of the frame, in the middle of its width.
        corner: camera.with_up(motion.floor(x).max(jump)),
        origin: Vector::from([0.5 * width, ground * ROWS]),
        scale: ROWS / height,
    };
    let mut picture = Picture::default();
    let half = 0.5 * width / view.scale;
    let across = Range::new(x, x).widened(half);
    view.draw_floor(&mut picture, across, (camera.sideways(), half));
    if !motion.in_space() {
        view.draw_marks(&mut picture, across);
    }
    if let Some(flag) = motion.flag(index) {
        view.draw_flag(&mut picture, flag.foot, width);
    }
    view.draw_path(&mut picture, &motion.path()[..=index]);
    view.draw_robot(&mut picture, &motion.bars(state), motion.payload(state));
    picture.to_pixels([width, ROWS], scale)
}

/// Writes a motion as a GIF.
///
/// # Errors
/// Errors of writing to `file`.
pub(super) fn write_gif(motion: &DrawnMotion, file: &mut dyn Write) -> io::Result<()> {
    let palette = Palette::new();
    let [width, height] = GIF_SIZE;
    let mut encoder = Encoder::new(file, width, height, palette.shades.as_flattened())
        .map_err(io::Error::other)?;
    let endless = encoder.set_repeat(Repeat::Infinite);
    endless.map_err(io::Error::other)?;
    let (_, shown) = motion.every(EVERY.max(motion.duration() / MOST));
    let pictures = (shown.iter()).map_while(|&index| draw(motion, index, GIF_SIZE));
    for (k, picture) in pictures.enumerate() {
        let is_last = k + 1 == shown.len();
        let seconds = if is_last { STAYS } else { EVERY };
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

/// Draws one state of a rollout. Returns 240 rows of 480 pixels: the top row comes first, and each row runs from left
/// to right. A pixel is three bytes: red, green, blue. Returns `None` if memory is short.
///
/// # Panics
/// If the trajectory has no state `index`.
pub fn frame(robot: &RobotFiles, trajectory: &TrajectoryFile, index: usize) -> Option<Vec<u8>> {
    let drawn = draw(&DrawnMotion::new(robot, trajectory), index, FRAME_SIZE)?;
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
        let shades = shades.chain([PAPER, EARTH, SHADOW]);
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
