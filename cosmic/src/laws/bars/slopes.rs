//! The tension of bars, and how it changes with the length and its rate: what an implicit step needs of forces along
//! bars.

use autodiff::{Dual, Real};
use autodiff_programs::kernels::{MOST_UNIFORMS, constants, seeded};
use autodiff_programs::{Array, Compiled, Kernel, Pullback};

use super::bar::{Bar, BarForce, EdgeNumbers, MovingBar};
use crate::geometry::{Symmetric, Vector};
use crate::lattice::EdgeVector;
use crate::{Fields, in_both_dimensions, kernel};

/// A small share of a stroke, and a small rate, m/s: a law may have a kink at the target and at rest, so slopes are also
/// taken beside these.
pub(in crate::laws) const BESIDE: f64 = 1e-6;

/// The tension of a bar and its derivatives, or of every bar as arrays.
#[derive(Clone, Copy, Debug, Fields)]
pub struct Tensions<T = Array> {
    /// The tension, N.
    pub tension: T,
    /// Its derivative with respect to the length, N/m.
    pub by_length: T,
    /// Its derivative with respect to the rate of the length, N s/m.
    pub by_rate: T,
}

/// The kernel of a law along bars with its slopes, which come from dual numbers. It reads a [`MovingBar`]. The uniform inputs
/// are the law's settings.
///
/// At a kink in the rate, the slope is the largest one beside the kink. From rest, Newton's method would otherwise believe
/// that an actuator at its limit keeps its force at any speed, and rounding would choose between the two slopes.
#[derive(Clone, Debug)]
pub(in crate::laws) struct Slopes<L, const D: usize> {
    pub(in crate::laws) law: L,
    /// The [softening](crate::lattice::Lattice::softening) of lengths, m^2.
    pub(in crate::laws) softening: f64,
    /// The largest strain of the actuator material.
    pub(in crate::laws) largest_strain: f64,
}

impl<L: BarForce, const D: usize> Slopes<L, D> {
    /// The tension with its derivatives with respect to the length and to the rate.
    #[inline(always)]
    fn tension<R: Real>(
        &self,
        [length, rate]: [R; 2],
        numbers: EdgeNumbers<R>,
        settings: &[R],
    ) -> Dual<R, 2> {
        let settings: [_; MOST_UNIFORMS] = constants(&settings[..L::COUNT]);
        let numbers: [_; 4] = constants(&numbers.array::<4>());
        let bar = Bar::new(
            seeded([length, rate]),
            EdgeNumbers::of(numbers),
            self.largest_strain,
        );
        L::tension(&self.law.of(&settings), bar)
    }

    #[inline(always)]
    fn of_bar<R: Real>(&self, bar: MovingBar<R, D>, settings: &[R]) -> Tensions<R> {
        let MovingBar { edge, numbers } = bar;
        let length = edge.length(self.softening);
        let rate = edge.rate(length);
        let at = self.tension([length, rate], numbers, settings);
        let [by_length, mut by_rate] = at.tangent;
        if L::NEEDS_RATE {
            for beside in [-BESIDE, BESIDE] {
                let moved = [length, rate + R::lit(beside)];
                let slope = self.tension(moved, numbers, settings).tangent[1];
                by_rate = R::select(by_rate.less(slope), slope, by_rate);
            }
        }
        Tensions {
            tension: at.value,
            by_length,
            by_rate,
        }
    }
}

in_both_dimensions! { D =>
    #[kernel]
    impl<L: BarForce> Kernel<_, _> for Slopes<L, D> {
        const COMPILED: Compiled = L::COMPILED.at_most(Compiled::Seldom);
        const UNIFORMS: usize = L::COUNT;

        fn eval<R: Real>(&self, bar: MovingBar<R, D>, settings: &[R]) -> Tensions<R> {
            self.of_bar(bar, settings)
        }
    }
}

/// A bar at the base of a linearisation.
#[derive(Clone, Copy, Fields)]
pub(crate) struct BarAtBase<T, const D: usize> {
    /// The vector along the bar, and the relative velocity of its ends.
    pub(crate) edge: EdgeVector<T, D>,
    pub(crate) tensions: Tensions<T>,
}

/// A bar's impulse over a step, as a linear function of the relative velocity of its ends during the step.
#[derive(Clone, Copy, Fields)]
pub(crate) struct LinearBar<T, const D: usize> {
    /// The impulse on the first node, N s, if the ends move with the velocity of the base.
    pub(crate) impulse: Vector<T, D>,
    /// The matrix by which another velocity changes it, kg.
    pub(crate) slopes: Symmetric<T, D>,
}

/// The kernel of the linear function of a bar. Negative slopes count as 0, and so does the tension of a compressed bar across
/// its axis, because the matrix must not be negative.
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
    impl Kernel<_, _> for Linear<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, bar: BarAtBase<R, D>, _: &[R]) -> LinearBar<R, D> {
            let (edge, Tensions { tension, by_length, by_rate }) = (bar.edge, bar.tensions);
            let (zero, dt) = (R::zero(), R::lit(self.dt));
            let length = edge.length(self.softening);
            let u = edge.d / length;
            let along = dt * dt * by_length.max(zero);
            let across = dt * dt * tension.max(zero) / length;
            let moved = Symmetric::scaling(u, along, across) * edge.dv;
            LinearBar {
                impulse: moved.fma(R::lit(self.lead), u * (dt * tension)),
                slopes: Symmetric::scaling(u, dt.fma(by_rate.max(zero), along), across),
            }
        }

        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// A bar whose velocity differs from that of the base.
#[derive(Clone, Copy, Fields)]
pub(crate) struct ChangedBar<T, const D: usize> {
    /// The change of the relative velocity of its ends, m/s.
    pub(crate) change: Vector<T, D>,
    pub(crate) linear: LinearBar<T, D>,
}

/// The kernel that evaluates the linear function of a bar: its impulse, N s.
#[derive(Clone, Copy, Debug)]
pub struct Impulse<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for Impulse<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, bar: ChangedBar<R, D>, _: &[R]) -> Vector<R, D> {
            bar.linear.impulse + bar.linear.slopes * bar.change
        }

        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            self.emitted_vjp(at)
        }
    }
}
