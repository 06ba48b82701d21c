//! Lattices that are their own mirror image: front and back in the plane, left and right in space.

use super::own::{Mirror, Payload, Sides};
use super::truss::Lattice;
use crate::geometry::{Dimension, Range, Vector};

/// Two places (in spacings) that are nearer than this are the same: places are written with at least nine digits.
const SAME: f64 = 1e-6;

impl Sides {
    /// The sides of a robot in this dimension.
    pub const fn of(dimension: Dimension) -> Self {
        match dimension {
            Dimension::Plane => Self::FrontAndBack,
            Dimension::Space => Self::LeftAndRight,
        }
    }

    /// The number of the component whose sign changes in the image of a vector: along the ground, or across.
    pub(crate) const fn component(self) -> usize {
        match self {
            Self::FrontAndBack => 0,
            Self::LeftAndRight => 1,
        }
    }
}

impl Lattice {
    /// The mirror image of this lattice; `None` if that is another lattice, or has its payload elsewhere.
    pub fn image(&self) -> Option<Mirror> {
        let sides = Sides::of(self.dimension);
        let turned_at = sides.component();
        let list = |place: &Vector<f64>| self.dimension.list(*place);
        let width = Range::of(self.places.iter().map(|place| list(place)[turned_at]));
        let turned = |place: &Vector<f64>| {
            let mut place = list(place);
            place[turned_at] = width.low + width.high - place[turned_at];
            self.dimension.vector(&place)
        };
        let node_at = |place: Vector<f64>| {
            let mut nodes = self.places.iter();
            nodes.position(|&other| other.distance(place) < SAME)
        };
        let nodes = self.places.iter().map(|place| node_at(turned(place)));
        let nodes: Vec<usize> = nodes.collect::<Option<_>>()?;
        let edge_between = |ends: [usize; 2]| {
            let mut edges = self.edges.iter();
            edges.position(|&[i, j]| ends == [i, j] || ends == [j, i])
        };
        let edges = self
            .edges
            .iter()
            .map(|ends| edge_between(ends.map(|node| nodes[node])));
        let edges: Vec<usize> = edges.collect::<Option<_>>()?;
        let stays = self.payload.iter().all(|payload| {
            let node = nodes.get(payload.node).copied();
            node.is_some_and(|node| self.payload.contains(&Payload { node, ..*payload }))
        });
        let numbers = [&self.rest_length, &self.stiffness];
        let alike = numbers.into_iter().all(|numbers| {
            let mut pairs = numbers.iter().zip(&edges);
            pairs.all(|(own, &image): (&f64, &usize)| (own - numbers[image]).abs() <= SAME * own)
        });
        (stays && alike).then_some(Mirror {
            sides,
            nodes,
            edges,
        })
    }

    /// Ties edges that mirror one another, so that the robot stays its own mirror image. A lattice that is not its own image
    /// does not change.
    #[must_use]
    pub fn mirrored(mut self) -> Self {
        if let Some(mirror) = self.image() {
            let pairs = mirror.edges.iter().enumerate();
            let pairs = pairs.filter(|&(edge, &image)| edge < image);
            self.rules.tie = pairs.map(|(edge, &image)| vec![edge, image]).collect();
            self.mirror = Some(mirror);
        }
        self
    }
}
