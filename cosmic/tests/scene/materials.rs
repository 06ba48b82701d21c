//! Parts: bars whose stiffness and mass follow from a section, a material and a length.

use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::design::Material::{self, Actuator, Skeleton, Void};
use cosmic::lattice::{Body, Lattice};
use cosmic::laws::Stops;
use cosmic::scene::{BarNumbers, MaterialSettings, Scene};
use cosmic::search::CoDesign;
use cosmic::walk::{self, BarLoad, Loads};
use cosmic::world::{Span, Trajectory, World};
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

/// The materials of the paper's scene with these settings of `[parts]`.
fn parts(settings: &str) -> MaterialSettings {
    let text = format!("materials.max_strain = [0.0, 0.0, 0.05]\nparts = {{{settings}}}");
    Scene::paper().with("parts", &text).unwrap().materials
}

/// Asserts that two numbers agree except for rounding: each is the result of fewer than 20 operations.
#[track_caller]
fn near(found: f64, expected: f64) {
    let off = (found - expected).abs();
    assert!(off <= 1e-14 * expected.abs(), "{found} {expected}");
}

/// A carbon tube of 6 and 4 mm, 0.2 m long, between joints of 1e5 N/m with fittings of 2 g, calculated by hand:
/// A = 1.5707963267948967e-5 m2, I = 5.105088062083415e-11 m4, E A / l = 10524335.389525807 N/m.
#[test]
fn a_tube_between_two_joints_agrees_with_a_calculation_by_hand() {
    let tube = parts("skeleton = 'tube', joint = 1e5, end_mass = 0.002");
    let BarNumbers { stiffness, density } = tube.of_length(0.2);
    near(stiffness[1], 49763.57852215692);
    near(0.2 * density[1], 0.008712388980384692);
    near(tube.euler_load(0.2).unwrap(), 1687.9041867838212);
    // Joints off are rigid. Void and actuator stay plain numbers.
    let rigid = parts("skeleton = 'tube'").of_length(0.2);
    near(rigid.stiffness[1], 10524335.389525807);
    let plain = MaterialSettings::default();
    for numbers in [rigid.stiffness, stiffness] {
        assert_eq!(
            [numbers[0], numbers[2]],
            [plain.stiffness[0], plain.stiffness[2]]
        );
    }
    assert_eq!(
        [density[0], density[2]],
        [plain.density[0], plain.density[2]]
    );
}

/// A tube without a hole is a rod. A square strut has 4 / pi times the area of a rod as thick as the strut is wide, and 16
/// / (3 pi) times its second moment of area. Euler's load falls with the square of the length.
#[test]
fn sections_agree_with_one_another() {
    let [rod, hollow, strut] = ["rod", "tube", "strut"].map(|kind| {
        parts(&format!(
            "skeleton = '{kind}', material = [2e9, 900], outer = 0.003, inner = 0.0"
        ))
    });
    assert_eq!(rod.of_length(0.1), hollow.of_length(0.1));
    let [round, square] = [&rod, &strut].map(|part| part.of_length(0.1));
    near(square.stiffness[1], 4.0 / PI * round.stiffness[1]);
    near(square.density[1], 4.0 / PI * round.density[1]);
    let [round, square] = [&rod, &strut].map(|part| part.euler_load(0.1).unwrap());
    near(square, 16.0 / (3.0 * PI) * round);
    near(rod.euler_load(0.2).unwrap(), 0.25 * round);
}

/// A device of 40 g with fittings of 2 g has the same mass in a bar of any length. Its stiffness is that of its material in
/// series with two joints: 1 / (1 / 30 + 2 / 1e4) = 29.82107355864811 N/m.
#[test]
fn a_device_has_its_own_mass() {
    let device = parts("actuator = 'device', joint = 1e4, end_mass = 0.002");
    for length in [0.1, 0.3] {
        let bar = device.of_length(length);
        near(length * bar.density[2], 0.044);
        near(bar.stiffness[2], 29.82107355864811);
        assert_eq!((bar.stiffness[1], bar.density[1]), (4e2, 0.030));
    }
    assert_eq!(device.euler_load(0.1), None);
}

/// Each edge of a body has the numbers of its own length, in layouts and in mixtures. The diagonals are longer.
#[test]
fn a_body_has_a_number_for_every_length() {
    let scene = Scene::paper();
    let mut layout = scene.lattice.clone();
    (layout.columns, layout.rows) = (2, 2);
    let lattice = Lattice::new(&layout, &scene.physics);
    let settings =
        "skeleton = 'rod', material = 'pla', outer = 0.003, joint = 2e3, actuator = 'device'";
    let materials = parts(settings);
    let numbers = |edge: usize| materials.of_length(lattice.rest_length[edge]);
    let body = |design: &Design<_>| -> Body<f64> {
        Body::new(design, &lattice, &materials, &scene.physics)
    };
    let kinds: Vec<Material> = (0..lattice.edges.len())
        .map(|edge| [Void, Skeleton, Actuator][edge % 3])
        .collect();
    let layout = body(&Design::Layout(kinds.clone()));
    let shares = [0.2, 0.5, 0.3];
    let mixed = body(&Design::of_shares(&vec![shares; kinds.len()]));
    let dot = |of: [f64; 3]| (0..3).map(|k| shares[k] * of[k]).sum::<f64>();
    let mut masses = [0.0; 2];
    for (edge, kind) in kinds.iter().enumerate() {
        let BarNumbers { stiffness, density } = numbers(edge);
        assert_eq!(layout.stiffness[edge], kind.of(&stiffness));
        near(mixed.stiffness[edge], dot(stiffness));
        let length = lattice.rest_length[edge];
        masses[0] += length * kind.of(&density);
        masses[1] += length * dot(density);
    }
    let of_nodes = 4.0 * scene.physics.node_mass + scene.physics.payload_mass;
    for (body, bars) in [&layout, &mixed].into_iter().zip(masses) {
        near(body.mass.iter().sum::<f64>(), of_nodes + bars);
    }
    assert!(numbers(0).stiffness[1] != numbers(2).stiffness[1]);
}

/// The Euler safety of a robot is the smallest of its skeleton bars that something pushes on. Plain numbers have none.
#[test]
fn the_euler_safety_is_that_of_the_bar_nearest_to_buckling() {
    let mut scene = Scene::paper();
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let tube = parts("skeleton = 'tube'");
    let load = tube.euler_load(lattice.rest_length[0]).unwrap();
    let mut layout = vec![Void; lattice.edges.len()];
    layout[..4].copy_from_slice(&[Skeleton, Skeleton, Actuator, Skeleton]);
    let length = |edge: usize| lattice.rest_length[edge];
    let pushed = |compression: f64| {
        Some(BarLoad {
            compression,
            ..BarLoad::default()
        })
    };
    let mut bars = vec![None; layout.len()];
    bars[..4].copy_from_slice(&[pushed(0.25), pushed(0.5), pushed(100.0), pushed(0.0)]);
    let still = Trajectory::new(vec![0], vec![lattice.state_at_rest()]);
    let safety = |scene: &Scene| {
        let world = World::new(lattice.clone(), scene);
        Loads::of(&world, &layout, &bars, &still).euler_safety
    };
    assert_eq!(safety(&scene), None);
    let second = load * (length(0) / length(1)).powi(2) / 0.5;
    scene.materials = tube;
    near(safety(&scene).unwrap(), second.min(load / 0.25));
}

/// The loads of a robot of this scene that moves for a second. Every fourth of its bars is an actuator.
fn loads_of_a_second(mut scene: Scene) -> Loads {
    scene.physics.steps = (1.0 / scene.physics.dt).round() as usize;
    let mut case = Case::of_scene(&scene, 1).unwrap();
    let kinds = [Actuator, Skeleton, Skeleton, Skeleton];
    let edges = case.lattice.edges.len();
    let layout: Vec<Material> = kinds.into_iter().cycle().take(edges).collect();
    case.design = Design::Layout(layout.clone());
    let (world, robot, steps) = (case.world(), case.robot(), case.scene.physics.steps);
    let seen = walk::guarded(&world, &robot, &Span::of_steps(steps));
    assert!(seen.divergence.is_none(), "{:?}", seen.divergence);
    let bars = walk::bar_loads(&world, &layout, &robot, &Span::of_steps(steps));
    Loads::of(&world, &layout, &bars, &seen.trajectory)
}

/// The scenes with real actuators are read without a warning, have a stable step for every design, and their robots move.
#[test]
fn robots_with_real_actuators_move() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/actuators");
    for (name, force) in [("pneumatic", 47.0), ("electric", 50.0)] {
        let text = fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap();
        let scene = Scene::parse(name, &text).unwrap();
        let warnings: Vec<_> = scene.warnings().iter().map(ToString::to_string).collect();
        assert_eq!(warnings, [""; 0], "{name}");
        assert!(
            scene
                .describe_world()
                .contains("skeleton carbon tube; actuators of 0.0")
        );
        CoDesign::new(&scene).unwrap();
        let loads = loads_of_a_second(scene);
        assert!(loads.strain.peak > 0.01, "{name}: {loads:?}");
        // The stops and the damper pull beside the actuator, whose force is limited.
        assert!(loads.force.peak < 3.0 * force, "{name}: {loads:?}");
        assert!(loads.euler_safety.unwrap() > 1.0, "{name}: {loads:?}");
    }
}

/// The stops of `workshop` follow from the stroke of its actuators, which the scene states once.
#[test]
fn the_stroke_of_a_device_is_stated_once() {
    for (settings, strain) in [
        (&[][..], 0.08),
        (&["materials.max_strain=[0, 0, 0.07]"], 0.07),
    ] {
        let scene = Scene::load("workshop").unwrap().set(settings).unwrap();
        let stops: Stops = scene.physics.forces.chosen().unwrap();
        assert_eq!(stops.at, strain);
    }
}

/// Edges that are too short for the parts of a scene are doubted.
#[test]
fn parts_that_do_not_fit_the_edges_are_doubted() {
    let warnings = |settings: &[&str]| -> Vec<String> {
        let scene = Scene::load("workshop").unwrap().set(settings).unwrap();
        let warnings = scene.warnings().into_iter().map(|warning| warning.says);
        warnings.filter(|says| says.contains("too short")).collect()
    };
    assert_eq!(warnings(&[]), [""; 0]);
    // A stroke as long as the bar, in the 17 edges of 0.2 m and the 12 diagonals of 0.283 m.
    let long = warnings(&["parts.stroke=0.2", "parts.length=off"]);
    assert_eq!(
        long,
        [
            "17 of 29 edges are too short for an actuator: the shortest shrinks to 0.1840 m, but the device has a stroke, so it must be at least 0.2 m long"
        ]
    );
    let long = warnings(&["parts.length=0.25"]);
    assert!(
        long[0].contains("but the device is 0.25 m long"),
        "{long:?}"
    );
    assert_eq!(
        warnings(&["parts.stroke=0.18", "parts.length=off"]),
        [""; 0]
    );
    let thick = warnings(&["parts.outer=0.5", "parts.inner=0.49"]);
    assert!(thick[0].contains("29 of 29 edges"), "{thick:?}");
    assert!(thick[0].contains("0.5 m thick"), "{thick:?}");
    assert_eq!(warnings(&["parts.outer=0.06"]), [""; 0]);
}

/// A cylinder takes a chamber of air at every movement: travel times area times absolute pressure.
#[test]
fn cylinders_take_air_at_every_movement() {
    let scene = Scene::load("workshop").unwrap();
    let air = |settings: &[&str]| {
        let scene = scene.set(settings).unwrap();
        scene.materials.parts.air(2.0)
    };
    let area = 0.25 * PI * 0.01 * 0.01;
    near(air(&[]).unwrap(), 2.0 * area * 5.6);
    near(air(&["parts.bore=0.02"]).unwrap(), 2.0 * 4.0 * area * 5.6);
    near(air(&["parts.pressure=9e5"]).unwrap(), 2.0 * area * 10.0);
    assert_eq!(air(&["parts.bore=off"]), None);
    assert_eq!(air(&["parts.actuator=numbers"]), None);
}

/// Air is pressed without losses by the work of many small compressors in a row, each of which raises the pressure a little.
#[test]
fn pressing_air_needs_the_isothermal_power() {
    let scene = Scene::load("workshop").unwrap();
    for (pressure, air) in [(4.6e5, 5.2e-4), (9e5, 2e-3), (10.0, 1e-3)] {
        let settings = [format!("parts.pressure={pressure}")];
        let scene = scene.set(&settings).unwrap();
        // The volume at 1 bar is `air`, so it is 1e5 air / p at the pressure p.
        let (stages, first) = (10_000, 1e5);
        let rise = pressure / f64::from(stages);
        let stage = |k| rise * first * air / (first + rise * (f64::from(k) + 0.5));
        let power: f64 = (0..stages).map(stage).sum();
        // The midpoint rule is off by (rise / p)^2 / 12, at most 7e-8.
        assert!((scene.materials.parts.air_power(air) / power - 1.0).abs() < 1e-7);
    }
    // A walk of `workshop`: at least 90 W, where its cylinders give 4.4 W.
    let power = scene.materials.parts.air_power(5.2e-4);
    assert!((power - 89.6).abs() < 0.05, "{power}");
}
