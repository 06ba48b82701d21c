use crate::small::lattice;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Body, Lattice, Marker};
use cosmic::scene::{
    Integrator, LatticeKind, LatticeSettings, MaterialSettings, PhysicsSettings, stable_step,
};
use cosmic::world::StepLimit;
use cosmic::world::stability::Vibration;
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
        // The bound of large lattices. The square of a frequency is above by at most a thousandth.
        let bound = vibration.fastest_within(1e-3).0 / expected - 1.0;
        assert!((-1e-9..=5e-4).contains(&bound), "relative error {bound:e}");
        // The stable step follows from a bound that is never below the largest frequency.
        let step = |frequency| stable_step(&physics, frequency, 0.0);
        assert!(step(vibration.edge_bound().0) <= step(expected) * (1.0 + 1e-9));
        worst = if off.abs() > worst.abs() { off } else { worst };
    }
    assert!(worst.abs() < 1e-9, "relative error {worst:e}");
}

/// In a large lattice the bound is at most a thousandth above the largest frequency, and never below it.
#[test]
fn the_frequency_of_a_large_lattice_is_a_bound() {
    let lattice = lattice(40, 26, 0.0);
    assert!(lattice.nodes() > 1000);
    let physics = PhysicsSettings::default();
    let design = Design::Layout(vec![Material::Skeleton; lattice.edges.len()]);
    let body = Body::new(&design, &lattice, &MaterialSettings::default(), &physics);
    let vibration = Vibration::new(&lattice, &body, &physics, &lattice.positions);
    let (bound, _) = vibration.fastest();
    let (exact, _) = vibration.fastest_within(1e-12);
    assert!((1.0..1.001).contains(&(bound / exact)), "{bound} {exact}");
    assert!(bound <= vibration.edge_bound().0);
}

/// The stable step of a robot in space follows from the largest eigenvalue of `M^-1 K`, whose entries come from the bars here,
/// also while the bars are strained.
#[test]
fn the_stable_step_of_a_cube_is_that_of_a_dense_eigenvalue_solver() {
    let mut settings = LatticeSettings {
        kind: LatticeKind::Cubic,
        columns: 3,
        depth: 3,
        rows: 2,
        ..LatticeSettings::default()
    };
    for (k, body_diagonals) in [false, true].into_iter().enumerate() {
        settings.body_diagonals = body_diagonals;
        let physics = PhysicsSettings {
            damping: 0.0,
            ..PhysicsSettings::default()
        };
        let lattice = Lattice::new(&settings, &physics);
        let material = |edge: usize| Material::ALL[(edge * edge + edge / 3 + k) % 3];
        let design = Design::Layout((0..lattice.edges.len()).map(material).collect());
        let body = Body::new(&design, &lattice, &MaterialSettings::default(), &physics);
        let moved = |(node, &x): (usize, &Vector<f64>)| {
            let turn = |by: f64| 0.01 * (by * node as f64).sin();
            x + Vector::new([turn(1.1), turn(2.3), turn(3.7)])
        };
        let positions: Vec<_> = lattice.positions.iter().enumerate().map(moved).collect();
        let mut matrix = DMatrix::<f64>::zeros(3 * body.mass.len(), 3 * body.mass.len());
        for (edge, &[i, j]) in lattice.edges.iter().enumerate() {
            let d = DVector::from_row_slice(&(positions[j] - positions[i]).array());
            let across = 1.0 - lattice.rest_length[edge] / d.norm();
            let n = d.normalize();
            let block = (&n * n.transpose()) * (1.0 - across) + DMatrix::identity(3, 3) * across;
            let block = block * body.stiffness[edge];
            for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                let mut part = matrix.view_mut((3 * a, 3 * b), (3, 3));
                let share: f64 = sign / f64::sqrt(body.mass[a] * body.mass[b]);
                part += &block * share;
            }
        }
        let expected = matrix.symmetric_eigenvalues().max().sqrt();
        let vibration = Vibration::new(&lattice, &body, &physics, &positions);
        let limit = StepLimit::exact(&vibration, &physics);
        // An explicit step is stable below `2 / omega`. The softening of a micrometre changes lengths by a fraction of 1e-10.
        assert!(
            (limit.step() * expected / 2.0 - 1.0).abs() < 1e-8,
            "{limit:?} {expected}"
        );
        assert!(StepLimit::safe(&vibration, 1.0, &physics).step() <= limit.step());
        let implicit = PhysicsSettings {
            integrator: Integrator::Implicit,
            ..physics
        };
        assert!(StepLimit::exact(&vibration, &implicit).step() > 1e3 * limit.step());
    }
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
