//! Motions of hinged bars that stretch no bar.

use nalgebra::DMatrix;

use crate::geometry::{Dimension, Vector};

/// Singular values up to this share of the largest one count as zero. Because directions have the length 1, the singular
/// value of a floppy mode is only a rounding error.
const RANK: f64 = 1e-9;

/// The number of floppy modes of hinged bars. It is the number of coordinates of the nodes, minus the rigid motions (three
/// in the plane; six in space, or five if all nodes are in one line), minus the rank of the matrix of the bars' directions.
/// `places` are the places of the nodes, and `live` are the nodes with a bar, ascending.
pub(crate) fn floppy_modes(
    dimension: Dimension,
    places: &[Vector<f64>],
    bars: &[[usize; 2]],
    live: &[usize],
) -> usize {
    if bars.is_empty() {
        return 0;
    }
    let place = |node: usize| {
        live.binary_search(&node)
            .expect("`live` has both nodes of every bar")
    };
    let axes = dimension.count();
    let straight = |node: &usize| {
        let [from, along] = [places[live[0]], places[live[1]] - places[live[0]]];
        let (along, off) = (along.unit(), places[*node] - from);
        along.across(off).norm() < RANK
    };
    let in_line = dimension == Dimension::Space && live.iter().all(straight);
    let rigid = axes * (axes + 1) / 2 - usize::from(in_line);
    let mut matrix = DMatrix::<f64>::zeros(bars.len(), axes * live.len());
    for (row, &[i, j]) in bars.iter().enumerate() {
        let direction = dimension.components((places[j] - places[i]).unit());
        for (k, along) in direction.enumerate() {
            matrix[(row, axes * place(i) + k)] = -along;
            matrix[(row, axes * place(j) + k)] = along;
        }
    }
    let values = matrix.singular_values();
    let rank = values.iter().filter(|v| **v > RANK * values[0]).count();
    (axes * live.len()).saturating_sub(rigid + rank)
}
