//! Solids as binary STL, in millimetres: convex prisms, each a closed surface of its own.

/// A convex prism.
pub(super) struct Prism {
    /// The corners of its base, counterclockwise as seen from its top, mm.
    pub(super) base: Vec<[f64; 3]>,
    /// From the base to the top, mm.
    pub(super) along: [f64; 3],
}

impl Prism {
    /// Its surface, corners counterclockwise as seen from outside. A corner has the same bits in all
    /// triangles that meet there, so that programs find them joined.
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

/// The file of some prisms. Normals are left for readers to take from the corners, as the format allows.
pub(super) fn binary(prisms: &[Prism]) -> Vec<u8> {
    let triangles: Vec<_> = prisms.iter().flat_map(Prism::triangles).collect();
    // 80 bytes that must not begin with "solid", which would mean text.
    let mut bytes = format!("{:<80}", "cosmic, millimetres").into_bytes();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for corners in triangles {
        bytes.extend([0; 12]);
        bytes.extend(corners.as_flattened().iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}
