//! A hand's skin: the sizes of its pose, its measured points, and how bones move it.

use autodiff::Real;

use super::transform::Affine;

/// Pose parameters: global rotation and translation, then four angles per finger.
pub const THETA: usize = 26;
/// The global ones.
pub(super) const GLOBAL: usize = 6;
pub(super) const FINGERS: usize = 5;
/// Angles of a finger, and bones of it.
pub(super) const JOINTS: usize = 4;

/// A measured point, and the point `u1 a + u2 b + (1 - u1 - u2) c` of the skin that is to meet it.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Where it was measured.
    pub point: [f64; 3],
    /// The vertices `a`, `b` and `c`.
    pub corners: [usize; 3],
    /// `u1` and `u2`.
    pub u: [f64; 2],
}

/// The place of a vertex, from the contributions of the bones.
#[inline(always)]
pub(super) fn blend<R: Real>(bones: &[Affine<R>], weights: &[R], vertex: [R; 3]) -> [R; 3] {
    let mut sum = [R::zero(); 3];
    for (bone, &weight) in bones.iter().zip(weights) {
        let moved = bone.apply(vertex);
        for i in 0..3 {
            sum[i] = weight.fma(moved[i], sum[i]);
        }
    }
    sum
}

/// How far a point of the skin is from where it was measured, by one coordinate.
#[inline(always)]
pub(super) fn residual<R: Real>(point: R, u: [R; 2], corners: [R; 3]) -> R {
    let last = R::one() - u[0] - u[1];
    point - (u[0] * corners[0] + u[1] * corners[1] + last * corners[2])
}
