//! The report of a gradient check.

use std::fmt;

/// The relative error of the negative control, which is a gradient that is wrong on purpose: one part in a hundred.
pub const WRONG_BY: f64 = 0.01;

/// The verdict of a check. Verdicts are ordered from good to bad.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The claimed slope is right: the difference quotients of both sides converge to it.
    Smooth,
    /// Difference quotients cannot decide. Either the left and the right slope differ and the claimed slope is between
    /// them, or the two slopes grow apart, or the slope is infinite.
    Kink,
    /// The claimed slope is wrong: the difference quotients have another slope, or forward mode disagrees.
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

/// The result of the check along one direction. Its slopes are per unit length.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Direction {
    /// The claimed slope: the scalar product of the gradient and the direction.
    pub gradient: f64,
    /// The slope from the claim's second source of derivatives, if it has one.
    pub forward: Option<f64>,
    /// The backward difference quotient at `step`.
    pub left: f64,
    /// The central difference quotient at `step`.
    pub central: f64,
    /// The forward difference quotient at `step`.
    pub right: f64,
    /// The smaller step of the difference quotients.
    pub step: f64,
    /// The order at which the remainder of the linear approximation falls with the step `h`. The remainder is `|f(x + h
    /// d) - f(x) - h gradient|`, taken at `h` and at `-h`, whichever is larger. The order is 2 or more if the slope is
    /// right and `f` is smooth. It is 1 if the slope is wrong or if there is a kink. `None` if the remainder is not clear of
    /// rounding errors, as for a linear function.
    pub taylor: Option<f64>,
    /// The error `|gradient - central|`, divided by the slope or by the typical slope, whichever is larger.
    pub error: f64,
    /// The verdict on the claimed slope.
    pub verdict: Verdict,
    /// The negative control: the verdict on a slope that is wrong on purpose, by the relative error [`WRONG_BY`], from
    /// the same difference quotients. `None` if this verdict would prove nothing. This is the case if the claimed slope
    /// is not smooth, or if it is too small.
    pub control: Option<Verdict>,
}

impl Direction {
    pub(super) fn absolute_error(&self) -> f64 {
        (self.gradient - self.central).abs()
    }
}

/// The component of the gradient that contributes most to the error along the worst direction.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Component {
    /// The index of the component.
    pub index: usize,
    /// The name of the component, if [`Options::names`](super::Options::names) has one.
    pub name: Option<String>,
    /// The claimed value of the component.
    pub gradient: f64,
    /// The value of the component by a central difference.
    pub central: f64,
    /// The verdict on the slope along this component alone.
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
    /// The results along the random directions, one for each.
    pub directions: Vec<Direction>,
    /// The component that is most likely to be wrong. `None` if the gradient is smooth.
    pub worst: Option<Component>,
    /// The worst of the directions' verdicts.
    pub verdict: Verdict,
    /// The negative control: the worst verdict that any direction gives on a gradient that is wrong on purpose, by the
    /// relative error [`WRONG_BY`]. The check can be trusted only if this is [`Verdict::Wrong`]. `None` if no direction
    /// can tell, because the function is not smooth along it or the slope is too small.
    pub control: Option<Verdict>,
}

impl Report {
    /// Makes a report. `worst` takes the verdict and finds the worst component.
    pub(super) fn new(
        directions: Vec<Direction>,
        worst: impl FnOnce(Verdict) -> Option<Component>,
    ) -> Self {
        let verdicts = directions.iter().map(|direction| direction.verdict);
        let verdict = verdicts.max().unwrap_or(Verdict::Wrong);
        let control = directions.iter().filter_map(|direction| direction.control);
        let control = control.max();
        Report {
            worst: worst(verdict),
            directions,
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
        if let Some(worst) = &self.worst {
            writeln!(out, "worst component {worst}")?;
        }
        match self.control {
            Some(said) => writeln!(
                out,
                "negative control: a gradient that is wrong on purpose, by {} %, is called {said}",
                100.0 * WRONG_BY
            )?,
            None => writeln!(
                out,
                "negative control: none, because the gradient is wrong, or no direction is smooth and steep enough"
            )?,
        }
        write!(out, "verdict: {}", self.verdict)
    }
}
