//! The tilt of an initial design: the share of void grows from one side to the other. The seed determines the
//! direction.

use std::f64::consts::TAU;

use crate::geometry::{Range, Segment, Vector};
use crate::lattice::Lattice;
use crate::random::{Purpose, stream, symmetric};

/// The share of void in an edge is clamped to this range after the tilt.
const VOID: Range = Range::new(0.001, 0.999);

/// Adds a surplus to the share of void of every edge: `tilt (1 + cos(a) x + sin(a) y)`. Here `x` and `y` go from -1 to
/// 1 across the lattice, and `a` is a random angle. If the direction of the angle is along an axis, the surplus grows
/// from 0 at one side of the lattice to `2 tilt` at the other side. If the direction is diagonal, the surplus grows
/// from `-0.4 tilt` in one corner to `2.4 tilt` in the opposite corner.
///
/// The angle depends on the seed, and all angles are equally likely. So a search over seeds also searches for the side
/// that should have less material.
pub fn tilted(void: &[f64], lattice: &Lattice, tilt: f64, seed: u64) -> Vec<f64> {
    let angle = symmetric(&mut stream(seed, Purpose::Tilt), 0.5 * TAU);
    let (sin, cos) = angle.sin_cos();
    let edge = |(m, middle): (&f64, Vector<f64>)| {
        let [x, y] = middle.in_plane();
        (m + tilt * (1.0 + cos * x + sin * y)).clamp(VOID.low, VOID.high)
    };
    let edges = void.iter().zip(midpoints(lattice));
    edges.map(edge).collect()
}

/// The midpoints of the edges, with coordinates from -1 to 1 across the lattice.
fn midpoints(lattice: &Lattice) -> Vec<Vector<f64>> {
    let extent = lattice.extent();
    let at = |node: usize| {
        lattice.places[node].zip_with(extent, |place, extent| match extent {
            0.0 => 0.0,
            extent => 2.0 * place / extent - 1.0,
        })
    };
    let middle = |&[i, j]: &[usize; 2]| Segment::new(at(i), at(j)).middle();
    lattice.edges.iter().map(middle).collect()
}
