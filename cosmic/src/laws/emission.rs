//! Writes `adjoints.rs` and tests that it is up to date.

use autodiff::emit::{adjoint, assert_fresh};

use super::bar::Tension;
use super::bending::{Bend, Total};
use super::contact::{Contact, Drifting, Flat, Flying};
use super::coulomb::Coulomb;
use super::force::Sum;
use super::hooke::Hooke;
use super::motion::{Drift, Flight};
use super::no_ground::NoGround;
use super::sticking::Sticking;
use super::stiffening::Stiffening;
use crate::geometry::Vector;

const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p cosmic-codesign --lib adjoints_are_fresh`.

use autodiff::Real;

use super::bar::Tension;
use super::bending::{Bend, Total};
use super::contact::{Drifting, Flying};
use super::coulomb::Coulomb;
use super::force::Sum;
use super::hooke::Hooke;
use super::no_ground::NoGround;
use super::stiffening::Stiffening;
use super::sticking::Sticking;
";

/// The names of uniform inputs: gravity, then the settings of a contact law.
const UNIFORMS: [&str; 3] = ["uniforms[0]", "uniforms[1]", "uniforms[2]"];

/// The adjoints of a step and of a drift under a contact law with this many settings.
fn of_contact<C: Contact>(name: &str, settings: usize, build: impl Fn(&[f64]) -> C) -> Vec<String> {
    let of_flight = ["self.flight.drift.dt", "self.flight.decay"];
    let flying = |v: &[f64]| Flying {
        flight: Flight {
            drift: Drift { dt: v[0] },
            decay: v[1],
            gravity: Vector::new([v[2], v[3]]),
        },
        contact: build(&v[4..]),
        ground: Flat,
    };
    let drifting = |v: &[f64]| Drifting {
        drift: Drift { dt: v[0] },
        contact: build(&v[1..]),
        ground: Flat,
    };
    let of_flight = [&of_flight, &UNIFORMS[..2 + settings]].concat();
    let of_drift = [&["self.drift.dt"], &UNIFORMS[..settings]].concat();
    vec![
        adjoint(&format!("Flying<{name}>"), &of_flight, flying),
        adjoint(&format!("Drifting<{name}>"), &of_drift, drifting),
    ]
}

#[test]
fn adjoints_are_fresh() {
    let [free, sticking] = [
        of_contact("NoGround", 0, |_| NoGround {}),
        of_contact("Sticking", 0, |_| Sticking {}),
    ];
    let coulomb = of_contact("Coulomb", 1, |v| Coulomb { friction: v[0] });
    let bars = [
        adjoint("Tension<Hooke>", &["self.dt"], |v| Tension {
            law: Hooke {},
            dt: v[0],
        }),
        adjoint("Tension<Stiffening>", &["uniforms[0]", "self.dt"], |v| {
            Tension {
                law: Stiffening { cubic: v[0] },
                dt: v[1],
            }
        }),
        adjoint("Bend", &["self.section", "self.dt"], |v| Bend {
            section: v[0],
            dt: v[1],
        }),
        adjoint("Total", &[], |_| Total),
        adjoint("Sum", &[], |_| Sum),
    ];
    let all = [&free[..], &sticking, &coulomb, &bars].concat();
    assert_fresh("src/laws/adjoints.rs", HEADER, &all);
}
