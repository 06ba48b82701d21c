//! Solids as binary STL, in millimetres: convex prisms, each with a closed surface.

use cosmic::geometry::Vector;

/// A convex prism in space.
pub struct Prism {
    /// The corners of its base, counterclockwise as seen from its top, in mm.
    pub base: Vec<[f64; 3]>,
    /// The vector from the base to the top, in mm.
    pub along: [f64; 3],
}

impl Prism {
    /// Returns the triangles of the prism's surface, with corners counterclockwise as seen from outside. A corner has
    /// the same bits in all of its triangles, so that other programs recognise a closed surface.
    fn triangles(&self) -> Vec<[[f32; 3]; 3]> {
        let single = |corner: [f64; 3]| corner.map(|x| x as f32);
        let base: Vec<_> = self.base.iter().map(|&x| single(x)).collect();
        let raised = |x: &[f64; 3]| single([0, 1, 2].map(|k| x[k] + self.along[k]));
        let top: Vec<_> = self.base.iter().map(raised).collect();
        let count = base.len();
        let mut triangles = Vec::new();
        for k in 1..count - 1 {
            triangles.push([base[0], base[k + 1], base[k]]);
            triangles.push([top[0], top[k], top[k + 1]]);
        }
        for k in 0..count {
            let next = (k + 1) % count;
            triangles.push([base[k], base[next], top[next]]);
            triangles.push([base[k], top[next], top[k]]);
        }
        triangles
    }
}

/// Returns the unit normal of a triangle. Seen from the side to which the normal points, the corners run
/// counterclockwise.
fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    let edge = |to: [f32; 3]| [0, 1, 2].map(|k| f64::from(to[k]) - f64::from(a[k]));
    let (u, v) = (edge(b), edge(c));
    let cross = [(1, 2), (2, 0), (0, 1)].map(|(k, l)| u[k] * v[l] - u[l] * v[k]);
    let length = cross.iter().map(|x| x * x).sum::<f64>().sqrt();
    // The STL format uses zeros as the normal of a triangle without area.
    cross.map(|x| {
        if length > 0.0 {
            (x / length) as f32
        } else {
            0.0
        }
    })
}

/// Returns the point in space at `height` above a point of the plane.
pub(super) fn spatial(point: Vector<f64>, height: f64) -> [f64; 3] {
    let [x, y] = point.array();
    [x, y, height]
}

/// Returns the bytes of a binary STL file that contains the prisms.
pub fn binary(prisms: &[Prism]) -> Vec<u8> {
    let triangles: Vec<_> = prisms.iter().flat_map(Prism::triangles).collect();
    // The head of 80 bytes must not begin with "solid", which would mean a text file.
    let mut bytes = format!("{:<80}", "cosmic, millimetres").into_bytes();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        let numbers = normal(corners)
            .into_iter()
            .chain(corners.as_flattened().iter().copied());
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend(0u16.to_le_bytes());
    }
    bytes
}
