//! The extremes that are tried.

use super::trial::{Trial, World, silent};
use crate::verify::probe::{frequencies, most};
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::lattice::EdgeVector;
use cosmic::laws::ContactLaw;
use cosmic::scene::{Integrator, Scene, StartKind};
use cosmic::simulator::stability::stable_step;

/// Steps of a trial: a vibration a twentieth beyond its limit grows a thousandfold in a dozen.
const STEPS: usize = 512;
/// The strain up to which frequencies count as those at rest. Their squares change by about as much, and
/// the nearest trial is a twentieth from the limit.
const LINEAR: f64 = 0.01;
/// The time steps that are tried, as shares of the limit.
const SHARES: [f64; 4] = [0.5, 0.95, 1.05, 2.0];

/// A case with its own time step, and its robot with time steps around the limit, whatever the length of
/// its rollout. A robot that starts far from rest has a limit that holds for its first step alone, and
/// is tried with its own time step only.
pub fn case_trials(case: &Case) -> Vec<Trial> {
    let mut case = case.clone();
    case.physics.steps = STEPS;
    let mut trials = Trials::default();
    trials.single("scene", "its own time step", case.clone());
    if strain(&case) < LINEAR {
        trials.around("scene", "without its world", &case, World::Free);
    }
    trials.0
}

/// The largest strain of an edge at the start.
fn strain(case: &Case) -> f64 {
    let edges = case.lattice.edges.iter().zip(&case.lattice.rest_length);
    most(edges.map(|(&edge, rest)| (EdgeVector::of(&case.start, edge).length() / rest - 1.0).abs()))
}

/// Every extreme: stiffness, mass and the ratios of both, damping, integrators, time steps,
/// friction, layouts, controllers, nodes in one place, sizes of lattices.
pub fn extreme_trials() -> Vec<Trial> {
    let mut trials = Trials::default();
    masses_and_stiffnesses(&mut trials);
    integrators_and_laws(&mut trials);
    let driven = robot(|_| {});
    trials.around(
        "time step",
        "on the ground, actuated",
        &driven,
        World::Driven,
    );
    frictions_and_layouts(&mut trials);
    controllers(&mut trials);
    coincidences(&mut trials);
    for side in [2, 3, 6, 10, 20, 40] {
        trials.free("lattice", &format!("{side}x{side} nodes"), |scene| {
            (scene.lattice.columns, scene.lattice.rows) = (side, side);
            (scene.physics.damping, scene.physics.steps) = (0.0, STEPS / 2);
        });
    }
    trials.0
}

/// A robot of 3x3 nodes of the paper's materials, all skeleton.
fn robot(change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.start.kind, scene.controller.hidden) = (StartKind::Uniform, 8);
    scene.physics.steps = STEPS;
    change(&mut scene);
    let mut case = Case::of_scene(&scene, 0).expect("the uniform start fits any lattice");
    set_layout(&mut case, |_| Material::Skeleton);
    case
}

/// Sets the material of every edge by its number.
fn set_layout(case: &mut Case, material: impl Fn(usize) -> Material) {
    let edges = 0..case.lattice.edges.len();
    case.frozen = Some(edges.map(material).collect());
}

/// The trials so far.
#[derive(Default)]
struct Trials(Vec<Trial>);

impl Trials {
    /// Adds a robot with time steps under and over its limit, where there is one.
    fn around(&mut self, group: &'static str, what: &str, case: &Case, world: World) {
        let mut case = match world {
            World::Free => silent(case),
            World::Driven => case.clone(),
        };
        let [frequency, _, damping] = frequencies(&case, &case.lattice.positions);
        let limit = stable_step(&case.physics, frequency, damping);
        if limit.is_infinite() {
            return;
        }
        for share in SHARES {
            case.physics.dt = share * limit;
            self.0.push(Trial {
                group,
                what: format!("{what}, dt {share} of the limit"),
                case: case.clone(),
                world,
                frequency,
                damping,
            });
        }
    }

    /// Adds a robot of a changed scene, without its world.
    fn free(&mut self, group: &'static str, what: &str, change: impl FnOnce(&mut Scene)) {
        self.around(group, what, &robot(change), World::Free);
    }

    /// Adds a robot in its world with its own time step.
    fn single(&mut self, group: &'static str, what: &str, case: Case) {
        let [frequency, _, damping] = frequencies(&case, &case.lattice.positions);
        self.0.push(Trial {
            group,
            what: what.to_owned(),
            frequency,
            damping,
            case,
            world: World::Driven,
        });
    }
}

/// A robot without damping whose springs have no mass.
fn of_masses(scene: &mut Scene, node: f64, payload: f64) {
    scene.materials.density = [0.0; 3];
    (scene.physics.node_mass, scene.physics.payload_mass) = (node, payload);
    scene.physics.damping = 0.0;
}

/// Each alone, and both ends of both ranges in one robot.
fn masses_and_stiffnesses(trials: &mut Trials) {
    for stiffness in [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6] {
        trials.free("stiffness", &format!("{stiffness:e} N/m"), |scene| {
            scene.materials.stiffness = [stiffness; 3];
            scene.physics.damping = 0.0;
        });
    }
    for mass in [1e-6, 1e-3, 1.0, 1e3] {
        let what = format!("{mass:e} kg a node");
        trials.free("mass", &what, |scene| of_masses(scene, mass, 0.0));
    }
    let mut stiff = robot(|scene| {
        scene.materials.stiffness = [1e-9, 1e6, 1.0];
        scene.physics.damping = 0.0;
    });
    set_layout(&mut stiff, |edge| Material::ALL[edge % 3]);
    let what = "1e-9, 1 and 1e6 N/m by turns";
    trials.around("ratio", what, &stiff, World::Free);
    let what = "a payload of 1e3 kg on nodes of 1e-6 kg";
    trials.free("ratio", what, |scene| of_masses(scene, 1e-6, 1e3));
}

/// The laws are bars that resist bending, once slender and once so thick that bending has the highest
/// frequency, and springs that stiffen.
fn integrators_and_laws(trials: &mut Trials) {
    use Integrator::{Leapfrog, SymplecticEuler};
    for damping in [1.0, 20.0, 1e4] {
        let what = format!("{damping} 1/s");
        trials.free("damping", &what, |s| s.physics.damping = damping);
    }
    for (what, integrator, substeps) in [
        ("symplectic Euler, 8 substeps", SymplecticEuler, 8),
        ("leapfrog", Leapfrog, 1),
        ("leapfrog, 8 substeps", Leapfrog, 8),
    ] {
        trials.free("integrator", what, |scene| {
            (scene.physics.integrator, scene.physics.substeps) = (integrator, substeps);
        });
    }
    for (what, radius, stiffening) in [
        ("bars of 0.02 m that resist bending", 0.02, 0.0),
        ("bars of 0.1 m", 0.1, 0.0),
        ("stiffening springs", 0.0, 1e4),
    ] {
        trials.free("law", what, |scene| {
            (scene.physics.bending_radius, scene.physics.stiffening) = (radius, stiffening);
        });
    }
}

fn frictions_and_layouts(trials: &mut Trials) {
    for friction in [0.0, 2.5, 1e3, 1e12] {
        let mut case = robot(|scene| scene.physics.contact = ContactLaw::coulomb());
        case.physics.friction = friction;
        case.frozen = None;
        trials.single("friction", &format!("Coulomb, {friction:e}"), case);
    }
    for material in Material::ALL {
        let mut case = robot(|_| {});
        set_layout(&mut case, |_| material);
        let what = format!("all {material:?}").to_lowercase();
        trials.single("layout", &what, case);
    }
}

fn controllers(trials: &mut Trials) {
    let mut actuated = robot(|_| {});
    set_layout(&mut actuated, |_| Material::Actuator);
    for (what, gain) in [
        ("silent: all weights zero", 0.0),
        ("saturated: weights times 1e3", 1e3),
        ("saturated: weights times 1e300", 1e300),
    ] {
        let mut case = actuated.clone();
        case.controller = case.controller.map(|w| w * gain);
        trials.single("controller", what, case);
    }
    let mut stuck = actuated;
    stuck.controller = stuck.controller.map(|_| 0.0);
    stuck.controller.b2.fill(-1e308);
    let what = "all actuators held at full contraction";
    trials.single("controller", what, stuck);
}

fn coincidences(trials: &mut Trials) {
    /// The node in whose place a node starts.
    type Place = fn(usize) -> usize;
    let known: [(&str, Place); 3] = [
        ("two nodes in one place", |i| if i == 1 { 0 } else { i }),
        ("every row in one place", |i| 3 * (i / 3)),
        ("all nodes in one place", |_| 4),
    ];
    for (what, place) in known {
        let mut case = robot(|_| {});
        let from = case.start.x.clone();
        for (i, x) in case.start.x.iter_mut().enumerate() {
            *x = from[place(i)];
        }
        case.frozen = None;
        trials.single("coincidence", what, case);
    }
}

#[cfg(test)]
mod tests {
    use super::{Trial, case_trials};
    use crate::verify::probe::small;
    use cosmic::case::Case;
    use cosmic::scene::Scene;

    #[test]
    fn odd_robots_do_as_expected() {
        let at_rest = |scene: &mut Scene| {
            scene.physics.gravity = 0.0;
            scene.materials.max_strain = [0.0; 3];
        };
        type Change = fn(&mut Scene);
        // Bars that damp have no energy.
        let earth = |scene: &mut Scene| scene.physics = Scene::load("earth").unwrap().physics;
        let cases: [(Change, usize); 6] = [
            (earth, 5),
            // Without springs there is no limit to try time steps around.
            (|scene| scene.materials.stiffness = [0.0; 3], 1),
            (at_rest, 5),
            (|scene| scene.physics.stiffening = 1e5, 5),
            // Trials are longer than the case's own rollout.
            (|scene| scene.physics.steps = 1, 5),
            (|scene| scene.physics.steps = 4, 5),
        ];
        for (change, count) in cases {
            let trials = case_trials(&small([3, 2], change));
            assert_eq!(trials.len(), count);
            for found in trials.iter().map(Trial::run) {
                assert!(found.is_ok(), "{found:?}");
            }
        }
    }

    #[test]
    fn what_starts_far_from_rest_is_tried_with_its_own_time_step_alone() {
        let mut case = Case::of_scene(&Scene::paper(), 0).unwrap();
        case.start.x[1][0] -= 0.9e-2 * case.lattice.rest_length[0];
        assert_eq!(case_trials(&case).len(), 5);
        case.start.x[1] = case.start.x[0];
        let [own] = &case_trials(&case)[..] else {
            panic!("more than its own time step")
        };
        assert!(own.run().is_ok(), "{:?}", own.run());
    }
}
