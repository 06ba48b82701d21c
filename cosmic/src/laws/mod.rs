//! The physical laws of a step: contact laws and forces. Each law has its own file. A law of a user implements the same
//! traits as the laws here.
//!
//! A law is a type with [settings](Law) and one generic method. The method returns the [velocity](Contact::respond) of
//! a node that meets the ground (`ground`), the [tension](BarForce::tension) of a bar (`bars`), or the
//! [force](NodeForce::force) on a node (`forces`). A force of another kind implements [`LatticeForce`]. Derivatives (also
//! with respect to the settings), SIMD lanes and the stable time step follow from that method without further code. Scenes
//! can choose every law of this crate and every law that a program has added to the
//! [registry](crate::Registry::with_law).

mod law;
mod motion;
mod bars;
mod forces;
mod ground;
mod formula;
mod choice;
#[rustfmt::skip]
mod adjoints;

pub(crate) use bars::LinearBar;
pub use bars::{Actuator, Bar, BarForce, Damper, Hooke, Rope, Stops, Tensions};
pub use choice::{Choice, ContactLaw, ForceLaws, contact, on_bars, on_lattice, on_nodes};
pub(crate) use choice::{LAW, names};
pub use forces::{
    AlongBars, Bumpers, Force, ForceParameters, LatticeForce, Node, NodeForce, Pose, Pull,
    RestingBar, Step, Stiffness,
};
pub(crate) use forces::{OnBars, add, tensions};
pub use formula::{BarFormula, NodeFormula};
pub(crate) use ground::{
    AnyContact, Balance, FindGround, FirstContact, FlightInputs, FreeEquation, GroundBelow,
    HeldEquation, HeldNode, NextContact, NodeAndGround, NodeContacts, NodeEquation, NodeInNextPass,
    NodeInPass, Reaction,
};
pub use ground::{Contact, Coulomb, Impact, NoGround, Sticking};
pub(crate) use law::FRICTION;
pub use law::{Law, StepInput};
pub use motion::{Drift, Motion, Particle};

/// The kernels of laws, for tests.
#[doc(hidden)]
pub mod kernels {
    pub use super::bars::{
        EdgeNumbers, Impulse, Linear, MovingBar, MovingTension, StillBar, Tension,
    };
    pub use super::forces::{Bump, Sum, Total};
    pub use super::ground::{
        Equation, FirstPass, Flat, Flying, NextPass, PushedNode, Surface, Terrain,
    };
    pub use super::motion::Push;
}
