use cosmic::geometry::{Ground, Vector};
use cosmic::lattice::State;
use cosmic::objective::{Displacement, Loss};
use cosmic::scene::{LossKind, LossSettings};
use cosmic::world::Trajectory;

fn displacement(kind: LossKind) -> Displacement {
    Displacement {
        ground: Ground { incline_deg: 30.0 },
        settings: LossSettings {
            kind,
            ..LossSettings::default()
        },
    }
}

/// The mean covers the last steps of a rollout. If a rollout is shorter than the window, the mean covers the whole
/// rollout.
#[test]
fn the_mean_looks_back_from_the_last_state() {
    let observed = |kind, steps| displacement(kind).observed(steps);
    let last_half: Vec<usize> = (2064..=4096).step_by(16).collect();
    assert_eq!(observed(LossKind::Mean, 4096), last_half);
    assert_eq!(observed(LossKind::Mean, 40), [8, 24, 40]);
    assert_eq!(observed(LossKind::Mean, 0), [0]);
    assert_eq!(observed(LossKind::Final, 40), [40]);
}

#[test]
fn both_forms_measure_along_the_ground() {
    let ground = displacement(LossKind::Final).ground;
    let state = |along: f64| {
        let place = ground.vector_to_world(Vector::upright(along, 0.4));
        State::new([place], [Vector::zero()])
    };
    let states = [9.0, 1.0, 2.0, 6.0].map(state).to_vec();
    let trajectory = Trajectory::new(vec![0, 8, 24, 40], states);
    // Rotating vectors with entries below 10 has rounding errors of 1e-15.
    let last = displacement(LossKind::Final).loss(&trajectory);
    assert!((last + 6.0).abs() < 1e-14);
    let mean = displacement(LossKind::Mean).loss(&trajectory);
    assert!((mean + 3.0).abs() < 1e-14);
}
