//! The gait as an animated GIF.

use std::io::{self, Write};

use gif::{Encoder, Frame, Repeat};
use tiny_skia::{
    Color, LineCap, Paint, PathBuilder, Pixmap, PremultipliedColorU8, Stroke, Transform,
};

use super::motion::{Motion, PAYLOAD, SKELETON};

const SIZE: [u16; 2] = [480, 240];
/// Colour of the marks on the ground.
const TICK: [u8; 3] = [0x99; 3];
/// Width of the picture in the world, in widths of the lattice.
const WIDTHS: f64 = 3.2;
/// Seconds of the rollout from one frame to the next, and hundredths of a second it is shown.
const FRAME: (f64, u16) = (0.1, 5);

/// Writes the whole rollout, twice as fast as it happens, the camera beside the robot. Ticks on
/// the ground stand every tenth of a metre, longer every whole one.
///
/// # Errors
/// What writing to `file` reports.
pub(super) fn write(motion: &Motion, file: &mut dyn Write) -> io::Result<()> {
    let palette = Palette::new(motion);
    let mut encoder = Encoder::new(file, SIZE[0], SIZE[1], palette.shades.as_flattened())
        .map_err(io::Error::other)?;
    encoder
        .set_repeat(Repeat::Infinite)
        .map_err(io::Error::other)?;
    let frames = (motion.duration() / FRAME.0) as usize;
    for k in 0..=frames {
        let index = motion.index_at(FRAME.0 * k as f64);
        let Some(picture) = Picture::new(motion, index) else {
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

/// The colours of the picture in eight shades from white, and the nearest of them to any colour.
struct Palette {
    shades: Vec<[u8; 3]>,
    /// By the upper five bits of red, green and blue.
    nearest: Vec<u8>,
}

impl Palette {
    fn new(motion: &Motion) -> Self {
        let strains = (-13..=13).map(|k| motion.colour(f64::from(k) / 13.0 * motion.limit()));
        let colours = strains.chain([SKELETON, PAYLOAD, TICK]);
        let shade = |c: [u8; 3], k: u16| c.map(|c| 255 - ((255 - u16::from(c)) * k / 8) as u8);
        let mut shades: Vec<[u8; 3]> = colours
            .flat_map(|colour| (1..=8).map(move |k| shade(colour, k)))
            .collect();
        shades.push([255; 3]);
        let middle = |bits: usize| (8 * (bits % 32) + 4) as i32;
        let nearest = |bits: usize| {
            let wanted = [bits / 1024, bits / 32, bits].map(middle);
            let off = |i: &usize| -> i32 {
                (0..3)
                    .map(|k| (i32::from(shades[*i][k]) - wanted[k]).pow(2))
                    .sum()
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
struct Picture<'m> {
    motion: &'m Motion<'m>,
    index: usize,
    pixels: Pixmap,
    /// The world's point in the middle of the lower third.
    camera: [f64; 2],
    scale: f64,
}

impl<'m> Picture<'m> {
    /// None if there is no memory for it.
    fn new(motion: &'m Motion<'m>, index: usize) -> Option<Self> {
        let mut pixels = Pixmap::new(SIZE[0].into(), SIZE[1].into())?;
        pixels.fill(Color::WHITE);
        let lattice = &motion.run.scene.lattice;
        let side = lattice.columns.max(lattice.rows) as f64 * lattice.spacing;
        let [x, _] = motion.camera(index);
        Some(Self {
            camera: [x, motion.ground_height(x)],
            scale: f64::from(SIZE[0]) / (WIDTHS * side),
            motion,
            index,
            pixels,
        })
    }

    fn place(&self, [x, y]: [f64; 2]) -> [f32; 2] {
        let across = 0.5 * f64::from(SIZE[0]) + (x - self.camera[0]) * self.scale;
        let down = 0.78 * f64::from(SIZE[1]) - (y - self.camera[1]) * self.scale;
        [across as f32, down as f32]
    }

    /// A line through points of the world.
    fn stroke(&mut self, points: &[[f64; 2]], ([r, g, b], width): ([u8; 3], f32)) {
        let mut path = PathBuilder::new();
        for (k, &point) in points.iter().enumerate() {
            let [x, y] = self.place(point);
            if k == 0 {
                path.move_to(x, y)
            } else {
                path.line_to(x, y)
            }
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
    fn draw(mut self, palette: &Palette) -> Vec<u8> {
        self.draw_ground();
        let path = self.motion.path();
        self.stroke(&path[..=self.index], (PAYLOAD, 1.2));
        let state = &self.motion.states()[self.index];
        for bar in self.motion.bars(state) {
            let width = if bar.actuator { 3.4 } else { 2.4 };
            self.stroke(&[bar.from, bar.to], (bar.colour, width));
        }
        // A short line with round ends is a dot.
        let [x, y] = state.x[0];
        self.stroke(&[[x, y], [x + 1e-4, y]], (PAYLOAD, 9.0));
        self.pixels
            .pixels()
            .iter()
            .map(|p| palette.index(p))
            .collect()
    }

    fn draw_ground(&mut self) {
        let half = 0.5 * f64::from(SIZE[0]) / self.scale;
        let height = |x| self.motion.ground_height(x);
        let ends = [self.camera[0] - half, self.camera[0] + half];
        let line = ends.map(|x| [x, height(x)]);
        let ticks = (10.0 * ends[0]).ceil() as i64..=(10.0 * ends[1]).floor() as i64;
        let pixel = 1.0 / self.scale;
        let ticks: Vec<_> = ticks
            .map(|k| {
                let (x, length) = (k as f64 / 10.0, if k % 10 == 0 { 14.0 } else { 5.0 });
                [[x, height(x)], [x, height(x) - length * pixel]]
            })
            .collect();
        for tick in ticks {
            self.stroke(&tick, (TICK, 1.0));
        }
        self.stroke(&line, (SKELETON, 1.6));
    }
}
