//! What a verdict says about the walk: each threshold from both sides.

use cosmic::geometry::Vector;
use cosmic::judge::Reliability;
use cosmic::judge::verdict::{HEADING, Item, Level, Measured, SURE_FOOTED, WALKS};
use cosmic::lattice::Lattice;
use cosmic::scene::Scene;
use cosmic::search::CoDesign;

use super::items::{around, level, robot, sound, unmeasured};

/// The first item of a verdict, which is the speed.
fn speed(measured: &Measured) -> (String, Level) {
    let Item { text, level, .. } = measured.verdict().items.remove(0);
    (text, level)
}

#[test]
fn a_robot_must_move_reliably_and_forwards() {
    let loads = sound();
    let moved = |displacement: f64| Measured {
        displacement: Some(displacement),
        ..robot(&loads)
    };
    let said = |text: &str, level| (text.to_owned(), level);
    // The lattice of `earth` is 0.5 m long, and a walk takes 16 s.
    let [[below, above], [stays, moves]] = WALKS.map(|lengths| around(0.5 * lengths));
    assert_eq!(speed(&moved(above)), said("0.016 m/s", Level::Good));
    assert_eq!(
        speed(&moved(below)),
        said(
            "0.016 m/s (only 0.50 of its length in 16 s)",
            Level::Doubtful
        )
    );
    assert_eq!(
        speed(&moved(moves)),
        said(
            "0.0016 m/s (only 0.050 of its length in 16 s)",
            Level::Doubtful
        )
    );
    for stays in [stays, -stays, 0.0] {
        assert_eq!(speed(&moved(stays)), said("stays in place", Level::Bad));
    }
    let standing = moved(stays).verdict();
    assert!(standing.to_text().starts_with("stays in place, "));
    assert!(!standing.to_text().contains("speaks against"));
    // A robot that does not get far gets advice.
    for (displacement, advised) in [(stays, true), (below, true), (above, false)] {
        assert_eq!(moved(displacement).verdict().hints.is_empty(), !advised);
    }
    assert_eq!(speed(&moved(-1.6)), said("0.10 m/s backwards", Level::Bad));
    let reliability = Reliability::Unreliable {
        stays_in_place: false,
        reason: "rollouts diverge".to_owned(),
    };
    let unreliable = |displacement: f64| Measured {
        reliability: &reliability,
        ..moved(displacement)
    };
    assert_eq!(
        speed(&unreliable(8.0)),
        said("0.50 m/s, unreliable", Level::Doubtful)
    );
    assert_eq!(
        speed(&unreliable(below)).0,
        "0.016 m/s (only 0.50 of its length in 16 s), unreliable"
    );
    let lost = Measured {
        displacement: None,
        ..robot(&loads)
    };
    assert_eq!(speed(&lost), said("its rollouts diverge", Level::Bad));
    // A robot with another task may stay or go back.
    let other = |displacement: f64| Measured {
        is_far: false,
        ..moved(displacement)
    };
    assert_eq!(speed(&other(0.0)).1, Level::Good);
    assert_eq!(speed(&other(-1.6)), said("0.10 m/s backwards", Level::Good));
}

/// A lattice that only has height is as long as a spacing.
#[test]
fn the_length_of_a_mast_is_a_spacing() {
    let scene = Scene::default();
    let earth = Lattice::new(&scene.lattice, &scene.physics);
    assert!((earth.body_length() - 0.5).abs() < 1e-12);
    let nodes = [0.0, 0.1, 0.2].map(|up| Vector::upright(0.0, up));
    let mast = Lattice::between(nodes.to_vec(), vec![[0, 1], [1, 2]]);
    assert!((mast.body_length() - 0.1).abs() < 1e-12);
    assert_eq!(mast.least_walk(), Lattice::STAYS * mast.body_length());
}

#[test]
fn a_robot_in_space_keeps_its_heading() {
    let loads = sound();
    let off = |across: (f64, f64)| Measured {
        across: Some(across),
        ..robot(&loads)
    };
    let level = |across| level(&off(across).verdict(), "off its heading");
    // The robot walks 8 m ahead.
    let [inside, outside] = around(HEADING).map(|angle| 8.0 * angle.to_radians().tan());
    for (low, high) in [(-0.1, inside), (-inside, 0.1)] {
        assert_eq!(level((low, high)), Level::Good);
    }
    for (low, high) in [(-0.1, outside), (-outside, 0.1)] {
        assert_eq!(level((low, high)), Level::Doubtful);
    }
    let says = off((0.2, 8.0 * 22_f64.to_radians().tan())).verdict();
    let says = says.to_text();
    assert!(
        says.contains("it goes up to 22 degrees off its heading"),
        "{says}"
    );
    // A planar robot has no heading, and neither has a robot that stays in place or goes to a goal.
    assert!(!robot(&loads).verdict().to_text().contains("heading"));
    let others = [
        Measured {
            displacement: Some(0.01),
            ..off((-1.0, 1.0))
        },
        Measured {
            is_far: false,
            ..off((-1.0, 1.0))
        },
    ];
    for other in others {
        let says = format!("{:?}", other.verdict());
        assert!(!says.contains("heading"), "{says}");
    }
}

#[test]
fn half_of_the_distance_remains_on_slippery_ground() {
    let loads = sound();
    let with = |low_friction: f64| Measured {
        low_friction: Some(low_friction),
        ..robot(&loads)
    };
    let level = |low_friction: f64| level(&with(low_friction).verdict(), "of the friction");
    let [below, above] = around(8.0 * SURE_FOOTED);
    assert_eq!([below, above].map(level), [Level::Doubtful, Level::Good]);
    let says = with(-2.0).verdict().to_text();
    let slides = "Doubtful: with 0.6 of the friction it gets to -2.00 m instead of 8.00 m.";
    assert!(says.contains(slides), "{says}");
    // A robot that stays in place or goes to a goal, and one whose feet never slip.
    let others = [
        Measured {
            displacement: Some(0.01),
            ..with(-2.0)
        },
        Measured {
            is_far: false,
            ..with(-2.0)
        },
        Measured {
            slips: false,
            ..with(-2.0)
        },
    ];
    for other in others {
        let says = format!("{:?}", other.verdict());
        assert!(!says.contains("of the friction"), "{says}");
    }
}

/// The remark has no level: it changes neither the level of the verdict nor what the verdict says about limits.
#[test]
fn a_planar_robot_needs_a_guide() {
    let loads = sound();
    let planar = robot(&loads);
    assert_eq!(
        level(&planar.verdict(), "falls over sideways"),
        Level::Remark
    );
    assert_eq!(planar.verdict().level(), Level::Good);
    let says = planar.verdict().to_text();
    assert!(
        says.contains("speaks against building it. To note: a planar robot"),
        "{says}"
    );
    let scene = Scene::load("cube").unwrap();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let of_scene = unmeasured(&scene, &lattice);
    let space = Measured {
        is_planar: of_scene.is_planar,
        ..planar
    };
    let says = space.verdict().to_text();
    assert!(
        says.contains("speaks against") && !says.contains("falls over"),
        "{says}"
    );
}

/// Scenes say whether their feet slip.
#[test]
fn friction_is_judged_only_where_feet_slip() {
    for (name, slips) in [("earth", true), ("stability", false), ("coulomb", true)] {
        let scene = Scene::load(name).unwrap();
        let codesign = CoDesign::new(&scene).unwrap();
        let measured = unmeasured(&scene, codesign.world().lattice());
        assert_eq!(measured.slips, slips, "{name}");
    }
}
