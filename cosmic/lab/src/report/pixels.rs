//! Paints pictures as pixels, without their texts.

use super::picture::{Colour, PAPER, Pen, Picture, Place, Shape};
use cosmic::geometry::{Bounds, Segment, Vector};
use tiny_skia::{
    FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, Transform,
};

/// Lines that leave the picture are cut off this many pixels outside it. The number must exceed the width of any line.
const MARGIN: f64 = 64.0;

/// A picture while it is painted.
struct Canvas {
    pixels: Pixmap,
    /// The transformation from the picture's units to pixels.
    scale: Transform,
    /// The bounds at which shapes are cut off, because the rasteriser cannot draw shapes that are far away.
    bounds: Bounds,
}

impl Picture {
    /// Paints the upper left part of the picture, which has the size `size`, enlarged by `scale`. Returns `None` if
    /// memory is short.
    pub(super) fn to_pixels(&self, size: impl Into<Place>, scale: f64) -> Option<Pixmap> {
        let size: Place = size.into();
        let [width, height] = (size * scale).map(|x| x.round() as u32).in_plane();
        let mut canvas = Canvas {
            pixels: Pixmap::new(width, height)?,
            scale: Transform::from_scale(scale as f32, scale as f32),
            bounds: Bounds::of([Vector::zero(), size]).widened(MARGIN),
        };
        canvas.pixels.fill(colour(PAPER));
        for shape in &self.shapes {
            canvas.paint(shape);
        }
        Some(canvas.pixels)
    }
}

impl Canvas {
    fn paint(&mut self, shape: &Shape) {
        match shape {
            Shape::Line(points, pen) => self.line(points, pen),
            Shape::Disc(middle, radius, fill, edge) => {
                let is_near = Segment::new(*middle, *middle)
                    .within(&self.bounds)
                    .is_some();
                let [x, y] = middle.map(|x| x as f32).in_plane();
                let circle = PathBuilder::from_circle(x, y, *radius as f32);
                self.area(circle.filter(|_| is_near), *fill, edge);
            }
            Shape::Rectangle(corner, size, fill) => {
                let ([x, y], [width, height]) = (corner.in_plane(), size.in_plane());
                let [x, y, width, height] = [x, y, width, height].map(|x| x as f32);
                let sides = Rect::from_xywh(x, y, width, height);
                let sides = sides.map(PathBuilder::from_rect);
                self.area(sides, *fill, &Pen::new(*fill, 0.0));
            }
            // Animations have no text.
            Shape::Text(..) => {}
        }
    }

    /// Fills an area and draws its edge, if there is one.
    fn area(&mut self, path: Option<Path>, fill: Colour, edge: &Pen) {
        if let Some(path) = path {
            let (rule, scale) = (FillRule::Winding, self.scale);
            self.pixels
                .fill_path(&path, &paint(fill), rule, scale, None);
            self.stroke(&path, edge);
        }
    }

    fn line(&mut self, points: &[Place], pen: &Pen) {
        let mut path = PathBuilder::new();
        let mut end = None;
        for pair in points.windows(2) {
            let Some(line) = Segment::new(pair[0], pair[1]).within(&self.bounds) else {
                continue;
            };
            let [from, to] = [line.from, line.to].map(|end| end.map(|x| x as f32).in_plane());
            if end != Some(line.from) {
                path.move_to(from[0], from[1]);
            }
            path.line_to(to[0], to[1]);
            end = Some(line.to);
        }
        // A path through fewer than two points has nothing to draw.
        if let Some(path) = path.finish() {
            self.stroke(&path, pen);
        }
    }

    fn stroke(&mut self, path: &Path, pen: &Pen) {
        if pen.width == 0.0 {
            return;
        }
        let stroke = Stroke {
            width: pen.width as f32,
            line_cap: LineCap::Round,
            line_join: LineJoin::Round,
            ..Stroke::default()
        };
        let (paint, scale) = (paint(pen.colour), self.scale);
        self.pixels.stroke_path(path, &paint, &stroke, scale, None);
    }
}

fn colour(Colour { rgb: [r, g, b] }: Colour) -> tiny_skia::Color {
    tiny_skia::Color::from_rgba8(r, g, b, 255)
}

fn paint(fill: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(colour(fill));
    paint
}
