//! The flat pattern: the bars as strips of plate with a hole at either end, layer by layer.
//!
//! Bars turn about the pins at their ends, so two bars of one node cannot lie in one plane any more
//! than two that cross. Bars of a layer are at least the gap apart: a layer can be cut from a plate as
//! it is drawn, and stacked on the layers below as it is drawn. Layers are drawn beside one another.

use super::layers::Stack;
use super::member::Member;
use super::sizes::{Sizes, misfit};
use cosmic::design::Material;
use cosmic::error::Result;

/// Space around each layer on the sheet, mm.
const MARGIN: f64 = 10.0;
/// Height of the labels of layers, mm.
pub(super) const LABEL: f64 = 6.0;

/// A bar on the sheet, mm from the lower left corner of it.
pub(super) struct Part {
    /// The number of its edge.
    pub(super) edge: usize,
    /// The nodes of its holes.
    pub(super) nodes: [usize; 2],
    /// The middles of its holes.
    pub(super) ends: [[f64; 2]; 2],
    /// Corners of the straight sides, counterclockwise: two at the first end's right and the second
    /// end's right, two at the second's left and the first's. Half circles join second and third, and
    /// fourth and first.
    pub(super) corners: [[f64; 2]; 4],
    /// Angle of the bar to the sheet's lower edge, degrees.
    pub(super) angle: f64,
    /// True for an actuator, which is no strip of plate: the strip shows the room that it takes.
    pub(super) is_actuator: bool,
}

impl Part {
    /// Its number and the nodes from its first end to its second.
    pub(super) fn label(&self) -> String {
        let [i, j] = self.nodes;
        format!("{i} [{}] {j}", self.edge)
    }

    /// Where its label is.
    pub(super) fn middle(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [0, 1].map(|k| 0.5 * (a[k] + b[k]))
    }
}

/// A layer on the sheet.
pub(super) struct Layer {
    /// Its bars.
    pub(super) parts: Vec<Part>,
    /// Where its label begins.
    pub(super) label: [f64; 2],
}

/// The sheet.
pub(super) struct Pattern {
    /// Layers from the lowest to the highest.
    pub(super) layers: Vec<Layer>,
    /// The layers of the bars and of the nodes.
    pub(super) stack: Stack,
    /// Width and height of the sheet, mm.
    pub(super) size: [f64; 2],
    /// The sizes that it is drawn with.
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
                "the bar of edge {edge} lies across node {node}, whose pin would go through it"
            )));
        }
        let [mut low, mut high] = [[f64::MAX; 2], [f64::MIN; 2]];
        for end in members.iter().flat_map(|member| member.ends) {
            low = [0, 1].map(|k| end[k].min(low[k]));
            high = [0, 1].map(|k| end[k].max(high[k]));
        }
        let tile = [0, 1].map(|k| high[k] - low[k] + sizes.width + 2.0 * MARGIN);
        let tile = [tile[0], tile[1] + LABEL];
        let count = stack.height();
        let columns = (count as f64).sqrt().ceil() as usize;
        let rows = count.div_ceil(columns);
        let layer = |layer: usize| {
            // As on a page: from left to right, and rows downwards.
            let left = (layer % columns) as f64 * tile[0];
            let bottom = (rows - 1 - layer / columns) as f64 * tile[1];
            let edge = MARGIN + 0.5 * sizes.width;
            let shift = [left + edge - low[0], bottom + edge - low[1]];
            let own = members.iter().zip(&stack.of_member);
            let own = own.filter(|(_, l)| **l == layer);
            Layer {
                parts: own.map(|(m, _)| part(m, shift, sizes.width)).collect(),
                label: [left + MARGIN, bottom + tile[1] - LABEL - 0.5 * MARGIN],
            }
        };
        Ok(Self {
            layers: (0..count).map(layer).collect(),
            size: [columns as f64 * tile[0], rows as f64 * tile[1]],
            sizes: *sizes,
            stack,
        })
    }

    /// Height of the labels on bars, mm.
    pub(super) fn label_height(&self) -> f64 {
        0.3 * self.sizes.width
    }
}

/// A bar, moved to its place on the sheet.
fn part(member: &Member, shift: [f64; 2], width: f64) -> Part {
    let ends @ [a, b] = member.ends.map(|x| [x[0] + shift[0], x[1] + shift[1]]);
    let [ux, uy] = member.direction();
    let half = 0.5 * width;
    let left = |x: [f64; 2]| [x[0] - half * uy, x[1] + half * ux];
    let right = |x: [f64; 2]| [x[0] + half * uy, x[1] - half * ux];
    Part {
        edge: member.edge,
        nodes: member.nodes,
        ends,
        corners: [right(a), right(b), left(b), left(a)],
        angle: uy.atan2(ux).to_degrees(),
        is_actuator: member.material == Material::Actuator,
    }
}

/// Refuses holes that leave no bar.
fn check(members: &[Member], sizes: &Sizes) -> Result<()> {
    let Sizes { width, hole, .. } = sizes;
    if hole >= width {
        return Err(misfit(format!(
            "a hole of {hole} mm is as wide as a bar, {width} mm"
        )));
    }
    // Between the holes there is as much as beside them.
    let least = hole + 0.5 * (width - hole);
    match members.iter().find(|member| member.span() < least) {
        None => Ok(()),
        Some(member) => Err(misfit(format!(
            "the bar of edge {} is {:.3} mm long, and its holes take {least} mm of it: choose a smaller \
             width and hole",
            member.edge,
            member.span()
        ))),
    }
}
