//! Computes eigenvalues and eigenvectors of symmetric matrices, and singular values, with all their derivatives, some of
//! which nalgebra's own iterations would lose.

use std::fmt;

use nalgebra::{DMatrix, DVector};

use super::super::element::Element;
use crate::drivers::implicit::{NoRoot, Residual, root};
use crate::real::Real;

/// The equations of an eigenpair: `A v = lambda v` and `v . v = 1`. The unknowns are `v` and `lambda`. The parameters
/// are the lower triangle of `A`, column by column.
#[derive(Clone)]
struct Pair {
    size: usize,
}

impl Residual for Pair {
    fn eval<R: Real>(&self, x: &[R], lower: &[R]) -> Vec<R> {
        let n = self.size;
        let (v, value) = (&x[..n], x[n]);
        let equations = product(v, lower).into_iter().zip(v);
        let mut residual: Vec<R> = equations.map(|(av, &v)| av - value * v).collect();
        residual.push((R::dot(v, v) - R::one()) * R::lit(0.5));
        residual
    }
}

/// Returns the product of a symmetric matrix, given by its lower triangle column by column, with a vector.
fn product<R: Real>(v: &[R], lower: &[R]) -> Vec<R> {
    let n = v.len();
    let mut product = vec![R::zero(); n];
    let mut entries = lower.iter();
    for j in 0..n {
        for (i, &entry) in (j..n).zip(&mut entries) {
            product[i] += entry * v[j];
            if i != j {
                product[j] += entry * v[i];
            }
        }
    }
    product
}

/// Returns the lower triangle of a symmetric matrix column by column, and the primals of its eigenvalues, ascending, each
/// with its eigenvector.
fn decomposed<R: Real>(matrix: &DMatrix<Element<R>>) -> (Vec<R>, Vec<(f64, DVector<f64>)>) {
    let size = matrix.nrows();
    let column = |j: usize| (j..size).map(move |i| matrix[(i, j)].0);
    let lower = (0..size).flat_map(column).collect();
    let primal = matrix.map(|entry| entry.0.primal()).symmetric_eigen();
    let values = primal.eigenvalues.iter().copied();
    let vectors = primal.eigenvectors.column_iter().map(|v| v.into_owned());
    let mut sorted: Vec<(f64, DVector<f64>)> = values.zip(vectors).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    (lower, sorted)
}

/// Why eigenvalues or singular values have no derivatives.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoDerivative {
    /// This eigenvalue is repeated, to within rounding.
    RepeatedEigenvalue(f64),
    /// This singular value is zero or repeated, to within rounding.
    RepeatedSingularValue(f64),
    /// The values that nalgebra found do not fulfil their equations: they are NaN, or too inexact.
    NoRoot(NoRoot),
}

impl fmt::Display for NoDerivative {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RepeatedEigenvalue(value) => write!(
                formatter,
                "the eigenvalue {value} is repeated, to within rounding, so it has no derivatives; \
                 call `symmetric_eigen_groups` with a `distance` that puts equal eigenvalues into one group"
            ),
            Self::RepeatedSingularValue(value) => write!(
                formatter,
                "the singular value {value} is zero or repeated, to within rounding, so it has no derivatives"
            ),
            Self::NoRoot(why) => why.fmt(formatter),
        }
    }
}

impl std::error::Error for NoDerivative {}

impl NoDerivative {
    /// Why eigenvalues that are more than `distance` apart are not a root of their equations. If these are singular, two of
    /// the eigenvalues are equal: the two that are closest to each other.
    fn of_eigenvalues(why: NoRoot, sorted: &[(f64, DVector<f64>)], distance: f64) -> Self {
        let gaps = sorted
            .windows(2)
            .map(|pair| (pair[1].0 - pair[0].0, pair[0].0));
        let apart = gaps.filter(|(gap, _)| *gap > distance);
        let closest = apart.min_by(|a, b| a.0.total_cmp(&b.0));
        match (&why, closest) {
            (NoRoot::Singular { .. }, Some((_, value))) => Self::RepeatedEigenvalue(value),
            _ => Self::NoRoot(why),
        }
    }
}

/// An eigenvalue and its eigenvector.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EigenPair<R> {
    /// The eigenvalue.
    pub value: Element<R>,
    /// The eigenvector, of length 1.
    pub vector: DVector<Element<R>>,
}

/// Returns the eigenvalues of a symmetric matrix, ascending, each with its eigenvector of length 1. Only the lower
/// triangle is read. Derivatives of every order are right, even where entries of the matrix are zero, because they
/// follow from the equations of each pair. They take one factorisation for each pair.
///
/// ```
/// use nalgebra::DMatrix;
/// use autodiff::matrices::symmetric_eigen;
/// use autodiff::{Element, hessian};
///
/// // The larger eigenvalue of [[1, x], [x, 3]] is 3 + x^2 / 2 + ….
/// let second = hessian(
///     |x| {
///         let [one, three] = [1.0, 3.0].map(Element::lit);
///         let matrix = DMatrix::from_row_slice(2, 2, &[one, Element(x[0]), Element(x[0]), three]);
///         symmetric_eigen(&matrix).expect("two values")[1].value.0
///     },
///     &[0.0f64],
/// );
/// assert!((second[0][0] - 1.0).abs() < 1e-15);
/// ```
///
/// # Errors
/// [`NoDerivative::RepeatedEigenvalue`] if an eigenvalue is repeated, to within rounding, because then neither the eigenvalue
/// nor its eigenvectors have derivatives. Its symmetric functions have: use [`symmetric_eigen_groups`].
///
/// # Panics
/// If the matrix is not square, or if the SIMD lanes of an entry differ.
#[track_caller]
pub fn symmetric_eigen<R: Real>(
    matrix: &DMatrix<Element<R>>,
) -> Result<Vec<EigenPair<R>>, NoDerivative> {
    let (lower, sorted) = decomposed(matrix);
    let pairs = sorted.iter().map(|found| pair(&lower, found));
    let pairs = pairs.collect::<Result<_, _>>();
    pairs.map_err(|why| NoDerivative::of_eigenvalues(why, &sorted, f64::NEG_INFINITY))
}

/// Returns an eigenpair with its derivatives by the lower triangle, given its primal.
#[track_caller]
fn pair<R: Real>(
    lower: &[R],
    (value, vector): &(f64, DVector<f64>),
) -> Result<EigenPair<R>, NoRoot> {
    let size = vector.len();
    let numbers = vector.iter().chain([value]);
    let x: Vec<R> = numbers.map(|&number| R::lit(number)).collect();
    let x = root(Pair { size }, &x, lower)?;
    let vector = DVector::from_iterator(size, x[..size].iter().copied().map(Element));
    let value = Element(x[size]);
    Ok(EigenPair { value, vector })
}

/// Returns the singular values of a matrix, descending. Derivatives of every order are right, even where entries of the
/// matrix are zero: the values are eigenvalues of the symmetric matrix `[[0, A], [A^T, 0]]`, by the equations of
/// [`symmetric_eigen`].
///
/// ```
/// use nalgebra::DMatrix;
/// use autodiff::matrices::singular_values;
/// use autodiff::{Element, Real, hessian};
///
/// /// The larger singular value of [[2, x], [0, 1]].
/// fn largest<R: Real>(x: &[R]) -> R {
///     let [two, zero, one] = [2.0, 0.0, 1.0].map(Element::lit);
///     let matrix = DMatrix::from_row_slice(2, 2, &[two, Element(x[0]), zero, one]);
///     singular_values(&matrix).expect("two values")[0].0
/// }
/// // It is 2 + x^2 / 3 + ….
/// assert!((hessian(largest, &[0.0f64])[0][0] - 2.0 / 3.0).abs() < 1e-14);
/// ```
///
/// # Errors
/// [`NoDerivative::RepeatedSingularValue`] if a singular value is zero or repeated, to within rounding, because then it has
/// no derivative.
///
/// # Panics
/// If the SIMD lanes of an entry differ.
#[track_caller]
pub fn singular_values<R: Real>(
    matrix: &DMatrix<Element<R>>,
) -> Result<DVector<Element<R>>, NoDerivative> {
    let (m, n) = matrix.shape();
    let mut both = DMatrix::from_element(m + n, m + n, Element(R::zero()));
    both.view_mut((m, 0), (n, m)).tr_copy_from(matrix);
    let (lower, sorted) = decomposed(&both);
    let largest: Vec<_> = sorted.iter().rev().take(m.min(n)).collect();
    // The next value is 0, from which the last one must be distinct too.
    let next = largest.iter().skip(1).map(|found| found.0).chain([0.0]);
    let rounding = f64::EPSILON * (m + n) as f64 * largest.first().map_or(0.0, |found| found.0);
    let mut gaps = largest.iter().zip(next);
    if let Some((found, _)) = gaps.find(|(found, next)| found.0 - next <= rounding) {
        return Err(NoDerivative::RepeatedSingularValue(found.0));
    }
    let value = |found: &(f64, DVector<f64>)| match pair(&lower, found) {
        Ok(pair) => Ok(pair.value),
        Err(NoRoot::Singular { .. }) if found.0.is_finite() => {
            Err(NoDerivative::RepeatedSingularValue(found.0))
        }
        Err(why) => Err(NoDerivative::NoRoot(why)),
    };
    let values = largest.into_iter().map(value);
    Ok(DVector::from_vec(values.collect::<Result<_, _>>()?))
}

/// The equations of an invariant subspace: `A X = X B` and `basis^T X = 1`. The unknowns are the columns of `X` and then
/// of `B`. The parameters are those of [`Pair`].
#[derive(Clone)]
struct Subspace {
    basis: DMatrix<f64>,
}

impl Residual for Subspace {
    fn eval<R: Real>(&self, x: &[R], lower: &[R]) -> Vec<R> {
        let (n, count) = self.basis.shape();
        let (columns, block) = x.split_at(n * count);
        let mut residual: Vec<R> = Vec::with_capacity(x.len());
        for (column, mix) in columns.chunks_exact(n).zip(block.chunks_exact(count)) {
            let mut equations = product(column, lower);
            for (&factor, column) in mix.iter().zip(columns.chunks_exact(n)) {
                for (equation, &x) in equations.iter_mut().zip(column) {
                    *equation -= factor * x;
                }
            }
            residual.extend(equations);
        }
        for (j, column) in columns.chunks_exact(n).enumerate() {
            for (i, of_basis) in self.basis.column_iter().enumerate() {
                let one = if i == j { 1.0 } else { 0.0 };
                residual.push(R::dot(column, of_basis.as_slice()) - R::lit(one));
            }
        }
        residual
    }
}

/// Eigenvalues of a symmetric matrix that are equal or close to one another.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct EigenGroup<R> {
    /// A square matrix with these eigenvalues, and with one row for each of them. A symmetric function of the eigenvalues is
    /// a function of this matrix: their sum is its trace, their product its [`determinant`](super::determinant), and the sum
    /// of their squares the trace of its square.
    pub block: DMatrix<Element<R>>,
}

impl<R: Real> EigenGroup<R> {
    /// Returns the mean of the eigenvalues.
    #[track_caller]
    pub fn mean(&self) -> Element<R> {
        self.block.trace() / Element::lit(self.block.nrows() as f64)
    }
}

/// Returns the eigenvalues of a symmetric matrix in groups, ascending. Eigenvalues that follow each other at a distance
/// of at most `distance` are in one group. Only the lower triangle is read. A repeated eigenvalue has no derivative by
/// itself, but the symmetric functions of its group have derivatives of every order, and these are right.
///
/// ```
/// use nalgebra::DMatrix;
/// use autodiff::matrices::{determinant, symmetric_eigen_groups};
/// use autodiff::{Element, Real, gradient};
///
/// /// The product of the two eigenvalues of [[2 + x, y], [y, 2 - x]] is 4 - x^2 - y^2.
/// fn product<R: Real>(x: &[R]) -> R {
///     let (two, [x, y]) = (Element::lit(2.0), [0, 1].map(|k| Element(x[k])));
///     let matrix = DMatrix::from_row_slice(2, 2, &[two + x, y, y, two - x]);
///     let groups = symmetric_eigen_groups(&matrix, 1e-6).expect("one group");
///     determinant(&groups[0].block).0
/// }
/// assert_eq!((product(&[0.0, 0.0]), gradient(product, &[0.0, 0.0])), (4.0, vec![0.0, 0.0]));
/// ```
///
/// # Errors
/// [`NoDerivative::RepeatedEigenvalue`] if eigenvalues of different groups are equal to within rounding, which a larger
/// `distance` avoids.
///
/// # Panics
/// If the matrix is not square, or if the SIMD lanes of an entry differ.
#[track_caller]
pub fn symmetric_eigen_groups<R: Real>(
    matrix: &DMatrix<Element<R>>,
    distance: f64,
) -> Result<Vec<EigenGroup<R>>, NoDerivative> {
    let (lower, sorted) = decomposed(matrix);
    let groups = sorted.chunk_by(|a, b| b.0 - a.0 <= distance);
    let group = |group: &[(f64, DVector<f64>)]| {
        let count = group.len();
        let vectors: Vec<_> = group.iter().map(|(_, vector)| vector.clone()).collect();
        let basis = DMatrix::from_columns(&vectors);
        let values = DVector::from_iterator(count, group.iter().map(|(value, _)| *value));
        let start = [basis.as_slice(), DMatrix::from_diagonal(&values).as_slice()].concat();
        let first = basis.len();
        let x = root(Subspace { basis }, &R::lits(&start), &lower)?;
        let block = x[first..].iter().copied().map(Element);
        let block = DMatrix::from_iterator(count, count, block);
        Ok(EigenGroup { block })
    };
    let groups = groups.map(group).collect::<Result<_, _>>();
    groups.map_err(|why| NoDerivative::of_eigenvalues(why, &sorted, distance))
}
