//! Letters drawn as strokes, because the rasteriser cannot draw text. The labels of animations use only 25 characters,
//! so a font crate is not worth its compile time.

use super::picture::{Font, Place};
use cosmic::geometry::Vector;

/// The height of a digit in the units of the glyphs.
const DIGIT: f64 = 8.0;
/// The height of a digit divided by the font's size.
const OF_SIZE: f64 = 0.7;
/// The space after a character, in the units of the glyphs. `BLANK` is the width of a character that has no glyph.
const GAP: f64 = 1.9;
const BLANK: f64 = 4.1;

/// For each character, the strokes that draw it. A stroke is a list of points `x,y`. `x` is measured from the left edge
/// of the character, `y` upwards from the baseline.
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

/// Returns the strokes of a text. A character without a glyph becomes a blank.
pub fn letters(text: &str, place: Place, font: Font) -> Vec<Vec<Place>> {
    let scale = OF_SIZE * font.size / DIGIT;
    let (mut left, mut strokes) = (0.0, Vec::new());
    for letter in text.chars() {
        let glyph = GLYPHS.iter().find(|(of, _)| *of == letter);
        let mut width: f64 = 0.0;
        for stroke in glyph.map_or(&[][..], |(_, strokes)| strokes) {
            let points = stroke.split(' ').map(point);
            let points: Vec<_> = points.inspect(|[x, _]| width = width.max(*x)).collect();
            strokes.push((left, points));
        }
        left += glyph.map_or(BLANK, |_| width + GAP);
    }
    let before = font.anchor * (left - GAP);
    let placed = |(left, points): (f64, Vec<[f64; 2]>)| {
        let point = |[x, y]: [f64; 2]| place + Vector::new([left + x - before, -y]) * scale;
        points.into_iter().map(point).collect()
    };
    strokes.into_iter().map(placed).collect()
}

fn point(pair: &str) -> [f64; 2] {
    let number = |text: &str| text.parse().expect("a number");
    let (x, y) = pair.split_once(',').expect("two numbers");
    [number(x), number(y)]
}
