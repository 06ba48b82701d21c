//! Draws a robot on its ground, for still pictures and animations.

use super::motion::{DrawnEdge, Motion, PAYLOAD, SKELETON};
use super::picture::{Colour, PAPER, Pen, Picture, Place};
use cosmic::geometry::{Range, Vector};

/// The colour of the band below the ground's line.
pub(super) const EARTH: Colour = Colour::hex(0xe4e6e9);
/// The colour of the marks along the ground's line.
pub(super) const MARK: Colour = Colour::hex(0x999999);
/// The colour of the flag at a goal.
pub(super) const GOAL: Colour = Colour::hex(0x1a7f4b);
/// The height of a flag, in pixels.
const POLE: f64 = 80.0;
/// The largest number of marks across a picture.
const MOST_MARKS: f64 = 100.0;

/// A view of the world in which a robot moves. It maps points of the world to places in a picture.
pub(super) struct View<'m> {
    pub(super) motion: &'m Motion<'m>,
    /// A point of the world, in metres. It is drawn at the place `origin` of the picture.
    pub(super) corner: Vector<f64>,
    pub(super) origin: Place,
    /// Pixels per metre.
    pub(super) scale: f64,
}

impl View<'_> {
    /// Returns the place in the picture at which a point of the world is drawn.
    pub(super) fn place(&self, point: Vector<f64>) -> Place {
        let away = (point - self.corner) * self.scale;
        // The world's y points up, but pixels are counted downwards.
        self.origin + away.with_up(-away.up())
    }

    fn line(&self, picture: &mut Picture, points: &[Vector<f64>], pen: Pen) {
        picture.line(points.iter().map(|point| self.place(*point)), pen);
    }

    /// Draws the part of the ground whose horizontal positions in the world are in the range `across`.
    pub(super) fn draw_ground(&self, picture: &mut Picture, across: Range) {
        let line = self.motion.ground_line(across).into_iter();
        let line: Vec<Place> = line.map(|point| self.place(point)).collect();
        let below = line.iter().map(|place| *place + Vector::from([0.0, 4.2]));
        picture.line(below, Pen::new(EARTH, 7.0));
        picture.line(line, Pen::new(SKELETON, 1.5));
    }

    /// Draws a mark at every tenth of a metre along the ground, counted from the payload's start, and a longer mark
    /// at every metre. On lattices of other sizes than a few decimetres, and if there were too many
    /// marks, both distances are multiplied by a power of ten.
    pub(super) fn draw_marks(&self, picture: &mut Picture, across: Range) {
        let motion = self.motion;
        let decades = |most: f64| most.log10().floor();
        let finest = decades(10.0 / motion.robot.lattice.scale);
        let per_metre = 10f64.powf(decades(MOST_MARKS / across.size()).min(finest));
        let cos = motion.ground().tangent().forward();
        let start = motion.payload(&motion.states()[0]).forward();
        let Range { low, high } = across.map(|x| per_metre * (x - start) / cos);
        for k in low.ceil() as i64..=high.floor() as i64 {
            let x = start + cos * k as f64 / per_metre;
            let top = self.place(Vector::from([x, motion.ground_height(x)]));
            let is_long = k % 10 == 0;
            let bottom = top + Vector::from([0.0, if is_long { 14.0 } else { 5.0 }]);
            picture.line([top, bottom], Pen::new(MARK, 1.0));
        }
    }

    /// Draws the payload's path through points of the world.
    pub(super) fn draw_path(&self, picture: &mut Picture, path: &[Vector<f64>]) {
        // More points than pixels would show no more detail.
        let every = path.len().div_ceil(1000).max(1);
        let points = path.iter().step_by(every).chain(path.last());
        let points: Vec<Vector<f64>> = points.copied().collect();
        self.line(picture, &points, Pen::new(PAYLOAD, 1.4));
    }

    /// Draws a flag at a point of the world. If the point is beyond the left or the right edge of the picture, draws an
    /// arrow at that edge. `width` is the width of the picture in pixels.
    pub(super) fn draw_flag(&self, picture: &mut Picture, foot: Vector<f64>, width: f64) {
        let foot = self.place(foot);
        let top = foot - Vector::from([0.0, POLE]);
        if (0.0..=width).contains(&foot.forward()) {
            picture.line([foot, top], Pen::new(MARK, 1.5));
            return picture.rectangle(top, Vector::from([18.0, 12.0]), GOAL);
        }
        let [tip, back] = if foot.forward() < 0.0 {
            [8.0, 10.0]
        } else {
            [width - 8.0, -10.0]
        };
        let arrow = [[back, -10.0], [0.0, 0.0], [back, 10.0]];
        let arrow = arrow.map(|off| Vector::from([tip, top.up()]) + Vector::from(off));
        picture.line(arrow, Pen::new(GOAL, 3.5));
    }

    pub(super) fn draw_robot(
        &self,
        picture: &mut Picture,
        bars: &[DrawnEdge],
        payload: Vector<f64>,
    ) {
        // Bars become thinner as the scale falls, but stay visible.
        let thickness = (self.scale / 100.0).clamp(1.2, 3.2);
        for bar in bars {
            let width = thickness * if bar.actuator { 1.35 } else { 1.0 };
            self.line(
                picture,
                &[bar.line.from, bar.line.to],
                Pen::new(bar.colour, width),
            );
        }
        draw_payload(picture, self.place(payload), 1.8 * thickness + 1.0);
    }
}

pub(super) fn draw_payload(picture: &mut Picture, place: impl Into<Place>, radius: f64) {
    picture.disc(place, radius, PAYLOAD, Pen::new(PAPER, 1.2));
}
