//! Derivatives of the built-in laws against differences and duals.

use autodiff::check::{Claim, Options, Verdict, check_directions};
use autodiff::{Dual, Function, Kernel, Real, gradient};

use super::bar::Tension;
use super::bending::Bend;
use super::contact::{Contact, Drifting, Flying};
use super::{Coulomb, Drift, Flight, Hooke, NoGround, Sticking, Stiffening};

const DT: f64 = 0.002;

/// The kernel's adjoint, its duals and differences of it, along a fixed cotangent.
fn verdict<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    x: [f64; I],
    wrong_by: f64,
) -> Verdict {
    let y_bar: [f64; O] = std::array::from_fn(|k| 1.0 - 0.4 * k as f64);
    let value = |x: &[f64]| {
        let y = kernel.eval::<f64>(std::array::from_fn(|i| x[i]));
        y.iter().zip(y_bar).map(|(y, bar)| y * bar).sum()
    };
    let forward = |direction: &[f64]| {
        let y = kernel.eval::<Dual<f64, 1>>(std::array::from_fn(|i| Dual {
            value: x[i],
            tangent: [direction[i]],
        }));
        y.iter().zip(y_bar).map(|(y, bar)| y.tangent[0] * bar).sum()
    };
    let gradient = kernel.vjp(x, y_bar).map(|bar| bar * (1.0 + wrong_by));
    let forward: Option<autodiff::check::Along> = match wrong_by {
        0.0 => Some(&forward),
        // The differences alone must notice.
        _ => None,
    };
    let claim = Claim {
        x: &x,
        gradient: &gradient,
        forward,
    };
    // An impulse over a mass of grams makes slopes that differ by thousands: the typical one
    // is then the largest alone, and the step must be small beside a time of impact.
    let options = Options {
        directions: 16,
        largest_step: 1e-3,
        ..Options::default()
    };
    let report = check_directions(value, &claim, &options);
    println!("{report}");
    report.verdict
}

fn is_right<K: Kernel<I, O>, const I: usize, const O: usize>(kernel: &K, x: [f64; I]) {
    assert_eq!(verdict(kernel, x, 0.0), Verdict::Smooth);
    assert_eq!(verdict(kernel, x, 0.01), Verdict::Wrong);
}

#[test]
fn springs() {
    let (dt, cubic) = (DT, 150.0);
    // Stretched, compressed, slack in one direction, and nearly without length.
    for [dx, dy] in [[0.08, 0.09], [-0.05, 0.02], [0.0, 0.1], [2e-3, 1e-3]] {
        let given = [dx, dy, 0.3, 4.0, 0.1, 0.35];
        let law = Hooke {};
        is_right(&Tension { law, dt }, given);
        let law = Stiffening { cubic };
        is_right(&Tension { law, dt }, given);
    }
}

/// Nodes in line, turned a little, at a right angle, folded back, and of uneven arms.
const TURNS: [[f64; 6]; 5] = [
    [0.0, 0.0, 0.1, 0.0, 0.2, 0.0],
    [0.0, 0.0, 0.1, 0.01, 0.2, 0.0],
    [0.0, 0.0, 0.1, 0.0, 0.1, 0.1],
    [0.0, 0.0, 0.1, 0.0, 0.01, 0.005],
    [0.3, 0.2, 0.1, 0.1, -0.4, 0.3],
];

const BEND: Bend = Bend {
    section: 2e-4,
    dt: DT,
};

#[test]
fn bending() {
    // In line, the cotangent above, which is linear along the nodes, is met by no slope.
    for [a, b, c, d, e, f] in TURNS[1..].iter().copied() {
        is_right(&BEND, [a, b, c, d, e, f, 400.0, 300.0]);
    }
}

/// The energy of the angular spring, as a function of the three nodes.
struct Energy;

impl Function for Energy {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let [ax, ay] = [x[2] - x[0], x[3] - x[1]];
        let [bx, by] = [x[4] - x[2], x[5] - x[3]];
        let lengths = (ax * ax + ay * ay).sqrt() * (bx * bx + by * by).sqrt();
        R::lit(0.04) * (R::one() - (ax * bx + ay * by) / lengths)
    }
}

#[test]
fn the_forces_of_bending_are_the_energy_s_slope() {
    for nodes in TURNS {
        let [a, b, c, d, e, f] = nodes;
        let bend = Bend { dt: 1.0, ..BEND };
        // Two edges of 400 N/m make 0.04 N m.
        let pulls = bend.eval([a, b, c, d, e, f, 400.0, 400.0]);
        let slope = gradient(&Energy, &nodes);
        for (pull, slope) in pulls.iter().zip(slope) {
            // Softening moves a length of 0.1 by a share of 5e-11; forces are below 1 N.
            assert!((pull + slope).abs() < 1e-9, "{pulls:?}");
        }
    }
}

fn flying<C: Contact>(contact: C) -> Flying<C> {
    let flight = Flight {
        drift: Drift { dt: DT },
        decay: (-20.0 * DT).exp(),
        gravity: [-0.003, -0.009],
    };
    Flying { flight, contact }
}

fn drifting<C: Contact>(contact: C) -> Drifting<C> {
    let drift = Drift { dt: DT };
    Drifting { drift, contact }
}

/// Nodes `[x, y, vx, vy, jx, jy, 1 / m]` that stay off the ground, that touch it within the
/// step, and that are under it and leave.
const NODES: [[f64; 7]; 3] = [
    [0.3, 0.2, 0.4, -0.5, 1e-3, 2e-3, 40.0],
    [0.3, 1e-3, 0.4, -0.9, 1e-3, -2e-3, 40.0],
    [0.3, -2e-3, 0.4, 0.9, 1e-3, 2e-3, 40.0],
];

/// Nodes that fly and drift under a contact law.
fn contact_is_right<C: Contact>(contact: C) {
    for node in NODES {
        is_right(&flying(contact.clone()), node);
        let [x, y, vx, vy, ..] = node;
        is_right(&drifting(contact.clone()), [x, y, vx, vy]);
    }
}

#[test]
fn contacts() {
    contact_is_right(NoGround {});
    contact_is_right(Sticking {});
    // Slides on, stops, and slides without friction.
    for friction in [0.2, 2.5, 0.0] {
        contact_is_right(Coulomb { friction });
    }
}

/// Friction holds a node that is at rest, so that nothing passes (D9); without friction nothing
/// holds it.
#[test]
fn coulomb_friction_at_rest() {
    let resting = [0.3, 1e-3, 0.0, -0.9];
    let drift = |friction| drifting(Coulomb { friction });
    is_right(&drift(0.2), resting);
    is_right(&drift(0.0), resting);
    let by_velocity = |friction| drift(friction).vjp(resting, [0.0, 0.0, 1.0, 0.0])[2];
    assert_eq!([0.2, 0.0].map(by_velocity), [0.0, 1.0]);
}

/// A node under the ground that moves inward stops where it is: `time_of_impact` is clamped
/// at 0, and passes nothing (D9).
#[test]
fn a_buried_node_keeps_its_place() {
    let buried = [0.3, -1e-3, 0.4, -0.5, 0.0, 0.0, 40.0];
    let by_place = flying(Sticking {}).vjp(buried, [0.7, 1.0, 5.0, 5.0]);
    assert_eq!(by_place, [0.7, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(verdict(&flying(Sticking {}), buried, 0.0), Verdict::Smooth);
}
