//! What the world of a scene asks of a robot: friction on a slope, steps of the ground, and a payload that its actuators
//! can lift.

use crate::geometry::{Ground, Vector};
use crate::lattice::{Lattice, Material, Payload};
use crate::laws::Actuator;
use crate::scene::{PhysicsSettings, Scene};

/// A place where the terrain is steeper than 45 degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Riser {
    /// The place along the ground of its far end, m.
    pub along: f64,
    /// Its height, m; negative if the terrain falls.
    pub height: f64,
}

impl PhysicsSettings {
    /// The steep places of the ground, ascending along the ground. Neighbouring steep segments that rise together count as
    /// one.
    pub fn risers(&self) -> Vec<Riser> {
        let profile = match self.contact.has_ground() {
            true => self.ground.resolved(),
            false => return Vec::new(),
        };
        let mut risers: Vec<Riser> = Vec::new();
        for ends in profile.points().windows(2) {
            let [length, height] = (ends[1] - ends[0]).in_plane();
            if height.abs() <= length {
                continue;
            }
            let (from, along) = (ends[0].forward(), ends[1].forward());
            match risers.last_mut() {
                Some(last) if last.along == from && last.height * height > 0.0 => {
                    last.along = along;
                    last.height += height;
                }
                _ => risers.push(Riser { along, height }),
            }
        }
        risers
    }

    /// The mass of a payload, kg.
    pub fn mass_of(&self, payload: &Payload) -> f64 {
        payload.mass.unwrap_or(self.payload_mass)
    }
}

impl Scene {
    /// The coefficient of friction divided by the smallest one that holds a robot at rest on the slope. `None` on level
    /// ground and where nothing slips.
    pub(crate) fn friction_margin(&self) -> Option<f64> {
        let slope = self.physics.incline_deg.to_radians().tan().abs();
        let slips = self.slips() && self.physics.gravity != 0.0;
        (slope > 0.0 && slips).then(|| self.physics.friction / slope)
    }

    /// The mass of all payloads, kg.
    pub fn payload_mass(&self, lattice: &Lattice) -> f64 {
        let payloads = lattice.payload.iter();
        payloads.map(|payload| self.physics.mass_of(payload)).sum()
    }

    /// The weight of all payloads as a share of what actuators can [lift](Self::lift) at most.
    pub(crate) fn share_of_lift(&self, lattice: &Lattice) -> f64 {
        match self.payload_mass(lattice) * self.physics.gravity.abs() {
            0.0 => 0.0,
            weight => weight / self.lift(lattice),
        }
    }

    /// An upper bound on the weight that actuators can lift, N. For every gap between neighbouring heights of nodes, it
    /// adds the upward forces of all bars across the gap, as if all were actuators that push at rest with their largest
    /// force. The bound is the smallest of these sums. It is infinite for a lattice whose nodes all lie at one height.
    pub fn lift(&self, lattice: &Lattice) -> f64 {
        let law: Option<Actuator> = self.physics.forces.chosen();
        let strain = self.materials.actuator_strain();
        let force = |edge: usize| match &law {
            Some(law) => law.force,
            None => {
                let bar = self.materials.of_edge(lattice, edge);
                Material::Actuator.of(&bar.stiffness) * strain * lattice.rest_length[edge]
            }
        };
        let up = |node: usize| lattice.places[node].up();
        let mut heights: Vec<f64> = lattice.places.iter().map(|place| place.up()).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let between = |pair: &[f64]| {
            let middle = 0.5 * (pair[0] + pair[1]);
            let edges = lattice.edges.iter().enumerate();
            let across = edges.filter(|(_, [i, j])| (up(*i) > middle) != (up(*j) > middle));
            let lifts = across.map(|(edge, [i, j])| {
                let offset = lattice.places[*j] - lattice.places[*i];
                force(edge) * (offset.up() / offset.norm()).abs()
            });
            lifts.sum::<f64>()
        };
        let bounds = heights.windows(2).map(between);
        bounds.fold(f64::INFINITY, f64::min)
    }

    /// The steep places of the ground, counted along the ground from the payload at the start, m.
    pub fn risers_ahead(&self, lattice: &Lattice) -> Vec<Riser> {
        let ground = Ground::from(&self.physics);
        let from: Vector<f64> = lattice.payload_point(&lattice.state_at_rest(), &ground);
        let ahead = |riser: Riser| Riser {
            along: riser.along - from.forward(),
            ..riser
        };
        let all = self.physics.risers().into_iter().map(ahead);
        all.filter(|riser| riser.along > 0.0).collect()
    }
}
