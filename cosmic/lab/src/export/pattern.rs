//! The flat pattern: the bars as strips of plate with a hole at each end, layer by layer.
//!
//! Bars turn about the pins at their ends, so bars that share a node or cross are in different layers. Bars of one
//! layer are at least [`Sizes::gap`] apart. Each layer is cut from a plate exactly as it is drawn, and stacked on the
//! layers below. Layers are drawn beside one another.

use super::layers::Stack;
use super::member::Member;
use super::sizes::{Sizes, misfit};
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::geometry::{Bounds, Segment, Vector};

/// The space around each layer on the sheet, in mm.
const MARGIN: f64 = 10.0;
/// The height of the labels of layers, in mm.
pub(super) const LABEL: f64 = 6.0;

/// A bar on the sheet of the flat pattern. Positions are in mm from the sheet's lower left corner.
pub(super) struct Part {
    /// The index of the bar's edge.
    pub(super) edge: usize,
    /// The nodes at its first and second hole.
    pub(super) nodes: [usize; 2],
    /// The line from the middle of the first hole to the middle of the second.
    pub(super) axis: Segment,
    /// The ends of the two straight sides, counterclockwise: right of the first hole, right of the second, left of the
    /// second, left of the first. Half circles join the second corner to the third, and the fourth to the first.
    pub(super) corners: [Vector<f64>; 4],
    /// The angle between the bar and the sheet's lower edge, in degrees.
    pub(super) angle: f64,
    /// True for an actuator. The strip of an actuator only shows how much space it needs.
    pub(super) is_actuator: bool,
}

impl Part {
    /// Returns the label on the bar: its first node, its edge in brackets, and its second node.
    pub(super) fn label(&self) -> String {
        let [i, j] = self.nodes;
        format!("{i} [{}] {j}", self.edge)
    }
}

/// A layer of bars on the sheet.
pub(super) struct Layer {
    /// The bars of the layer.
    pub(super) parts: Vec<Part>,
    /// The position at which the layer's label begins.
    pub(super) label: Vector<f64>,
}

/// The drawing of all layers on one sheet, as SVG or DXF files show it.
pub(super) struct Pattern {
    /// Layers from the lowest to the highest.
    pub(super) layers: Vec<Layer>,
    /// The layer of each bar.
    pub(super) stack: Stack,
    /// The width and height of the sheet, in mm.
    pub(super) size: Vector<f64>,
    /// The sizes of bars and holes.
    pub(super) sizes: Sizes,
}

impl Pattern {
    pub(super) fn new(members: &[Member], sizes: &Sizes) -> Result<Self> {
        check(members, sizes)?;
        let apart = sizes.width + sizes.gap;
        let reach = 0.5 * (sizes.width + sizes.hole);
        let stack = Stack::new(members, reach, |a, b| a.distance(b) < apart);
        if let Some([edge, node]) = stack.blocked {
            return Err(misfit(format!(
                "the bar of edge {edge} lies across node {node}, whose pin would go through it; use --csv or \
                 --stl instead"
            )));
        }
        let ends = members
            .iter()
            .flat_map(|member| [member.axis.from, member.axis.to]);
        let bounds = Bounds::of(ends);
        // A tile is the space for one layer on the sheet. `inset` leads from its lower left corner to the lower left
        // corner of the nodes' bounding box.
        let inset = Vector::new([MARGIN + 0.5 * sizes.width; 2]);
        let tile = bounds.size() + inset * 2.0 + Vector::new([0.0, LABEL]);
        let count = stack.height();
        let columns = (count as f64).sqrt().ceil() as usize;
        let rows = count.div_ceil(columns);
        let layer = |layer: usize| {
            // Layers are placed from left to right, and then downwards, as on a page.
            let place = [layer % columns, rows - 1 - layer / columns].map(|k| k as f64);
            let corner = tile.zip_with(Vector::new(place), |size, place| place * size);
            let shift = corner + inset - bounds.low;
            let own = members.iter().zip(&stack.of_member);
            let own = own.filter(|(_, l)| **l == layer);
            Layer {
                parts: own.map(|(m, _)| part(m, shift, sizes.width)).collect(),
                label: corner + Vector::new([MARGIN, tile.up() - LABEL - 0.5 * MARGIN]),
            }
        };
        Ok(Self {
            layers: (0..count).map(layer).collect(),
            size: tile.zip_with(Vector::new([columns, rows]), |size, count| {
                count as f64 * size
            }),
            sizes: *sizes,
            stack,
        })
    }

    /// Returns the height of the labels on bars, in mm.
    pub(super) fn label_height(&self) -> f64 {
        0.3 * self.sizes.width
    }
}

/// Returns a bar at its place on the sheet. `shift` moves the bar to this place, and `width` is the width of its strip.
fn part(member: &Member, shift: Vector<f64>, width: f64) -> Part {
    let (a, b) = (member.axis.from + shift, member.axis.to + shift);
    let direction = member.axis.direction();
    let left = direction.turned_left() * (0.5 * width);
    Part {
        edge: member.edge,
        nodes: member.nodes,
        axis: Segment::new(a, b),
        corners: [a - left, b - left, b + left, a + left],
        angle: direction.angle().to_degrees(),
        is_actuator: member.material == Material::Actuator,
    }
}

/// Returns an error if the holes are too large for the bars.
fn check(members: &[Member], sizes: &Sizes) -> Result<()> {
    let Sizes { width, hole, .. } = sizes;
    if hole >= width {
        return Err(misfit(format!(
            "the hole is {hole} mm wide, but must be narrower than the bar, which is {width} mm wide"
        )));
    }
    // There must be as much material between the two holes as beside a hole.
    let least = hole + 0.5 * (width - hole);
    match members.iter().find(|member| member.axis.length() < least) {
        None => Ok(()),
        Some(member) => Err(misfit(format!(
            "the bar of edge {} is {:.3} mm long, but needs at least {least} mm for its holes: choose a smaller \
             width and hole",
            member.edge,
            member.axis.length()
        ))),
    }
}
