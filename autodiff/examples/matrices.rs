//! Differentiates Cholesky's factorisation, the inverse and the eigenvalues of the stiffness matrix of a chain of
//! springs.
use autodiff::matrices::{Element, symmetric_eigen};
use autodiff::{Real, gradient};
use nalgebra::DMatrix;

/// Returns the stiffness matrix of masses in a row. The first spring joins the first mass to a wall.
fn stiffness<R: Real>(springs: &[R]) -> DMatrix<Element<R>> {
    DMatrix::from_fn(springs.len(), springs.len(), |i, j| match i.abs_diff(j) {
        0 => Element(springs[i] + springs.get(i + 1).copied().unwrap_or(R::zero())),
        1 => Element(-springs[i.max(j)]),
        _ => Element::lit(0.0),
    })
}

fn log_determinant<R: Real>(springs: &[R]) -> R {
    let factor = stiffness(springs).cholesky().unwrap().unpack();
    factor.diagonal().iter().map(|d| d.0.ln() + d.0.ln()).sum()
}

fn compliance<R: Real>(springs: &[R]) -> R {
    stiffness(springs).try_inverse().unwrap()[(3, 3)].0
}

fn lowest<R: Real>(springs: &[R]) -> R {
    symmetric_eigen(&stiffness(springs)).unwrap()[0].value.0
}

fn main() {
    let springs = [1.0, 2.0, 3.0, 4.0];
    let by_determinant = gradient(log_determinant, &springs);
    let by_compliance = gradient(compliance, &springs);
    let by_lowest = gradient(lowest, &springs);
    println!("{by_determinant:.4?}\n{by_compliance:.4?}\n{by_lowest:.4?}");
    let mode = &symmetric_eigen(&stiffness(&springs)).unwrap()[0].vector;
    for i in 1..4 {
        assert!((by_determinant[i] - 1.0 / springs[i]).abs() < 1e-14);
        assert!((by_compliance[i] + 1.0 / springs[i].powi(2)).abs() < 1e-14);
        assert!((by_lowest[i] - (mode[i] - mode[i - 1]).0.powi(2)).abs() < 1e-14);
    }
}
