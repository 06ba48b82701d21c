//! Robots without a design: stiffnesses and masses are stated directly. They have no actuators.

use autodiff::{Parameters, Real};
use cosmic::geometry::Vector;
use cosmic::lattice::{Body, Lattice, Marker, State};
use cosmic::laws::ContactLaw;
use cosmic::policy::Controller;
use cosmic::scene::{ControllerSettings, PhysicsSettings, Scene};
use cosmic::world::{Span, Trajectory, World};

/// A robot without a design. It consists of nodes, springs between them, and the physics of its world.
#[derive(Clone, Debug)]
pub struct Bare {
    /// The edges and rest lengths. The lattice's positions are not used.
    pub lattice: Lattice,
    /// The stiffness of each edge and the mass of each node. All strains are zero, so there are no actuators.
    pub body: Body<f64>,
    /// The time step, forces and ground. The number of steps is ignored.
    pub physics: PhysicsSettings,
}

impl Bare {
    /// Creates a robot from nodes with these masses. Each spring is `(edge, rest length, stiffness)`. The world has no
    /// gravity, no damping and no ground.
    pub fn new(springs: &[([usize; 2], f64, f64)], masses: &[f64]) -> Self {
        let edges = springs.iter().map(|spring| spring.0).collect();
        let lattice = Lattice {
            rest_length: springs.iter().map(|spring| spring.1).collect(),
            scale: 1.0,
            ..Lattice::between(vec![Vector::zero(); masses.len()], edges)
        };
        let body = Body {
            stiffness: springs.iter().map(|spring| spring.2).collect(),
            strain: vec![0.0; springs.len()],
            largest_strain: 1.0,
            rest_length: Vec::new(),
            mass: masses.to_vec(),
            presence: Vec::new(),
            marker: Marker::default(),
        };
        let physics = PhysicsSettings {
            gravity: 0.0,
            damping: 0.0,
            contact: ContactLaw::none(),
            ..PhysicsSettings::default()
        };
        Self {
            lattice,
            body,
            physics,
        }
    }

    /// Creates two nodes of equal mass that do not affect each other, because the spring between them has no stiffness.
    pub fn free_node(physics: PhysicsSettings) -> Self {
        let bare = Self::new(&[([0, 1], 1.0, 0.0)], &[0.01, 0.01]);
        Self { physics, ..bare }
    }

    /// Simulates from `start` and returns the states after the numbers of steps in `observed`.
    pub fn run<R: Real>(&self, start: &State<R>, observed: Vec<usize>) -> Trajectory<R> {
        let mut scene = Scene::paper();
        scene.controller = ControllerSettings {
            hidden: 1,
            clocks: 0,
            ..ControllerSettings::default()
        };
        scene.physics = PhysicsSettings {
            steps: observed.last().copied().unwrap_or(0),
            ..self.physics.clone()
        };
        let silent = Controller::xavier(&scene.controller, &self.lattice, 0).map(|_| R::zero());
        let world = World::new(self.lattice.clone(), &scene);
        let robot = world.robot(self.body.map(R::lit), silent, start);
        world.run_one(&robot, &Span::from_start(observed))
    }

    /// Simulates from `start` and returns the state after `steps` steps.
    pub fn run_to_end<R: Real>(&self, start: &State<R>, steps: usize) -> State<R> {
        self.run(start, vec![steps]).states.remove(0)
    }
}
