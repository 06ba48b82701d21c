//! Laws along bars, each in its own file. A law is a [`BarForce`]: its method returns the tension of a bar.

mod bar;
mod slopes;
mod hooke;
mod damper;
mod stops;
mod actuator;
mod rope;

pub use actuator::Actuator;
pub use bar::{Bar, BarForce, EdgeNumbers, MovingBar, MovingTension, StillBar, Tension};
pub use damper::Damper;
pub use hooke::Hooke;
pub use rope::Rope;
pub(crate) use slopes::LinearBar;
pub(super) use slopes::{BESIDE, Slopes};
pub use slopes::{Impulse, Linear, Tensions};
pub use stops::Stops;
