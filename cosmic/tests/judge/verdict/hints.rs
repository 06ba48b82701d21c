//! What may stop a robot that does not get far, and what a verdict advises.

use cosmic::design::Structure;
use cosmic::judge::verdict::{Item, Level, Measured};
use cosmic::judge::{Reliability, Standstill};
use cosmic::lattice::Lattice;
use cosmic::scene::Scene;

use super::items::{robot, sound, unmeasured};

/// A robot that stops under a stair: the time in which it walks counts, and the verdict says where it stops and what to try.
#[test]
fn a_robot_that_stops_is_told_where_and_since_when() {
    let scene = Scene::load("steps").unwrap();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let loads = sound();
    let robot = Measured {
        displacement: Some(0.9),
        standstill: Some(Standstill {
            since: 6.0,
            at: 0.9,
        }),
        ..Measured {
            risers: scene.risers_ahead(&lattice),
            ..robot(&loads)
        }
    };
    let verdict = robot.verdict();
    assert_eq!(
        verdict.items[0],
        Item::figure(
            "0.15 m/s until it stands still at 0.90 m after 6.0 s",
            Level::Doubtful
        )
    );
    let risers = robot.risers.len();
    assert_eq!(risers, scene.physics.ground.count);
    let passed = robot
        .risers
        .iter()
        .filter(|riser| riser.along <= 0.9)
        .count();
    assert!(passed > 0 && passed < risers);
    assert_eq!(
        verdict.items[1].text,
        format!("passes {passed} of {risers} steps")
    );
    let next = &verdict.hints[0];
    assert!(next.starts_with("the next step is 2.0 cm high"), "{next}");
    // A robot with a goal may stand still.
    let other = Measured {
        is_far: false,
        ..robot.clone()
    };
    assert!(!other.verdict().to_text().contains("stands still"));
    assert!(other.verdict().hints.is_empty());
    let walks = Measured {
        standstill: None,
        ..robot
    };
    assert!(walks.verdict().hints.is_empty());
}

/// The verdict on a slow, an unreliable or a floppy robot names the page about such robots.
#[test]
fn a_robot_that_does_not_walk_well_has_a_page() {
    let loads = sound();
    let unreliable = Reliability::Unreliable {
        stays_in_place: false,
        reason: String::new(),
    };
    let well = robot(&loads);
    let floppy = |modes| {
        well.structure.map(|structure| Structure {
            floppy_modes: Some(modes),
            ..structure
        })
    };
    let has_page = |robot: Measured| robot.verdict().hints.join("; ").contains("docs/walks.md");
    for (displacement, reliability, modes, expected) in [
        (8.0, &Reliability::Reliable, 0, false),
        (0.2, &Reliability::Reliable, 0, true),
        (8.0, &unreliable, 0, true),
        (8.0, &Reliability::Reliable, 1, true),
    ] {
        let robot = Measured {
            displacement: Some(displacement),
            reliability,
            structure: floppy(modes),
            ..well.clone()
        };
        assert_eq!(has_page(robot), expected);
    }
}

/// Slopes and payloads that stop a robot are named, and scenes with them are doubted.
#[test]
fn slippery_slopes_and_heavy_payloads_are_named() {
    let of = |settings: &str| {
        let scene = Scene::default().with("hard", settings).unwrap();
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let stays = Measured {
            displacement: Some(0.0),
            ..unmeasured(&scene, &lattice)
        };
        let warnings: Vec<_> = scene.warnings().iter().map(ToString::to_string).collect();
        (stays.verdict().hints.join("; "), warnings.join("; "))
    };
    let (hints, warnings) = of("");
    assert_eq!(
        (&hints[..], &warnings[..]),
        (
            "try other seeds: `--starts 4`; docs/walks.md says what helps most",
            ""
        )
    );
    // tan 25 degrees is 0.466, tan 40 degrees 0.839.
    let (hints, warnings) = of("physics.incline_deg = 25.0\nphysics.friction = 0.7");
    assert!(
        hints.contains("it is 1.5 times what holds a robot at rest"),
        "{hints}"
    );
    assert_eq!(warnings, "");
    let (hints, warnings) = of("physics.incline_deg = 40.0\nphysics.friction = 0.7");
    assert!(
        hints.contains("only 0.83 times what holds a robot"),
        "{hints}"
    );
    assert!(
        warnings.starts_with("the robot slides down the slope"),
        "{warnings}"
    );
    assert!(
        warnings.ends_with("a friction of 0.84 holds it at rest; walking needs more"),
        "{warnings}"
    );
    let (hints, warnings) = of("physics.payload_mass = 20.0");
    assert!(hints.starts_with("the payload is heavy"), "{hints}");
    assert!(
        warnings.starts_with("the payload weighs 196.200 N"),
        "{warnings}"
    );
}
