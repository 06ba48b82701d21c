//! The part of the stable time step that the cheap bound gives away.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use crate::verify::probe::median;
use cosmic::geometry::Vector;
use cosmic::lattice::Body;
use cosmic::lattice::Lattice;
use cosmic::random::{Purpose, stream, symmetric};
use cosmic::scene::{PhysicsSettings, Scene};
use cosmic::simulator::stability::Vibration;

/// The bound on the largest frequency over that frequency, for random lattices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundRatio {
    /// The number of lattices.
    pub lattices: usize,
    /// The least ratio. Below 1 the bound would be none.
    pub least: f64,
    /// The median.
    pub median: f64,
    /// The largest.
    pub most: f64,
}

/// Measures it over so many lattices: 2 to 8 nodes each way, a random material on every edge or a
/// random mixture, bars that resist bending on every other one, nodes moved by up to a fifth of the
/// spacing off the places where the springs rest.
///
/// # Panics
/// For no lattice at all.
pub fn bound_ratio(lattices: usize) -> BoundRatio {
    let ratio = |seed: usize| {
        let mut stream = stream(seed as u64, Purpose::Verification);
        let (lattice, body, physics) = random(&mut stream);
        let moved = |&x: &Vector<f64>| x.map(|c| c + symmetric(&mut stream, 0.2 * SPACING));
        let positions: Vec<Vector<f64>> = lattice.positions.iter().map(moved).collect();
        let vibration = Vibration::new(&lattice, &body, &physics, &positions);
        vibration.edge_bound() / vibration.largest_frequency()
    };
    let mut ratios: Vec<f64> = (0..lattices).into_par_iter().map(ratio).collect();
    ratios.sort_by(f64::total_cmp);
    BoundRatio {
        lattices,
        least: ratios[0],
        median: median(ratios.iter().copied()),
        most: ratios[lattices - 1],
    }
}

/// Distance of neighbouring nodes, m.
const SPACING: f64 = 0.1;

fn random(stream: &mut ChaCha8Rng) -> (Lattice, Body<f64>, PhysicsSettings) {
    let mut scene = Scene::paper();
    scene.lattice.spacing = SPACING;
    scene.lattice.columns = stream.random_range(2..=8);
    scene.lattice.rows = stream.random_range(2..=8);
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    if stream.random() {
        scene.physics.bending_radius = stream.random_range(0.0..0.5 * SPACING);
    }
    let one_hot = stream.random::<bool>();
    let mut share = |_: &[usize; 2]| {
        if one_hot {
            let chosen = stream.random_range(0..3);
            return std::array::from_fn(|k| f64::from(u8::from(k == chosen)));
        }
        let shares: [f64; 3] = std::array::from_fn(|_| stream.random());
        let sum: f64 = shares.iter().sum();
        shares.map(|s| s / sum)
    };
    let mixture: Vec<[f64; 3]> = lattice.edges.iter().map(&mut share).collect();
    let body = Body::new(&mixture, &lattice, &scene.materials, &scene.physics);
    (lattice, body, scene.physics)
}
