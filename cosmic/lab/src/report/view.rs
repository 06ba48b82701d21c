//! Draws a robot on its ground, for still pictures and animations.

use super::eye::Eye;
use super::motion::{DrawnEdge, DrawnMotion, PAYLOAD, SKELETON};
use super::picture::{Colour, Font, PAPER, Pen, Picture, Place};
use cosmic::geometry::{Bounds, Range, Vector};
use cosmic::numbers::fixed;

/// The width of a still picture, in pixels.
pub(super) const WIDTH: f64 = 960.0;
/// What stays free at either side of a still picture, in pixels.
pub(super) const MARGIN: f64 = 24.0;
/// The colour of the band below the ground's line.
pub(super) const EARTH: Colour = Colour::hex(0xe4e6e9);
/// The colour of the marks along the ground's line.
pub(super) const MARK: Colour = Colour::hex(0x999999);
/// The colour of the flag at a goal.
pub(super) const GOAL: Colour = Colour::hex(0x1a7f4b);
/// The colour of shadows and of the grid on the ground.
pub(super) const SHADOW: Colour = Colour::hex(0xd5dbe1);
/// How far the ground of a robot in space is drawn around what it carries, in metres.
pub(super) const MARGIN_OF_GROUND: f64 = 0.1;
/// The fraction of its colour that the farthest bar loses to the colour of the paper.
const FOG: f64 = 0.62;
/// How far the paper shows on either side of a bar in front of other bars, in pixels.
const HALO: f64 = 1.2;
/// The width of an undecided bar, in pixels.
const HAIRLINE: f64 = 0.6;
/// The height of a flag, in pixels.
const POLE: f64 = 80.0;
/// The largest number of marks across a picture.
const MOST_MARKS: f64 = 100.0;

/// A view of the world in which a robot moves. It maps points of the world to places in a picture.
pub(super) struct View<'m> {
    pub(super) motion: &'m DrawnMotion<'m>,
    /// The direction in which the world is seen.
    pub(super) eye: Eye,
    /// A point of the world, in metres. It is drawn at the place `origin` of the picture.
    pub(super) corner: Vector<f64>,
    pub(super) origin: Place,
    /// Pixels per metre.
    pub(super) scale: f64,
}

impl<'m> View<'m> {
    /// Returns the view in which the box `seen`, of points as the eye [sees](Eye::see) them, stands with the middle of its
    /// lower edge at a place of the picture.
    pub(super) fn standing(
        motion: &'m DrawnMotion<'m>,
        (eye, seen): (Eye, Bounds),
        place: [f64; 2],
        scale: f64,
    ) -> Self {
        let foot = Vector::from([-seen.centre().forward(), seen.low.up()]);
        Self {
            motion,
            eye,
            corner: Vector::zero(),
            origin: Vector::from(place) + foot * scale,
            scale,
        }
    }

    /// Returns such a view below the height `top` of the picture, as wide as the page unless it would then be higher than
    /// `tallest` pixels, and the position of its lower edge.
    pub(super) fn below(
        motion: &'m DrawnMotion<'m>,
        (eye, seen): (Eye, Bounds),
        top: f64,
        tallest: f64,
    ) -> (Self, f64) {
        let size = seen.size();
        let scale = ((WIDTH - 2.0 * MARGIN) / size.forward()).min(tallest / size.up());
        let bottom = top + scale * size.up();
        let place = [0.5 * WIDTH, bottom];
        (Self::standing(motion, (eye, seen), place, scale), bottom)
    }

    /// Returns the place in the picture at which a point of the world is drawn.
    pub(super) fn place(&self, point: Vector<f64>) -> Place {
        let seen = self.eye.see(point - self.corner) * self.scale;
        // The world's z points up, but pixels are counted downwards.
        self.origin + Vector::upright(seen.forward(), -seen.up())
    }

    /// Draws the ground as a grid, whose lines are a round number of metres apart. `ranges` are those of the ground along
    /// and across. If `named`, numbers in front of the grid are metres along the ground from the payload's start.
    pub(super) fn draw_grid(&self, picture: &mut Picture, ranges: [Range; 2], named: bool) {
        let motion = self.motion;
        let level = |[x, y]: [f64; 2]| Vector::new([x, y, motion.ground_height(x)]);
        let step = round_step(48.0 / self.scale);
        let cos = motion.ground().tangent().forward();
        let start = motion.payload(&motion.states()[0]);
        let [along, across] = ranges;
        let marks = |range: Range, from: f64, apart: f64| {
            let Range { low, high } = range.map(|x| (x - from) / apart);
            (low.ceil() as i64..=high.floor() as i64).map(move |k| (k, from + apart * k as f64))
        };
        let pen = Pen::new(SHADOW, 0.8);
        for (k, x) in marks(along, start.forward(), step * cos) {
            self.line(
                picture,
                &[across.low, across.high].map(|y| level([x, y])),
                pen,
            );
            if named {
                let place = self.place(level([x, across.low])) + Vector::from([0.0, 14.0]);
                picture.text(
                    place,
                    format!("{} m", metres(step * k as f64, step)),
                    Font::Caption,
                );
            }
        }
        for (_, y) in marks(across, start.sideways(), step) {
            let line = motion.ground_line(along).into_iter();
            let line: Vec<_> = line.map(|point| point.with_sideways(y)).collect();
            self.line(picture, &line, pen);
        }
    }

    /// Draws the shadows that bars cast straight down.
    fn draw_shadows(&self, picture: &mut Picture, bars: &[DrawnEdge], thickness: f64) {
        let below = |point: Vector<f64>| point.with_up(self.motion.ground_height(point.forward()));
        for bar in bars.iter().filter(|bar| !bar.faint) {
            let ends = [bar.line.from, bar.line.to].map(below);
            self.line(picture, &ends, Pen::new(SHADOW, 1.7 * thickness));
        }
    }

    fn line(&self, picture: &mut Picture, points: &[Vector<f64>], pen: Pen) {
        picture.line(points.iter().map(|point| self.place(*point)), pen);
    }

    /// Draws the part of the ground whose horizontal positions in the world are in the range `across`.
    ///
    /// Of a robot in space, draws a grid around the point `middle` instead, as far across as along, but at most `deep`
    /// metres to either side.
    pub(super) fn draw_floor(
        &self,
        picture: &mut Picture,
        across: Range,
        (middle, deep): (f64, f64),
    ) {
        if self.motion.in_space() {
            let sideways = Range::new(middle, middle).widened(deep);
            return self.draw_grid(picture, [across, sideways], false);
        }
        self.draw_ground(picture, across);
    }

    /// Draws the line of the ground whose horizontal positions in the world are in the range `across`.
    fn draw_ground(&self, picture: &mut Picture, across: Range) {
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

    /// Draws the bars and the payload of a robot. Of a robot in space, nearer parts hide farther ones, which are paler, and
    /// bars have a halo and a shadow.
    pub(super) fn draw_robot(
        &self,
        picture: &mut Picture,
        bars: &[DrawnEdge],
        payload: Vector<f64>,
    ) {
        // Bars become thinner as the scale falls, but stay visible.
        let thickness = (self.scale / 100.0).clamp(1.2, 3.2);
        let radius = 1.8 * thickness + 1.0;
        if !self.motion.in_space() {
            for bar in bars {
                self.line(
                    picture,
                    &[bar.line.from, bar.line.to],
                    pen_of(bar, thickness),
                );
            }
            return draw_payload(picture, self.place(payload), radius);
        }
        if !self.eye.is_level() {
            self.draw_shadows(picture, bars, thickness);
        }
        let away = |point: Vector<f64>| self.eye.see(point).sideways();
        let mut bars: Vec<_> = bars
            .iter()
            .map(|bar| (away(bar.line.middle()), bar))
            .collect();
        bars.sort_by(|a, b| b.0.total_cmp(&a.0));
        let depth = Range::of(bars.iter().map(|(away, _)| *away));
        let mut payload = Some(payload);
        for (far, bar) in bars {
            if let Some(nearer) = payload.filter(|&payload| away(payload) > far) {
                draw_payload(picture, self.place(nearer), radius);
                payload = None;
            }
            let pen = pen_of(bar, thickness);
            let ends = [bar.line.from, bar.line.to].map(|end| self.place(end));
            let length = ends[0].distance(ends[1]);
            // Where bars meet, a halo would cut them.
            let cut = (2.0 * pen.width + HALO) / length;
            if !bar.faint && cut < 0.4 {
                let halo = [cut, 1.0 - cut].map(|share| ends[0].towards(ends[1], share));
                picture.line(halo, Pen::new(PAPER, pen.width + 2.0 * HALO));
            }
            let fog = FOG * (far - depth.low) / depth.size().max(1e-9);
            picture.line(ends, Pen::new(bar.colour.mixed(PAPER, fog), pen.width));
        }
        if let Some(payload) = payload {
            draw_payload(picture, self.place(payload), radius);
        }
    }
}

/// The pen for a bar: undecided bars are hairlines, and actuators are thicker than skeleton.
fn pen_of(bar: &DrawnEdge, thickness: f64) -> Pen {
    let width = match bar {
        DrawnEdge { faint: true, .. } => HAIRLINE,
        DrawnEdge { actuator: true, .. } => 1.35 * thickness,
        _ => thickness,
    };
    Pen::new(bar.colour, width)
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
pub(super) fn round_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0].map(|k| k * decade);
    let step = steps.into_iter().find(|step| *step >= least * (1.0 - 1e-9));
    step.unwrap_or(10.0 * decade)
}

/// A multiple of `step` with as many decimals as it needs.
fn metres(x: f64, step: f64) -> String {
    let digits = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
    fixed(x, digits).replace('-', "\u{2212}")
}

pub(super) fn draw_payload(picture: &mut Picture, place: impl Into<Place>, radius: f64) {
    picture.disc(place, radius, PAYLOAD, Pen::new(PAPER, 1.2));
}
