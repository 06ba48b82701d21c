//! The direction in which a robot is seen.

use cosmic::geometry::{Bounds, Dimension, Vector};

/// A parallel projection. `page/painter.js` has the same one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// The cosine and the sine of the yaw.
    yaw: [f64; 2],
    /// The cosine and the sine of the pitch.
    pitch: [f64; 2],
}

impl Eye {
    /// The view from the side, as yaw and pitch in degrees: points along the ground are to the right.
    pub const SIDE: [f64; 2] = [0.0, 0.0];
    /// The view in which a robot in space is seen at first, as yaw and pitch in degrees.
    pub const THREE_QUARTERS: [f64; 2] = [-40.0, 18.0];
    /// The view of a robot that walks towards the viewer.
    pub const FRONT: [f64; 2] = [-90.0, 0.0];
    /// The view from above.
    pub const TOP: [f64; 2] = [0.0, 90.0];

    /// Returns the projection for a yaw and a pitch in degrees.
    pub fn new(angles: [f64; 2]) -> Self {
        let [yaw, pitch] = angles.map(|degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            [cos, sin]
        });
        Self { yaw, pitch }
    }

    /// Returns the projection in which robots of this dimension are drawn.
    pub fn of(dimension: Dimension) -> Self {
        Self::new(match dimension {
            Dimension::Plane => Self::SIDE,
            Dimension::Space => Self::THREE_QUARTERS,
        })
    }

    /// Returns how far a point is to the right, away from the viewer, and up, in this order.
    pub fn see(&self, point: Vector<f64>) -> Vector<f64> {
        let ([cos, sin], [flat, tilt]) = (self.yaw, self.pitch);
        let [x, y, z] = point.array();
        let away = sin * x + cos * y;
        Vector::new([
            cos * x - sin * y,
            flat * away - tilt * z,
            flat * z + tilt * away,
        ])
    }

    /// Returns the box around points, as they are [seen](Self::see).
    pub(super) fn bounds(&self, points: impl IntoIterator<Item = Vector<f64>>) -> Bounds {
        Bounds::of(points.into_iter().map(|point| self.see(point)))
    }

    /// Returns how much wider a box of the world looks for each metre that it is deep.
    pub(super) fn slant(&self) -> f64 {
        let [cos, sin] = self.yaw;
        (sin / cos).abs()
    }

    /// True if the ground is seen as a line.
    pub(super) fn is_level(&self) -> bool {
        self.pitch[1] == 0.0
    }

    /// The cosine of the pitch: how high a metre above the ground looks.
    pub(super) fn flat(&self) -> f64 {
        self.pitch[0]
    }

    /// The sine of the pitch: how high a metre of the ground looks that leads away from the viewer.
    pub(super) fn tilt(&self) -> f64 {
        self.pitch[1]
    }
}
