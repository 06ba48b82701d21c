//! A moment of a walk as a picture of pixels.

use super::lettering::lettered;
use super::motion::{Motion, PAYLOAD, SKELETON, View};
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

/// A picture under construction, of a width and a height in pixels.
struct Canvas<'m> {
    motion: &'m Motion<'m>,
    size: [f64; 2],
    pixels: Pixmap,
    view: View,
}

impl Shot<'_> {
    /// The picture, of a width and a height in pixels; `None` if there is no memory for it.
    pub(super) fn draw(&self, [width, height]: [u16; 2]) -> Option<Pixmap> {
        let mut pixels = Pixmap::new(width.into(), height.into())?;
        pixels.fill(Color::WHITE);
        let (motion, size) = (self.motion, [width, height].map(f64::from));
        let [x, _] = motion.camera(self.index);
        let view = View {
            // In the middle of the lower third.
            corner: [x, motion.floor(x)],
            origin: [0.5 * size[0], 0.78 * size[1]],
            scale: size[1] / (HEIGHTS * motion.robot.lattice.side()),
        };
        let mut canvas = Canvas {
            motion,
            size,
            pixels,
            view,
        };
        canvas.draw_ground();
        canvas.draw_robot(self.index);
        let corner = [0.05 * size[1], 0.1 * size[1]];
        canvas.letter(&self.label, corner, 10.0);
        Some(canvas.pixels)
    }
}

impl Canvas<'_> {
    /// A length that is so many pixels in a picture of 240 rows.
    fn pixels(&self, length: f64) -> f64 {
        length * self.size[1] / 240.0
    }

    fn draw_robot(&mut self, index: usize) {
        let motion = self.motion;
        self.line(&motion.path()[..=index], PAYLOAD, 1.2);
        let state = &motion.states()[index];
        for bar in motion.bars(state) {
            let width = if bar.actuator { 3.4 } else { 2.4 };
            self.line(&[bar.from, bar.to], bar.colour, width);
        }
        // A short line with round ends is a dot.
        let [x, y] = state.x[0];
        self.line(&[[x, y], [x + 1e-4, y]], PAYLOAD, 9.0);
    }

    /// Text that begins at a point of the picture, of a height in pixels of a picture of 240 rows.
    fn letter(&mut self, text: &str, corner: [f64; 2], height: f64) {
        for stroke in lettered(text, corner, self.pixels(height)) {
            self.stroke(&stroke, SKELETON, 0.14 * height);
        }
    }

    /// Ticks stand at every tenth of a metre along the ground from where the payload begins, longer ones at
    /// whole metres; if these are too many, they are farther apart by powers of ten.
    fn draw_ground(&mut self) {
        let half = 0.5 * self.size[0] / self.view.scale;
        let motion = self.motion;
        let middle = self.view.corner[0];
        let ends = [middle - half, middle + half];
        let line = motion.ground_line(ends);
        let per_metre = 10f64.powf((MOST_TICKS / (2.0 * half)).log10().floor().min(1.0));
        // Along the ground, as displacements are measured.
        let ([cos, _], start) = (motion.ground().tangent(), motion.states()[0].x[0][0]);
        let [first, last] = ends.map(|x| per_metre * (x - start) / cos);
        let ticks = first.ceil() as i64..=last.floor() as i64;
        for k in ticks {
            let x = start + cos * k as f64 / per_metre;
            let length = self.pixels(if k % 10 == 0 { 14.0 } else { 5.0 }) / self.view.scale;
            let height = motion.ground_height(x);
            self.line(&[[x, height], [x, height - length]], TICK, 1.0);
            if k % 10 == 0 {
                let metres = format!("{} m", k as f64 / per_metre);
                let [x, y] = self.view.place([x, height - length]);
                self.letter(&metres, [x + self.pixels(4.0), y], 7.0);
            }
        }
        self.line(&line, SKELETON, 1.6);
    }

    /// A line through points of the world; its width is in pixels of a picture of 240 rows.
    fn line(&mut self, points: &[[f64; 2]], colour: [u8; 3], width: f64) {
        let points: Vec<[f64; 2]> = points.iter().map(|point| self.view.place(*point)).collect();
        self.stroke(&points, colour, width);
    }

    /// A line through points of the picture.
    fn stroke(&mut self, points: &[[f64; 2]], [r, g, b]: [u8; 3], width: f64) {
        let mut path = PathBuilder::new();
        let mut end = None;
        for pair in points.windows(2) {
            let Some([from, to]) = within([pair[0], pair[1]], self.size) else {
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
            width: self.pixels(width) as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        self.pixels
            .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }
}

/// The part of the segment inside the picture or a little beyond, or `None`.
/// The rasteriser has no room for lines that end far away.
fn within([from, to]: [[f64; 2]; 2], size: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    // Shares of the way, by Liang and Barsky.
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for k in 0..2 {
        let way = to[k] - from[k];
        let bounds = [-MARGIN, size[k] + MARGIN].map(|bound| bound - from[k]);
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
        [0, 1].map(|k| along(k).clamp(-MARGIN, size[k] + MARGIN))
    };
    let ends = [
        if first > 0.0 { at(first) } else { from },
        if last < 1.0 { at(last) } else { to },
    ];
    let finite = ends.as_flattened().iter().all(|x| x.is_finite());
    (first <= last && finite).then_some(ends)
}

#[cfg(test)]
mod tests {
    use super::within as within_size;

    fn within(ends: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
        within_size(ends, [480.0, 240.0])
    }

    #[test]
    fn lines_end_where_the_picture_does() {
        let inside = [[10.0, 10.0], [400.0, 200.0]];
        assert_eq!(within(inside), Some(inside));
        // Across the picture's middle, from 64 pixels before its left edge to 64 behind its right.
        let [from, to] = within([[-1e9, 120.0], [1e9, 120.0]]).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        assert!(
            near(from[0], -64.0) && near(to[0], 544.0),
            "{from:?} {to:?}"
        );
        let [from, to] = within([[240.0, 120.0], [240.0, -1e12]]).unwrap();
        assert!(from == [240.0, 120.0] && near(to[1], -64.0), "{to:?}");
        let far = within([[-1e30, 120.0], [1e30, 120.0]]).unwrap();
        assert!(far.iter().all(|end| end[0].abs() <= 544.0), "{far:?}");
        assert_eq!(within([[-1e9, 0.0], [-1e8, 0.0]]), None);
        assert_eq!(within([[0.0, 1e9], [1e9, 1e9 + 1.0]]), None);
        assert_eq!(within([[f64::NAN, 0.0], [1.0, 1.0]]), None);
        assert_eq!(within([[0.0, 0.0], [f64::INFINITY, 1.0]]), None);
    }
}
