//! Poses the skin of a hand, in lanes over vertices.

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Dual, Real};
use cosmic::kernel;

use super::affine::Affine;
use super::instance::{BONES, FINGERS, GLOBAL, Instance, JOINTS, THETA};
use crate::objectives::rotation;

/// The length below which a rotation vector is taken to be no rotation.
const NO_ROTATION: f64 = 1e-4;
/// The bones that no angle moves: the wrist, the forearm, and the first bone of each finger.
const STILL: [usize; 2 + FINGERS] = [0, BONES - 1, 1, 5, 9, 13, 17];

/// The vertices of the posed skin, and their derivatives with respect to `theta`. They are indexed by coordinate and
/// then by vertex.
pub(super) struct Skin {
    pub(super) places: [Vec<f64>; 3],
    pub(super) derivatives: Vec<[Vec<f64>; 3]>,
}

impl Skin {
    pub(super) fn new(instance: &Instance) -> Self {
        let room = || [(); 3].map(|()| vec![0.0; instance.vertices[0].len()]);
        Self {
            places: room(),
            derivatives: (0..THETA).map(|_| room()).collect(),
        }
    }

    /// Poses all vertices.
    pub(super) fn pose(&mut self, instance: &Instance) {
        let (global_theta, angles) = instance.theta.split_at(GLOBAL);
        f64::vectorize(Pose {
            instance,
            bones: &f64::vectorize(Bones { instance, angles }),
            global: &global(global_theta),
            skin: self,
        });
    }

    /// Poses all vertices, and computes their derivatives.
    pub(super) fn pose_with_derivatives(&mut self, instance: &Instance) {
        let (global_theta, angles) = instance.theta.split_at(GLOBAL);
        let angles: Vec<Dual<f64, JOINTS>> = angles.chunks(JOINTS).flat_map(seeded).collect();
        let angles = &angles[..];
        f64::vectorize(Pose {
            instance,
            bones: &f64::vectorize(Bones { instance, angles }),
            global: &global(&seeded::<GLOBAL>(global_theta)),
            skin: self,
        });
    }
}

/// Poses all vertices. The numbers are plain numbers or carry derivatives. The derivatives of a bone are along the
/// directions of its own finger; those of the whole hand are along other directions.
struct Pose<'a, B, G> {
    instance: &'a Instance,
    bones: &'a [Affine<B>],
    global: &'a Affine<G>,
    skin: &'a mut Skin,
}

#[kernel]
impl Vectorized<f64> for Pose<'_, f64, f64> {
    type Output = ();
    fn run<L: Lane<f64>>(self) {
        let all: [usize; BONES] = std::array::from_fn(|bone| bone);
        let moves = splat::<L, BONES>(all, |bone| self.bones[bone]);
        let global = self.global.map(L::splat);
        for first in (0..self.instance.len).step_by(L::N) {
            let weights = weights(self.instance, all, first);
            let place = blend(&moves, &weights, load(&self.instance.vertices, first));
            store(global.apply(place), &mut self.skin.places, first);
        }
    }
}

#[kernel]
impl Vectorized<f64> for Pose<'_, Dual<f64, JOINTS>, Dual<f64, GLOBAL>> {
    type Output = ();
    fn run<L: Lane<f64>>(mut self) {
        let moves = splat::<L, { 2 + FINGERS }>(STILL, |bone| self.bones[bone].map(primal));
        for first in (0..self.instance.len).step_by(L::N) {
            let weights = weights(self.instance, STILL, first);
            let part = blend(&moves, &weights, load(&self.instance.vertices, first));
            store(part, &mut self.skin.places, first);
        }
        for finger in 0..FINGERS {
            self.add_finger::<L>(finger);
        }
        self.turn::<L>();
    }
}

impl Pose<'_, Dual<f64, JOINTS>, Dual<f64, GLOBAL>> {
    /// Adds the part of the vertices that depends on the angles of a finger, which is the part from all bones of the
    /// finger but the first. Blending and turning are linear in the transformations of the bones. So the same code,
    /// applied to the derivatives of these transformations, computes the derivatives of the part.
    #[inline(always)]
    fn add_finger<L: Lane<f64>>(&mut self, finger: usize) {
        let Self {
            instance,
            bones,
            skin,
            ..
        } = self;
        let root = 1 + JOINTS * finger;
        let moving = [root + 1, root + 2, root + 3];
        let moves = splat::<L, 3>(moving, |bone| bones[bone].map(primal));
        let mut slopes = [moves; JOINTS];
        for d in 0..JOINTS {
            slopes[d] = splat(moving, |bone| bones[bone].map(|number| number.tangent[d]));
        }
        let turn = self.global.map(primal).linear().map(L::splat);
        let column = GLOBAL + JOINTS * finger;
        for first in (0..instance.len).step_by(L::N) {
            let weights = weights(instance, moving, first);
            let vertex = load(&instance.vertices, first);
            let part = blend(&moves, &weights, vertex);
            let mut place = load::<L>(&skin.places, first);
            for i in 0..3 {
                place[i] += part[i];
            }
            store(place, &mut skin.places, first);
            for d in 0..JOINTS {
                let slope = turn.apply(blend(&slopes[d], &weights, vertex));
                store(slope, &mut skin.derivatives[column + d], first);
            }
        }
    }

    /// Rotates and translates the whole skin.
    #[inline(always)]
    fn turn<L: Lane<f64>>(&mut self) {
        let Self { instance, skin, .. } = self;
        let global = self.global.map(lift::<L>);
        for first in (0..instance.len).step_by(L::N) {
            let place = load::<L>(&skin.places, first);
            let mut constants = [Dual::constant(place[0]); 3];
            for i in 1..3 {
                constants[i] = Dual::constant(place[i]);
            }
            let posed = global.apply(constants);
            for i in 0..3 {
                posed[i].value.store(&mut skin.places[i][first..]);
                for d in 0..GLOBAL {
                    posed[i].tangent[d].store(&mut skin.derivatives[d][i][first..]);
                }
            }
        }
    }
}

/// Computes the transformations of all bones from the angles of the fingers. The bones are computed one after the
/// other, because each needs its parent. So lanes are not used. The code runs through `vectorize` only to be compiled
/// with the instruction set of the lanes.
struct Bones<'a, R> {
    instance: &'a Instance,
    angles: &'a [R],
}

#[kernel]
impl<R: Real> Vectorized<f64> for Bones<'_, R> {
    type Output = Vec<Affine<R>>;
    fn run<L: Lane<f64>>(self) -> Vec<Affine<R>> {
        let mut absolute: Vec<Affine<R>> = Vec::with_capacity(BONES);
        let mut transforms = Vec::with_capacity(BONES);
        for (i, bone) in self.instance.bones.iter().enumerate() {
            let mut relative = bone.relative.map(R::lit);
            if !STILL.contains(&i) {
                relative = relative.after(&Affine::euler(euler(i, self.angles)));
            }
            let here = match bone.parent {
                Some(parent) => absolute[parent].after(&relative),
                None => relative,
            };
            let mut transform = here.after(&bone.inverse_rest.map(R::lit));
            if self.instance.mirrored {
                for entry in &mut transform.0[0] {
                    *entry = -*entry;
                }
            }
            transforms.push(transform);
            absolute.push(here);
        }
        transforms
    }
}

/// Returns the angles of a bone about x, y and z. The bone must be moved by some angle.
#[inline(always)]
fn euler<R: Real>(bone: usize, angles: &[R]) -> [R; 3] {
    let (finger, joint) = ((bone - 1) / JOINTS, (bone - 1) % JOINTS);
    let angles = &angles[JOINTS * finger..][..JOINTS];
    match joint {
        1 => [angles[0], R::zero(), angles[1]],
        _ => [angles[joint], R::zero(), R::zero()],
    }
}

/// Returns the rotation and translation of the whole hand.
fn global<R: Real>(theta: &[R]) -> Affine<R> {
    let r = [theta[0], theta[1], theta[2]];
    let small = R::dot(&r, &r).sqrt().less(R::lit(NO_ROTATION));
    let mut matrix = [[R::zero(); 4]; 3];
    for column in 0..3 {
        let mut unit = [R::zero(); 3];
        unit[column] = R::one();
        let turned = rotation::rotate(r, unit);
        for row in 0..3 {
            matrix[row][column] = R::select(small, unit[row], turned[row]);
        }
    }
    for row in 0..3 {
        matrix[row][3] = theta[3 + row];
    }
    Affine(matrix)
}

/// Returns numbers as variables: dual numbers in which each variable has its own direction.
fn seeded<const N: usize>(numbers: &[f64]) -> [Dual<f64, N>; N] {
    let mut variables = [Dual::constant(0.0); N];
    for i in 0..N {
        variables[i] = Dual::variable(numbers[i], i);
    }
    variables
}

#[inline(always)]
fn primal<const N: usize>(number: Dual<f64, N>) -> f64 {
    number.value
}

/// Copies a number to all lanes.
#[inline(always)]
fn lift<L: Lane<f64>>(number: Dual<f64, GLOBAL>) -> Dual<L, GLOBAL> {
    let mut lifted = Dual::constant(L::splat(number.value));
    for d in 0..GLOBAL {
        lifted.tangent[d] = L::splat(number.tangent[d]);
    }
    lifted
}

/// Copies the transformations of a few bones to all lanes.
#[inline(always)]
fn splat<L: Lane<f64>, const N: usize>(
    bones: [usize; N],
    transform: impl Fn(usize) -> Affine<f64>,
) -> [Affine<L>; N] {
    let mut moves = [Affine([[L::zero(); 4]; 3]); N];
    for i in 0..N {
        moves[i] = transform(bones[i]).map(L::splat);
    }
    moves
}

/// Loads the weights of a few bones for vertices that follow each other.
#[inline(always)]
fn weights<L: Lane<f64>, const N: usize>(
    instance: &Instance,
    bones: [usize; N],
    first: usize,
) -> [L; N] {
    let mut weights = [L::zero(); N];
    for i in 0..N {
        weights[i] = L::load(&instance.weights[bones[i]][first..]);
    }
    weights
}

/// Returns the positions of vertices: the weighted sum of what a few bones contribute.
#[inline(always)]
fn blend<L: Lane<f64>, const N: usize>(
    bones: &[Affine<L>; N],
    weights: &[L; N],
    vertex: [L; 3],
) -> [L; 3] {
    let mut sum = [L::zero(); 3];
    for bone in 0..N {
        let moved = bones[bone].apply(vertex);
        for i in 0..3 {
            sum[i] = weights[bone].fma(moved[i], sum[i]);
        }
    }
    sum
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
