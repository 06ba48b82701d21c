//! The frame of a case file (D1).

use crate::geometry::{Ground, Vector};
use crate::lattice::State;

/// The frame in which a case file gives positions. Its axes are those of the world, but its ground line may lie above
/// its origin (D1). In the world's frame, the ground line passes through the origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Height of the ground line above the origin of the file, in metres.
    pub ground_height: f64,
}

impl Frame {
    /// The place of the world's origin in the file.
    fn origin(self) -> Vector<f64> {
        Vector::upright(0.0, self.ground_height)
    }

    /// Converts a position from the frame of the file to the world's frame.
    pub fn read(self, position: Vector<f64>) -> Vector<f64> {
        position - self.origin()
    }

    /// Converts a goal from the frame of the file to the world's frame. Goals are in the frame of the ground.
    pub(super) fn read_goal(self, goal: Vector<f64>, ground: &Ground) -> Vector<f64> {
        goal - ground.vector_to_ground(self.origin())
    }

    /// Converts a position from the world's frame to the frame of the file.
    pub fn written(self, position: Vector<f64>) -> Vector<f64> {
        position + self.origin()
    }

    /// Converts a state from the world's frame to the frame of the file.
    pub(super) fn written_state(self, state: &State<f64>) -> State<f64> {
        State {
            x: state.x.iter().map(|&x| self.written(x)).collect(),
            ..state.clone()
        }
    }

    /// The place along the ground of the world's origin, counted from the origin of the file, in metres.
    pub(super) fn along(self, ground: &Ground) -> f64 {
        ground.along(self.origin())
    }
}
