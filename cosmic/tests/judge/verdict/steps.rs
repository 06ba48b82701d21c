//! The verdict on loads and powers at half the time step.

use super::items::{level, robot, sound, walking};
use cosmic::judge::verdict::{HalfStep, Level, Measured, Verdict};
use cosmic::scene::Scene;
use cosmic::walk::{Energy, Loads, Magnitude};

/// A robot whose loads at half the time step are `half`, and whose power there is `power`, W.
fn halved(own: &Loads, half: &Loads, power: f64) -> Verdict {
    let own = robot(own);
    let half = HalfStep {
        loads: half,
        energy: Energy { power, ..walking() },
        own_energy: walking(),
    };
    let robot = Measured {
        half_step: Some(half),
        ..own
    };
    robot.verdict()
}

/// Sets one number of a robot: of its loads, or its power (W).
type Set = fn(&mut Loads, &mut f64, f64);

/// A change by a fifth is good, a larger one is doubtful, in either direction.
#[test]
fn loads_must_not_change_by_more_than_a_fifth_at_half_the_step() {
    let quantities: [(&str, Set); 6] = [
        ("the force of a muscle is", |loads, _, x| {
            loads.force.peak = x
        }),
        ("the speed of a muscle is", |loads, _, x| {
            loads.speed.peak = x
        }),
        ("the power of a muscle is", |loads, _, x| {
            loads.power.p99 = x
        }),
        ("the push on a bar is", |loads, _, x| loads.compression = x),
        ("the Euler safety is", |loads, _, x| {
            loads.euler_safety = Some(x)
        }),
        ("the power that it needs is", |_, power, x| *power = x),
    ];
    for (name, set) in quantities {
        let with = |x: f64| {
            let (mut own, mut half, mut power) = (sound(), sound(), 1.0);
            set(&mut own, &mut 1.0, 1.0);
            set(&mut half, &mut power, x);
            halved(&own, &half, power)
        };
        for x in [1.0, 1.199, 0.801] {
            assert_eq!(
                level(&with(x), "change by up to"),
                Level::Good,
                "{name} {x}"
            );
        }
        for x in [1.201, 0.799] {
            assert_eq!(level(&with(x), name), Level::Doubtful, "{name} {x}");
        }
    }
    let mut half = sound();
    half.compression = 45.7;
    let mut own = half.clone();
    own.compression = 35.6;
    let says = halved(&own, &half, 1.0).to_text();
    let doubt =
        "Doubtful: the push on a bar is 46 N at half the time step and 36 N at the scene's.";
    assert!(says.contains(doubt), "{says}");
    // What is 0 at both steps does not change.
    let still = halved(&Loads::default(), &Loads::default(), 1.0);
    assert_eq!(level(&still, "change by up to 0 %"), Level::Good);
    let unknown = Measured {
        half_step: None,
        ..robot(&own)
    };
    assert_eq!(
        level(&unknown.verdict(), "depend on the time step"),
        Level::Doubtful
    );
}

/// Each load and the power are judged at the time step at which they are worse.
#[test]
fn the_worse_time_step_is_judged() {
    let bad: [(&str, Set); 6] = [
        ("skeleton", |loads, _, x| {
            loads.skeleton_strain = Some(0.06 * x)
        }),
        ("their stroke", |loads, _, x| loads.strain.peak = 0.5 * x),
        ("one muscle", |loads, _, x| loads.power.p99 = 150.0 * x),
        ("buckle", |loads, _, x| loads.euler_safety = Some(0.5 / x)),
        ("pass through", |loads, _, x| {
            (loads.tangled, loads.most_tangles) = (0.1 * (x - 1e-3), 3);
        }),
        ("of 180 W/kg", |_, power, x| *power = 1000.0 * x),
    ];
    for (name, set) in bad {
        let judged = |own: f64, half: f64| {
            let [(mut a, mut power), (mut b, mut other)] = [(sound(), 1.0), (sound(), 1.0)];
            set(&mut a, &mut power, own);
            set(&mut b, &mut other, half);
            let half = HalfStep {
                loads: &b,
                energy: Energy {
                    power: other,
                    ..walking()
                },
                own_energy: walking(),
            };
            let robot = Measured {
                energy: Some(Energy { power, ..walking() }),
                half_step: Some(half),
                ..robot(&a)
            };
            level(&robot.verdict(), name)
        };
        let found = [judged(1e-3, 1e-3), judged(1.0, 1e-3), judged(1e-3, 1.0)];
        assert_eq!(found, [Level::Good, Level::Bad, Level::Bad], "{name}");
    }
    // The data sheet of a cylinder: 47 N and 0.75 m/s.
    let scene = Scene::load("workshop").unwrap();
    let mut half = sound();
    (half.force, half.speed) = (
        Magnitude {
            peak: 60.0,
            p99: 50.0,
        },
        Magnitude {
            peak: 1.0,
            p99: 0.9,
        },
    );
    let own = sound();
    let robot = Measured {
        half_step: Some(HalfStep {
            loads: &half,
            energy: walking(),
            own_energy: walking(),
        }),
        sheet: scene.data_sheet(),
        ..robot(&own)
    };
    for name in ["of about 47 N", "of 0.75 m/s"] {
        assert_eq!(level(&robot.verdict(), name), Level::Bad, "{name}");
    }
}
