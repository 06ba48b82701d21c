//! Rotates by a vector whose direction is the axis and whose length is the angle (Rodrigues' formula).

use autodiff::Real;

/// Rotates `v` by the rotation vector `r`. If `r` is exactly zero, the result is `v + r x v`, which has the right
/// derivative at zero.
#[inline(always)]
pub(super) fn rotate<R: Real>(r: [R; 3], v: [R; 3]) -> [R; 3] {
    let squared = dot(r, r);
    let at_zero = squared.less_equal(R::zero());
    // If the angle is zero, it is replaced by 1. Any number but zero would do, because the terms below are not selected
    // then.
    let angle = R::select(at_zero, R::one(), squared).sqrt();
    let inverse = angle.recip();
    let axis = [r[0] * inverse, r[1] * inverse, r[2] * inverse];
    let (sin, cos) = (angle.sin(), angle.cos());
    let across = cross(axis, v);
    let along = dot(axis, v) * (R::one() - cos);
    let near_zero = cross(r, v);
    let mut turned = v;
    for i in 0..3 {
        let exact = v[i] * cos + across[i] * sin + axis[i] * along;
        turned[i] = R::select(at_zero, v[i] + near_zero[i], exact);
    }
    turned
}

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}
