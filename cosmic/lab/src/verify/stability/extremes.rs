//! The extremes that are tried.

use super::trial::{Trial, World, silent};
use crate::verify::probe::most;
use cosmic::case::Case;
use cosmic::design::Material;
use cosmic::scene::{Contact, Integrator, Scene, StartKind};
use cosmic::simulator::length;
use cosmic::simulator::stability::{Vibration, stable_step};

/// Steps of a trial: a vibration a twentieth beyond its limit grows a thousandfold in a dozen.
const STEPS: usize = 512;
/// The strain up to which frequencies are those at rest: their squares change by about as much, and
/// the nearest trial is a twentieth from the limit.
const LINEAR: f64 = 0.01;
/// Time steps over the limit that are tried, under it and beyond.
const SHARES: [f64; 4] = [0.5, 0.95, 1.05, 2.0];

/// A case around its own limit, however long its rollout is. What starts far from rest has no limit
/// that holds for longer than its first step.
pub(super) fn of_case(case: &Case) -> Vec<Trial> {
    let mut case = case.clone();
    case.physics.steps = STEPS;
    let own = single(("scene", "its own time step".to_owned()), case.clone());
    let mut trials = vec![own];
    if strain(&case) < LINEAR {
        trials.extend(around(("scene", "without its world"), &case, World::Free));
    }
    trials
}

/// The most that an edge is off its rest length at the start, as a share of it.
fn strain(case: &Case) -> f64 {
    let edges = case.lattice.edges.iter().zip(&case.lattice.rest_length);
    most(edges.map(|(&edge, rest)| (length(&case.start.x, edge) / rest - 1.0).abs()))
}

/// Everything that does not hang on a scene.
pub(super) fn all() -> Vec<Trial> {
    let groups = [
        stiffnesses,
        masses,
        ratios,
        dampings,
        integrators,
        laws,
        time_steps,
        frictions,
        layouts,
        controllers,
        coincidences,
        lattices,
    ];
    groups.into_iter().flat_map(|group| group()).collect()
}

/// A robot of 3x3 nodes of the paper's materials, all skeleton.
fn robot(change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::default();
    (scene.lattice.columns, scene.lattice.rows) = (3, 3);
    (scene.start.kind, scene.controller.hidden) = (StartKind::Uniform, 8);
    scene.physics.steps = STEPS;
    change(&mut scene);
    let mut case = Case::of_scene(&scene, 0).expect("the uniform start fits any lattice");
    case.frozen = Some(vec![Material::Skeleton; case.lattice.edges.len()]);
    case
}

/// The largest frequency of a case at rest, 1/s.
fn frequency(case: &Case) -> f64 {
    let body = case.body();
    Vibration::new(&case.lattice, &body, &case.physics, &case.lattice.positions).largest_frequency()
}

/// A robot with time steps under and over its limit, where there is one.
fn around((group, what): (&'static str, &str), case: &Case, world: World) -> Vec<Trial> {
    let case = &match world {
        World::Free => silent(case),
        World::Driven => case.clone(),
    };
    let frequency = frequency(case);
    let limit = stable_step(&case.physics, frequency);
    if limit.is_infinite() {
        return Vec::new();
    }
    let trial = |share: f64| {
        let mut case = case.clone();
        case.physics.dt = share * limit;
        Trial {
            group,
            what: format!("{what}, dt {share} of the limit"),
            case,
            world,
            frequency,
        }
    };
    SHARES.map(trial).into()
}

/// A robot in its world with its own time step.
fn single((group, what): (&'static str, String), case: Case) -> Trial {
    Trial {
        group,
        what,
        frequency: frequency(&case),
        case,
        world: World::Driven,
    }
}

fn stiffnesses() -> Vec<Trial> {
    let of = |stiffness: f64| {
        let case = robot(|scene| {
            scene.materials.stiffness = [stiffness; 3];
            scene.physics.damping = 0.0;
        });
        around(
            ("stiffness", &format!("{stiffness:e} N/m")),
            &case,
            World::Free,
        )
    };
    [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6]
        .into_iter()
        .flat_map(of)
        .collect()
}

fn masses() -> Vec<Trial> {
    let of = |mass: f64| {
        let case = robot(|scene| {
            scene.materials.density = [0.0; 3];
            (scene.physics.node_mass, scene.physics.payload_mass) = (mass, 0.0);
            scene.physics.damping = 0.0;
        });
        around(("mass", &format!("{mass:e} kg a node")), &case, World::Free)
    };
    [1e-6, 1e-3, 1.0, 1e3].into_iter().flat_map(of).collect()
}

/// Both ends of both ranges in one robot.
fn ratios() -> Vec<Trial> {
    let mut stiff = robot(|scene| {
        scene.materials.stiffness = [1e-9, 1e6, 1.0];
        scene.physics.damping = 0.0;
    });
    let edges = stiff.lattice.edges.len();
    stiff.frozen = Some((0..edges).map(|e| Material::ALL[e % 3]).collect());
    let heavy = robot(|scene| {
        scene.materials.density = [0.0; 3];
        (scene.physics.node_mass, scene.physics.payload_mass) = (1e-6, 1e3);
        scene.physics.damping = 0.0;
    });
    let stiff = around(
        ("ratio", "1e-9, 1 and 1e6 N/m by turns"),
        &stiff,
        World::Free,
    );
    let heavy = around(
        ("ratio", "a payload of 1e3 kg on nodes of 1e-6 kg"),
        &heavy,
        World::Free,
    );
    stiff.into_iter().chain(heavy).collect()
}

fn dampings() -> Vec<Trial> {
    let of = |damping: f64| {
        let case = robot(|scene| scene.physics.damping = damping);
        around(("damping", &format!("{damping} 1/s")), &case, World::Free)
    };
    [1.0, 20.0, 1e4].into_iter().flat_map(of).collect()
}

fn integrators() -> Vec<Trial> {
    let of = |(what, integrator, substeps): (&str, Integrator, usize)| {
        let case = robot(|scene| {
            (scene.physics.integrator, scene.physics.substeps) = (integrator, substeps);
        });
        around(("integrator", what), &case, World::Free)
    };
    let known = [
        (
            "symplectic Euler, 8 substeps",
            Integrator::SymplecticEuler,
            8,
        ),
        ("leapfrog", Integrator::Leapfrog, 1),
        ("leapfrog, 8 substeps", Integrator::Leapfrog, 8),
    ];
    known.into_iter().flat_map(of).collect()
}

/// Bars that resist bending, slender and so thick that this is what vibrates fastest, and springs
/// that would stiffen.
fn laws() -> Vec<Trial> {
    let of = |(what, radius, stiffening): (&str, f64, f64)| {
        let case = robot(|scene| {
            (scene.physics.bending_radius, scene.physics.stiffening) = (radius, stiffening);
        });
        around(("law", what), &case, World::Free)
    };
    let known = [
        ("bars of 0.02 m that resist bending", 0.02, 0.0),
        ("bars of 0.1 m", 0.1, 0.0),
        ("stiffening springs", 0.0, 1e4),
    ];
    known.into_iter().flat_map(of).collect()
}

/// On the ground, with gravity and a controller.
fn time_steps() -> Vec<Trial> {
    let case = robot(|_| {});
    around(
        ("time step", "on the ground, actuated"),
        &case,
        World::Driven,
    )
}

fn frictions() -> Vec<Trial> {
    let of = |friction: f64| {
        let mut case = robot(|scene| scene.physics.contact = Contact::Coulomb);
        case.physics.friction = friction;
        case.frozen = None;
        single(("friction", format!("Coulomb, {friction:e}")), case)
    };
    [0.0, 2.5, 1e3, 1e12].map(of).into()
}

fn layouts() -> Vec<Trial> {
    let of = |material: Material| {
        let mut case = robot(|_| {});
        case.frozen = Some(vec![material; case.lattice.edges.len()]);
        single(("layout", format!("all {material:?}").to_lowercase()), case)
    };
    Material::ALL.map(of).into()
}

fn controllers() -> Vec<Trial> {
    let of = |(what, gain): (&str, f64)| {
        let mut case = robot(|_| {});
        case.controller = case.controller.map(|w| w * gain);
        case.frozen = Some(vec![Material::Actuator; case.lattice.edges.len()]);
        single(("controller", what.to_owned()), case)
    };
    let known = [
        ("silent: all weights zero", 0.0),
        ("saturated: weights times 1e3", 1e3),
        ("saturated: weights times 1e300", 1e300),
    ];
    let mut stuck = robot(|_| {});
    stuck.controller = stuck.controller.map(|_| 0.0);
    stuck.controller.b2.fill(-1e308);
    stuck.frozen = Some(vec![Material::Actuator; stuck.lattice.edges.len()]);
    let what = "all actuators held at full contraction".to_owned();
    let stuck = single(("controller", what), stuck);
    known.map(of).into_iter().chain([stuck]).collect()
}

fn coincidences() -> Vec<Trial> {
    /// The node in whose place a node starts.
    type Place = fn(usize) -> usize;
    let moved = |(what, place): (&str, Place)| {
        let mut case = robot(|_| {});
        let from = case.start.x.clone();
        for (i, x) in case.start.x.iter_mut().enumerate() {
            *x = from[place(i)];
        }
        case.frozen = None;
        single(("coincidence", what.to_owned()), case)
    };
    let known: [(&str, Place); 3] = [
        ("two nodes in one place", |i| if i == 1 { 0 } else { i }),
        ("every row in one place", |i| 3 * (i / 3)),
        ("all nodes in one place", |_| 4),
    ];
    known.map(moved).into()
}

fn lattices() -> Vec<Trial> {
    let of = |side: usize| {
        let case = robot(|scene| {
            (scene.lattice.columns, scene.lattice.rows) = (side, side);
            (scene.physics.damping, scene.physics.steps) = (0.0, STEPS / 2);
        });
        around(
            ("lattice", &format!("{side}x{side} nodes")),
            &case,
            World::Free,
        )
    };
    [2, 3, 6, 10, 20, 40].into_iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::of_case;
    use cosmic::case::Case;
    use cosmic::scene::Scene;

    fn all_are_well(change: impl FnOnce(&mut Scene)) -> usize {
        let mut scene = Scene::default();
        (scene.lattice.columns, scene.lattice.rows) = (3, 2);
        change(&mut scene);
        let trials = of_case(&Case::of_scene(&scene, 0).unwrap());
        for trial in &trials {
            let found = trial.run();
            assert!(found.is_ok(), "{found:?}");
        }
        trials.len()
    }

    #[test]
    fn what_does_not_vibrate_has_no_limit_to_be_tried() {
        assert_eq!(
            all_are_well(|scene| scene.materials.stiffness = [0.0; 3]),
            1
        );
    }

    #[test]
    fn what_nothing_moves_does_not_grow() {
        let at_rest = |scene: &mut Scene| {
            scene.physics.gravity = 0.0;
            scene.materials.max_strain = [0.0; 3];
        };
        assert_eq!(all_are_well(at_rest), 5);
    }

    #[test]
    fn springs_that_stiffen_are_tried_without_their_stroke() {
        let stiffening = |scene: &mut Scene| scene.physics.stiffening = 1e5;
        assert_eq!(all_are_well(stiffening), 5);
    }

    #[test]
    fn a_case_is_tried_for_longer_than_its_own_rollout() {
        for steps in [1, 4] {
            assert_eq!(all_are_well(|scene| scene.physics.steps = steps), 5);
        }
    }

    #[test]
    fn what_starts_far_from_rest_is_tried_with_its_own_time_step_alone() {
        let mut case = Case::of_scene(&Scene::default(), 0).unwrap();
        case.start.x[1][0] -= 0.9e-2 * case.lattice.rest_length[0];
        assert_eq!(of_case(&case).len(), 5);
        case.start.x[1] = case.start.x[0];
        let [own] = &of_case(&case)[..] else {
            panic!("more than its own time step")
        };
        assert!(own.run().is_ok(), "{:?}", own.run());
    }
}
