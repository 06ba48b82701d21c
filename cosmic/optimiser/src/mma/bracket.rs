//! A search for the zero of a decreasing function, by the Illinois variant of regula falsi.

/// The state of the search: a point below the zero and, once known, a point above it, each with the value of the
/// function.
pub(super) struct Bracket {
    below: (f64, f64),
    above: Option<(f64, f64)>,
    /// The end of the bracket that was replaced last, and the number of times in a row that this end was replaced.
    moved: (End, usize),
}

#[derive(Clone, Copy, PartialEq)]
enum End {
    Below,
    Above,
}

impl Bracket {
    /// Begins a search at the point 0, where the function has the positive value `value`.
    pub(super) fn starting_with(value: f64) -> Self {
        Bracket {
            below: (0.0, value),
            above: None,
            moved: (End::Above, 0),
        }
    }

    /// Narrows the bracket: one of its ends moves to the point `at`, where the function has the value `value`.
    pub(super) fn narrow(&mut self, at: f64, value: f64) {
        let moves = if value > 0.0 { End::Below } else { End::Above };
        let (last, times) = self.moved;
        self.moved = (moves, if moves == last { times + 1 } else { 1 });
        // If the same end moves twice in a row, the value at the other end is halved. Otherwise the other end might
        // never move.
        let weight = if self.moved.1 > 1 { 0.5 } else { 1.0 };
        match (moves, self.above) {
            (End::Below, above) => {
                self.below = (at, value);
                self.above = above.map(|(end, value)| (end, weight * value));
            }
            (End::Above, None) => self.above = Some((at, value)),
            (End::Above, Some(_)) => {
                self.below.1 *= weight;
                self.above = Some((at, value));
            }
        }
    }

    /// The next point to try. Until a point above the zero is known, it is four times the last point. Then it is each
    /// known kink inside the bracket, once. After that, it is the zero of the chord (the straight line between the two
    /// ends). If the zero of the chord is repeatedly close to one end, there is an unknown kink near that end; the next
    /// point is then the middle of the bracket.
    pub(super) fn next_trial(&self, kinks: &mut Vec<f64>) -> f64 {
        let (start, value) = self.below;
        let Some((end, other)) = self.above else {
            return 4.0 * start;
        };
        kinks.retain(|&kink| start < kink && kink < end);
        let share = value / (value - other);
        let hugs = !(0.01..=0.99).contains(&share);
        let share = if hugs && self.moved.1 > 1 { 0.5 } else { share };
        kinks.pop().unwrap_or(start + share * (end - start))
    }
}
