//! The implicit step in extreme cases: it does not explode, and it keeps momentum. Batches and other number types agree
//! with single rollouts. That its states and gradients are right is tested in `reference_rollouts.rs` and
//! `rollout_gradients.rs`.

use autodiff::Parameters;

use cosmic::case::Case;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::{Lattice, State};
use cosmic::scene::{LatticeKind, LatticeSettings, PhysicsSettings, Scene, edges, stable_step};
use cosmic::world::Span;
use cosmic_tests::{Bare, robot, states};

/// The number of steps of an extreme robot.
const STEPS: usize = 30;

/// Stiffness, mass and time step over nine orders of magnitude, with and without dampers. The speed grows at most as much
/// as a heavy node can drive a light one, and momentum changes by at most 1e-9 of the largest impulse of a bar.
#[test]
fn extreme_robots_do_not_explode_and_keep_their_momentum() {
    let (mut runs, mut refused) = (0, 0);
    for body in &bodies() {
        for forces in ["[]", "['damper']"] {
            for stiffness in [1.0, 1e3, 1e6, 1e9] {
                for mass in [1e-9, 1e-4, 0.1, 1e3] {
                    for dt in [1e-5, 1e-3, 0.1] {
                        let bare = body.robot(stiffness, mass, forces, dt);
                        // A bound on the largest frequency: a node has at most twelve bars, which pull at both ends.
                        let frequency = (24.0 * stiffness / mass).sqrt();
                        if dt > stable_step(&bare.physics, frequency, 0.0) {
                            refused += 1;
                            continue;
                        }
                        runs += 1;
                        let about = format!(
                            "{}, {forces}, {stiffness:e} N/m, {mass:e} kg, {dt:e} s",
                            body.name
                        );
                        assert_keeps(&bare, &body.start(), &about);
                    }
                }
            }
        }
    }
    assert!(runs > 300 && refused > 0, "{runs} runs, {refused} refused");
}

/// Nodes and bars.
struct Body {
    name: &'static str,
    /// The positions at rest, m.
    places: Vec<Vector<f64>>,
    dimension: Dimension,
    edges: Vec<[usize; 2]>,
    /// The masses of nodes, as multiples of a given mass.
    heavy: Vec<f64>,
}

fn bodies() -> [Body; 5] {
    let lattice = |name, columns: usize, rows: usize| Body {
        name,
        places: (0..columns * rows)
            .map(|k| [0.1 * (k % columns) as f64, 0.1 * (k / columns) as f64].into())
            .collect(),
        dimension: Dimension::Plane,
        edges: edges(columns, rows),
        heavy: vec![1.0; columns * rows],
    };
    let mut light = lattice("two heavy nodes on light ones", 2, 2);
    light.heavy = vec![1.0, 1.0, 1e3, 1e3];
    let mut short = lattice("a bar of 1e-6 m", 3, 2);
    short.places[1] = [1e-6, 0.0].into();
    let mut chain = lattice("a chain of 100 bars", 101, 1);
    chain.edges = (0..100).map(|k| [k, k + 1]).collect();
    let settings = LatticeSettings {
        kind: LatticeKind::Cubic,
        columns: 3,
        depth: 2,
        rows: 2,
        ..LatticeSettings::default()
    };
    let laid_out = Lattice::new(&settings, &PhysicsSettings::default());
    let mut heavy = vec![1.0; laid_out.nodes()];
    heavy[3] = 1e3;
    let cubes = Body {
        name: "3x2x2 nodes in space, one of them heavy",
        places: laid_out.positions,
        dimension: Dimension::Space,
        edges: laid_out.edges,
        heavy,
    };
    [lattice("3x3 nodes", 3, 3), light, short, chain, cubes]
}

impl Body {
    /// The robot with bars of this stiffness (N/m) and nodes of this mass (kg), in free flight.
    fn robot(&self, stiffness: f64, mass: f64, forces: &str, dt: f64) -> Bare {
        let length = |&[i, j]: &[usize; 2]| self.places[i].distance(self.places[j]);
        let springs = self.edges.iter();
        let springs: Vec<_> = springs
            .map(|edge| (*edge, length(edge), stiffness))
            .collect();
        let masses: Vec<f64> = self.heavy.iter().map(|heavy| heavy * mass).collect();
        let settings = format!(
            "physics = {{integrator = 'implicit', contact = 'none', forces = {forces}, dt = {dt:e}, gravity = 0.0, \
             damping = 0.0}}"
        );
        let scene = Scene::paper().with("extreme", &settings).unwrap();
        let mut bare = Bare::new(&springs, &masses);
        bare.lattice.dimension = self.dimension;
        Bare {
            physics: scene.physics,
            ..bare
        }
    }

    /// The positions at rest, with velocities of up to 1 m/s that look random.
    fn start(&self) -> State<f64> {
        let noise = |k: usize| (12.9898 * (k as f64 + 1.0)).sin();
        let velocity = |k: usize| {
            let across = noise(1000 + k);
            (self.dimension).onto(Vector::new([noise(2 * k), across, noise(2 * k + 1)]))
        };
        State {
            dimension: self.dimension,
            x: self.places.clone(),
            v: (0..self.places.len()).map(velocity).collect(),
        }
    }
}

#[track_caller]
fn assert_keeps(bare: &Bare, start: &State<f64>, about: &str) {
    let seen = bare.run(start, (0..=STEPS).collect()).states;
    let most = |numbers: &mut dyn Iterator<Item = f64>| numbers.fold(0.0, f64::max);
    let speed = |state: &State<f64>| most(&mut state.v.iter().map(|v| v.norm()));
    let growth = most(&mut seen.iter().map(speed)) / speed(start);
    // A heavy node drives a light one to a few times its speed.
    assert!(growth < 10.0, "{about}: {growth}");
    assert!(seen.iter().all(|state| !state.is_absurd()), "{about}");
    let masses = &bare.body.mass;
    let momentum = |state: &State<f64>| -> Vector<f64> {
        masses.iter().zip(&state.v).map(|(m, v)| *v * *m).sum()
    };
    let impulse = |state: &State<f64>| {
        let edges = bare.lattice.edges.iter().enumerate();
        most(&mut edges.map(|(edge, &[i, j])| {
            let stretched = state.x[i].distance(state.x[j]) - bare.lattice.rest_length[edge];
            bare.physics.dt * bare.body.stiffness[edge] * stretched.abs()
        }))
    };
    // Velocities are rounded at 1e-16 in each step. Of a heavy node, that is more than 1e-9 of a small impulse, so a
    // momentum is compared with at least 1e-5 of the largest momentum of a node.
    let carried = masses.iter().zip(&start.v).map(|(m, v)| m * v.norm());
    let impulse = most(&mut seen.iter().map(impulse)).max(1e-5 * most(&mut { carried }));
    let lost = (momentum(&seen[STEPS]) - momentum(start)).norm() / impulse;
    assert!(lost <= 1e-9, "{about}: {lost:e}");
}

/// A robot with a skeleton of 1e6 N/m stands, pushes and slides. In single precision it does the same for a while.
#[test]
fn a_stiff_robot_runs_in_single_precision() {
    let case = stiff("");
    let exact = states(&case);
    let (world, design) = (case.world(), case.own_design());
    let span = Span::from_start((0..=case.scene.physics.steps).collect());
    let as_designed = (&design, &world.nominal(&case.start));
    let robots = world.robots::<f32>(&[as_designed], &case.controller);
    let single = world.run_one(&robots[0], &span);
    let apart = exact.iter().zip(&single.states).map(|(exact, single)| {
        let pairs = exact.x.iter().zip(&single.x);
        (pairs.map(|(a, b)| a.distance(b.map(f64::from)))).fold(0.0, f64::max)
    });
    let apart = apart.fold(0.0, f64::max);
    // Positions are rounded at 1e-8 m. A stiffness of 1e6 N/m turns that into impulses of 2e-5 N s, which 90 steps add up.
    assert!(apart > 0.0 && apart < 1e-3, "{apart:e} m");
}

fn stiff(more: &str) -> Case {
    robot(&format!(
        "physics = {{integrator = 'implicit', contact = 'coulomb', friction = 0.6{more}}}\nmaterials.stiffness = \
         [1e-7, 1e6, 30.0]"
    ))
}

/// Several robots in one batch have the bits of single rollouts.
#[test]
fn a_batch_of_stiff_robots_has_the_bits_of_single_rollouts() {
    let case = stiff("");
    let (world, own) = (case.world(), case.robot());
    let robot = |k: usize| {
        let mut start = case.start.clone();
        for v in &mut start.v {
            *v = *v * (1.0 + 0.1 * k as f64);
        }
        own.from(&start)
    };
    let robots: Vec<_> = (0..9).map(robot).collect();
    let span = Span::of_steps(case.scene.physics.steps);
    let together = world.run(&robots, &span);
    for (k, (robot, seen)) in robots.iter().zip(&together).enumerate() {
        let alone = world.run_one(robot, &span);
        assert_eq!(alone.states, seen.states, "robot {k}");
    }
}

/// A robot of `workshop` whose actuators pull and push with all their force from the first step on.
fn from_rest(seed: u8) -> Case {
    let mut scene = Scene::load("workshop").unwrap();
    scene.physics.steps = 60;
    let mut case = Case::of_scene(&scene, seed.into()).unwrap();
    let draws = unlike(case.lattice.edges.len(), seed.into());
    let material = |draw: f64| match draw {
        ..-0.3 => Material::Void,
        ..0.3 => Material::Skeleton,
        _ => Material::Actuator,
    };
    case.design = Design::Layout(draws.into_iter().map(material).collect());
    let weights = std::cell::Cell::new(0.7 * f64::from(seed));
    case.controller = case.controller.map(|_| {
        let place = weights.get();
        weights.set(place + 12.9898);
        0.5 * scattered(place)
    });
    case
}

/// A number without a pattern, between -1 and 1.
fn scattered(place: f64) -> f64 {
    (1e4 * place.sin()).sin()
}

fn unlike(count: usize, seed: f64) -> Vec<f64> {
    (0..count)
        .map(|k| scattered(12.9898 * k as f64 + seed))
        .collect()
}

/// The velocities of all nodes after each of these steps.
fn velocities(case: &Case, start: &[Vector<f64>], steps: &[usize]) -> Vec<Vec<Vector<f64>>> {
    let mut from = case.start.clone();
    from.v = start.to_vec();
    let span = Span::from_start(steps.to_vec());
    let seen = (case.world()).run_one(&case.robot().from(&from), &span);
    seen.states.into_iter().map(|state| state.v).collect()
}

fn apart(a: &[Vector<f64>], b: &[Vector<f64>]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// Actuators at their limits have a kink at rest, and the contact decides whether a node rests. Neither lets rounding
/// decide: velocities of 1e-10 m/s at the start change those of later steps by little more.
#[test]
fn rounding_does_not_decide_how_a_robot_leaves_its_rest() {
    for seed in 0..6 {
        let case = from_rest(seed);
        let steps = [1, 2, 10, 60];
        let still = velocities(&case, &case.start.v, &steps);
        let fastest = still[0].iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert!(fastest > 0.1, "{fastest} m/s");
        for draw in 0..4 {
            let moved = unlike(2 * case.start.v.len(), 3.0 + f64::from(draw));
            let moved = moved.chunks(2).map(|v| Vector::upright(v[0], v[1]) * 1e-10);
            let moved = velocities(&case, &moved.collect::<Vec<_>>(), &steps);
            for (step, (still, moved)) in steps.iter().zip(still.iter().zip(&moved)) {
                let apart = apart(still, moved);
                assert!(apart < 1e-8, "seed {seed}, step {step}: {apart:e} m/s");
            }
        }
    }
}
