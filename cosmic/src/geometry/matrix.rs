//! Small symmetric matrices, such as the stiffness of a node in every direction.

use std::ops::{Add, AddAssign, Mul};

use nalgebra::Matrix3;

use super::dimension::Dimension;
use super::vector::Vector;

/// A symmetric matrix with `D` rows and `D` columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Matrix<const D: usize = 3> {
    rows: [Vector<f64, D>; D],
}

impl<const D: usize> Matrix<D> {
    /// The matrix of zeros.
    pub fn zero() -> Self {
        Self {
            rows: [Vector([0.0; D]); D],
        }
    }

    /// The symmetric part `(A + A^T) / 2` of a matrix `A`, which is given by its rows.
    pub fn symmetric(rows: [Vector<f64, D>; D]) -> Self {
        let part = |row: usize, k: usize| {
            if row == k {
                rows[row].0[k]
            } else {
                0.5 * (rows[row].0[k] + rows[k].0[row])
            }
        };
        Self {
            rows: std::array::from_fn(|row| Vector::from_fn(|k| part(row, k))),
        }
    }

    /// The matrix `v v^T`. If `v` is a unit vector, the matrix projects onto `v`.
    pub fn square(v: Vector<f64, D>) -> Self {
        Self {
            rows: v.0.map(|factor| v * factor),
        }
    }

    /// The sum of the diagonal.
    pub fn trace(&self) -> f64 {
        (0..D).map(|k| self.rows[k].0[k]).sum()
    }
}

impl Matrix {
    /// The matrix that projects onto the directions of a dimension: for space it is the identity.
    pub fn onto(dimension: Dimension) -> Self {
        Self {
            rows: Vector::axes().map(|axis| dimension.onto(axis)),
        }
    }

    /// The largest eigenvalue. If the matrix acts in the plane only, it is that of its part there.
    pub fn largest_eigenvalue(&self) -> f64 {
        let [[a, across, b], [_, rest, other], [_, _, d]] = self.rows.map(Vector::array);
        if [across, rest, other] == [0.0; 3] {
            return 0.5 * (a + d) + (0.5 * (a - d)).hypot(b);
        }
        let matrix = Matrix3::from_fn(|row, k| self.rows[row].0[k]);
        matrix.symmetric_eigenvalues().max()
    }
}

impl<const D: usize> AddAssign for Matrix<D> {
    fn add_assign(&mut self, other: Self) {
        for (row, added) in self.rows.iter_mut().zip(other.rows) {
            *row += added;
        }
    }
}

impl<const D: usize> Add for Matrix<D> {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl<const D: usize> Mul<f64> for Matrix<D> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            rows: self.rows.map(|row| row * factor),
        }
    }
}

impl<const D: usize> Mul<Vector<f64, D>> for Matrix<D> {
    type Output = Vector<f64, D>;
    fn mul(self, v: Vector<f64, D>) -> Vector<f64, D> {
        Vector(self.rows.map(|row| row.dot(v)))
    }
}
