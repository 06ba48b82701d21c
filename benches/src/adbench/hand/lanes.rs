//! The hand's work in SIMD lanes: over vertices, then over correspondences.

use autodiff::Dual;
use autodiff::simd::{Lane, Vectorized};
use num_traits::Zero;

use super::model::HandModel;
use super::skin::{FINGERS, GLOBAL, JOINTS, THETA, Target, blend, residual};
use super::transform::{Affine, lift, splat};

/// The directions of a correspondence: its own `u1 u2`, then `theta`.
const DIRECTIONS: usize = 2 + THETA;
/// At least as many as any register has lanes.
const WIDEST: usize = 16;

/// The skin posed, and its derivatives by `theta`; by coordinate, then vertex.
pub(super) struct Skin {
    pub(super) places: [Vec<f64>; 3],
    pub(super) derivatives: Vec<[Vec<f64>; 3]>,
}

/// Poses all vertices.
pub(super) struct Pose<'a> {
    pub(super) model: &'a HandModel,
    pub(super) bones: &'a [Affine<f64>],
    pub(super) global: &'a Affine<f64>,
    pub(super) skin: &'a mut Skin,
}

impl Vectorized<f64> for Pose<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<f64>>(self) {
        let mut bones = Vec::with_capacity(self.bones.len());
        for bone in self.bones {
            bones.push(splat::<L>(bone));
        }
        let global = splat(self.global);
        let mut weights = vec![L::zero(); bones.len()];
        for first in (0..self.model.len).step_by(L::N) {
            for (weight, column) in weights.iter_mut().zip(&self.model.weights) {
                *weight = L::load(&column[first..]);
            }
            let vertex = load(&self.model.vertices, first);
            let posed = global.apply(blend(&bones, &weights, vertex));
            store(posed, &mut self.skin.places, first);
        }
    }
}

/// Poses all vertices, with derivatives.
pub(super) struct PoseDerivatives<'a> {
    pub(super) model: &'a HandModel,
    /// Each along the directions of its own finger.
    pub(super) bones: &'a [Affine<Dual<f64, JOINTS>>],
    pub(super) global: &'a Affine<Dual<f64, GLOBAL>>,
    pub(super) skin: &'a mut Skin,
}

impl Vectorized<f64> for PoseDerivatives<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<f64>>(mut self) {
        self.still::<L>();
        for finger in 0..FINGERS {
            self.finger::<L>(finger);
        }
        self.whole::<L>();
    }
}

impl PoseDerivatives<'_> {
    /// Begins the skin with what the bones contribute that no angle moves: wrist, forearm and
    /// the fingers' roots.
    #[inline(always)]
    fn still<L: Lane<f64>>(&mut self) {
        let mut still = [0; 2 + FINGERS];
        still[1] = self.bones.len() - 1;
        let mut bones = [Affine([[L::zero(); 4]; 3]); 2 + FINGERS];
        for i in 0..2 + FINGERS {
            if i >= 2 {
                still[i] = 1 + JOINTS * (i - 2);
            }
            bones[i] = splat(&self.bones[still[i]].map(primal));
        }
        let mut weights = [L::zero(); 2 + FINGERS];
        for first in (0..self.model.len).step_by(L::N) {
            for i in 0..2 + FINGERS {
                weights[i] = L::load(&self.model.weights[still[i]][first..]);
            }
            let part = blend(&bones, &weights, load(&self.model.vertices, first));
            store(part, &mut self.skin.places, first);
        }
    }

    /// Adds the part of a finger, its root left out. The derivatives by its angles come from that
    /// part alone. Blending and turning are linear in the bones: what makes the part of the bones makes
    /// its derivatives of theirs.
    #[inline(always)]
    fn finger<L: Lane<f64>>(&mut self, finger: usize) {
        const MOVING: usize = JOINTS - 1;
        let bone = 2 + JOINTS * finger;
        let mut bones = [Affine([[L::zero(); 4]; 3]); MOVING];
        let mut slopes = [bones; JOINTS];
        for joint in 0..MOVING {
            let moving = &self.bones[bone + joint];
            bones[joint] = splat(&moving.map(primal));
            for d in 0..JOINTS {
                slopes[d][joint] = splat(&moving.map(|number| number.tangent[d]));
            }
        }
        let turn = splat::<L>(&self.global.map(primal).linear());
        let column = GLOBAL + JOINTS * finger;
        let mut weights = [L::zero(); MOVING];
        for first in (0..self.model.len).step_by(L::N) {
            for joint in 0..MOVING {
                weights[joint] = L::load(&self.model.weights[bone + joint][first..]);
            }
            let vertex = load(&self.model.vertices, first);
            let part = blend(&bones, &weights, vertex);
            let mut place = load::<L>(&self.skin.places, first);
            for i in 0..3 {
                place[i] += part[i];
            }
            store(place, &mut self.skin.places, first);
            for d in 0..JOINTS {
                let slope = turn.apply(blend(&slopes[d], &weights, vertex));
                store(slope, &mut self.skin.derivatives[column + d], first);
            }
        }
    }

    /// Turns and moves the whole skin.
    #[inline(always)]
    fn whole<L: Lane<f64>>(&mut self) {
        let global = lift::<L, GLOBAL>(self.global);
        for first in (0..self.model.len).step_by(L::N) {
            let posed = global.apply(constants(load(&self.skin.places, first)));
            let mut places = [L::zero(); 3];
            for i in 0..3 {
                places[i] = posed[i].value;
            }
            store(places, &mut self.skin.places, first);
            for d in 0..GLOBAL {
                store(along(&posed, d), &mut self.skin.derivatives[d], first);
            }
        }
    }
}

/// The residuals of all correspondences.
pub(super) struct Residuals<'a> {
    pub(super) targets: &'a [Target],
    pub(super) skin: &'a Skin,
    pub(super) residuals: &'a mut [f64],
}

impl Vectorized<f64> for Residuals<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<f64>>(self) {
        for first in (0..self.targets.len()).step_by(L::N) {
            let here = Here::new(self.targets, first);
            for i in 0..3 {
                let corners = here.corners::<L>(&self.skin.places[i]);
                let gap = residual(here.point(i), here.u(), corners);
                here.scatter(gap, &mut self.residuals[3 * first + i..], 3);
            }
        }
    }
}

/// The residuals of all correspondences, and their Jacobian by `u1 u2` and `theta`; in rows of
/// fewer columns by the last of these.
pub(super) struct ResidualDerivatives<'a> {
    pub(super) targets: &'a [Target],
    pub(super) skin: &'a Skin,
    pub(super) residuals: &'a mut [f64],
    pub(super) jacobian: &'a mut [f64],
}

impl Vectorized<f64> for ResidualDerivatives<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<f64>>(self) {
        let columns = self.jacobian.len() / self.residuals.len();
        let skipped = DIRECTIONS - columns;
        for first in (0..self.targets.len()).step_by(L::N) {
            let here = Here::new(self.targets, first);
            let u = here.u();
            let variables = [Dual::<L, 2>::variable(u[0], 0), Dual::variable(u[1], 1)];
            for i in 0..3 {
                let row = 3 * first + i;
                let point = Dual::constant(here.point(i));
                let corners = constants(here.corners(&self.skin.places[i]));
                let gap = residual(point, variables, corners);
                here.scatter(gap.value, &mut self.residuals[row..], 3);
                let mut scatter = |slope: L, direction: usize| {
                    let column = row * columns + direction - skipped;
                    here.scatter(slope, &mut self.jacobian[column..], 3 * columns);
                };
                for d in skipped..2 {
                    scatter(gap.tangent[d], d);
                }
                // The gap is linear in the skin: what makes it of places makes its derivatives of theirs.
                for d in 0..THETA {
                    let slopes = here.corners(&self.skin.derivatives[d][i]);
                    scatter(residual(L::zero(), u, slopes), 2 + d);
                }
            }
        }
    }
}

/// The correspondences from one on, as many as there are lanes; past the last, that one again.
struct Here<'a> {
    targets: &'a [Target],
    /// The corners, each in all lanes.
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

    /// Writes the lanes, repetitions left out, to every `stride`th place.
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

    #[inline(always)]
    fn point<L: Lane<f64>>(&self, coordinate: usize) -> L {
        self.gather(|target| target.point[coordinate])
    }

    #[inline(always)]
    fn u<L: Lane<f64>>(&self) -> [L; 2] {
        [
            self.gather(|target| target.u[0]),
            self.gather(|target| target.u[1]),
        ]
    }

    /// A number of the skin's at the corners of the triangles.
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

fn primal<const N: usize>(number: Dual<f64, N>) -> f64 {
    number.value
}

#[inline(always)]
fn load<L: Lane<f64>>(columns: &[Vec<f64>; 3], first: usize) -> [L; 3] {
    let mut point = [L::zero(); 3];
    for i in 0..3 {
        point[i] = L::load(&columns[i][first..]);
    }
    point
}

#[inline(always)]
fn store<L: Lane<f64>>(point: [L; 3], columns: &mut [Vec<f64>; 3], first: usize) {
    for i in 0..3 {
        point[i].store(&mut columns[i][first..]);
    }
}

/// The tangents of a point along a direction.
#[inline(always)]
fn along<L: Lane<f64>, const N: usize>(point: &[Dual<L, N>; 3], direction: usize) -> [L; 3] {
    let mut tangents = [L::zero(); 3];
    for i in 0..3 {
        tangents[i] = point[i].tangent[direction];
    }
    tangents
}

#[inline(always)]
fn constants<L: Lane<f64>, const N: usize>(point: [L; 3]) -> [Dual<L, N>; 3] {
    let mut constants = [Dual::zero(); 3];
    for i in 0..3 {
        constants[i] = Dual::constant(point[i]);
    }
    constants
}
