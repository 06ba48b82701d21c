//! The lattice: nodes, and the edges between them.

use autodiff::Real;
use autodiff_programs::Graph;

use super::State;
use super::own::{EdgeRules, Mirror, Payload, Truss, median};
use crate::Fields;
use crate::geometry::{Bounds, Dimension, Ground, Range, Segment, Vector};

/// The nodes and edges of a robot. One or several nodes carry payload.
///
/// A lattice is constant: no derivative flows through the rest lengths or the masses computed from them, even if the
/// initial positions are variables.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Whether the lattice is in the plane or in space.
    pub dimension: Dimension,
    /// Initial positions in the world's frame, one per node, in metres.
    pub positions: Vec<Vector<f64>>,
    /// The two nodes `[i, j]` that each edge joins.
    pub edges: Vec<[usize; 2]>,
    /// The rest length of each edge, in metres.
    pub rest_length: Vec<f64>,
    /// The initial positions of the nodes along and above the ground, measured from the lower left corner of the
    /// lattice in units of `spacing`. On a rectangular lattice they are whole numbers: column and row.
    pub places: Vec<Vector<f64>>,
    /// The distance between neighbouring nodes, in metres. For a truss, it is the median length of the edges.
    pub spacing: f64,
    /// The length that counts as 1 m in the small lengths and the bounds that the method contains, in metres: ten
    /// spacings, which are 1 m in the paper's scenes.
    pub scale: f64,
    /// The nodes with extra mass, at least one. In reports and losses, the payload is the first one.
    pub payload: Vec<Payload>,
    /// Restrictions on the materials of the edges.
    pub rules: EdgeRules,
    /// The stiffness of the bar of each edge, in N/m, whether it is skeleton or actuator. Empty if the stiffnesses are
    /// those of the materials.
    pub stiffness: Vec<f64>,
    /// The mirror image of the lattice, for a robot that stays its own mirror image (`lattice.mirror`).
    pub mirror: Option<Mirror>,
}

impl Lattice {
    /// The number of spacings in a [scale](Lattice::scale).
    pub(crate) const SPACINGS: f64 = 10.0;

    /// A robot that moves by less than this share of its length in a rollout stays in place. A foot that slips to and fro
    /// moves a robot that far.
    pub const STAYS: f64 = 0.05;

    /// Makes a lattice over level ground from nodes at these positions (m). The rest length of each edge is the
    /// distance of its two nodes.
    ///
    /// # Panics
    /// If an edge has a node that does not exist.
    pub fn between(positions: Vec<Vector<f64>>, edges: Vec<[usize; 2]>) -> Self {
        let truss = Truss {
            nodes: positions.clone(),
            edges,
            ..Truss::default()
        };
        Self::of_truss(&truss, positions)
    }

    /// Converts a truss to a lattice. `positions` are the positions of its nodes in the world's frame.
    pub fn of_truss(truss: &Truss, positions: Vec<Vector<f64>>) -> Self {
        let distance = |&[i, j]: &[usize; 2]| positions[i].distance(positions[j]);
        let distances: Vec<f64> = truss.edges.iter().map(distance).collect();
        let spacing = median(&distances)
            .filter(|length| *length > 0.0)
            .unwrap_or(1.0);
        let corner = Bounds::of(truss.nodes.iter().copied()).low;
        Self {
            dimension: truss.dimension,
            places: truss
                .nodes
                .iter()
                .map(|&x| (x - corner) / spacing)
                .collect(),
            positions,
            edges: truss.edges.clone(),
            rest_length: if truss.rest.is_empty() {
                distances
            } else {
                truss.rest.clone()
            },
            spacing,
            scale: Self::SPACINGS * spacing,
            payload: truss.payload.clone(),
            rules: truss.rules.clone(),
            stiffness: truss.stiffness.clone(),
            mirror: None,
        }
    }

    /// Converts this lattice to a truss. The node positions of the truss are the `places` of this lattice, so its edges
    /// have the lengths of their places.
    pub fn truss(&self) -> Truss {
        Truss {
            dimension: self.dimension,
            nodes: self.places.clone(),
            edges: self.edges.clone(),
            payload: self.payload.clone(),
            rules: self.rules.clone(),
            stiffness: self.stiffness.clone(),
            ..Truss::default()
        }
    }
}

impl Lattice {
    /// The number of nodes.
    pub fn nodes(&self) -> usize {
        self.positions.len()
    }

    /// The initial state: all nodes are at rest in their initial positions.
    pub fn state_at_rest(&self) -> State<f64> {
        State {
            dimension: self.dimension,
            x: self.positions.clone(),
            v: vec![Vector::zero(); self.nodes()],
        }
    }

    /// The point of the payload in a state, along the ground and normal to it, from the world's origin (m). Goals that a
    /// user states count from this point at the start.
    pub fn payload_point(&self, state: &State<f64>, ground: &Ground) -> Vector<f64> {
        ground.vector_to_ground(state.x[self.payload[0].node])
    }

    /// The size of the lattice along the ground and above it, in units of `spacing`.
    pub fn extent(&self) -> Vector<f64> {
        Bounds::of(self.places.iter().copied())
            .high
            .map(|most| most.max(0.0))
    }

    /// The width of the lattice with half a spacing added on either side, in metres.
    pub fn width(&self) -> f64 {
        (self.extent().forward() + 1.0) * self.spacing
    }

    /// The width or the height of the lattice, whichever is larger, with half a spacing added on either side, in
    /// metres.
    pub fn side(&self) -> f64 {
        (self.extent().largest() + 1.0) * self.spacing
    }

    /// The extent of the nodes along the ground at rest, m.
    pub fn length(&self) -> f64 {
        let along = self.places.iter().map(|place| place.forward());
        Range::of(along).size() * self.spacing
    }

    /// The least number of bars of a stiff frame of all nodes: the number of their coordinates, less the rigid motions (Maxwell).
    pub(crate) fn stiff_bars(&self) -> usize {
        let axes = self.dimension.count();
        (axes * self.nodes()).saturating_sub(axes * (axes + 1) / 2)
    }

    /// The length of the robot by which its walks are judged, m: the [length](Self::length) of the lattice, but at least a
    /// spacing, for a robot that only has height.
    pub fn body_length(&self) -> f64 {
        self.length().max(self.spacing)
    }

    /// The distance below which a robot stays in place, m: a twentieth of its [length](Self::body_length).
    pub fn least_walk(&self) -> f64 {
        Self::STAYS * self.body_length()
    }

    /// The line segment between the places of two nodes, in units of `spacing`.
    pub fn segment(&self, [i, j]: [usize; 2]) -> Segment {
        Segment::new(self.places[i], self.places[j])
    }

    /// The midpoint of each edge, in units of `spacing`.
    pub fn midpoints(&self) -> impl Iterator<Item = Vector<f64>> {
        self.edges.iter().map(|&ends| self.segment(ends).middle())
    }

    /// The vector from node `i` to node `j` of the edge `ends = [i, j]`, in units of `spacing`.
    pub fn direction(&self, ends: [usize; 2]) -> Vector<f64> {
        self.segment(ends).vector()
    }
}

impl Lattice {
    /// The edges as a graph. Springs are symmetric; a [`Graph`] has the smaller node of each edge first.
    pub(crate) fn graph(&self) -> Graph {
        let ascending = |&[i, j]: &[usize; 2]| [i.min(j), i.max(j)];
        let edges: Vec<[usize; 2]> = self.edges.iter().map(ascending).collect();
        Graph::new(self.nodes(), &edges)
    }

    /// A number that is added to the square of an edge's length, in m^2. It keeps the length smooth where the two nodes
    /// of the edge coincide (D4). It is the square of a millionth of the [scale](Lattice::scale).
    pub fn softening(&self) -> f64 {
        let length = 1e-6 * self.scale;
        length * length
    }

    /// The time that counts as 1 s in the bounds that the method contains, in seconds. A body that is accelerated at
    /// 1 m/s^2 for this time covers half a [scale](Lattice::scale).
    pub fn time_scale(&self) -> f64 {
        self.scale.sqrt()
    }
}

/// The position and the velocity of an edge's second node relative to its first node.
#[derive(Clone, Copy, Debug, Fields)]
pub struct EdgeVector<R, const D: usize = 3> {
    /// The vector from the edge's first node to its second node, in metres.
    pub d: Vector<R, D>,
    /// The velocity of the second node minus the velocity of the first node, in m/s.
    pub dv: Vector<R, D>,
}

impl<R: Real> EdgeVector<R> {
    /// The edge vector of the edge from node `i` to node `j` in a state.
    pub fn of(state: &State<R>, [i, j]: [usize; 2]) -> Self {
        Self {
            d: state.x[j] - state.x[i],
            dv: state.v[j] - state.v[i],
        }
    }
}

impl<R: Real, const D: usize> EdgeVector<R, D> {
    /// The length that the force laws use, in metres. With a `softening` (m^2) above 0, which is that of the
    /// [lattice](Lattice::softening), it is never zero (D4).
    #[inline(always)]
    pub fn length(&self, softening: f64) -> R {
        self.d.softened_norm(softening)
    }

    /// The rate at which the edge grows, in m/s. `length` is its length.
    #[inline(always)]
    pub fn rate(&self, length: R) -> R {
        self.d.dot(self.dv) / length
    }
}
