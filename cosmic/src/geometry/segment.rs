//! Straight segments and their crossings.

use super::dimension::Dimension;
use super::points::Bounds;
use super::range::Range;
use super::vector::Vector;

/// The tolerance for a point on the line of a segment. The measure is the area of the parallelogram that the segment
/// spans with the vector to the point, divided by the sum of the squared lengths of both.
const ON_LINE: f64 = 1e-9;

/// A straight line between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<const D: usize = 3> {
    /// The first end.
    pub from: Vector<f64, D>,
    /// The second end.
    pub to: Vector<f64, D>,
}

impl<const D: usize> Segment<D> {
    /// The segment between two points.
    pub fn new(from: Vector<f64, D>, to: Vector<f64, D>) -> Self {
        Self { from, to }
    }

    /// The length.
    pub fn length(&self) -> f64 {
        self.from.distance(self.to)
    }

    /// The vector from the first end to the second.
    pub fn vector(&self) -> Vector<f64, D> {
        self.to - self.from
    }

    /// The unit vector from the first end to the second.
    pub fn direction(&self) -> Vector<f64, D> {
        self.vector() / self.length()
    }

    /// The midpoint.
    pub fn middle(&self) -> Vector<f64, D> {
        (self.from + self.to) * 0.5
    }

    /// The height of the line through both ends, at position `along` on the first axis.
    pub fn height(&self, along: f64) -> f64 {
        let Self { from, to } = self;
        let share = (along - from.forward()) / (to.forward() - from.forward());
        from.up() + (to.up() - from.up()) * share
    }

    /// The part of the segment inside a box; `None` if no part is inside, or if an end of the part is not finite.
    pub fn within(&self, bounds: &Bounds<D>) -> Option<Self> {
        let Self { from, to } = self;
        // Computes both ends of the part as shares of the segment, by the method of Liang and Barsky.
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        for k in 0..D {
            let way = to.0[k] - from.0[k];
            let (low, high) = (bounds.low.0[k] - from.0[k], bounds.high.0[k] - from.0[k]);
            if way == 0.0 && !(low..=high).contains(&0.0) {
                return None;
            }
            if way != 0.0 {
                let (one, other) = (low / way, high / way);
                first = first.max(one.min(other));
                last = last.min(one.max(other));
            }
        }
        // The point at a share is clamped, because on a very long segment the rounding of the share may move the point
        // out of the box.
        let at = |share: f64| {
            let end = from.towards(*to, share);
            Vector::from_fn(|k| end.0[k].clamp(bounds.low.0[k], bounds.high.0[k]))
        };
        let part = Self {
            from: if first > 0.0 { at(first) } else { *from },
            to: if last < 1.0 { at(last) } else { *to },
        };
        (first <= last && part.from.is_finite() && part.to.is_finite()).then_some(part)
    }

    /// The distance from a point to the nearest point of the segment.
    pub fn distance_to(&self, point: Vector<f64, D>) -> f64 {
        let direction = self.direction();
        let along = (point - self.from).dot(direction).clamp(0.0, self.length());
        (point - self.from).distance(direction * along)
    }
}

impl Segment {
    /// True if two segments cross at a point that is not an end of either.
    pub fn crosses(&self, other: &Self) -> bool {
        self.side(other.from) * self.side(other.to) < 0.0
            && other.side(self.from) * other.side(self.to) < 0.0
    }

    /// True if two segments in space are nearer to each other than a hundredth of the shorter one, at a place that is not an
    /// end of either.
    pub fn passes_by(&self, other: &Self) -> bool {
        let (d, e, apart) = (self.vector(), other.vector(), self.from - other.from);
        let (dd, ee, de) = (d.dot(d), e.dot(e), d.dot(e));
        let determinant = dd * ee - de * de;
        if determinant <= ON_LINE * dd * ee {
            return false;
        }
        let along = (de * e.dot(apart) - ee * d.dot(apart)) / determinant;
        let beside = (dd * e.dot(apart) - de * d.dot(apart)) / determinant;
        let between = |share: f64| (CLEARANCE..=1.0 - CLEARANCE).contains(&share);
        let gap = apart + d * along - e * beside;
        between(along) && between(beside) && gap.dot(gap) < CLEARANCE * CLEARANCE * dd.min(ee)
    }

    /// On which side of this segment's line a point is: 1 on the left, -1 on the right, 0 on the line.
    fn side(&self, point: Vector<f64>) -> f64 {
        let (d, e) = (self.vector(), point - self.from);
        let area = d.cross(e);
        let size = d.dot(d) + e.dot(e);
        if area.abs() < ON_LINE * size {
            0.0
        } else {
            area.signum()
        }
    }
}

/// Two bars of a robot in space cross if they are nearer to each other than this share of the shorter one, between their
/// ends.
const CLEARANCE: f64 = 0.01;

/// Finds the pairs of edges that [cross](Segment::crosses), or in space [nearly touch](Segment::passes_by). `nodes` has the position of every node, `edges` the two
/// nodes of every edge. A pair consists of the indices of two edges, the smaller index first. The pairs are in
/// ascending order.
///
/// The search sweeps along one axis and compares only edges that overlap along this axis. If edges are short, few pairs
/// are compared. An edge with a coordinate that is NaN crosses no other edge.
///
/// # Panics
/// If an edge has a node that does not exist.
pub fn crossings(
    dimension: Dimension,
    nodes: &[Vector<f64>],
    edges: &[[usize; 2]],
) -> Vec<[usize; 2]> {
    let cross = match dimension {
        Dimension::Plane => Segment::crosses,
        Dimension::Space => Segment::passes_by,
    };
    let segment = |&[i, j]: &[usize; 2]| Segment::new(nodes[i], nodes[j]);
    let segments: Vec<Segment> = edges.iter().map(segment).collect();
    // The range of every edge's coordinates along both axes.
    let span = |segment: &Segment| {
        // In space, two bars may cross without touching.
        let apart = match dimension {
            Dimension::Plane => 0.0,
            Dimension::Space => CLEARANCE * segment.length(),
        };
        [0, 2]
            .map(|axis| Range::of([segment.from, segment.to].map(|end| end.0[axis])).widened(apart))
    };
    let spans: Vec<[Range; 2]> = segments.iter().map(span).collect();
    let axis = usize::from(crowding(&spans, 1) < crowding(&spans, 0));
    let mut order: Vec<usize> = (0..edges.len()).collect();
    order.sort_by(|&i, &j| spans[i][axis].low.total_cmp(&spans[j][axis].low));
    let mut pairs = Vec::new();
    for (k, &i) in order.iter().enumerate() {
        let later = order[k + 1..].iter();
        for &j in later.take_while(|j| spans[**j][axis].low <= spans[i][axis].high) {
            let [one, other] = [i, j].map(|edge| spans[edge][1 - axis]);
            let overlap = other.low <= one.high && one.low <= other.high;
            if overlap && cross(&segments[i], &segments[j]) {
                pairs.push([i.min(j), i.max(j)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// The mean number of edges that overlap at one position along an axis. The sweep uses the axis for which this number
/// is smaller.
fn crowding(spans: &[[Range; 2]], axis: usize) -> f64 {
    let along = || spans.iter().map(|span| span[axis]);
    let all = Range::of(along().flat_map(|span| [span.low, span.high]));
    along().map(|span| span.size()).sum::<f64>() / all.size()
}
