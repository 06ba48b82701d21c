//! Pictures that only robots in space have: the robot from the front, from the side and from above, and the map of its
//! footfalls.

use super::eye::Eye;
use super::motion::{CONTRACTED, DrawnMotion, EXTENDED, Footfall, SKELETON};
use super::picture::{Colour, Font, PAPER, Pen, Picture};
use super::view::{MARGIN, MARGIN_OF_GROUND, MARK, View, WIDTH, round_step};
use cosmic::geometry::{Bounds, Range, Vector};

/// The colour of feet that are in the middle between left and right.
const BETWEEN: Colour = MARK;
/// The height of a scale bar with its text, in pixels.
const SCALE_BAR: f64 = 40.0;
/// The largest height of a drawing, in pixels.
const TALLEST: f64 = 240.0;

/// Draws the robot at one moment from the front, from the side and from above, to one scale. Returns the position of the
/// lower edge.
pub(super) fn draw_views(
    picture: &mut Picture,
    motion: &DrawnMotion,
    index: usize,
    top: f64,
) -> f64 {
    let state = &motion.states()[index];
    let title = format!("At {:.2} s, to one scale", motion.time(index));
    picture.text([MARGIN, top], title, Font::Bold);
    let views = [
        ("from the front", Eye::FRONT),
        ("from the side", Eye::SIDE),
        ("from above", Eye::TOP),
    ]
    .map(|(name, angles)| (name, Eye::new(angles)));
    let floor = motion.floor(motion.centre(state).forward());
    let boxes = views.map(|(_, eye)| {
        let seen = eye.bounds(motion.body_at(state));
        let ground = if eye.is_level() { floor } else { seen.low.up() };
        Bounds::of([seen.low, seen.high, seen.low.with_up(ground)])
    });
    let panel = (WIDTH - 2.0 * MARGIN) / 3.0;
    let largest = |of: fn(Vector<f64>) -> f64| {
        boxes
            .iter()
            .map(|seen| of(seen.size()))
            .fold(0.05, f64::max)
    };
    let scale = ((panel - 70.0) / largest(Vector::forward)).min(TALLEST / largest(Vector::up));
    let bottom = top + 24.0 + scale * largest(Vector::up);
    for (k, ((name, eye), seen)) in views.into_iter().zip(boxes).enumerate() {
        let middle = MARGIN + panel * (k as f64 + 0.5);
        let view = View::standing(motion, (eye, seen), [middle, bottom], scale);
        if eye.is_level() {
            let half = 0.5 * (panel - 24.0);
            let at = bottom + scale * (seen.low.up() - floor);
            picture.line(
                [[middle - half, at], [middle + half, at]],
                Pen::new(SKELETON, 1.5),
            );
        }
        let mut bars = motion.bars(state);
        bars.retain(|bar| motion.is_near(bar, state));
        view.draw_robot(picture, &bars, motion.payload(state));
        picture.text([middle, bottom + 24.0], name, Font::Caption);
        draw_scale(picture, [middle, bottom + 36.0], scale, 0.3 * panel);
    }
    bottom + SCALE_BAR
}

/// Draws a bar around a place that shows how long a round number of metres is. The bar has at most `most` pixels.
fn draw_scale(picture: &mut Picture, [x, y]: [f64; 2], scale: f64, most: f64) {
    let length = round_step(0.4 * most / scale);
    let half = 0.5 * scale * length;
    let pen = Pen::new(SKELETON, 1.5);
    picture.line([[x - half, y], [x + half, y]], pen);
    for end in [x - half, x + half] {
        picture.line([[end, y - 4.0], [end, y + 4.0]], pen);
    }
    picture.text(
        [x + half + 26.0, y + 4.0],
        format!("{length} m"),
        Font::Caption,
    );
}

/// Draws where the feet of the robot touch the ground, from above, and the path of its payload. Returns the position of the
/// lower edge.
pub(super) fn draw_footfalls(picture: &mut Picture, motion: &DrawnMotion, top: f64) -> f64 {
    let title = "Footfalls from above: a disc where a node lands, a line where it slides";
    picture.text([MARGIN, top], title, Font::Bold);
    let falls = motion.footfalls();
    let shown = falls.iter().flat_map(|fall| fall.places.iter().copied());
    let eye = Eye::new(Eye::TOP);
    let seen = eye
        .bounds(shown.chain(motion.path()))
        .widened(MARGIN_OF_GROUND);
    let (view, bottom) = View::below(motion, (eye, seen), top + 40.0, TALLEST);
    let across = Range::new(seen.low.up(), seen.high.up());
    view.draw_grid(
        picture,
        [Range::new(seen.low.forward(), seen.high.forward()), across],
        true,
    );
    view.draw_path(picture, &motion.path());
    for Footfall { node, places } in &falls {
        let pen = Pen::new(side_of(motion, *node), 1.5);
        let places: Vec<_> = places.iter().map(|&place| view.place(place)).collect();
        picture.disc(places[0], 3.0, pen.colour, Pen::new(PAPER, 0.8));
        if places.len() > 1 {
            picture.line(places, pen);
        }
    }
    let mut key = |x: f64, name: &str, colour: Colour| {
        picture.disc([x, top + 18.0], 3.5, colour, Pen::new(colour, 0.0));
        picture.text([x + 9.0, top + 22.0], name, Font::Plain);
    };
    key(MARGIN + 4.0, "left", CONTRACTED);
    key(MARGIN + 56.0, "middle", BETWEEN);
    key(MARGIN + 126.0, "right", EXTENDED);
    draw_scale(
        picture,
        [WIDTH - MARGIN - 100.0, top + 18.0],
        view.scale,
        120.0,
    );
    bottom + 24.0
}

/// The colour of a foot: by its side of the lattice at rest.
fn side_of(motion: &DrawnMotion, node: usize) -> Colour {
    let places = &motion.robot.lattice.positions;
    let across = Range::of(places.iter().map(|place| place.sideways()));
    let off = places[node].sideways() - 0.5 * (across.low + across.high);
    if off.abs() < 1e-6 * motion.robot.lattice.spacing {
        BETWEEN
    } else if off > 0.0 {
        CONTRACTED
    } else {
        EXTENDED
    }
}
