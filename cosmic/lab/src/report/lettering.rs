//! Letters made of strokes, for pictures whose rasteriser knows none: those that labels need.

use cosmic::geometry::Vector;

/// Height of a digit, in the units of glyphs.
const DIGIT: f64 = 8.0;
/// Space between two glyphs, and the width of a blank.
const GAP: f64 = 1.9;
const BLANK: f64 = 2.2;

/// Characters, each as strokes through points `x,y`, to the right of its left edge and above its line.
#[rustfmt::skip]
const GLYPHS: [(char, &[&str]); 25] = [
    ('0', &["1,0 3,0 4,1 4,7 3,8 1,8 0,7 0,1 1,0"]),
    ('1', &["0.6,6.4 2.4,8 2.4,0"]),
    ('2', &["0,7 1,8 3,8 4,7 4,5.4 0,0 4,0"]),
    ('3', &["0,7 1,8 3,8 4,7 4,5.3 3,4.3 1.6,4.3", "3,4.3 4,3.3 4,1 3,0 1,0 0,1"]),
    ('4', &["3,0 3,8 0,2.4 4.2,2.4"]),
    ('5', &["3.8,8 0.6,8 0.2,4.5 1.1,5.1 3,5.1 4,4.1 4,1 3,0 1,0 0,1"]),
    ('6', &["3.8,7.2 3,8 1,8 0,7 0,1 1,0 3,0 4,1 4,3.8 3,4.8 1,4.8 0,3.8"]),
    ('7', &["0,8 4,8 1.4,0"]),
    ('8', &["1,4.4 0,5.4 0,7 1,8 3,8 4,7 4,5.4 3,4.4 1,4.4 0,3.4 0,1 1,0 3,0 4,1 4,3.4 3,4.4"]),
    ('9', &["0.2,0.8 1,0 3,0 4,1 4,7 3,8 1,8 0,7 0,4.2 1,3.2 3,3.2 4,4.2"]),
    ('.', &["0.2,0 0.3,0"]),
    ('-', &["0,4 3.2,4"]),
    (',', &["0.5,0.2 0.1,-1.4"]),
    ('a', &["3.6,5.6 3.6,0", "3.6,4.4 2.6,5.6 1,5.6 0,4.4 0,1.2 1,0 2.6,0 3.6,1.2"]),
    ('d', &["3.6,8 3.6,0", "3.6,4.4 2.6,5.6 1,5.6 0,4.4 0,1.2 1,0 2.6,0 3.6,1.2"]),
    ('e', &["0,3 3.6,3 3.6,4.4 2.6,5.6 1,5.6 0,4.4 0,1.2 1,0 2.6,0 3.5,0.9"]),
    ('i', &["0.2,0 0.2,5.6", "0.2,7.7 0.2,7.8"]),
    ('l', &["0.2,8 0.2,0"]),
    ('m', &["0,0 0,5.6", "0,4.4 1.1,5.6 1.9,5.6 2.7,4.7 2.7,0", "2.7,4.4 3.8,5.6 4.6,5.6 5.4,4.7 5.4,0"]),
    ('n', &["0,0 0,5.6", "0,4.3 1.3,5.6 2.5,5.6 3.4,4.6 3.4,0"]),
    ('o', &["1,0 2.6,0 3.6,1.2 3.6,4.4 2.6,5.6 1,5.6 0,4.4 0,1.2 1,0"]),
    ('r', &["0,0 0,5.6", "0,4 1.4,5.6 2.4,5.6"]),
    ('s', &["3.2,4.7 2.4,5.6 0.9,5.6 0,4.8 0,3.9 0.8,3 2.5,2.6 3.3,1.8 3.3,0.8 2.4,0 0.9,0 0,0.8"]),
    ('t', &["1,7.6 1,1 1.8,0 2.6,0", "0,5.6 2.6,5.6"]),
    ('v', &["0,5.6 1.8,0 3.6,5.6"]),
];

/// The strokes of a text with digits of a height (px), which begins at a point of the picture, from its left and
/// its top; what has no glyph is a blank.
pub(super) fn lettered(text: &str, begin: Vector<f64>, height: f64) -> Vec<Vec<Vector<f64>>> {
    let (scale, mut left, mut lines) = (height / DIGIT, 0.0, Vec::new());
    for letter in text.chars() {
        let glyph = GLYPHS.iter().find(|(of, _)| *of == letter);
        let strokes = glyph.map_or(Vec::new(), |(_, strokes)| {
            strokes.iter().map(|stroke| points(stroke)).collect()
        });
        let widths = strokes
            .iter()
            .flatten()
            .map(|point: &Vector<f64>| point.forward());
        let width = widths.fold(0.0, f64::max);
        let place = |point: Vector<f64>| {
            let [along, above] = point.array();
            begin + Vector::new([left + along, -above]) * scale
        };
        let placed = strokes
            .into_iter()
            .map(|stroke| stroke.into_iter().map(place).collect());
        lines.extend(placed.collect::<Vec<Vec<_>>>());
        left += GAP + if glyph.is_some() { width } else { BLANK };
    }
    lines
}

fn points(stroke: &str) -> Vec<Vector<f64>> {
    let number = |text: &str| text.parse().expect("a number");
    let point = |pair: &str| {
        pair.split_once(',')
            .map(|(x, y)| Vector::new([number(x), number(y)]))
    };
    stroke.split(' ').filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::{GLYPHS, lettered};
    use cosmic::geometry::{Bounds, Vector};

    #[test]
    fn every_character_of_a_label_has_strokes() {
        let label = "delivered iteration 0123456789 - 1.5 s, 2.0 m";
        for letter in label.chars().filter(|letter| *letter != ' ') {
            assert!(GLYPHS.iter().any(|(of, _)| *of == letter), "{letter}");
        }
        let lines = lettered("10", Vector::new([100.0, 50.0]), 16.0);
        // The one stands left of the nought, both on the line and as high as digits are.
        assert_eq!(lines.len(), 2);
        let ends = lines.concat();
        let bounds = Bounds::of(ends);
        assert!(
            bounds.low.forward() > 100.0 && bounds.low.up() >= 34.0 && bounds.high.up() <= 50.0
        );
        let [one, nought] = [&lines[0], &lines[1]].map(|line| Bounds::of(line.iter().copied()));
        assert!(one.high.forward() < nought.low.forward());
    }
}
