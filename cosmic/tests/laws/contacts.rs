//! Tests of the built-in contact laws, also over terrain: their derivatives, compared with finite differences and dual
//! numbers.
#![allow(unreachable_pub)] // `settings!` makes public structs.

use autodiff::Real;
use autodiff::check::Verdict;
use autodiff_programs::Kernel;
use autodiff_programs::kernels::Fixed;
use cosmic::geometry::{Profile, Vector};
use cosmic::kernel;
use cosmic::laws::kernels::{Flat, Flying, Surface, Terrain};
use cosmic::laws::{Contact, Coulomb, Drift, Impact, Law, NoGround, Sticking};

use super::kernels::{DT, Drifting, adjoint, is_right, values, verdict};

fn flying<C: Contact, G: Surface>(contact: C, ground: G) -> Fixed<Flying<C, G>> {
    let drift = Drift { dt: DT };
    let decay = (-20.0 * DT).exp();
    Fixed {
        uniforms: [vec![-0.003, -0.009, decay], values(&contact)].concat(),
        kernel: Flying {
            drift,
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
        is_right(&Drifting::new(contact.clone(), Flat), [x, y, vx, vy]);
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
    let drift = |friction| Drifting::new(Coulomb { friction }, Flat);
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
    let points = points.iter().copied().map(Vector::from);
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
    Drifting::new(contact, valley()).eval(node, &[])
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
        is_right(&Drifting::new(contact.clone(), valley()), node);
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

#[kernel]
impl Contact for Bouncing {
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
    is_right(&Drifting::new(Coulomb { friction: 4.0 }, valley()), SLIDER);
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
        let cornered = Drifting::new(Coulomb::default(), valley());
        assert_eq!(cornered.eval(node, &[])[2..], [0.0, 0.0]);
        let by_node = adjoint(&cornered, node, [1.0, -0.4, 1.0, 1.0]);
        assert!(by_node.iter().all(|bar| bar.abs() < 1e-14), "{by_node:?}");
    }

    // In a wider corner, the law also responds on the second side, and the node moves on along that side.
    let wide = Drifting::new(Coulomb::default(), wide_valley());
    let [x, y, vx, vy] = wide.eval(SLIDER, &[]);
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
    let [x, y, vx, vy] = Drifting::new(Bouncing {}, wide_valley()).eval(SLIDER, &[]);
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
    let [x, _, vx, vy] =
        Drifting::new(Coulomb::default(), slope).eval([0.1005, 0.2998, 1.0, -0.9], &[]);
    // Of the velocity (1, -0.9), the component along (2, -1) / sqrt 5 remains. The points are 1e-4 apart and rounded at
    // 3e-17, so the direction between them is exact to 1e-12.
    assert!((vx - 2.0 * 2.9 / 5.0).abs() < 1e-11 && (vy + 0.5 * vx).abs() < 1e-11);
    assert!((x - (0.1005 + DT * vx)).abs() < 1e-4);
}
