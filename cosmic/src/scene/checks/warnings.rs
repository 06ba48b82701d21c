//! Warnings about settings that can be simulated but are probably a mistake.

use crate::geometry::{Range, Vector};
use crate::lattice::{Doubt, Lattice, Material};
use crate::laws::Stops;
use crate::numbers::rounded;
use crate::scene::{
    BarNumbers, DataSheet, Integrator, ProfileKind, SLENDERNESS, Scene, Setting, StartKind,
};
use serde::Serialize;
use std::collections::HashSet;
use std::f64::consts::PI;
use std::fmt;

/// A warning about settings of a scene.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The settings that the warning is about. The user should change the first one.
    pub settings: Vec<Setting>,
    /// The problem, in a sentence.
    pub says: String,
    /// The change that would solve the problem. May be empty.
    pub remedy: String,
}

impl Finding {
    /// Makes a warning about the settings with the given keys.
    ///
    /// # Panics
    /// If the scene does not have one of the keys.
    pub(crate) fn new(scene: &Scene, keys: &[&str], says: String, remedy: String) -> Self {
        let all = scene.settings();
        let setting = |key: &&str| all.iter().find(|s| s.key == *key).cloned();
        Finding {
            settings: (keys
                .iter()
                .map(|key| setting(key).expect("a key of a scene")))
            .collect(),
            says,
            remedy,
        }
    }
}

/// Writes the problem, then the settings with their values, then the remedy.
impl fmt::Display for Finding {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let settings = self.settings.iter();
        let settings: Vec<_> = settings
            .map(|s| format!("{} = {}", s.key, s.value))
            .collect();
        write!(out, "{} ({})", self.says, settings.join(", "))?;
        if !self.remedy.is_empty() {
            write!(out, "; {}", self.remedy)?;
        }
        Ok(())
    }
}

/// A possible warning: the condition under which it is given, the keys that it is about, and the problem.
struct WarningRule {
    holds: fn(&Scene) -> bool,
    keys: &'static [&'static str],
    says: &'static str,
}

/// Makes a list of possible warnings. Each has its keys, a sentence about the problem, and the condition under which it
/// is given.
macro_rules! warnings {
    ($([$($key:literal),+]: $says:literal if $holds:expr;)+) => {
        [$(WarningRule { keys: &[$($key),+], says: $says, holds: $holds }),+]
    };
}

const WARNINGS: &[WarningRule] = &warnings! {
    ["materials.stiffness"]: "void is at least as stiff as skeleton"
        if |s| stiffness(s, Material::Void) >= stiffness(s, Material::Skeleton);
    ["materials.stiffness"]: "void is at least as stiff as an actuator"
        if |s| stiffness(s, Material::Void) >= stiffness(s, Material::Actuator);
    ["materials.density"]: "void is heavier than a solid material"
        if |s| {
            let [void, skeleton, actuator] = typical(s).density;
            void > skeleton.min(actuator)
        };
    ["materials.max_strain"]: "actuators do not move: their largest strain is 0"
        if |s| strain(s) == 0.0;
    ["stops.at", "materials.max_strain"]: "the end stops lie beyond the stroke of the actuators, so an actuator is not stopped at the end of its stroke"
        if |s| stops(s).is_some_and(|stops| 0.0 < strain(s) && strain(s) < stops.at);
    ["stops.stiffness", "materials.stiffness"]: "the end stops are softer than the actuators that run into them"
        if |s| stops(s).is_some_and(|stops| {
            // The stiffness counts for actuators with the strain of the stops.
            stops.stiffness * strain(s) / stops.at < stiffness(s, Material::Actuator) && 0.0 < strain(s)
        });
    ["volume.actuator"]: "no edge may be an actuator"
        if |s| s.volume.actuator[1] == 0.0 && s.start.kind != StartKind::Layout;
    ["volume.solid"]: "fewer bars may exist than a stiff robot needs, which is two for each node less three in the plane, and three less six in space: every design sags or sinks in"
        if |s| {
            // The paper's own share is a default.
            s.designs() && s.volume.solid != Scene::paper().volume.solid && {
                let lattice = Lattice::new(&s.lattice, &s.physics);
                let edges = lattice.edges.len();
                let allowed = (s.volume.solid[1] * edges as f64).round() as usize;
                (allowed + 1..=edges).contains(&lattice.stiff_bars())
            }
        };
    ["physics.gravity"]: "gravity points up"
        if |s| s.physics.gravity < 0.0;
    ["physics.gravity", "physics.contact"]: "without gravity the robot does not rest on the ground"
        if |s| s.physics.contact.has_ground() && s.physics.gravity == 0.0;
    ["physics.incline_deg"]: "the ground is inclined by less than a degree; the angle is in degrees, not in radians"
        if |s| 0.0 < s.physics.incline_deg.abs() && s.physics.incline_deg.abs() < 1.0;
    ["schedule.horizon", "physics.steps"]: "the horizon is longer than the rollout and ends with it"
        if |s| s.schedule.horizon.iter().any(|&steps| steps > s.physics.steps);
    ["physics.contact", "physics.gravity"]: "the robot falls forever: there is no ground"
        if |s| !s.physics.contact.has_ground() && s.physics.gravity > 0.0;
    ["physics.friction", "physics.contact"]: "nothing holds the robot's feet: the ground has no friction"
        if |s| s.physics.contact.name() == "coulomb" && s.physics.friction == 0.0;
    ["lattice.drop"]: "the lowest nodes start below the ground"
        if |s| s.physics.contact.has_ground() && s.lattice.drop < 0.0 && !s.lattice.is_truss();
    ["lattice.file"]: "nodes of the truss start below the ground"
        if |s| s.physics.contact.has_ground() && s.lattice.lowest() < 0.0 && s.lattice.is_truss();
    ["ground.profile", "lattice.drop"]: "the lowest nodes start below the profile of the ground"
        if |s| s.physics.contact.has_ground() && s.lattice.lowest() >= 0.0 && starts_inside(s);
    ["ground.count", "ground.spacing"]: "the rough ground ends within eight lengths of the robot; the ground beyond it is flat"
        if ends_soon;
    ["controller.gain", "lattice.columns", "lattice.rows"]: "the initial controller barely moves so many nodes; use the controller settings of the scene \"large\""
        if |s| {
            let nodes = s.lattice.nodes();
            let is_default = s.controller.gain == Scene::paper().controller.gain;
            nodes > 100 && !s.lattice.is_truss() && is_default
        };
    ["controller.omega"]: "the clock does not advance"
        if |s| s.controller.omega == 0.0;
    ["controller.omega", "physics.dt"]: "the clock advances by half a period or more in a time step"
        if |s| s.controller.omega * s.physics.dt >= PI;
};

/// The end stops, if the scene has chosen them.
fn stops(scene: &Scene) -> Option<Stops> {
    scene.physics.forces.chosen()
}

/// The largest strain of the actuators.
fn strain(scene: &Scene) -> f64 {
    scene.materials.actuator_strain()
}

/// The stiffness of a bar of this material between two neighbouring nodes, N/m.
fn stiffness(scene: &Scene, material: Material) -> f64 {
    material.of(&typical(scene).stiffness)
}

/// The numbers of a bar between two neighbouring nodes.
fn typical(scene: &Scene) -> BarNumbers {
    scene.materials.of_length(scene.lattice.spacing)
}

/// True if a node starts below the profile of the ground. Of a generated lattice, only the lowest row is checked.
fn starts_inside(scene: &Scene) -> bool {
    let (lattice, profile) = (&scene.lattice, scene.physics.ground.resolved());
    let is_inside = |place: Vector<f64>| profile.above(place) < 0.0;
    if let Some(truss) = lattice.file.truss() {
        return truss.nodes.iter().copied().any(is_inside);
    }
    let place = |column: usize| column as f64 * lattice.spacing;
    (0..lattice.columns).any(|column| is_inside(Vector::upright(place(column), lattice.drop)))
}

/// True if the rough ground ends less than eight robot lengths ahead of the robot. Good robots walk farther.
fn ends_soon(scene: &Scene) -> bool {
    const LENGTHS: f64 = 8.0;
    let (lattice, ground) = (&scene.lattice, &scene.physics.ground);
    if ground.profile != ProfileKind::Rough || !scene.physics.contact.has_ground() {
        return false;
    }
    let profile = ground.resolved();
    let Some(end) = profile.points().last() else {
        return false;
    };
    let robot = match lattice.file.truss() {
        None => {
            let width = (lattice.columns - 1) as f64 * lattice.spacing;
            Range::new(0.0, width)
        }
        Some(truss) => Range::of(truss.nodes.iter().map(|node| node.forward())),
    };
    end.forward() < robot.high + LENGTHS * robot.size()
}

impl Scene {
    /// Warnings about valid settings that are probably a mistake, such as void that is stiffer than skeleton. Changed
    /// settings that have no effect are included.
    pub fn warnings(&self) -> Vec<Finding> {
        let in_doubt = WARNINGS.iter().filter(|warning| (warning.holds)(self));
        in_doubt
            .map(|warning| Finding::new(self, warning.keys, warning.says.into(), String::new()))
            .chain(of_truss(self))
            .chain(nonsense(self))
            .chain(many_substeps(self))
            .chain(misfits(self))
            .chain(slides(self))
            .chain(too_heavy(self))
            .chain(self.unread())
            .collect()
    }
}

/// Warnings about parts that do not fit the edges of the lattice.
fn misfits(scene: &Scene) -> Vec<Finding> {
    let (sheet, mut found) = (scene.data_sheet(), Vec::new());
    if sheet == DataSheet::default() {
        return found;
    }
    let lengths = Lattice::new(&scene.lattice, &scene.physics).rest_length;
    let all = lengths.len();
    let shortest = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let mut warn = |keys: &[&str], says| found.push(Finding::new(scene, keys, says, String::new()));
    if let Some(device) = sheet.length {
        let is_short = |length: &&f64| device.room(**length) < device.least;
        let short = lengths.iter().filter(is_short).count();
        let (key, what) = match device.is_stated {
            true => ("parts.length", "is"),
            false => ("parts.stroke", "has a stroke, so it must be at least"),
        };
        if short > 0 {
            let says = format!(
                "{short} of {all} edges are too short for an actuator: the shortest shrinks to {:.4} m, but the device {what} {} m long",
                device.room(shortest),
                device.least
            );
            warn(&[key, "materials.max_strain"], says);
        }
    }
    if let Some(thickness) = sheet.thickness {
        let [_, least] = SLENDERNESS.map(|ratio| ratio * thickness);
        let short = lengths.iter().filter(|length| **length < least).count();
        if short > 0 {
            let says = format!(
                "{short} of {all} edges are too short for a skeleton bar that is {thickness} m thick: the shortest is \
                 {shortest:.4} m long"
            );
            warn(&["parts.outer"], says);
        }
    }
    found
}

/// The smallest plausible size of a robot, and a size that no robot of this kind has reached, m. Their ratio is 1000, so
/// lengths in millimetres are noticed for a robot of any size.
const SIZES: Range = Range {
    low: 0.005,
    high: 5.0,
};

/// Warnings about a robot of an implausible size, a robot far above the ground, and a rollout that is too short for a
/// stride.
fn nonsense(scene: &Scene) -> Vec<Finding> {
    let (lattice, physics) = (&scene.lattice, &scene.physics);
    let size = scene.extent().largest();
    let of_robot = match lattice.is_truss() {
        true => "lattice.file",
        false => "lattice.spacing",
    };
    let warn = |keys: &[&str], says: String, remedy: &str| {
        Finding::new(scene, keys, says, remedy.to_owned())
    };
    let mut found = Vec::new();
    if !(SIZES.low..SIZES.high).contains(&size) {
        let says = format!("the robot measures {} m", rounded(size, 3));
        let remedy = match size > SIZES.high {
            true => "lengths are in metres; divide lengths in millimetres by 1000",
            false => "lengths are in metres",
        };
        found.push(warn(&[of_robot], says, remedy));
    }
    let above = lattice.lowest();
    if physics.contact.has_ground() && above > (0.5 * size).min(1.0) {
        let key = match lattice.is_truss() {
            true => "lattice.file",
            false => "lattice.drop",
        };
        let says = format!("the robot starts {} m above the ground", rounded(above, 3));
        found.push(warn(&[key], says, "move its lowest node to the ground"));
    }
    let (lasts, stride) = (
        physics.steps as f64 * physics.dt,
        2.0 * PI / scene.controller.omega,
    );
    if lasts < stride && stride.is_finite() {
        let says = format!(
            "a rollout lasts {} s, which is less than a period of the clock ({} s)",
            rounded(lasts, 3),
            rounded(stride, 3)
        );
        let keys = ["physics.steps", "physics.dt", "controller.omega"];
        found.push(warn(&keys, says, "raise physics.steps"));
    }
    found
}

/// Warnings about a truss: that it is in pieces, or that its shape is in doubt.
fn of_truss(scene: &Scene) -> Vec<Finding> {
    if let Some(pieces) = of_truss_in_pieces(scene) {
        return vec![pieces];
    }
    let doubts = scene.lattice.file.truss().map(|truss| truss.doubts());
    let finding = |doubt: Doubt| Finding::new(scene, &["lattice.file"], doubt.says, doubt.remedy);
    doubts.into_iter().flatten().map(finding).collect()
}

/// A warning about a truss whose edges do not connect all of its nodes.
fn of_truss_in_pieces(scene: &Scene) -> Option<Finding> {
    let truss = scene.lattice.file.truss()?;
    let mut piece: Vec<usize> = (0..truss.nodes.len()).collect();
    let forbidden: HashSet<usize> = truss.rules.forbid.iter().copied().collect();
    let edges = (truss.edges.iter().enumerate()).filter(|(edge, _)| !forbidden.contains(edge));
    for (_, &[i, j]) in edges {
        let (from, to) = (piece[i], piece[j]);
        (piece.iter_mut().filter(|of| **of == from)).for_each(|of| *of = to);
    }
    let pieces: HashSet<usize> = piece.iter().copied().collect();
    let other = piece.iter().position(|of| *of != piece[0])?;
    let says = format!(
        "the truss is in {} pieces: no chain of edges connects node 0 with node {other}",
        pieces.len()
    );
    let remedy = "add edges between the pieces, or merge nodes at the same place".to_owned();
    Some(Finding::new(scene, &["lattice.file"], says, remedy))
}

/// Explicit steps with more substeps than this are slower than implicit steps by far.
const MANY_SUBSTEPS: usize = 64;

/// A warning about a scene that needs many short mechanical steps. The implicit step needs few, because it is stable for
/// stiff bars.
fn many_substeps(scene: &Scene) -> Option<Finding> {
    let physics = &scene.physics;
    let (steps, substeps) = (physics.steps, physics.substeps);
    if physics.integrator == Integrator::Implicit || substeps <= MANY_SUBSTEPS {
        return None;
    }
    let mut implicit = scene.clone();
    implicit.physics.integrator = Integrator::Implicit;
    implicit.follow();
    let fewer = implicit.physics.steps * implicit.physics.substeps;
    let remedy = match fewer < steps * substeps {
        true => format!(
            "set physics.integrator = \"implicit\": a rollout then takes {fewer} mechanical steps"
        ),
        false => "set physics.integrator = \"implicit\" and physics.substeps = 1".to_owned(),
    };
    let says = format!(
        "light or stiff bars make the simulation slow: a rollout takes {} mechanical steps",
        steps * substeps
    );
    let keys = ["physics.integrator", "physics.steps", "physics.substeps"];
    Some(Finding::new(scene, &keys, says, remedy))
}

/// The margin of friction below which a scene is doubtful. A foot that pushes the robot up the slope needs more friction
/// than one that only holds it.
const FRICTION_MARGIN: f64 = 1.2;

/// A warning if a robot at rest slides down the slope, or nearly so.
fn slides(scene: &Scene) -> Option<Finding> {
    let margin = scene.friction_margin()?;
    let says = match margin {
        ..1.0 => "the robot slides down the slope",
        ..FRICTION_MARGIN => "the robot barely stays in place on the slope",
        _ => return None,
    };
    let least = scene.physics.incline_deg.to_radians().tan().abs();
    let keys = ["physics.incline_deg", "physics.friction"];
    let remedy = format!("a friction of {least:.2} holds it at rest; walking needs more");
    Some(Finding::new(scene, &keys, says.to_owned(), remedy))
}

/// A warning if the payload is heavier than what the actuators can lift.
fn too_heavy(scene: &Scene) -> Option<Finding> {
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let weight = scene.payload_mass(&lattice) * scene.physics.gravity.abs();
    let lift = scene.lift(&lattice);
    (weight > lift).then(|| {
        let says = format!(
            "the payload weighs {weight:.3} N, but the actuators can lift {lift:.3} N at most"
        );
        let remedy = "choose a lighter payload or stronger actuators".to_owned();
        Finding::new(scene, &["physics.payload_mass"], says, remedy)
    })
}
