//! The thresholds of a verdict, each from both sides, and its line.

use cosmic::design::{Design, Material, Structure};
use cosmic::judge::Reliability;
use cosmic::judge::verdict::{
    BATTERY, BRUSHES, ENDURANCES, EULER_SAFETIES, MUSCLE_POWERS, SKELETON_STRAINS, STROKES,
};
use cosmic::judge::verdict::{HalfStep, Item, Level, Measured, Verdict};
use cosmic::lattice::Lattice;
use cosmic::outcome::{StopReason, Summary};
use cosmic::policy::Controller;
use cosmic::scene::Scene;
use cosmic::search::CoDesign;
use cosmic::walk::{Energy, Loads, Magnitude};
use serde_json::json;
use std::path::Path;
use std::sync::LazyLock;

/// A number just below and just above a threshold.
pub(super) fn around(threshold: f64) -> [f64; 2] {
    [threshold * (1.0 - 1e-9), threshold * (1.0 + 1e-9)]
}

/// The loads of a robot that could be built.
pub(super) fn sound() -> Loads {
    Loads {
        skeleton_strain: Some(0.001),
        strain: Magnitude {
            peak: 0.2,
            p99: 0.1,
        },
        power: Magnitude {
            peak: 0.5,
            p99: 0.1,
        },
        most_tangles: 0,
        ..Loads::default()
    }
}

/// The energy of half a kilogram that needs 1 W.
pub(super) fn walking() -> Energy {
    Energy {
        mass: 0.5,
        power: 1.0,
        ..Energy::default()
    }
}

/// A robot that is not measured, but has the volumes that `earth` asks for.
pub(super) fn unmeasured(scene: &Scene, lattice: &Lattice) -> Measured<'static> {
    static SUMMARY: LazyLock<Summary> = LazyLock::new(|| {
        let summary = json!({
            "scene": "",
            "seed": 1,
            "displacement_along": 0.0,
            "displacement": [0.0, 0.0],
            "reliability": Reliability::Reliable,
            "V": 0.5,
            "V_act": 0.2,
            "undecided": false,
            "flips": 0,
            "skipped_gradients": 0,
            "iterations": 1,
            "delivered_iteration": 1,
            "stop_reason": StopReason::Finished,
            "cosmic_version": "",
            "seconds": 0.0,
        });
        serde_json::from_value(summary).unwrap()
    });
    SUMMARY.measured(scene, lattice)
}

/// A robot of half a kilogram and ten bars that walks 8 m in 16 s.
pub(super) fn robot(loads: &Loads) -> Measured<'_> {
    let scene = Scene::default();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    Measured {
        seconds: 16.0,
        displacement: Some(8.0),
        low_friction: Some(8.0),
        reliability: &Reliability::Reliable,
        structure: Some(Structure {
            pieces: 1,
            ..Structure::default()
        }),
        loads: Some(loads),
        energy: Some(walking()),
        half_step: Some(HalfStep {
            loads,
            energy: walking(),
            own_energy: walking(),
        }),
        bars: 10,
        payload: 0.03,
        actuator_strain: 0.35,
        ..unmeasured(&scene, &lattice)
    }
}

fn judged(change: impl Fn(&mut Loads)) -> Verdict {
    let mut loads = sound();
    change(&mut loads);
    robot(&loads).verdict()
}

/// The level of the only item that contains `word`.
#[track_caller]
pub(super) fn level(verdict: &Verdict, word: &str) -> Level {
    let mut found = verdict.items.iter().filter(|item| item.text.contains(word));
    let item = found
        .next()
        .unwrap_or_else(|| panic!("no {word:?} in {verdict:?}"));
    assert!(found.next().is_none(), "two items with {word:?}");
    item.level
}

/// Asserts that a load is good up to `limits[0]`, doubtful up to `limits[1]`, and bad above.
#[track_caller]
fn has_limits(word: &str, limits: [f64; 2], set: impl Fn(&mut Loads, f64)) {
    let level = |x: f64| level(&judged(|loads| set(loads, x)), word);
    let [[a, b], [c, d]] = limits.map(around);
    assert_eq!(
        [a, b, c, d].map(level),
        [Level::Good, Level::Doubtful, Level::Doubtful, Level::Bad]
    );
}

/// A robot with another task must do better for it than at rest.
#[test]
fn an_objective_is_compared_with_that_at_rest() {
    let loads = sound();
    let with = |loss: f64, idle: f64| {
        let task = Measured {
            is_far: false,
            losses: Some((loss, idle)),
            ..robot(&loads)
        };
        level(&task.verdict(), "with muscles at rest)")
    };
    // Of a robot that goes where it is told, people want to know how much of the way is left.
    let told = Measured {
        is_far: false,
        losses: Some((0.2, 1.0)),
        way_left: Some(0.27),
        ..robot(&loads)
    };
    assert_eq!(
        level(&told.verdict(), "leaves 27 % of the way"),
        Level::Good
    );
    let says = with(-0.98, 0.0);
    assert_eq!(says, Level::Good);
    for sign in [1.0, -1.0] {
        // The loss must fall by 2 % of the larger of the two numbers.
        let idle = sign;
        assert_eq!(with(idle - 0.03, idle), Level::Good);
        assert_eq!(with(idle - 0.01, idle), Level::Bad);
        assert_eq!(with(idle, idle), Level::Bad);
    }
    assert_eq!(with(0.0, 0.0), Level::Bad);
}

#[test]
fn each_load_has_two_thresholds() {
    has_limits("skeleton", SKELETON_STRAINS, |loads, x| {
        loads.skeleton_strain = Some(x);
    });
    has_limits(
        "their stroke",
        STROKES.map(|limit| 0.35 * limit),
        |loads, x| {
            loads.strain.peak = x;
        },
    );
    // A bar weighs 47 g on average, without the payload. A single peak, which depends on the time step, is not judged.
    let peak = judged(|loads| loads.power.peak = 1e6);
    assert_eq!(level(&peak, "one muscle"), Level::Good);
    has_limits(
        "one muscle",
        MUSCLE_POWERS.map(|limit| 0.047 * limit),
        |loads, x| {
            loads.power.p99 = x;
        },
    );
    // Safeties are good above their thresholds, so their reciprocals are tested.
    has_limits(
        "buckle",
        EULER_SAFETIES.map(|limit| 1.0 / limit),
        |loads, x| {
            loads.euler_safety = Some(1.0 / x);
        },
    );
}

#[test]
fn bars_may_brush_but_not_pass_through_each_other() {
    let tangled = |share: f64, pairs: usize| {
        judged(|loads| (loads.tangled, loads.most_tangles) = (share, pairs))
    };
    assert_eq!(level(&tangled(0.0, 0), "pass through"), Level::Good);
    assert_eq!(
        level(&tangled(BRUSHES, 1), "(one pair at a time)"),
        Level::Doubtful
    );
    assert_eq!(
        level(&tangled(around(BRUSHES)[1], 41), "(up to 41 pairs)"),
        Level::Bad
    );
}

#[test]
fn a_battery_of_a_fifth_of_the_mass_lasts_long_enough() {
    let loads = sound();
    let level = |seconds: f64| {
        let energy = Energy {
            mass: 0.5,
            power: 0.5 * BATTERY / seconds,
            ..Energy::default()
        };
        let robot = Measured {
            energy: Some(energy),
            ..robot(&loads)
        };
        level(&robot.verdict(), "of 180 W/kg")
    };
    let [[b, a], [d, c]] = ENDURANCES.map(around);
    assert_eq!(
        [a, b, c, d].map(level),
        [Level::Good, Level::Doubtful, Level::Doubtful, Level::Bad]
    );
}

/// Pressing the air of cylinders counts if it needs more power than their work.
#[test]
fn the_larger_of_mechanical_power_and_that_of_air_is_judged() {
    let loads = sound();
    let with = |power: f64, pressing: f64| {
        let energy = Energy {
            power,
            air: Some(5.2e-4),
            air_power: Some(pressing),
            ..walking()
        };
        let robot = Measured {
            energy: Some(energy),
            ..robot(&loads)
        };
        robot.verdict()
    };
    let [[b, a], [d, c]] = ENDURANCES.map(around);
    let level = |seconds: f64, other: f64| {
        let power = 0.5 * BATTERY / seconds;
        let both = [with(power, other * power), with(other * power, power)];
        both.map(|verdict| level(&verdict, "of 180 W/kg"))
    };
    for other in [0.05, 1.0] {
        assert_eq!(
            [a, b, c, d].map(|seconds| level(seconds, other)),
            [Level::Good, Level::Doubtful, Level::Doubtful, Level::Bad].map(|level| [level; 2])
        );
    }
    let says = |verdict: Verdict| verdict.items[3].text.clone();
    assert_eq!(
        says(with(4.4, 61.0)),
        "needs 61 W (122 of 180 W/kg) to press 31 litres of air a minute (at 1 bar; about 122 W with the losses of a \
         compressor)"
    );
    assert_eq!(
        says(with(61.0, 4.4)),
        "needs 61 W (122 of 180 W/kg) and 31 litres of air a minute (at 1 bar)"
    );
}

#[test]
fn the_line_names_what_is_bad_and_what_is_doubtful() {
    let sound = judged(|_| {}).to_text();
    assert_eq!(
        sound,
        "0.50 m/s, 0.50 kg, carries 30 g, needs 1.0 W (2.0 of 180 W/kg). Nothing measured here speaks against building it. To \
         note: a planar robot falls over sideways: it needs a guide or a second frame."
    );
    let verdict = judged(|loads| {
        (loads.tangled, loads.most_tangles) = (0.9, 41);
        (loads.skeleton_strain, loads.power.p99) = (Some(0.17), 140.0);
    });
    assert_eq!(
        verdict.to_text(),
        "0.50 m/s, 0.50 kg, carries 30 g, needs 1.0 W (2.0 of 180 W/kg). Would not work as built: bars pass through each \
         other (up to 41 pairs), the skeleton stretches or shrinks by 17 %. Doubtful: one muscle gives 140 W of 14 W (2979 \
         of 300 W/kg). To note: a planar robot falls over sideways: it needs a guide or a second frame."
    );
    assert_eq!(verdict.level(), Level::Bad);
    let json = serde_json::to_value(&verdict).unwrap();
    assert_eq!(
        json[0],
        serde_json::json!({ "text": "0.50 m/s", "level": "good" })
    );
}

/// The verdict on a robot of `workshop` with other parts, whose shortest bars have these lengths (m).
fn with_parts(settings: &[&str], loads: &Loads, bars: f64) -> Verdict {
    let scene = Scene::load("workshop").unwrap().set(settings).unwrap();
    let structure = Structure {
        pieces: 1,
        shortest_skeleton: Some(bars),
        shortest_actuator: Some(bars),
        ..Structure::default()
    };
    Measured {
        structure: Some(structure),
        sheet: scene.data_sheet(),
        ..robot(loads)
    }
    .verdict()
}

/// A robot within the limits of its cylinders, which are 47 N and 0.75 m/s.
#[test]
fn a_robot_is_compared_with_the_data_sheets_of_its_parts() {
    let mut loads = sound();
    let peak = |peak: f64, p99: f64| Magnitude { peak, p99 };
    (loads.force, loads.speed) = (peak(38.5, 20.0), peak(0.7, 0.6));
    let verdict = with_parts(&[], &loads, 0.2);
    let word = |verdict: &Verdict, word: &str| level(verdict, word);
    for item in ["of about 47 N", "of 0.75 m/s", "for a muscle of", "m thick"] {
        assert_eq!(word(&verdict, item), Level::Good, "{item}: {verdict:?}");
    }
    // A short time beyond the data sheet is doubtful, a longer time is bad. Without a data sheet, the law states the limits.
    loads.speed = peak(1.0, 0.63);
    assert_eq!(
        word(
            &with_parts(&[], &loads, 0.2),
            "1.0 m/s of 0.75 m/s (99 %: 0.63 m/s)"
        ),
        Level::Doubtful
    );
    loads.speed = peak(1.0, 0.9);
    assert_eq!(
        word(&with_parts(&[], &loads, 0.2), "of 0.75 m/s"),
        Level::Bad
    );
    let slow = with_parts(&["parts.speed=off", "parts.force=off"], &loads, 0.2);
    assert_eq!(word(&slow, "of 0.50 m/s"), Level::Bad);
    assert_eq!(word(&slow, "of about 36 N"), Level::Doubtful);
    // A device without air has one force.
    let electric = with_parts(&["parts.bore=off"], &loads, 0.2);
    assert_eq!(word(&electric, "of 47 N"), Level::Good);
    // The power is judged by the mass of the cylinder, 40 g.
    (loads.power.p99, loads.speed) = (14.0, peak(0.7, 0.6));
    let strong = with_parts(&[], &loads, 0.2);
    assert_eq!(
        word(&strong, "14 W of 12 W (350 of 300 W/kg)"),
        Level::Doubtful
    );
    loads.power.p99 = 130.0;
    assert_eq!(
        word(
            &with_parts(&[], &loads, 0.2),
            "of 120 W (3250 of 3000 W/kg)"
        ),
        Level::Bad
    );
    // Plain numbers have no data sheet.
    let plain = robot(&loads).verdict().to_text();
    assert!(
        !plain.contains("m/s of") && !plain.contains("thick"),
        "{plain}"
    );
}

#[test]
fn parts_must_fit_their_bars() {
    let loads = sound();
    let level =
        |settings: &[&str], bars: f64, word: &str| level(&with_parts(settings, &loads, bars), word);
    let unknown = |stroke: &'static str| [stroke, "parts.length=off"];
    // The cylinder is 135 mm long; a bar shrinks by 8 %.
    let [below, above] = around(0.135 / 0.92);
    assert_eq!(level(&[], above, "for a muscle"), Level::Good);
    assert_eq!(level(&[], below, "for a muscle"), Level::Bad);
    // A device of unknown length is longer than its stroke, and most are longer than twice their stroke.
    for (bars, expected) in [
        (0.2, Level::Bad),
        (around(0.2 / 0.92)[1], Level::Doubtful),
        (around(0.4 / 0.92)[1], Level::Good),
    ] {
        assert_eq!(
            level(&unknown("parts.stroke=0.2"), bars, "for a muscle"),
            expected
        );
    }
    assert_eq!(
        level(&unknown("parts.stroke=0.05"), 0.05, "with a stroke of"),
        Level::Bad
    );
    let tube = ["parts.outer=0.5", "parts.inner=0.49"];
    assert_eq!(level(&tube, 0.2, "0.50 m thick"), Level::Bad);
    assert_eq!(
        level(&["parts.outer=0.03"], 0.2, "m thick"),
        Level::Doubtful
    );
}

/// A design without a rollout has neither energy nor loads, and an undecided design has no bars.
#[test]
fn what_is_not_known_is_said() {
    let scene = Scene::default();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let old = Measured {
        displacement: Some(1.0),
        ..unmeasured(&scene, &lattice)
    };
    let items = old.verdict().items;
    let mass = Item::figure("mass not known", Level::Doubtful);
    assert!(items.contains(&mass), "{items:?}");
    let says = old.verdict().to_text();
    let missing = "Doubtful: how far it walks with 0.6 of the friction is not known, how its bars are connected is not known, \
                   the load of its bars is not known, the energy that it needs is not known.";
    assert!(says.contains(missing), "{says}");
    // One missing part is enough.
    let loads = sound();
    let without = |change: fn(&mut Measured)| {
        let mut robot = robot(&loads);
        change(&mut robot);
        robot.verdict().to_text()
    };
    assert!(without(|_| ()).contains("speaks against"));
    let changes: [fn(&mut Measured); 4] = [
        |robot| robot.low_friction = None,
        |robot| robot.structure = None,
        |robot| robot.loads = None,
        |robot| robot.energy = None,
    ];
    for change in changes {
        let says = without(change);
        assert!(
            says.contains("not known") && !says.contains("speaks against"),
            "{says}"
        );
    }
    let undecided = Measured {
        is_undecided: true,
        ..old
    };
    let says = undecided.verdict().to_text();
    assert!(
        says.contains("Would not work as built: the materials of its edges are undecided. To note"),
        "{says}"
    );
}

/// Two bars in line: a mechanism without a muscle. It falls over, so nothing else speaks against it.
#[test]
fn a_mechanism_without_muscles_does_not_pass() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/outside");
    let scene = Scene::load(folder.join("chain.toml").to_str().unwrap()).unwrap();
    let codesign = CoDesign::new(&scene).unwrap();
    let layout = Design::Layout(vec![Material::Skeleton; 2]);
    let controller = Controller::xavier(&scene.controller, codesign.world().lattice(), 1);
    let progress = codesign.begin_with(1, layout, controller).unwrap();
    let delivery = codesign.deliver(&progress);
    let lattice = codesign.world().lattice();
    let summary = Summary::new(&scene, &progress, &delivery);
    let verdict = summary.measured(&scene, lattice).verdict();
    let text = verdict.to_text();
    assert_eq!(verdict.level(), Level::Bad);
    for says in [
        "it has no muscles",
        "1 floppy mode, which no bar resists",
        "0 % of its edges are muscles (bounds: ",
    ] {
        assert!(text.contains(says), "{text}");
    }
    assert!(
        !text.contains("-0") && !text.contains("speaks against"),
        "{text}"
    );
}

#[test]
fn floppy_modes_and_missed_volumes_are_doubts() {
    let loads = sound();
    let with = |floppy_modes, volumes| Measured {
        structure: Some(Structure {
            pieces: 1,
            floppy_modes,
            ..Structure::default()
        }),
        volumes,
        ..robot(&loads)
    };
    let inside = [0.5, 0.21];
    assert_eq!(with(Some(0), inside).verdict().level(), Level::Good);
    let floppy = with(Some(5), inside).verdict();
    assert_eq!(level(&floppy, "5 floppy modes"), Level::Doubtful);
    // The bounds of `earth` widen by 0.03 to 47 % and 53 %, 17 % and 25 %.
    let at = |volumes| with(Some(0), volumes).verdict().level();
    assert_eq!([at([0.47, 0.17]), at([0.53, 0.25])], [Level::Good; 2]);
    assert_eq!(
        [[0.46, 0.2], [0.54, 0.2], [0.5, 0.16], [0.5, 0.26]].map(at),
        [Level::Doubtful; 4]
    );
    let says = with(Some(0), [0.46, 0.2]).verdict().to_text();
    assert!(
        says.contains("Doubtful: 46 % of its edges are solid (bounds: 47 % to 53 %). To note"),
        "{says}"
    );
}
