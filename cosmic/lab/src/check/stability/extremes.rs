//! The extreme robots to try.

use autodiff::Parameters;

use super::trial::{Setting, Trial};
use crate::check::probe::most;
use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::geometry::Dimension;
use cosmic::lattice::EdgeVector;
use cosmic::laws::ContactLaw;
use cosmic::scene::{Integrator, LatticeKind, PartsSettings, Scene, StartKind};

/// The number of steps of a trial. It is more than enough: with a time step 5 % above its limit, a vibration grows a
/// thousandfold in a dozen steps.
const STEPS: usize = 512;
/// If no edge is strained by more than this at the start, the frequencies at the start are taken to be those at rest.
/// The squares of the frequencies change by about as much as the strain, and the closest trial is 5 % away from the
/// limit.
const LINEAR: f64 = 0.01;
/// The time steps to try, as multiples of the limit of stability.
const FRACTIONS: [f64; 4] = [0.5, 0.95, 1.05, 2.0];

/// Returns the trials of a case: with its own time step, and with time steps around the limit of stability. They have
/// the same number of steps for every case. If the robot starts far from rest, the limit holds only for the first step,
/// and only its own time step is tried.
pub fn case_trials(case: &Case) -> Vec<Trial> {
    let mut case = case.clone();
    case.scene.physics.steps = STEPS;
    let edges = case.lattice.edges.iter().zip(&case.lattice.rest_length);
    let strains = edges.map(|(&edge, rest)| {
        (EdgeVector::of(&case.start, edge).length(case.lattice.softening()) / rest - 1.0).abs()
    });
    let starts_at_rest = most(strains) < LINEAR;
    let own = Trial::new("scene", "its own time step", case.clone(), Setting::Driven);
    let free =
        starts_at_rest.then(|| Trial::new("scene", "without its world", case, Setting::Free));
    let around = free.iter().flat_map(around);
    std::iter::once(own).chain(around).collect()
}

/// Returns trials of the same robot with time steps below and above its limit of stability. There are none if the robot
/// has no limit, or if its limit is one of rounding.
fn around(trial: &Trial) -> Vec<Trial> {
    let has_limit = trial.limit.is_finite() && !trial.is_implicit();
    let fractions = FRACTIONS.iter().filter(|_| has_limit);
    fractions.map(|fraction| trial.at(*fraction)).collect()
}

/// A list of trials under construction. Each trial runs a changed [`robot`].
struct Trials {
    dimension: Dimension,
    all: Vec<Trial>,
}

impl Trials {
    /// Adds trials of a changed robot without ground, gravity and actuation, with time steps around its limit.
    fn free(&mut self, group: &'static str, what: &str, change: impl FnOnce(&mut Case)) {
        let mut case = robot(self.dimension, 3);
        change(&mut case);
        let trial = Trial::new(group, what, case, Setting::Free);
        self.all.extend(around(&trial));
    }

    /// Adds a trial of a changed robot in its world, with the time step of its scene.
    fn own(&mut self, group: &'static str, what: &str, change: impl FnOnce(&mut Case)) {
        let mut case = robot(self.dimension, 3);
        change(&mut case);
        self.all
            .push(Trial::new(group, what, case, Setting::Driven));
    }
}

/// All trials of extreme robots, which are squares in the plane and cubes in space.
pub fn extreme_trials(dimension: Dimension) -> Vec<Trial> {
    let all = Vec::new();
    let mut trials = Trials { dimension, all };
    masses_and_stiffnesses(&mut trials);
    integrators(&mut trials);
    trials.all.extend(implicit(dimension));
    let what = "on the ground, actuated";
    let driven = Trial::new("time step", what, robot(dimension, 3), Setting::Driven);
    trials.all.extend(around(&driven));
    layouts_and_controllers(&mut trials);
    let (sides, times): (&[usize], _) = match dimension {
        Dimension::Plane => (&[2, 3, 6, 10, 20, 40], 2),
        Dimension::Space => (&[2, 3, 4, 6, 10], 3),
    };
    for &side in sides {
        let size = vec![side.to_string(); times].join("x");
        trials.free("lattice", &format!("{size} nodes"), |case| {
            *case = robot(dimension, side);
            (case.scene.physics.damping, case.scene.physics.steps) = (0.0, STEPS / 2);
        });
    }
    trials.all
}

/// Makes a robot of `side` times `side` nodes, in space of as many layers, with the paper's materials, in which all edges are
/// skeleton.
fn robot(dimension: Dimension, side: usize) -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (side, side);
    if dimension == Dimension::Space {
        (scene.lattice.kind, scene.lattice.depth) = (LatticeKind::Cubic, side);
    }
    (scene.start.kind, scene.controller.hidden) = (StartKind::Uniform, 8);
    scene.physics.steps = STEPS;
    let mut case = Case::of_scene(&scene, 0).expect("the uniform start fits any lattice");
    set_layout(&mut case, |_| Material::Skeleton);
    case
}

/// Sets the material of every edge to `material(edge)`.
fn set_layout(case: &mut Case, material: impl Fn(usize) -> Material) {
    case.design = Design::Layout((0..case.lattice.edges.len()).map(material).collect());
}

/// Gives every edge equal fractions of all materials.
fn set_mixture(case: &mut Case) {
    case.design = Design::Undecided(vec![[1.0 / 3.0; 3]; case.lattice.edges.len()]);
}

fn set_springs(case: &mut Case, stiffness: [f64; 3]) {
    (case.scene.materials.stiffness, case.scene.physics.damping) = (stiffness, 0.0);
    case.scene.materials.parts = PartsSettings::default();
}

/// Sets the masses of nodes and payload. Bars get no mass.
fn set_masses(case: &mut Case, node: f64, payload: f64) {
    (case.scene.materials.density, case.scene.physics.damping) = ([0.0; 3], 0.0);
    case.scene.materials.parts = PartsSettings::default();
    (
        case.scene.physics.node_mass,
        case.scene.physics.payload_mass,
    ) = (node, payload);
}

/// Adds robots without damping that have extreme stiffnesses and masses, or very different ones in one robot.
fn masses_and_stiffnesses(trials: &mut Trials) {
    for k in [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let what = format!("{k:e} N/m");
        trials.free("stiffness", &what, |case| set_springs(case, [k; 3]));
    }
    for mass in [1e-6, 1e-3, 1.0, 1e3] {
        let what = format!("{mass:e} kg a node");
        trials.free("mass", &what, |case| set_masses(case, mass, 0.0));
    }
    trials.free("ratio", "1e-9, 1 and 1e6 N/m in turns", |case| {
        set_springs(case, [1e-9, 1e6, 1.0]);
        set_layout(case, |edge| Material::ALL[edge % 3]);
    });
    let what = "a payload of 1e3 kg on nodes of 1e-6 kg";
    trials.free("ratio", what, |case| set_masses(case, 1e-6, 1e3));
}

/// Adds robots with strong damping and with other integrators.
fn integrators(trials: &mut Trials) {
    use Integrator::{Leapfrog, SymplecticEuler};
    for damping in [1.0, 20.0, 1e4] {
        let what = format!("{damping} 1/s");
        trials.free("damping", &what, |case| {
            case.scene.physics.damping = damping
        });
    }
    for (what, integrator, substeps) in [
        ("symplectic Euler, 8 substeps", SymplecticEuler, 8),
        ("leapfrog", Leapfrog, 1),
        ("leapfrog, 8 substeps", Leapfrog, 8),
    ] {
        trials.free("integrator", what, |case| {
            (case.scene.physics.integrator, case.scene.physics.substeps) = (integrator, substeps);
        });
    }
}

/// Returns robots with implicit steps: every combination of stiffness, mass and time step whose masses are not lost in
/// rounding. No vibration may grow.
fn implicit(dimension: Dimension) -> Vec<Trial> {
    let mut trials = Vec::new();
    for stiffness in [1.0, 1e3, 1e6, 1e9] {
        for mass in [1e-9, 1e-4, 0.1, 1e3] {
            for dt in [1e-5, 1e-3, 0.1] {
                let mut case = robot(dimension, 3);
                set_springs(&mut case, [stiffness; 3]);
                set_masses(&mut case, mass, 0.0);
                (case.scene.physics.integrator, case.scene.physics.dt) = (Integrator::Implicit, dt);
                let what = format!("{stiffness:e} N/m, {mass:e} kg a node, dt {dt:e} s");
                trials.push(Trial::new("implicit", &what, case, Setting::Free));
            }
        }
    }
    trials.retain(|trial| trial.case.scene.physics.dt < trial.limit);
    trials
}

fn layouts_and_controllers(trials: &mut Trials) {
    for friction in [0.0, 2.5, 1e3, 1e12] {
        trials.own("friction", &format!("Coulomb, {friction:e}"), |case| {
            (case.scene.physics.contact, case.scene.physics.friction) =
                (ContactLaw::coulomb(), friction);
            set_mixture(case);
        });
    }
    for material in Material::ALL {
        let what = format!("all {material:?}").to_lowercase();
        trials.own("layout", &what, |case| set_layout(case, |_| material));
    }
    for (what, gain, bias) in [
        ("silent: all weights zero", 0.0, 0.0),
        ("saturated: weights times 1e3", 1e3, 0.0),
        ("saturated: weights times 1e300", 1e300, 0.0),
        ("all actuators held at full contraction", 0.0, -1e308),
    ] {
        trials.own("controller", what, |case| {
            set_layout(case, |_| Material::Actuator);
            case.controller = case.controller.map(|w| w * gain);
            let biases = case.controller.block_mut("b2").iter_mut();
            biases.for_each(|b| *b += bias);
        });
    }
    /// A function from nodes to nodes. Each node starts in the place of the node that the function returns.
    type Place = fn(usize) -> usize;
    let places: [(&str, Place); 3] = [
        ("two nodes in one place", |i| if i == 1 { 0 } else { i }),
        ("every row in one place", |i| 3 * (i / 3)),
        ("all nodes in one place", |_| 4),
    ];
    for (what, place) in places {
        trials.own("coincidence", what, |case| {
            let from = case.start.x.clone();
            case.start.x = (0..from.len()).map(|i| from[place(i)]).collect();
            set_mixture(case);
        });
    }
}
