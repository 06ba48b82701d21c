//! Terrain: the segments of a ground's profile, and the search for the first segment that a node meets.
//!
//! A node is over exactly one segment at any time. The path of a node over the corners of the profile consists of stays:
//! during each stay, the node is over one segment. The node meets the first segment whose line it crosses during the stay
//! over that segment. Each stay begins exactly when the previous stay ends, so that no node slips through a corner because
//! of rounding.
//!
//! A vertical wall is a segment without a stay. A node meets it at the moment between two stays, if it passes the wall
//! below the edge. Then it is placed exactly at the wall, because a node behind the wall would be below the ground there.
//! A node exactly at a wall is in front of it, over the ground at its foot.

use std::sync::Arc;

use autodiff::{Dual, Mask, Real};

use crate::geometry::{Plane, Profile, Rotation, Vector, Wall};
use crate::laws::motion::Particle;

/// The profile of the ground as a list of segments, for use in kernels.
#[derive(Clone, Debug)]
pub struct Terrain {
    segments: Arc<[Segment]>,
    /// The numbers of the segments that are walls.
    walls: Arc<[usize]>,
}

/// A straight part of the terrain, in the ground's frame.
#[derive(Clone, Copy, Debug)]
struct Segment {
    plane: Plane<f64>,
    /// The position along the ground at which this segment ends and the next one begins, m.
    end: f64,
    /// The wall, if this segment is one.
    wall: Option<Wall>,
    /// The number of the wall at the end of this segment: this segment itself, or the next one.
    wall_at_end: Option<usize>,
}

/// A point counts as on a line if its distance from the line is at most this share of its distance from the corner
/// before it.
const ON_LINE: f64 = 1e-12;

impl Terrain {
    /// Converts a profile. Returns `None` for a flat profile, which has no points.
    pub fn new(profile: &Profile) -> Option<Self> {
        let points = profile.points();
        let (first, last) = (*points.first()?, *points.last()?);
        let level = Rotation::NONE;
        let mut segments = vec![Segment::new(first, level, first.forward())];
        for ends in points.windows(2) {
            let (from, to) = (ends[0], ends[1]);
            match segments.last_mut() {
                // Points on one line do not form a corner, so a node slides across them without an impact.
                Some(last) if last.continues_to(from, to) => last.end = to.forward(),
                _ => {
                    let axes = Rotation::towards(from, to);
                    let wall = profile.walls().find(|wall| wall.place == to.forward());
                    segments.push(Segment {
                        wall: wall.filter(|wall| wall.place == from.forward()),
                        ..Segment::new(from, axes, to.forward())
                    });
                }
            }
        }
        match segments.last_mut() {
            Some(segment) if segment.plane.axes == level => segment.end = f64::INFINITY,
            _ => segments.push(Segment::new(last, level, f64::INFINITY)),
        }
        let is_wall = |k: &usize| segments[*k].wall.is_some();
        let walls: Arc<[usize]> = (0..segments.len()).filter(is_wall).collect();
        for &wall in &*walls {
            // The first segment is level, so there is one before the wall.
            for k in [wall - 1, wall] {
                segments[k].wall_at_end = Some(wall);
            }
        }
        let segments = segments.into();
        Some(Self { segments, walls })
    }

    /// The search along a drift of a node that does not meet segment number `but`; -1 stands for no segment.
    #[inline(always)]
    pub(super) fn search<R: Real>(&self, but: R) -> Search<'_, R> {
        Search {
            terrain: self,
            but,
            touched: R::lit(NONE),
            found: Found::nothing(),
        }
    }

    /// The plane of segment number `segment`; of the first segment for -1. It has no derivative.
    #[inline(always)]
    pub(super) fn plane_of<R: Real>(&self, segment: R) -> Plane<R> {
        let mut plane = self.segments[0].plane.lit();
        for k in 1..self.segments.len() {
            let is_next = R::lit(k as f64 - 0.5).less(segment);
            plane = Plane::select(is_next, self.segments[k].plane.lit(), plane);
        }
        plane
    }

    /// How far a node that touches the wall with segment number `touched`, or is behind a wall by a rounding error, must be
    /// moved forward to be exactly at the wall, m. It has no derivative.
    #[inline(always)]
    fn shift_to_wall<R: Real, const D: usize>(&self, node: Particle<R, D>, touched: R) -> R {
        let (zero, mut x, mut all) = (R::zero(), node.x, R::zero());
        for &k in &*self.walls {
            let segment = &self.segments[k];
            let Some(wall) = &segment.wall else { continue };
            let touches = is_number(k, touched);
            let behind = -segment.plane.lit().height(x);
            let below = R::lit(wall.heights.high) - x.up();
            // A node that stands on the edge is nearer to the top than to the wall.
            let is_behind =
                zero.less(behind) & behind.less(R::lit(wall.tolerance())) & behind.less(below);
            let shift = (R::lit(wall.place) - x.forward()).detach();
            let shift = R::select(touches | is_behind, shift, zero);
            x = x.moved_along(Vector::upright(shift, zero));
            all += shift;
        }
        all
    }

    /// The position along the ground at which a node leaves segment number `k`, forward. A node that moves along a wall,
    /// or touches the wall with segment number `but`, stays in front of it.
    #[inline(always)]
    fn end_of<R: Real, const D: usize>(&self, k: usize, way: &RemainingDrift<R, D>, but: R) -> R {
        let Segment {
            end, wall_at_end, ..
        } = self.segments[k];
        let end = R::lit(end);
        let Some(number) = wall_at_end else {
            return end;
        };
        let segment = &self.segments[number];
        let Some(wall) = &segment.wall else {
            return end;
        };
        let touches = is_number(number, but);
        let moves_along = way.node.v.forward().abs().less(R::lit(LEAST_SPEED));
        let is_in_front = !segment.plane.lit().height(way.node.x).less(R::zero());
        let never = R::lit(if wall.rises {
            f64::INFINITY
        } else {
            f64::NEG_INFINITY
        });
        R::select((touches | moves_along) & is_in_front, never, end)
    }

    /// Finds the first segment of the terrain that a node meets on its way. Ignores segment number `but`. The result
    /// has no derivative.
    #[inline(always)]
    fn meet<R: Real, const D: usize>(&self, way: &RemainingDrift<R, D>, but: R) -> Hit<R> {
        let (zero, least) = (R::zero(), R::lit(LEAST_SPEED));
        let Particle { x, v } = way.node;
        // A node that moves straight up or down stays over its segment.
        let speed = R::select(v.forward().abs().less(least), least, v.forward());
        let per_way = speed.recip();
        let mut met = Hit::none(way.left);
        let mut enters = R::lit(f64::NEG_INFINITY) * per_way;
        let (mut earliest, mut last_met) = (way.left, way.left);
        for k in 0..self.segments.len() {
            let segment = &self.segments[k];
            let (number, plane) = (R::lit(k as f64), segment.plane.lit());
            // The first and the last moment at which the node is over this segment. A node that moves backwards leaves
            // a segment where the segment begins.
            let leaves = (self.end_of(k, way, but) - x.forward()) * per_way;
            let first = enters.min(leaves).max(zero);
            let last = enters.max(leaves).min(way.left);
            enters = leaves;
            let (height, out) = (plane.height(x), plane.axes.out(v));
            let is_other = !is_number(k, but);
            let SegmentHit {
                is_met,
                first,
                last,
            } = match &segment.wall {
                None => {
                    let sinks = last.fma(out, height).less(zero) & out.less(zero);
                    let is_met = sinks & first.less(last) & first.less(earliest);
                    SegmentHit {
                        is_met,
                        first,
                        last,
                    }
                }
                Some(wall) => segment.pass(wall, way, per_way, earliest),
            };
            let is_met = is_met & is_other;
            earliest = R::select(is_met, first, earliest);
            last_met = R::select(is_met, last, last_met);
            met.touches = met.touches | is_met;
            met.segment = R::select(is_met, number, met.segment);
            met.plane = Plane::select(is_met, plane, met.plane);
        }
        let slack = R::lit(SLACK) * way.left;
        met.earliest = (earliest - slack).max(zero);
        met.latest = last_met;
        met.detached()
    }
}

/// How often a contact law acts on a node in one drift. The node is placed at walls, and the terrain is searched, once more.
pub(super) const IMPACTS: usize = 2;

/// What a node meets along its drift: the segments, in turn, and the walls that it is placed at. Nothing of it has a
/// derivative. So an adjoint searches with plain numbers, and then repeats the drift in duals with what was found.
pub(super) trait Route<R: Real> {
    /// The node, which is placed exactly at the wall if it has just met one or is behind one by a rounding error. Its
    /// derivatives do not change.
    fn beside_walls<const D: usize>(&mut self, node: Particle<R, D>) -> Particle<R, D>;

    /// The next segment that the node meets.
    fn meet<const D: usize>(&mut self, way: &RemainingDrift<R, D>) -> Hit<R>;
}

/// The route that is found by searching. The search notes what it finds.
pub(super) struct Search<'a, R: Real> {
    terrain: &'a Terrain,
    /// The number of the segment that the node does not meet.
    but: R,
    /// The number of the segment that the node has just met.
    touched: R,
    found: Found<R>,
}

impl<R: Real> Route<R> for Search<'_, R> {
    #[inline(always)]
    fn beside_walls<const D: usize>(&mut self, node: Particle<R, D>) -> Particle<R, D> {
        self.found.shifts[self.found.next_shift] = self.terrain.shift_to_wall(node, self.touched);
        self.found.beside_walls(node)
    }

    #[inline(always)]
    fn meet<const D: usize>(&mut self, way: &RemainingDrift<R, D>) -> Hit<R> {
        let hit = self.terrain.meet(way, self.but);
        (self.but, self.touched) = (hit.segment, hit.segment);
        self.found.hits[self.found.next_hit] = hit;
        self.found.next_hit += 1;
        hit
    }
}

impl<R: Real> Search<'_, R> {
    /// The route that was found, from its beginning, for duals with the values of `R`.
    #[inline(always)]
    pub(super) fn found<const N: usize>(&self) -> Found<Dual<R, N>> {
        let mut found = Found::nothing();
        for k in 0..=IMPACTS {
            found.shifts[k] = Dual::constant(self.found.shifts[k]);
            found.hits[k] = self.found.hits[k].constant();
        }
        found
    }
}

/// A route that is known.
pub(super) struct Found<R: Real> {
    /// How far the node is moved forward to a wall, m.
    shifts: [R; IMPACTS + 1],
    hits: [Hit<R>; IMPACTS + 1],
    /// The numbers of the shift and of the hit that come next.
    next_shift: usize,
    next_hit: usize,
}

impl<R: Real> Found<R> {
    #[inline(always)]
    fn nothing() -> Self {
        Self {
            shifts: [R::zero(); IMPACTS + 1],
            hits: [Hit::none(R::zero()); IMPACTS + 1],
            next_shift: 0,
            next_hit: 0,
        }
    }
}

impl<R: Real> Route<R> for Found<R> {
    #[inline(always)]
    fn beside_walls<const D: usize>(&mut self, node: Particle<R, D>) -> Particle<R, D> {
        let shift = Vector::upright(self.shifts[self.next_shift], R::zero());
        self.next_shift += 1;
        Particle {
            x: node.x.moved_along(shift),
            ..node
        }
    }

    #[inline(always)]
    fn meet<const D: usize>(&mut self, _: &RemainingDrift<R, D>) -> Hit<R> {
        self.next_hit += 1;
        self.hits[self.next_hit - 1]
    }
}

/// How a node passes a segment: whether it meets the segment, and the earliest and the latest time of impact, s.
struct SegmentHit<R: Real> {
    is_met: R::Mask,
    first: R,
    last: R,
}

/// The time of impact may be earlier than the node's stay over the segment, by at most this fraction of the remaining
/// time.
///
/// When a node slides into a corner, it meets the other side of the corner at the moment when its stay over that side
/// begins. Without the slack, rounding would decide which of the two times is used. With the slack, the time of the
/// impact is always used, which has a derivative. The beginning of the stay has none.
const SLACK: f64 = 1e-3;

/// The smallest speed along the ground with which the search calculates, m/s: a slower node is treated as if it had
/// this speed. It is a normal number in single precision too.
const LEAST_SPEED: f64 = 1e-30;

impl Segment {
    fn new(point: Vector<f64>, axes: Rotation<f64>, end: f64) -> Self {
        let plane = Plane::through(point, axes);
        Self {
            plane,
            end,
            wall: None,
            wall_at_end: None,
        }
    }

    /// True if the line from the corner `from`, where this segment ends, to the corner `to` is a part of this segment.
    fn continues_to(&self, from: Vector<f64>, to: Vector<f64>) -> bool {
        match self.wall {
            None => self.plane.height(to).abs() < ON_LINE * from.distance(to),
            Some(wall) => to.forward() == wall.place,
        }
    }

    /// Whether a node passes this segment, which is a wall, from the front to the back and below the edge. `per_way` is
    /// the reciprocal of the speed along the ground. A wall is met before the ground behind it, which the node reaches at
    /// the same moment.
    #[inline(always)]
    fn pass<R: Real, const D: usize>(
        &self,
        wall: &Wall,
        way: &RemainingDrift<R, D>,
        per_way: R,
        earliest: R,
    ) -> SegmentHit<R> {
        let (node, plane, zero) = (way.node, self.plane.lit(), R::zero());
        let is_in_front = !plane.height(node.x).less(zero);
        // Computes the end of the drift exactly as the drift does, so that no node slips through by rounding.
        let ends_behind = plane.height(node.after(way.left).x).less(zero);
        let moves_in = plane.axes.out(node.v).less(zero);
        let first = (R::lit(wall.place) - node.x.forward()) * per_way;
        let first = first.min(way.left).max(zero);
        let edge = R::lit(wall.heights.high);
        let is_below = node.after(first).x.up().less(edge);
        SegmentHit {
            is_met: is_in_front & ends_behind & moves_in & is_below & !earliest.less(first),
            first,
            // The bounds serve other segments. Here, the time of impact is within the drift anyway.
            last: way.left,
        }
    }
}

/// The rest of a node's drift: the node, and the time for which it still moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct RemainingDrift<R, const D: usize = 2> {
    pub(super) node: Particle<R, D>,
    /// The remaining time, s.
    pub(super) left: R,
}

/// The result of a search for the segment that a node meets: the segment, if there is one, and bounds on the time of
/// impact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hit<R: Real> {
    /// False if the node meets no segment.
    pub(super) touches: R::Mask,
    /// The number of the segment; -1 if there is none.
    pub(super) segment: R,
    plane: Plane<R>,
    /// The earliest and the latest possible time of impact, s.
    earliest: R,
    latest: R,
}

impl<R: Real> Hit<R> {
    #[inline(always)]
    fn none(left: R) -> Self {
        Self {
            touches: R::Mask::splat(false),
            segment: R::lit(NONE),
            plane: Plane::LEVEL.lit(),
            earliest: R::zero(),
            latest: left,
        }
    }

    /// Removes the derivatives of the search. A small change of the path does not change which segment the node meets,
    /// except at corners. So only the impact needs derivatives, and the adjoint does not contain the search.
    #[inline(always)]
    fn detached(self) -> Self {
        Self {
            touches: self.touches,
            segment: self.segment.detach(),
            plane: self.plane.detach(),
            earliest: self.earliest.detach(),
            latest: self.latest.detach(),
        }
    }

    /// The hit for duals with the values of `R`.
    #[inline(always)]
    fn constant<const N: usize>(self) -> Hit<Dual<R, N>> {
        Hit {
            touches: self.touches,
            segment: Dual::constant(self.segment),
            plane: self.plane.constant(),
            earliest: Dual::constant(self.earliest),
            latest: Dual::constant(self.latest),
        }
    }

    /// Returns the node at the impact, and the time that remains then. The velocity has components along the segment
    /// and out of it. If the node meets no segment, returns the node at the end of its way. The derivative of the time
    /// of impact is 0 at the bounds of that time (D9).
    #[inline(always)]
    pub(super) fn reached<const D: usize>(
        &self,
        way: &RemainingDrift<R, D>,
    ) -> RemainingDrift<R, D> {
        let Particle { x, v } = way.node;
        let local = self.plane.axes.into_rotated(v);
        let approach = R::select(self.touches, local.up(), -R::one());
        let time = (-self.plane.height(x) / approach).clamp(self.earliest, self.latest);
        let moving = R::select(self.touches, time, way.left);
        RemainingDrift {
            node: Particle {
                x: way.node.after(moving).x,
                v: local,
            },
            left: way.left - moving,
        }
    }

    /// Converts a vector from components along and out of the segment to the ground's frame.
    #[inline(always)]
    pub(super) fn in_ground<const D: usize>(&self, vector: Vector<R, D>) -> Vector<R, D> {
        self.plane.axes.out_of_rotated(vector)
    }
}

/// True if a segment number is `k`.
#[inline(always)]
fn is_number<R: Real>(k: usize, number: R) -> R::Mask {
    let k = R::lit(k as f64);
    !(k.less(number) | number.less(k))
}

/// The segment number for "no segment".
pub(super) const NONE: f64 = -1.0;
