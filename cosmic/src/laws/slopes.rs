//! The tension of bars, and how it changes with the length and its rate: what an implicit step needs of forces along
//! bars.

use autodiff::{Dual, Real};
use autodiff_programs::kernels::{MOST_UNIFORMS, constants, seeded};
use autodiff_programs::{Array, Compiled, Kernel, Pullback};

use super::bar::{Bar, BarForce, four};
use crate::geometry::{Symmetric, Vector};
use crate::lattice::EdgeVector;
use crate::{in_both_dimensions, kernel};

/// A small share of a stroke, and a small rate, m/s: a law may have a kink at the target and at rest, so slopes are also
/// taken beside these.
pub(super) const BESIDE: f64 = 1e-6;

/// The tension of every bar (N), and its derivatives with respect to the length (N/m) and to the rate (N s/m).
#[derive(Clone, Copy, Debug)]
pub struct Tensions {
    /// The tension, N.
    pub tension: Array,
    /// Its derivative with respect to the length, N/m.
    pub by_length: Array,
    /// Its derivative with respect to the rate of the length, N s/m.
    pub by_rate: Array,
}

impl Tensions {
    /// The three arrays, in the order of the fields.
    pub fn array(self) -> [Array; 3] {
        [self.tension, self.by_length, self.by_rate]
    }
}

impl From<[Array; 3]> for Tensions {
    fn from([tension, by_length, by_rate]: [Array; 3]) -> Self {
        Self {
            tension,
            by_length,
            by_rate,
        }
    }
}

/// The kernel of a law along bars with its slopes, which come from dual numbers. The inputs are the vector along the bar
/// (m), the relative velocity of its ends (m/s), the activation, the stiffness (N/m), the rest length (m) and the strain at
/// full activation; the results are the numbers of [`Tensions`]. The uniform inputs are the law's settings.
///
/// At a kink in the rate, the slope is the largest one beside the kink. From rest, Newton's method would otherwise believe
/// that an actuator at its limit keeps its force at any speed, and rounding would choose between the two slopes.
#[derive(Clone, Debug)]
pub(super) struct Slopes<L> {
    pub(super) law: L,
    /// The [softening](crate::lattice::Lattice::softening) of lengths, m^2.
    pub(super) softening: f64,
    /// The largest strain of the actuator material.
    pub(super) largest_strain: f64,
}

impl<L: BarForce> Slopes<L> {
    /// The tension with its derivatives with respect to the length and to the rate.
    #[inline(always)]
    fn tension<R: Real>(
        &self,
        [length, rate]: [R; 2],
        given: [R; 4],
        settings: &[R],
    ) -> Dual<R, 2> {
        let settings: [_; MOST_UNIFORMS] = constants(&settings[..L::COUNT]);
        let bar = Bar::new(
            seeded([length, rate]),
            constants(&given),
            self.largest_strain,
        );
        L::tension(&self.law.of(&settings), bar)
    }
}

in_both_dimensions! { D =>
    #[kernel]
    impl<L: BarForce> Kernel<{ 2 * D + 4 }, 3> for Slopes<L> {
        const COMPILED: Compiled = L::COMPILED.at_most(Compiled::Seldom);
        const UNIFORMS: usize = L::COUNT;

        fn eval<R: Real>(&self, x: [R; 2 * D + 4], settings: &[R]) -> [R; 3] {
            let (edge, given) = EdgeVector::<R, D>::split(&x);
            self.of_bar(edge, four(given), settings)
        }
    }
}

impl<L: BarForce> Slopes<L> {
    /// The numbers of [`Tensions`].
    #[inline(always)]
    fn of_bar<R: Real, const D: usize>(
        &self,
        edge: EdgeVector<R, D>,
        given: [R; 4],
        settings: &[R],
    ) -> [R; 3] {
        let length = edge.length(self.softening);
        let rate = edge.rate(length);
        let at = self.tension([length, rate], given, settings);
        let [by_length, mut by_rate] = at.tangent;
        if L::NEEDS_RATE {
            for beside in [-BESIDE, BESIDE] {
                let moved = [length, rate + R::lit(beside)];
                let slope = self.tension(moved, given, settings).tangent[1];
                by_rate = R::select(by_rate.less(slope), slope, by_rate);
            }
        }
        [at.value, by_length, by_rate]
    }
}

/// The kernel of a bar's impulse over a step, as a linear function of the relative velocity of its ends during the step.
///
/// The inputs are the vector along the bar and the relative velocity of its ends at the base of the linearisation, and
/// the [`Tensions`]. The results are the impulse on the first node (N s) if the ends move with that velocity, and the
/// lower triangle of the matrix `S` by which another velocity changes it (kg). Negative slopes count as 0, and so does the
/// tension of a compressed bar across its axis, because `S` must not be negative.
#[derive(Clone, Copy, Debug)]
pub struct Linear<const D: usize> {
    /// The duration of the step, s.
    pub dt: f64,
    /// The softening of lengths, m^2.
    pub softening: f64,
    /// 1 if the base is the start of the step, from which the ends move; 0 if it is the end of the step.
    pub lead: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 2 * D + 3 }, { D + D * (D + 1) / 2 }> for Linear<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, bar: [R; 2 * D + 3], _: &[R]) -> [R; D + D * (D + 1) / 2] {
            let (edge, rest) = EdgeVector::<R, D>::split(&bar);
            let (tension, by_length, by_rate) = (rest[0], rest[1], rest[2]);
            let (zero, dt) = (R::zero(), R::lit(self.dt));
            let length = edge.length(self.softening);
            let u = edge.d / length;
            let along = dt * dt * by_length.max(zero);
            let across = dt * dt * tension.max(zero) / length;
            let moved = Symmetric::scaling(u, along, across) * edge.dv;
            let impulse = moved.fma(R::lit(self.lead), u * (dt * tension));
            let slopes = Symmetric::scaling(u, dt.fma(by_rate.max(zero), along), across);
            let mut linear = [R::zero(); D + D * (D + 1) / 2];
            impulse.write(&mut linear);
            slopes.write(&mut linear[D..]);
            linear
        }

        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 2 * D + 3 }, { D + D * (D + 1) / 2 }, M>,
        ) -> [[R; 2 * D + 3]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel that evaluates the linear function of [`Linear`]: the impulse of a bar (N s) for the relative velocity of its
/// ends, measured from the base.
#[derive(Clone, Copy, Debug)]
pub struct Impulse<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 2 * D + D * (D + 1) / 2 }, D> for Impulse<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, bar: [R; 2 * D + D * (D + 1) / 2], _: &[R]) -> [R; D] {
            let ([change, impulse], slopes) = Vector::<R, D>::split(&bar);
            (impulse + Symmetric::first_of(slopes) * change).array()
        }

        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 2 * D + D * (D + 1) / 2 }, D, M>,
        ) -> [[R; 2 * D + D * (D + 1) / 2]; M] {
            self.emitted_vjp(at)
        }
    }
}
