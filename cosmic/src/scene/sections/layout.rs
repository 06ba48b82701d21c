//! The hand-made layouts: two three-legged layouts, and the filled layout of the paper's ablation. The paper does not
//! list the edges of its three-legged baseline, so the two three-legged layouts are drawn to resemble it.

use super::design::Layout;

/// The three-legged layouts are made for a square lattice with this number of nodes along each side.
pub(crate) const LAYOUT_SIDE: usize = 6;

/// The layout "tall". Each string holds the edges of a row of nodes, the bottom row first. Each digit is the material
/// of one edge: 0 is void, 1 skeleton, 2 actuator.
const TALL: [&str; LAYOUT_SIDE] = [
    "121020112100201121021",
    "021020102100201021021",
    "021020102100201021021",
    "100121012101201120100",
    "000100010001000000000",
    "00000",
];

/// The layout "short", in the form of [`TALL`].
const SHORT: [&str; LAYOUT_SIDE] = [
    "121020112100201121021",
    "121020112100201121021",
    "121121112011211121121",
    "200200010002000200000",
    "000000000000000000000",
    "00000",
];

impl Layout {
    /// The material of each of the 110 edges of the 6x6 lattice, in the order of the edges: 0 is void, 1 skeleton, 2
    /// actuator. `None` for the filled layout, which fits any lattice.
    pub fn materials(self) -> Option<Vec<u8>> {
        let rows = match self {
            Layout::Tall => TALL,
            Layout::Short => SHORT,
            Layout::Filled => return None,
        };
        let digits = rows.iter().flat_map(|row| row.bytes());
        Some(digits.map(|digit| digit - b'0').collect())
    }
}
