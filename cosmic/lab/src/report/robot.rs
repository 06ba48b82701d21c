//! Draws the picture of a robot's rollout: its journey, and one period of its gait.

use std::f64::consts::TAU;
use std::iter::once;
use std::ops::RangeInclusive;

use super::eye::Eye;
use super::motion::{BEYOND, DrawnMotion, SKELETON};
use super::picture::{Font, Pen, Picture};
use super::space;
use super::view::{MARGIN, MARGIN_OF_GROUND, View, WIDTH, draw_payload};
use cosmic::geometry::{Bounds, Range, Vector};

/// The width of one of the six panels that show the gait, in pixels.
const PANEL: f64 = (WIDTH - 2.0 * MARGIN) / 6.0;

/// Draws the journey at the top and one period of the gait below it. Of a robot in space, draws it also from three sides, and
/// the map of its footfalls.
pub(super) fn draw(motion: &DrawnMotion) -> String {
    let mut picture = Picture::default();
    let title = format!("{:.1} s of walking", motion.duration());
    picture.text([MARGIN, 26.0], title, Font::Bold);
    draw_legend(&mut picture, motion);
    let bottom = draw_journey(&mut picture, motion);
    let mut bottom = draw_gait(&mut picture, motion, bottom + 46.0);
    if motion.in_space() {
        let (index, _) = period(motion);
        bottom = space::draw_views(&mut picture, motion, index, bottom + 76.0);
        bottom = space::draw_footfalls(&mut picture, motion, bottom + 46.0);
    }
    let title = "The robot at several moments, coloured by strain, and the path of its payload";
    picture.to_svg([WIDTH, bottom + 44.0], title)
}

/// Draws the journey: the whole rollout in one view of the world. Returns the position of the view's lower edge.
fn draw_journey(picture: &mut Picture, motion: &DrawnMotion) -> f64 {
    let moments = moments(motion);
    let states = moments.iter().map(|&i| &motion.states()[i]);
    let shown = states.flat_map(|state| motion.places(state));
    let shown: Vec<Vector<f64>> = shown.chain(motion.path()).collect();
    let eye = Eye::of(motion.robot.lattice.dimension);
    let all = Bounds::of(shown.iter().copied());
    let across = Range::new(all.low.forward(), all.high.forward()).widened(MARGIN_OF_GROUND);
    let middle = all.centre().sideways();
    let deep = match motion.in_space() {
        true => 0.5 * all.size().sideways() + MARGIN_OF_GROUND,
        false => 0.0,
    };
    let ground = motion.ground_line(across).into_iter();
    let ground =
        ground.flat_map(|point| [-deep, deep].map(|off| point.with_sideways(middle + off)));
    let seen = eye.bounds(shown.into_iter().chain(ground));
    // No higher than a screen.
    let (view, bottom) = View::below(motion, (eye, seen), 64.0, 420.0);
    view.draw_floor(picture, across, (middle, deep));
    view.draw_path(picture, &motion.path());
    for index in moments {
        let state = &motion.states()[index];
        let mut bars = motion.bars(state);
        if index > 0 {
            // Loose parts that the robot left behind would cover the drawings of earlier moments.
            bars.retain(|bar| motion.is_near(bar, state));
        }
        view.draw_robot(picture, &bars, motion.payload(state));
        let body = motion.body_at(state).map(|point| view.place(point));
        let body = Bounds::of(body);
        let above = Vector::from([body.centre().forward(), body.low.up() - 8.0]);
        picture.text(above, format!("{:.1} s", motion.time(index)), Font::Caption);
    }
    bottom + 12.0
}

/// Returns the indices of the states to draw: the first, the last, and as many in between as fit side by side.
fn moments(motion: &DrawnMotion) -> Vec<usize> {
    let reached = |index: usize| motion.centre(&motion.states()[index]).forward();
    let last = motion.states().len() - 1;
    let [start, end] = [0, last].map(reached);
    let size = motion.bounds(&motion.states()[last]).size();
    let eye = Eye::of(motion.robot.lattice.dimension);
    let wide = size.forward() + eye.slant() * size.sideways();
    let width = 1.15 * wide.max(motion.robot.lattice.spacing);
    let gaps = ((end - start).abs() / width) as usize;
    if gaps == 0 {
        // The robot hardly moves, so two drawings would cover each other.
        return vec![last];
    }
    let nearest = |goal: f64| {
        let off = |i: &usize| (reached(*i) - goal).abs();
        let nearest = (0..last).min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.unwrap_or(0)
    };
    let between = (1..gaps.min(7)).map(|k| start + (end - start) * k as f64 / gaps.min(7) as f64);
    once(0).chain(between.map(nearest)).chain([last]).collect()
}

/// Returns the index of the state at which the last whole period of the clock begins, and the duration of the period, s.
fn period(motion: &DrawnMotion) -> (usize, f64) {
    let period = (TAU / motion.robot.omega).min(motion.duration());
    (motion.index_at(motion.duration() - period), period)
}

/// Draws six moments of the gait, each in its own panel. They divide the last whole period of the clock. Returns the
/// position of the panels' lower edge.
fn draw_gait(picture: &mut Picture, motion: &DrawnMotion, top: f64) -> f64 {
    let (_, period) = period(motion);
    let start = motion.duration() - period;
    let moments = [0, 1, 2, 3, 4, 5].map(|k| motion.index_at(start + period * f64::from(k) / 6.0));
    let eye = Eye::of(motion.robot.lattice.dimension);
    let corners = moments.map(|index| {
        let centre = motion.centre(&motion.states()[index]);
        centre.with_up(motion.floor(centre.forward()))
    });
    // How each body is seen from the point of the ground below its middle.
    let boxes: Vec<Bounds> = moments
        .iter()
        .zip(corners)
        .map(|(&index, corner)| {
            let body = motion.body_at(&motion.states()[index]);
            eye.bounds(body.map(|point| point - corner))
        })
        .collect();
    let largest = boxes
        .iter()
        .map(Bounds::size)
        .fold(Vector::from([0.05; 2]), |a, b| a.zip_with(b, f64::max));
    let [width, height] = largest.in_plane();
    let scale = ((PANEL - 18.0) / width).min(220.0 / height);
    let middles = corners.map(Vector::forward);
    let rise = scale * most_rise(motion, &middles, 0.5 * PANEL / scale);
    // In a view from above, parts of the robot are lower than the point below its middle.
    let sink = match motion.in_space() {
        true => scale * boxes.iter().map(|seen| -seen.low.up()).fold(0.0, f64::max),
        false => 0.0,
    };
    let bottom = top + (scale * height + 2.0 * rise + 16.0);
    let title = if period < motion.duration() {
        format!("One period of the clock, {period:.2} s, at the end")
    } else {
        format!("From start to end, {period:.2} s")
    };
    picture.text([MARGIN, top], title, Font::Bold);
    for (panel, index) in moments.into_iter().enumerate() {
        let middle = MARGIN + PANEL * (panel as f64 + 0.5);
        let view = View {
            motion,
            eye,
            corner: corners[panel],
            origin: Vector::from([middle, bottom - rise - sink]),
            scale,
        };
        draw_panel(picture, &view, moments[0]..=index);
        let place = [middle, bottom + 28.0];
        picture.text(place, format!("{:.2} s", motion.time(index)), Font::Caption);
    }
    bottom
}

/// Returns how far the ground rises above or falls below its mean height, in metres: the largest distance, within
/// `half` metres of each of the `middles`.
fn most_rise(motion: &DrawnMotion, middles: &[f64], half: f64) -> f64 {
    let rises = middles.iter().flat_map(|&middle| {
        let line = motion.ground_line(Range::new(middle, middle).widened(half));
        let floor = motion.floor(middle);
        line.into_iter()
            .map(move |point| (point.up() - floor).abs())
    });
    rises.fold(0.0, f64::max)
}

/// Draws the robot in the last of `states`, and the payload's path through all of them. Parts outside the panel are cut
/// off.
fn draw_panel(picture: &mut Picture, view: &View, states: RangeInclusive<usize>) {
    let motion = view.motion;
    let state = &motion.states()[*states.end()];
    let middle = view.corner;
    let half = 0.5 * (PANEL - 6.0) / view.scale;
    // The corners of a square of ground are farther to the right than its edges.
    let ground = if motion.in_space() { 0.7 * half } else { half };
    let along = Range::new(middle.forward(), middle.forward()).widened(ground);
    view.draw_floor(picture, along, (middle.sideways(), ground));
    let inside = |point: &Vector<f64>| view.eye.see(*point - middle).forward().abs() < half;
    let mut path = motion.path()[states].to_vec();
    path.retain(inside);
    view.draw_path(picture, &path);
    let mut bars = motion.bars(state);
    bars.retain(|bar| inside(&bar.line.from) && inside(&bar.line.to));
    view.draw_robot(picture, &bars, motion.payload(state));
}

/// Draws the legend of the colours, right-aligned on the first line.
fn draw_legend(picture: &mut Picture, motion: &DrawnMotion) {
    let (left, y) = (WIDTH - 532.0, 22.0);
    let mut key = |x: f64, colour, name: &str| {
        picture.line([[left + x, y], [left + x + 18.0, y]], Pen::new(colour, 4.0));
        picture.text([left + x + 26.0, y + 4.0], name, Font::Plain);
    };
    key(0.0, SKELETON, "skeleton");
    key(416.0, BEYOND, "beyond limits");
    draw_payload(picture, [left + 98.0, y], 5.0);
    picture.text([left + 108.0, y + 4.0], "payload", Font::Plain);
    picture.text([left + 168.0, y + 4.0], "actuator", Font::Plain);
    let percent = 100.0 * motion.limit;
    let [low, high] = [left + 272.0, left + 352.0];
    let least = format!("\u{2212}{percent:.0} %");
    picture.text([low - 6.0, y + 4.0], least, Font::End);
    for k in 0..20 {
        let colour = motion.colour((f64::from(k) / 9.5 - 1.0) * motion.limit);
        let x = low + 4.0 * f64::from(k);
        picture.rectangle([x, y - 4.0], [4.2, 8.0], colour);
    }
    picture.text(
        [high + 8.0, y + 4.0],
        format!("+{percent:.0} %"),
        Font::Plain,
    );
}
