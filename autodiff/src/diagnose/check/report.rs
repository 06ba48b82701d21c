//! The findings of a gradient check.

use std::fmt;

/// The relative error of the negative control: one part in a hundred.
pub const WRONG_BY: f64 = 0.01;

/// The verdict of a check; ordered from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The differences settle on the claimed slope from both sides.
    Smooth,
    /// Differences cannot tell. The claimed slope is between the left and the right slope, which differ or
    /// grow apart, or no step makes the differences settle.
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

/// The check along one direction. Slopes are per unit length.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Direction {
    /// The claimed slope: the gradient times the direction.
    pub gradient: f64,
    /// The slope from the claim's second source of derivatives, if it has one.
    pub forward: Option<f64>,
    /// The backward difference quotient at `step`.
    pub left: f64,
    /// The central difference quotient at `step`.
    pub central: f64,
    /// The forward difference quotient at `step`.
    pub right: f64,
    /// The step that the verdict rests on.
    pub step: f64,
    /// The order at which the remainder `|f(x + h d) - f(x) - h gradient|`, the larger one ahead and behind, falls
    /// with the step `h`. It is 2 or more if the slope is right and `f` smooth, and 1 if the slope is wrong or at a
    /// kink. It is measured at the smallest steps whose remainders are clear of rounding. `None` if no two of them
    /// are clear, as for a linear function.
    pub taylor: Option<f64>,
    /// `|gradient - central|`, relative to the slope and the typical slope.
    pub error: f64,
    /// The possible error of `central`, on the scale of `error`: an estimate from the neighbouring steps,
    /// infinite if the differences do not settle.
    pub unsure: f64,
    /// The verdict.
    pub verdict: Verdict,
    /// The verdict of the differences on a slope that is wrong on purpose, by the relative error [`WRONG_BY`]. `None`
    /// if the slope is not smooth, or if its uncertainty exceeds a quarter of that error, because the verdict would
    /// prove nothing then.
    pub control: Option<Verdict>,
}

impl Direction {
    pub(super) fn absolute_error(&self) -> f64 {
        (self.gradient - self.central).abs()
    }
}

/// The component that contributes most to the error of the worst direction.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Component {
    /// Its index.
    pub index: usize,
    /// Its name, if [`Options::names`](super::Options::names) has one.
    pub name: Option<String>,
    /// The claimed component.
    pub gradient: f64,
    /// Its central difference.
    pub central: f64,
    /// The verdict along this component.
    pub verdict: Verdict,
}

/// Displays the name (or the index, if there is no name) and the finding.
impl fmt::Display for Component {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            Some(name) => write!(out, "{name}")?,
            None => write!(out, "{}", self.index)?,
        }
        write!(
            out,
            ": gradient {:.8e}, differences {:.8e}, {}",
            self.gradient, self.central, self.verdict
        )
    }
}

/// The outcome of a check, displayed as a table.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Report {
    /// One row per random direction.
    pub directions: Vec<Direction>,
    /// The component to look at first.
    pub worst: Component,
    /// The worst verdict of any direction.
    pub verdict: Verdict,
    /// The negative control: the worst verdict of any direction on a gradient that is wrong on purpose, by the
    /// relative error [`WRONG_BY`]. The check can be trusted only if this is [`Verdict::Wrong`]. `None` if no
    /// direction is smooth and steep enough to tell.
    pub control: Option<Verdict>,
}

impl Report {
    pub(super) fn new(directions: Vec<Direction>, worst: Component) -> Self {
        let verdicts = directions.iter().map(|direction| direction.verdict);
        let verdict = verdicts.max().unwrap_or(worst.verdict);
        let control = directions.iter().filter_map(|direction| direction.control);
        let control = control.max();
        Report {
            directions,
            worst,
            verdict,
            control,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{:>9} ", "direction")?;
        for slope in ["gradient", "forward", "left", "central", "right"] {
            write!(out, "{slope:>15} ")?;
        }
        let [step, error, taylor] = ["step", "error", "taylor"];
        writeln!(out, "{step:>8} {error:>8} {taylor:>7}  verdict")?;
        let or_dash = |shown: Option<String>| shown.unwrap_or_else(|| "-".into());
        for (i, row) in self.directions.iter().enumerate() {
            let forward = or_dash(row.forward.map(|slope| format!("{slope:.8e}")));
            let taylor = or_dash(row.taylor.map(|order| format!("{order:.2}")));
            write!(out, "{i:>9} {:>15.8e} {forward:>15} ", row.gradient)?;
            for slope in [row.left, row.central, row.right] {
                write!(out, "{slope:>15.8e} ")?;
            }
            let (step, error, verdict) = (row.step, row.error, row.verdict);
            writeln!(out, "{step:>8.1e} {error:>8.1e} {taylor:>7}  {verdict}")?;
        }
        writeln!(out, "worst component {}", self.worst)?;
        match self.control {
            Some(said) => writeln!(
                out,
                "negative control: a gradient that is wrong on purpose, by {} %, is called {said}",
                100.0 * WRONG_BY
            )?,
            None if self.verdict == Verdict::Wrong => {
                writeln!(
                    out,
                    "negative control: none, because the gradient itself is wrong"
                )?;
            }
            None => writeln!(
                out,
                "negative control: none, because no direction is smooth and steep enough for differences"
            )?,
        }
        write!(out, "verdict: {}", self.verdict)
    }
}
