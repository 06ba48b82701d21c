//! What a gradient check found.

use std::fmt;

/// What a check says of a gradient; ordered from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The differences settle on the claimed slope, and from both sides.
    Smooth,
    /// Differences cannot tell: the left and the right slope differ or grow apart and the claimed
    /// one is between them, or no step makes the differences settle.
    Kink,
    /// The differences settle on another slope, or forward mode disagrees.
    Wrong,
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Verdict::Smooth => "smooth",
            Verdict::Kink => "kink",
            Verdict::Wrong => "wrong",
        })
    }
}

/// One direction's check. Slopes are per unit length along the direction.
#[derive(Clone, Debug)]
pub struct Direction {
    /// The claimed slope: gradient times direction.
    pub gradient: f64,
    /// The slope by the claim's second source.
    pub forward: Option<f64>,
    /// Difference quotient behind the point, at `step`.
    pub left: f64,
    /// Difference quotient around the point, at `step`.
    pub central: f64,
    /// Difference quotient ahead of the point, at `step`.
    pub right: f64,
    /// The step that the verdict rests on.
    pub step: f64,
    /// `|gradient - central|`, relative to the slope and the typical slope.
    pub error: f64,
    /// By how much `central` may be off, relative to the same: a guess from the steps beside it,
    /// infinite where differences do not settle.
    pub unsure: f64,
    /// The verdict.
    pub verdict: Verdict,
}

impl Direction {
    pub(super) fn absolute_error(&self) -> f64 {
        (self.gradient - self.central).abs()
    }
}

/// The component that has the largest part in the worst direction's error.
#[derive(Clone, Debug)]
pub struct Component {
    /// Its index.
    pub index: usize,
    /// The claimed component.
    pub gradient: f64,
    /// Its central difference.
    pub central: f64,
    /// The verdict along this component alone.
    pub verdict: Verdict,
}

/// The outcome of a check; displayed as a table.
#[derive(Clone, Debug)]
pub struct Report {
    /// One row per random direction.
    pub directions: Vec<Direction>,
    /// Where to look first.
    pub worst: Component,
    /// The worst verdict of any direction.
    pub verdict: Verdict,
}

impl Report {
    pub(super) fn new(directions: Vec<Direction>, worst: Component) -> Self {
        let verdicts = directions.iter().map(|direction| direction.verdict);
        let verdict = verdicts.max().unwrap_or(worst.verdict);
        Report {
            directions,
            worst,
            verdict,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            out,
            "{:>9} {:>15} {:>15} {:>15} {:>15} {:>15} {:>8} {:>8}  verdict",
            "direction", "gradient", "forward", "left", "central", "right", "step", "error"
        )?;
        for (i, row) in self.directions.iter().enumerate() {
            let forward = row
                .forward
                .map_or("-".into(), |slope| format!("{slope:.8e}"));
            writeln!(
                out,
                "{i:>9} {:>15.8e} {forward:>15} {:>15.8e} {:>15.8e} {:>15.8e} {:>8.1e} {:>8.1e}  {}",
                row.gradient, row.left, row.central, row.right, row.step, row.error, row.verdict
            )?;
        }
        let Component {
            index,
            gradient,
            central,
            verdict,
        } = &self.worst;
        writeln!(
            out,
            "worst component {index}: gradient {gradient:.8e}, differences {central:.8e}, {verdict}"
        )?;
        write!(out, "verdict: {}", self.verdict)
    }
}
