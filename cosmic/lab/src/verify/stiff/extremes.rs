//! The implicit step on robots with extreme stiffness, masses and time steps.

use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::scene::{PhysicsSettings, Scene, edges, stable_step};
use cosmic::simulator::Store;
use rayon::prelude::*;

use crate::table::{Standing, Table};
use crate::verify::Bare;
use crate::verify::probe::most;

/// The number of steps of a run.
const STEPS: usize = 30;
/// A speed that grows by this factor counts as an explosion. A heavy node drives a light one to a few times its speed.
const GROWTH: f64 = 10.0;
/// The largest change of momentum, as a share of the largest impulse of a bar in a step.
const LOST: f64 = 1e-9;
/// Velocities are rounded at 1e-16 in each step. Of a heavy node, that is more than [`LOST`] of a small impulse, so a
/// momentum is compared with at least this share of the largest momentum of a node.
const CARRIED: f64 = 1e-5;

pub(super) const NOTE: &str = "Extreme robots without ground and gravity begin with random velocities and take 30 implicit \
     steps: stiffness 1, 1e3, 1e6 and 1e9 N/m, nodes of 1e-9, 1e-4, 0.1 and 1e3 kg, time steps of 1e-5, 1e-3 and 0.1 s in \
     every combination. Combinations in which rounding would lose the masses, `(dt omega)^2` above 1e13, are refused. \
     Implicit Euler damps vibrations that it does not resolve, and bars pull along their direction at the end of the step, so \
     energy and angular momentum are lost if bars vibrate or turn fast compared with the step.";

/// The results of all runs of a body, with or without dampers.
#[derive(Clone, Copy, Debug)]
pub struct Extreme {
    body: &'static str,
    has_dampers: bool,
    /// The number of runs.
    pub runs: usize,
    /// The number of combinations that are refused.
    pub refused: usize,
    worst: Losses,
}

/// How much a run loses of what should stay, and how much faster its nodes become.
#[derive(Clone, Copy, Debug)]
struct Losses {
    /// The largest speed, divided by that at the start.
    growth: f64,
    /// The change of momentum, divided by the largest impulse of a bar.
    momentum: f64,
    /// The change of angular momentum about the origin, divided by the sum of `m |x| |v|` at the start.
    angular: f64,
    /// The least and the largest of the energy at the end, divided by that at the start.
    energy: [f64; 2],
}

impl Extreme {
    /// The body, and whether it has dampers.
    pub fn name(&self) -> String {
        let dampers = if self.has_dampers { ", dampers" } else { "" };
        format!("{}{dampers}", self.body)
    }

    /// True if no speed grew too much. NaN counts as growth.
    pub fn is_bounded(&self) -> bool {
        self.worst.growth < GROWTH
    }

    /// True if every run kept its momentum.
    pub fn keeps_momentum(&self) -> bool {
        self.worst.momentum <= LOST
    }
}

/// Tries every body with every stiffness, mass and time step.
pub fn extremes() -> Vec<Extreme> {
    let bodies = Body::all();
    let kinds: Vec<_> = (bodies.iter())
        .flat_map(|body| [false, true].map(|has_dampers| (body, has_dampers)))
        .collect();
    let try_all = |&(body, has_dampers): &(&Body, bool)| tried(body, has_dampers);
    kinds.par_iter().map(try_all).collect()
}

fn tried(body: &Body, has_dampers: bool) -> Extreme {
    let mut found = Extreme {
        body: body.name,
        has_dampers,
        runs: 0,
        refused: 0,
        worst: Losses {
            growth: 0.0,
            momentum: 0.0,
            angular: 0.0,
            energy: [f64::INFINITY, 0.0],
        },
    };
    let physics = physics(has_dampers);
    for stiffness in [1.0, 1e3, 1e6, 1e9] {
        for mass in [1e-9, 1e-4, 0.1, 1e3] {
            for dt in [1e-5, 1e-3, 0.1] {
                let (bare, start) = body.robot(
                    stiffness,
                    mass,
                    PhysicsSettings {
                        dt,
                        ..physics.clone()
                    },
                );
                // A bound on the largest frequency: a node has at most eight bars, which pull at both ends.
                let frequency = (16.0 * stiffness / mass).sqrt();
                if dt > stable_step(&bare.physics, frequency, 0.0) {
                    found.refused += 1;
                    continue;
                }
                found.runs += 1;
                found.worst = found.worst.and(Losses::of(&bare, &start));
            }
        }
    }
    found
}

/// The settings of implicit steps in free flight.
fn physics(has_dampers: bool) -> PhysicsSettings {
    let forces = if has_dampers { "['damper']" } else { "[]" };
    let settings =
        format!("physics = {{integrator = 'implicit', contact = 'none', forces = {forces}}}");
    let scene = Scene::paper().with("extreme", &settings);
    scene.expect("the settings are valid").physics
}

/// Nodes and bars, and their start in motion.
struct Body {
    name: &'static str,
    /// The positions at rest, m.
    places: Vec<[f64; 2]>,
    edges: Vec<[usize; 2]>,
    /// The masses of nodes, as multiples of a given mass.
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

/// A number from -1 to 1 that looks random.
fn noise(k: usize) -> f64 {
    (12.9898 * (k as f64 + 1.0)).sin()
}

impl Losses {
    fn of(bare: &Bare, start: &State<f64>) -> Self {
        let seen = bare.run(start, (0..=STEPS).collect()).states;
        let end = &seen[STEPS];
        let speed = |state: &State<f64>| most(state.v.iter().map(|v| v.norm()));
        let nodes = bare.body.mass.iter().zip(&start.v);
        let carried = CARRIED * most(nodes.map(|(mass, v)| mass * v.norm()));
        let impulse = most(seen.iter().map(|state| impulse(bare, state))).max(carried);
        let spins = each_node(bare, start).map(|(mass, x, v)| mass * x.norm() * v.norm());
        let energy = energy(bare, end) / energy(bare, start);
        Self {
            growth: most(seen.iter().map(speed)) / speed(start),
            momentum: (momentum(bare, end) - momentum(bare, start)).norm() / impulse,
            angular: (spin(bare, end) - spin(bare, start)).abs() / spins.sum::<f64>(),
            energy: [energy, energy],
        }
    }

    /// The worse of each.
    fn and(self, other: Self) -> Self {
        let worse = |of: fn(&Self) -> f64| most([of(&self), of(&other)].into_iter());
        Self {
            growth: worse(|of| of.growth),
            momentum: worse(|of| of.momentum),
            angular: worse(|of| of.angular),
            energy: [
                self.energy[0].min(other.energy[0]),
                worse(|of| of.energy[1]),
            ],
        }
    }
}

/// The mass, position and velocity of each node.
fn each_node<'a>(
    bare: &'a Bare,
    state: &'a State<f64>,
) -> impl Iterator<Item = (f64, Vector<f64>, Vector<f64>)> + 'a {
    let nodes = bare.body.mass.iter().zip(&state.x).zip(&state.v);
    nodes.map(|((mass, x), v)| (*mass, *x, *v))
}

fn momentum(bare: &Bare, state: &State<f64>) -> Vector<f64> {
    each_node(bare, state).map(|(mass, _, v)| v * mass).sum()
}

/// The angular momentum about the origin, kg m^2/s.
fn spin(bare: &Bare, state: &State<f64>) -> f64 {
    each_node(bare, state)
        .map(|(mass, x, v)| mass * x.cross(v))
        .sum()
}

/// The kinetic energy and that of the springs, J.
fn energy(bare: &Bare, state: &State<f64>) -> f64 {
    let mut physics = bare.physics.clone();
    physics.forces = physics.forces.without("damper");
    let store = Store::new(&bare.lattice, &physics, &bare.body);
    store.energy(state).expect("springs have an energy")
}

/// The largest impulse of a spring over a step that ends in this state, N s.
fn impulse(bare: &Bare, state: &State<f64>) -> f64 {
    let edges = bare.lattice.edges.iter().enumerate();
    most(edges.map(|(edge, &[i, j])| {
        let stretched = state.x[i].distance(state.x[j]) - bare.lattice.rest_length[edge];
        bare.physics.dt * bare.body.stiffness[edge] * stretched.abs()
    }))
}

/// The table of the extreme robots.
pub(super) fn table(extremes: &[Extreme]) -> Table {
    Table::of(
        "implicit_extremes",
        "Implicit steps at the extremes",
        extremes,
    )
    .column("body", "nodes and bars", |of| of.body)
    .column("dampers", "whether bars have dampers", |of| {
        if of.has_dampers { "yes" } else { "no" }
    })
    .column("runs", "number of runs", |of| of.runs)
    .column("refused", "combinations that are refused", |of| of.refused)
    .column(
        "growth",
        "largest speed, divided by that at the start",
        |of| of.worst.growth,
    )
    .column(
        "momentum",
        "largest change of momentum, divided by the largest impulse of a bar",
        |of| of.worst.momentum,
    )
    .column(
        "angular",
        "largest change of angular momentum, divided by the sum of m |x| |v| at the start",
        |of| of.worst.angular,
    )
    .column(
        "energy_least",
        "least energy at the end, divided by that at the start",
        |of| of.worst.energy[0],
    )
    .column(
        "energy_most",
        "largest energy at the end, divided by that at the start",
        |of| of.worst.energy[1],
    )
    .mark(Standing::Failed, |of| {
        !(of.is_bounded() && of.keeps_momentum())
    })
    .done()
}
