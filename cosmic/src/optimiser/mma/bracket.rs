//! A search for the zero of a decreasing function, by the Illinois variant of regula falsi.

/// The state of the search: a point below the zero and, once known, a point above it, each with the value of the
/// function.
pub(super) struct Bracket {
    below: (f64, f64),
    above: Option<(f64, f64)>,
    /// The end of the bracket that moved last, and how many times in a row.
    moved: (End, usize),
}

#[derive(Clone, Copy, PartialEq)]
enum End {
    Below,
    Above,
}

impl Bracket {
    /// A bracket that starts at 0, where the function has this positive value.
    pub(super) fn starting_with(value: f64) -> Self {
        Bracket {
            below: (0.0, value),
            above: None,
            moved: (End::Above, 0),
        }
    }

    /// Narrows the bracket by the value of the function at a point inside.
    pub(super) fn narrow(&mut self, at: f64, value: f64) {
        let moves = if value > 0.0 { End::Below } else { End::Above };
        let (last, times) = self.moved;
        self.moved = (moves, if moves == last { times + 1 } else { 1 });
        // If an end stays twice in a row, its value is halved, because it might stay forever otherwise.
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

    /// The next point to try: four times the last one, until a point above the zero is known; then each known kink
    /// inside the bracket, once; then the zero of the chord. If the zero of the chord is repeatedly close to one end,
    /// there is an unknown kink near that end, and the bracket is halved instead.
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

#[cfg(test)]
mod tests {
    use super::Bracket;
    use crate::optimiser::mma::dual::MAX_TRIALS;

    /// A function that is constant at 1e-6 up to a kink at 7 and then falls steeply. The elastic cost makes slopes look
    /// like this.
    fn kinked(at: f64) -> f64 {
        1e-6 - 1e3 * (at - 7.0).max(0.0)
    }

    fn trials(mut kinks: Vec<f64>) -> usize {
        let mut bracket = Bracket::starting_with(kinked(0.0));
        let mut at = 1.0;
        for trials in 1..=MAX_TRIALS {
            let value = kinked(at);
            if value.abs() < 1e-7 {
                return trials;
            }
            bracket.narrow(at, value);
            at = bracket.next_trial(&mut kinks);
        }
        panic!("no zero found: stopped at {at}");
    }

    #[test]
    fn a_known_kink_shortens_the_search() {
        let (blind, told) = (trials(vec![]), trials(vec![3.0, 7.0, 50.0]));
        // The trials are 1, 4, 16, the kink at 7, and the chord beyond it, which is exact up to rounding.
        assert!(
            told <= 6 && blind > 2 * told,
            "{told} trials, {blind} without kinks"
        );
    }
}
