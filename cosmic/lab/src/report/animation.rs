//! The gait as an animated GIF.

use std::io::{self, Write};

use cosmic::record::TrajectoryFile;
use gif::{Encoder, Frame, Repeat};
use tiny_skia::{
    Color, LineCap, Paint, PathBuilder, Pixmap, PremultipliedColorU8, Stroke, Transform,
};

use super::files::RobotFiles;
use super::motion::{Motion, PAYLOAD, SKELETON, View};

const SIZE: [u16; 2] = [480, 240];
/// The width of a [`frame`], pixels.
pub const FRAME_WIDTH: usize = SIZE[0] as usize;
/// Colour of the ticks on the ground.
const TICK: [u8; 3] = [0x99; 3];
/// Width of the picture in the world, in widths of the lattice.
const WIDTHS: f64 = 3.2;
/// Seconds of the rollout from one frame to the next, and hundredths of a second that a frame shows.
const FRAME: (f64, u16) = (0.1, 5);
/// Pixels beyond the edges of a picture at which longer lines end: more than the width of any line.
const BEYOND: f64 = 32.0;
/// The most ticks across a picture.
const MOST_TICKS: f64 = 100.0;

/// Writes the whole rollout at double speed, faster if it is long. The camera moves with the robot. Ticks
/// stand at every tenth of a metre along the ground, longer ones at whole metres; if these are too many,
/// they are farther apart by powers of ten.
///
/// # Errors
/// Errors of writing to `file`.
pub(super) fn write(motion: &Motion, file: &mut dyn Write) -> io::Result<()> {
    let palette = Palette::new(motion);
    let mut encoder = Encoder::new(file, SIZE[0], SIZE[1], palette.shades.as_flattened())
        .map_err(io::Error::other)?;
    encoder
        .set_repeat(Repeat::Infinite)
        .map_err(io::Error::other)?;
    let (_, moments) = motion.every(FRAME.0);
    let frames = moments.len() - 1;
    for (k, index) in moments.into_iter().enumerate() {
        let Some(picture) = Canvas::new(motion, index) else {
            break;
        };
        let frame = Frame {
            width: SIZE[0],
            height: SIZE[1],
            delay: if k == frames { 20 * FRAME.1 } else { FRAME.1 },
            buffer: picture.draw(&palette).into(),
            ..Frame::default()
        };
        encoder.write_frame(&frame).map_err(io::Error::other)?;
    }
    Ok(())
}

/// One moment of a rollout as a picture of 240 rows of 480 pixels, from the top left, with red, green and blue of
/// each. `None` if there is no memory for it.
///
/// # Panics
/// If the trajectory has no state of that index.
pub fn frame(robot: &RobotFiles, trajectory: &TrajectoryFile, index: usize) -> Option<Vec<u8>> {
    let motion = Motion::new(robot, trajectory);
    let drawn = Canvas::new(&motion, index)?.drawn();
    let pixels = drawn.pixels().iter();
    Some(
        pixels
            .flat_map(|p| [p.red(), p.green(), p.blue()])
            .collect(),
    )
}

/// The part of the segment inside the picture or a little beyond, or `None`.
/// The rasteriser has no room for lines that end far away.
fn within([from, to]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    // Shares of the way, by Liang and Barsky.
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for k in 0..2 {
        let way = to[k] - from[k];
        let bounds = [-BEYOND, f64::from(SIZE[k]) + BEYOND].map(|bound| bound - from[k]);
        if way == 0.0 && !(bounds[0]..=bounds[1]).contains(&0.0) {
            return None;
        }
        if way != 0.0 {
            let [one, other] = bounds.map(|bound| bound / way);
            first = first.max(one.min(other));
            last = last.min(one.max(other));
        }
    }
    // Held to the bounds: from far away their share is rounded.
    let at = |share: f64| {
        let along = |k: usize| from[k] + share * (to[k] - from[k]);
        [0, 1].map(|k| along(k).clamp(-BEYOND, f64::from(SIZE[k]) + BEYOND))
    };
    let ends = [
        if first > 0.0 { at(first) } else { from },
        if last < 1.0 { at(last) } else { to },
    ];
    let finite = ends.as_flattened().iter().all(|x| x.is_finite());
    (first <= last && finite).then_some(ends)
}

/// The colours of the picture in eight shades from white, and for any colour the nearest of them.
struct Palette {
    shades: Vec<[u8; 3]>,
    /// Indices of shades by the upper five bits of red, green and blue.
    nearest: Vec<u8>,
}

impl Palette {
    fn new(motion: &Motion) -> Self {
        let strains = (-13..=13).map(|k| motion.colour(f64::from(k) / 13.0 * motion.limit));
        let colours = strains.chain([SKELETON, PAYLOAD, TICK]);
        let shade = |c: [u8; 3], k: u16| c.map(|c| 255 - ((255 - u16::from(c)) * k / 8) as u8);
        let shades = colours.flat_map(|colour| (1..=8).map(move |k| shade(colour, k)));
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

/// One frame under construction.
struct Canvas<'m> {
    motion: &'m Motion<'m>,
    index: usize,
    pixels: Pixmap,
    view: View,
}

impl<'m> Canvas<'m> {
    /// `None` if there is no memory for it.
    fn new(motion: &'m Motion<'m>, index: usize) -> Option<Self> {
        let mut pixels = Pixmap::new(SIZE[0].into(), SIZE[1].into())?;
        pixels.fill(Color::WHITE);
        let side = motion.robot.lattice.side();
        let [x, _] = motion.camera(index);
        let view = View {
            // In the middle of the lower third.
            corner: [x, motion.floor(x)],
            origin: [0.5 * f64::from(SIZE[0]), 0.78 * f64::from(SIZE[1])],
            scale: f64::from(SIZE[0]) / (WIDTHS * side),
        };
        Some(Self {
            view,
            motion,
            index,
            pixels,
        })
    }

    /// A line through points of the world.
    fn stroke(&mut self, points: &[[f64; 2]], [r, g, b]: [u8; 3], width: f32) {
        let mut path = PathBuilder::new();
        let mut end = None;
        for pair in points.windows(2) {
            let Some([from, to]) = within([pair[0], pair[1]].map(|point| self.view.place(point)))
            else {
                continue;
            };
            if end != Some(from) {
                path.move_to(from[0] as f32, from[1] as f32);
            }
            path.line_to(to[0] as f32, to[1] as f32);
            end = Some(to);
        }
        // A path of one point, or of points that are not finite, has nothing to draw.
        let Some(path) = path.finish() else { return };
        let mut paint = Paint::default();
        paint.set_color_rgba8(r, g, b, 255);
        let stroke = Stroke {
            width,
            line_cap: LineCap::Round,
            ..Stroke::default()
        };
        self.pixels
            .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }

    /// The finished frame as indices into the palette.
    fn draw(self, palette: &Palette) -> Vec<u8> {
        let pixels = self.drawn();
        let pixels = pixels.pixels().iter();
        pixels.map(|pixel| palette.index(pixel)).collect()
    }

    /// The finished frame.
    fn drawn(mut self) -> Pixmap {
        self.draw_ground();
        let path = self.motion.path();
        self.stroke(&path[..=self.index], PAYLOAD, 1.2);
        let state = &self.motion.states()[self.index];
        for bar in self.motion.bars(state) {
            let width = if bar.actuator { 3.4 } else { 2.4 };
            self.stroke(&[bar.from, bar.to], bar.colour, width);
        }
        // A short line with round ends is a dot.
        let [x, y] = state.x[0];
        self.stroke(&[[x, y], [x + 1e-4, y]], PAYLOAD, 9.0);
        self.pixels
    }

    fn draw_ground(&mut self) {
        let half = 0.5 * f64::from(SIZE[0]) / self.view.scale;
        let motion = self.motion;
        let height = |x| motion.ground_height(x);
        let middle = self.view.corner[0];
        let ends = [middle - half, middle + half];
        let line = motion.ground_line(ends);
        let per_metre = 10f64.powf((MOST_TICKS / (2.0 * half)).log10().floor().min(1.0));
        // Along the ground, as displacements are measured.
        let [cos, _] = self.motion.ground().tangent();
        let [first, last] = ends.map(|x| per_metre * x / cos);
        let ticks = first.ceil() as i64..=last.floor() as i64;
        let pixel = 1.0 / self.view.scale;
        for k in ticks {
            let x = cos * k as f64 / per_metre;
            let length = if k % 10 == 0 { 14.0 } else { 5.0 };
            let tick = [[x, height(x)], [x, height(x) - length * pixel]];
            self.stroke(&tick, TICK, 1.0);
        }
        self.stroke(&line, SKELETON, 1.6);
    }
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    fn lines_end_where_the_picture_does() {
        let inside = [[10.0, 10.0], [400.0, 200.0]];
        assert_eq!(within(inside), Some(inside));
        // Across the picture's middle, from 32 pixels before its left edge to 32 behind its right.
        let [from, to] = within([[-1e9, 120.0], [1e9, 120.0]]).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        assert!(
            near(from[0], -32.0) && near(to[0], 512.0),
            "{from:?} {to:?}"
        );
        let [from, to] = within([[240.0, 120.0], [240.0, -1e12]]).unwrap();
        assert!(from == [240.0, 120.0] && near(to[1], -32.0), "{to:?}");
        let far = within([[-1e30, 120.0], [1e30, 120.0]]).unwrap();
        assert!(far.iter().all(|end| end[0].abs() <= 512.0), "{far:?}");
        assert_eq!(within([[-1e9, 0.0], [-1e8, 0.0]]), None);
        assert_eq!(within([[0.0, 1e9], [1e9, 1e9 + 1.0]]), None);
        assert_eq!(within([[f64::NAN, 0.0], [1.0, 1.0]]), None);
        assert_eq!(within([[0.0, 0.0], [f64::INFINITY, 1.0]]), None);
    }
}
