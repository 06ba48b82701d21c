//! Arithmetic of vectors: sums, differences, and products with numbers.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use autodiff::Real;

use super::vector::Vector;

impl<R: Real, const D: usize> Add for Vector<R, D> {
    type Output = Self;
    #[inline(always)]
    fn add(mut self, other: Self) -> Self {
        for k in 0..D {
            self.0[k] += other.0[k];
        }
        self
    }
}

impl<R: Real, const D: usize> Sub for Vector<R, D> {
    type Output = Self;
    #[inline(always)]
    fn sub(mut self, other: Self) -> Self {
        for k in 0..D {
            self.0[k] -= other.0[k];
        }
        self
    }
}

impl<R: Real, const D: usize> Mul<R> for Vector<R, D> {
    type Output = Self;
    #[inline(always)]
    fn mul(mut self, factor: R) -> Self {
        for k in 0..D {
            self.0[k] = factor * self.0[k];
        }
        self
    }
}

impl<R: Real, const D: usize> Div<R> for Vector<R, D> {
    type Output = Self;
    #[inline(always)]
    fn div(mut self, divisor: R) -> Self {
        for k in 0..D {
            self.0[k] /= divisor;
        }
        self
    }
}

impl<R: Real, const D: usize> Neg for Vector<R, D> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for k in 0..D {
            self.0[k] = -self.0[k];
        }
        self
    }
}

impl<R: Real, const D: usize> AddAssign for Vector<R, D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real, const D: usize> SubAssign for Vector<R, D> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<R: Real, const D: usize> Sum for Vector<R, D> {
    fn sum<I: Iterator<Item = Self>>(vectors: I) -> Self {
        vectors.fold(Self::zero(), Add::add)
    }
}
