//! The task: computes the loss of a robot from its design and its controller.

use std::borrow::Borrow;

use autodiff::Real;
use autodiff_programs::{CotangentBound, Memory};
use serde::{Deserialize, Serialize};

use crate::design::{Design, Material, Mixture};
use crate::geometry::{Ground, Vector};
use crate::inputs::Inputs;
use crate::lattice::{Body, Lattice, State};
use crate::objective::{Loss, LossOf};
use crate::policy::{Controller, Goals};
use crate::projection::{Projector, Variation};
use crate::scene::{
    AnyDesign, ControllerSettings, MaterialSettings, MovedBody, PhysicsSettings, Scene, VoidEdges,
};
use crate::simulator::stability::Vibration;
use crate::simulator::{BarLoad, Energy, Loads, Robots, Simulator, Span, StepCheck, Trajectory};

/// The steps of a rollout that carry the gradient (D11). The rollout ends after them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizon {
    /// The number of steps on the clock at the start of the rollout.
    pub first: usize,
    /// The number of steps that carry the gradient.
    pub steps: usize,
    /// The bound on the state's cotangent in the reverse sweep. With `None` the gradient is exact.
    pub cotangent_bound: Option<CotangentBound>,
}

impl Horizon {
    /// A horizon of `steps` steps from the start of the clock. The gradient is exact.
    pub fn of_steps(steps: usize) -> Self {
        Self {
            first: 0,
            steps,
            cotangent_bound: None,
        }
    }
}

/// The states of a rollout that a run keeps are this number of steps apart.
pub const KEEP_EVERY: usize = 16;

/// The numbers of steps before the states that are kept of a rollout of `steps` steps: every state after `every` steps, and
/// the last one.
pub fn kept_steps(steps: usize, every: usize) -> Vec<usize> {
    (0..steps).step_by(every).chain([steps]).collect()
}

/// The loads of a layout and the energy that it needs in one rollout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadsAndEnergy {
    /// The loads of each edge; `None` for a void edge.
    pub bars: Vec<Option<BarLoad>>,
    /// The loads of the robot.
    pub loads: Loads,
    /// The energy that it needs.
    pub energy: Energy,
}

/// How many of `rollouts` rollouts with one controller a thread runs together. It is 8, one per SIMD lane, or fewer if
/// other threads would have nothing to do.
pub fn together(rollouts: usize) -> usize {
    (rollouts / rayon::current_num_threads()).clamp(1, 8)
}

/// Everything that is needed to simulate a robot, except for its design vectors, its controller and its initial state:
/// the lattice, the physics, and the settings that turn a design into a body.
#[derive(Clone, Debug)]
pub struct Task {
    /// The nodes, edges and rest lengths of the robot.
    pub lattice: Lattice,
    /// The physics: time step, number of steps, forces, masses and ground.
    pub physics: PhysicsSettings,
    /// The stiffnesses, densities and strains of the materials.
    pub materials: MaterialSettings,
    /// Projects the design vectors of designs to mixtures.
    pub projector: Projector,
    /// The simulator of the robot.
    pub simulator: Simulator,
    /// True if the weight of a node in means and observations [depends on how solid its edges
    /// are](Body::with_one_piece). Otherwise all weights are 1.
    one_piece: bool,
    /// The part of the robot whose displacement counts.
    moved: MovedBody,
    /// The factors by which the simulated robot differs from its design; `None` for the nominal robot.
    variation: Option<Variation>,
}

impl Task {
    /// A task for the nominal robot of a scene on a lattice. Its rollouts have `physics.steps` steps.
    pub fn new(lattice: Lattice, scene: &Scene) -> Self {
        let physics = &scene.physics;
        Self {
            simulator: Simulator::new(&lattice, physics, &scene.controller),
            projector: Projector::new(&scene.projection, &lattice),
            lattice,
            physics: physics.clone(),
            materials: scene.materials.clone(),
            one_piece: scene.design.one_piece,
            moved: scene.objective.body,
            variation: None,
        }
    }

    /// A copy of the task with a [memory budget](Simulator::with_memory) for gradients.
    #[must_use]
    pub fn with_memory(self, memory: Memory) -> Self {
        Self {
            simulator: self.simulator.with_memory(memory),
            ..self
        }
    }

    /// A copy of the task with another part of the robot whose displacement counts (`objective.body`).
    #[must_use]
    pub(crate) fn with_moved(self, moved: MovedBody) -> Self {
        Self { moved, ..self }
    }

    /// A copy of the task for a robot as it is built: its stiffnesses and masses are multiplied by the factors in
    /// `variation`. The coefficient of friction is multiplied by `friction`.
    #[must_use]
    pub fn varied(&self, variation: Variation, friction: f64) -> Self {
        Self {
            variation: Some(variation),
            ..self.with_friction(friction)
        }
    }

    /// A copy of the task whose coefficient of friction is multiplied by `factor`.
    #[must_use]
    pub(crate) fn with_friction(&self, factor: f64) -> Self {
        let friction = self.physics.friction * factor;
        let physics = PhysicsSettings {
            friction,
            ..self.physics.clone()
        };
        Self {
            simulator: self.simulator.with_friction(friction),
            physics,
            ..self.clone()
        }
    }

    /// A copy of the task with other physics, such as a shorter time step. Its robots have the controller's settings
    /// `controller`, their feedback, and the goal of the scene. The memory budget and the flag that stops rollouts stay.
    #[must_use]
    pub(crate) fn with_physics(
        &self,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        let simulator = Simulator::new(&self.lattice, physics, controller);
        let mut simulator = simulator.with_memory(self.simulator.memory);
        simulator.stop = self.simulator.stop.clone();
        Self {
            simulator,
            physics: physics.clone(),
            ..self.clone()
        }
    }

    /// A copy of the task without feedback (open loop): the controller observes the state `seen` in every step, so that
    /// only its clock changes.
    #[must_use]
    pub fn without_feedback(&self, seen: &State<f64>) -> Self {
        Self {
            simulator: self.simulator.without_feedback(seen),
            ..self.clone()
        }
    }

    /// A copy of the task with other [goals](Simulator::with_goals).
    #[must_use]
    pub fn with_goals(&self, goals: &Goals) -> Self {
        Self {
            simulator: self.simulator.with_goals(goals),
            ..self.clone()
        }
    }

    /// The body that belongs to a design. It includes the [variation](Task::varied) of this task, if there is one.
    pub fn body<R: Real>(&self, design: &Design<Mixture<R>>) -> Body<R> {
        self.built(design, design.layout(), &self.materials)
    }

    /// The body of a finished robot as a function of the shares of its edges, for derivatives with respect to them. If
    /// the shares are those of the layout, it has the bits of the [body](Self::body) of the layout. What the layout
    /// leaves out stays out, whatever the shares are: nodes without a bar and the springs at them, and the stiffness of
    /// void if `physics.void_edges` is "drop".
    pub fn body_near<R: Real>(&self, layout: &[Material], shares: &[[R; 3]]) -> Body<R> {
        let mut materials = self.materials.clone();
        if self.physics.void_edges == VoidEdges::Drop {
            materials.stiffness[Material::Void as usize] = 0.0;
        }
        self.built(&Design::of_shares(shares), Some(layout), &materials)
    }

    /// The body of a design, which is known to have or to be near `layout`.
    fn built<R: Real>(
        &self,
        design: &Design<Mixture<R>>,
        layout: Option<&[Material]>,
        materials: &MaterialSettings,
    ) -> Body<R> {
        let lattice = &self.lattice;
        let mut body = Body::new(design, lattice, materials, &self.physics);
        if self.one_piece {
            body = body.with_one_piece(design, layout, lattice);
        }
        if let Some(variation) = &self.variation {
            body = body.varied(variation);
        }
        body.with_marker(self.moved, design, layout, lattice)
    }

    /// The ground line of the physics.
    pub fn ground(&self) -> Ground {
        Ground::from(&self.physics)
    }

    /// The time step, s, below which every design of the lattice is [stable](AnyDesign::stable_step), and so are its
    /// random variations, which may vibrate [`faster`](crate::scene::RobustSettings::faster) times as fast.
    pub fn stable_step_of_any_design(&self, faster: f64) -> f64 {
        AnyDesign::new(&self.lattice, &self.materials, &self.physics).stable_step(faster)
    }

    /// Checks whether the time step is short enough for the vibrations of a robot. The robot has this design and is at
    /// rest in `positions`. Its random variations may vibrate [`faster`](crate::scene::RobustSettings::faster) times as
    /// fast and are checked too. `any_design` is the [stable step of every design](Self::stable_step_of_any_design).
    pub fn step_check(
        &self,
        design: &Design<Mixture<f64>>,
        positions: &[Vector<f64>],
        faster: f64,
        any_design: f64,
    ) -> StepCheck {
        let body = self.body(design);
        let vibration = Vibration::new(&self.lattice, &body, &self.physics, positions);
        StepCheck::new(&vibration, any_design, faster, &self.physics)
    }

    /// Computes the loss of a design over a horizon. The controller and the initial state are in `inputs`.
    pub fn loss<R: Real>(
        &self,
        design: &Design<Mixture<R>>,
        inputs: &Inputs<R>,
        loss: &(impl Loss + LossOf<R> + ?Sized),
        horizon: &Horizon,
    ) -> R {
        let trajectories = self.over_horizon(&[design], inputs, loss, horizon);
        loss.loss_of(&trajectories[0])
    }

    /// Simulates several designs with one controller and one initial state. The trajectories hold the states and the
    /// nodes that the loss reads.
    pub fn over_horizon<R: Real>(
        &self,
        designs: &[impl Borrow<Design<Mixture<R>>>],
        inputs: &Inputs<R>,
        loss: &(impl Loss + ?Sized),
        horizon: &Horizon,
    ) -> Vec<Trajectory<R>> {
        let bodies: Vec<_> = designs.iter().map(|d| self.body(d.borrow())).collect();
        let robots = Robots {
            surroundings: &[self.simulator.surroundings()],
            bodies: &bodies,
            controllers: std::slice::from_ref(&inputs.controller),
        };
        let starts = vec![&inputs.start; bodies.len()];
        let of_markers = bodies.iter().map(|body| body.marker.nodes());
        let span = Span {
            first: horizon.first,
            nodes: of_markers.fold(loss.nodes(), usize::max),
            cotangent_bound: horizon.cotangent_bound,
            metered: loss.reads_efforts(),
            ..Span::from_start(loss.observed(horizon.steps.min(self.physics.steps)))
        };
        self.simulator.rollouts(&robots, &starts, &span)
    }

    /// The loads and the energy of a layout over all steps of a rollout that does not diverge and moves the robot by
    /// `displacement` along the ground (m). Bars that pass through each other are counted in the states `seen` of this
    /// rollout. `None` for an undecided design.
    pub fn loads_and_energy(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        start: &State<f64>,
        seen: &Trajectory<f64>,
        displacement: f64,
    ) -> Option<LoadsAndEnergy> {
        let (layout, steps) = (design.layout()?, self.physics.steps);
        let (simulator, materials, body) = (&self.simulator, &self.materials, self.body(design));
        let bars = simulator.loads(layout, &body, controller, start, steps);
        Some(LoadsAndEnergy {
            loads: simulator.loads_of(layout, &bars, seen, materials),
            energy: simulator.energy_of(layout, &bars, &body, materials, steps, displacement),
            bars,
        })
    }
}
