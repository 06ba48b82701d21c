//! The ground line and its frame.

use autodiff::Real;

/// The ground: a line through the point `(0, height)` of the world, inclined to the horizontal.
///
/// Its frame has that point as origin, the [tangent](Ground::tangent) as first axis and the
/// [normal](Ground::normal) as second: the second coordinate is the height above the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// Height of the ground at `x = 0`, in metres.
    pub height: f64,
    /// Angle to the horizontal in degrees, positive where the ground rises towards `+x`.
    pub incline_deg: f64,
}

impl Ground {
    /// Whether the ground is horizontal: then its frame is the world's, moved and not turned.
    pub fn is_flat(&self) -> bool {
        self.incline_deg == 0.0
    }

    /// The unit vector `s` along the ground, exactly `(1, 0)` on flat ground.
    pub fn tangent(&self) -> [f64; 2] {
        let (sin, cos) = self.incline_deg.to_radians().sin_cos();
        [cos, sin]
    }

    /// The unit vector `n` out of the ground, exactly `(0, 1)` on flat ground.
    pub fn normal(&self) -> [f64; 2] {
        let [cos, sin] = self.tangent();
        [-sin, cos]
    }

    /// A vector (a velocity, a force) of the world in the ground's frame.
    pub fn vector_to_ground<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        if self.is_flat() {
            return [x, y];
        }
        let [cos, sin] = self.tangent().map(R::lit);
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// A vector of the ground's frame in the world's.
    pub fn vector_to_world<R: Real>(&self, [along, up]: [R; 2]) -> [R; 2] {
        if self.is_flat() {
            return [along, up];
        }
        let [cos, sin] = self.tangent().map(R::lit);
        [cos * along - sin * up, sin * along + cos * up]
    }

    /// A point of the world in the ground's frame: how far along, and how high above the ground.
    pub fn point_to_ground<R: Real>(&self, [x, y]: [R; 2]) -> [R; 2] {
        self.vector_to_ground([x, y - R::lit(self.height)])
    }

    /// A point of the ground's frame in the world's.
    pub fn point_to_world<R: Real>(&self, point: [R; 2]) -> [R; 2] {
        let [x, y] = self.vector_to_world(point);
        [x, y + R::lit(self.height)]
    }
}

#[cfg(test)]
mod tests {
    use super::Ground;

    #[test]
    fn there_and_back() {
        for incline_deg in [-37.0, 0.0, 15.0, 90.0] {
            let ground = Ground {
                height: 0.1,
                incline_deg,
            };
            let point: [f64; 2] = [0.7, -0.3];
            let back = ground.point_to_world(ground.point_to_ground(point));
            // Two rotations of numbers below 1: a few roundings of 1e-16.
            assert!((0..2).all(|k| (back[k] - point[k]).abs() < 1e-15));
        }
    }

    #[test]
    fn the_normal_points_out_of_the_ground() {
        let ground = Ground {
            height: 0.1,
            incline_deg: 30.0,
        };
        let [x, y] = ground.normal();
        let up: [f64; 2] = ground.point_to_ground([2.0 * x, 0.1 + 2.0 * y]);
        // One rotation of numbers near 2.
        assert!(up[0].abs() < 1e-15 && (up[1] - 2.0).abs() < 1e-15);
    }

    #[test]
    fn flat_ground_is_exact() {
        let ground = Ground {
            height: 0.1,
            incline_deg: 0.0,
        };
        assert_eq!(ground.tangent(), [1.0, 0.0]);
        assert_eq!(ground.normal(), [0.0, 1.0]);
    }
}
