//! A simple evolution of robots: it changes bodies and controllers at random, and keeps what walks farther. It has no
//! gradients, and shows what they are worth.

use crate::work::{Work, along};
use cosmic::design::{Design, LayoutRules, Material, VolumeBounds, solid_and_actuators};
use cosmic::policy::Controller;
use cosmic::random::{Purpose, stream, symmetric};
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{Rng, RngExt};
use serde_json::Value;

/// The number of robots that are kept.
const KEPT: usize = 8;
/// The largest change of a weight. Children change by this, or by up to a hundredth of it.
const STRIDE: f64 = 0.5;
/// A random body that keeps to the rules of the scene is drawn at most so many times.
const DRAWS: usize = 100;

/// A robot that was tried.
#[derive(Clone)]
struct Tried {
    materials: Vec<Material>,
    controller: Controller<f64>,
    /// How far it walks, m.
    far: f64,
}

/// What the scene asks of a body.
struct Rules {
    layout: LayoutRules,
    bounds: VolumeBounds,
}

impl Rules {
    fn has_allowed_volumes(&self, materials: &[Material]) -> bool {
        let shares =
            solid_and_actuators(materials).map(|count| count as f64 / materials.len() as f64);
        self.bounds.solid.contains(shares[0]) && self.bounds.actuator.contains(shares[1])
    }
}

/// The robots that are kept, and how many were tried.
pub(crate) struct Evolution {
    random: ChaCha8Rng,
    rules: Rules,
    tries: usize,
    /// The best robot is the first.
    kept: Vec<Tried>,
}

impl Evolution {
    pub(crate) fn new(work: &Work) -> Self {
        let (scene, lattice) = (work.codesign.scene(), work.codesign.world().lattice());
        Self {
            random: stream(work.progress.seed, Purpose::Mutation),
            rules: Rules {
                layout: LayoutRules::new(lattice, &scene.design),
                bounds: VolumeBounds::widened(&scene.volume, 0.0),
            },
            tries: 0,
            kept: Vec::new(),
        }
    }

    /// Tries one more robot: at first a random one, then a child of one that is kept. Returns whether it is the best.
    pub(crate) fn attempt(&mut self, work: &mut Work) -> bool {
        self.tries += 1;
        let (rules, random) = (&self.rules, &mut self.random);
        let mut tried = match self.kept.len() {
            KEPT => child(&self.kept[random.random_range(0..KEPT)], rules, random),
            _ => founder(work, rules, random),
        };
        tried.far = work.far(&tried.materials, &tried.controller);
        let place = self.kept.partition_point(|kept| kept.far >= tried.far);
        self.kept.insert(place, tried);
        self.kept.truncate(KEPT);
        place == 0
    }

    pub(crate) fn tries(&self) -> usize {
        self.tries
    }

    /// The best robot so far, with its rollout.
    pub(crate) fn present(&self, work: &mut Work) -> Value {
        let best = &self.kept[0];
        work.become_robot(&best.materials, &best.controller);
        work.present()
    }
}

impl Work {
    /// How far a robot walks, m; minus infinity if its walk diverges.
    fn far(&mut self, materials: &[Material], controller: &Controller<f64>) -> f64 {
        self.become_robot(materials, controller);
        let last = self.codesign.scene().physics.steps;
        let seen = self.codesign.watch(&self.progress, vec![0, last]);
        let ground = self.codesign.world().ground();
        seen.map_or(f64::NEG_INFINITY, |seen| along(&seen, &ground))
    }

    fn become_robot(&mut self, materials: &[Material], controller: &Controller<f64>) {
        self.progress.design = Design::Layout(materials.to_vec());
        self.progress.controller = controller.clone();
    }
}

/// A random body that the scene allows, with random weights as at the start of a design.
fn founder(work: &Work, rules: &Rules, random: &mut ChaCha8Rng) -> Tried {
    let (scene, lattice) = (work.codesign.scene(), work.codesign.world().lattice());
    let edges = lattice.edges.len();
    let number = |[low, high]: [f64; 2], most: usize, random: &mut ChaCha8Rng| {
        let most = most.min((high * edges as f64) as usize);
        let least = ((low * edges as f64).ceil() as usize).min(most);
        random.random_range(least..=most)
    };
    let mut materials = Vec::new();
    for _ in 0..DRAWS {
        let muscles = number(scene.volume.actuator, edges, random);
        let bars = number(scene.volume.solid, edges, random).max(muscles);
        materials = (0..edges)
            .map(|edge| match edge {
                _ if edge < muscles => Material::Actuator,
                _ if edge < bars => Material::Skeleton,
                _ => Material::Void,
            })
            .collect();
        materials.shuffle(random);
        materials = rules.layout.without_loose_bars(&materials);
        if rules.has_allowed_volumes(&materials) {
            break;
        }
    }
    Tried {
        materials,
        controller: Controller::xavier(&scene.controller, lattice, random.next_u64()),
        far: f64::NEG_INFINITY,
    }
}

/// A robot with other weights than its parent and, every other time, with one or two other bars.
fn child(parent: &Tried, rules: &Rules, random: &mut ChaCha8Rng) -> Tried {
    let mut child = parent.clone();
    let stride = STRIDE * 0.01_f64.powf(random.random());
    for weight in child.controller.numbers_mut() {
        *weight += symmetric(random, stride);
    }
    for _ in 0..random.random_range(0..4_usize).saturating_sub(1) {
        let mut other = child.materials.clone();
        let edge = random.random_range(0..other.len());
        other[edge] = Material::ALL[random.random_range(0..3)];
        let other = rules.layout.without_loose_bars(&other);
        if rules.has_allowed_volumes(&other) {
            child.materials = other;
        }
    }
    child
}
