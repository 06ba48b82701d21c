//! A simple evolution of robots: it changes bodies and controllers at random, and keeps what walks farther. It has no
//! gradients, and shows what they are worth.

use crate::work::{Work, along};
use cosmic::design::{Design, Material, joined_to_payload};
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

/// The robots that are kept, and how many were tried.
pub(crate) struct Evolution {
    random: ChaCha8Rng,
    tries: usize,
    /// The best robot is the first.
    kept: Vec<Tried>,
}

impl Evolution {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            random: stream(seed, Purpose::Mutation),
            tries: 0,
            kept: Vec::new(),
        }
    }

    /// Tries one more robot: at first a random one, then a child of one that is kept. Returns whether it is the best.
    pub(crate) fn attempt(&mut self, work: &mut Work) -> bool {
        self.tries += 1;
        let random = &mut self.random;
        let mut tried = match self.kept.len() {
            KEPT => child(&self.kept[random.random_range(0..KEPT)], work, random),
            _ => founder(work, random),
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
        let seen = self
            .codesign
            .evaluator()
            .watch(&self.progress, vec![0, last]);
        let ground = self.codesign.task().ground();
        seen.map_or(f64::NEG_INFINITY, |seen| along(&seen, &ground))
    }

    fn become_robot(&mut self, materials: &[Material], controller: &Controller<f64>) {
        self.progress.design = Design::Layout(materials.to_vec());
        self.progress.controller = controller.clone();
    }
}

/// A random body that the scene allows, with random weights as at the start of a design.
fn founder(work: &Work, random: &mut ChaCha8Rng) -> Tried {
    let (scene, lattice) = (work.codesign.scene(), &work.codesign.task().lattice);
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
        if keep_to_rules(work, &mut materials) {
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
fn child(parent: &Tried, work: &Work, random: &mut ChaCha8Rng) -> Tried {
    let mut child = parent.clone();
    let stride = STRIDE * 0.01_f64.powf(random.random());
    for weight in child.controller.numbers_mut() {
        *weight += symmetric(random, stride);
    }
    for _ in 0..random.random_range(0..4_usize).saturating_sub(1) {
        let before = child.materials.clone();
        let edge = random.random_range(0..before.len());
        child.materials[edge] = Material::ALL[random.random_range(0..3)];
        if !keep_to_rules(work, &mut child.materials) {
            child.materials = before;
        }
    }
    child
}

/// Removes loose bars, unless the scene allows them. Returns whether the shares of bars and of muscles are within the bounds of
/// the scene.
fn keep_to_rules(work: &Work, materials: &mut [Material]) -> bool {
    let (scene, lattice) = (work.codesign.scene(), &work.codesign.task().lattice);
    if scene.design.one_piece {
        let joined = joined_to_payload(lattice, materials);
        for (material, ends) in materials.iter_mut().zip(&lattice.edges) {
            if !joined[ends[0]] {
                *material = Material::Void;
            }
        }
    }
    let within = |of: fn(Material) -> bool, [low, high]: [f64; 2]| {
        let count = materials.iter().filter(|&&material| of(material)).count();
        (low..=high).contains(&(count as f64 / materials.len() as f64))
    };
    within(Material::is_solid, scene.volume.solid)
        && within(|m| m == Material::Actuator, scene.volume.actuator)
}
