//! The determinant of a matrix, by recursive expansion along the first row.
//!
//! The expansion along the upper rows is a sum over all choices of a different column in each row. The terms have the
//! same form, so they are computed in lanes. Each choice is a datum of ones and zeros: multiplied with a row, they pick
//! the entry in the chosen column. If the matrix is large, its first rows are expanded by nested calls, which saves
//! memory.

use autodiff::{Function, Real, gradient};
use autodiff_programs::data::{Sum, Summand};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Error, Prepared, read, require, work};

#[derive(Deserialize)]
struct Input {
    #[serde(rename = "A")]
    matrix: Vec<f64>,
    ell: usize,
}

/// The order of the minors that remain after the expansion.
const LEAF: usize = 6;
/// The largest order for which the determinant is a single sum over data.
const LARGEST: usize = 9;

/// A term of the expansion along all rows but the last [`LEAF`]: the product of one entry of each upper row and the
/// remaining minor. The datum of a term holds its sign, followed by ones and zeros. These pick a column for each upper
/// row, and then for each remaining column.
#[derive(Clone)]
struct Term {
    order: usize,
}

impl Summand for Term {
    fn eval<R: Real>(&self, matrix: &[R], datum: &[R]) -> R {
        let (order, upper) = (self.order, self.order - LEAF);
        let mut minor = [R::zero(); LEAF * LEAF];
        let mut product = datum[0];
        for row in 0..upper {
            let pick = &datum[1 + row * order..][..order];
            product *= R::dot(&matrix[row * order..][..order], pick);
        }
        for column in 0..LEAF {
            let pick = &datum[1 + (upper + column) * order..][..order];
            for row in 0..LEAF {
                let entries = &matrix[(upper + row) * order..][..order];
                minor[row * LEAF + column] = R::dot(entries, pick);
            }
        }
        product * of_six(&minor, [0, 1, 2, 3, 4, 5])
    }
}

/// Defines a function that computes a minor of a small matrix, from its last rows and as many columns. The function
/// uses minors with one row less.
macro_rules! expansion {
    ($name:ident, $order:literal, $smaller:ident) => {
        #[inline(always)]
        fn $name<R: Real>(matrix: &[R], columns: [usize; $order]) -> R {
            let row = &matrix[(LEAF - $order) * LEAF..][..LEAF];
            let mut sum = R::zero();
            for j in 0..$order {
                let mut others = [0; $order - 1];
                for k in 0..$order - 1 {
                    others[k] = columns[if k < j { k } else { k + 1 }];
                }
                let term = row[columns[j]] * $smaller(matrix, others);
                sum += if j % 2 == 0 { term } else { -term };
            }
            sum
        }
    };
}

expansion! { of_six, 6, of_five }
expansion! { of_five, 5, of_four }
expansion! { of_four, 4, of_three }
expansion! { of_three, 3, of_two }

/// Returns the minor of the last two rows in the columns `a` and `b`.
#[inline(always)]
fn of_two<R: Real>(matrix: &[R], [a, b]: [usize; 2]) -> R {
    let (upper, last) = matrix[(LEAF - 2) * LEAF..].split_at(LEAF);
    upper[a] * last[b] - upper[b] * last[a]
}

/// The determinant as a function of all entries of a matrix.
struct Determinant {
    order: usize,
}

impl Function for Determinant {
    fn eval<R: Real>(&self, matrix: &[R]) -> R {
        let order = self.order.min(LARGEST);
        let expansion = (order >= LEAF).then(|| Sum::new(Term { order }, &ways(order)));
        determinant(matrix, self.order, expansion.as_ref())
    }
}

/// Returns the determinant of a matrix. `expansion` is a recorded sum that computes determinants of one fixed order. For
/// a larger matrix, this function calls itself on smaller matrices until they have that order.
fn determinant<R: Real>(matrix: &[R], order: usize, expansion: Option<&Sum<Term>>) -> R {
    if order == 1 {
        return matrix[0];
    }
    if (LEAF..=LARGEST).contains(&order)
        && let Some(expansion) = expansion
    {
        return expansion.run(matrix);
    }
    let (first, below) = matrix.split_at(order);
    let mut sum = R::zero();
    for (j, &entry) in first.iter().enumerate() {
        let others = below
            .chunks(order)
            .flat_map(|row| [&row[..j], &row[j + 1..]]);
        let others: Vec<R> = others.flatten().copied().collect();
        let entry = if j % 2 == 0 { entry } else { -entry };
        sum = entry.fma(determinant(&others, order - 1, expansion), sum);
    }
    sum
}

/// Returns all ways to choose a different column in each upper row. Each way is a datum of [`Term`].
fn ways(order: usize) -> Vec<Vec<f64>> {
    let mut ways = Vec::new();
    let mut columns: Vec<usize> = (0..order).collect();
    choose(&mut columns, 0, 1.0, &mut ways);
    ways
}

/// Appends all choices whose first `chosen` columns are fixed. The other columns are in ascending order.
fn choose(columns: &mut [usize], chosen: usize, sign: f64, ways: &mut Vec<Vec<f64>>) {
    let order = columns.len();
    if chosen + LEAF == order {
        let mut way = vec![0.0; 1 + order * order];
        way[0] = sign;
        for (row, &column) in columns.iter().enumerate() {
            way[1 + row * order + column] = 1.0;
        }
        ways.push(way);
        return;
    }
    for j in chosen..order {
        columns[chosen..=j].rotate_right(1);
        let odd = (j - chosen) % 2 == 1;
        choose(columns, chosen + 1, if odd { -sign } else { sign }, ways);
        columns[chosen..=j].rotate_left(1);
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { matrix, ell } = read(input)?;
    let entries = ell.checked_mul(ell);
    require(
        ell > 0 && entries == Some(matrix.len()),
        "`A` must have `ell * ell` numbers",
    )?;
    let determinant = Determinant { order: ell };
    match function {
        "primal" => work(move || determinant.eval(&matrix)),
        "gradient" => work(move || gradient(|x| determinant.eval(x), &matrix)),
        _ => Error::function(function),
    }
}
