//! What is probably a mistake in a truss, although it can be simulated: parts that no bar holds, and in space no stiffness in
//! some direction and heights that are not the last number of a node.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::own::Truss;
use super::rigidity::floppy_modes;
use crate::geometry::{Bounds, Dimension, Range, Vector};
use crate::numbers::counted;

/// Bars that are inclined by less than this (rad, root of the mean square) to the plane across a direction give almost no
/// stiffness in that direction: a four-hundredth of the stiffness of bars along it.
const WEAK: f64 = 0.05;
/// Two places that are nearer than this share of the size of the truss are the same. Drawings are rounded.
const SAME: f64 = 1e-3;
/// Nodes up to this share of the height above the lowest node are feet.
const FOOT: f64 = 0.02;
/// The largest number of bars for which floppy modes are counted, which takes half a second.
const MOST_RANKED: usize = 300;

/// Something about a truss that is probably a mistake.
pub(crate) struct Doubt {
    /// The problem, in a sentence.
    pub(crate) says: String,
    /// The change that would solve the problem.
    pub(crate) remedy: String,
}

/// A direction in which bars give the least stiffness.
struct Weakest {
    /// The stiffness as a share of the stiffness that all bars would give if they had this direction.
    share: f64,
    direction: Vector<f64>,
}

impl Weakest {
    /// The weakest direction of bars with these unit directions.
    fn of(bars: &[Vector<f64>]) -> Self {
        let square = |bar: &Vector<f64>| {
            let bar = Vector3::from(bar.array());
            bar * bar.transpose()
        };
        let sum: Matrix3<f64> = bars.iter().map(square).sum();
        let eigen = SymmetricEigen::new(sum / bars.len().max(1) as f64);
        let (weakest, share) = eigen.eigenvalues.argmin();
        let direction: [f64; 3] = eigen.eigenvectors.column(weakest).into_owned().into();
        // Of the two opposite directions, the one whose largest component is positive.
        let largest = direction.iter().fold(
            0.0,
            |most: f64, x| {
                if x.abs() > most.abs() { *x } else { most }
            },
        );
        Self {
            share,
            direction: Vector::new(direction) * largest.signum(),
        }
    }

    fn is_weak(&self) -> bool {
        self.share < WEAK * WEAK
    }

    /// The direction as text, such as `[0, 0.71, 0.71]`.
    fn shown(&self) -> String {
        // Adding 0 turns -0 into 0.
        let rounded = self
            .direction
            .array()
            .map(|x| (100.0 * x).round() / 100.0 + 0.0);
        let [along, across, above] = rounded;
        format!("[{along}, {across}, {above}]")
    }
}

impl Truss {
    /// What is probably a mistake in this truss.
    pub(crate) fn doubts(&self) -> Vec<Doubt> {
        if self.dimension == Dimension::Plane {
            return self.is_hinged().into_iter().collect();
        }
        match self.is_flat() {
            Some(flat) => vec![flat],
            None => self.is_loose().into_iter().chain(self.lies()).collect(),
        }
    }

    /// The edges that may be bars.
    fn possible_bars(&self) -> impl Iterator<Item = [usize; 2]> {
        let edges = self.edges.iter().enumerate();
        let possible = edges.filter(|(edge, _)| !self.rules.forbid.contains(edge));
        possible.map(|(_, ends)| *ends)
    }

    fn direction(&self, [i, j]: [usize; 2]) -> Vector<f64> {
        (self.nodes[j] - self.nodes[i]).unit()
    }

    /// The doubt about a truss whose bars are all across one direction.
    fn is_flat(&self) -> Option<Doubt> {
        let bars: Vec<_> = self
            .possible_bars()
            .map(|ends| self.direction(ends))
            .collect();
        let weakest = Weakest::of(&bars);
        let lies = weakest.direction.up().abs() > 0.9;
        weakest.is_weak().then(|| Doubt {
            says: format!(
                "the truss is flat: all of its bars lie across the direction {}, in which it has no stiffness, so its \
                 robot folds or falls over at the smallest push",
                weakest.shown()
            ),
            remedy: if lies {
                "a node is [along, across, above]: if the second number is the height in the file, write [along, height], \
                 which makes a robot in the plane; or give the truss height"
            } else {
                "give it depth: add nodes off its plane, and join them to it by bars and diagonals; or write two numbers \
                 for every node, [along, above], which makes a robot in the plane"
            }
            .to_owned(),
        })
    }

    /// The doubt about a truss in space with a node that no bar holds in some direction, or with [hinges](Self::is_hinged).
    /// Springs that pull at rest may hold such a truss, so it has no stated rest lengths.
    fn is_loose(&self) -> Option<Doubt> {
        if !self.rest.is_empty() {
            return None;
        }
        let mut at = vec![Vec::new(); self.nodes.len()];
        for ends in self.possible_bars() {
            for node in ends {
                at[node].push(self.direction(ends));
            }
        }
        let of_nodes = at.iter().map(|bars| Weakest::of(bars)).enumerate();
        let weak: Vec<_> = of_nodes.filter(|(_, of)| of.is_weak()).collect();
        if let Some((node, of)) = weak.first() {
            let others = match weak.len() - 1 {
                0 => String::new(),
                1 => ", nor has another node in some direction".to_owned(),
                more => format!(", nor have {more} other nodes in some direction"),
            };
            return Some(Doubt {
                says: format!(
                    "node {} has no stiffness in the direction {}, because all of its edges lie across it{others}",
                    self.given_number(*node),
                    of.shown()
                ),
                remedy: "add an edge to a node off their plane".to_owned(),
            });
        }
        self.is_hinged()
    }

    /// The doubt about a truss with parts that move against each other without stretching a bar.
    fn is_hinged(&self) -> Option<Doubt> {
        let bars: Vec<_> = self.possible_bars().collect();
        if bars.len() > MOST_RANKED || !self.rest.is_empty() {
            return None;
        }
        let live: Vec<usize> = (0..self.nodes.len()).collect();
        let modes = floppy_modes(self.dimension, &self.nodes, &bars, &live);
        (modes > 0).then(|| Doubt {
            says: format!(
                "parts of the truss move against each other and stretch no bar, even if every edge has a bar: {}",
                counted(modes, "such motion")
            ),
            remedy: format!(
                "add at least {}, such as a diagonal, across the hinges",
                counted(modes, "edge")
            ),
        })
    }

    /// The doubt about a truss that lies on its side, because the second number of its nodes is the height.
    fn lies(&self) -> Option<Doubt> {
        const ACROSS: usize = 1;
        const ABOVE: usize = 2;
        let [across, above] = [ACROSS, ABOVE].map(|axis| self.range(axis));
        let payload = self.nodes[self.payload[0].node].array();
        let near = |a: f64, b: f64| (a - b).abs() < SAME * self.size();
        let middle = |range: Range| 0.5 * (range.low + range.high);
        // Robots are usually alike on the left and on the right, but not above and below.
        let is_likely = match [ACROSS, ABOVE].map(|axis| self.is_own_image(axis)) {
            [true, false] => false,
            [false, true] => true,
            [true, true] => {
                let is_centred = near(middle(above), 0.0) && above.low < 0.0;
                let stands = is_centred && near(across.low, 0.0);
                let carries =
                    near(payload[ABOVE], middle(above)) && near(payload[ACROSS], across.high);
                stands || carries
            }
            [false, false] => self.stands(ACROSS) && !self.stands(ABOVE),
        };
        is_likely.then(|| Doubt {
            says: "the truss seems to lie on its side: the second number of its nodes looks like the height".to_owned(),
            remedy: "a node is [along, across, above]: if the second number is the height, exchange the second and the \
                     third number"
                .to_owned(),
        })
    }

    fn size(&self) -> f64 {
        Bounds::of(self.nodes.iter().copied()).size().largest()
    }

    fn range(&self, axis: usize) -> Range {
        Range::of(self.nodes.iter().map(|node| node.array()[axis]))
    }

    /// True if the mirror image of the nodes along an axis has nodes at the same places.
    fn is_own_image(&self, axis: usize) -> bool {
        let (range, near) = (self.range(axis), SAME * self.size());
        let image = |node: &Vector<f64>| {
            let mut image = node.array();
            image[axis] = range.low + range.high - image[axis];
            Vector::new(image)
        };
        let has = |place: Vector<f64>| self.nodes.iter().any(|node| node.distance(place) < near);
        self.nodes.iter().map(image).all(has)
    }

    /// True if the truss would stand on its lowest nodes if `axis` pointed up: if the middle of its nodes is between them.
    fn stands(&self, axis: usize) -> bool {
        let (range, others) = (self.range(axis), [(axis + 1) % 3, (axis + 2) % 3]);
        let level = range.low + FOOT * range.size();
        let count = self.nodes.len() as f64;
        let middle = others.map(|other| {
            let all = self.nodes.iter().map(|node| node.array()[other]);
            all.sum::<f64>() / count
        });
        let feet = self.nodes.iter().map(|node| node.array());
        let feet = feet.filter(|foot| foot[axis] <= level);
        let angle = |foot: [f64; 3]| {
            let [a, b] = [0, 1].map(|k| foot[others[k]] - middle[k]);
            b.atan2(a)
        };
        let mut angles: Vec<f64> = feet.map(angle).collect();
        angles.sort_by(f64::total_cmp);
        let Some(first) = angles.first().copied() else {
            return false;
        };
        angles.push(first + TAU);
        // No gap of half a turn or more between the directions of neighbouring feet.
        angles.windows(2).all(|pair| pair[1] - pair[0] < 0.5 * TAU)
    }
}
