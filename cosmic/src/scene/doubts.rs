//! Settings that can be simulated and are probably a mistake.

use super::{ProfileKind, Scene, Setting, StartKind};
use crate::geometry::{Range, Vector};
use serde::Serialize;
use std::f64::consts::PI;
use std::fmt;

/// A remark about a scene's settings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The settings that the remark is about. The first one is the one to change.
    pub settings: Vec<Setting>,
    /// The problem.
    pub says: String,
    /// The change that would solve the problem; may be empty.
    pub remedy: String,
}

impl Finding {
    /// A remark about settings of a scene.
    ///
    /// # Panics
    /// If the scene has no such key.
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

/// Remark, settings with their values, and remedy.
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

/// A setting that is probably a mistake.
struct Doubt {
    holds: fn(&Scene) -> bool,
    keys: &'static [&'static str],
    says: &'static str,
}

const DOUBTS: [Doubt; 16] = [
    Doubt {
        holds: |s| s.materials.stiffness[0] >= s.materials.stiffness[1],
        keys: &["materials.stiffness"],
        says: "void is at least as stiff as skeleton",
    },
    Doubt {
        holds: |s| s.materials.stiffness[0] >= s.materials.stiffness[2],
        keys: &["materials.stiffness"],
        says: "void is at least as stiff as an actuator",
    },
    Doubt {
        holds: |s| s.materials.density[0] > s.materials.density[1].min(s.materials.density[2]),
        keys: &["materials.density"],
        says: "void is heavier than a solid material",
    },
    Doubt {
        holds: |s| s.materials.max_strain[2] == 0.0,
        keys: &["materials.max_strain"],
        says: "actuators do not move: their largest strain is 0",
    },
    Doubt {
        holds: |s| s.volume.actuator[1] == 0.0 && s.start.kind != StartKind::Layout,
        keys: &["volume.actuator"],
        says: "no edge may be an actuator",
    },
    Doubt {
        holds: |s| s.physics.gravity < 0.0,
        keys: &["physics.gravity"],
        says: "gravity points up",
    },
    Doubt {
        holds: |s| !s.physics.contact.has_ground() && s.physics.gravity > 0.0,
        keys: &["physics.contact", "physics.gravity"],
        says: "the robot falls forever: there is no ground",
    },
    Doubt {
        holds: |s| s.physics.contact.name() == "coulomb" && s.physics.friction == 0.0,
        keys: &["physics.friction", "physics.contact"],
        says: "nothing holds the robot's feet: the ground has no friction",
    },
    Doubt {
        holds: |s| s.physics.contact.has_ground() && s.lattice.drop < 0.0 && !s.lattice.is_truss(),
        keys: &["lattice.drop"],
        says: "the lowest nodes start below the ground",
    },
    Doubt {
        holds: |s| {
            s.physics.contact.has_ground() && s.lattice.lowest() < 0.0 && s.lattice.is_truss()
        },
        keys: &["lattice.file"],
        says: "nodes of the truss start below the ground",
    },
    Doubt {
        holds: |s| s.physics.contact.has_ground() && s.lattice.lowest() >= 0.0 && starts_inside(s),
        keys: &["ground.profile", "lattice.drop"],
        says: "the lowest nodes start below the profile of the ground",
    },
    Doubt {
        holds: ends_soon,
        keys: &["ground.count", "ground.spacing"],
        says: "the rough ground ends within eight lengths of the robot; the ground beyond it is flat",
    },
    Doubt {
        holds: |s| {
            let nodes = s.lattice.columns * s.lattice.rows;
            nodes > 100
                && !s.lattice.is_truss()
                && s.controller.gain == Scene::paper().controller.gain
        },
        keys: &["controller.gain", "lattice.columns", "lattice.rows"],
        says: "the first controller barely moves so many nodes; the controller settings of the scene \"large\" suit them",
    },
    Doubt {
        holds: |s| s.controller.omega == 0.0,
        keys: &["controller.omega"],
        says: "the clock stands still",
    },
    Doubt {
        holds: |s| s.controller.omega * s.physics.dt >= PI,
        keys: &["controller.omega", "physics.dt"],
        says: "the clock turns by half a period or more in a time step",
    },
    Doubt {
        holds: |s| s.selection.perturbation == 0.0,
        keys: &["selection.perturbation"],
        says: "all perturbed starts are equal, so medians over them are meaningless",
    },
];

/// True if a node of the lowest row starts below the profile.
fn starts_inside(scene: &Scene) -> bool {
    let (lattice, profile) = (&scene.lattice, scene.physics.ground.resolved());
    let is_inside = |place: Vector<f64>| profile.above(place) < 0.0;
    if let Some(truss) = lattice.file.truss() {
        return truss.nodes.iter().copied().any(is_inside);
    }
    let place = |column: usize| lattice.origin_x + column as f64 * lattice.spacing;
    (0..lattice.columns).any(|column| is_inside(Vector::new([place(column), lattice.drop])))
}

/// True if the rough ground ends within eight robot lengths ahead of the robot. Good robots walk
/// farther.
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
            Range::new(lattice.origin_x, lattice.origin_x + width)
        }
        Some(truss) => Range::of(truss.nodes.iter().map(|node| node.forward())),
    };
    end.forward() < robot.high + LENGTHS * robot.size()
}

impl Scene {
    /// Valid settings that are probably a mistake, such as void that is stiffer than skeleton, and settings that
    /// nothing reads.
    pub fn doubts(&self) -> Vec<Finding> {
        let in_doubt = DOUBTS.iter().filter(|doubt| (doubt.holds)(self));
        in_doubt
            .map(|doubt| Finding::new(self, doubt.keys, doubt.says.into(), String::new()))
            .chain(self.unread())
            .collect()
    }
}
