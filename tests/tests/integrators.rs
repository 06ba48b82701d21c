//! The integrators that a scene may choose: their order of accuracy and their substeps. Stable time steps are tested in
//! other places: with the laws, and by `check`.

use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::scene::{Integrator, PhysicsSettings};
use cosmic_tests::{Bare, farthest};

const ALL: [Integrator; 3] = [
    Integrator::SymplecticEuler,
    Integrator::Leapfrog,
    Integrator::Implicit,
];

/// A stretched square with its diagonals, which vibrates and turns without contact.
fn square(integrator: Integrator, dt: f64, substeps: usize) -> (Bare, State<f64>) {
    let side = [[0, 1], [0, 2], [1, 3], [2, 3]].map(|edge| (edge, 0.1, 40.0));
    let diagonal = [[0, 3], [1, 2]].map(|edge| (edge, 0.02f64.sqrt(), 25.0));
    let springs = [&side[..], &diagonal[..]].concat();
    let mut bare = Bare::new(&springs, &[0.01, 0.02, 0.01, 0.015]);
    bare.physics = PhysicsSettings {
        dt,
        integrator,
        substeps,
        gravity: 4.8,
        damping: 5.0,
        ..bare.physics
    };
    let start = State::new(
        vec![[0.0, 0.0], [0.12, 0.01], [-0.01, 0.11], [0.11, 0.09]],
        vec![[0.1, 0.0], [0.0, 0.3], [-0.2, 0.1], [0.0, 0.0]],
    );
    (bare, start)
}

#[test]
fn every_integrator_has_its_order() {
    const TIME: f64 = 0.128;
    let run = |integrator, steps: usize| {
        let (bare, start) = square(integrator, TIME / steps as f64, 1);
        bare.run_to_end(&start, steps)
    };
    // These steps are 64 times shorter than the shortest steps below. So the error of this run is at most 1e-3 of the
    // error of the runs below.
    let truth = run(Integrator::Leapfrog, 64 * 256);
    for (integrator, order) in ALL.into_iter().zip([1.0, 2.0, 1.0]) {
        let error = |steps| farthest(&run(integrator, steps), &truth);
        let observed = (error(128) / error(256)).log2();
        println!("{integrator:?}: order {observed:.3}");
        // The next term of the error is smaller than the first by the factor dt omega = 0.1, and partly cancels in the
        // quotient of two errors.
        assert!((observed - order).abs() < 0.1, "{integrator:?}: {observed}");
    }
}

#[test]
fn leapfrog_falls_exactly() {
    for (integrator, exact) in ALL.into_iter().zip([false, true, false]) {
        let mut bare = Bare::free_node(PhysicsSettings {
            integrator,
            damping: 0.0,
            contact: ContactLaw::none(),
            ..PhysicsSettings::default()
        });
        bare.physics.dt = 1.0 / 256.0;
        let start = State::new(vec![[0.0, 0.0], [1.0, 0.0]], vec![[0.3, 1.0]; 2]);
        let end = bare.run_to_end(&start, 256);
        // The nodes fall for one second at 4.8 m/s2. Their heights are below 2 m and are rounded 512 times.
        let error: f64 = end.x[0].up() - (1.0 - 2.4);
        assert_eq!(
            error.abs() < 512.0 * 2.3e-16,
            exact,
            "{integrator:?}: {error:e}"
        );
    }
}

/// Without a controller, n substeps give the same motion as n shorter steps.
#[test]
fn substeps_are_shorter_steps() {
    for integrator in ALL {
        let (coarse, start) = square(integrator, 0.004, 4);
        let (fine, _) = square(integrator, 0.001, 1);
        assert_eq!(
            coarse.run_to_end(&start, 50),
            fine.run_to_end(&start, 200),
            "{integrator:?}"
        );
    }
}
