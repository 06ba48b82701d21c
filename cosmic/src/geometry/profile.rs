//! The profile of the ground: the height of the terrain above the ground line.

use serde::{Deserialize, Serialize};

use super::ground::Ground;
use super::range::Range;
use super::segment::Segment;
use super::vector::Vector;

/// The largest number of points of a profile. The time of a simulation step grows with the number of points times the
/// number of nodes.
pub const MOST_POINTS: usize = 64;

/// The height of the terrain above the ground line, as a function of the position along the line, both in metres in the
/// ground's frame. The terrain is straight between the points of the profile, and level before the first and after the
/// last point. Without points, the terrain is the ground line itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Vector<f64>>", into = "Vec<Vector<f64>>")]
pub struct Profile {
    points: Vec<Vector<f64>>,
}

impl Profile {
    /// The profile through points `[along, height]`.
    ///
    /// # Errors
    /// If there are more than [`MOST_POINTS`] points, if a point is not finite, or if a point is not ahead of the point
    /// before it. The text of the error continues a sentence that begins with the name of the profile, such as "has a
    /// point that is not finite".
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
        match Self::not_ahead(&points) {
            None => Ok(Self { points }),
            Some(at) => Err(format!(
                "has the point {:?} that is not ahead of {:?}",
                points[at],
                points[at - 1]
            )),
        }
    }

    /// The index of the first point that is not ahead of the point before it.
    pub(crate) fn not_ahead(points: &[Vector<f64>]) -> Option<usize> {
        // Comparisons with NaN are false, so a NaN is not ahead.
        let is_ahead = |at: &usize| points[at - 1].forward() < points[*at].forward();
        (1..points.len()).find(|at| !is_ahead(at))
    }

    /// The points, ascending along the ground.
    pub fn points(&self) -> &[Vector<f64>] {
        &self.points
    }

    /// True if the profile has no points, so that the terrain is the ground line itself.
    pub fn is_flat(&self) -> bool {
        self.points.is_empty()
    }

    /// The height of the terrain at a position along the ground line, in metres.
    pub fn height(&self, along: f64) -> f64 {
        let (Some(first), Some(last)) = (self.points.first(), self.points.last()) else {
            return 0.0;
        };
        match self
            .points
            .partition_point(|point| point.forward() <= along)
        {
            0 => first.up(),
            ahead if ahead == self.points.len() => last.up(),
            ahead => Segment::new(self.points[ahead - 1], self.points[ahead]).height(along),
        }
    }

    /// The height of a point above the terrain in metres, measured along the normal of the ground line. It is negative
    /// below the terrain. The point is in the ground's frame.
    pub fn above(&self, point: Vector<f64>) -> f64 {
        point.up() - self.height(point.forward())
    }

    /// The points of the terrain over a range of positions along the ground line: both ends and the corners between
    /// them.
    pub fn between(&self, along: Range) -> Vec<Vector<f64>> {
        let Range { low, high } = along;
        let end = |along: f64| Vector::new([along, self.height(along)]);
        let corners = self.points.iter().copied();
        let corners = corners.filter(|corner| low < corner.forward() && corner.forward() < high);
        let mut line = vec![end(low)];
        line.extend(corners);
        line.push(end(high));
        line
    }

    /// The height of the terrain in metres, in the world's frame. It is measured above the point of the ground line
    /// that has the x coordinate `x` in the world's frame.
    pub fn height_in_world(&self, ground: &Ground, x: f64) -> f64 {
        let [cos, sin] = ground.tangent().array();
        ground.height + x * sin / cos + self.height(x / cos) * cos
    }

    /// The points of the terrain in the world's frame, over the part of the ground line whose x coordinates are in the
    /// range `across`.
    pub fn in_world(&self, ground: &Ground, across: Range) -> Vec<Vector<f64>> {
        if self.is_flat() {
            let end = |x: f64| Vector::new([x, self.height_in_world(ground, x)]);
            return vec![end(across.low), end(across.high)];
        }
        let cos = ground.tangent().forward();
        let line = self.between(across.map(|x| x / cos)).into_iter();
        line.map(|point| ground.point_to_world(point)).collect()
    }

    /// The largest depth of a bar below the terrain, in metres; 0 if the bar is nowhere below the terrain. The depth is
    /// measured along the normal of the ground line.
    pub fn depth(&self, bar: Segment) -> f64 {
        let [from, to] = if bar.from.forward() <= bar.to.forward() {
            [bar.from, bar.to]
        } else {
            [bar.to, bar.from]
        };
        let bar = Segment::new(from, to);
        // Between two corners the distance from bar to terrain is linear, so it is largest at a corner or at an end.
        let ends = [from, to].map(|end| -self.above(end));
        let corners = self.points.iter();
        let corners = corners
            .filter(|corner| from.forward() < corner.forward() && corner.forward() < to.forward());
        let depths = corners.map(|corner| corner.up() - bar.height(corner.forward()));
        depths.chain(ends).fold(0.0, f64::max)
    }
}

impl TryFrom<Vec<Vector<f64>>> for Profile {
    type Error = String;
    fn try_from(points: Vec<Vector<f64>>) -> Result<Self, String> {
        Self::new(points)
    }
}

impl From<Profile> for Vec<Vector<f64>> {
    fn from(profile: Profile) -> Self {
        profile.points
    }
}
