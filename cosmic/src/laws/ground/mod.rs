//! Contact laws, each in its own file, and the ground that nodes meet: flat ground, or [terrain](Terrain) with a profile.

mod terrain;
mod contact;
mod no_ground;
mod sticking;
mod coulomb;
mod pass;
mod hold;
mod any_contact;

pub(crate) use any_contact::{AnyContact, FlightInputs};
pub use contact::{Contact, Flat, Flying, Impact, PushedNode, Surface};
pub use coulomb::Coulomb;
pub use hold::{Equation, FirstPass, NextPass};
pub(crate) use hold::{FindGround, FreeEquation, Reaction};
pub use no_ground::NoGround;
pub(crate) use pass::{
    Balance, FirstContact, GroundBelow, HeldEquation, HeldNode, NextContact, NodeAndGround,
    NodeContacts, NodeEquation, NodeInNextPass, NodeInPass,
};
pub use sticking::Sticking;
pub use terrain::Terrain;
