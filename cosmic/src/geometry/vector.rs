//! Vectors of `D` components.

use crate::Fields;
use std::cmp::Ordering;
use std::fmt;

use autodiff::{Parameters, Real};

/// A vector or a point with `D` components. By default it is one of space: along the ground, across, and above. The points
/// of a planar robot are 0 across. Kernels, which compute with as few numbers as possible, take vectors of two components
/// for it: along and above.
///
/// Kernels can call all methods for components of the type [`Real`]: the methods are loops and marked
/// `#[inline(always)]`; see [`kernel`](macro@crate::kernel).
#[derive(Clone, Copy, PartialEq, Eq, Parameters, Fields)]
pub struct Vector<T, const D: usize = 3>(pub(super) [T; D]);

impl<T, const D: usize> Vector<T, D> {
    /// The vector with the given components.
    #[inline(always)]
    pub const fn new(components: [T; D]) -> Self {
        Self(components)
    }

    /// The vector whose component `k` is `of(k)`.
    pub fn from_fn(of: impl FnMut(usize) -> T) -> Self {
        Self(std::array::from_fn(of))
    }

    /// The components as an array.
    #[inline(always)]
    pub fn array(self) -> [T; D] {
        self.0
    }

    /// Applies a function to every component. Kernels use loops or operators instead.
    pub fn map<S>(self, of: impl FnMut(T) -> S) -> Vector<S, D> {
        Vector(self.0.map(of))
    }
}

impl<T: Copy, const D: usize> Vector<T, D> {
    /// The first component, which is along the ground.
    #[inline(always)]
    pub fn forward(self) -> T {
        self.0[0]
    }

    /// The last component, which points up or out of the ground.
    #[inline(always)]
    pub fn up(self) -> T {
        self.0[D - 1]
    }

    /// This vector with its first component replaced by `forward`.
    #[must_use]
    pub fn with_forward(mut self, forward: T) -> Self {
        self.0[0] = forward;
        self
    }

    /// This vector with its last component replaced by `up`.
    #[inline(always)]
    #[must_use]
    pub fn with_up(mut self, up: T) -> Self {
        self.0[D - 1] = up;
        self
    }

    /// Applies a function to the components of two vectors in pairs.
    pub fn zip_with<S: Copy, U>(
        self,
        other: Vector<S, D>,
        mut of: impl FnMut(T, S) -> U,
    ) -> Vector<U, D> {
        Vector::from_fn(|k| of(self.0[k], other.0[k]))
    }
}

impl<R: Real, const D: usize> Vector<R, D> {
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([R::zero(); D])
    }

    /// Converts the components of a vector to constants of the type `R`.
    #[inline(always)]
    pub fn lit(constant: Vector<f64, D>) -> Self {
        let mut vector = Self::zero();
        for k in 0..D {
            vector.0[k] = R::lit(constant.0[k]);
        }
        vector
    }

    /// The component across; 0 for a vector of the plane.
    #[inline(always)]
    pub fn sideways(self) -> R {
        if D == 3 { self.0[1] } else { R::zero() }
    }

    /// This vector with its component across replaced by `sideways`. A vector of the plane does not change.
    #[inline(always)]
    #[must_use]
    pub fn with_sideways(mut self, sideways: R) -> Self {
        if D == 3 {
            self.0[1] = sideways;
        }
        self
    }

    /// The vector with the first component `forward` and the last component `up`. Other components are zero.
    #[inline(always)]
    pub fn upright(forward: R, up: R) -> Self {
        let mut vector = Self::zero();
        vector.0[0] = forward;
        vector.0[D - 1] = up;
        vector
    }

    /// The part of this vector along the ground: the same vector with the last component set to zero.
    #[inline(always)]
    #[must_use]
    pub fn along(self) -> Self {
        self.with_up(R::zero())
    }

    /// The scalar product.
    #[inline(always)]
    pub fn dot(self, other: Self) -> R {
        let mut sum = self.0[D - 1] * other.0[D - 1];
        for k in (0..D - 1).rev() {
            sum = self.0[k].fma(other.0[k], sum);
        }
        sum
    }

    /// The length. At the zero vector its derivative is 0.
    #[inline(always)]
    pub fn norm(self) -> R {
        let mut norm = self.0[0].abs();
        for k in 1..D {
            norm = norm.hypot(self.0[k]);
        }
        norm
    }

    /// The length of the part along the ground. Where that part is zero, the derivative is 0.
    #[inline(always)]
    pub fn norm_along(self) -> R {
        let mut norm = self.0[0].abs();
        for k in 1..D - 1 {
            norm = norm.hypot(self.0[k]);
        }
        norm
    }

    /// The sum of the absolute values of the components.
    #[inline(always)]
    pub fn sum_of_sizes(self) -> R {
        let mut sum = self.0[0].abs();
        for k in 1..D {
            sum += self.0[k].abs();
        }
        sum
    }

    /// `sqrt(|self|^2 + softening)`: a length that is smooth at the zero vector.
    #[inline(always)]
    pub fn softened_norm(self, softening: f64) -> R {
        let mut square = R::lit(softening);
        for k in (0..D).rev() {
            square = self.0[k].fma(self.0[k], square);
        }
        square.sqrt()
    }

    /// Shortens a vector along the ground, whose last component is zero, by the length `by` (at least 0). A vector
    /// shorter than `by` becomes the zero vector.
    #[inline(always)]
    #[must_use]
    pub fn shortened(self, by: R) -> Self {
        // In the plane, a vector along the ground has only its first component.
        if D == 2 {
            let left = self.0[0].abs() - by;
            return Self::upright(self.0[0].signum() * left.max(R::zero()), R::zero());
        }
        let square = self.dot(self);
        let rests = square.less_equal(R::zero());
        let safe = R::select(rests, R::one(), square);
        let factor = (R::one() - by * safe.rsqrt()).max(R::zero());
        self * R::select(rests, R::zero(), factor)
    }

    /// The part of the vector `other` that is perpendicular to this vector, which must be a unit vector.
    #[inline(always)]
    #[must_use]
    pub fn across(self, other: Self) -> Self {
        // In the plane, this formula is used: it gives exactly zero for parallel vectors.
        if D == 2 {
            let sin = self.0[0] * other.0[1] - self.0[1] * other.0[0];
            return Self::upright(-(sin * self.0[1]), sin * self.0[0]);
        }
        other - self * self.dot(other)
    }

    /// `self * factor + term`.
    #[inline(always)]
    #[must_use]
    pub fn fma(self, factor: R, term: Self) -> Self {
        let mut sum = term;
        for k in 0..D {
            sum.0[k] = factor.fma(self.0[k], term.0[k]);
        }
        sum
    }

    /// `if_true` where the mask is true, otherwise `if_false`. Derivatives flow only through the chosen vector.
    #[inline(always)]
    pub fn select(mask: R::Mask, if_true: Self, if_false: Self) -> Self {
        let mut chosen = if_false;
        for k in 0..D {
            chosen.0[k] = R::select(mask, if_true.0[k], if_false.0[k]);
        }
        chosen
    }

    /// Moves this point along the ground by the vector `by`. The last component of the point does not change.
    #[inline(always)]
    #[must_use]
    pub fn moved_along(mut self, by: Self) -> Self {
        for k in 0..D - 1 {
            self.0[k] += by.0[k];
        }
        self
    }
}

/// A vector along the ground, of which kernels do not read or return the last component: it is 0.
#[derive(Clone, Copy, Debug)]
pub struct Along<T, const D: usize>([T; D]);

impl<R: Real, const D: usize> Along<R, D> {
    /// The components along the ground of a vector.
    #[inline(always)]
    pub fn of(vector: Vector<R, D>) -> Self {
        Self(vector.0)
    }

    /// The vector, with the last component 0.
    #[inline(always)]
    pub fn vector(self) -> Vector<R, D> {
        Vector(self.0).along()
    }
}

#[expect(
    clippy::manual_memcpy,
    reason = "kernels need loops, which are inlined"
)]
impl<T: Copy, const D: usize> Fields<T> for Along<T, D> {
    const COUNT: usize = D - 1;

    #[inline(always)]
    fn first_of(numbers: &[T]) -> Self {
        let mut components = [numbers[0]; D];
        for k in 1..D - 1 {
            components[k] = numbers[k];
        }
        Self(components)
    }

    #[inline(always)]
    fn write(self, numbers: &mut [T]) {
        for k in 0..D - 1 {
            numbers[k] = self.0[k];
        }
    }

    #[inline(always)]
    fn any(&self) -> T {
        self.0[0]
    }
}

impl<const D: usize> Vector<f64, D> {
    /// The vector whose components are all NaN.
    pub const NAN: Self = Self([f64::NAN; D]);

    /// The distance between two points.
    pub fn distance(self, other: Self) -> f64 {
        let apart = self - other;
        let rest = apart.0[1..].iter();
        rest.fold(apart.0[0].abs(), |sum: f64, &component| {
            sum.hypot(component)
        })
    }

    /// The unit vectors along the axes.
    pub fn axes() -> [Self; D] {
        std::array::from_fn(|axis| Self::from_fn(|k| f64::from(u8::from(k == axis))))
    }

    /// The unit vector in the direction of this vector; NaN for the zero vector.
    #[must_use]
    pub fn unit(self) -> Self {
        self / self.distance(Self::zero())
    }

    /// The point at a `share` of the way from this point to `other`: 0 is this point, 1 the other.
    #[must_use]
    pub fn towards(self, other: Self, share: f64) -> Self {
        self + (other - self) * share
    }

    /// Compares two points by their coordinates along one axis, the axis on which `size` is largest. Points with equal
    /// coordinates are compared along the axis with the next largest component of `size`, and so on.
    pub fn total_cmp_along(self, other: Self, size: Self) -> Ordering {
        let mut axes: [usize; D] = std::array::from_fn(|k| k);
        axes.sort_by(|&a, &b| size.0[b].total_cmp(&size.0[a]));
        let orders = axes.into_iter().map(|k| self.0[k].total_cmp(&other.0[k]));
        orders.fold(Ordering::Equal, Ordering::then)
    }

    /// The largest component.
    pub fn largest(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// True if no component is infinite or NaN.
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|component| component.is_finite())
    }
}

impl<T: Copy> Vector<T> {
    /// The two components of a vector of the plane: forward and up.
    pub fn in_plane(self) -> [T; 2] {
        [self.0[0], self.0[2]]
    }
}

impl Vector<f64> {
    /// A vector of the plane turned to the left by a right angle.
    #[must_use]
    pub fn turned_left(self) -> Self {
        let [x, y] = self.in_plane();
        [-y, x].into()
    }

    /// The signed area of the parallelogram that this vector and `other`, two vectors of the plane, span. It is positive if
    /// `other` is to the left of this vector.
    pub fn cross(self, other: Self) -> f64 {
        let ([x, y], [other_x, other_y]) = (self.in_plane(), other.in_plane());
        x * other_y - y * other_x
    }
}

/// A vector of the plane, from its components forward and up.
impl<R: Real> From<[R; 2]> for Vector<R> {
    fn from([forward, up]: [R; 2]) -> Self {
        Self::upright(forward, up)
    }
}

/// True for a vector of the plane with the components `[forward, up]`.
impl PartialEq<[f64; 2]> for Vector<f64> {
    fn eq(&self, other: &[f64; 2]) -> bool {
        *self == Self::from(*other)
    }
}

/// Formats the vector like an array.
impl<T: fmt::Debug, const D: usize> fmt::Debug for Vector<T, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl<T: Default, const D: usize> Default for Vector<T, D> {
    fn default() -> Self {
        Self::from_fn(|_| T::default())
    }
}

impl<T, const D: usize> From<[T; D]> for Vector<T, D> {
    fn from(components: [T; D]) -> Self {
        Self(components)
    }
}

impl<T, const D: usize> From<Vector<T, D>> for [T; D] {
    fn from(vector: Vector<T, D>) -> Self {
        vector.0
    }
}

impl<T: PartialEq, const D: usize> PartialEq<[T; D]> for Vector<T, D> {
    fn eq(&self, other: &[T; D]) -> bool {
        self.0 == *other
    }
}
