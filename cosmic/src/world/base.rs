//! [`World`]: everything about a scene that its robots share.

use std::sync::Arc;

use autodiff::{Parameters, Real};

use super::mechanics::Mechanics;
use super::robot::{Robot, Variation};
use super::stability::Vibration;
use super::step::{Drive, RobotStep};
use super::step_check::StepCheck;
use super::surroundings::Surroundings;
use crate::design::{Design, Material, Mixture};
use crate::geometry::{Ground, Vector};
use crate::lattice::{Body, Lattice, State};
use crate::policy::{Controller, Goals};
use crate::projection::Projector;
use crate::scene::{
    AnyDesign, ControllerSettings, GoalKind, MaterialSettings, MovedBody, PhysicsSettings, Scene,
    VoidEdges,
};

/// The states of a walk that a run keeps are this number of steps apart.
pub(crate) const KEEP_EVERY: usize = 16;

/// The numbers of steps before the states that are kept of a walk of `steps` steps: every state after `every` steps, and
/// the last one.
pub(crate) fn kept_steps(steps: usize, every: usize) -> Vec<usize> {
    (0..steps).step_by(every).chain([steps]).collect()
}

/// How many of `walks` walks with one controller a thread runs together. It is 8, one per SIMD lane, or fewer if
/// other threads would have nothing to do.
pub fn together(walks: usize) -> usize {
    (walks / rayon::current_num_threads()).clamp(1, 8)
}

/// Everything about a scene that its robots share: the lattice, the physics, the recorded step, and the settings that turn a
/// design into a body. It is built once.
#[derive(Clone, Debug)]
pub struct World {
    /// The nodes, edges and rest lengths of the robot.
    pub(super) lattice: Lattice,
    /// The physics: time step, number of steps, forces, masses and ground.
    pub(super) physics: PhysicsSettings,
    /// The stiffnesses, densities and strains of the materials.
    pub(super) materials: MaterialSettings,
    /// Projects the design vectors of designs to mixtures.
    pub(super) projector: Projector,
    /// True if the [presence](Body::with_presence) of a node depends on how solid its edges are. Otherwise all nodes have
    /// presence 1.
    one_piece: bool,
    /// The part of the robot whose displacement counts.
    moved: MovedBody,
    pub(super) step: RobotStep,
    pub(super) ground: Ground,
    /// For each step, its [pairs](RobotStep::pairs_at) of the clock and the goals, and then the time if a force reads it.
    pub(super) clock: Arc<[f64]>,
}

impl World {
    /// The world of a scene for robots on a lattice. Walks have at most `physics.steps` steps.
    pub fn new(lattice: Lattice, scene: &Scene) -> Self {
        let physics = &scene.physics;
        let step = RobotStep::new(&lattice, physics, &scene.controller);
        Self {
            clock: step.inputs_of_steps(physics.dt, physics.steps),
            step,
            ground: Ground::from(physics),
            projector: Projector::new(&scene.projection, &lattice),
            lattice,
            physics: physics.clone(),
            materials: scene.materials.clone(),
            one_piece: scene.design.one_piece,
            moved: scene.objective.body,
        }
    }

    /// The nodes, edges and rest lengths of the robot.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The physics: time step, number of steps, forces, masses and ground.
    pub fn physics(&self) -> &PhysicsSettings {
        &self.physics
    }

    /// The stiffnesses, densities and strains of the materials.
    pub fn materials(&self) -> &MaterialSettings {
        &self.materials
    }

    /// Projects the design vectors of designs to mixtures.
    pub fn projector(&self) -> &Projector {
        &self.projector
    }

    /// A copy of the world with another part of the robot whose displacement counts (`objective.body`).
    #[must_use]
    pub(crate) fn with_moved(&self, moved: MovedBody) -> Self {
        Self {
            moved,
            ..self.clone()
        }
    }

    /// A copy of the world whose walks have this number of steps, unless they are shorter already.
    #[must_use]
    pub(crate) fn shortened(&self, steps: usize) -> Self {
        let mut short = self.clone();
        short.physics.steps = steps.min(self.physics.steps);
        short
    }

    /// A copy of the world with other physics, such as a shorter time step. Its robots have the controller's settings
    /// `controller`.
    #[must_use]
    pub fn with_physics(&self, physics: &PhysicsSettings, controller: &ControllerSettings) -> Self {
        let step = RobotStep::new(&self.lattice, physics, controller);
        Self {
            clock: step.inputs_of_steps(physics.dt, physics.steps),
            step,
            ground: Ground::from(physics),
            physics: physics.clone(),
            ..self.clone()
        }
    }

    /// The surroundings of the scene, whose numbers are constants: gravity, friction, the settings of the laws, and the
    /// goal if goals are inputs of a walk.
    pub fn surroundings<R: Real>(&self) -> Surroundings<R> {
        let settings = &self.step.settings;
        let goals = (settings.goals == GoalKind::Given).then(|| Goals::at(settings.goal));
        Surroundings::of_scene(&self.step.inputs, goals.as_ref())
    }

    /// The body that belongs to a design.
    pub fn body<R: Real>(&self, design: &Design<Mixture<R>>) -> Body<R> {
        self.built(design, design.layout(), &self.materials, [&[]; 2])
    }

    /// The body of a robot as it is built: the stiffnesses and masses of its design, times the factors of the variation.
    pub(super) fn varied_body<R: Real>(
        &self,
        design: &Design<Mixture<R>>,
        variation: &Variation,
    ) -> Body<R> {
        let factors = [&variation.stiffness[..], &variation.mass];
        self.built(design, design.layout(), &self.materials, factors)
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
        self.built(
            &Design::of_shares(shares),
            Some(layout),
            &materials,
            [&[]; 2],
        )
    }

    /// The body of a design, which is known to have or to be near `layout`. `factors` are those of the stiffness of each edge
    /// and of the mass of each node, or empty.
    fn built<R: Real>(
        &self,
        design: &Design<Mixture<R>>,
        layout: Option<&[Material]>,
        materials: &MaterialSettings,
        factors: [&[f64]; 2],
    ) -> Body<R> {
        let lattice = &self.lattice;
        let mut body = Body::new(design, lattice, materials, &self.physics);
        if self.one_piece {
            body = body.with_presence(design, layout, lattice);
        }
        for (name, factors) in ["bars.stiffness", "nodes.mass"].into_iter().zip(factors) {
            body.scale(name, &R::lits(factors), &lattice.rest_length);
        }
        body.with_marker(self.moved, design, layout, lattice)
    }

    /// A robot in the surroundings of the scene.
    pub fn robot<R: Real>(
        &self,
        body: impl Into<Arc<Body<R>>>,
        controller: impl Into<Arc<Controller<R>>>,
        start: &State<R>,
    ) -> Robot<R> {
        Robot {
            body: body.into(),
            controller: controller.into(),
            surroundings: Arc::new(self.surroundings()),
            start: start.clone(),
        }
    }

    /// No variation: the design as it is, in the surroundings of the scene, from this start.
    pub fn nominal(&self, start: &State<f64>) -> Variation {
        Variation {
            stiffness: Vec::new(),
            mass: Vec::new(),
            surroundings: Arc::new(self.surroundings()),
            start: start.clone(),
        }
    }

    /// A robot of this design, with a variation.
    pub fn varied<R: Real>(
        &self,
        design: &Design<Mixture<R>>,
        controller: &Arc<Controller<R>>,
        variation: &Variation,
    ) -> Robot<R> {
        Robot {
            body: Arc::new(self.varied_body(design, variation)),
            controller: Arc::clone(controller),
            surroundings: self.adapted(variation),
            start: variation.start.map(R::lit),
        }
    }

    /// The surroundings of a variation, which may be from a world whose steps read other numbers.
    fn adapted<R: Real>(&self, variation: &Variation) -> Arc<Surroundings<R>> {
        let surroundings = variation.surroundings.adapted(self.surroundings());
        Arc::new(surroundings.map(R::lit))
    }

    /// Robots with one controller, each with its design and its variation, in the number type `R`. Neighbours share what is
    /// the same.
    pub fn robots<R: Real>(
        &self,
        pairs: &[(&Design<Mixture<f64>>, &Variation)],
        controller: &Controller<f64>,
    ) -> Vec<Robot<R>> {
        let controller = Arc::new(controller.map(R::lit));
        let mut robots: Vec<Robot<R>> = Vec::new();
        for (k, &(design, variation)) in pairs.iter().enumerate() {
            let before = robots.last().map(|robot| (pairs[k - 1], robot));
            let same_body = before.filter(|((other, own), _)| {
                let are_as_designed = own.is_as_designed() && variation.is_as_designed();
                std::ptr::eq(*other, design) && are_as_designed
            });
            let same_surroundings = before
                .filter(|((_, own), _)| Arc::ptr_eq(&own.surroundings, &variation.surroundings));
            let body = || Arc::new(self.varied_body(&design.lift(), variation));
            let robot = Robot {
                body: same_body.map_or_else(body, |(_, robot)| Arc::clone(&robot.body)),
                controller: Arc::clone(&controller),
                surroundings: same_surroundings.map_or_else(
                    || self.adapted(variation),
                    |(_, robot)| Arc::clone(&robot.surroundings),
                ),
                start: variation.start.map(R::lit),
            };
            robots.push(robot);
        }
        robots
    }

    /// The forces, the contact law and the integrator of a step.
    pub(crate) fn mechanics(&self) -> &Mechanics {
        &self.step.mechanics
    }

    /// The ground line of the physics.
    pub fn ground(&self) -> Ground {
        self.ground
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

    /// Panics unless robots fit this lattice. Without this check, arrays for a larger lattice would be misread silently.
    pub(super) fn check<R: Real>(&self, robots: &[Robot<R>]) {
        let (nodes, edges) = (self.lattice.nodes(), self.lattice.edges.len());
        let fits = |what: &str, found: usize, expected: usize| self.fits(what, found, expected);
        for Robot { body, start, .. } in robots {
            fits("stiffness", body.stiffness.len(), edges);
            fits("strain", body.strain.len(), edges);
            fits("masses", body.mass.len(), nodes);
            if !body.presence.is_empty() {
                fits("presence", body.presence.len(), nodes);
            }
            if !body.rest_length.is_empty() {
                fits("rest lengths", body.rest_length.len(), edges);
            }
            fits("initial positions", start.x.len(), nodes);
            fits("initial velocities", start.v.len(), nodes);
        }
    }

    /// Panics unless a controller fits this lattice.
    pub(super) fn check_controller<R: Real>(&self, controller: &Controller<R>) {
        let Drive::Policy(driver) = &self.step.drive else {
            return;
        };
        let given: Vec<_> = controller.blocks().collect();
        self.fits("blocks of the controller", given.len(), driver.blocks.len());
        for ((name, shape, _), block) in given.into_iter().zip(&*driver.blocks) {
            assert_eq!(name, block.name, "the controller belongs to another policy");
            let what = format!("numbers of the controller in `{name}`");
            self.fits(&what, shape.len(), block.shape.len());
        }
    }

    /// Panics unless `found` is `expected`: the number of `what` (such as masses) that this lattice needs.
    #[track_caller]
    pub(super) fn fits(&self, what: &str, found: usize, expected: usize) {
        let nodes = self.lattice.nodes();
        assert_eq!(found, expected, "{what} of a robot of {nodes} nodes");
    }

    /// Converts a state in the world's frame to one flat array in the ground's frame.
    pub fn flatten<R: Real>(&self, state: &State<R>) -> Vec<R> {
        state.to_ground(&self.ground).to_columns()
    }

    /// Converts a flat array in the ground's frame to a state in the world's frame. The array has all nodes, or only
    /// the first nodes.
    pub(super) fn unflatten<R: Real>(&self, state: &[R]) -> State<R> {
        State::from_columns(self.lattice.dimension, state).to_world(&self.ground)
    }
}
