//! Describes the robot and the world of a scene, each in one line.

use super::{ActuatorPart, ProfileKind, Scene, SkeletonPart};
use crate::geometry::Vector;
use crate::lattice::Lattice;
use crate::settings::Named;

impl Scene {
    /// A description of the robot in one line: its lattice, its size, its mass, and its payload. The mass is that of a
    /// robot whose volume is in the middle of the bounds on the volume.
    pub fn robot(&self) -> String {
        let lattice = Lattice::new(&self.lattice, &self.physics);
        let [long, high] = self.extent().map(rounded).array();
        let solid = 0.5 * self.volume.solid.iter().sum::<f64>();
        let of_bar = |&length: &f64| {
            let [_, skeleton, actuator] = self.materials.of_length(length).density;
            0.5 * (skeleton + actuator) * length
        };
        let bars: f64 = lattice.rest_length.iter().map(of_bar).sum();
        let nodes = lattice.nodes() as f64 * self.physics.node_mass;
        let payload = lattice.payload.iter();
        let payload: f64 = (payload.map(|p| p.mass.unwrap_or(self.physics.payload_mass))).sum();
        format!(
            "{}, {} nodes, {} edges; {long} m long, {high} m high; about {} kg and a payload of {} kg",
            self.lattice.name(),
            lattice.nodes(),
            lattice.edges.len(),
            rounded(nodes + solid * bars),
            rounded(payload),
        )
    }

    /// The length and the height of the robot at rest, m.
    pub(super) fn extent(&self) -> Vector<f64> {
        let lattice = Lattice::new(&self.lattice, &self.physics);
        lattice.extent() * lattice.spacing
    }

    /// A description of the world in one line: gravity, contact and friction, drag, damping of the bars, and end stops.
    /// Other forces, an incline, a ground profile and parts are named if the scene has them.
    pub fn world(&self) -> String {
        let physics = &self.physics;
        let mut parts = vec![format!("gravity {} m/s2", physics.gravity)];
        parts.push(match physics.contact.name() {
            "none" => "no ground".to_owned(),
            name if self.slips() => format!("contact {name}, friction {}", physics.friction),
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
            rate => format!("drag {rate} 1/s"),
        });
        let bars = &self.materials.parts;
        if bars.skeleton != SkeletonPart::Numbers {
            let (material, part) = (bars.material.name(), bars.skeleton.name());
            parts.push(format!("skeleton {material} {part}"));
        }
        if bars.actuator == ActuatorPart::Device {
            parts.push(format!("actuators of {} kg", bars.actuator_mass));
        }
        let settings = self.settings();
        let law = |name: &str| {
            let of_law = |key: &str| {
                key.strip_prefix(name)
                    .is_some_and(|rest| rest.starts_with('.'))
            };
            let of_law = settings.iter().filter(|setting| of_law(&setting.key));
            let values = of_law.map(|setting| format!("{} = {}", setting.key, setting.value));
            values.collect::<Vec<_>>().join(", ")
        };
        let laws: Vec<_> = physics
            .forces
            .about()
            .into_iter()
            .map(|(name, _)| name)
            .collect();
        for (name, says, missing) in [
            ("damper", "damped bars", "no damping in bars"),
            ("stops", "end stops", "no end stops"),
        ] {
            parts.push(if laws.contains(&name) {
                format!("{says} ({})", law(name))
            } else {
                missing.to_owned()
            });
        }
        let others = laws
            .iter()
            .filter(|name| !["damper", "stops"].contains(name));
        parts.extend(others.map(|name| format!("force {name}")));
        parts.join("; ")
    }
}

/// The number, rounded to three significant digits.
pub(super) fn rounded(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}
