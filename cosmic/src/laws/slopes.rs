//! The tension of bars, and how it changes with the length and its rate: what an implicit step needs of forces along
//! bars.

use autodiff::arrays::{MOST_UNIFORMS, UniformKernel, Uniforms};
use autodiff::{Array, Dual, Kernel, Real};

use super::bar::{Bar, BarForce};
use crate::geometry::{Symmetric, Vector};
use crate::lattice::EdgeVector;

/// The arrays of bars from which forces along them follow. Each has a number for every slot of the graph.
pub struct Stretched {
    /// The length of the bar, m, and its rate, m/s.
    pub length: [Array; 2],
    /// The controller's output.
    pub activation: Array,
    /// Stiffness, N/m.
    pub stiffness: Array,
    /// Rest length, m.
    pub rest_length: Array,
    /// Strain at full activation.
    pub strain: Array,
}

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
    pub(crate) fn array(self) -> [Array; 3] {
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

/// The kernel of a law along bars with its slopes, which come from dual numbers. It maps the arrays of [`Stretched`] to
/// those of [`Tensions`]. The uniform inputs are the law's settings.
#[derive(Clone, Debug)]
pub(super) struct Slopes<L>(pub(super) L);

impl<L: BarForce> UniformKernel<6, 3> for Slopes<L> {
    const UNIFORMS: usize = L::COUNT;

    #[inline(always)]
    fn eval_with<R: Real>(&self, x: [R; 6], settings: &Uniforms<R>) -> [R; 3] {
        let mut moving = [Dual::<R, 2>::constant(R::zero()); 6];
        let mut constants = [Dual::<R, 2>::constant(R::zero()); MOST_UNIFORMS];
        for k in 0..6 {
            moving[k] = Dual::constant(x[k]);
        }
        for k in 0..L::COUNT {
            constants[k] = Dual::constant(settings[k]);
        }
        let [.., activation, stiffness, rest_length, strain] = moving;
        let (length, rate) = (Dual::variable(x[0], 0), Dual::variable(x[1], 1));
        let bar = Bar::new(length, rate, [activation, stiffness, rest_length, strain]);
        let tension = L::tension(&self.0.of(&constants), bar);
        [tension.value, tension.tangent[0], tension.tangent[1]]
    }
}

/// The kernel that describes a bar by its ends. The inputs are the position and the velocity of its first node, then
/// those of its second node. The results are its length (m), the rate of the length (m/s), the unit vector along it, and
/// the velocity of the second node relative to the first (m/s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Along {
    /// The [softening](crate::lattice::Lattice::softening) of lengths, m^2.
    pub(crate) softening: f64,
}

impl Kernel<8, 6> for Along {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, to_x, to_y, to_vx, to_vy]: [R; 8]) -> [R; 6] {
        let edge = EdgeVector {
            d: Vector::new([to_x, to_y]) - Vector::new([x, y]),
            dv: Vector::new([to_vx, to_vy]) - Vector::new([vx, vy]),
        };
        let length = edge.length(self.softening);
        let ([ux, uy], [dvx, dvy]) = ((edge.d / length).array(), edge.dv.array());
        [length, edge.rate(length), ux, uy, dvx, dvy]
    }
}

/// The kernel of a bar's impulse over a step, as a linear function of the relative velocity of its ends during the step.
///
/// The inputs are the [`Tensions`], the length, the unit vector `u` along the bar, and the relative velocity of the ends
/// at the base of the linearisation. The results are the impulse on the first node (N s) if the ends move with that
/// velocity, and the lower triangle of the matrix `S` by which another velocity changes it (kg). Negative slopes count as
/// 0, and so does the tension of a compressed bar across its axis, because `S` must not be negative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Linear {
    /// The duration of the step, s.
    pub(crate) dt: f64,
    /// True if the base is the start of the step, from which the ends move; false if it is the end of the step.
    pub(crate) from_start: bool,
}

impl Kernel<8, 5> for Linear {
    #[inline(always)]
    fn eval<R: Real>(
        &self,
        [tension, by_length, by_rate, length, ux, uy, dvx, dvy]: [R; 8],
    ) -> [R; 5] {
        let (zero, dt) = (R::zero(), R::lit(self.dt));
        let (u, dv) = (Vector::new([ux, uy]), Vector::new([dvx, dvy]));
        let along = dt * dt * by_length.max(zero);
        let across = dt * dt * tension.max(zero) / length;
        let mut impulse = u * (dt * tension);
        if self.from_start {
            impulse += Symmetric::scaling(u, along, across) * dv;
        }
        let slopes = Symmetric::scaling(u, dt.fma(by_rate.max(zero), along), across);
        let ([jx, jy], [xx, xy, yy]) = (impulse.array(), slopes.array());
        [jx, jy, xx, xy, yy]
    }
}

/// The kernel that evaluates the linear function of [`Linear`]: the impulse of a bar (N s) for the relative velocity of its
/// ends, measured from the base.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Impulse;

impl Kernel<7, 2> for Impulse {
    #[inline(always)]
    fn eval<R: Real>(&self, [ex, ey, jx, jy, xx, xy, yy]: [R; 7]) -> [R; 2] {
        let changed = Symmetric::new([xx, xy, yy]) * Vector::new([ex, ey]);
        (Vector::new([jx, jy]) + changed).array()
    }
}
