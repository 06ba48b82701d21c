//! Checks trusses and renumbers their nodes.

use std::collections::HashSet;

use super::own::{Payload, Truss};
use crate::geometry::Bounds;

/// The largest distance of a node from the origin of the ground, in metres. Generated lattices have the same limit.
const FARTHEST: f64 = 1e3;
/// The length of the shortest allowed edge, in metres. Generated lattices have the same limit. In a small truss,
/// shorter edges are allowed too.
const SHORTEST: f64 = 1e-3;
/// The length of the shortest allowed edge, as a share of the median length, in a truss whose median length is below
/// 0.1 m.
const SHORTEST_SHARE: f64 = 0.01;
/// The largest mass of a payload, in kg. Scenes have the same limit.
const HEAVIEST: f64 = 1e3;

impl Truss {
    /// Checks the truss and renumbers its nodes for the simulator: the first payload becomes node 0. Sorts each group
    /// of tied edges. Edges keep their numbers.
    ///
    /// # Errors
    /// A sentence with the wrong value's key in backquotes, if there is one of these errors:
    /// - there is no edge; a node is beyond 1000 m or has no edge;
    /// - the given numbers are not the node numbers in some order;
    /// - an edge has an unknown node, is shorter than a millimetre (in a truss whose median
    ///   length is below 0.1 m, than 1 % of that length) or is listed twice;
    /// - a payload has an unknown node or an impossible mass, or two payloads have the same node;
    /// - a rule names an unknown edge, or an edge is both kept and forbidden;
    /// - a tied group has fewer than two edges, or edges under different rules, or an edge is tied twice.
    pub fn checked(mut self) -> Result<Self, String> {
        self.check_nodes()?;
        self.check_edges()?;
        self.check_marks()?;
        (self.rules.tie.iter_mut()).for_each(|tie| tie.sort_unstable());
        self.renumber();
        Ok(self)
    }

    /// Renumbers the nodes. The first payload becomes node 0, and the former node 0 gets its number. The other nodes
    /// may be renumbered to save memory: the simulator needs one slot per node for each distinct difference between the
    /// numbers of an edge's two nodes. If numbering the nodes along the longer side of the truss gives fewer distinct
    /// differences, they are numbered that way. Renumbering a truss twice changes nothing.
    fn renumber(&mut self) {
        let nodes = self.nodes.len();
        let first = self.payload[0].node;
        let mut given: Vec<usize> = (0..nodes).collect();
        given.swap(0, first);
        let mut along = given.clone();
        let size = Bounds::of(self.nodes.iter().copied()).size();
        along[1..].sort_by(|&a, &b| self.nodes[a].total_cmp_along(self.nodes[b], size));
        let [given_numbers, along_numbers] = [&given, &along].map(|order| {
            let mut numbers = vec![0; nodes];
            (order.iter().enumerate()).for_each(|(number, &node)| numbers[node] = number);
            numbers
        });
        let differences = |numbers: &[usize]| {
            let difference = |&[i, j]: &[usize; 2]| numbers[i].abs_diff(numbers[j]);
            let all: HashSet<usize> = self.edges.iter().map(difference).collect();
            all.len()
        };
        let (order, numbers) = if differences(&along_numbers) < differences(&given_numbers) {
            (along, along_numbers)
        } else {
            (given, given_numbers)
        };
        self.nodes = order.iter().map(|&node| self.nodes[node]).collect();
        let given: Vec<usize> = order.iter().map(|&node| self.given_number(node)).collect();
        let is_changed = given.iter().enumerate().any(|(node, given)| node != *given);
        self.given_numbers = if is_changed { given } else { Vec::new() };
        for node in self.edges.as_flattened_mut() {
            *node = numbers[*node];
        }
        for payload in &mut self.payload {
            payload.node = numbers[payload.node];
        }
    }

    fn check_nodes(&self) -> Result<(), String> {
        let mut given = self.given_numbers.clone();
        given.sort_unstable();
        if !given.is_empty() && !given.iter().copied().eq(0..self.nodes.len()) {
            return Err(format!(
                "`given_numbers`: expected each whole number from 0 to {} exactly once, or no numbers",
                self.nodes.len().saturating_sub(1)
            ));
        }
        for (node, x) in self.nodes.iter().enumerate() {
            if x.iter().any(|x| x.is_nan() || x.abs() > FARTHEST) {
                return Err(format!(
                    "`nodes[{node}]`: expected numbers from -{FARTHEST} to {FARTHEST}, found {x:?}"
                ));
            }
        }
        Ok(())
    }

    fn check_edges(&self) -> Result<(), String> {
        let nodes = self.nodes.len();
        let (mut seen, mut has_edge) = (HashSet::new(), vec![false; nodes]);
        let mut lengths = Vec::new();
        for (e, &[i, j]) in self.edges.iter().enumerate() {
            if i == j || i.max(j) >= nodes {
                return Err(format!(
                    "`edges[{e}]`: expected two different nodes below {nodes}, found [{i}, {j}]"
                ));
            }
            if !seen.insert([i.min(j), i.max(j)]) {
                return Err(format!("`edges[{e}]`: [{i}, {j}] is given twice"));
            }
            lengths.push(self.nodes[i].distance(self.nodes[j]));
            (has_edge[i], has_edge[j]) = (true, true);
        }
        if self.edges.is_empty() {
            return Err("`edges`: expected at least one edge, found none".to_owned());
        }
        let mut sorted = lengths.clone();
        sorted.sort_by(f64::total_cmp);
        let shortest = SHORTEST.min(SHORTEST_SHARE * sorted[sorted.len() / 2]);
        if let Some(e) = lengths
            .iter()
            .position(|length| *length < shortest || *length == 0.0)
        {
            let ([i, j], length) = (self.edges[e], lengths[e]);
            return Err(format!(
                "`edges[{e}]`: expected nodes at least {shortest} m apart, found [{i}, {j}], which are {length} m apart"
            ));
        }
        match has_edge.iter().position(|has| !has) {
            Some(node) => Err(format!("`nodes[{node}]`: no edge has node {node}")),
            None => Ok(()),
        }
    }

    /// Checks only the payload and the edge rules.
    ///
    /// # Errors
    /// The errors of [`checked`](Self::checked).
    pub(crate) fn check_marks(&self) -> Result<(), String> {
        self.check_payload()?;
        self.check_rules()
    }

    fn check_payload(&self) -> Result<(), String> {
        let nodes = self.nodes.len();
        if self.payload.is_empty() {
            return Err("`payload`: expected at least one node, found none".to_owned());
        }
        let mut seen = HashSet::new();
        for (k, &Payload { node, mass }) in self.payload.iter().enumerate() {
            if node >= nodes {
                return Err(format!(
                    "`payload`: expected a node below {nodes}, found {node}"
                ));
            }
            if !seen.insert(node) {
                return Err(format!("`payload[{k}]`: node {node} is given twice"));
            }
            if let Some(mass) = mass.filter(|mass| !(0.0..=HEAVIEST).contains(mass)) {
                return Err(format!(
                    "`payload[{k}].mass`: expected a number from 0 to {HEAVIEST}, found {mass}"
                ));
            }
        }
        Ok(())
    }

    fn check_rules(&self) -> Result<(), String> {
        let (edges, rules) = (self.edges.len(), &self.rules);
        let known = |what: String, edge: usize| {
            let says = || format!("`{what}`: expected an edge below {edges}, found {edge}");
            if edge < edges { Ok(()) } else { Err(says()) }
        };
        for (name, list) in [("keep", &rules.keep), ("forbid", &rules.forbid)] {
            for (k, &edge) in list.iter().enumerate() {
                known(format!("{name}[{k}]"), edge)?;
            }
        }
        let both = |edge: &&usize| rules.keep.contains(*edge);
        if let Some(edge) = rules.forbid.iter().find(both) {
            return Err(format!(
                "`forbid`: edge {edge} is also in `keep`; remove it from one of the two"
            ));
        }
        let mut seen = HashSet::new();
        for (k, tie) in rules.tie.iter().enumerate() {
            if tie.len() < 2 {
                return Err(format!(
                    "`tie[{k}]`: expected two edges or more, found {}",
                    tie.len()
                ));
            }
            let rule = |edge: usize| [true, false].map(|solid| rules.allow(edge, solid));
            for &edge in tie {
                known(format!("tie[{k}]"), edge)?;
                if !seen.insert(edge) {
                    return Err(format!("`tie[{k}]`: edge {edge} is tied twice"));
                }
                if rule(edge) != rule(tie[0]) {
                    return Err(format!(
                        "`tie[{k}]`: edges {} and {edge} are under different rules; tied edges must all \
                         be in `keep`, all in `forbid` or all in neither",
                        tie[0]
                    ));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::{Segment, Vector};
    use crate::lattice::{EdgeRules, Payload, Truss};
    use proptest::prelude::*;
    use std::collections::{BTreeSet, HashSet};

    /// Two triangles with a common edge, and one edge that ends freely.
    const KITE: &str = r#"{
 "format": "cosmic-truss", "version": 1,
 "nodes": [[0, 0], [0.1, 0], [0.05, 0.1], [0.15, 0.1], [0.3, 0.1]],
 "edges": [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [3, 4]],
 "payload": [{"node": 2, "mass": 0.5}, {"node": 0}],
 "keep": [5], "forbid": [0], "tie": [[4, 2, 3]]
}"#;

    fn refusal(from: &str, to: &str) -> String {
        assert!(KITE.contains(from), "{from}");
        let text = KITE.replacen(from, to, 1);
        Truss::parse("kite.json", &text).unwrap_err().to_string()
    }

    #[test]
    fn invalid_trusses_are_refused_with_their_place() {
        for (from, to, says) in [
            (
                "[1, 2], ",
                "[1, 9], ",
                "`edges[2]`: expected two different nodes below 5, found [1, 9]",
            ),
            (
                "[1, 2], ",
                "[2, 2], ",
                "`edges[2]`: expected two different nodes below 5, found [2, 2]",
            ),
            (
                "[1, 2], ",
                "[1, 0], ",
                "`edges[2]`: [1, 0] is given twice\n --> kite.json:4:28",
            ),
            (
                "[0.1, 0]",
                "[0, 0.0005]",
                "`edges[0]`: expected nodes at least 0.001 m apart",
            ),
            (
                ", [3, 4]",
                "",
                "`nodes[4]`: no edge has node 4\n --> kite.json:3:56",
            ),
            (
                "[0.3, 0.1]",
                "[3e3, 0]",
                "`nodes[4]`: expected numbers from -1000 to 1000",
            ),
            ("[0.3, 0.1]", "[0, 1, 2]", "`nodes[4]`: too many values"),
            (
                "\"node\": 2",
                "\"node\": 7",
                "`payload`: expected a node below 5, found 7",
            ),
            (
                "\"keep\"",
                "\"given_numbers\": [0, 1, 2, 3, 3], \"keep\"",
                "`given_numbers`: expected each whole number from 0 to 4 exactly once",
            ),
            (
                "\"node\": 0",
                "\"node\": 2",
                "`payload[1]`: node 2 is given twice",
            ),
            (
                "0.5}",
                "-0.5}",
                "`payload[0].mass`: expected a number from 0 to 1000, found -0.5",
            ),
            (
                "[{\"node\": 2, \"mass\": 0.5}, {\"node\": 0}]",
                "[]",
                "`payload`: expected at least one",
            ),
            (
                "[{\"node\": 2, \"mass\": 0.5}, {\"node\": 0}]",
                "\"x\"",
                "expected a node, or a list",
            ),
            (
                "\"keep\": [5]",
                "\"keep\": [6]",
                "`keep[0]`: expected an edge below 6, found 6",
            ),
            (
                "\"keep\": [5]",
                "\"keep\": [0]",
                "`forbid`: edge 0 is also in `keep`",
            ),
            (
                "[[4, 2, 3]]",
                "[[4, 8]]",
                "`tie[0]`: expected an edge below 6, found 8",
            ),
            (
                "[[4, 2, 3]]",
                "[[4]]",
                "`tie[0]`: expected two edges or more, found 1",
            ),
            (
                "[[4, 2, 3]]",
                "[[4, 3, 4]]",
                "`tie[0]`: edge 4 is tied twice",
            ),
            (
                "[[4, 2, 3]]",
                "[[4, 3], [2, 3]]",
                "`tie[1]`: edge 3 is tied twice",
            ),
            (
                "[[4, 2, 3]]",
                "[[4, 5]]",
                "`tie[0]`: edges 4 and 5 are under different rules",
            ),
            (
                "cosmic-truss",
                "truss",
                "`format` is \"truss\" version 1, not \"cosmic-truss\"",
            ),
            ("\"version\": 1", "\"version\": 2", "version 2, not"),
            (
                "\"format\": \"cosmic-truss\", ",
                "",
                "missing field `format`",
            ),
            ("\"tie\"", "\"ties\"", "unknown field `ties`"),
        ] {
            let found = refusal(from, to);
            assert!(
                found.contains(says) && found.contains("kite.json:"),
                "{found}"
            );
        }
        let none = "{\"format\": \"cosmic-truss\", \"version\": 1, \"nodes\": [], \"edges\": []}";
        let none = Truss::parse("none", none).unwrap_err().to_string();
        assert!(none.contains("expected at least one edge"), "{none}");
    }

    /// A truss is valid even if its edges cross, overlap or end freely, or if it consists of separate pieces.
    #[test]
    fn unusual_trusses_are_read() {
        let fine = r#"{"format": "cosmic-truss", "version": 1,
            "nodes": [[0, 0], [1, 1], [0, 1], [1, 0], [2, 0], [5, 5], [5, 6]],
            "edges": [[0, 1], [2, 3], [0, 3], [0, 4], [5, 6]], "payload": 3}"#;
        let fine = Truss::parse("fine", fine).unwrap();
        let mass = None;
        assert_eq!(fine.payload, [Payload { node: 0, mass }]);
        let ends = |edge: usize| fine.edges[edge].map(|node| fine.nodes[node]);
        assert_eq!(fine.nodes[0], [1.0, 0.0]);
        assert_eq!(ends(2), [[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(ends(4), [[5.0, 5.0], [5.0, 6.0]]);
    }

    #[test]
    fn the_payload_is_node_0_and_copies_are_equal() {
        let kite = Truss::parse("kite", KITE).unwrap();
        assert_eq!(
            kite.payload.iter().map(|p| p.node).collect::<Vec<_>>(),
            [0, 2]
        );
        assert_eq!(kite.edges[..3], [[2, 1], [2, 0], [1, 0]]);
        assert_eq!(kite.rules.tie, [[2, 3, 4]]);
        assert_eq!(
            kite.rules.groups(6),
            [vec![0], vec![1], vec![2, 3, 4], vec![5]]
        );
        assert_eq!(Truss::parse("copy", &kite.to_json()).unwrap(), kite);
        assert_eq!(kite.lowest(), 0.0);
    }

    /// A ladder of 20 cells has randomly numbered nodes. They are renumbered from one end of the ladder to the other.
    #[test]
    fn nodes_are_numbered_along_the_truss_where_that_saves_places() {
        let mut shuffled: Vec<usize> = (0..42).collect();
        shuffled[1..].sort_by_key(|&k| (1e6 * (13.0 * k as f64).sin()) as i64);
        let place = |&k: &usize| Vector::new([0.1 * (k / 2) as f64, 0.1 * (k % 2) as f64]);
        let nodes: Vec<Vector<f64>> = shuffled.iter().map(place).collect();
        let is_near = |[i, j]: [usize; 2]| nodes[i].distance(nodes[j]) < 0.11;
        let pairs = (0..42).flat_map(|i| (i + 1..42).map(move |j| [i, j]));
        let truss = Truss {
            edges: pairs.filter(|&pair| is_near(pair)).collect(),
            nodes: nodes.clone(),
            ..Truss::default()
        };
        let differences = |truss: &Truss| {
            let edges = truss.edges.iter().map(|[i, j]| i.abs_diff(*j));
            edges.collect::<HashSet<_>>().len()
        };
        let numbered = truss.clone().checked().unwrap();
        assert!(differences(&truss) > 10);
        // One difference for the rungs and one for the rails. Node 0 is at an end of the ladder and stays the first
        // node.
        assert_eq!(differences(&numbered), 2);
        assert_eq!(numbered.nodes[0], truss.nodes[0]);
        let ends = |truss: &Truss| -> Vec<Segment> {
            let edges = truss.edges.iter();
            edges
                .map(|&[i, j]| Segment::new(truss.nodes[i], truss.nodes[j]))
                .collect()
        };
        assert_eq!(ends(&numbered), ends(&truss));
        assert_eq!(numbered.clone().checked().unwrap(), numbered);
    }

    proptest! {
        /// Every truss is either refused or renumbered. Renumbering changes nothing else.
        #[test]
        fn a_truss_is_refused_or_numbered_once(
            nodes in prop::collection::vec([0.0..1.0, 0.0..1.0], 7),
            more in prop::collection::vec((0..7usize, 0..7usize), 0..12),
            (first, other) in (0..7usize, prop::option::of(0..7usize)),
            keep in prop::collection::vec(0..12usize, 0..2),
            forbid in prop::collection::vec(0..12usize, 0..2),
            tie in prop::collection::vec(prop::collection::vec(0..12usize, 0..4), 0..2),
        ) {
            let payload = [first].into_iter().chain(other);
            let path = (0..6).map(|node| [node, node + 1]);
            let more: BTreeSet<_> = more.into_iter().filter(|(i, j)| i + 1 < *j).collect();
            let edges = path.chain(more.into_iter().map(|(i, j)| [j, i])).collect();
            let truss = Truss {
                payload: payload.map(|node| Payload { node, mass: None }).collect(),
                rules: EdgeRules { keep, forbid, tie },
                nodes: nodes.into_iter().map(Vector::new).collect(),
                edges,
                given_numbers: Vec::new(),
            };
            let Ok(numbered) = truss.clone().checked() else { return Ok(()) };
            let ends = |truss: &Truss| -> Vec<Segment> {
                let edges = truss.edges.iter();
                edges.map(|&[i, j]| Segment::new(truss.nodes[i], truss.nodes[j])).collect()
            };
            prop_assert_eq!(ends(&numbered), ends(&truss));
            prop_assert_eq!(numbered.payload[0].node, 0);
            prop_assert_eq!(numbered.nodes[0], truss.nodes[first]);
            let given = |node: usize| truss.nodes[numbered.given_number(node)];
            prop_assert_eq!((0..7).map(given).collect::<Vec<_>>(), numbered.nodes.clone());
            let copy = Truss::parse("copy", &numbered.to_json()).unwrap();
            prop_assert_eq!(&copy.given_numbers, &numbered.given_numbers);
            prop_assert_eq!(copy, numbered);
        }
    }

    #[test]
    #[should_panic(expected = "the lattice \"bad\": `edges[0]`")]
    fn an_invalid_truss_cannot_be_added() {
        let edges = vec![[0, 0]];
        let bad = Truss {
            edges,
            ..Truss::default()
        };
        let _ = crate::Registry::default().with_lattice("bad", bad);
    }
}
