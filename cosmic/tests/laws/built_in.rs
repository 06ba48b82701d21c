//! Tests of the built-in laws: their derivatives, compared with finite differences and dual numbers, and contact over
//! terrain.
#![allow(unreachable_pub)] // `settings!` makes public structs.

use autodiff::arrays::Fixed;
use autodiff::check::{Along, Claim, Options, Verdict, check_directions};
use autodiff::{Dual, Function, Kernel, Pullback, Real, gradient};
use cosmic::geometry::{Profile, Vector};
use cosmic::laws::{
    Actuator, Bar, BarForce, Bend, Buckle, Bump, Bumpers, Contact, Coulomb, Damper, Drift,
    Drifting, Flat, Flight, Flying, Hooke, Impact, Law, MovingTension, NoGround, Rope, Sticking,
    Stiffening, Stops, Tension, Terrain, Underfoot,
};

const DT: f64 = 0.002;
/// The softening of lengths, m^2.
const SOFTENING: f64 = 1e-12;

/// Computes the cotangents of a kernel's inputs at `x` from the cotangents `y_bar` of its outputs.
fn adjoint<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    x: [f64; I],
    y_bar: [f64; O],
) -> [f64; I] {
    let [x_bar] = kernel.vjp(Pullback::new(kernel, x, [y_bar]));
    x_bar
}

/// Compares the adjoint of a kernel with dual numbers and finite differences, for a fixed cotangent. The adjoint is
/// multiplied by `1 + wrong_by`: with `wrong_by` not 0, a test can check that the comparison notices a wrong adjoint.
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
    let gradient = adjoint(kernel, x, y_bar).map(|bar| bar * (1.0 + wrong_by));
    // A wrong gradient must be noticed by the finite differences alone.
    let forward: Option<Along> = (wrong_by == 0.0).then_some(&forward);
    let claim = Claim {
        x: &x,
        gradient: &gradient,
        forward,
    };
    // The check needs many directions, because slopes differ by factors of thousands: an impulse is divided by a mass
    // of grams. The step sizes must be small compared to the time of impact.
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

/// The values of a law's settings.
fn values(law: &impl Law) -> Vec<f64> {
    law.inputs().into_iter().map(|(_, value)| value).collect()
}

fn tension<L: BarForce>(law: L) -> Fixed<Tension<L>> {
    Fixed {
        uniforms: values(&law),
        kernel: Tension {
            law,
            dt: DT,
            softening: SOFTENING,
        },
    }
}

#[test]
fn springs() {
    // The spring is stretched, compressed, at its target length, and very short.
    for [dx, dy] in [[0.08, 0.09], [-0.05, 0.02], [0.0, 0.1], [2e-3, 1e-3]] {
        let given = [dx, dy, 0.3, 4.0, 0.1, 0.35];
        is_right(&tension(Hooke {}), given);
        is_right(&tension(Stiffening { cubic: 150.0 }), given);
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
            assert_eq!(tension.eval(given), [0.0; 2]);
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
    }
}

/// An actuator pulls like a spring up to its force, which falls with speed while it does work, and not while it is driven
/// backwards.
#[test]
fn actuators_are_limited_by_force_and_speed() {
    let law = Actuator {
        force: 0.6,
        speed: 0.5,
        strain: 0.35,
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
        // Faster than it can move without a load.
        (0.03, -0.6, 0.0),
    ] {
        // Lengths of 0.1 m are rounded at 1e-17 and multiplied by 30 N/m.
        let bar = bar(0.1 + change, rate, 0.35);
        assert!((total(bar) - force).abs() < 1e-14, "{change} {rate}");
    }
    // A passive bar keeps its spring, and half of an actuator has half of the limit.
    assert_eq!(Actuator::tension(&law, bar(0.13, 0.0, 0.0)), 0.0);
    let half = total(bar(0.13, 0.0, 0.175));
    assert!((half - 0.5 * (0.9 + 0.6)).abs() < 1e-14, "{half}");
    for [dvx, dvy] in [[-0.1, -0.1], [0.2, 0.1]] {
        let given = [0.11, 0.09, dvx, dvy, 0.3, 30.0, 0.1, 0.35];
        let Fixed { kernel, uniforms } = tension(law.clone());
        let kernel = MovingTension(kernel);
        is_right(&Fixed { kernel, uniforms }, given);
    }
}

/// Ropes do not push, and buckled bars push with their Euler load.
#[test]
fn ropes_and_buckled_bars() {
    let rope = Rope {
        actuator: 1.0,
        skeleton: 0.0,
        strain: 0.35,
    };
    let buckle = Buckle { bending: 1e-3 };
    let load = std::f64::consts::PI.powi(2) * 1e-3 / 0.01;
    // With 30 N/m, the Euler load compresses the bar by 0.033 m.
    for (length, of_rope, of_buckle) in [(0.12, 0.6, 0.6), (0.08, 0.0, -0.6), (0.05, 0.0, -load)] {
        let bar = bar(length, 0.0, 0.35);
        let total = |tension: f64| bar.spring() + tension;
        assert!((total(Rope::tension(&rope, bar)) - of_rope).abs() < 1e-14);
        assert!((total(Buckle::tension(&buckle, bar)) - of_buckle).abs() < 1e-14);
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
        let of_buckle = slope(&|length| buckle.energy(at(length)).unwrap());
        assert!((of_buckle - Buckle::tension(&buckle, at(length))).abs() < 1e-8);
    }
    for [dx, dy] in [[0.03, 0.04], [0.02, 0.03]] {
        let given = [dx, dy, 0.3, 30.0, 0.1, 0.35];
        is_right(&tension(rope.clone()), given);
        is_right(&tension(buckle.clone()), given);
    }
}

/// Positions of three nodes over which two edges lie in line, turn a little, form a right angle, fold back, and have
/// different lengths.
const TURNS: [[f64; 6]; 5] = [
    [0.0, 0.0, 0.1, 0.0, 0.2, 0.0],
    [0.0, 0.0, 0.1, 0.01, 0.2, 0.0],
    [0.0, 0.0, 0.1, 0.0, 0.1, 0.1],
    [0.0, 0.0, 0.1, 0.0, 0.01, 0.005],
    [0.3, 0.2, 0.1, 0.1, -0.4, 0.3],
];

const BEND: Bend = Bend {
    section: 2e-4,
    softening: SOFTENING,
    dt: DT,
};

#[test]
fn bending() {
    // The first entry, in line, is left out: there every slope that `verdict` compares is 0, so a wrong gradient could
    // not be noticed.
    for [a, b, c, d, e, f] in TURNS[1..].iter().copied() {
        is_right(&BEND, [a, b, c, d, e, f, 400.0, 300.0]);
    }
}

/// The energy of the angular spring, as a function of the coordinates of the three nodes.
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
fn the_forces_of_bending_are_the_slope_of_the_energy() {
    for nodes in TURNS {
        let [a, b, c, d, e, f] = nodes;
        let bend = Bend { dt: 1.0, ..BEND };
        // Two edges of 400 N/m have an angular stiffness of 0.04 N m.
        let pulls = bend.eval([a, b, c, d, e, f, 400.0, 400.0]);
        let slope = gradient(|x| Energy.eval(x), &nodes);
        for (pull, slope) in pulls.iter().zip(slope) {
            // The softening changes a length of 0.1 m by a fraction of 5e-11, and the forces are below 1 N.
            assert!((pull + slope).abs() < 1e-9, "{pulls:?}");
        }
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
        let [ix, iy, jx, jy] = kernel.eval(at);
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
        assert_eq!(kernel.eval(far), [0.0; 4]);
    }
}

fn flying<C: Contact, G: Underfoot>(contact: C, ground: G) -> Fixed<Flying<C, G>> {
    let drift = Drift { dt: DT };
    let decay = (-20.0 * DT).exp();
    Fixed {
        uniforms: [vec![-0.003, -0.009], values(&contact)].concat(),
        kernel: Flying {
            flight: Flight { drift, decay },
            contact,
            ground,
        },
    }
}

fn drifting<C: Contact, G: Underfoot>(contact: C, ground: G) -> Fixed<Drifting<C, G>> {
    Fixed {
        uniforms: values(&contact),
        kernel: Drifting {
            drift: Drift { dt: DT },
            contact,
            ground,
        },
    }
}

/// Nodes `[x, y, vx, vy, jx, jy, 1 / m]` with the impulse `[jx, jy]`. The first stays above the ground, the second
/// touches it within the step, and the third is below the ground and leaves it.
const NODES: [[f64; 7]; 3] = [
    [0.3, 0.2, 0.4, -0.5, 1e-3, 2e-3, 40.0],
    [0.3, 1e-3, 0.4, -0.9, 1e-3, -2e-3, 40.0],
    [0.3, -2e-3, 0.4, 0.9, 1e-3, 2e-3, 40.0],
];

/// Checks the adjoints of steps and drifts under a contact law, for all of [`NODES`].
fn contact_is_right<C: Contact>(contact: C) {
    for node in NODES {
        is_right(&flying(contact.clone(), Flat), node);
        let [x, y, vx, vy, ..] = node;
        is_right(&drifting(contact.clone(), Flat), [x, y, vx, vy]);
    }
}

#[test]
fn contacts() {
    contact_is_right(NoGround {});
    contact_is_right(Sticking {});
    // With these coefficients of friction, the node slides on, stops, and slides without friction.
    for friction in [0.2, 2.5, 0.0] {
        contact_is_right(Coulomb { friction });
    }
}

/// For a node at rest, the derivative of the new velocity with respect to the old one is 0 with friction, which holds
/// the node (D9), and 1 without friction.
#[test]
fn coulomb_friction_at_rest() {
    let resting = [0.3, 1e-3, 0.0, -0.9];
    let drift = |friction| drifting(Coulomb { friction }, Flat);
    is_right(&drift(0.2), resting);
    is_right(&drift(0.0), resting);
    let by_velocity = |friction| adjoint(&drift(friction), resting, [0.0, 0.0, 1.0, 0.0])[2];
    assert_eq!([0.2, 0.0].map(by_velocity), [0.0, 1.0]);
}

/// A node below the ground that moves inward stops where it is: the time of impact is clamped to 0 and passes no
/// derivative (D9).
#[test]
fn a_buried_node_keeps_its_place() {
    let buried = [0.3, -1e-3, 0.4, -0.5, 0.0, 0.0, 40.0];
    let by_place = adjoint(&flying(Sticking {}, Flat), buried, [0.7, 1.0, 5.0, 5.0]);
    assert_eq!(by_place, [0.7, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(
        verdict(&flying(Sticking {}, Flat), buried, 0.0),
        Verdict::Smooth
    );
}

fn terrain(points: &[[f64; 2]]) -> Terrain {
    let points = points.iter().copied().map(Vector::new);
    Terrain::new(&Profile::new(points.collect()).unwrap()).unwrap()
}

/// Terrain that goes down, steeply up, and down again: a ridge at 0.2 m, a valley of 80 degrees at 0.5 m and a spike at
/// 0.6 m.
fn valley() -> Terrain {
    terrain(&[[0.2, 0.3], [0.5, 0.0], [0.6, 0.6], [0.7, 0.1]])
}

/// Terrain that begins with the same slope down as [`valley`]. After an obtuse corner, the ground rises by 1 in 4.
fn wide_valley() -> Terrain {
    terrain(&[[0.2, 0.3], [0.5, 0.0], [0.9, 0.1]])
}

/// Returns the node `[x, y, vx, vy]` after a drift over [`valley`].
fn over_valley<C: Contact>(contact: C, node: [f64; 4]) -> [f64; 4] {
    drifting(contact, valley()).eval(node)
}

/// The height of a node above the line through the slope that leads down into the valley, m.
fn above_slope([x, y, ..]: [f64; 4]) -> f64 {
    (x + y - 0.5) / 2f64.sqrt()
}

/// Nodes `[x, y, vx, vy]` above or on [`valley`]. The first stays above the slope that leads down. Three meet this
/// slope, one of them from beyond the ridge and one while it moves backwards. One slides across the ridge and flies on.
/// One starts inside the ground and leaves it. One falls down the steep side of the valley.
const WALKERS: [[f64; 4]; 7] = [
    [0.35, 0.2, 0.4, -0.5],
    [0.35, 0.1505, 0.4, -0.9],
    [0.1998, 0.3005, 0.5, -0.9],
    [0.35, 0.1505, -0.7, -0.3],
    [0.1999, 0.3001, 0.8, -0.2],
    [0.3, 0.1, 0.3, 0.6],
    [0.503, 0.0185, -0.1, -1.5],
];

/// A node that meets the slope just before the corner of the valley. It slides into the corner unless friction stops
/// it.
const SLIDER: [f64; 4] = [0.4996, 0.0005, 0.5, -0.9];

/// Checks the adjoints of steps and drifts over the valley, for all of [`WALKERS`].
fn contact_over_terrain_is_right<C: Contact>(contact: C) {
    for node in WALKERS {
        is_right(&drifting(contact.clone(), valley()), node);
        let [x, y, vx, vy] = node;
        let pushed = [x, y, vx, vy, 1e-3, -1e-3, 40.0];
        is_right(&flying(contact.clone(), valley()), pushed);
    }
}

cosmic::settings! {
    /// A contact law as a user would write it: a node leaves the ground with half of the speed at which it met the
    /// ground.
    struct Bouncing {}
}

impl Law for Bouncing {
    const NAME: &'static str = "bouncing";
}

impl Contact for Bouncing {
    #[inline(always)]
    fn respond<R: Real, const D: usize>(_: &Self, impact: Impact<R, D>) -> Vector<R, D> {
        let velocity = impact.velocity;
        velocity.with_up(R::lit(-0.5) * velocity.up())
    }
}

#[test]
fn contacts_over_terrain() {
    contact_over_terrain_is_right(Sticking {});
    contact_over_terrain_is_right(Bouncing {});
    for friction in [0.1, 0.3, 2.5] {
        contact_over_terrain_is_right(Coulomb { friction });
    }
    is_right(&drifting(Coulomb { friction: 4.0 }, valley()), SLIDER);
}

#[test]
fn a_law_responds_along_the_segment_that_is_met() {
    // Without friction, the part of the velocity (0.4, -0.9) along the slope of 45 degrees remains.
    let [x, y, vx, vy] = over_valley(Coulomb::default(), WALKERS[1]);
    let along = (0.4 + 0.9) / 2f64.sqrt();
    // The tolerance covers a few roundings of numbers below 1.
    assert!((vx - along / 2f64.sqrt()).abs() < 1e-15 && (vx + vy).abs() < 1e-15);
    assert!(above_slope([x, y, vx, vy]).abs() < 1e-15);
    // The node starts 0.0005 m above the slope and approaches it at 0.5 m/s.
    let falling = 0.0005 / 0.5;
    assert!((x - (0.35 + 0.4 * falling + vx * (DT - falling))).abs() < 1e-15);
    let stopped = over_valley(Sticking {}, WALKERS[1]);
    assert!(stopped[2..] == [0.0, 0.0] && above_slope(stopped).abs() < 1e-15);
}

/// A node that slides down to the valley meets the steep side within the same step. The corner is sharper than 90
/// degrees. The part of the velocity along the steep side leads back into the slope, so the node stops in the corner.
#[test]
fn a_second_impact_within_a_step() {
    let [x, y, vx, vy] = over_valley(Coulomb::default(), SLIDER);
    assert_eq!([vx, vy], [0.0, 0.0]);
    // The tolerance covers roundings of numbers below 1, divided by the sine of the angle between the slopes.
    assert!((x - 0.5).abs() < 1e-14 && y.abs() < 1e-14, "{x} {y}");
    // A node that comes down the steep side stops in the corner too.
    for node in [SLIDER, [0.5003, 0.0022, -0.1, -1.5]] {
        let cornered = drifting(Coulomb::default(), valley());
        assert_eq!(cornered.eval(node)[2..], [0.0, 0.0]);
        let by_node = adjoint(&cornered, node, [1.0, -0.4, 1.0, 1.0]);
        assert!(by_node.iter().all(|bar| bar.abs() < 1e-14), "{by_node:?}");
    }

    // In a wider corner, the law also responds on the second side, and the node moves on along that side.
    let wide = drifting(Coulomb::default(), wide_valley());
    let [x, y, vx, vy] = wide.eval(SLIDER);
    assert!(x > 0.5 && (y - 0.25 * (x - 0.5)).abs() < 1e-15);
    // The node slides down with the velocity (0.7, -0.7). After the corner, the component along (4, 1) / sqrt 17
    // remains.
    let left = 0.7 * 3.0 / 17f64.sqrt();
    assert!((vx - left * 4.0 / 17f64.sqrt()).abs() < 1e-15 && (vy - vx / 4.0).abs() < 1e-15);
    is_right(&wide, SLIDER);
}

/// A node that bounces off one side of a valley also bounces off the other side.
#[test]
fn a_user_s_law_responds_at_every_impact() {
    let [x, y, vx, vy] = drifting(Bouncing {}, wide_valley()).eval(SLIDER);
    // The velocity (0.5, -0.9) is (0.7, -0.7) along the slope plus (-0.2, -0.2) into it. Half of the second part is
    // reflected, which gives (0.8, -0.6). On the other side, this is 2.6 / 17 (4, 1) along the side and -3.2 / 17 (-1,
    // 4) into it.
    let second = [(4.0 * 2.6 - 1.6) / 17.0, (2.6 + 4.0 * 1.6) / 17.0];
    // The tolerance covers a few roundings of numbers below 10.
    assert!((vx - second[0]).abs() < 1e-14 && (vy - second[1]).abs() < 1e-14);
    assert!(x > 0.5 && y > 0.25 * (x - 0.5));
}

/// On the right of the spike, a node can be below the line through the left side of the spike and still be above the
/// ground.
#[test]
fn segments_end_at_their_corners() {
    let node = [0.605, 0.6, 0.3, -0.4];
    let free = over_valley(Sticking {}, node);
    assert_eq!(free[2..], node[2..]);
    // A node that comes from the left meets the spike, however thin the spike is.
    let caught = over_valley(Sticking {}, [0.5999, 0.59945, 0.9, 0.0]);
    assert_eq!(caught[2..], [0.0, 0.0]);
}

/// Points on a straight line are no corners: a node slides across many of them in one step.
#[test]
fn points_on_a_line_are_no_corners() {
    let points = (0..40).map(|k| [0.1 + 1e-4 * f64::from(k), 0.3 - 0.5e-4 * f64::from(k)]);
    let slope = terrain(&points.collect::<Vec<_>>());
    let [x, _, vx, vy] = drifting(Coulomb::default(), slope).eval([0.1005, 0.2998, 1.0, -0.9]);
    // Of the velocity (1, -0.9), the component along (2, -1) / sqrt 5 remains. The points are 1e-4 apart and rounded at
    // 3e-17, so the direction between them is exact to 1e-12.
    assert!((vx - 2.0 * 2.9 / 5.0).abs() < 1e-11 && (vy + 0.5 * vx).abs() < 1e-11);
    assert!((x - (0.1005 + DT * vx)).abs() < 1e-4);
}
