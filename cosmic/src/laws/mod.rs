//! The physical laws of a step: contact laws and forces. Each law has its own file. A law of a user implements the same
//! traits as the laws here.
//!
//! A law is a type with [settings](Law) and one generic method. The method returns the [velocity](Contact::respond) of
//! a node that meets the ground, the [tension](BarForce::tension) of a bar, or the [force](NodeForce::force) on a node.
//! A force of another kind implements [`LatticeForce`]. Derivatives (also with respect to the settings), SIMD lanes and the
//! stable time step follow from that method without further code. Scenes can choose every law of this crate and every
//! law that a program has added to the [registry](crate::Registry::with_law).

mod law;
mod motion;
mod stiffness;
mod terrain;
mod contact;
mod no_ground;
mod sticking;
mod coulomb;
mod pass;
mod hold;
mod any_contact;
mod bar;
mod slopes;
mod force;
mod on_bars;
mod node;
mod hooke;
mod damper;
mod stops;
mod actuator;
mod rope;
mod bumpers;
mod formula;
mod choice;
#[rustfmt::skip]
mod adjoints;

pub use actuator::Actuator;
pub(crate) use any_contact::{AnyContact, FlightInputs};
pub use bar::{Bar, BarForce, EdgeNumbers, MovingBar, MovingTension, StillBar, Tension};
pub use bumpers::{Bump, Bumpers, Total};
pub use choice::{Choice, ContactLaw, ForceLaws, contact, on_bars, on_lattice, on_nodes};
pub(crate) use choice::{LAW, names};
pub use contact::{Contact, Flat, Flying, Impact, PushedNode, Surface};
pub use coulomb::Coulomb;
pub use damper::Damper;
pub(crate) use force::add;
pub use force::{Force, ForceParameters, LatticeForce, Pose, Pull, RestingBar, Step, Sum};
pub use formula::{BarFormula, NodeFormula};
pub use hold::{Equation, FirstPass, NextPass};
pub(crate) use hold::{FindGround, FreeEquation, Reaction};
pub use hooke::Hooke;
pub use law::{Law, StepInput};
pub use motion::{Drift, Motion, Particle, Push};
pub use no_ground::NoGround;
pub use node::{Node, NodeForce};
pub(crate) use on_bars::OnBars;
pub(crate) use pass::{
    Balance, FirstContact, GroundBelow, HeldEquation, HeldNode, NextContact, NodeAndGround,
    NodeContacts, NodeEquation, NodeInNextPass, NodeInPass,
};
pub use rope::Rope;
pub(crate) use slopes::LinearBar;
pub use slopes::{Impulse, Linear, Tensions};
pub use sticking::Sticking;
pub use stiffness::Stiffness;
pub use stops::Stops;
pub use terrain::Terrain;
