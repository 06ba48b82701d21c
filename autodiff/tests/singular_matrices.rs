//! Determinants and factorisations at matrices that are singular, defective, or have repeated eigenvalues, compared with
//! differences.

use crate::common::{assert_close, differences, forward_gradient, hessian_rows};
use autodiff::matrices::{
    Element, determinant, exp, inverse, log_determinant, singular_values, solve,
    symmetric_eigen_groups,
};
use autodiff::{DoubleDouble, Dual, Function, Real, Tape, gradient, jacobian, jacobian_reverse};
use nalgebra::{DMatrix, DVector};

fn square<R: Real>(x: &[R]) -> DMatrix<Element<R>> {
    let size = x.len().isqrt();
    DMatrix::from_row_iterator(size, size, x.iter().copied().map(Element))
}

/// The sum over all permutations, row by row. It has no division and no branch.
fn by_minors(x: &DMatrix<f64>) -> f64 {
    if x.is_empty() {
        return 1.0;
    }
    let term = |j: usize| {
        let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * x[(0, j)] * by_minors(&x.clone().remove_row(0).remove_column(j))
    };
    (0..x.ncols()).map(term).sum()
}

/// Returns the product of two matrices of small integers with `rank` columns and rows, whose rank is `rank`.
fn of_rank(size: usize, rank: usize) -> Vec<f64> {
    let entry = |i: usize, j: usize| ((i * i + 3 * j + i * j * j) % 7) as f64 - 3.0;
    let [left, right] = [
        DMatrix::from_fn(size, rank, entry),
        DMatrix::from_fn(rank, size, entry),
    ];
    (left * right).transpose().as_slice().to_vec()
}

/// Returns a matrix with `value` on the diagonal and ones above it, which has a single eigenvector.
fn jordan(size: usize, value: f64) -> Vec<f64> {
    let entry = |i, j| match (j as i32) - (i as i32) {
        0 => value,
        1 => 1.0,
        _ => 0.0,
    };
    DMatrix::from_fn(size, size, entry)
        .transpose()
        .as_slice()
        .to_vec()
}

/// Matrices of small integers, row by row.
fn matrices() -> Vec<Vec<f64>> {
    let mut matrices = vec![
        vec![0.0, 1.0, 0.0, 2.0],
        vec![1.0, 2.0, 2.0, 4.0],
        // Two rows are equal.
        vec![
            1.0, 2.0, 3.0, 4.0, 1.0, 2.0, 3.0, 4.0, 2.0, 0.0, 5.0, 1.0, 0.0, 3.0, 1.0, 7.0,
        ],
        // A column is zero.
        vec![
            0.0, 2.0, 3.0, 4.0, 0.0, 2.0, 1.0, 4.0, 0.0, 0.0, 5.0, 1.0, 0.0, 3.0, 1.0, 7.0,
        ],
        // Regular, with zeros on the diagonal.
        vec![
            0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 4.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.0,
        ],
        // A repeated eigenvalue.
        vec![
            2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 5.0,
        ],
    ];
    for size in 1..=5 {
        matrices.extend((0..=size).map(|rank| of_rank(size, rank)));
        matrices.extend([0.0, 2.0].map(|value| jordan(size, value)));
    }
    matrices
}

struct Determinant;

impl Function for Determinant {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        determinant(&square(x)).0
    }
}

/// The determinant is linear in each entry, so differences with steps of 1 are exact.
#[test]
fn determinants_have_their_cofactors_whatever_the_rank() {
    let plain = |x: &[f64]| vec![by_minors(&square(x).map(|x| x.0))];
    for x in matrices() {
        let n = x.len();
        let slopes = |x: &[f64]| {
            (0..n)
                .flat_map(|k| differences(plain, x, k, 1.0))
                .collect::<Vec<_>>()
        };
        // The entries are below 100, so products of five are below 1e10; most are much smaller.
        let tolerance =
            1e-13 * (1.0 + x.iter().fold(0.0, |a: f64, b| a.max(b.abs()))).powi(n.isqrt() as i32);
        assert_close(&[Determinant.eval(&x)], &plain(&x), tolerance);
        assert_close(
            &gradient(|x| Determinant.eval(x), &x),
            &slopes(&x),
            tolerance,
        );
        assert_close(&forward_gradient(&Determinant, &x), &slopes(&x), tolerance);
        let second: Vec<f64> = (0..n)
            .flat_map(|k| differences(slopes, &x, k, 1.0))
            .collect();
        assert_close(&hessian_rows(&Determinant, &x).concat(), &second, tolerance);
        let by_tapes =
            (0..n).flat_map(|i| gradient(|x| gradient(|x| Determinant.eval(x), x)[i], &x));
        assert_close(&by_tapes.collect::<Vec<_>>(), &second, tolerance);
    }
}

/// The determinant is a polynomial of the entries, so no derivative may have a pole next to a singular matrix.
#[test]
fn a_nearly_singular_matrix_keeps_the_digits_of_its_derivatives() {
    for (size, rank, distance) in [
        (4, 2, 1e-9),
        (5, 3, 1e-12),
        (6, 4, 1e-15),
        (6, 2, 1e-17),
        (6, 0, 1e-160),
    ] {
        let noise = |k: usize| distance * ((k * 37 % 11) as f64 - 5.0);
        let x: Vec<f64> = of_rank(size, rank)
            .iter()
            .enumerate()
            .map(|(k, x)| x + noise(k))
            .collect();
        let wide: Vec<DoubleDouble> = x.iter().map(|&x| x.into()).collect();
        let exact = |row: Vec<DoubleDouble>| {
            row.into_iter()
                .map(DoubleDouble::to_f64)
                .collect::<Vec<_>>()
        };
        // The rounding error is relative to products of as many entries as a cofactor has rows.
        let largest = x.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
        let tolerance = 1e-14 * largest.powi(size as i32 - 1);
        let slopes = exact(gradient(|x| Determinant.eval(x), &wide));
        assert_close(&gradient(|x| Determinant.eval(x), &x), &slopes, tolerance);
        let second = exact(hessian_rows(&Determinant, &wide).concat());
        let found = hessian_rows(&Determinant, &x).concat();
        assert_close(&found, &second, tolerance);
    }
}

#[test]
fn a_logarithm_of_a_determinant_has_the_slopes_of_its_matrix() {
    struct Logarithm;
    impl Function for Logarithm {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            log_determinant(&square(x)).0
        }
    }
    let plain = |x: &[f64]| vec![by_minors(&square(x).map(|x| x.0)).abs().ln()];
    for x in matrices() {
        if plain(&x)[0].is_infinite() {
            // Rounding may leave a determinant of 1e-13.
            assert!(Logarithm.eval(&x) < -25.0, "{x:?}");
            let cofactors = gradient(|x| Determinant.eval(x), &x);
            let modes = [
                gradient(|x| Logarithm.eval(x), &x),
                forward_gradient(&Logarithm, &x),
            ];
            for (slope, cofactor) in modes.iter().flatten().zip(cofactors.iter().cycle()) {
                // A cofactor of 0 may have a rounding error.
                let moves = cofactor.abs() > 1e-9;
                assert!(
                    !moves || slope.is_nan() || slope.abs() >= 1e9,
                    "{x:?}: {slope}"
                );
            }
            continue;
        }
        let slopes: Vec<f64> = (0..x.len())
            .flat_map(|k| differences(plain, &x, k, 1e-5))
            .collect();
        // The truncation error is h^2 times third derivatives, and the rounding error eps / h.
        for found in [
            gradient(|x| Logarithm.eval(x), &x),
            forward_gradient(&Logarithm, &x),
        ] {
            assert_close(&found, &slopes, 1e-8);
        }
        assert_close(&[Logarithm.eval(&x)], &plain(&x), 1e-13);
    }
    let tiny = DMatrix::from_diagonal_element(5, 5, Element(1e-100));
    assert_close(&[log_determinant(&tiny).0], &[5.0 * 1e-100_f64.ln()], 1e-11);
}

#[test]
fn what_has_no_determinant_is_nan() {
    let nan = DMatrix::from_element(4, 4, Element(f64::NAN));
    assert!(determinant(&nan).0.is_nan() && log_determinant(&nan).0.is_nan());
    assert_eq!(
        determinant(&DMatrix::from_element(0, 0, Element(f64::NAN))).0,
        1.0
    );
}

/// nalgebra's elimination divides by a pivot of zero that carries a derivative. Along a direction in which the pivot does
/// not move, it skips the column, and with it derivatives. If this test fails, nalgebra has changed, and the module's
/// documentation must change too.
#[test]
fn nalgebra_loses_derivatives_at_a_pivot_of_zero_that_does_not_move() {
    struct ByLu;
    impl Function for ByLu {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            square(x).lu().determinant().0
        }
    }
    let zero_column = [0.0_f64, 1.0, 0.0, 2.0];
    assert_eq!(
        gradient(|x| Determinant.eval(x), &zero_column),
        [2.0, 0.0, -1.0, 0.0]
    );
    assert_eq!(forward_gradient(&ByLu, &zero_column)[2], 0.0);
    let is_right = |slopes: &[f64], right: &[f64]| {
        // The cofactors are integers below 1000.
        let near = |(a, b): (&f64, &f64)| a.is_nan() || (a - b).abs() < 1e-12;
        slopes.iter().zip(right).all(near)
    };
    let slopes = gradient(|x| ByLu.eval(x), &zero_column);
    assert!(
        slopes[2].is_nan() && is_right(&slopes, &[2.0, 0.0, -1.0, 0.0]),
        "{slopes:?}"
    );
    // A column of zeros, where the cofactor of the entry in row 1 is -17.
    let zero_column_of_four = &matrices()[3];
    let own = gradient(|x| square(x).determinant().0, zero_column_of_four);
    let right = gradient(|x| Determinant.eval(x), zero_column_of_four);
    assert!(own[4].is_nan() && is_right(&own, &right), "{own:?}");
    assert_close(&[right[4]], &[-17.0], 1e-14);
}

/// Whether each of the crate's own solvers refuses the matrix: equations, the inverse, singular values.
fn refusals<R: Real>(x: &[R]) -> [bool; 3] {
    let matrix = square(x);
    let load = DVector::from_element(matrix.nrows(), Element::lit(1.0));
    [
        solve(&matrix, &load).is_none(),
        inverse(&matrix).is_none(),
        singular_values(&matrix).is_err(),
    ]
}

/// Rounding leaves pivots of 1e-16 in some of the matrices.
#[test]
fn singular_matrices_are_refused_in_every_mode_and_regular_ones_are_not() {
    let duals = |x: &[f64], moves: bool| match moves {
        true => x.iter().map(|&x| Dual::variable(x, 0)).collect(),
        false => x.iter().map(|&x| Dual::constant(x)).collect(),
    };
    for x in matrices() {
        let singular = by_minors(&square(&x).map(|x| x.0)) == 0.0;
        let on_tape = Tape::new().record(&x, refusals);
        let [still, moving]: [Vec<Dual<f64, 1>>; 2] = [false, true].map(|moves| duals(&x, moves));
        for found in [refusals(&x), on_tape, refusals(&still), refusals(&moving)] {
            assert_eq!(found[..2], [singular; 2], "{x:?}");
            assert!(found[2] || !singular, "{x:?}");
        }
    }
}

/// A sum of singular values with different weights, of a matrix with three columns.
struct Values;

impl Function for Values {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let entries = x.iter().copied().map(Element);
        let matrix = DMatrix::from_iterator(x.len() / 3, 3, entries);
        let values = singular_values(&matrix).expect("distinct values above 0");
        let weighted = values
            .iter()
            .enumerate()
            .map(|(k, value)| value.0 * R::lit(1.0 + k as f64));
        weighted.fold(R::zero(), |sum, x| sum + x)
    }
}

#[test]
fn singular_values_have_their_derivatives_where_entries_are_zero() {
    let diagonal = vec![1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0];
    let triangular = vec![1.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.5, 1.0, 4.0];
    let wide = vec![1.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let tall = vec![1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 7.0];
    for x in [diagonal, triangular, wide, tall] {
        let plain = |x: &[f64]| {
            let values = DMatrix::from_column_slice(x.len() / 3, 3, x).singular_values();
            let weighted = values
                .iter()
                .enumerate()
                .map(|(k, value)| value * (1.0 + k as f64));
            vec![weighted.sum()]
        };
        assert_close(&[Values.eval(&x)], &plain(&x), 1e-14);
        let of = |values: &dyn Fn(&[f64]) -> Vec<f64>, h| {
            let columns = (0..x.len()).map(|k| differences(values, &x, k, h));
            columns.collect::<Vec<Vec<f64>>>().concat()
        };
        // The truncation error is h^2 times third derivatives below 10, and the rounding error eps / h.
        let slopes = of(&plain, 1e-5);
        assert_close(&gradient(|x| Values.eval(x), &x), &slopes, 1e-8);
        assert_close(&forward_gradient(&Values, &x), &slopes, 1e-8);
        let second = of(&|x| gradient(|x| Values.eval(x), x), 1e-5);
        assert_close(&hessian_rows(&Values, &x).concat(), &second, 1e-8);
    }
}

/// The ways to solve equations and to invert.
#[derive(Clone, Copy, Debug)]
enum Way {
    Lu,
    FullLu,
    Qr,
    PivotedQr,
    Cholesky,
    Inverse,
    OwnSolution,
    OwnInverse,
    Eigen,
    Svd,
}

/// The ways that do not need distinct eigenvalues or singular values.
const WAYS: [Way; 8] = [
    Way::Lu,
    Way::FullLu,
    Way::Qr,
    Way::PivotedQr,
    Way::Cholesky,
    Way::Inverse,
    Way::OwnSolution,
    Way::OwnInverse,
];

impl Way {
    /// Returns the solution for the load 1, 2, 3, …, or the entries of the inverse.
    fn solved<R: Real>(self, x: &[R]) -> Option<Vec<R>> {
        let matrix = square(x);
        let size = matrix.nrows();
        let load = DVector::from_fn(size, |i, _| Element::lit(1.0 + i as f64));
        let solution = match self {
            Self::Lu => matrix.lu().solve(&load),
            Self::FullLu => matrix.full_piv_lu().solve(&load),
            Self::Qr => matrix.qr().solve(&load),
            Self::PivotedQr => matrix.col_piv_qr().solve(&load),
            Self::Cholesky => matrix.cholesky().map(|factors| factors.solve(&load)),
            Self::Inverse => {
                let inverse = matrix.try_inverse()?;
                return Some(inverse.iter().map(|x| x.0).collect());
            }
            Self::OwnSolution => solve(&matrix, &load),
            Self::OwnInverse => return Some(inverse(&matrix)?.iter().map(|x| x.0).collect()),
            Self::Eigen => {
                let eigen = matrix.symmetric_eigen();
                let by_mode = eigen.eigenvectors.tr_mul(&load);
                Some(&eigen.eigenvectors * by_mode.component_div(&eigen.eigenvalues))
            }
            Self::Svd => matrix.svd(true, true).solve(&load, Element::lit(0.0)).ok(),
        };
        Some(solution?.iter().map(|x| x.0).collect())
    }
}

/// Whether the matrix equals its transpose, up to the rounding of a difference.
fn symmetric(x: &[f64]) -> bool {
    let matrix = square(x).map(|x| x.0);
    matrix == matrix.transpose()
}

#[test]
fn solutions_are_right_at_zeros_and_repeated_values_and_refused_at_singular_matrices() {
    let distinct = vec![
        4.0, 1.0, 0.0, 0.5, 1.0, 5.0, 0.3, 0.0, 0.0, 0.3, 6.0, 1.0, 0.5, 0.0, 1.0, 8.0,
    ];
    let by_values = [Way::Eigen, Way::Svd].map(|way| (way, distinct.clone()));
    for (way, x) in &by_values {
        let [found, expected] = [*way, Way::Lu].map(|way| way.solved(x).expect("regular"));
        // Both solutions have the rounding errors of a few dozen operations.
        assert_close(&found, &expected, 1e-13);
    }
    let everywhere = WAYS
        .into_iter()
        .flat_map(|way| matrices().into_iter().map(move |x| (way, x)));
    for (way, x) in everywhere.chain(by_values) {
        if matches!(way, Way::Cholesky) && !symmetric(&x) {
            continue; // Cholesky's factorisation reads one triangle.
        }
        let regular = by_minors(&square(&x).map(|x| x.0)) != 0.0;
        let Some(plain) = way.solved(&x) else {
            continue;
        };
        if !regular {
            // Rounding made a pivot that is not quite zero, and the solution is as large as its inverse.
            let largest = plain.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            assert!(
                largest.is_nan() || largest >= 1e12,
                "{way:?} at {x:?}: {plain:?}"
            );
            continue;
        }
        let of = |x: &[f64]| way.solved(x).expect("a regular matrix");
        let count = plain.len();
        let by_column: Vec<Vec<f64>> = (0..x.len()).map(|k| differences(of, &x, k, 1e-5)).collect();
        let rows: Vec<f64> = (0..count)
            .flat_map(|i| by_column.iter().map(move |column| column[i]))
            .collect();
        // The truncation error is h^2 times third derivatives.
        let size = rows.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
        let tolerance = 1e-6 * size;
        let forward = jacobian(|x| way.solved(x).expect("a regular matrix"), &x);
        assert_close(forward.as_slice(), &rows, tolerance);
        let reverse = jacobian_reverse(|x| way.solved(x).expect("a regular matrix"), &x);
        assert_close(reverse.as_slice(), &rows, tolerance);
    }
}

/// The exponential, and the symmetric functions of the eigenvalues of a symmetric matrix.
#[test]
fn exponentials_and_groups_are_right_at_defective_and_repeated_inputs() {
    for x in matrices() {
        if x.iter().any(|x| x.abs() > 5.0) {
            continue; // The exponential would be large.
        }
        fn entries<R: Real>(x: &[R]) -> Vec<R> {
            exp(&square(x)).iter().map(|x| x.0).collect()
        }
        let count = x.len();
        let by_column: Vec<Vec<f64>> = (0..count)
            .map(|k| differences(entries::<f64>, &x, k, 1e-5))
            .collect();
        let rows: Vec<f64> = (0..count)
            .flat_map(|i| by_column.iter().map(move |column| column[i]))
            .collect();
        let size = rows.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
        // The truncation error is h^2 times third derivatives, which are as large as the entries.
        assert_close(jacobian(entries, &x).as_slice(), &rows, 1e-9 * size);
        assert_close(jacobian_reverse(entries, &x).as_slice(), &rows, 1e-9 * size);
    }
    struct Product;
    impl Function for Product {
        fn eval<R: Real>(&self, x: &[R]) -> R {
            let matrix = square(x);
            let even = (&matrix + matrix.transpose()) * Element::lit(0.5);
            let groups = symmetric_eigen_groups(&even, 100.0).expect("one group");
            determinant(&groups[0].block).0
        }
    }
    for size in 1..=5 {
        // All eigenvalues are 0, or all are 2.
        for value in [0.0, 2.0] {
            let x = DMatrix::from_diagonal_element(size, size, value)
                .as_slice()
                .to_vec();
            let whole = |x: &[f64]| {
                let matrix = square(x).map(|x| x.0);
                vec![by_minors(&((&matrix + matrix.transpose()) * 0.5))]
            };
            let slopes: Vec<f64> = (0..x.len())
                .flat_map(|k| differences(whole, &x, k, 1e-4))
                .collect();
            // The truncation error is h^2 times third derivatives below 10.
            assert_close(&gradient(|x| Product.eval(x), &x), &slopes, 1e-6);
            assert_close(&forward_gradient(&Product, &x), &slopes, 1e-6);
        }
    }
}
