//! Scale invariance. A scene whose lengths, times and masses are multiplied by `s`, `sqrt(s)` and `m` has the same
//! robot, which moves `s` times as far. For `s` = 4^k and `m` = 2^k every number of the computation is only multiplied
//! by a power of two, so the bits are the same.
//!
//! [`scaled`] multiplies every key by the dimension of its unit. Keys without a unit are dimensionless. So are constants:
//! the perturbation of a start counts in the scale of the lattice, and so do the bounds on gradients.

use cosmic::judge::Delivery;
use cosmic::scene::{Scene, TaskKind};
use cosmic::search::CoDesign;

/// The factors by which a scene is scaled.
#[derive(Clone, Copy, Debug)]
struct Factors {
    length: f64,
    mass: f64,
}

impl Factors {
    /// The factor on times. Accelerations stay as they are.
    fn time(self) -> f64 {
        self.length.sqrt()
    }

    /// The factor on numbers with this unit.
    ///
    /// # Panics
    /// If the unit is unknown.
    fn of(self, unit: &str) -> f64 {
        let (length, time, mass) = (self.length, self.time(), self.mass);
        match unit {
            "" | "degrees" | "MB" => 1.0,
            "m" => length,
            "s" => time,
            "kg" => mass,
            "1/m" => 1.0 / length,
            "1/m2" => 1.0 / (length * length),
            "1/s" | "rad/s" => 1.0 / time,
            "m/s" => length / time,
            "s/m" => time / length,
            "m/s2" => length / (time * time),
            "kg/m" => mass / length,
            "Pa" => mass / (length * time * time),
            "N/m" => mass / (time * time),
            _ => panic!("the unit {unit} has no factor: add its dimension"),
        }
    }
}

/// The scene with every number multiplied by the factor of its unit.
fn scaled(scene: &Scene, factors: Factors) -> Scene {
    // These robots have no parts, so the numbers of parts have no effect. Some would leave their range.
    let settings = scene.settings().into_iter();
    let settings = settings.filter(|setting| !setting.key.starts_with("parts."));
    let settings = settings.map(|setting| {
        let factor = factors.of(setting.unit);
        format!("{} = {}", setting.key, times(&setting.value, factor))
    });
    let file = scene.lattice.file.clone();
    let mut scaled = scene.set(&settings.collect::<Vec<_>>()).unwrap();
    scaled.lattice.file = file;
    // The weight multiplies a number with a unit, which is a constant.
    scaled.objective.weight *= match scene.objective.task {
        TaskKind::Reach => factors.time(),
        TaskKind::Economy => factors.of("s") * factors.of("s/m"),
        TaskKind::Far | TaskKind::Climb | TaskKind::Back => 1.0,
    };
    scaled
}

/// A value of a scene file with all its numbers multiplied by a factor.
fn times(value: &str, factor: f64) -> String {
    if factor == 1.0 {
        return value.to_owned();
    }
    let ends = ['[', ']', ',', ' '];
    let part = |part: &str| {
        let number = part.trim_end_matches(ends);
        let rest = &part[number.len()..];
        let number: Result<f64, _> = number.parse();
        number.map_or(part.to_owned(), |x| format!("{:?}{rest}", x * factor))
    };
    value.split_inclusive(ends).map(part).collect()
}

/// Worlds and robots that differ in their physics.
const WORLDS: [&str; 7] = [
    "base = 'stability'",
    "base = 'earth'",
    // In single precision, a derivative differs in its last digit at the smallest size, and nowhere else. In double
    // precision all bits agree.
    "base = 'errand'\ngradient.precision = 'f64'",
    "base = 'coulomb'\nphysics.incline_deg = 12.0\nlattice.kind = 'triangular'",
    "base = 'stability'\nphysics = { integrator = 'leapfrog', substeps = 3 }",
    "base = 'rough'\ncontroller.goal_scale = 0.5",
    "base = 'steps'\nobjective.body = 'mass'\nlattice.payload = 5\ncontroller.clock = 'learned'",
];

/// The scene of a world, with a small robot that falls, walks and is optimised in all phases.
fn scene(world: &str) -> Scene {
    let scene = Scene::parse("world", world).unwrap();
    let small = "
        [lattice]
        columns = 3
        rows = 3
        drop = 0.02
        [physics]
        steps = 192
        [controller]
        hidden = 8
        gain = [6.0, 6.0]
        [start]
        kind = 'stability'
        [volume]
        solid = [0.3, 0.7]
        actuator = [0.0, 0.42]
        [loss]
        window = 32
        [schedule]
        iterations = 14
        attraction_from = 4
        snap_at = 8
        horizon = [64, 128]
        horizon_over = [1, 6]
        snap_trials = 4
        polish_trials = 4
        settle = 0.5
        [binarisation]
        threshold_over = [2, 6]
    ";
    scene.with("small", small).unwrap()
}

/// Optimises a scene with a fixed seed.
fn delivered(scene: &Scene) -> Delivery {
    CoDesign::new(scene).unwrap().optimise(5, |_| ()).unwrap()
}

/// Everything in an optimisation is free of scale: both optimisers and their bounds, the losses of all tasks, the
/// domain randomisation, the snap, the polish, the fine-tuning and the selection.
#[test]
fn an_optimisation_delivers_the_same_robot_at_every_scale() {
    let tasks = ["reach", "climb", "economy", "back"].map(|task| {
        format!("base = 'stability'\nobjective = {{ task = '{task}', body = 'nodes' }}")
    });
    let worlds = WORLDS.iter().map(|world| (*world).to_owned());
    for world in worlds.chain(tasks) {
        let scene = scene(&world);
        let robot = delivered(&scene);
        let along = robot.seen.moved.forward();
        assert!(along.is_finite() && along != 0.0, "{world}");
        for exponent in [-3, 3] {
            let factors = Factors {
                length: 4_f64.powi(exponent),
                mass: 2_f64.powi(2 * exponent - 1),
            };
            let other = delivered(&scaled(&scene, factors));
            let says = format!("{world}: {factors:?}");
            assert_eq!(other.design, robot.design, "{says}");
            assert!(other.controller == robot.controller, "{says}");
            assert_eq!(other.seen.moved.forward(), factors.length * along, "{says}");
            assert_eq!(
                other.spread.p10,
                factors.length * robot.spread.p10,
                "{says}"
            );
            assert_eq!(other.reliability.word(), robot.reliability.word(), "{says}");
        }
    }
}

/// If a single number keeps its value, another robot is delivered, so the test above can fail.
#[test]
fn a_number_that_is_not_scaled_changes_the_robot() {
    let factors = Factors {
        length: 64.0,
        mass: 1.0,
    };
    let scene = scene(WORLDS[0]);
    let mut other = scaled(&scene, factors);
    other.physics.damping = scene.physics.damping;
    assert!(delivered(&scene).controller != delivered(&other).controller);
}
