//! What the parts of a scene can do according to their data sheets.

use crate::laws::Actuator;
use crate::scene::{ActuatorPart, Scene, SkeletonPart};

/// Length of a skeleton bar divided by its thickness from which it is sound, and from which it is doubtful. Euler's load and
/// joints without friction are for slender bars; below 3, bars that meet at 45 degrees touch before their ends do.
pub(crate) const SLENDERNESS: [f64; 2] = [10.0, 3.0];

/// What the parts of a scene can do. Numbers that the scene does not state are `None`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DataSheet {
    /// The largest force of a device, N.
    pub force: Option<f64>,
    /// True for a cylinder, which pulls with less than this force: the rod takes a part of the area of its piston.
    pub is_cylinder: bool,
    /// The largest speed of a device, m/s.
    pub speed: Option<f64>,
    /// The mass of a device, kg.
    pub mass: Option<f64>,
    /// The smallest length of a device.
    pub length: Option<DeviceLength>,
    /// The thickness of a skeleton bar, m.
    pub thickness: Option<f64>,
}

/// The smallest length of a device, and how much shorter than at rest its bar becomes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceLength {
    /// The smallest length (m). If the scene does not state it, it is the stroke: a device is longer than the rod that it
    /// takes in.
    pub least: f64,
    /// True if the scene states the length.
    pub is_stated: bool,
    /// The largest strain by which an actuator shortens its bar.
    pub strain: f64,
}

impl DeviceLength {
    /// The length that a bar with this rest length (m) leaves for a device when it is shortest, m.
    pub fn room(&self, rest_length: f64) -> f64 {
        rest_length * (1.0 - self.strain)
    }
}

impl Scene {
    /// What the parts of the scene can do according to their data sheets. Where the scene does not state the force and the
    /// speed of a device, they are those of the law `actuator`.
    pub fn data_sheet(&self) -> DataSheet {
        let parts = &self.materials.parts;
        let thickness = (parts.skeleton != SkeletonPart::Numbers).then_some(parts.outer);
        if parts.actuator != ActuatorPart::Device {
            return DataSheet {
                thickness,
                ..DataSheet::default()
            };
        }
        let law: Option<Actuator> = self.physics.forces.chosen();
        DataSheet {
            force: parts.force.or(law.as_ref().map(|law| law.force)),
            is_cylinder: parts.cylinder().is_some(),
            speed: parts.speed.or(law.map(|law| law.speed)),
            mass: Some(parts.actuator_mass),
            length: Some(DeviceLength {
                least: parts.length.unwrap_or(parts.stroke),
                is_stated: parts.length.is_some(),
                strain: self.materials.actuator_strain(),
            }),
            thickness,
        }
    }
}
