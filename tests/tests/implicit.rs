//! The implicit step in extreme cases: it does not explode, and it keeps momentum. Batches and other number types agree
//! with single rollouts. That its states and gradients are right is tested in `reference_rollouts.rs` and
//! `rollout_gradients.rs`.

use autodiff::Real;
use cosmic::case::Case;
use cosmic::domain::{Domain, rollouts};
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::scene::{PhysicsSettings, Scene, edges, stable_step};
use cosmic::simulator::Span;
use cosmic_tests::{Bare, robot, states};

/// A number from -1 to 1 that looks random.
fn noise(k: usize) -> f64 {
    (12.9898 * (k as f64 + 1.0)).sin()
}

/// Nodes and bars, and their start in motion.
struct Body {
    name: &'static str,
    /// The positions at rest, m.
    places: Vec<[f64; 2]>,
    edges: Vec<[usize; 2]>,
    /// The masses of nodes, as multiples of the mass of the case.
    heavy: Vec<f64>,
}

impl Body {
    fn lattice(name: &'static str, columns: usize, rows: usize) -> Self {
        let place = |k: usize| [0.1 * (k % columns) as f64, 0.1 * (k / columns) as f64];
        Self {
            name,
            places: (0..columns * rows).map(place).collect(),
            edges: edges(columns, rows),
            heavy: vec![1.0; columns * rows],
        }
    }

    fn all() -> [Self; 4] {
        let mut light = Self::lattice("two heavy nodes on light ones", 2, 2);
        light.heavy = vec![1.0, 1.0, 1e3, 1e3];
        let mut short = Self::lattice("a bar of 1e-6 m", 3, 2);
        short.places[1] = [1e-6, 0.0];
        let mut chain = Self::lattice("a chain of 100 bars", 101, 1);
        chain.edges = (0..100).map(|k| [k, k + 1]).collect();
        [Self::lattice("3x3 nodes", 3, 3), light, short, chain]
    }

    /// The robot with bars of this stiffness (N/m) and nodes of this mass (kg), and its start.
    fn robot(&self, stiffness: f64, mass: f64, physics: PhysicsSettings) -> (Bare, State<f64>) {
        let length = |&[i, j]: &[usize; 2]| {
            let [a, b] = [i, j].map(|node| Vector::new(self.places[node]));
            a.distance(b)
        };
        let springs: Vec<_> = (self.edges.iter())
            .map(|edge| (*edge, length(edge), stiffness))
            .collect();
        let masses: Vec<f64> = self.heavy.iter().map(|heavy| heavy * mass).collect();
        let mut bare = Bare::new(&springs, &masses);
        bare.physics = PhysicsSettings {
            ground_height: bare.physics.ground_height,
            gravity: 0.0,
            damping: 0.0,
            ..physics
        };
        let velocity = |k: usize| [noise(2 * k), noise(2 * k + 1)];
        let start = State::new(
            self.places.clone(),
            (0..masses.len()).map(velocity).collect::<Vec<[f64; 2]>>(),
        );
        (bare, start)
    }
}

fn momentum(bare: &Bare, state: &State<f64>) -> Vector<f64> {
    let terms = bare.body.mass.iter().zip(&state.v);
    terms.map(|(&mass, &v)| v * mass).sum()
}

fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, f64::max)
}

/// The largest impulse of a spring over a step that ends in this state, N s.
fn impulse(bare: &Bare, state: &State<f64>) -> f64 {
    let edges = bare.lattice.edges.iter().enumerate();
    largest(edges.map(|(edge, &[i, j])| {
        let stretched = state.x[i].distance(state.x[j]) - bare.lattice.rest_length[edge];
        bare.physics.dt * bare.body.stiffness[edge] * stretched.abs()
    }))
}

/// Stiffness, mass and time step over nine orders of magnitude, with and without dampers. The speed grows at most as much
/// as a heavy node can drive a light one, and momentum changes by at most 1e-9 of the largest impulse.
#[test]
fn extreme_robots_do_not_explode_and_keep_their_momentum() {
    let (mut runs, mut refused) = (0, 0);
    for body in Body::all() {
        for stiffness in [1.0, 1e3, 1e6, 1e9] {
            for mass in [1e-9, 1e-4, 0.1, 1e3] {
                for dt in [1e-5, 1e-3, 0.1] {
                    for forces in ["[]", "['damper']"] {
                        let settings = format!(
                            "physics = {{integrator = 'implicit', contact = 'none', forces = {forces}, dt = {dt:e}}}"
                        );
                        let scene = Scene::paper().with("test", &settings);
                        let physics = scene.expect("the settings are valid").physics;
                        let (bare, start) = body.robot(stiffness, mass, physics);
                        // A bound on the largest frequency: a node has at most eight bars, which pull at both ends.
                        let frequency = (16.0 * stiffness / mass).sqrt();
                        if dt > stable_step(&bare.physics, frequency, 0.0) {
                            refused += 1;
                            continue;
                        }
                        let name = format!(
                            "{}: {stiffness:e} N/m, {mass:e} kg, {dt:e} s, {forces}",
                            body.name
                        );
                        check(&name, &bare, &start);
                        runs += 1;
                    }
                }
            }
        }
    }
    println!("{runs} runs, {refused} refused");
    assert!(runs > 300 && refused > 0, "{runs} runs, {refused} refused");
}

fn check(name: &str, bare: &Bare, start: &State<f64>) {
    const STEPS: usize = 30;
    let seen = bare.run(start, (0..=STEPS).collect()).states;
    let speed = |state: &State<f64>| largest(state.v.iter().map(|v| v.norm()));
    let growth = largest(seen.iter().map(speed)) / speed(start);
    assert!(growth < 10.0, "{name}: the speed grows by {growth}");
    let lost = (momentum(bare, &seen[STEPS]) - momentum(bare, start)).norm();
    // Velocities are rounded in each of the 30 steps at 1e-16. Of a heavy node, that is more than 1e-9 of a small impulse,
    // but less than 1e-14 of the momentum of the node.
    let nodes = bare.body.mass.iter().zip(&start.v);
    let carried = 1e-5 * largest(nodes.map(|(mass, v)| mass * v.norm()));
    let scale = largest(seen.iter().map(|state| impulse(bare, state))).max(carried);
    assert!(lost <= 1e-9 * scale, "{name}: lost {lost:e} of {scale:e}");
}

/// A robot with a skeleton of 1e6 N/m stands, pushes and slides. In single precision it does the same for a while.
#[test]
fn a_stiff_robot_runs_in_single_precision() {
    let case = stiff("");
    let exact = states(&case);
    let (task, design) = (case.task(), case.own_design());
    let span = Span::from_start((0..=case.physics.steps).collect());
    let domains = [Domain::of(&task, case.start.clone())];
    let controller = case.controller.map(f32::lit);
    let single = rollouts(&[design.lift::<f32>()], &controller, &domains, &span).remove(0);
    let apart = exact.iter().zip(&single.states).map(|(exact, single)| {
        let pairs = exact.x.iter().zip(&single.x);
        largest(pairs.map(|(a, b)| a.distance(b.map(f64::from))))
    });
    let apart = largest(apart);
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
    let (task, design) = (case.task(), case.own_design());
    let start = |k: usize| {
        let mut start = case.start.clone();
        for v in &mut start.v {
            *v = *v * (1.0 + 0.1 * k as f64);
        }
        Domain::of(&task, start)
    };
    let domains: Vec<_> = (0..9).map(start).collect();
    let span = Span::from_start(vec![case.physics.steps]);
    let together = rollouts(&[&design], &case.controller, &domains, &span);
    for (k, (domain, seen)) in domains.iter().zip(&together).enumerate() {
        let alone = task.rollout(&design, &case.controller, &domain.start, &span);
        assert_eq!(alone.states, seen.states, "robot {k}");
    }
}
