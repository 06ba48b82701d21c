//! Trusses: lattices whose nodes and edges come from a file or from a program.

use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize};

use crate::error::{Error, Result};
use crate::geometry::{Dimension, Row, Vector};
use crate::reading::{from_json, placed, read_at_most, text_of};
use crate::registry::Registry;

/// The value of the key `format` in a truss file.
const FORMAT: &str = "cosmic-truss";
/// The value of the key `version` in a truss file.
const VERSION: u32 = 1;

/// The size of the largest truss file that is read, in bytes. A truss of ten thousand edges needs half a million bytes.
const LARGEST: u64 = 1 << 26;

/// A truss in the plane or in space. Edges may cross, overlap and have free ends, and the truss may consist of several pieces.
/// [`checked`](Truss::checked) lists the errors that a truss can have.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(into = "RawTruss", try_from = "RawTruss")]
pub struct Truss {
    /// Whether the nodes are in the plane or in space.
    pub dimension: Dimension,
    /// The positions of the nodes along the ground, across and above it, in metres from the ground's origin.
    pub nodes: Vec<Vector<f64>>,
    /// The two nodes `[i, j]` that each edge joins.
    pub edges: Vec<[usize; 2]>,
    /// The nodes with extra mass. There is at least one. In reports and losses, the payload is the first one.
    pub payload: Vec<Payload>,
    /// Restrictions on the materials of the edges.
    pub rules: EdgeRules,
    /// The rest length of each edge, in metres. Empty if they are the distances of the nodes.
    pub rest: Vec<f64>,
    /// The stiffness of the bar of each edge, in N/m, whether it is skeleton or actuator. Empty if the stiffnesses are
    /// those of the scene's materials.
    pub stiffness: Vec<f64>,
    /// The number that each node had in the original file or program. Empty if no node was renumbered.
    pub given_numbers: Vec<usize>,
}

/// Compares trusses without the original numbers of their nodes.
impl PartialEq for Truss {
    fn eq(&self, other: &Self) -> bool {
        (&self.nodes, &self.edges) == (&other.nodes, &other.edges)
            && (&self.payload, &self.rules) == (&other.payload, &other.rules)
            && (&self.rest, &self.stiffness) == (&other.rest, &other.stiffness)
    }
}

/// A node with extra mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// The number of the node.
    pub node: usize,
    /// The extra mass of the node, in kg. `None` means the setting `physics.payload_mass` of the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
}

impl Payload {
    /// A payload at a single node, with the mass `physics.payload_mass` of the scene.
    pub fn at(node: usize) -> Vec<Self> {
        vec![Self { node, mass: None }]
    }
}

/// Restrictions on the materials of edges. The numbers are indices into the list of edges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EdgeRules {
    /// Edges that are always solid: either skeleton or actuator.
    pub keep: Vec<usize>,
    /// Edges that are always skeleton.
    pub skeleton: Vec<usize>,
    /// Edges that are always actuators.
    pub actuator: Vec<usize>,
    /// Edges that are always void.
    pub forbid: Vec<usize>,
    /// Groups of edges that share one design vector. Each group is in ascending order.
    pub tie: Vec<Vec<usize>>,
}

impl EdgeRules {
    /// True for each material that the rules allow for `edge`: void, skeleton and actuator.
    pub fn allowed(&self, edge: usize) -> [bool; 3] {
        let is_in = |list: &[usize]| list.contains(&edge);
        if is_in(&self.forbid) {
            [true, false, false]
        } else if is_in(&self.skeleton) {
            [false, true, false]
        } else if is_in(&self.actuator) {
            [false, false, true]
        } else {
            [!is_in(&self.keep), true, true]
        }
    }

    /// True if the rules allow every material for every edge.
    pub(crate) fn allow_all(&self) -> bool {
        self.lists().iter().all(|(_, list)| list.is_empty())
    }

    /// The lists of edges whose materials are restricted, with their keys in a truss file.
    pub(super) fn lists(&self) -> [(&'static str, &[usize]); 4] {
        [
            ("keep", &self.keep),
            ("skeleton", &self.skeleton),
            ("actuator", &self.actuator),
            ("forbid", &self.forbid),
        ]
    }

    /// All edges in groups. The edges of a group share a design vector. An edge that is not tied forms a group by
    /// itself. Groups are in the order of their first edges.
    pub fn groups(&self, edges: usize) -> Vec<Vec<usize>> {
        let tie = |edge: usize| self.tie.iter().find(|tie| tie.contains(&edge));
        let group = |edge: usize| match tie(edge) {
            None => Some(vec![edge]),
            Some(tie) => (tie[0] == edge).then(|| tie.clone()),
        };
        (0..edges).filter_map(group).collect()
    }
}

/// The sides of a robot that are mirror images of each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Of a robot in the plane. Its image walks the other way.
    FrontAndBack,
    /// Of a robot in space. Its image walks the same way.
    LeftAndRight,
}

/// For each node and each edge of a lattice, its mirror image: the node or the edge on the other side of the middle.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    /// The sides that change places.
    pub sides: Sides,
    /// The image of each node.
    pub nodes: Vec<usize>,
    /// The image of each edge.
    pub edges: Vec<usize>,
}

/// The keys of a truss file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTruss {
    format: String,
    version: u32,
    // Two coordinates in the plane, three in space.
    nodes: Vec<Row>,
    edges: Vec<[usize; 2]>,
    #[serde(default = "first_node", deserialize_with = "payload")]
    payload: Vec<Payload>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    keep: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    skeleton: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    actuator: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    forbid: Vec<usize>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    tie: Vec<Vec<usize>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    rest: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    stiffness: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    given_numbers: Vec<usize>,
}

/// The payload of a truss file that names none: node 0.
fn first_node() -> Vec<Payload> {
    Payload::at(0)
}

/// Reads the key `payload`: the number of a node, or a list of nodes with their masses.
fn payload<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Vec<Payload>, D::Error> {
    #[derive(Deserialize)]
    #[serde(
        untagged,
        expecting = "expected a node, or a list of objects with the keys `node` and `mass`"
    )]
    enum Form {
        Node(usize),
        List(Vec<Payload>),
    }
    Ok(match Form::deserialize(from)? {
        Form::Node(node) => Payload::at(node),
        Form::List(list) => list,
    })
}

impl From<Truss> for RawTruss {
    fn from(truss: Truss) -> Self {
        let rules = truss.rules;
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            nodes: truss.dimension.rows(&truss.nodes),
            edges: truss.edges,
            payload: truss.payload,
            keep: rules.keep,
            skeleton: rules.skeleton,
            actuator: rules.actuator,
            forbid: rules.forbid,
            tie: rules.tie,
            rest: truss.rest,
            stiffness: truss.stiffness,
            given_numbers: truss.given_numbers,
        }
    }
}

impl TryFrom<RawTruss> for Truss {
    type Error = String;

    fn try_from(raw: RawTruss) -> std::result::Result<Self, String> {
        if (&*raw.format, raw.version) != (FORMAT, VERSION) {
            return Err(format!(
                "`format` is {:?} version {}, not {FORMAT:?} version {VERSION}",
                raw.format, raw.version
            ));
        }
        let first = raw.nodes.first().map_or(2, |row| row.len());
        let fits = |(node, x): (usize, &Row)| match x.len() {
            count @ (2 | 3) if count == first => Ok(()),
            _ => Err(format!(
                "`nodes[{node}]`: expected two coordinates, [along, above], for all nodes, or three, [along, across, \
                 above], found {x:?}"
            )),
        };
        let mut nodes = raw.nodes.iter().enumerate();
        nodes.try_for_each(fits)?;
        let dimension = Dimension::of_rows(&raw.nodes)?;
        let truss = Truss {
            dimension,
            nodes: raw.nodes.iter().map(|x| dimension.vector(x)).collect(),
            edges: raw.edges,
            payload: raw.payload,
            rules: EdgeRules {
                keep: raw.keep,
                skeleton: raw.skeleton,
                actuator: raw.actuator,
                forbid: raw.forbid,
                tie: raw.tie,
            },
            rest: raw.rest,
            stiffness: raw.stiffness,
            given_numbers: raw.given_numbers,
        };
        truss.checked()
    }
}

/// A truss without nodes and edges, whose payload is node 0.
impl Default for Truss {
    fn default() -> Self {
        Self {
            dimension: Dimension::Plane,
            nodes: Vec::new(),
            edges: Vec::new(),
            payload: Payload::at(0),
            rules: EdgeRules::default(),
            rest: Vec::new(),
            stiffness: Vec::new(),
            given_numbers: Vec::new(),
        }
    }
}

impl Truss {
    /// Reads a truss file.
    ///
    /// # Errors
    /// [`Error::Read`] for a missing file or a folder, [`Error::Usage`] for a file that is too long, [`Error::Malformed`]
    /// with the place for a file that is not UTF-8 and for a malformed truss.
    pub fn read(path: &Path) -> Result<Self> {
        let about = path.metadata().map_err(Error::reading(path))?;
        if !about.is_file() {
            let source = std::io::Error::other("not a file");
            return Err(Error::reading(path)(source));
        }
        let bytes = read_at_most(path, LARGEST)?;
        let file = path.display().to_string();
        let text = text_of(&file, &bytes)?;
        Self::parse(&file, text)
    }

    /// Reads a truss from the text of a file; messages name `file`.
    ///
    /// # Errors
    /// [`Error::Malformed`].
    pub fn parse(file: &str, text: &str) -> Result<Self> {
        let raw: RawTruss = from_json(file, 0, text.as_bytes()).map_err(|mut error| {
            if let Error::Malformed {
                message,
                allowed,
                report,
                ..
            } = &mut error
                && ["missing field `format`", "missing field `version`"].contains(&&**message)
            {
                *allowed = format!(
                    "write after the first `{{`: \"format\": {FORMAT:?}, \"version\": {VERSION},"
                );
                *report += &format!("\n  = {allowed}");
            }
            error
        })?;
        Self::try_from(raw).map_err(|says| placed(file, text, Error::Usage(says)))
    }

    /// The number that a node had in the original file or program.
    pub fn given_number(&self, node: usize) -> usize {
        self.given_numbers.get(node).copied().unwrap_or(node)
    }

    /// The height of the lowest node above the ground line, in metres.
    pub fn lowest(&self) -> f64 {
        let heights = self.nodes.iter().map(|x| x.up());
        heights.fold(f64::INFINITY, f64::min)
    }

    /// The truss as the text of a truss file.
    pub fn to_json(&self) -> String {
        let text = serde_json::to_string(&RawTruss::from(self.clone()));
        text.expect("numbers with string keys can be written as JSON") + "\n"
    }
}

/// The noun for a lattice in messages and in the registry.
const LATTICE: &str = "lattice";

impl Registry {
    /// Adds a lattice. Scenes choose it by `lattice.file = "its_name"`. The folder of a run holds a copy of the
    /// lattice, so that every program can read the run.
    ///
    /// # Panics
    /// If the name is taken, or if [`Truss::checked`] fails.
    #[must_use]
    pub fn with_lattice(self, name: &'static str, truss: Truss) -> Self {
        let truss = truss.checked();
        let truss = truss.unwrap_or_else(|says| panic!("the lattice {name:?}: {says}"));
        self.with(LATTICE, &[], name, Arc::new(truss))
    }

    /// The lattice that was added with this name; `None` if there is none.
    pub(crate) fn lattice(&self, name: &str) -> Option<Arc<Truss>> {
        self.get::<Arc<Truss>>(LATTICE, name).cloned()
    }
}

/// The median of lengths; of the two in the middle, the longer one. `None` if there are no lengths.
pub(super) fn median(lengths: &[f64]) -> Option<f64> {
    let mut sorted = lengths.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}
