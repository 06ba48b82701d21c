//! The structure of a layout: how its bars are connected, and which connections a scene may require. A bar is an edge
//! of solid material.

use std::collections::VecDeque;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::Material;
use crate::geometry::{Dimension, crossings};
use crate::lattice::{EdgeRules, Lattice};
use crate::scene::DesignSettings;

/// The lowest row consists of the nodes whose height is below this, in units of the spacing.
const LEVEL: f64 = 1e-9;
/// Singular values up to this share of the largest one count as zero. Because lengths are about 1, the singular value
/// of a floppy mode is only a rounding error.
const RANK: f64 = 1e-9;
/// The largest number of bars for which floppy modes are counted. The time grows with the cube of the number; this many
/// bars take a few seconds.
pub const MOST_RANKED: usize = 2000;

crate::keys! {
    /// How the bars of a layout are connected.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Structure {
        /// Number of pieces, each of connected bars.
        pieces: usize, "whole number", columns ["pieces"];
        /// Number of nodes with a bar.
        nodes: usize, "whole number", columns ["nodes"];
        /// Number of ends of bars where there is neither another bar nor a payload.
        free_ends: usize, "whole number", columns ["free_ends"];
        /// Number of pairs of bars that cross between their ends.
        crossings: usize, "whole number", columns ["crossings"];
        /// Number of nodes in the lowest row with a bar.
        feet: usize, "whole number", columns ["feet"];
        /// Number of independent motions that stretch no bar, without rigid motions, if bars turn freely about their
        /// ends. `null` for more than 2000 bars.
        floppy_modes: Option<usize>, "whole number or `null`", columns ["floppy_modes"];
        /// Rest length of the shortest skeleton bar. `null` if there is none.
        shortest_skeleton: Option<f64>, "number or `null`", unit "m";
        /// Rest length of the shortest actuator. `null` if there is none.
        shortest_actuator: Option<f64>, "number or `null`", unit "m";
    }
}

impl Structure {
    /// The structure of a layout.
    pub fn new(lattice: &Lattice, layout: &[Material]) -> Self {
        let bars = Bars { lattice, layout };
        let degrees = bars.degrees();
        let live: Vec<usize> = (0..lattice.nodes()).filter(|&n| degrees[n] > 0).collect();
        let piece = bars.pieces();
        let mut pieces: Vec<usize> = live.iter().map(|&node| piece[node]).collect();
        pieces.sort_unstable();
        pieces.dedup();
        let ends: Vec<[usize; 2]> = bars.iter().map(|(_, ends)| ends).collect();
        Self {
            pieces: pieces.len(),
            nodes: live.len(),
            free_ends: bars.free_ends(),
            crossings: crossings(lattice.dimension, &lattice.places, &ends).len(),
            feet: bars.feet(),
            floppy_modes: (ends.len() <= MOST_RANKED).then(|| floppy_modes(lattice, &ends, &live)),
            shortest_skeleton: bars.shortest(Material::Skeleton),
            shortest_actuator: bars.shortest(Material::Actuator),
        }
    }
}

/// For each node, true if bars connect it to the first payload.
pub fn joined_to_payload(lattice: &Lattice, layout: &[Material]) -> Vec<bool> {
    Bars { lattice, layout }.held()
}

/// For each node, true if it has a bar or a payload.
pub fn is_in_use(lattice: &Lattice, layout: &[Material]) -> Vec<bool> {
    let degrees = Bars { lattice, layout }.degrees();
    let mut is_in_use: Vec<bool> = degrees.into_iter().map(|degree| degree > 0).collect();
    for payload in &lattice.payload {
        is_in_use[payload.node] = true;
    }
    is_in_use
}

/// The bars of a layout.
struct Bars<'a> {
    lattice: &'a Lattice,
    layout: &'a [Material],
}

impl Bars<'_> {
    /// Iterates over the bars: the index of the bar's edge, and its two nodes.
    fn iter(&self) -> impl Iterator<Item = (usize, [usize; 2])> {
        let edges = self.lattice.edges.iter().zip(self.layout).enumerate();
        let bars = edges.filter(|(_, (_, material))| material.is_solid());
        bars.map(|(edge, (ends, _))| (edge, *ends))
    }

    /// The rest length of the shortest bar of a material, m.
    fn shortest(&self, material: Material) -> Option<f64> {
        let lengths = self.lattice.rest_length.iter().zip(self.layout);
        let lengths = lengths.filter(|(_, m)| **m == material);
        lengths.map(|(length, _)| *length).reduce(f64::min)
    }

    /// The number of bars at every node.
    fn degrees(&self) -> Vec<usize> {
        let mut degrees = vec![0; self.lattice.nodes()];
        let ends = self.iter().flat_map(|(_, ends)| ends);
        ends.for_each(|node| degrees[node] += 1);
        degrees
    }

    /// Numbers the pieces of a layout. Returns a number for every node; nodes that are connected by bars have the same
    /// number.
    fn pieces(&self) -> Vec<usize> {
        let mut parent: Vec<usize> = (0..self.lattice.nodes()).collect();
        let root = |parent: &mut Vec<usize>, mut node: usize| {
            while parent[node] != node {
                parent[node] = parent[parent[node]];
                node = parent[node];
            }
            node
        };
        for (_, ends) in self.iter() {
            let [i, j] = ends.map(|node| root(&mut parent, node));
            parent[i] = j;
        }
        let nodes = 0..parent.len();
        nodes.map(|node| root(&mut parent, node)).collect()
    }

    fn payload(&self) -> impl Iterator<Item = usize> {
        self.lattice.payload.iter().map(|payload| payload.node)
    }

    /// For each node, true if bars connect it to the first payload.
    fn held(&self) -> Vec<bool> {
        let pieces = self.pieces();
        let first = self.payload().next().map(|node| pieces[node]);
        pieces.iter().map(|piece| Some(*piece) == first).collect()
    }

    fn free_ends(&self) -> usize {
        let degrees = self.degrees().into_iter().enumerate();
        let is_free = |node| self.payload().all(|payload| payload != node);
        degrees
            .filter(|&(node, degree)| degree == 1 && is_free(node))
            .count()
    }

    /// The number of nodes in the lowest row that have a bar.
    fn feet(&self) -> usize {
        let nodes = self.lattice.places.iter().zip(self.degrees());
        nodes
            .filter(|(place, degree)| place.up() < LEVEL && *degree > 0)
            .count()
    }
}

/// The rules that a layout must obey: the lattice's rules for its edges, and the requirements in the section `[design]`
/// of the scene.
#[derive(Clone, Debug)]
pub struct LayoutRules {
    lattice: Lattice,
    asked: DesignSettings,
    /// The pairs of edges that cross; empty if the scene allows bars to cross.
    crossing: Vec<[usize; 2]>,
}

impl LayoutRules {
    /// The rules of a lattice and the requirements `asked` of a scene, together.
    pub fn new(lattice: &Lattice, asked: &DesignSettings) -> Self {
        Self {
            crossing: if asked.crossings {
                Vec::new()
            } else {
                crossings(lattice.dimension, &lattice.places, &lattice.edges)
            },
            lattice: lattice.clone(),
            asked: asked.clone(),
        }
    }

    /// The lattice's rules: which materials each edge may have.
    pub(super) fn edges(&self) -> &EdgeRules {
        &self.lattice.rules
    }

    fn bars<'a>(&'a self, layout: &'a [Material]) -> Bars<'a> {
        let lattice = &self.lattice;
        Bars { lattice, layout }
    }

    /// Counts the faults of a layout: each bar and each payload that should be connected to the first payload but is
    /// not, and each violation of the other requirements.
    pub fn faults(&self, layout: &[Material]) -> usize {
        let (asked, bars) = (&self.asked, self.bars(layout));
        let mut faults = 0;
        if asked.one_piece {
            let held = bars.held();
            faults += bars.iter().filter(|(_, ends)| !held[ends[0]]).count();
            faults += bars.payload().filter(|&node| !held[node]).count();
        }
        if !asked.free_ends {
            faults += bars.free_ends();
        }
        if asked.feet > 0 {
            faults += asked.feet.saturating_sub(bars.feet());
        }
        let are_bars = |pair: &&[usize; 2]| pair.iter().all(|&edge| layout[edge].is_solid());
        faults + self.crossing.iter().filter(are_bars).count()
    }

    /// Removes the loose bars of a layout: the bars that are not connected to the first payload. If the scene does not
    /// require one piece, the layout does not change.
    pub fn without_loose_bars(&self, layout: &[Material]) -> Vec<Material> {
        let (mut rest, bars) = (layout.to_vec(), self.bars(layout));
        if self.asked.one_piece {
            let held = bars.held();
            for (edge, _) in bars.iter().filter(|(_, ends)| !held[ends[0]]) {
                rest[edge] = Material::Void;
            }
        }
        rest
    }

    /// Finds the shortest path of edges that, as bars, would connect a loose bar or a loose payload to the first
    /// payload. The path is empty if there is no such path, if nothing is loose, or if the scene does not require one
    /// piece.
    pub fn bridge(&self, layout: &[Material]) -> Vec<usize> {
        if !self.asked.one_piece {
            return Vec::new();
        }
        let bars = self.bars(layout);
        let (held, mut is_goal) = (bars.held(), vec![false; self.lattice.nodes()]);
        let ends = bars.iter().flat_map(|(_, ends)| ends);
        for node in ends.chain(bars.payload()) {
            is_goal[node] = !held[node];
        }
        // A breadth-first search from all connected nodes.
        let mut way: Vec<Option<[usize; 2]>> = vec![None; held.len()];
        let mut seen = held.clone();
        let mut front: VecDeque<usize> = (0..held.len()).filter(|&n| held[n]).collect();
        while let Some(node) = front.pop_front() {
            if is_goal[node] {
                let steps = std::iter::successors(way[node], |[_, from]| way[*from]);
                return steps.map(|[edge, _]| edge).collect();
            }
            for (edge, ends) in self.lattice.edges.iter().enumerate() {
                let Some(at) = ends.iter().position(|&end| end == node) else {
                    continue;
                };
                let next = ends[1 - at];
                if !seen[next] && self.edges().allowed(edge)[1..].contains(&true) {
                    seen[next] = true;
                    way[next] = Some([edge, node]);
                    front.push_back(next);
                }
            }
        }
        Vec::new()
    }
}

/// The number of floppy modes of hinged bars. It is the number of coordinates of the nodes, minus the rigid motions (three
/// in the plane; six in space, or five if all nodes are in one line), minus the rank of the matrix of the bars' directions.
/// `live` are the nodes with a bar, ascending.
fn floppy_modes(lattice: &Lattice, bars: &[[usize; 2]], live: &[usize]) -> usize {
    if bars.is_empty() {
        return 0;
    }
    let place = |node: usize| {
        live.binary_search(&node)
            .expect("`live` has both nodes of every bar")
    };
    let (dimension, axes) = (lattice.dimension, lattice.dimension.count());
    let straight = |node: &usize| {
        let [from, along] = [
            lattice.places[live[0]],
            lattice.places[live[1]] - lattice.places[live[0]],
        ];
        let (along, off) = (along.unit(), lattice.places[*node] - from);
        along.across(off).norm() < RANK
    };
    let in_line = dimension == Dimension::Space && live.iter().all(straight);
    let rigid = axes * (axes + 1) / 2 - usize::from(in_line);
    let mut matrix = DMatrix::<f64>::zeros(bars.len(), axes * live.len());
    for (row, &[i, j]) in bars.iter().enumerate() {
        let direction = dimension.components(lattice.direction([i, j]));
        for (k, along) in direction.enumerate() {
            matrix[(row, axes * place(i) + k)] = -along;
            matrix[(row, axes * place(j) + k)] = along;
        }
    }
    let values = matrix.singular_values();
    let rank = values.iter().filter(|v| **v > RANK * values[0]).count();
    (axes * live.len()).saturating_sub(rigid + rank)
}
