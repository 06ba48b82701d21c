//! The structure of a layout: how its bars are connected, and which connections a scene may require. A bar is an edge
//! of solid material.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::Material;
use crate::geometry::crossings;
use crate::lattice::{EdgeRules, Lattice, floppy_modes};
use crate::scene::DesignSettings;

/// The lowest row consists of the nodes whose height is below this, in units of the spacing.
const LEVEL: f64 = 1e-9;
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
            floppy_modes: (ends.len() <= MOST_RANKED)
                .then(|| floppy_modes(lattice.dimension, &lattice.places, &ends, &live)),
            shortest_skeleton: bars.shortest(Material::Skeleton),
            shortest_actuator: bars.shortest(Material::Actuator),
        }
    }
}

/// For each node, true if bars connect it to the first payload.
pub fn joined_to_payload(lattice: &Lattice, layout: &[Material]) -> Vec<bool> {
    Bars { lattice, layout }.held()
}

/// For each node, true if it has a bar or a payload: its presence is not 0.
pub(crate) fn is_present(lattice: &Lattice, layout: &[Material]) -> Vec<bool> {
    let degrees = Bars { lattice, layout }.degrees();
    let mut is_present: Vec<bool> = degrees.into_iter().map(|degree| degree > 0).collect();
    for payload in &lattice.payload {
        is_present[payload.node] = true;
    }
    is_present
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

    /// Counts the faults of a layout, and prepares for counting those of layouts that differ from it in one edge.
    pub(super) fn counted<'a>(&'a self, layout: &'a [Material]) -> Faults<'a> {
        Faults::new(self, layout)
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

/// The [faults](LayoutRules::faults) of a layout. Counts those of a layout that differs from it in one edge without looking
/// at all other edges.
pub(super) struct Faults<'a> {
    bars: Bars<'a>,
    rules: &'a LayoutRules,
    /// The number of faults.
    pub(super) count: usize,
    /// The piece of each node.
    pieces: Vec<usize>,
    /// The piece of the first payload.
    held: Option<usize>,
    /// For each piece, the numbers of its bars and payloads.
    loads: Vec<usize>,
    degrees: Vec<usize>,
    feet: usize,
    is_payload: Vec<bool>,
    /// For each edge, true if its piece would fall apart without its bar.
    divides: Vec<bool>,
    /// For each edge, the edges that it crosses, if they must not be bars at once.
    crossed: Vec<Vec<usize>>,
}

impl<'a> Faults<'a> {
    fn new(rules: &'a LayoutRules, layout: &'a [Material]) -> Self {
        let bars = rules.bars(layout);
        let (nodes, edges) = (rules.lattice.nodes(), rules.lattice.edges.len());
        let pieces = bars.pieces();
        let mut loads = vec![0; nodes];
        bars.iter()
            .for_each(|(_, [node, _])| loads[pieces[node]] += 1);
        let mut is_payload = vec![false; nodes];
        for node in bars.payload() {
            is_payload[node] = true;
            loads[pieces[node]] += 1;
        }
        let mut crossed = vec![Vec::new(); edges];
        for &[a, b] in &rules.crossing {
            crossed[a].push(b);
            crossed[b].push(a);
        }
        let held = bars.payload().next().map(|node| pieces[node]);
        Self {
            count: rules.faults(layout),
            held,
            feet: bars.feet(),
            degrees: bars.degrees(),
            divides: bars.dividing(),
            bars,
            rules,
            pieces,
            loads,
            is_payload,
            crossed,
        }
    }

    /// The number of faults if the edge `edge` had the material `to`.
    pub(super) fn after(&self, edge: usize, to: Material) -> usize {
        let Bars { lattice, layout } = self.bars;
        let (was, is) = (layout[edge].is_solid(), to.is_solid());
        if was == is {
            return self.count;
        }
        let ends = lattice.edges[edge];
        let [from, into] = ends.map(|node| self.pieces[node]);
        let is_held = |piece: usize| Some(piece) == self.held;
        let asked = &self.rules.asked;
        if asked.one_piece && was && is_held(from) && self.divides[edge] {
            let mut changed = layout.to_vec();
            changed[edge] = to;
            return self.rules.faults(&changed);
        }
        // The faults before and after the change of what the edge can change.
        let [mut before, mut after] = [0, 0];
        if asked.one_piece {
            match (is_held(from), is_held(into)) {
                (true, true) => {}
                (false, false) => [before, after] = [usize::from(was), usize::from(is)],
                (true, false) => before = self.loads[into],
                (false, true) => before = self.loads[from],
            }
        }
        let feet = ends.map(|node| lattice.places[node].up() < LEVEL);
        let degrees = ends.map(|node| self.degrees[node]);
        let then = degrees.map(|degree| if is { degree + 1 } else { degree - 1 });
        if !asked.free_ends {
            let is_end =
                |degree: usize, node: usize| usize::from(degree == 1 && !self.is_payload[node]);
            before += is_end(degrees[0], ends[0]) + is_end(degrees[1], ends[1]);
            after += is_end(then[0], ends[0]) + is_end(then[1], ends[1]);
        }
        if asked.feet > 0 {
            let of = |degrees: [usize; 2]| {
                let with_bar = feet.iter().zip(degrees);
                with_bar
                    .filter(|(foot, degree)| **foot && *degree > 0)
                    .count()
            };
            before += asked.feet.saturating_sub(self.feet);
            after += asked
                .feet
                .saturating_sub(self.feet + of(then) - of(degrees));
        }
        let crossed = self.crossed[edge].iter();
        let crossed = crossed.filter(|other| layout[**other].is_solid()).count();
        before += crossed * usize::from(was);
        after += crossed * usize::from(is);
        self.count + after - before
    }
}

impl Bars<'_> {
    /// For each edge, true if it is a bar without which its piece would fall apart. Searches every piece in depth: a bar
    /// divides its piece if no other bar leads from the nodes beyond it back to a node before it (R. Tarjan, "A note on
    /// finding the bridges of a graph", 1974).
    fn dividing(&self) -> Vec<bool> {
        let nodes = self.lattice.nodes();
        let mut at = vec![Vec::new(); nodes];
        for (edge, [i, j]) in self.iter() {
            at[i].push((edge, j));
            at[j].push((edge, i));
        }
        let mut divides = vec![false; self.layout.len()];
        // When each node was reached, and the earliest node that the nodes beyond it lead back to.
        let (mut reached, mut back) = (vec![usize::MAX; nodes], vec![usize::MAX; nodes]);
        let mut clock = 0;
        for root in 0..nodes {
            if reached[root] != usize::MAX {
                continue;
            }
            // Each entry: a node, the edge by which it was reached, and how many of its bars were followed.
            let mut path = vec![(root, usize::MAX, 0)];
            (reached[root], back[root]) = (clock, clock);
            clock += 1;
            while let Some((node, by, followed)) = path.last_mut() {
                let (node, by) = (*node, *by);
                if let Some(&(edge, next)) = at[node].get(*followed) {
                    *followed += 1;
                    if edge == by {
                        continue;
                    }
                    if reached[next] == usize::MAX {
                        (reached[next], back[next]) = (clock, clock);
                        clock += 1;
                        path.push((next, edge, 0));
                    } else {
                        back[node] = back[node].min(reached[next]);
                    }
                    continue;
                }
                path.pop();
                if let Some((before, ..)) = path.last() {
                    back[*before] = back[*before].min(back[node]);
                    divides[by] = back[node] > reached[*before];
                }
            }
        }
        divides
    }
}
