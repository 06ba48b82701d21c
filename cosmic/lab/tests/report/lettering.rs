use cosmic::geometry::{Bounds, Vector};
use cosmic_lab::report::lettering::letters;
use cosmic_lab::report::picture::Font;

#[test]
fn every_character_of_a_label_has_strokes_between_its_neighbours() {
    let label = "delivered iteration 0123456789 - 1.5 s, 2.0 m";
    for letter in label.chars().filter(|letter| *letter != ' ') {
        let strokes = letters(&letter.to_string(), Vector::zero(), Font::PLAIN);
        assert!(!strokes.is_empty(), "{letter}");
    }
    for (anchor, [left, right]) in [(0.0, [100.0, 120.0]), (1.0, [80.0, 100.0])] {
        let strokes = letters("10", Vector::new([100.0, 50.0]), Font::PLAIN.at(anchor));
        let [one, zero] = &strokes[..] else {
            panic!("{strokes:?}");
        };
        let [one, zero] = [one, zero].map(|stroke| Bounds::of(stroke.iter().copied()));
        assert!(left <= one.low[0] && one.high[0] < zero.low[0] && zero.high[0] <= right);
        // In a font of 12 pixels, digits are 8.4 pixels high.
        assert!(one.low[1] >= 41.6 - 1e-9 && zero.high[1] <= 50.0);
    }
}
