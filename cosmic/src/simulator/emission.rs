//! Writes `adjoints.rs`, and tests that it is up to date.

use autodiff::emit::{adjoint, assert_fresh};

use super::kernels::{
    Bend, Drift, Flight, FreeDrift, Sliding, SlidingDrift, Spring, Sticking, StickingDrift,
    Stiffening, Total,
};

const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p cosmic-codesign --lib adjoints_are_fresh`.

use autodiff::Real;

use super::kernels::{
    Bend, Flight, FreeDrift, Sliding, SlidingDrift, Spring, Sticking, StickingDrift, Stiffening, Total,
};
";

fn flight(values: &[f64]) -> Flight {
    Flight {
        drift: Drift { dt: values[0] },
        decay: values[1],
        gravity: [values[2], values[3]],
    }
}

#[test]
fn adjoints_are_fresh() {
    let of_flight = |of: &str| {
        let fields = ["drift.dt", "decay", "gravity[0]", "gravity[1]"];
        fields.map(|field| format!("{of}.{field}")).to_vec()
    };
    let [flying, sticking, mut sliding] = ["self", "self.0", "self.flight"].map(of_flight);
    sliding.push("self.friction".to_owned());
    let [flying, sticking, sliding] = [&flying, &sticking, &sliding]
        .map(|names| names.iter().map(String::as_str).collect::<Vec<_>>());
    let parts = [
        adjoint("Spring", &["self.dt"], |v| Spring { dt: v[0] }),
        adjoint("Flight", &flying, flight),
        adjoint("Sticking", &sticking, |v| Sticking(flight(v))),
        adjoint("Sliding", &sliding, |v| Sliding {
            flight: flight(v),
            friction: v[4],
        }),
        adjoint("FreeDrift", &["self.0.dt"], |v| {
            FreeDrift(Drift { dt: v[0] })
        }),
        adjoint("StickingDrift", &["self.0.dt"], |v| {
            StickingDrift(Drift { dt: v[0] })
        }),
        adjoint("SlidingDrift", &["self.drift.dt", "self.friction"], |v| {
            SlidingDrift {
                drift: Drift { dt: v[0] },
                friction: v[1],
            }
        }),
        adjoint("Stiffening", &["self.spring.dt", "self.cubic"], |v| {
            Stiffening {
                spring: Spring { dt: v[0] },
                cubic: v[1],
            }
        }),
        adjoint("Bend", &["self.dt"], |v| Bend { dt: v[0] }),
        adjoint("Total", &[], |_| Total),
    ];
    assert_fresh("src/simulator/adjoints.rs", HEADER, &parts);
}
