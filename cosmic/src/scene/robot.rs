//! Settings of the robot and its world: lattice, physics, materials, controller.

use super::field::Named;
use serde::{Deserialize, Serialize};

/// The lattice: its size and where it stands (D1).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LatticeSettings {
    /// Nodes in a row (paper: 6).
    pub columns: usize,
    /// Nodes in a column (paper: 6).
    pub rows: usize,
    /// Distance of neighbouring nodes, m (D1).
    pub spacing: f64,
    /// Distance of column 0 from the ground's origin, along the ground, m (D1).
    pub origin_x: f64,
    /// Height of row 0 above the ground line at the start, m (D1).
    pub drop: f64,
}

impl Default for LatticeSettings {
    fn default() -> Self {
        LatticeSettings {
            columns: 6,
            rows: 6,
            spacing: 0.1,
            origin_x: 0.1,
            drop: 0.0,
        }
    }
}

/// What the simulator integrates and against which ground.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PhysicsSettings {
    /// Time step, s (paper, table 2).
    pub dt: f64,
    /// Steps of a rollout (paper, table 2).
    pub steps: usize,
    /// How a step is integrated (paper: symplectic Euler).
    pub integrator: Integrator,
    /// Mechanical steps of `dt / substeps` for each of the controller, whose output is held (paper:
    /// 1).
    pub substeps: usize,
    /// Gravity, straight down on inclines too, m/s2 (paper silent).
    pub gravity: f64,
    /// Damping rate of the velocities, 1/s (paper silent).
    pub damping: f64,
    /// Mass every node has by itself, kg (D2).
    pub node_mass: f64,
    /// Extra mass of node 0, the payload, kg (paper silent).
    pub payload_mass: f64,
    /// Height of the ground line at x = 0, m (D1).
    pub ground_height: f64,
    /// Angle of the ground, degrees (paper: 0, and 15 for the incline).
    pub incline_deg: f64,
    /// Contact law of the ground (paper: infinite friction, Coulomb for one case).
    pub contact: Contact,
    /// Coefficient of friction, read for Coulomb contact alone (paper: 2.5).
    pub friction: f64,
    /// Cubic coefficient c of the spring force k (e + c e^3), 1/m2 (paper: 0, Hooke's law).
    pub stiffening: f64,
    /// Radius of gyration of the bars' section, m: above 0 bars in line resist bending (paper: 0).
    pub bending_radius: f64,
    /// Whether void edges pull: dropped, those of an exactly one-hot layout do not (paper: they
    /// do).
    pub void_edges: VoidEdges,
    /// What an optimisation does about a time step with which the robot's vibrations grow.
    pub unstable_step: UnstableStep,
}

impl Default for PhysicsSettings {
    fn default() -> Self {
        PhysicsSettings {
            dt: 0.002,
            steps: 8192,
            integrator: Integrator::SymplecticEuler,
            substeps: 1,
            gravity: 4.8,
            damping: 20.0,
            node_mass: 1e-4,
            payload_mass: 0.03,
            ground_height: 0.1,
            incline_deg: 0.0,
            contact: Contact::Infinite,
            friction: 2.5,
            stiffening: 0.0,
            bending_radius: 0.0,
            void_edges: VoidEdges::Keep,
            unstable_step: UnstableStep::Error,
        }
    }
}

/// How positions and velocities step through time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// First the velocities by the forces at hand, then the positions by the new velocities: of
    /// first order.
    #[default]
    SymplecticEuler,
    /// Half a drift, the forces at the middle between two half dampings, half a drift: of second
    /// order between contacts.
    Leapfrog,
}

impl Named for Integrator {
    const ALL: &'static [(&'static str, Self)] = &[
        ("symplectic_euler", Integrator::SymplecticEuler),
        ("leapfrog", Integrator::Leapfrog),
    ];
}

/// What becomes of the void edges of a layout, whose stiffness is next to nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VoidEdges {
    /// They pull with the stiffness of void.
    #[default]
    Keep,
    /// They do not pull at all, and no step computes them; their mass stays. Mixtures, and designs
    /// that something is differentiated by, keep theirs.
    Drop,
}

impl Named for VoidEdges {
    const ALL: &'static [(&'static str, Self)] =
        &[("keep", VoidEdges::Keep), ("drop", VoidEdges::Drop)];
}

/// What becomes of a run whose time step is beyond the stable one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum UnstableStep {
    /// It is refused.
    Error,
    /// It goes on, and a warning is given.
    Warn,
}

impl Named for UnstableStep {
    const ALL: &'static [(&'static str, Self)] =
        &[("error", UnstableStep::Error), ("warn", UnstableStep::Warn)];
}

/// What a node's velocity becomes when it meets the ground.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Contact {
    /// There is no ground.
    None,
    /// The node stops.
    Infinite,
    /// The normal part vanishes; friction shortens the tangential part and never reverses it (D5).
    Coulomb,
}

impl Named for Contact {
    const ALL: &'static [(&'static str, Self)] = &[
        ("none", Contact::None),
        ("infinite", Contact::Infinite),
        ("coulomb", Contact::Coulomb),
    ];
}

/// The library of materials, each array in the order void, skeleton, actuator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaterialSettings {
    /// Stiffness of void, skeleton, actuator, N/m (paper, table 1).
    pub stiffness: [f64; 3],
    /// Mass per length of void, skeleton, actuator, kg/m (paper, table 1).
    pub density: [f64; 3],
    /// Largest actuation strain of void, skeleton, actuator (paper, table 1); only the last is
    /// used: what of an edge is no actuator does not act (D8).
    pub max_strain: [f64; 3],
    /// Exponent on the shares of a mixture in its stiffness, the penalisation of SIMP (paper: 1,
    /// none).
    pub penalisation: usize,
}

impl Default for MaterialSettings {
    fn default() -> Self {
        MaterialSettings {
            stiffness: [1e-7, 4e2, 3e1],
            density: [1e-8, 0.030, 0.100],
            max_strain: [0.0, 0.0, 0.35],
            penalisation: 1,
        }
    }
}

/// The neural controller: its size, its inputs, its goals and how its weights start.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ControllerSettings {
    /// Width of the hidden layer (paper: 32).
    pub hidden: usize,
    /// Number of clock signals (paper: 10).
    pub clocks: usize,
    /// Angular frequency of the clock, rad/s (paper: 10).
    pub omega: f64,
    /// Goal: along the ground and above it, from the world's origin, m (paper: 2, 0.1).
    pub goal: [f64; 2],
    /// Factor on the goal at the controller's input, 1/m (D3).
    pub goal_scale: f64,
    /// Whether the goal is given relative to the mean node position (D3; paper: false).
    pub goal_relative: bool,
    /// Whether the controller is trained for a second goal too, mirrored behind the origin, towards
    /// which the payload has to get as far back; what is reported and chosen by stays the way ahead
    /// (paper: false).
    pub two_goals: bool,
    /// Factor on the node offsets at the controller's input, 1/m (D3).
    pub offset_scale: f64,
    /// Factor on the node velocities at the controller's input, s/m (D3).
    pub velocity_scale: f64,
    /// Gain of the Xavier initialisation of the hidden and the output layer (paper silent).
    pub gain: [f64; 2],
}

impl ControllerSettings {
    /// Whether positions and velocities make any difference to an observation.
    pub fn senses(&self) -> [bool; 2] {
        let follows_goal = self.goal_relative && self.goal_scale != 0.0;
        [
            self.offset_scale != 0.0 || follows_goal,
            self.velocity_scale != 0.0,
        ]
    }

    /// The same with the goal mirrored: behind the origin where it was ahead.
    pub fn turned_back(&self) -> Self {
        let [along, height] = self.goal;
        Self {
            goal: [-along, height],
            ..self.clone()
        }
    }
}

impl Default for ControllerSettings {
    fn default() -> Self {
        ControllerSettings {
            hidden: 32,
            clocks: 10,
            omega: 10.0,
            goal: [2.0, 0.1],
            goal_scale: 0.05,
            goal_relative: false,
            two_goals: false,
            offset_scale: 0.05,
            velocity_scale: 0.05,
            gain: [2.0, 2.0],
        }
    }
}
