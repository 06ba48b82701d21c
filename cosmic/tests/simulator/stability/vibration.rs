use crate::small::lattice;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Body, Lattice, Marker};
use cosmic::scene::{LatticeKind, LatticeSettings, MaterialSettings, PhysicsSettings, stable_step};
use cosmic::simulator::stability::Vibration;
use nalgebra::{DMatrix, DVector};

/// The largest frequency, 1/s, from all eigenvalues of the dense matrix.
fn of_dense_matrix(vibration: &Vibration, body: &Body<f64>, dimension: Dimension) -> f64 {
    let root: Vec<f64> = body.mass.iter().map(|m| m.sqrt().recip()).collect();
    let size = dimension.count() * root.len();
    let unit = |column: usize| DVector::from_fn(size, |row, _| f64::from(u8::from(row == column)));
    let columns: Vec<_> = (0..size)
        .map(|k| vibration.product(&unit(k), &root))
        .collect();
    let matrix = DMatrix::from_columns(&columns);
    matrix.symmetric_eigenvalues().max().max(0.0).sqrt()
}

/// The largest frequency agrees with a dense eigenvalue solver, also for layouts with two nearly equal frequencies.
#[test]
fn the_largest_frequency_is_found_among_close_ones() {
    let cubes = LatticeSettings {
        kind: LatticeKind::Cubic,
        columns: 3,
        depth: 2,
        rows: 2,
        ..LatticeSettings::default()
    };
    let physics = PhysicsSettings::default();
    assert_found(&lattice(4, 3, 0.0), 2000);
    assert_found(&Lattice::new(&cubes, &physics), 300);
}

fn assert_found(lattice: &Lattice, layouts: usize) {
    let physics = PhysicsSettings::default();
    let mut worst: f64 = 0.0;
    for layout in 0..layouts {
        let material = |e: usize| Material::ALL[(layout * (e * e + 7 * e + 3) / 5 + e) % 3];
        let design = Design::Layout((0..lattice.edges.len()).map(material).collect());
        let body = Body::new(&design, lattice, &MaterialSettings::default(), &physics);
        let vibration = Vibration::new(lattice, &body, &physics, &lattice.positions);
        let expected = of_dense_matrix(&vibration, &body, lattice.dimension);
        let off = vibration.fastest().0 / expected - 1.0;
        // The stable step follows from a bound that is never below the largest frequency.
        let step = |frequency| stable_step(&physics, frequency, 0.0);
        assert!(step(vibration.edge_bound().0) <= step(expected) * (1.0 + 1e-9));
        worst = if off.abs() > worst.abs() { off } else { worst };
    }
    assert!(worst.abs() < 1e-9, "relative error {worst:e}");
}

/// Of two separate springs, the stiffer one determines the frequency, even if it is stiffer by a tiny fraction
/// only.
#[test]
fn the_largest_of_two_nearly_equal_frequencies_is_found() {
    let positions = [[0.0, 0.0], [1.0, 0.0], [0.0, 5.0], [0.0, 6.0]];
    let positions = positions.map(Vector::from).to_vec();
    let lattice = Lattice::between(positions, vec![[0, 1], [2, 3]]);
    for excess in [1e-6, 1e-7, 3e-8, 1e-8, 1e-9, 0.0] {
        let body = Body {
            stiffness: vec![50.0, 50.0 * (1.0 + excess)],
            strain: vec![0.0; 2],
            largest_strain: 1.0,
            rest_length: Vec::new(),
            mass: vec![0.01; 4],
            presence: Vec::new(),
            marker: Marker::default(),
        };
        let physics = PhysicsSettings::default();
        let vibration = Vibration::new(&lattice, &body, &physics, &lattice.positions);
        let off = vibration.fastest().0 / (1e4 * (1.0 + excess)).sqrt() - 1.0;
        // The softening of 10 micrometres changes a length of 1 m by a fraction of 5e-11.
        assert!(
            off.abs() < 1e-10,
            "off by {off:e} with an excess of {excess:e}"
        );
    }
}
