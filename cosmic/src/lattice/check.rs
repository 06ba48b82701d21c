//! Checks trusses and renumbers their nodes.

use std::collections::{HashMap, HashSet};

use super::own::{Payload, Truss, median};
use crate::geometry::Bounds;

/// The largest distance of a node from the origin of the ground, in metres. Generated lattices have the same limit.
const FARTHEST: f64 = 1e3;
/// The length of the shortest allowed edge, in metres. Generated lattices have the same limit. In a small truss,
/// shorter edges are allowed too.
const SHORTEST: f64 = 1e-3;
/// The length of the shortest allowed edge, as a share of the median length, in a truss whose median length is below
/// 0.1 m.
const SHORTEST_SHARE: f64 = 0.01;
/// The largest stiffness of a bar, in N/m. Scenes have the same limit.
const STIFFEST: f64 = 1e9;
/// The largest mass of a payload, in kg. Scenes have the same limit.
const HEAVIEST: f64 = 1e3;

/// The end of a message about the number of a node.
const COUNTED: &str = "; nodes are counted from 0";
/// The end of a message about edges that count nodes from 1.
const COUNTED_FROM_1: &str = "; nodes are counted from 0, but these edges count from 1: subtract 1 from every number of \
    a node";

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
    /// - a rule names an unknown edge, or an edge is under two rules;
    /// - there are rest lengths or stiffnesses, but not one for every edge, or they are impossible;
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
            if x.array().iter().any(|x| x.is_nan() || x.abs() > FARTHEST) {
                return Err(format!(
                    "`nodes[{node}]`: expected numbers from -{FARTHEST} to {FARTHEST}, found {:?}; lengths are in metres: \
                     divide lengths in millimetres by 1000",
                    self.dimension.list(*x)
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
                let hint = if i == j { "" } else { self.hint_of_counting() };
                return Err(format!(
                    "`edges[{e}]`: expected two different nodes below {nodes}, found [{i}, {j}]{hint}"
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
        let median = median(&lengths).unwrap_or(f64::INFINITY);
        let shortest = SHORTEST.min(SHORTEST_SHARE * median);
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
            Some(node) => Err(format!(
                "`nodes[{node}]`: no edge has node {node}{}",
                if node == 0 { COUNTED } else { "" }
            )),
            None => Ok(()),
        }
    }

    /// The end of a message about an edge to a node that does not exist.
    fn hint_of_counting(&self) -> &'static str {
        let named = self.edges.as_flattened().iter();
        match (named.clone().min(), named.max()) {
            (Some(1..), Some(most)) if *most == self.nodes.len() => COUNTED_FROM_1,
            _ => COUNTED,
        }
    }

    /// Checks only the payload and the edge rules.
    ///
    /// # Errors
    /// The errors of [`checked`](Self::checked).
    pub(crate) fn check_marks(&self) -> Result<(), String> {
        self.check_payload()?;
        self.check_rules()?;
        self.check_bars()
    }

    fn check_bars(&self) -> Result<(), String> {
        let edges = self.edges.len();
        for (name, list, most, unit) in [
            ("rest", &self.rest, FARTHEST, "m"),
            ("stiffness", &self.stiffness, STIFFEST, "N/m"),
        ] {
            if !list.is_empty() && list.len() != edges {
                return Err(format!(
                    "`{name}`: expected {edges} numbers, one for every edge, found {}",
                    list.len()
                ));
            }
            let wrong = |&&(_, &x): &&(usize, &f64)| !(x > 0.0 && x <= most);
            let numbers: Vec<_> = list.iter().enumerate().collect();
            if let Some((edge, x)) = numbers.iter().find(wrong) {
                return Err(format!(
                    "`{name}[{edge}]`: expected a number above 0 {unit} and at most {most} {unit}, found {x}"
                ));
            }
        }
        Ok(())
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
                    "`payload`: expected a node below {nodes}, found {node}{COUNTED}"
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
            let says = || {
                format!(
                    "`{what}`: expected an edge below {edges}, found {edge}; edges are counted from 0"
                )
            };
            if edge < edges { Ok(()) } else { Err(says()) }
        };
        let mut ruled = HashMap::new();
        for (name, list) in rules.lists() {
            for (k, &edge) in list.iter().enumerate() {
                known(format!("{name}[{k}]"), edge)?;
                let other = *ruled.entry(edge).or_insert(name);
                if other != name {
                    return Err(format!(
                        "`{name}`: edge {edge} is also in `{other}`; remove it from one of the two"
                    ));
                }
            }
        }
        let mut seen = HashSet::new();
        for (k, tie) in rules.tie.iter().enumerate() {
            if tie.len() < 2 {
                return Err(format!(
                    "`tie[{k}]`: expected two edges or more, found {}",
                    tie.len()
                ));
            }
            for &edge in tie {
                known(format!("tie[{k}]"), edge)?;
                if !seen.insert(edge) {
                    return Err(format!("`tie[{k}]`: edge {edge} is tied twice"));
                }
                if rules.allowed(edge) != rules.allowed(tie[0]) {
                    return Err(format!(
                        "`tie[{k}]`: edges {} and {edge} are under different rules; tied edges must all \
                         be in the same one of `keep`, `skeleton`, `actuator` and `forbid`, or all in none",
                        tie[0]
                    ));
                }
            }
        }
        Ok(())
    }
}
