//! Writes `adjoints.rs` and tests that it is up to date.

use autodiff::arrays::Fixed;
use autodiff::emit::{adjoint, assert_fresh};

use super::bar::{BarForce, Tension};
use super::bending::{Bend, Total};
use super::contact::{Contact, Drifting, Flat, Flying};
use super::coulomb::Coulomb;
use super::force::Sum;
use super::hooke::Hooke;
use super::motion::{Drift, Flight};
use super::no_ground::NoGround;
use super::sticking::Sticking;
use super::stiffening::Stiffening;

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

/// The adjoints of a step and of a drift under a contact law.
fn of_contact<C: Contact>(name: &str) -> [String; 2] {
    let (contact, ground) = (C::default(), Flat);
    let flying = |v: &[f64]| Fixed {
        kernel: Flying {
            flight: Flight {
                drift: Drift { dt: v[0] },
                decay: v[1],
            },
            contact: contact.clone(),
            ground,
        },
        uniforms: v[2..].to_vec(),
    };
    let drifting = |v: &[f64]| Fixed {
        kernel: Drifting {
            drift: Drift { dt: v[0] },
            contact: contact.clone(),
            ground,
        },
        uniforms: v[1..].to_vec(),
    };
    let of_flight = ["self.flight.drift.dt", "self.flight.decay"];
    let of_flight = [&of_flight, &UNIFORMS[..2 + C::COUNT]].concat();
    let of_drift = [&["self.drift.dt"], &UNIFORMS[..C::COUNT]].concat();
    [
        adjoint(&format!("Flying<{name}>"), &of_flight, flying),
        adjoint(&format!("Drifting<{name}>"), &of_drift, drifting),
    ]
}

/// The adjoint of the impulse of a law along bars.
fn of_bars<L: BarForce>(name: &str) -> String {
    let tension = |v: &[f64]| Fixed {
        kernel: Tension {
            law: L::default(),
            dt: v[L::COUNT],
        },
        uniforms: v[..L::COUNT].to_vec(),
    };
    let fields = [&UNIFORMS[..L::COUNT], &["self.dt"]].concat();
    adjoint(&format!("Tension<{name}>"), &fields, tension)
}

#[test]
fn adjoints_are_fresh() {
    let contacts = [
        of_contact::<NoGround>("NoGround"),
        of_contact::<Sticking>("Sticking"),
        of_contact::<Coulomb>("Coulomb"),
    ];
    let forces = [
        of_bars::<Hooke>("Hooke"),
        of_bars::<Stiffening>("Stiffening"),
        adjoint("Bend", &["self.section", "self.dt"], |v| Bend {
            section: v[0],
            dt: v[1],
        }),
        adjoint("Total", &[], |_| Total),
        adjoint("Sum", &[], |_| Sum),
    ];
    let all = [contacts.as_flattened(), &forces].concat();
    assert_fresh("src/laws/adjoints.rs", HEADER, &all);
}
