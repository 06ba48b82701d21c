//! Tests of the kernels' adjoints, against their duals and against differences.

use autodiff::check::{Claim, Options, Verdict, check_directions};
use autodiff::{Adjoint, Dual};

use super::kernels::{Flight, Sliding, Spring, Sticking};

const DT: f64 = 0.002;

/// The kernel's adjoint, its duals and differences of it, along a fixed cotangent.
fn verdict<K: Adjoint<I, O>, const I: usize, const O: usize>(
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
    check_directions(value, &claim, &options).verdict
}

fn is_right<K: Adjoint<I, O>, const I: usize, const O: usize>(kernel: &K, x: [f64; I]) {
    assert_eq!(verdict(kernel, x, 0.0), Verdict::Smooth);
    assert_eq!(verdict(kernel, x, 0.01), Verdict::Wrong);
}

#[test]
fn springs() {
    let spring = Spring { dt: DT };
    // Stretched, compressed, slack in one direction, and nearly without length.
    for [dx, dy] in [[0.08, 0.09], [-0.05, 0.02], [0.0, 0.1], [2e-3, 1e-3]] {
        is_right(&spring, [dx, dy, 0.3, 4.0, 0.1, 0.35]);
    }
}

fn flight() -> Flight {
    Flight {
        dt: DT,
        decay: (-20.0 * DT).exp(),
        gravity: [-0.003, -0.009],
    }
}

/// Nodes `[x, y, vx, vy, jx, jy, 1 / m]` that stay off the ground, that touch it within the
/// step, and that are under it and leave.
const NODES: [[f64; 7]; 3] = [
    [0.3, 0.2, 0.4, -0.5, 1e-3, 2e-3, 40.0],
    [0.3, 1e-3, 0.4, -0.9, 1e-3, -2e-3, 40.0],
    [0.3, -2e-3, 0.4, 0.9, 1e-3, 2e-3, 40.0],
];

#[test]
fn infinite_friction() {
    for node in NODES {
        is_right(&Sticking(flight()), node);
    }
}

#[test]
fn coulomb_friction() {
    // Slides on, stops, and slides without friction.
    for friction in [0.2, 2.5, 0.0] {
        let kernel = Sliding {
            flight: flight(),
            friction,
        };
        for node in NODES {
            is_right(&kernel, node);
        }
    }
}

/// A node under the ground that moves inward stops where it is: `time_of_impact` is clamped
/// at 0, and passes nothing (D9).
#[test]
fn a_buried_node_keeps_its_place() {
    let buried = [0.3, -1e-3, 0.4, -0.5, 0.0, 0.0, 40.0];
    let by_place = Sticking(flight()).vjp(buried, [0.7, 1.0, 5.0, 5.0]);
    assert_eq!(by_place, [0.7, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(verdict(&Sticking(flight()), buried, 0.0), Verdict::Smooth);
}
