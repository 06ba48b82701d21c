//! The profile of the ground: the height of the terrain above the ground line.

use serde::{Deserialize, Serialize};

use super::ground::Ground;
use super::range::Range;
use super::segment::Segment;
use super::vector::Vector;

/// The largest number of points of a profile. The time of a simulation step grows with the number of points times the
/// number of nodes.
pub const MOST_POINTS: usize = 64;

/// The height of the terrain above the ground line at each position along the line, both in metres in the ground's frame.
/// The terrain is straight between the points of the profile, and level before the first and after the last point. Two
/// points at one position are the foot and the edge of a vertical wall. Without points, the terrain is the ground line
/// itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct Profile {
    points: Vec<Vector<f64>>,
}

impl Profile {
    /// The profile through points `[along, height]`.
    ///
    /// # Errors
    /// If there are more than [`MOST_POINTS`] points, if a point is not finite, or if a point is behind the point before
    /// it (an overhang), equals it, or turns back on a wall. The text of the error continues a sentence that begins with
    /// the name of the profile, such as "has a point that is not finite".
    pub fn new(points: Vec<Vector<f64>>) -> Result<Self, String> {
        if points.len() > MOST_POINTS {
            return Err(format!(
                "has {} points, more than {MOST_POINTS}",
                points.len()
            ));
        }
        if points.iter().any(|point| !point.is_finite()) {
            return Err("has a point that is not finite".to_owned());
        }
        match Self::misplaced(&points) {
            None => Ok(Self { points }),
            Some((at, says)) => Err(format!("{says}: {}", points[at].shown())),
        }
    }

    /// The index of the first point that cannot follow the points before it, and a reason that continues a sentence like
    /// that of [`new`](Self::new).
    pub(crate) fn misplaced(points: &[Vector<f64>]) -> Option<(usize, &'static str)> {
        let fault = |at: usize| {
            let (before, point) = (points[at - 1], points[at]);
            // Comparisons with NaN are false, so a NaN is misplaced.
            if before.forward() < point.forward() {
                return None;
            }
            let turns = |earlier: &Vector<f64>| {
                let [first, second] = [before.up() - earlier.up(), point.up() - before.up()];
                earlier.forward() == point.forward() && first * second < 0.0
            };
            if before.forward() != point.forward() {
                Some("has a point behind the point before it, but must not overhang")
            } else if before.up() == point.up() {
                Some("has the same point twice")
            } else if points[..at - 1].last().is_some_and(turns) {
                Some("turns back on a vertical wall")
            } else {
                None
            }
        };
        (1..points.len()).find_map(|at| Some((at, fault(at)?)))
    }

    /// The points, ascending along the ground.
    pub fn points(&self) -> &[Vector<f64>] {
        &self.points
    }

    /// The points as pairs `[along, height]`.
    pub fn pairs(&self) -> Vec<[f64; 2]> {
        self.points.iter().map(|point| point.in_plane()).collect()
    }

    /// True if the profile has no points, so that the terrain is the ground line itself.
    pub fn is_flat(&self) -> bool {
        self.points.is_empty()
    }

    /// The height of the terrain at a position along the ground line, in metres; at a wall, the height of its foot.
    pub fn height(&self, along: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return 0.0;
        };
        let is_behind = |point: &Vector<f64>| point.forward() < along;
        let at = self.points.partition_point(is_behind);
        let here = self.points[at..].iter();
        let here = here.take_while(|point| point.forward() == along);
        match here.map(|point| point.up()).reduce(f64::min) {
            Some(height) => height,
            None if at == 0 => first.up(),
            None if at == self.points.len() => last.up(),
            None => Segment::new(self.points[at - 1], self.points[at]).height(along),
        }
    }

    /// The height of a point above the terrain in metres, measured along the normal of the ground line. It is negative
    /// below the terrain. Behind a wall, it is minus the distance from the wall if that is smaller. The point is in the
    /// ground's frame.
    pub fn above(&self, point: Vector<f64>) -> f64 {
        let above = point.up() - self.height(point.forward());
        let behind = self.walls().filter_map(|wall| wall.behind(point));
        behind.fold(above, |above, behind| above.max(-behind))
    }

    /// The vertical walls in ascending order along the ground.
    pub(crate) fn walls(&self) -> impl Iterator<Item = Wall> {
        let places = self.points.chunk_by(|a, b| a.forward() == b.forward());
        places.filter_map(|points| match points {
            [first, .., last] => {
                let (place, rises) = (first.forward(), first.up() < last.up());
                let mut others = self.points.iter().map(|point| point.forward() - place);
                let depth = match rises {
                    true => others.find(|ahead| *ahead > 0.0),
                    false => others.rfind(|ahead| *ahead < 0.0),
                };
                Some(Wall {
                    place,
                    heights: Range::of([first.up(), last.up()]),
                    rises,
                    depth: depth.map_or(f64::INFINITY, f64::abs),
                })
            }
            _ => None,
        })
    }

    /// The points of the terrain over a range of positions along the ground line: both ends and the corners between
    /// them.
    pub fn between(&self, along: Range) -> Vec<Vector<f64>> {
        let Range { low, high } = along;
        let end = |along: f64| Vector::upright(along, self.height(along));
        let corners = self.points.iter().copied();
        // A wall at an end of the range belongs to the terrain over the range.
        let corners = corners.filter(|corner| low <= corner.forward() && corner.forward() <= high);
        let corners: Vec<_> = corners.collect();
        let starts = corners.first().is_none_or(|corner| corner.forward() != low);
        let ends = corners.last().is_none_or(|corner| corner.forward() != high);
        let mut line = Vec::new();
        line.extend(starts.then(|| end(low)));
        line.extend(corners);
        line.extend(ends.then(|| end(high)));
        line
    }

    /// The height of the terrain in metres, in the world's frame. It is measured above the point of the ground line
    /// that has the x coordinate `x` in the world's frame.
    pub fn height_in_world(&self, ground: &Ground, x: f64) -> f64 {
        let [cos, sin] = ground.tangent().in_plane();
        x * sin / cos + self.height(x / cos) * cos
    }

    /// The points of the terrain in the world's frame, over the part of the ground line whose x coordinates are in the
    /// range `across`.
    pub fn in_world(&self, ground: &Ground, across: Range) -> Vec<Vector<f64>> {
        if self.is_flat() {
            let end = |x: f64| Vector::upright(x, self.height_in_world(ground, x));
            return vec![end(across.low), end(across.high)];
        }
        let cos = ground.tangent().forward();
        let line = self.between(across.map(|x| x / cos)).into_iter();
        line.map(|point| ground.vector_to_world(point)).collect()
    }
}

/// A vertical wall of the terrain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wall {
    /// The position along the ground, m.
    pub(crate) place: f64,
    /// The heights of its foot and of its edge, m.
    pub(crate) heights: Range,
    /// True if the edge is ahead of the foot, so that the ground is on the side of `+x`.
    pub(crate) rises: bool,
    /// The distance from the wall to the next corner of the ground behind it, m.
    depth: f64,
}

impl Wall {
    /// A node that is below the edge and behind the wall by less than this distance, in m, got there by rounding: it
    /// touches the wall. The distance is eight units in the last place of the position in single precision, but less than
    /// the thickness of a pillar, whose other side is a wall too.
    pub(crate) fn tolerance(&self) -> f64 {
        (1e-6 * self.place.abs().max(1e-3)).min(0.5 * self.depth)
    }

    /// The distance of a point behind the wall, in m; `None` if the point is in front of the wall, above it or below it.
    fn behind(&self, point: Vector<f64>) -> Option<f64> {
        let ahead = point.forward() - self.place;
        let behind = if self.rises { ahead } else { -ahead };
        (behind >= 0.0 && self.heights.contains(point.up())).then_some(behind)
    }
}

impl TryFrom<Vec<[f64; 2]>> for Profile {
    type Error = String;
    fn try_from(points: Vec<[f64; 2]>) -> Result<Self, String> {
        Self::new(points.into_iter().map(Vector::from).collect())
    }
}

impl From<Profile> for Vec<[f64; 2]> {
    fn from(profile: Profile) -> Self {
        profile.pairs()
    }
}
