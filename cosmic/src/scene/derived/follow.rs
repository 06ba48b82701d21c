//! Numbers that follow from the robot and its world: the settings whose file says "auto".
//!
//! Two robots that differ only in their size move alike if all lengths grow by a factor `s`, all times by `sqrt(s)`, and
//! all masses by any factor, with stiffness and damping to match. The rules below carry the numbers that were found by
//! experiment for `earth`, a robot of 6x6 nodes, to other robots and worlds in this way. For `earth` they give those
//! numbers to the bit. No rule rounds, so that a robot of four times the size gets the same numbers with another
//! exponent.
//!
//! Stability needs more than similarity: stiff or light bars need shorter mechanical steps than `earth`. A rule for
//! `physics.substeps` takes care of them.

use super::any_design::AnyDesign;
use super::stable_step::STABLE_SHARE;
use crate::geometry::{Dimension, Ground};
use crate::lattice::{Lattice, Material};
use crate::laws::{Actuator, Bumpers, Damper, ForceLaws, Stops};
use crate::scene::sections::MOST_SUBSTEPS;
use crate::scene::{
    BarNumbers, GoalKind, GoalsSettings, PhysicsSettings, Scene, Setting, StartKind,
};
use autodiff::Real;

/// The bars of a robot that needs bars, as a multiple of those that a stiff frame has at least: `studies/gaits.md`.
const SPARE: f64 = 1.2;

/// The numbers of a robot and its world on which the rules are based.
struct Scales {
    /// The horizontal extent of the lattice at rest, divided by that of `earth`, which is 0.5 m.
    length: f64,
    /// The time scale `sqrt(l / g)`, divided by that of `earth`.
    time: f64,
    /// Whether the robot is in the plane or in space.
    dimension: Dimension,
    /// The number of nodes.
    nodes: usize,
    /// The number of edges.
    edges: f64,
    /// The share of the edges that a stiff robot needs, with some to spare; at most 0.9.
    stiff: f64,
    /// The longest mechanical step that is stable for every design, s; infinite if nothing vibrates.
    stable: f64,
    /// True if the nodes together weigh more than the bars of a lattice that is half full.
    heavy_nodes: bool,
    /// True for a truss with fewer than three edges per node. Somebody has chosen these edges, while a lattice offers
    /// more than a robot needs: with half of its edges, an arch collapses.
    sparse: bool,
    /// True if the robot gets as many bars as a stiff frame needs, because it sags or sinks in with half of its edges: it
    /// carries more than a third of what the bars of a half-full lattice weigh, climbs or descends a slope of five degrees or
    /// more, or is a truss of which half the edges cannot be stiff. False with heavy nodes and for a sparse truss, which get
    /// nearly all of their bars.
    firm: bool,
    /// The largest force of an actuator at rest, which its law may limit, divided by the weight of a robot whose lattice
    /// is half full.
    strength: f64,
}

impl Scales {
    fn of(scene: &Scene) -> Self {
        let lattice = Lattice::new(&scene.lattice, Ground::from(&scene.physics));
        let length = match lattice.length() {
            // The nodes of a vertical mast have no extent along the ground.
            0.0 => lattice.spacing,
            length => length,
        } / 0.5;
        let mut physics = scene.physics.clone();
        physics.substeps = 1;
        let bar = scene.materials.of_length(lattice.spacing);
        let [_, densities @ ..] = bar.density;
        let density = 0.5 * densities.iter().sum::<f64>();
        let bars = 0.5 * density * lattice.rest_length.iter().sum::<f64>();
        let nodes = lattice.nodes() as f64 * physics.node_mass;
        let stiffness = Material::Actuator.of(&bar.stiffness);
        let strain = scene.materials.actuator_strain();
        // Without gravity, a robot takes the time of a robot on earth.
        let gravity = match physics.gravity.abs() {
            0.0 => 9.81,
            gravity => gravity,
        };
        let weight = (nodes + bars + physics.payload_mass) * gravity;
        let law: Option<Actuator> = physics.forces.chosen();
        let limit = law.map_or(f64::INFINITY, |law| law.force);
        let any_design = AnyDesign::new(&lattice, &scene.materials, &physics);
        let (edges, stiff_bars) = (lattice.edges.len() as f64, lattice.stiff_bars() as f64);
        let (heavy_nodes, is_truss) = (nodes > bars, scene.lattice.is_truss());
        let sparse = is_truss && lattice.edges.len() < 3 * lattice.nodes();
        let needs_bars = physics.payload_mass > bars / 3.0
            || physics.incline_deg.abs() >= 5.0
            || is_truss && 0.5 * edges < stiff_bars;
        Self {
            stiff: (SPARE * stiff_bars / edges).min(0.9),
            length,
            time: (length * (9.81 / gravity)).sqrt(),
            dimension: lattice.dimension,
            nodes: lattice.nodes(),
            edges,
            heavy_nodes,
            firm: needs_bars && !heavy_nodes && !sparse,
            sparse,
            strength: (stiffness * strain * lattice.spacing).min(limit) / weight,
            stable: any_design.stable_step(scene.robust.faster()),
        }
    }

    /// The factor that keeps the sum of the squares of all observed offsets or velocities as it is for 36 nodes.
    fn per_node(&self) -> f64 {
        (36.0 / self.nodes as f64).sqrt()
    }

    /// The factor by which a robot is more careful than `earth`: below 1 if an actuator can lift more than 1.5 times the
    /// robot's weight. Such a robot flies apart if it begins with full strokes or learns in large steps.
    fn care(&self) -> f64 {
        (1.5 / self.strength).clamp(0.1, 1.0)
    }

    /// The care for steps of the optimiser. What a change of the controller does to a strong robot grows exponentially
    /// with time, so short rollouts need less care.
    fn care_of_rates(&self, physics: &PhysicsSettings) -> f64 {
        let usual = 16.384 * self.time;
        let share = (physics.steps as f64 * physics.dt / usual).min(1.0);
        // The power of the system's libm may differ from machine to machine.
        <f64 as Real>::powf(self.care(), share)
    }
}

/// The iteration that is the same share of the run as iteration `of_300` is of 300.
fn iteration(scene: &Scene, of_300: usize) -> usize {
    (scene.schedule.iterations * of_300 / 300).max(1)
}

/// A rule: the key, and the function that sets it. Rules read the numbers that earlier rules have set.
type Rule = (&'static str, fn(&mut Scene, &Scales));

/// A bar between two neighbouring nodes.
#[derive(Clone, Copy)]
struct Bar {
    /// The rest length, m.
    length: f64,
    numbers: BarNumbers,
}

/// A rule for a setting of a law: the key, and the function that sets it for a bar of the lattice.
type LawRule = (&'static str, fn(&mut Scene, Bar));

/// The rules for the settings of laws. The scales depend on these settings, so they come first.
const LAWS: [LawRule; 4] = [
    ("stops.at", |scene, _| {
        let at = match scene.materials.actuator_strain() {
            // Actuators that do not move have no stops.
            0.0 => 0.27,
            // Devices with a data sheet use their whole stroke.
            strain if scene.physics.forces.chosen::<Actuator>().is_some() => strain,
            strain => 0.27 * (strain / 0.35),
        };
        let laws = &mut scene.physics.forces;
        laws.change(|stops: &mut Stops| stops.at = at);
    }),
    ("stops.stiffness", |scene, bar| {
        let stiffness = 1300.0 * (Material::Actuator.of(&bar.numbers.stiffness) / 30.0);
        let laws = &mut scene.physics.forces;
        laws.change(|stops: &mut Stops| stops.stiffness = stiffness);
    }),
    ("damper.time", |scene, bar| {
        // Half of the bar's mass and a node, divided by its stiffness: the period of its vibration, squared and up to a
        // factor. First that of `earth`.
        const OF_EARTH: f64 = (1e-4 + 0.5 * 0.03 * 0.1) / 400.0;
        let BarNumbers { stiffness, density } = bar.numbers;
        let [stiffness, density] = [stiffness, density].map(|of| Material::Skeleton.of(&of));
        let mass = scene.physics.node_mass + 0.5 * density * bar.length;
        let slower = (mass / stiffness / OF_EARTH).sqrt();
        let laws = &mut scene.physics.forces;
        laws.change(|damper: &mut Damper| damper.time = (2.5e-4 * slower).min(1.0));
    }),
    ("bumpers.stiffness", |scene, bar| {
        let skeleton = Material::Skeleton.of(&bar.numbers.stiffness);
        let laws = &mut scene.physics.forces;
        laws.change(|bumpers: &mut Bumpers| bumpers.stiffness = (5.0 * skeleton).max(1e-9));
    }),
];

/// Every other rule. The declarations of the keys state them in words.
const RULES: [Rule; 24] = [
    ("physics.dt", |scene, world| {
        let physics = &mut scene.physics;
        let substeps = match scene.auto.contains("physics.substeps") {
            true => MOST_SUBSTEPS,
            false => physics.substeps as f64,
        };
        physics.dt = (0.002 * world.time).min(STABLE_SHARE * world.stable * substeps);
    }),
    ("physics.substeps", |scene, world| {
        let physics = &mut scene.physics;
        let least = (physics.dt / (STABLE_SHARE * world.stable)).ceil();
        physics.substeps = least.clamp(1.0, MOST_SUBSTEPS) as usize;
    }),
    ("physics.steps", |scene, world| {
        scene.physics.steps = (16.384 * world.time / scene.physics.dt).round() as usize;
    }),
    ("physics.speed_bound", |scene, world| {
        scene.physics.speed_bound = Some(100.0 * (world.length / world.time));
    }),
    ("schedule.window", |scene, world| {
        // In space robots lose the way: `studies/gaits.md`.
        let helps = world.dimension == Dimension::Plane && scene.can_be_cut();
        scene.schedule.window = helps.then_some(1.024 * world.time);
    }),
    ("schedule.iterations", |scene, _| {
        scene.schedule.iterations = if scene.learns_in_windows() { 75 } else { 300 };
    }),
    ("schedule.snap_at", |scene, _| {
        scene.schedule.snap_at = match scene.start.kind {
            StartKind::Layout => 0,
            // Bars are better chosen one at a time in a gait than before there is one: `studies/gaits.md`.
            _ if scene.learns_in_windows() => 1,
            _ => iteration(scene, 240),
        };
    }),
    ("schedule.attraction_from", |scene, _| {
        scene.schedule.attraction_from = scene.schedule.snap_at * 17 / 24;
    }),
    ("schedule.horizon_over", |scene, _| {
        scene.schedule.horizon_over = [80, 150].map(|of_300| iteration(scene, of_300));
    }),
    ("binarisation.threshold_over", |scene, _| {
        scene.binarisation.threshold_over = [20, 100].map(|of_300| iteration(scene, of_300));
    }),
    ("schedule.horizon", |scene, _| {
        // A goal should be reached within its time.
        let parts = match scene.controller.goals {
            GoalKind::Fixed => [4, 2],
            GoalKind::Given => [2 * GoalsSettings::COUNT, GoalsSettings::COUNT],
        };
        scene.schedule.horizon = parts.map(|part| (scene.physics.steps / part).max(1));
    }),
    ("loss.window", |scene, _| {
        scene.loss.window = (scene.physics.steps / 4)
            .min(scene.schedule.horizon[0])
            .max(1);
    }),
    ("loss.every", |scene, _| {
        scene.loss.every = (scene.loss.window / 128).max(1);
    }),
    ("controller.omega", |scene, world| {
        // A muscle with a shorter stroke makes up for it by more strokes.
        let faster = (0.35 / scene.materials.actuator_strain()).clamp(0.25, 4.0);
        let omega = if world.firm { 20.0 } else { 10.0 };
        scene.controller.omega = omega / world.time * faster;
    }),
    ("controller.goal", |scene, world| {
        scene.controller.goal = [2.0, 0.1].map(|x| x * world.length).into();
    }),
    ("controller.goal_scale", |scene, world| {
        let scale = match scene.controller.goals {
            GoalKind::Fixed => 0.05,
            GoalKind::Given => 3.0,
        };
        scene.controller.goal_scale = scale / world.length;
    }),
    ("goals.along", |scene, world| {
        scene.goals.along = [-1.5, 1.5].map(|x| x * world.length);
    }),
    ("controller.offset_scale", |scene, world| {
        scene.controller.offset_scale = 0.05 / world.length * world.per_node();
    }),
    ("controller.velocity_scale", |scene, world| {
        scene.controller.velocity_scale = 0.05 / (world.length / world.time) * world.per_node();
    }),
    ("controller.gain", |scene, world| {
        let controller = &mut scene.controller;
        let (hidden, clocks) = (controller.hidden as f64, controller.clocks as f64);
        let observed = controller.observation_length(world.dimension, world.nodes) as f64;
        // A weight of a layer is drawn with the variance `2 gain^2 / (inputs + outputs)`.
        let of_clocks = (observed + hidden) / 188.0 * (10.0 / clocks);
        let of_hidden = (hidden + world.edges) / 142.0 * (32.0 / hidden);
        controller.gain =
            [2.0 * of_clocks.sqrt(), 0.2 * of_hidden.sqrt()].map(|gain| gain * world.care());
    }),
    ("adam.rate", |scene, world| {
        scene.adam.rate = 0.004 * world.care_of_rates(&scene.physics);
    }),
    ("adam.fine_rate", |scene, world| {
        scene.adam.fine_rate = 0.003 * world.care_of_rates(&scene.physics);
    }),
    ("volume.solid", |scene, world| {
        scene.volume.solid = if world.heavy_nodes || world.sparse {
            [0.9, 1.0]
        } else if world.firm {
            // In hundredths, so that people can read them.
            [0.0, 10.0].map(|more| ((100.0 * world.stiff).round() + more) / 100.0)
        } else {
            [0.5, 0.5]
        };
    }),
    ("volume.actuator", |scene, world| {
        scene.volume.actuator = if world.heavy_nodes {
            [0.2, 1.0]
        } else if world.firm {
            [0.35, 0.45]
        } else {
            [0.2, 0.22]
        };
    }),
];

impl Scene {
    /// The settings that follow from the robot and its world, in the order in which a scene is written.
    pub fn following(&self) -> Vec<Setting> {
        let mut settings = self.settings();
        settings.retain(|setting| self.auto.contains(&setting.key));
        settings
    }

    /// Computes the settings whose files say "auto". Reading and changing a scene does this. A program that changes the
    /// fields of a scene calls it afterwards; the settings that do not follow from others stay as they are.
    ///
    /// Returns the keys whose new values are out of range.
    pub fn follow(&mut self) -> Vec<String> {
        if self.auto.is_empty() {
            return Vec::new();
        }
        // The scales read the payload.
        if self.auto.contains("lattice.payload") {
            self.lattice.payload = match self.lattice.mirror {
                false => 0,
                true if self.lattice.is_cubic() => self.lattice.depth / 2 * self.lattice.columns,
                true => self.lattice.columns / 2,
            };
        }
        let length = Lattice::new(&self.lattice, Ground::from(&self.physics)).spacing;
        let numbers = self.materials.of_length(length);
        for (key, set) in LAWS {
            if self.auto.contains(key) {
                set(self, Bar { length, numbers });
            }
        }
        let scales = Scales::of(self);
        for (key, set) in RULES {
            if self.auto.contains(key) {
                set(self, &scales);
            }
        }
        let keys = self.auto.clone().into_iter();
        // The settings of a law that the scene has not chosen do not exist.
        let mut fits = |key: &String| {
            self.field(key)
                .is_none_or(|field| field.value.fits(&field.limits))
        };
        keys.filter(|key| !fits(key)).collect()
    }

    /// If numbers of the scene follow from others, lets those of its new laws follow too: the laws that are not among `before`.
    pub(in crate::scene) fn let_new_laws_follow(&mut self, before: &ForceLaws) {
        if self.auto.is_empty() {
            return;
        }
        for (name, settings) in self.physics.forces.settings() {
            if before.laws().all(|law| law.name() != name) {
                let keys = settings.fields().into_iter();
                let keys = keys.filter(|field| !field.auto.is_empty());
                self.auto
                    .extend(keys.map(|field| format!("{name}.{}", field.key)));
            }
        }
    }
}
