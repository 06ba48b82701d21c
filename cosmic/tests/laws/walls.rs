//! Tests of contact with vertical walls: where nodes end, at walls, edges and feet, and their derivatives.

use autodiff::Dual;
use autodiff::check::Verdict;
use autodiff_programs::Kernel;
use cosmic::geometry::{Profile, Vector};
use cosmic::laws::kernels::Terrain;
use cosmic::laws::{Contact, Coulomb, Sticking};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::kernels::{DT, Drifting, adjoint, is_right, verdict};

fn drifting<C: Contact>(contact: C, points: &[[f64; 2]]) -> Drifting<C, Terrain> {
    let points = points.iter().copied().map(Vector::from).collect();
    let terrain = Terrain::new(&Profile::new(points).unwrap()).unwrap();
    Drifting::new(contact, terrain)
}

/// Level ground that rises by 0.125 m at 1 m. The numbers are exact in binary, so that rounding decides nothing.
const UP: [[f64; 2]; 2] = [[1.0, 0.0], [1.0, 0.125]];

/// The mirror image of [`UP`].
const DOWN: [[f64; 2]; 2] = [[-1.0, 0.125], [-1.0, 0.0]];

/// The node after a drift over [`UP`]. The mirror image of the node must end at the mirror image of that place.
fn after<C: Contact>(contact: C, node: [f64; 4]) -> [f64; 4] {
    let mirrored = |[x, y, vx, vy]: [f64; 4]| [-x, y, -vx, vy];
    let up = drifting(contact.clone(), &UP).eval(node, &[]);
    let down = drifting(contact, &DOWN).eval(mirrored(node), &[]);
    assert_eq!(up, mirrored(down), "{node:?}");
    up
}

/// About a millimetre: the node [`BEFORE`] reaches the wall after 2^-10 s.
const NEAR: f64 = 1.0 / 1024.0;
/// A node that runs into the wall half way up, 1 m/s fast.
const BEFORE: [f64; 4] = [1.0 - NEAR, 0.0625, 1.0, 0.5];

#[test]
fn a_wall_stops_a_node() {
    let reached = 0.0625 + 0.5 * NEAR;
    assert_eq!(after(Sticking {}, BEFORE), [1.0, reached, 0.0, 0.0]);
    // Friction takes 0.25 times the velocity into the wall from the velocity along the wall, also when the node moves
    // down.
    let [x, y, vx, vy] = after(Coulomb { friction: 0.25 }, BEFORE);
    assert_eq!([x, vx], [1.0, 0.0]);
    // The tolerances cover the rounding of friction and of the time that is left.
    assert!((vy - 0.25).abs() < 1e-15 && (y - (reached + 0.25 * (DT - NEAR))).abs() < 1e-15);
    let [x, y, vx, vy] = BEFORE;
    let down = after(Coulomb { friction: 0.25 }, [x, y, vx, -vy]);
    assert!(down[0] == 1.0 && down[2] == 0.0 && (down[3] + 0.25).abs() < 1e-15);
    // Without a wall ahead, the node moves on.
    assert_eq!(after(Sticking {}, [x, y, -vx, vy])[2..], [-vx, vy]);
}

/// A node at the wall that is pushed into it stays exactly there and slides along it. One that is pulled away leaves.
#[test]
fn a_node_leans_on_a_wall() {
    let friction = 0.25;
    let mut node = after(Sticking {}, BEFORE);
    for _ in 0..40 {
        (node[2], node[3]) = (0.3, -0.5);
        node = after(Coulomb { friction }, node);
        assert_eq!([node[0], node[2]], [1.0, 0.0]);
        // The tolerance covers the rounding of friction.
        assert!((node[3] - (-0.5 + 0.25 * 0.3)).abs() < 1e-15);
    }
    (node[2], node[3]) = (-0.3, 0.1);
    let left = after(Coulomb { friction }, node);
    assert!(left[0] < 1.0 && left[2..] == [-0.3, 0.1]);
}

/// A node at a wall slides down to its foot, and does not hang on the ground behind the wall.
#[test]
fn a_node_slides_down_a_wall() {
    let mut node = [1.0, 0.0625, 0.0, 0.0];
    // The node reaches the foot up to one rounding of numbers below 0.1.
    while node[1] > 1e-16 {
        node[3] -= 9.81 * DT;
        let before = node;
        node = after(Coulomb { friction: 0.5 }, before);
        assert!(node[0] == 1.0 && node[1] < before[1]);
    }
    assert!(node[1] > -1e-16 && [node[0], node[2], node[3]] == [1.0, 0.0, 0.0]);
}

/// The edge belongs to the ground behind it for a node that passes it, and to nothing for a node above it: exactly above
/// the edge, a node falls along the wall.
#[test]
fn edges() {
    let [edge, x] = [0.125, 1.0 - NEAR];
    assert_eq!(
        after(Sticking {}, [x, edge, 1.0, 0.0])[1..],
        [edge, 1.0, 0.0]
    );
    let below = edge - 1e-15;
    assert_eq!(
        after(Sticking {}, [x, below, 1.0, 0.0]),
        [1.0, below, 0.0, 0.0]
    );
    // The node reaches the edge exactly while it sinks, and lands on the ground behind it.
    let landed = after(Sticking {}, [x, edge + 0.5 * NEAR, 1.0, -0.5]);
    assert_eq!(landed, [1.0, edge, 0.0, 0.0]);
    // A node that leaves over the edge passes the corner too.
    let leaves = [1.0 + NEAR, edge + 0.5 * NEAR, -1.0, -0.5];
    assert_eq!(after(Sticking {}, leaves)[2..], [-1.0, -0.5]);
    for y in [edge + 1e-3, edge] {
        let fallen = after(Sticking {}, [1.0, y, 0.0, -1.0]);
        assert_eq!(fallen, [1.0, y - DT, 0.0, -1.0], "{y}");
    }
}

/// Behind a wall by a rounding error, a node touches the wall. Deeper inside the ground, it is below the ground there.
#[test]
fn nodes_behind_a_wall() {
    for behind in [1e-16, 1e-9, 5e-7] {
        let slid = after(Sticking {}, [1.0 + behind, 0.0625, 0.0, -0.5]);
        assert_eq!(slid, [1.0, 0.0625 - 0.5 * DT, 0.0, -0.5]);
        let held = after(Sticking {}, [1.0 + behind, 0.0625, 0.5, 0.0]);
        assert_eq!(held, [1.0, 0.0625, 0.0, 0.0]);
        // A node that stands near the edge is not at the wall.
        let stands = after(Sticking {}, [1.0 + 5e-7, 0.125 - 1e-12, 0.0, -0.5]);
        assert_eq!(stands, [1.0 + 5e-7, 0.125 - 1e-12, 0.0, 0.0]);
    }
    let inside = [1.01, 0.0625, 0.0, -0.5];
    assert_eq!(after(Sticking {}, inside), [1.01, 0.0625, 0.0, 0.0]);
    let out = after(Sticking {}, [1.0 + NEAR, 0.0625, -1.0, 0.0]);
    assert!(out[0] < 1.0 && out[2..] == [-1.0, 0.0]);
}

/// A node that slides along the ground to the foot of a wall stops there, and so does one that falls along the wall.
#[test]
fn the_foot_of_a_wall() {
    let law = Coulomb { friction: 0.125 };
    let slides = after(law.clone(), [1.0 - NEAR, 0.0, 1.0, -0.5]);
    assert_eq!(slides, [1.0, 0.0, 0.0, 0.0]);
    let both = after(law, [1.0 - 0.5 * NEAR, 0.5 * NEAR, 1.0, -1.0]);
    assert_eq!(both, [1.0, 0.0, 0.0, 0.0]);
}

/// Nodes over [`UP`]: free in front of the wall and above it; into the wall, upwards and downwards; over the edge, onto
/// the ground behind it; into the foot, along the ground and from above; from the top back over the edge.
const WALKERS: [[f64; 4]; 8] = [
    [0.99, 0.05, 0.5, 0.3],
    [0.9995, 0.2, 0.7, 0.3],
    [0.9993, 0.05, 0.9, 0.8],
    [0.9993, 0.05, 0.9, -0.8],
    [0.9996, 0.1255, 0.8, -0.7],
    [0.9993, 0.0003, 0.9, -0.8],
    [0.9993, 0.0009, 0.9, -0.8],
    [1.0005, 0.1253, -0.9, -0.4],
];

#[test]
fn derivatives_at_walls() {
    let (mut moving, mut in_foot) = (0, 0);
    let mut check = |drift: Drifting<Coulomb, Terrain>, node: [f64; 4]| {
        let [x, y, vx, vy] = drift.eval(node, &[]);
        // The height of the foot has a rounding error.
        if y.abs() < 1e-12 && [x.abs(), vx, vy] == [1.0, 0.0, 0.0] {
            // A node that ends in the foot has no slope. Sines and cosines of walls are rounded.
            for bar in 0..4 {
                let weights = std::array::from_fn(|k| f64::from(u8::from(k == bar)));
                let by = adjoint(&drift, node, weights);
                assert!(by.iter().all(|slope| slope.abs() < 1e-12), "{by:?}");
            }
            in_foot += 1;
        } else {
            is_right(&drift, node);
            moving += 1;
        }
    };
    for node in WALKERS {
        is_right(&drifting(Sticking {}, &UP), node);
        for friction in [0.1, 0.3, 2.5, 0.0] {
            check(drifting(Coulomb { friction }, &UP), node);
            let [x, y, vx, vy] = node;
            check(drifting(Coulomb { friction }, &DOWN), [-x, y, -vx, vy]);
        }
    }
    assert!(moving > 40 && in_foot > 3, "{moving} {in_foot}");
}

/// The conventions at the kinks of a wall; [docs/method.md](../../../docs/method.md) lists them.
#[test]
fn kinks_at_walls() {
    let drift = drifting(Sticking {}, &UP);
    let forward = |node: [f64; 4], k: usize| {
        let seed = |i: usize| Dual {
            value: node[i],
            tangent: [f64::from(u8::from(i == k))],
        };
        let moved = drift.eval::<Dual<f64, 1>>(std::array::from_fn(seed), &[]);
        moved.map(|number| number.tangent[0])
    };
    // The rows are: leaning on the wall, where the time of impact is clamped to 0; in line with the wall, which is free;
    // and exactly to the edge, over the ground behind it.
    for (node, by_x, by_vx) in [
        ([1.0, 0.0625, 0.5, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0; 4]),
        (
            [1.0, 0.0625, 0.0, -0.5],
            [1.0, 0.0, 0.0, 0.0],
            [DT, 0.0, 1.0, 0.0],
        ),
        (
            [1.0 - NEAR, 0.125, 1.0, 0.0],
            [1.0, 0.0, 0.0, 0.0],
            [DT, 0.0, 1.0, 0.0],
        ),
    ] {
        assert_eq!(
            [forward(node, 0), forward(node, 2)],
            [by_x, by_vx],
            "{node:?}"
        );
        for bar in 0..4 {
            let weights = std::array::from_fn(|k| f64::from(u8::from(k == bar)));
            let by = adjoint(&drift, node, weights);
            assert_eq!([by[0], by[2]], [by_x[bar], by_vx[bar]], "{node:?}, {bar}");
        }
    }
    // A wrong gradient at a wall is noticed.
    assert_eq!(verdict(&drift, WALKERS[2], 0.1), Verdict::Wrong);
}

/// A wall acts like the limit of steep slopes: over random walls, nodes end where a slope of 1e-9 m would leave them.
#[test]
fn a_wall_is_the_limit_of_steep_slopes() {
    const WIDTH: f64 = 1e-9;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut met, mut passed) = (0, 0);
    for round in 0..4000 {
        let edge: f64 = rng.random_range(0.001..0.1);
        // The slope begins at the wall of the foot, on either side.
        let (wall, slope) = if round % 2 == 0 {
            ([[1.0, 0.0], [1.0, edge]], [[1.0, 0.0], [1.0 + WIDTH, edge]])
        } else {
            ([[1.0, edge], [1.0, 0.0]], [[1.0 - WIDTH, edge], [1.0, 0.0]])
        };
        let high = if rng.random_bool(0.5) {
            0.003
        } else {
            edge + 0.001
        };
        let node = [
            1.0 + rng.random_range(-0.003..0.003),
            rng.random_range(0.0..high),
            rng.random_range(-2.0..2.0),
            rng.random_range(-2.0..2.0),
        ];
        let behind = if round % 2 == 0 {
            node[0] - 1.0
        } else {
            1.0 - node[0]
        };
        if (0.0..1e-6).contains(&behind) {
            // Such a node counts as touching the wall, but is deep in the ground behind the slope.
            continue;
        }
        let law = Coulomb { friction: 0.3 };
        let at_wall = drifting(law.clone(), &wall).eval(node, &[]);
        let on_slope = drifting(law, &slope).eval(node, &[]);
        let off = (0..4).map(|k| (at_wall[k] - on_slope[k]).abs());
        // The slope is turned by at most 1e-6, because its height is at least 1 mm, and speeds are at most 2 m/s.
        assert!(
            off.fold(0.0, f64::max) < 1e-5,
            "{round}: {node:?} {at_wall:?} {on_slope:?}"
        );
        let is_met = at_wall[0] == 1.0;
        (met, passed) = (met + usize::from(is_met), passed + usize::from(!is_met));
    }
    assert!(met > 400 && passed > 400, "{met} {passed}");
}

/// However thin a pillar and however fast a node, the node does not pass through.
#[test]
fn a_thin_pillar_stops_a_fast_node() {
    for width in [1e-3, 1e-9, 1e-15] {
        let pillar = [
            [0.5, 0.0],
            [0.5, 0.2],
            [0.5 + width, 0.2],
            [0.5 + width, 0.0],
        ];
        let node = [0.1, 0.1, 400.0, 0.0];
        assert_eq!(drifting(Sticking {}, &pillar).eval(node, &[])[0], 0.5);
        let back = drifting(Sticking {}, &pillar).eval([0.9, 0.1, -400.0, 0.0], &[]);
        assert_eq!(back[0], 0.5 + width);
    }
}
