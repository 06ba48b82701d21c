//! Tests of the built-in laws of bars: their derivatives, compared with finite differences and dual numbers.

use autodiff::{Dual, Real, gradient};
use autodiff_programs::Kernel;
use autodiff_programs::kernels::Fixed;
use cosmic::geometry::Vector;
use cosmic::laws::kernels::{Bump, MovingTension, Tension};
use cosmic::laws::{Actuator, Bar, BarForce, Bumpers, Damper, Hooke, Rope, Stops};

use cosmic::settings::StepInputs;

use super::kernels::{DT, is_right, values};

/// The softening of lengths, m^2.
const SOFTENING: f64 = 1e-12;
/// The largest strain of the actuator material.
const LARGEST_STRAIN: f64 = 0.35;

fn tension<L: BarForce>(law: L) -> Fixed<Tension<L>> {
    Fixed {
        uniforms: values(&law),
        kernel: Tension {
            law,
            dt: DT,
            softening: SOFTENING,
            largest_strain: LARGEST_STRAIN,
        },
    }
}

#[test]
fn springs() {
    // The spring is stretched, compressed, at its target length, and very short.
    for [dx, dy] in [[0.08, 0.09], [-0.05, 0.02], [0.0, 0.1], [2e-3, 1e-3]] {
        let given = [dx, dy, 0.3, 4.0, 0.1, 0.35];
        is_right(&tension(Hooke {}), given);
    }
}

#[test]
fn dampers() {
    let law = Damper { time: 1e-3 };
    for [dvx, dvy] in [[0.4, -0.1], [-2.0, 1.0]] {
        let given = [0.08, 0.09, dvx, dvy, 0.3, 40.0, 0.1, 0.35];
        let Fixed { kernel, uniforms } = tension(law.clone());
        let kernel = MovingTension(kernel);
        is_right(&Fixed { kernel, uniforms }, given);
    }
    // The expected tension is 40 N/m times 1 ms times 0.5 m/s = 0.02 N.
    let bar = |rate| Bar {
        length: 0.12,
        rate,
        target: 0.1,
        rest_length: 0.1,
        stiffness: 40.0,
        strain: 0.35,
        largest_strain: LARGEST_STRAIN,
    };
    assert!((Damper::tension(&law, bar(0.5)) - 0.02).abs() < 1e-17);
    assert_eq!(Damper::tension(&law, bar(0.0)), 0.0);
}

#[test]
fn stops_at_both_ends_of_the_stroke() {
    let law = Stops {
        at: 0.35,
        stiffness: 400.0,
    };
    let bar = |length, strain| bar(length, 0.0, strain);
    for (length, force) in [(0.1349, 0.0), (0.136, 0.4), (0.0651, 0.0), (0.064, -0.4)] {
        // Lengths of 0.1 m are rounded at 1e-17 and multiplied by 400 N/m.
        assert!((Stops::tension(&law, bar(length, 0.35)) - force).abs() < 1e-14);
        // A bar with half the share of actuator has half the stiffness at its stops; a passive bar has no stop.
        assert!((Stops::tension(&law, bar(length, 0.175)) - 0.5 * force).abs() < 1e-14);
        assert_eq!(Stops::tension(&law, bar(length, 0.0)), 0.0);
        let (at, h) = (|l: f64| law.energy(bar(l, 0.35)).unwrap(), 1e-6);
        // The energy is a parabola, so differences are exact except for rounding errors of 1e-20 J divided by h.
        assert!(((at(length + h) - at(length - h)) / (2.0 * h) - force).abs() < 1e-8);
    }
    // The three bars are longer than the stops allow, between the stops, and shorter than the stops allow.
    for [dx, dy] in [[0.12, 0.09], [0.08, 0.09], [0.03, 0.04]] {
        let given = [dx, dy, 0.3, 30.0, 0.1, 0.35];
        let tension = tension(law.clone());
        let length = Vector::new([dx, dy]).norm();
        if (length - 0.1_f64).abs() > 0.035 {
            is_right(&tension, given);
        } else {
            assert_eq!(tension.eval(given, &[]), [0.0; 2]);
        }
    }
}

/// A bar of 30 N/m whose target is its rest length of 0.1 m.
fn bar(length: f64, rate: f64, strain: f64) -> Bar<f64> {
    Bar {
        length,
        rate,
        target: 0.1,
        rest_length: 0.1,
        stiffness: 30.0,
        strain,
        largest_strain: LARGEST_STRAIN,
    }
}

/// An actuator pulls like a spring up to its force, which falls with speed while it does work, and not while it is driven
/// backwards. Beyond its speed it brakes.
#[test]
fn actuators_are_limited_by_force_and_speed() {
    let law = Actuator {
        force: 0.6,
        speed: 0.5,
    };
    let total = |bar: Bar<f64>| bar.spring() + Actuator::tension(&law, bar);
    for (change, rate, force) in [
        (0.01, 0.0, 0.3),
        (0.03, 0.0, 0.6),
        (-0.03, 0.0, -0.6),
        // It shortens while it pulls, at half of its speed, and lengthens while it pushes.
        (0.03, -0.25, 0.3),
        (-0.03, 0.25, -0.3),
        // It is pulled out or pushed in against its force.
        (0.03, 0.25, 0.6),
        (-0.03, -0.25, -0.6),
        // As fast as it can move without a load, and faster, whatever its target is.
        (0.03, -0.5, 0.0),
        (0.03, -0.75, -0.3),
        (-0.03, 0.75, 0.3),
        (0.0, -0.75, -0.3),
        (-0.005, 0.75, 0.3),
        // Its target asks for more than the least brake.
        (-0.015, -0.75, -0.45),
        // Beyond twice its speed it brakes with more than its force.
        (0.03, -1.0, -0.6),
        (0.03, -2.0, -1.8),
        (-0.03, -2.0, -1.8),
        (-0.03, 2.0, 1.8),
        (0.03, 2.0, 1.8),
    ] {
        // Lengths of 0.1 m are rounded at 1e-17 and multiplied by 30 N/m.
        let bar = bar(0.1 + change, rate, 0.35);
        assert!((total(bar) - force).abs() < 1e-14, "{change} {rate}");
    }
    // A passive bar keeps its spring, and half of an actuator has half of the limit.
    assert_eq!(Actuator::tension(&law, bar(0.13, 0.0, 0.0)), 0.0);
    let half = total(bar(0.13, 0.0, 0.175));
    assert!((half - 0.5 * (0.9 + 0.6)).abs() < 1e-14, "{half}");
    // The last two are braked, one of them with more than the force.
    for [dvx, dvy] in [[-0.1, -0.1], [0.2, 0.1], [-0.5, -0.5], [1.0, 1.0]] {
        let given = [0.11, 0.09, dvx, dvy, 0.3, 30.0, 0.1, 0.35];
        let Fixed { kernel, uniforms } = tension(law.clone());
        let kernel = MovingTension(kernel);
        is_right(&Fixed { kernel, uniforms }, given);
    }
}

/// The tension that the law `actuator` adds to a bar whose length differs from its target by `change` (m), as a function of
/// the rate.
fn actuator_at<R: Real>(law: &Actuator, change: f64, rate: R) -> R {
    let bar = Bar {
        length: R::lit(0.25 + change),
        rate,
        target: R::lit(0.25),
        rest_length: R::lit(0.25),
        stiffness: R::lit(30.0),
        strain: R::lit(0.5),
        largest_strain: 0.5,
    };
    Actuator::tension(&law.constant(), bar)
}

/// An actuator at its limit has a kink at rest, and one that is driven backwards at twice its speed. Its slope there is that
/// of the constant force. Where the spring meets the line that falls with speed, it is that of the spring. The line has no kink
/// where it begins to brake.
#[test]
fn at_its_kinks_an_actuator_has_the_slope_of_the_constant_force() {
    let law = Actuator {
        force: 0.75,
        speed: 0.5,
    };
    // All these numbers are exact.
    let line = 0.75 / 0.5;
    for (change, rate, slope) in [
        (0.03, 0.0, 0.0),
        (0.03, 0.25, 0.0),
        (0.03, -0.25, line),
        (0.03, -0.5, line),
        (0.03, -1.0, line),
        (0.03, -2.0, line),
        (0.03, 1.0, 0.0),
        (0.03, 1.25, line),
        (-0.03, 0.0, 0.0),
        (-0.03, -0.25, 0.0),
        (-0.03, 0.5, line),
        (-0.03, 1.0, line),
        (-0.03, -1.0, 0.0),
        (-0.03, -1.25, line),
        (0.015625, -0.18, 0.0),
        (0.015625, -0.1875, 0.0),
        (0.015625, -0.19, line),
        (-0.015625, 0.1875, 0.0),
    ] {
        let forward = actuator_at(&law, change, Dual::<f64, 1>::variable(rate, 0)).tangent;
        let reverse = gradient(|x| actuator_at(&law, change, x[0]), &[rate]);
        assert_eq!(
            (forward, &reverse[..]),
            ([slope], &[slope][..]),
            "{change} {rate}"
        );
    }
}

#[test]
fn ropes_do_not_push() {
    let rope = Rope {
        actuator: 1.0,
        skeleton: 0.0,
    };
    for (length, force) in [(0.12, 0.6), (0.08, 0.0), (0.05, 0.0)] {
        let bar = bar(length, 0.0, 0.35);
        let total = bar.spring() + Rope::tension(&rope, bar);
        assert!((total - force).abs() < 1e-14);
    }
    // A skeleton bar is no rope.
    assert_eq!(Rope::tension(&rope, bar(0.08, 0.0, 0.0)), 0.0);
    for length in [0.12, 0.08, 0.05] {
        // Parabolas, as in the test of the stops.
        let slope =
            |energy: &dyn Fn(f64) -> f64| (energy(length + 1e-6) - energy(length - 1e-6)) / 2e-6;
        let at = |length| bar(length, 0.0, 0.35);
        let of_rope = slope(&|length| rope.energy(at(length)).unwrap());
        assert!((of_rope - Rope::tension(&rope, at(length))).abs() < 1e-8);
    }
    for [dx, dy] in [[0.03, 0.04], [0.02, 0.03]] {
        let given = [dx, dy, 0.3, 30.0, 0.1, 0.35];
        is_right(&tension(rope.clone()), given);
    }
}

/// A node near the middle of a bar, near its first end and near its last end, on either side. The contact begins at a
/// distance of 0.02 m.
const NEAR: [[f64; 6]; 4] = [
    [0.04, 0.01, 0.0, 0.0, 0.1, 0.02],
    [-0.005, 0.008, 0.0, 0.0, 0.1, 0.02],
    [0.108, 0.012, 0.0, 0.0, 0.1, 0.02],
    [0.06, 0.008, 0.0, 0.0, 0.1, 0.02],
];

fn bump() -> Fixed<Bump> {
    let law = Bumpers {
        distance: 0.2,
        ..Bumpers::default()
    };
    let kernel = Bump {
        shortest: 0.1,
        softening: SOFTENING,
        dt: DT,
    };
    Fixed {
        uniforms: values(&law),
        kernel,
    }
}

#[test]
fn bumpers() {
    for near in NEAR {
        for most in [0.025, 0.015, 1.0] {
            let [a, b, c, d, e, f] = near;
            is_right(&bump(), [a, b, c, d, e, f, 400.0, 900.0, most, 1.0, -1.0]);
        }
    }
}

/// The forces of a contact are the slope of its energy, `k depth^2 / 2`, and a node that is far enough away feels none.
#[test]
fn the_forces_of_bumpers_are_the_slope_of_the_energy() {
    // 2000 N/m, 400 N/m and 900 N/m in series.
    let stiffness = 1.0 / (1.0 / 2000.0 + 1.0 / 400.0 + 1.0 / 900.0);
    for near in NEAR {
        let energy = |x: &[f64]| {
            let [bx, by] = [x[4] - x[2], x[5] - x[3]];
            let [nx, ny] = [x[0] - x[2], x[1] - x[3]];
            let share = ((nx * bx + ny * by) / (bx * bx + by * by)).clamp(0.0, 1.0);
            let gap = (nx - bx * share).hypot(ny - by * share);
            0.5 * stiffness * (0.02 - gap).max(0.0).powi(2)
        };
        let [a, b, c, d, e, f] = near;
        let kernel = Fixed {
            kernel: Bump {
                dt: 1.0,
                ..bump().kernel
            },
            uniforms: bump().uniforms,
        };
        let at = [a, b, c, d, e, f, 400.0, 900.0, 1.0, 1.0, 1.0];
        let [ix, iy, jx, jy] = kernel.eval(at, &[]);
        let pulls = [-(ix + jx), -(iy + jy), ix, iy, jx, jy];
        for (k, pull) in pulls.into_iter().enumerate() {
            let moved = |by: f64| {
                let mut x = near;
                x[k] += by;
                energy(&x)
            };
            // Central differences over 1e-6 m: the energy is 1e-3 J, so rounding is below 1e-12 J / 1e-6 m = 1e-6 N, and
            // the third derivative, about k / (1e-2 m)^2, adds 1e-12 m^2 of it.
            let slope = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            assert!((pull + slope).abs() < 2e-6, "{pulls:?} {k} {slope}");
        }
        // The same pair, which may push only from 0.1 mm on.
        let [.., _, first, last] = at;
        let far = [a, b, c, d, e, f, 400.0, 900.0, 1e-4, first, last];
        assert_eq!(kernel.eval(far, &[]), [0.0; 4]);
    }
}
