//! Implements [`Parameters`](crate::Parameters) for matrices of elements.

use nalgebra::{DMatrix, DVector, Dim, Matrix, RawStorage, SMatrix};

use super::super::element::Element;
use crate::parameters::{Parameters, Walk};
use crate::real::Real;

impl<R: Real> Parameters<R> for Element<R> {
    type With<S: Real> = Element<S>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Element<S> {
        Element(self.0.map_numbers(walk))
    }
}

/// Returns a copy of the entries, row by row. This is the order of their names `matrix[i][j]`.
fn entries<R: Real, S: Real, M: Dim, N: Dim>(
    matrix: &Matrix<Element<R>, M, N, impl RawStorage<Element<R>, M, N>>,
    walk: &mut Walk<'_, R, S>,
) -> Vec<Element<S>> {
    let rows = matrix.row_iter().map(|row| row.iter().copied().collect());
    let rows: Vec<Vec<Element<R>>> = rows.collect();
    rows.map_numbers(walk).concat()
}

impl<R: Real> Parameters<R> for DMatrix<Element<R>> {
    type With<S: Real> = DMatrix<Element<S>>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        DMatrix::from_row_slice(self.nrows(), self.ncols(), &entries(self, walk))
    }
}

impl<R: Real> Parameters<R> for DVector<Element<R>> {
    type With<S: Real> = DVector<Element<S>>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        DVector::from_vec(self.as_slice().to_vec().map_numbers(walk))
    }
}

impl<R: Real, const M: usize, const N: usize> Parameters<R> for SMatrix<Element<R>, M, N> {
    type With<S: Real> = SMatrix<Element<S>, M, N>;
    fn map_numbers<S: Real>(&self, walk: &mut Walk<'_, R, S>) -> Self::With<S> {
        SMatrix::from_row_slice(&entries(self, walk))
    }
}
