//! Describes the robot and the world of a scene, each in one line.

use crate::geometry::{Dimension, Vector};
use crate::lattice::Lattice;
use crate::numbers::{rounded, shortened};
use crate::scene::keys::Setting;
use crate::scene::{ActuatorPart, ProfileKind, Scene, SkeletonPart};
use crate::settings::Named;

/// The keys of `[physics]` that [`Scene::describe_world`] mentions, followed by those that do not describe the world: the
/// masses, which are in the description of the robot, and the keys that say how a rollout is computed.
const KNOWN: [&str; 15] = [
    "gravity",
    "contact",
    "friction",
    "incline_deg",
    "damping",
    "forces",
    "node_mass",
    "payload_mass",
    "dt",
    "steps",
    "integrator",
    "substeps",
    "void_edges",
    "speed_bound",
    "unstable_step",
];

impl Scene {
    /// A description of the robot in one line: its lattice, its size, its mass, and its payload. The mass is that of a
    /// robot whose volume is in the middle of the bounds on the volume.
    pub fn describe_robot(&self) -> String {
        let lattice = Lattice::new(&self.lattice, &self.physics);
        let [long, wide, high] = self.extent().map(|x| rounded(x, 3)).array();
        let wide = match lattice.dimension {
            Dimension::Plane => String::new(),
            Dimension::Space => format!(", {wide} m wide"),
        };
        let solid = 0.5 * self.volume.solid.iter().sum::<f64>();
        let of_bar = |&length: &f64| {
            let [_, skeleton, actuator] = self.materials.of_length(length).density;
            0.5 * (skeleton + actuator) * length
        };
        let bars: f64 = lattice.rest_length.iter().map(of_bar).sum();
        let nodes = lattice.nodes() as f64 * self.physics.node_mass;
        format!(
            "{}, {} nodes, {} edges; {long} m long{wide}, {high} m high; about {} kg and a payload of {} kg",
            self.lattice.name(),
            lattice.nodes(),
            lattice.edges.len(),
            rounded(nodes + solid * bars, 3),
            rounded(self.payload_mass(&lattice), 3),
        )
    }

    /// The length, the width and the height of the robot at rest, m; in the plane the width is 0.
    pub(in crate::scene) fn extent(&self) -> Vector<f64> {
        let lattice = Lattice::new(&self.lattice, &self.physics);
        lattice.extent() * lattice.spacing
    }

    /// A description of the world in one line: gravity, contact and friction, drag, damping of the bars, and end stops.
    /// Other forces, an incline, a ground profile, parts and any other physics are named if the scene has them.
    pub fn describe_world(&self) -> String {
        let physics = &self.physics;
        let mut parts = vec![format!("gravity {} m/s\u{b2}", physics.gravity)];
        parts.push(match physics.contact.name() {
            "none" => "no ground".to_owned(),
            "infinite" => "feet never slip (contact infinite)".to_owned(),
            name if self.slips() => {
                let friction = physics.friction;
                format!("feet slip at friction {friction} (contact {name})")
            }
            name => format!("contact {name}"),
        });
        if physics.incline_deg != 0.0 {
            parts.push(format!("incline {} degrees", physics.incline_deg));
        }
        if physics.contact.has_ground() && physics.ground.profile != ProfileKind::Flat {
            parts.push(format!("ground {}", physics.ground.profile.name()));
        }
        parts.push(match physics.damping {
            0.0 => "no drag".to_owned(),
            rate => format!("drag {rate} per second"),
        });
        let bars = &self.materials.parts;
        if bars.skeleton != SkeletonPart::Numbers {
            let (material, part) = (bars.material.name(), bars.skeleton.name());
            parts.push(format!("skeleton {material} {part}"));
        }
        if bars.actuator == ActuatorPart::Device {
            parts.push(format!("actuators of {} kg", bars.actuator_mass));
        }
        parts.extend(self.forces());
        let others = self.physics_beyond(&KNOWN).into_iter();
        parts.extend(others.filter_map(|departure| {
            let (_, key) = departure.key.split_once('.')?;
            Some(with_unit(key, &departure.here, departure.unit))
        }));
        parts.join("; ")
    }

    /// Descriptions of the forces: the damping of bars, end stops, and the names of all others.
    fn forces(&self) -> Vec<String> {
        let laws = self.physics.forces.about().into_iter();
        let laws: Vec<_> = laws.map(|(name, _)| name).collect();
        let known = [
            ("damper", "damped bars", "no damping in bars"),
            ("stops", "end stops", "no end stops"),
        ];
        let described = known.map(|(name, says, missing)| match laws.contains(&name) {
            true => format!("{says} ({})", self.numbers_of(name)),
            false => missing.to_owned(),
        });
        let others = laws.into_iter();
        let others = others.filter(|law| known.iter().all(|(name, ..)| name != law));
        let others = others.map(|name| format!("force {name}"));
        described.into_iter().chain(others).collect()
    }

    /// The numbers of a law, each with its name and unit.
    fn numbers_of(&self, law: &str) -> String {
        let number = |setting: Setting| {
            let (section, key) = setting.key.split_once('.')?;
            let key = match key {
                "at" => "at a strain of",
                key => key,
            };
            (section == law).then(|| with_unit(key, &setting.value, setting.unit))
        };
        let numbers: Vec<String> = self.settings().into_iter().filter_map(number).collect();
        numbers.join(", ")
    }
}

/// The words of a key, its value, and its unit.
fn with_unit(key: &str, value: &str, unit: &str) -> String {
    let value = shortened(value);
    let value = value.strip_suffix(".0").unwrap_or(&value);
    let says = format!("{} {value} {unit}", key.replace('_', " "));
    says.trim_end().to_owned()
}
