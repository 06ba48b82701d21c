//! Gradient clipping.

use autodiff::{Mask, Real};

/// Gradient clipping: a bound on the norm of the state's cotangent in the reverse sweep. A cotangent with a larger norm
/// is scaled down to the bound, so the result is no longer the exact gradient. Computing the norm does not overflow. If
/// a number of the cotangent is infinite or NaN, the whole cotangent becomes NaN. Derivatives of a clipped gradient
/// treat the scaling factor as a constant, so Hessians are not exact and may not be symmetric.
///
/// ```
/// use autodiff::{Real, Var, gradient};
/// use autodiff_programs::{CotangentBound, Kernel, Model, Program, Rollout, kernel};
///
/// /// Each step doubles `x`.
/// #[derive(Clone, Copy)]
/// struct Doubling;
///
/// #[kernel]
/// impl Kernel<1, 1> for Doubling {
///     fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
///         [x + x]
///     }
/// }
///
/// impl Model for Doubling {
///     fn record(&self, program: &mut Program) {
///         let x = program.state(1);
///         let [next] = program.map(Doubling, [x], &[]);
///         program.advance(x, next);
///     }
/// }
///
/// let slope = |rollout: Rollout<Doubling>| gradient(|x: &[Var<f64>]| rollout.run(x, &[])[0], &[1.0]);
/// assert_eq!(slope(Rollout::new(Doubling, 10)), [1024.0]);
/// let bound = CotangentBound { norm: 5.0, every: 1 };
/// let bounded = Rollout { cotangent_bound: Some(bound), ..Rollout::new(Doubling, 10) };
/// assert_eq!(slope(bounded), [5.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CotangentBound {
    /// The largest allowed Euclidean norm; 0 or more.
    pub norm: f64,
    /// The cotangent is checked before step 0 and then after every `every` steps; 1 or more.
    pub every: usize,
}

impl CotangentBound {
    /// Scales down the cotangent of each start whose norm exceeds the bound. `state_bar` is the cotangent of the state
    /// after `step` steps. Its norm is computed in `units`, which are [`Rollout::cotangent_units`].
    ///
    /// [`Rollout::cotangent_units`]: super::Rollout::cotangent_units
    pub(super) fn clip<R: Real>(
        self,
        step: usize,
        starts: usize,
        units: Option<&[f64]>,
        state_bar: &mut [R],
    ) {
        if !step.is_multiple_of(self.every) || state_bar.is_empty() {
            return;
        }
        let limit = R::lit(self.norm);
        for start in 0..starts {
            let of_start = state_bar[start..].iter().step_by(starts);
            let mut of_start: Vec<R> = of_start.copied().collect();
            let unit_of = |k: usize| units.map(|units| R::lit(units[k]));
            for (k, bar) in of_start.iter_mut().enumerate() {
                *bar = unit_of(k).map_or(*bar, |unit| *bar / unit);
            }
            let (squared, unit) = measure(&mut of_start);
            let in_units = limit / unit;
            let exceeds = (in_units * in_units).less(squared) | !squared.finite();
            // If a number is infinite, the factor would be 0 and hide the other numbers. So it is set to NaN.
            let factor = limit * squared.rsqrt();
            let factor = R::select(squared.finite(), factor, R::lit(f64::NAN));
            let bars = state_bar[start..].iter_mut().step_by(starts);
            for (k, (bar, measured)) in bars.zip(of_start).enumerate() {
                let clipped = measured * factor;
                let clipped = unit_of(k).map_or(clipped, |unit| clipped * unit);
                *bar = R::select(exceeds, clipped, *bar);
            }
        }
    }
}

/// Divides `numbers` in place by a unit. Returns the sum of the squares of the quotients, and the unit. The unit is 1
/// or the largest magnitude. It is chosen so that the squares do not overflow and do not underflow noticeably.
fn measure<R: Real>(numbers: &mut [R]) -> (R, R) {
    let squared = R::dot(numbers, numbers).detach();
    // Squares that underflow, even in single precision, are below 1e-38 and therefore negligible.
    let fits = R::lit(1e-30).less_equal(squared) & squared.finite();
    if fits.all() {
        return (squared, R::one());
    }
    let magnitudes = numbers.iter().map(|x| x.detach().abs());
    let largest = magnitudes.fold(R::zero(), |largest, x| x.max(largest));
    let unit = R::select(fits | largest.less_equal(R::zero()), R::one(), largest);
    for number in &mut *numbers {
        *number /= unit;
    }
    (R::dot(numbers, numbers).detach(), unit)
}
