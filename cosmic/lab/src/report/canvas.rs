//! A moment of a walk as a picture of pixels.

use super::lettering::lettered;
use super::motion::{Motion, PAYLOAD, SKELETON, View};
use cosmic::geometry::{Bounds, Range, Segment, Vector};
use tiny_skia::{Color, LineCap, LineJoin, Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Colour of the ticks on the ground.
pub(super) const TICK: [u8; 3] = [0x99; 3];
/// Height of the picture in the world, in widths of the lattice.
const HEIGHTS: f64 = 1.6;
/// Pixels beyond the edges of a picture at which longer lines end: more than the width of any line.
const MARGIN: f64 = 64.0;
/// The most ticks across a picture.
const MOST_TICKS: f64 = 100.0;

/// Where a picture stands in an animation: the state of a motion, and a label, which may be empty.
pub(super) struct Shot<'m> {
    pub(super) motion: &'m Motion<'m>,
    pub(super) index: usize,
    pub(super) label: String,
}

/// The size of a picture, pixels.
#[derive(Clone, Copy)]
pub(super) struct Size {
    pub(super) width: u16,
    pub(super) height: u16,
}

/// A picture under construction, of a width and a height in pixels.
struct Canvas<'m> {
    motion: &'m Motion<'m>,
    size: Vector<f64>,
    pixels: Pixmap,
    view: View,
}

impl Shot<'_> {
    /// The picture, of a width and a height in pixels; `None` if there is no memory for it.
    pub(super) fn draw(&self, Size { width, height }: Size) -> Option<Pixmap> {
        let mut pixels = Pixmap::new(width.into(), height.into())?;
        pixels.fill(Color::WHITE);
        let (motion, size) = (self.motion, Vector::new([width, height]).map(f64::from));
        let [width, height] = size.array();
        let x = motion.camera(self.index).forward();
        let view = View {
            // In the middle of the lower third.
            corner: Vector::new([x, motion.floor(x)]),
            origin: Vector::new([0.5 * width, 0.78 * height]),
            scale: height / (HEIGHTS * motion.robot.lattice.side()),
        };
        let mut canvas = Canvas {
            motion,
            size,
            pixels,
            view,
        };
        canvas.draw_ground();
        canvas.draw_robot(self.index);
        let corner = Vector::new([0.05 * height, 0.1 * height]);
        canvas.letter(&self.label, corner, 10.0);
        Some(canvas.pixels)
    }
}

impl Canvas<'_> {
    /// A length that is so many pixels in a picture of 240 rows.
    fn pixels(&self, length: f64) -> f64 {
        length * self.size.up() / 240.0
    }

    fn draw_robot(&mut self, index: usize) {
        let motion = self.motion;
        self.line(&motion.path()[..=index], PAYLOAD, 1.2);
        let state = &motion.states()[index];
        for bar in motion.bars(state) {
            let width = if bar.actuator { 3.4 } else { 2.4 };
            self.line(&[bar.line.from, bar.line.to], bar.colour, width);
        }
        // A short line with round ends is a dot.
        let place = state.x[0];
        let beside = place + Vector::new([1e-4, 0.0]);
        self.line(&[place, beside], PAYLOAD, 9.0);
    }

    /// Text that begins at a point of the picture, of a height in pixels of a picture of 240 rows.
    fn letter(&mut self, text: &str, corner: Vector<f64>, height: f64) {
        for stroke in lettered(text, corner, self.pixels(height)) {
            self.stroke(&stroke, SKELETON, 0.14 * height);
        }
    }

    /// Ticks stand at every tenth of a metre along the ground from where the payload begins, longer ones at
    /// whole metres; if these are too many, they are farther apart by powers of ten.
    fn draw_ground(&mut self) {
        let half = 0.5 * self.size.forward() / self.view.scale;
        let motion = self.motion;
        let middle = self.view.corner.forward();
        let across = Range::new(middle, middle).widened(half);
        let line = motion.ground_line(across);
        let per_metre = 10f64.powf((MOST_TICKS / (2.0 * half)).log10().floor().min(1.0));
        // Along the ground, as displacements are measured.
        let cos = motion.ground().tangent().forward();
        let start = motion.states()[0].x[0].forward();
        let Range { low, high } = across.map(|x| per_metre * (x - start) / cos);
        let ticks = low.ceil() as i64..=high.floor() as i64;
        for k in ticks {
            let x = start + cos * k as f64 / per_metre;
            let length = self.pixels(if k % 10 == 0 { 14.0 } else { 5.0 }) / self.view.scale;
            let top = Vector::new([x, motion.ground_height(x)]);
            let bottom = top - Vector::new([0.0, length]);
            self.line(&[top, bottom], TICK, 1.0);
            if k % 10 == 0 {
                let metres = format!("{} m", k as f64 / per_metre);
                let beside = Vector::new([self.pixels(4.0), 0.0]);
                self.letter(&metres, self.view.place(bottom) + beside, 7.0);
            }
        }
        self.line(&line, SKELETON, 1.6);
    }

    /// A line through points of the world; its width is in pixels of a picture of 240 rows.
    fn line(&mut self, points: &[Vector<f64>], colour: [u8; 3], width: f64) {
        let points: Vec<Vector<f64>> = points.iter().map(|point| self.view.place(*point)).collect();
        self.stroke(&points, colour, width);
    }

    /// A line through points of the picture.
    fn stroke(&mut self, points: &[Vector<f64>], [r, g, b]: [u8; 3], width: f64) {
        // The rasteriser has no room for lines that end far away.
        let picture = Bounds {
            low: Vector::zero(),
            high: self.size,
        };
        let picture = picture.widened(MARGIN);
        let mut path = PathBuilder::new();
        let mut end = None;
        for pair in points.windows(2) {
            let line = Segment::new(pair[0], pair[1]);
            let Some(line) = line.within(&picture) else {
                continue;
            };
            if end != Some(line.from) {
                let [x, y] = line.from.map(|x| x as f32).array();
                path.move_to(x, y);
            }
            let [x, y] = line.to.map(|x| x as f32).array();
            path.line_to(x, y);
            end = Some(line.to);
        }
        // A path of one point, or of points that are not finite, has nothing to draw.
        let Some(path) = path.finish() else { return };
        let mut paint = Paint::default();
        paint.set_color_rgba8(r, g, b, 255);
        let stroke = Stroke {
            width: self.pixels(width) as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        self.pixels
            .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }
}
