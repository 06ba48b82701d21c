//! Computes eigenvalues and eigenvectors of symmetric matrices with all their derivatives, some of which nalgebra's own
//! iterations would lose.

use ::nalgebra::{DMatrix, DVector};

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
        let mut residual: Vec<R> = v.iter().map(|&v| -(value * v)).collect();
        let mut entries = lower.iter();
        for j in 0..n {
            for (i, &entry) in (j..n).zip(&mut entries) {
                residual[i] += entry * v[j];
                if i != j {
                    residual[j] += entry * v[i];
                }
            }
        }
        residual.push((R::dot(v, v) - R::one()) * R::lit(0.5));
        residual
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
/// use ::nalgebra::DMatrix;
/// use autodiff::nalgebra::symmetric_eigen;
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
/// If an eigenvalue is repeated, to within rounding, because then neither the eigenvalue nor its eigenvectors have
/// derivatives.
///
/// # Panics
/// If the matrix is not square, or if the SIMD lanes of an entry differ.
pub fn symmetric_eigen<R: Real>(matrix: &DMatrix<Element<R>>) -> Result<Vec<EigenPair<R>>, NoRoot> {
    let size = matrix.nrows();
    let lower: Vec<R> = (0..size)
        .flat_map(|j| (j..size).map(move |i| matrix[(i, j)].0))
        .collect();
    let primal = matrix.map(|entry| entry.0.primal()).symmetric_eigen();
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| primal.eigenvalues[a].total_cmp(&primal.eigenvalues[b]));
    let pair = |k: usize| {
        let vector = primal.eigenvectors.column(k);
        let numbers = vector.iter().chain([&primal.eigenvalues[k]]);
        let x: Vec<R> = numbers.map(|&number| R::lit(number)).collect();
        let x = root(Pair { size }, &x, &lower)?;
        let vector = DVector::from_iterator(size, x[..size].iter().copied().map(Element));
        let value = Element(x[size]);
        Ok(EigenPair { value, vector })
    };
    order.into_iter().map(pair).collect()
}
