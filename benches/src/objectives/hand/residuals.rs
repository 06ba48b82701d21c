//! Computes the residuals and their Jacobian, in lanes over the measured points.

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Dual, Real};
use cosmic::kernel;

use super::instance::{THETA, Target};
use super::pose::Skin;

/// The largest number of lanes of any register.
const WIDEST: usize = 16;

/// Returns one coordinate of the difference between a measured point and its point on the skin.
#[inline(always)]
fn residual<R: Real>(point: R, u: [R; 2], corners: [R; 3]) -> R {
    let last = R::one() - u[0] - u[1];
    point - (u[0] * corners[0] + u[1] * corners[1] + last * corners[2])
}

/// Computes the residuals of all targets. Unless `jacobian` is empty, also computes the rows of the Jacobian. A row has
/// the derivatives with respect to `u1` and `u2`, if it has room for them, and then those with respect to `theta`.
pub(super) struct Residuals<'a> {
    pub(super) targets: &'a [Target],
    pub(super) skin: &'a Skin,
    pub(super) residuals: &'a mut [f64],
    pub(super) jacobian: &'a mut [f64],
}

#[kernel]
impl Vectorized<f64> for Residuals<'_> {
    type Output = ();
    fn run<L: Lane<f64>>(self) {
        let columns = self.jacobian.len() / self.residuals.len();
        for first in (0..self.targets.len()).step_by(L::N) {
            let here = Here::new(self.targets, first);
            let u = [
                here.gather(|target| target.u[0]),
                here.gather(|target| target.u[1]),
            ];
            for i in 0..3 {
                let row = 3 * first + i;
                let point: L = here.gather(|target| target.point[i]);
                let corners = here.corners::<L>(&self.skin.places[i]);
                let gap = residual(point, u, corners);
                here.scatter(gap, &mut self.residuals[row..], 3);
                if columns == 0 {
                    continue;
                }
                let jacobian = &mut self.jacobian[row * columns..];
                let own = columns - THETA;
                let by_u = slopes_by_u(point, u, corners);
                for d in 0..own {
                    here.scatter(by_u[d], &mut jacobian[d..], 3 * columns);
                }
                // The residual is linear in the positions of the skin. So applied to derivatives of the positions, it
                // gives derivatives of the residual.
                for d in 0..THETA {
                    let slopes = here.corners(&self.skin.derivatives[d][i]);
                    let slope = residual(L::zero(), u, slopes);
                    here.scatter(slope, &mut jacobian[own + d..], 3 * columns);
                }
            }
        }
    }
}

/// Returns the derivatives of a residual with respect to `u1` and `u2`.
#[inline(always)]
fn slopes_by_u<L: Lane<f64>>(point: L, u: [L; 2], [a, b, c]: [L; 3]) -> [L; 2] {
    let corners = [Dual::constant(a), Dual::constant(b), Dual::constant(c)];
    let u = [Dual::variable(u[0], 0), Dual::variable(u[1], 1)];
    residual(Dual::constant(point), u, corners).tangent
}

/// The targets of all lanes, one for each lane. If there are too few, the last target is repeated.
struct Here<'a> {
    targets: &'a [Target],
    /// For each of the three corners, the vertex of each target.
    corners: [[usize; WIDEST]; 3],
}

impl<'a> Here<'a> {
    #[inline(always)]
    fn new(targets: &'a [Target], first: usize) -> Self {
        let targets = &targets[first..];
        let mut corners = [[0; WIDEST]; 3];
        for lane in 0..WIDEST {
            let target = &targets[lane.min(targets.len() - 1)];
            for k in 0..3 {
                corners[k][lane] = target.corners[k];
            }
        }
        Self { targets, corners }
    }

    /// Writes each lane to a list. The entries for consecutive lanes are `stride` apart. Repeated targets are left out.
    #[inline(always)]
    fn scatter<L: Lane<f64>>(&self, values: L, to: &mut [f64], stride: usize) {
        let mut lanes = [0.0; WIDEST];
        values.store(&mut lanes);
        for lane in 0..L::N.min(self.targets.len()) {
            to[lane * stride] = lanes[lane];
        }
    }

    #[inline(always)]
    fn gather<L: Lane<f64>>(&self, number: impl Fn(&Target) -> f64) -> L {
        let mut lanes = [0.0; WIDEST];
        for lane in 0..L::N {
            lanes[lane] = number(&self.targets[lane.min(self.targets.len() - 1)]);
        }
        L::load(&lanes)
    }

    /// Loads, for each target, the numbers that belong to its three vertices. `of_vertices` is a coordinate of the skin
    /// or a derivative of it.
    #[inline(always)]
    fn corners<L: Lane<f64>>(&self, of_vertices: &[f64]) -> [L; 3] {
        let mut numbers = [L::zero(); 3];
        for k in 0..3 {
            let mut lanes = [0.0; WIDEST];
            for lane in 0..L::N {
                lanes[lane] = of_vertices[self.corners[k][lane]];
            }
            numbers[k] = L::load(&lanes);
        }
        numbers
    }
}
