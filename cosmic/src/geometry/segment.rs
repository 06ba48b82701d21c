//! Straight segments and their crossings.

use super::points::Bounds;
use super::range::Range;
use super::vector::Vector;

/// The tolerance for a point on the line of a segment. The measure is the area of the parallelogram that the segment
/// spans with the vector to the point, divided by the sum of the squared lengths of both.
const ON_LINE: f64 = 1e-9;

/// A straight line between two points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<const D: usize = 2> {
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

impl Segment<2> {
    /// The smallest distance between the points of two segments; 0 where they cross.
    pub fn distance(&self, other: &Self) -> f64 {
        if self.crosses(other) {
            return 0.0;
        }
        let to_self = [other.from, other.to].map(|end| self.distance_to(end));
        let to_other = [self.from, self.to].map(|end| other.distance_to(end));
        to_self.into_iter().chain(to_other).fold(f64::MAX, f64::min)
    }

    /// True if two segments cross at a point that is not an end of either.
    pub fn crosses(&self, other: &Self) -> bool {
        self.side(other.from) * self.side(other.to) < 0.0
            && other.side(self.from) * other.side(self.to) < 0.0
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

/// Finds the pairs of edges that [cross](Segment::crosses). `nodes` has the position of every node, `edges` the two
/// nodes of every edge. A pair consists of the indices of two edges, the smaller index first. The pairs are in
/// ascending order.
///
/// The search sweeps along one axis and compares only edges that overlap along this axis. If edges are short, few pairs
/// are compared. An edge with a coordinate that is NaN crosses no other edge.
///
/// # Panics
/// If an edge has a node that does not exist.
pub fn crossings(nodes: &[Vector<f64>], edges: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let segment = |&[i, j]: &[usize; 2]| Segment::new(nodes[i], nodes[j]);
    let segments: Vec<Segment> = edges.iter().map(segment).collect();
    // The range of every edge's coordinates along both axes.
    let span = |segment: &Segment| {
        [0, 1].map(|axis| Range::of([segment.from, segment.to].map(|end| end.0[axis])))
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
            if overlap && segments[i].crosses(&segments[j]) {
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

#[cfg(test)]
mod tests {
    use super::{Segment, crossings};
    use crate::geometry::{Bounds, Vector};
    use crate::random::{Purpose, stream, symmetric};

    /// The result of [`crossings`] for segments that do not share nodes.
    fn swept(segments: &[Segment]) -> Vec<[usize; 2]> {
        let edges: Vec<[usize; 2]> = (0..segments.len()).map(|k| [2 * k, 2 * k + 1]).collect();
        let ends = segments
            .iter()
            .flat_map(|segment| [segment.from, segment.to]);
        crossings(&ends.collect::<Vec<_>>(), &edges)
    }

    fn of_all_pairs(segments: &[Segment]) -> Vec<[usize; 2]> {
        let later = |i: usize| (i + 1..segments.len()).map(move |j| [i, j]);
        let pairs = (0..segments.len()).flat_map(later);
        pairs
            .filter(|[i, j]| segments[*i].crosses(&segments[*j]))
            .collect()
    }

    #[test]
    fn a_sweep_finds_the_crossings_of_all_pairs() {
        let mut random = stream(5, Purpose::Verification);
        let mut found = 0;
        for case in 0..60 {
            // The cases have wide, high and square fields, and short and long segments. In half of them the ends are
            // on a grid, so that segments meet, overlap and are parallel to the axes.
            let size = [[15.0, 1.0], [1.0, 15.0], [4.0, 4.0]][case % 3];
            let reach = [1.0, 3.0, 30.0][case / 3 % 3];
            let on_grid = case % 2 == 0;
            let segments: Vec<Segment> = (0..150)
                .map(|_| {
                    let mut number = |limit: f64| {
                        let x = symmetric(&mut random, limit);
                        if on_grid { x.round() } else { x }
                    };
                    let from = Vector::new(size).map(&mut number);
                    Segment::new(from, from.map(|x| x + number(reach)))
                })
                .collect();
            let expected = of_all_pairs(&segments);
            assert_eq!(swept(&segments), expected, "case {case}");
            found += expected.len();
        }
        assert!(found > 1000, "{found} crossings");
        assert!(swept(&[]).is_empty());
    }

    fn of([from, to]: [[f64; 2]; 2]) -> Segment {
        Segment::new(from.into(), to.into())
    }

    #[test]
    fn segments_end_at_the_bounds() {
        let bounds = Bounds::of([[-64.0, -64.0], [544.0, 304.0]].map(Vector::new));
        let within = |ends| of(ends).within(&bounds);
        let inside = [[10.0, 10.0], [400.0, 200.0]];
        assert_eq!(within(inside), Some(of(inside)));
        let across = within([[-1e9, 120.0], [1e9, 120.0]]).unwrap();
        // The ends are shares of a segment of 1e9 m. A share is rounded at 1e-16, which gives an error of 1e-7 m.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-6;
        assert!(
            near(across.from.0[0], -64.0) && near(across.to.0[0], 544.0),
            "{across:?}"
        );
        let down = within([[240.0, 120.0], [240.0, -1e12]]).unwrap();
        assert!(
            down.from == [240.0, 120.0] && near(down.to.0[1], -64.0),
            "{down:?}"
        );
        let far = within([[-1e30, 120.0], [1e30, 120.0]]).unwrap();
        assert!(
            [far.from, far.to].iter().all(|end| end.0[0].abs() <= 544.0),
            "{far:?}"
        );
        assert_eq!(within([[-1e9, 0.0], [-1e8, 0.0]]), None);
        assert_eq!(within([[0.0, 1e9], [1e9, 1e9 + 1.0]]), None);
        assert_eq!(within([[f64::NAN, 0.0], [1.0, 1.0]]), None);
        assert_eq!(within([[0.0, 0.0], [f64::INFINITY, 1.0]]), None);
    }

    #[test]
    fn a_segment_with_a_nan_crosses_nothing() {
        let [up, down] = [[[0.0, 0.0], [1.0, 1.0]], [[0.0, 1.0], [1.0, 0.0]]].map(of);
        let lost = of([[f64::NAN, 0.0], [1.0, 1.0]]);
        let nowhere = of([[f64::NAN; 2]; 2]);
        assert_eq!(swept(&[lost, up, nowhere, down]), [[1, 3]]);
    }
}
