//! Pictures of the robot: its journey, one cycle of its gait, its layout.

use std::f64::consts::TAU;
use std::iter::once;
use std::ops::RangeInclusive;

use super::motion::{BEYOND, DrawnEdge, Motion, PAYLOAD, SKELETON, View, hex};
use super::svg::{BOLD, END, INK_LINE, MUTED_LINE, MUTED_MIDDLE, Svg};
use cosmic::geometry::{Bounds, Range, Vector};

const WIDTH: f64 = 960.0;
const MARGIN: f64 = 24.0;
/// Width of a panel of the gait.
const PANEL: f64 = (WIDTH - 2.0 * MARGIN) / 6.0;

impl View {
    /// Draws the ground from one place along to another.
    fn draw_ground(&self, svg: &mut Svg, motion: &Motion, across: Range) {
        let line = motion.ground_line(across).into_iter();
        let mut line: Vec<Vector<f64>> = line.map(|point| self.place(point)).collect();
        svg.polyline(&line, &format!(r#"{INK_LINE} stroke-width="1.5""#));
        for point in &mut line {
            *point += Vector::new([0.0, 4.2]);
        }
        let below = format!(r#"{MUTED_LINE} stroke-opacity="0.18" stroke-width="7""#);
        svg.polyline(&line, &below);
    }

    fn draw_robot(&self, svg: &mut Svg, bars: &[DrawnEdge], payload: Vector<f64>) {
        // Bars become thinner as the scale falls, to a least width that can be seen.
        let thickness = (self.scale / 100.0).clamp(1.2, 3.2);
        svg.group(r#"stroke-linecap="round""#, |svg| {
            for bar in bars {
                let width = thickness * if bar.actuator { 1.35 } else { 1.0 };
                let style = format!(r#"stroke="{}" stroke-width="{width:.1}""#, hex(bar.colour));
                svg.line(self.place(bar.line.from), self.place(bar.line.to), &style);
            }
        });
        draw_payload(svg, self.place(payload), 1.8 * thickness);
    }

    fn draw_path(&self, svg: &mut Svg, path: &[Vector<f64>]) {
        // More points than pixels show nothing more.
        let every = path.len().div_ceil(1000).max(1);
        let mut points: Vec<Vector<f64>> =
            path.iter().step_by(every).map(|&p| self.place(p)).collect();
        points.extend(path.last().map(|&p| self.place(p)));
        let colour = hex(PAYLOAD);
        let style = format!(r#"stroke="{colour}" stroke-width="1.4" stroke-linejoin="round""#);
        svg.polyline(&points, &style);
    }
}

fn draw_payload(svg: &mut Svg, place: impl Into<Vector<f64>>, radius: f64) {
    let colour = hex(PAYLOAD);
    let style = format!(r##"fill="{colour}" stroke="#fff" stroke-width="1.2""##);
    svg.circle(place, radius + 1.0, &style);
}

/// The journey above, one cycle of the gait below.
pub(super) fn draw(motion: &Motion) -> String {
    let mut svg = Svg::default();
    let title = format!("{:.1} s of walking", motion.duration());
    svg.text([MARGIN, 26.0], &title, BOLD);
    draw_legend(&mut svg, motion);
    let bottom = draw_journey(&mut svg, motion);
    let bottom = draw_gait(&mut svg, motion, bottom + 46.0);
    svg.finish(
        [WIDTH, bottom + 44.0],
        "The robot at several moments, coloured by strain, and the path of its payload",
    )
}

/// Draws the whole rollout in one picture of the world; returns its lower edge.
fn draw_journey(svg: &mut Svg, motion: &Motion) -> f64 {
    let moments = moments(motion);
    let states = moments.iter().map(|&i| &motion.states()[i]);
    let shown = states.flat_map(|state| motion.places(state));
    let shown = Bounds::of(shown.chain(motion.path()));
    let across = Range::new(shown.low.forward(), shown.high.forward()).widened(0.1);
    let ground = Bounds::of(motion.ground_line(across));
    let up = Range::new(shown.low.up(), shown.high.up());
    let up = up.with(ground.low.up()).with(ground.high.up());
    // As large as the page is wide, unless that would make it higher than a screen.
    let scale = ((WIDTH - 2.0 * MARGIN) / across.size()).min(420.0 / up.size());
    let bottom = 64.0 + scale * up.size();
    let slack = WIDTH - scale * across.size();
    let view = View {
        corner: Vector::new([across.low, up.low]),
        origin: Vector::new([0.5 * slack, bottom]),
        scale,
    };
    view.draw_ground(svg, motion, across);
    view.draw_path(svg, &motion.path());
    for index in moments {
        let state = &motion.states()[index];
        let mut bars = motion.bars(state);
        if index > 0 {
            // Parts left behind would lie across the first robots.
            bars.retain(|bar| motion.is_near(bar, state));
        }
        view.draw_robot(svg, &bars, state.x[0]);
        let top = motion.bounds(state).high.up();
        let above = view.place(motion.centre(state).with_up(top)) - Vector::new([0.0, 8.0]);
        let time = format!("{:.1} s", motion.time(index));
        svg.text(above, &time, MUTED_MIDDLE);
    }
    bottom + 12.0
}

/// The first state, the last, and as many in between as fit side by side along the way.
fn moments(motion: &Motion) -> Vec<usize> {
    let reached = |index: usize| motion.centre(&motion.states()[index]).forward();
    let last = motion.states().len() - 1;
    let [start, end] = [0, last].map(reached);
    let wide = motion.bounds(&motion.states()[last]).size().forward();
    let width = 1.15 * wide.max(motion.robot.lattice.spacing);
    let gaps = ((end - start).abs() / width) as usize;
    if gaps == 0 {
        // They would cover one another.
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

/// Draws six moments of the last whole period of the clock, each in its own panel; returns the lower
/// edge of the panels.
fn draw_gait(svg: &mut Svg, motion: &Motion, top: f64) -> f64 {
    let period = (TAU / motion.scene().controller.omega).min(motion.duration());
    let start = motion.duration() - period;
    let moments = [0, 1, 2, 3, 4, 5].map(|k| motion.index_at(start + period * f64::from(k) / 6.0));
    let sizes = moments.map(|index| motion.bounds(&motion.states()[index]).size());
    let largest = sizes
        .into_iter()
        .fold(Vector::new([0.05; 2]), |a, b| a.zip_with(b, f64::max));
    let [width, height] = largest.array();
    let scale = ((PANEL - 18.0) / width).min(220.0 / height);
    let middles = moments.map(|index| motion.centre(&motion.states()[index]).forward());
    let rise = scale * most_rise(motion, &middles, 0.5 * PANEL / scale);
    let bottom = top + (scale * height + 2.0 * rise + 16.0);
    let title = if period < motion.duration() {
        format!("One period of the clock, {period:.2} s, at the end")
    } else {
        format!("From start to end, {period:.2} s")
    };
    svg.text([MARGIN, top], &title, BOLD);
    for (panel, index) in moments.into_iter().enumerate() {
        let left = MARGIN + PANEL * panel as f64;
        let middle = middles[panel];
        let view = View {
            corner: Vector::new([middle - 0.5 * PANEL / scale, motion.floor(middle)]),
            origin: Vector::new([left, bottom - rise]),
            scale,
        };
        draw_panel(svg, motion, moments[0]..=index, &view);
        let place = [left + 0.5 * PANEL, bottom + 28.0];
        svg.text(place, &format!("{:.2} s", motion.time(index)), MUTED_MIDDLE);
    }
    bottom
}

/// How far the ground rises or falls at most within half a panel.
fn most_rise(motion: &Motion, middles: &[f64], half: f64) -> f64 {
    let rises = middles.iter().flat_map(|&middle| {
        let (line, floor) = (
            motion.ground_line(Range::new(middle, middle).widened(half)),
            motion.floor(middle),
        );
        line.into_iter()
            .map(move |point| (point.up() - floor).abs())
    });
    rises.fold(0.0, f64::max)
}

/// Draws the robot at the last of some states, and the payload's path through them, cut to the panel.
fn draw_panel(svg: &mut Svg, motion: &Motion, states: RangeInclusive<usize>, view: &View) {
    let state = &motion.states()[*states.end()];
    let middle = motion.centre(state).forward();
    let half = 0.5 * (PANEL - 6.0) / view.scale;
    view.draw_ground(svg, motion, Range::new(middle, middle).widened(half));
    let inside = |point: &Vector<f64>| (point.forward() - middle).abs() < half;
    let mut path = motion.path()[states].to_vec();
    path.retain(inside);
    view.draw_path(svg, &path);
    let mut bars = motion.bars(state);
    bars.retain(|bar| inside(&bar.line.from) && inside(&bar.line.to));
    view.draw_robot(svg, &bars, state.x[0]);
}

/// Draws the legend of the colours at the right end of the first line.
fn draw_legend(svg: &mut Svg, motion: &Motion) {
    let (left, y) = (WIDTH - 532.0, 22.0);
    let end = r#"stroke-width="4" stroke-linecap="round""#;
    let skeleton = format!(r#"stroke="{}" {end}"#, hex(SKELETON));
    svg.line([left, y], [left + 18.0, y], &skeleton);
    svg.text([left + 26.0, y + 4.0], "skeleton", "");
    draw_payload(svg, [left + 98.0, y], 4.0);
    svg.text([left + 108.0, y + 4.0], "payload", "");
    svg.text([left + 168.0, y + 4.0], "actuator", "");
    let percent = 100.0 * motion.limit;
    let ramp = [left + 272.0, left + 352.0];
    let least = format!("\u{2212}{percent:.0} %");
    svg.text([ramp[0] - 6.0, y + 4.0], &least, END);
    for k in 0..20 {
        let colour = hex(motion.colour((f64::from(k) / 9.5 - 1.0) * motion.limit));
        let x = ramp[0] + 4.0 * f64::from(k);
        svg.rect([x, y - 4.0], [4.2, 8.0], &format!(r#"fill="{colour}""#));
    }
    svg.text([ramp[1] + 8.0, y + 4.0], &format!("+{percent:.0} %"), "");
    let beyond = format!(r#"stroke="{}" {end}"#, hex(BEYOND));
    svg.line([ramp[1] + 64.0, y], [ramp[1] + 82.0, y], &beyond);
    svg.text([ramp[1] + 90.0, y + 4.0], "beyond these", "");
}
