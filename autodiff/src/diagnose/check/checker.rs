//! Checks a gradient along random directions, and finds the wrong component.

use super::report::{Component, Direction, Report, Verdict};
use super::slopes::Judge;
use crate::drivers::{self, Function};
use crate::math::DoubleDouble;

/// The options of a gradient check. The default suits functions whose variables are of order one.
#[derive(Clone, Debug)]
pub struct Options {
    /// The number of random directions, each of unit length.
    pub directions: usize,
    /// The step along a direction, as a multiple of the largest `|x_i|` or of 1, whichever is larger. A second step is a
    /// sixteenth of it.
    pub step: f64,
    /// The largest difference between two slopes that still counts as agreement. It is relative to the slope or to the
    /// root mean square of the gradient, whichever is larger. Slopes that change the value by less than some
    /// dozens of roundings in f64, over a step of the length of `x`, agree with 0.
    pub tolerance: f64,
    /// The seed of the random directions.
    pub seed: u64,
    /// The name of each component of the gradient. If there are no names, a report shows indices.
    pub names: Vec<String>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            directions: 4,
            step: 1e-11,
            tolerance: 1e-6,
            seed: 0,
            names: Vec::new(),
        }
    }
}

impl Options {
    /// Returns the default options, with a name for each component of the gradient; for example
    /// [`Parameters::names`](crate::Parameters::names).
    pub fn named(names: Vec<String>) -> Self {
        Self {
            names,
            ..Self::default()
        }
    }
}

/// A function that takes a direction and returns the derivative along it.
pub type Along<'a> = &'a dyn Fn(&[f64]) -> f64;

/// A claimed gradient at a point, which [`check_directions`] checks.
#[derive(Clone, Copy)]
pub struct Claim<'a> {
    /// The point at which the gradient is claimed.
    pub x: &'a [f64],
    /// The claimed gradient at the point.
    pub gradient: &'a [f64],
    /// A second source of derivatives, such as forward mode. It returns the derivative along a direction.
    pub forward: Option<Along<'a>>,
}

impl<'a> Claim<'a> {
    /// Creates the claim that `gradient` is the gradient at `x`, without a second source of derivatives.
    pub fn new(x: &'a [f64], gradient: &'a [f64]) -> Self {
        let forward = None;
        Self {
            x,
            gradient,
            forward,
        }
    }
}

/// Checks the gradient of a generic function at `x`. Reverse mode is compared with forward mode and with difference
/// quotients.
///
/// ```
/// use autodiff::{Function, Real};
/// use autodiff::check::{Options, Verdict, check_gradient};
///
/// struct Norm;
/// impl Function for Norm {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         R::dot(x, x).sqrt()
///     }
/// }
/// let report = check_gradient(&Norm, &[3.0, 4.0], &Options::default());
/// assert_eq!(report.verdict, Verdict::Smooth, "{report}");
/// // Made wrong on purpose, it is called wrong.
/// assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
/// // The remainder is of second order.
/// let order = report.directions[0].taylor.unwrap();
/// assert!((order - 2.0).abs() < 0.1, "{report}");
/// ```
///
/// The next example has a kink. It also has a rule with a wrong partial: forward and reverse mode both use it and so
/// agree, but differences find it.
///
/// ```
/// use autodiff::check::{Options, Verdict, check_gradient};
/// use autodiff::custom::{Rule, apply};
/// use autodiff::{Function, Real};
///
/// #[derive(Clone)]
/// struct Square;
/// impl Rule for Square {
///     fn value<R: Real>(&self, x: &[R]) -> R {
///         x[0] * x[0]
///     }
///     fn partials<R: Real>(&self, x: &[R], _value: R) -> Vec<R> {
///         vec![x[0]] // forgot the 2
///     }
/// }
///
/// /// The work of lifting a mass and of stopping it.
/// struct Work;
/// impl Function for Work {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         let [mass, height, speed] = [x[0], x[1], x[2]];
///         let half = R::lit(0.5);
///         mass * (R::lit(9.81) * height.max(R::zero()) + half * apply(Square, &[speed]))
///     }
/// }
///
/// let options = Options {
///     names: ["mass", "height", "speed"].map(String::from).to_vec(),
///     ..Options::default()
/// };
/// let report = check_gradient(&Work, &[2.0, 0.5, 3.0], &options);
/// assert_eq!(report.verdict, Verdict::Wrong, "{report}");
/// // The slope by the speed is mass * speed = 6; half of it is claimed.
/// let worst = report.worst.as_ref().unwrap();
/// assert_eq!(worst.name.as_deref(), Some("speed"), "{report}");
/// assert_eq!(worst.gradient, 3.0);
/// assert!((worst.central - 6.0).abs() < 1e-6, "{report}");
///
/// // On the ground, at rest: nothing is wrong, but the slopes up and down differ.
/// let report = check_gradient(&Work, &[2.0, 0.0, 0.0], &options);
/// assert_eq!(report.verdict, Verdict::Kink, "{report}");
/// assert_eq!(report.worst.unwrap().name.as_deref(), Some("height"));
/// ```
///
/// # Panics
/// Like [`check_directions`].
#[track_caller]
pub fn check_gradient(function: &impl Function, x: &[f64], options: &Options) -> Report {
    let gradient = drivers::gradient(|x| function.eval(x), x);
    let forward = |direction: &[f64]| function.eval(&drivers::along(x, direction)).tangent[0];
    let claim = Claim {
        x,
        gradient: &gradient,
        forward: Some(&forward),
    };
    check_directions(|x| function.eval(x), &claim, options)
}

/// Checks a claimed gradient against difference quotients of a generic function, which is called with double-doubles. If
/// the claim has a second source of derivatives, the gradient is compared with that too.
///
/// ```
/// use autodiff::check::{Claim, Options, Verdict, check_directions};
///
/// let claim = Claim {
///     x: &[1.0, 2.0],
///     gradient: &[4.0, 1.1], // of x^2 y, whose slopes there are 4 and 1
///     forward: None,
/// };
/// let report = check_directions(|x| x[0] * x[0] * x[1], &claim, &Options::default());
/// assert_eq!(report.verdict, Verdict::Wrong, "{report}");
/// assert_eq!(report.worst.as_ref().unwrap().index, 1, "{report}");
/// let order = report.directions[0].taylor.unwrap();
/// assert!((order - 1.0).abs() < 0.1, "{report}");
/// ```
///
/// # Panics
/// If there is no component or no direction, if the gradient and `x` differ in length, if there are names but not
/// one per component, or if the step is not positive and finite.
#[track_caller]
pub fn check_directions(
    value: impl Fn(&[DoubleDouble]) -> DoubleDouble,
    claim: &Claim,
    options: &Options,
) -> Report {
    checked(&value, claim, options)
}

type Value<'a> = &'a dyn Fn(&[DoubleDouble]) -> DoubleDouble;

/// The body of [`check_directions`]. It takes the function as a trait object, so that it is compiled only once and not
/// for each closure.
#[track_caller]
fn checked(value: Value, claim: &Claim, options: &Options) -> Report {
    refuse_misuse(claim, options);
    let n = claim.x.len();
    let typical = (dot(claim.gradient, claim.gradient) / n as f64).sqrt();
    let x: Vec<DoubleDouble> = claim.x.iter().map(|&x| x.into()).collect();
    let checker = Checker {
        here: value(&x),
        size: largest(claim.x),
        x,
        value,
        claim,
        options,
        // A gradient that is infinite or NaN cannot set the scale.
        typical: if typical.is_finite() { typical } else { 0.0 },
    };
    let mut random = SplitMix(options.seed);
    let mut worst = (0.0, vec![1.0; n]);
    let mut directions = Vec::with_capacity(options.directions);
    for _ in 0..options.directions {
        let direction = normalised((0..n).map(|_| random.next()).collect());
        let checked = checker.check(&direction);
        if checked.error > worst.0 || checked.error.is_nan() {
            worst = (checked.error, direction);
        }
        directions.push(checked);
    }
    Report::new(directions, |verdict| {
        (verdict != Verdict::Smooth).then(|| checker.worst_component(worst.1))
    })
}

#[track_caller]
fn refuse_misuse(claim: &Claim, options: &Options) {
    let (n, names) = (claim.x.len(), options.names.len());
    assert!(n > 0, "a gradient without components cannot be checked");
    assert!(
        options.directions > 0,
        "`directions` is 0; it must be 1 or more"
    );
    assert_eq!(
        n,
        claim.gradient.len(),
        "the gradient needs one component per argument"
    );
    assert!(
        options.step > 0.0 && options.step.is_finite(),
        "`step` is {}; it must be positive and finite",
        options.step
    );
    assert!(
        names == 0 || names == n,
        "{names} names for {n} components; give one name per component, or none"
    );
}

struct Checker<'a> {
    value: Value<'a>,
    x: Vec<DoubleDouble>,
    here: DoubleDouble,
    /// The largest finite magnitude of an argument.
    size: f64,
    claim: &'a Claim<'a>,
    options: &'a Options,
    /// The root mean square of the claimed gradient. A slope along a random direction has about this size.
    typical: f64,
}

impl Checker<'_> {
    fn check(&self, direction: &[f64]) -> Direction {
        let along = |(&g, &d): (&f64, &f64)| if d == 0.0 { 0.0 } else { g * d };
        // A component in which the direction is zero adds 0 to the slope, even if the gradient is infinite there.
        let claimed = self.claim.gradient.iter().zip(direction).map(along).sum();
        let forward = self.claim.forward.map(|forward| forward(direction));
        let Options {
            step, tolerance, ..
        } = *self.options;
        let steps = [step * self.size.max(1.0), self.size];
        let judge = Judge::new(self.here, &|h| self.moved(direction, h), steps);
        let judge = judge.of(claimed, self.typical, tolerance);
        let mut verdict = judge.verdict();
        if forward.is_some_and(|forward| !judge.same(forward)) {
            verdict = Verdict::Wrong;
        }
        let slopes = judge.near;
        Direction {
            gradient: claimed,
            forward,
            left: slopes.left,
            central: slopes.central,
            right: slopes.right,
            step: slopes.step,
            taylor: judge.order(),
            error: (claimed - slopes.central).abs() / judge.scale(slopes.central),
            verdict,
            control: judge.control(verdict),
        }
    }

    /// Returns the component that contributes most to the error along `direction`, found by bisection.
    fn worst_component(&self, mut direction: Vec<f64>) -> Component {
        let (mut first, mut end) = (0, direction.len());
        while end - first > 1 {
            let middle = first + (end - first) / 2;
            let half = |range: std::ops::Range<usize>| {
                let mut half = vec![0.0; direction.len()];
                half[range.clone()].copy_from_slice(&direction[range]);
                let length = dot(&half, &half).sqrt();
                let half = normalised(half);
                let checked = self.check(&half);
                // What this half contributes to the error along `direction`: the error of the slope along the half,
                // times the half's length. A claimed slope of infinity or NaN always counts as the worst.
                let error = if checked.gradient.is_finite() {
                    checked.absolute_error() * length
                } else {
                    f64::INFINITY
                };
                (error, half)
            };
            let (low, high) = (half(first..middle), half(middle..end));
            if low.0 >= high.0 || high.0.is_nan() && !low.0.is_nan() {
                (direction, end) = (low.1, middle);
            } else {
                (direction, first) = (high.1, middle);
            }
        }
        direction.fill(0.0);
        direction[first] = 1.0;
        let checked = self.check(&direction);
        Component {
            index: first,
            name: self.options.names.get(first).cloned(),
            gradient: checked.gradient,
            central: checked.central,
            verdict: checked.verdict,
        }
    }

    fn moved(&self, direction: &[f64], h: f64) -> DoubleDouble {
        let pairs = self.x.iter().zip(direction);
        let moved = |(&x, &d): (&DoubleDouble, &f64)| x + DoubleDouble::from(h * d);
        (self.value)(&pairs.map(moved).collect::<Vec<_>>())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns the largest finite magnitude.
fn largest(x: &[f64]) -> f64 {
    let finite = x.iter().filter(|x| x.is_finite());
    finite.fold(0.0, |size: f64, x| size.max(x.abs()))
}

fn normalised(mut direction: Vec<f64>) -> Vec<f64> {
    let length = dot(&direction, &direction).sqrt();
    direction.iter_mut().for_each(|d| *d /= length);
    direction
}

/// The random number generator SplitMix64 (Steele, Lea and Flood 2014). It is good enough for directions and needs no
/// other crate.
struct SplitMix(u64);

impl SplitMix {
    /// Returns a number that is uniform in `[-1, 1)`.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
