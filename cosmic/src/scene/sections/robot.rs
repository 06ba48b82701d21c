//! Settings of the robot and its world: lattice, physics, controller.

use crate::scene::Scene;
use std::sync::Arc;

use super::item_name::ItemName;
use super::terrain::GroundSettings;
use super::truss_file::TrussFile;
use crate::geometry::{Dimension, Ground, Vector};
use crate::lattice::Lattice;
use crate::laws::{AnyContact, ContactLaw, Force, ForceLaws, Hooke, OnBars};
use crate::settings;
use crate::settings::{POSITIVE, STEPS, Settings, within};

settings! {
    /// The lattice: its size and its place (D1).
    struct LatticeSettings {
        /// Number of nodes in a row.
        columns: usize = 6, allowed within(2.0, 64.0),
            read "without a `file`" if Scene::is_generated,
            source "paper: 6";
        /// Number of rows.
        rows: usize = 6, allowed within(2.0, 64.0),
            read "without a `file`" if Scene::is_generated,
            source "paper: 6";
        /// Number of nodes across. A lattice has at most 4096 nodes.
        depth: usize = 3, allowed within(2.0, 64.0),
            read "with `kind = \"cubic\"`" if |s: &Scene| s.lattice.is_cubic(),
            source "beyond the paper";
        /// Whether cubes have body diagonals, in addition to the diagonals of their faces.
        body_diagonals: bool = false,
            read "with `kind = \"cubic\"`" if |s: &Scene| s.lattice.is_cubic(),
            source "beyond the paper";
        /// Distance between neighbouring nodes.
        spacing: f64 = 0.1, allowed within(1e-3, 100.0), unit "m",
            read "without a `file`" if Scene::is_generated,
            source "D1";
        /// Height of row 0 above the ground line at the start.
        drop: f64 = 0.0, allowed within(-10.0, 100.0), unit "m",
            read "without a `file`" if Scene::is_generated,
            source "D1";
        /// Squares with both diagonals, equilateral triangles, or cubes, which are a robot in space.
        kind: LatticeKind = LatticeKind::Rectangular,
            read "without a `file`" if Scene::is_generated,
            source "D1";
        /// Number of the node that carries `physics.payload_mass`: row * columns + column, from 0 at the lower left.
        payload: usize = 0, allowed within(0.0, 4095.0),
            auto "node 0; with `mirror` the node in the middle of row 0, in space in the middle of its rear",
            read "without a `file`" if Scene::is_generated,
            source "paper: 0";
        /// Whether the robot is its own mirror image, with the payload in the middle. In the plane, front and back are mirror
        /// images; with the policy "gaits" so are the gaits ahead and back. In space, left and right are mirror images, also in
        /// what the network does.
        mirror: bool = false, source "beyond the paper";
        /// Nodes and edges instead of columns and rows: the path of a truss file, relative to the scene's file.
        file: TrussFile = TrussFile::default(), source "the paper has none";
    }
}

settings! {
    /// The edges of a generated lattice.
    #[derive(Default)]
    enum LatticeKind {
        /// Squares with both diagonals.
        #[default]
        Rectangular = "rectangular",
        /// Equilateral triangles, every second row half a spacing further along.
        Triangular = "triangular",
        /// Cubes with both diagonals of each face.
        Cubic = "cubic",
    }
}

/// The dimension of a generated lattice, which is that of its kind.
impl From<LatticeKind> for Dimension {
    fn from(kind: LatticeKind) -> Self {
        match kind {
            LatticeKind::Cubic => Self::Space,
            LatticeKind::Rectangular | LatticeKind::Triangular => Self::Plane,
        }
    }
}

impl LatticeSettings {
    /// True if the nodes and edges come from a truss file or from a program, and not from columns and rows.
    pub fn is_truss(&self) -> bool {
        self.file.truss().is_some()
    }

    /// True if the lattice is generated and consists of cubes.
    pub fn is_cubic(&self) -> bool {
        !self.is_truss() && self.kind == LatticeKind::Cubic
    }

    /// Whether the lattice is in the plane or in space.
    pub fn dimension(&self) -> Dimension {
        match self.file.truss() {
            Some(truss) => truss.dimension,
            None => self.kind.into(),
        }
    }

    /// The number of nodes of a generated lattice, at most the largest `usize`.
    pub fn nodes(&self) -> usize {
        let depth = if self.is_cubic() { self.depth } else { 1 };
        self.columns.saturating_mul(self.rows).saturating_mul(depth)
    }

    /// The height of the lowest node above the ground line at the start, in metres.
    pub fn lowest(&self) -> f64 {
        let truss = self.file.truss();
        truss.map_or(self.drop, |truss| truss.lowest())
    }

    /// A short name of the lattice: its size, such as `6x6`, or the path of its truss file.
    pub fn name(&self) -> String {
        let size = format!("{}x{}", self.columns, self.rows);
        match (self.file.truss(), self.kind) {
            (Some(_), _) => self.file.path().to_owned(),
            (None, LatticeKind::Rectangular) => size,
            (None, LatticeKind::Triangular) => format!("triangular {size}"),
            (None, LatticeKind::Cubic) => format!("{}x{}x{}", self.columns, self.depth, self.rows),
        }
    }
}

/// The largest number of substeps.
pub(crate) const MOST_SUBSTEPS: f64 = 1024.0;

settings! {
    /// The physics of a rollout, with the ground line, which passes through the origin of the world.
    struct PhysicsSettings with ground: GroundSettings {
        /// Time step.
        dt: f64 = 0.002, allowed within(1e-9, 1.0), unit "s",
            auto "0.002 s times the time scale, or less if the largest number of substeps is not stable for every design",
            source "paper, table 2";
        /// Number of steps of a rollout.
        steps: usize = 8192, allowed STEPS,
            auto "16.384 s times the time scale, divided by `dt`", source "paper, table 2";
        /// Integration method.
        integrator: Integrator = Integrator::SymplecticEuler, source "paper: symplectic Euler";
        /// Number of mechanical steps per step of the controller.
        substeps: usize = 1, allowed within(1.0, MOST_SUBSTEPS),
            auto "the smallest number whose substep is at most 0.97 of the step that is stable for every design", source "paper: 1";
        /// Gravity, which points straight down on inclines too.
        gravity: f64 = 4.8, allowed within(-1e3, 1e3), unit "m/s2", source "found by experiment";
        /// Damping rate of the velocities.
        damping: f64 = 20.0, allowed within(0.0, 1e4), unit "1/s", source "found by experiment";
        /// Mass of a node without its edges.
        node_mass: f64 = 1e-4, allowed within(1e-9, 1e3), unit "kg", source "D2";
        /// Extra mass of the payload.
        payload_mass: f64 = 0.03, allowed within(0.0, 1e3), unit "kg", source "found by experiment";
        /// Angle of the ground; above 0 the robot walks uphill.
        incline_deg: f64 = 0.0, allowed within(-80.0, 80.0), unit "degrees",
            source "paper: 0, and 15 for the incline";
        /// Contact law of the ground.
        contact: ContactLaw = ContactLaw::infinite(),
            source "paper: infinite friction, Coulomb for one case";
        /// Coefficient of friction of contact laws that slip, such as Coulomb contact.
        friction: f64 = 2.5, allowed within(0.0, 1e3),
            read "with a contact law that slips" if Scene::slips,
            source "paper: 2.5";
        /// Forces in addition to springs, by the names of their laws.
        forces: ForceLaws = ForceLaws::default(), source "the paper has none";
        /// Whether the void edges of a one-hot layout pull.
        void_edges: VoidEdges = VoidEdges::Keep, source "paper: they do";
        /// The speed of a node above which a rollout counts as diverged. Nodes reach 13 m/s in delivered robots, about 50
        /// m/s in undecided robots that hold together, and several hundred in robots that fly apart.
        speed_bound: Option<f64> = Some(100.0), allowed POSITIVE, unit "m/s",
            auto "100 m/s times `l / 0.5 m` divided by the time scale",
            source "found by experiment";
        /// What an optimisation does if the time step is so long that the robot's vibrations grow.
        unstable_step: UnstableStep = UnstableStep::Error, source "beyond the paper";
    } of cases {
        /// Number of times that an implicit step solves its equations, each time about the last result. Once is
        /// inaccurate: it brakes stiff robots that turn.
        passes: usize = 2, source "found by experiment";
    }
}

settings! {
    /// The integration method of positions and velocities.
    #[derive(Default)]
    enum Integrator {
        /// Updates the velocities with the current forces, then the positions with the new velocities. First order.
        #[default]
        SymplecticEuler = "symplectic_euler",
        /// Half a drift, half a damping, the forces at the middle, half a damping, half a drift. Second order between
        /// contacts.
        Leapfrog = "leapfrog",
        /// Solves for the velocities with the forces of bars at the end of the step. First order. Stable with stiff bars,
        /// at steps that are a thousand times as long as those of the other methods, but each step takes longer, and
        /// vibrations that it does not resolve are damped.
        Implicit = "implicit",
    }
}

settings! {
    /// Whether the void edges of a layout, which have almost no stiffness, are kept.
    #[derive(Default)]
    enum VoidEdges {
        /// They pull with the stiffness of void.
        #[default]
        Keep = "keep",
        /// They do not pull at all, and no step computes them; their mass stays. Void edges keep their stiffness in
        /// mixtures.
        Drop = "drop",
    }
}

settings! {
    /// The reaction to an unstable time step.
    enum UnstableStep {
        /// The run is refused.
        Error = "error",
        /// The run continues with a warning.
        Warn = "warn",
    }
}

impl From<&PhysicsSettings> for Ground {
    fn from(physics: &PhysicsSettings) -> Self {
        let incline_deg = physics.incline_deg;
        Self { incline_deg }
    }
}

impl PhysicsSettings {
    /// The sections that belong to the physics but are written separately: the ground, and each chosen law that has
    /// settings. The section of a law has the name of the law.
    pub(in crate::scene) fn own_sections(&mut self) -> Vec<(&'static str, &mut dyn Settings)> {
        let ground: (_, &mut dyn Settings) = ("ground", &mut self.ground);
        let contact = (self.contact.name(), self.contact.settings());
        let mut all: Vec<_> = [ground, contact]
            .into_iter()
            .chain(self.forces.settings())
            .collect();
        all.retain_mut(|(_, settings)| !settings.fields().is_empty());
        all
    }

    /// The contact law that the scene chooses.
    pub(crate) fn contact_law(&self) -> Box<dyn AnyContact> {
        let mut law = self.contact.law().boxed();
        self.fill(law.settings());
        law
    }

    /// The force laws that act on a lattice. The springs come first.
    pub(crate) fn forces_on(&self, lattice: &Lattice) -> Vec<Arc<dyn Force>> {
        let springs: Arc<dyn Force> = Arc::new(OnBars(Hooke {}));
        let chosen = self.forces.laws().filter_map(|law| {
            let mut law = law.boxed();
            self.fill(law.settings());
            law.on(lattice)
        });
        [springs].into_iter().chain(chosen).collect()
    }

    /// Fills the numbers of this section that a law reads too.
    fn fill(&self, law: &mut dyn Settings) {
        law.fill(&|key| self.number(key));
    }

    /// The value of a key of this section that a law reads, such as `physics.friction`.
    ///
    /// # Panics
    /// If the section has no number with this key.
    fn number(&self, key: &str) -> f64 {
        let mut own = self.clone();
        let fields = own.fields().into_iter();
        let mut numbers =
            fields.filter_map(|field| Some((field.key, field.value.json().as_f64()?)));
        let found = numbers.find(|(own, _)| key.strip_prefix("physics.") == Some(own));
        let (_, number) = found.unwrap_or_else(|| {
            panic!("a law reads `{key}`, but the section [physics] has no number of this name")
        });
        number
    }
}

settings! {
    /// The controller: policy, size, inputs, goals and initial weights.
    struct ControllerSettings {
        /// The policy: a network that observes the robot, the same network in open loop (it does not observe the robot), or a
        /// network with hidden units for each direction of a given goal.
        policy: ItemName = ItemName::policy(), source "paper: mlp";
        /// Width of the hidden layer.
        hidden: usize = 32, allowed within(1.0, 4096.0), source "paper: 32";
        /// Number of clock signals.
        clocks: usize = 10, allowed within(1.0, 1024.0), source "paper: 10";
        /// Angular frequency of the clock.
        omega: f64 = 10.0, allowed within(0.0, 1e4), unit "rad/s",
            auto "10 rad/s divided by the time scale, times 0.35 divided by the largest actuation strain (a factor from \
                  0.25 to 4); twice that where `volume.actuator` follows to `[0.35, 0.45]`",
            source "paper: 10";
        /// Whether the frequency of the clock is a design variable, which begins at `omega`.
        clock: ClockKind = ClockKind::Fixed, source "paper: fixed";
        /// Position of the goal along the ground and above it, or with three numbers along, across and above. It is measured
        /// from the world's origin, where the first column starts. For the task `reach` it is the place to go to. Otherwise a
        /// fixed goal is only a pair of numbers that the network sees.
        goal: Vector<f64> = Vector::upright(2.0, 0.1), allowed within(-1e6, 1e6), unit "m", auto "`[2 m, 0.1 m]` times `l / 0.5 m`",
            read "with a `goal_scale` above 0, or for the task `reach`" if |s: &Scene| s.controller.goal_scale > 0.0 || s.reaches(),
            source "paper: 2, 0.1";
        /// Factor on the goal in the observation.
        goal_scale: f64 = 0.05, allowed within(0.0, 1e6), unit "1/m", auto "0.05 / m divided by `l / 0.5 m`; 3 / m for a given goal",
            source "D3, found by experiment";
        /// The goals for which the controller is trained: the constant `goal`, or goals that are given to every rollout and
        /// may change while the robot walks. A robot can be steered only by given goals.
        goals: GoalKind = GoalKind::Fixed, source "paper: fixed";
        /// Factor on the node offsets in the observation.
        offset_scale: f64 = 0.05, allowed within(0.0, 1e6), unit "1/m",
            auto "0.05 / m times `sqrt(36 / nodes)`, divided by `l / 0.5 m`",
            source "D3, found by experiment";
        /// Factor on the node velocities in the observation.
        velocity_scale: f64 = 0.05, allowed within(0.0, 1e6), unit "s/m",
            auto "0.05 s/m times `sqrt(36 / nodes)` and the time scale, divided by `l / 0.5 m`",
            source "D3, found by experiment";
        /// Gain of the Xavier initialisation of the hidden and the output layer.
        gain: [f64; 2] = [2.0, 2.0], allowed within(0.0, 1e3),
            auto "gains for which the first activations are as large as with `[2, 0.2]` and 36 nodes, 110 edges, 10 clock \
                  signals and 32 hidden units; times the care",
            source "found by experiment";
    } of cases {
        /// Whether the goal is given relative to the mean node position.
        goal_relative: bool = false, source "D3; paper: false";
    }
}

settings! {
    /// The goals for which a controller is trained.
    #[derive(Default)]
    enum GoalKind {
        /// The goal is the constant `goal`.
        #[default]
        Fixed = "fixed",
        /// Every rollout has its own goals; `goal` is the goal of a rollout that is given none.
        Given = "given",
    }
}

settings! {
    /// Whether the frequency of the clock is a design variable.
    #[derive(Default)]
    enum ClockKind {
        /// The frequency is `omega`.
        #[default]
        Fixed = "fixed",
        /// The controller has one more number, `tempo`. The frequency is `omega * exp(tempo)`.
        Learned = "learned",
    }
}

/// The parts of a state that a controller observes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Senses {
    /// The positions of the nodes.
    pub x: bool,
    /// The velocities of the nodes.
    pub v: bool,
}

impl ControllerSettings {
    /// The number of entries in an observation of a robot with this number of nodes: the clocks, the goal, and the
    /// offsets and velocities of the nodes. A file may state an absurd number of clocks: the result is at most the
    /// largest `usize`.
    pub fn observation_length(&self, dimension: Dimension, nodes: usize) -> usize {
        self.clocks
            .saturating_add(dimension.count() * (1 + 2 * nodes))
    }

    /// Whether an observation depends on positions, and whether it depends on velocities.
    pub fn senses(&self) -> Senses {
        let relative = self.goal_relative || self.goals == GoalKind::Given;
        let follows_goal = relative && self.goal_scale != 0.0;
        Senses {
            x: self.offset_scale != 0.0 || follows_goal,
            v: self.velocity_scale != 0.0,
        }
    }

    /// If the policy does not fit the kind of goal: the key to change (besides `controller.goals`), and why.
    pub(crate) fn misfit(&self) -> Option<(&'static str, &'static str)> {
        let unseen = "given goals need a policy that observes the robot, and a goal_scale above 0";
        match (self.goals, self.policy.name()) {
            (GoalKind::Fixed, "gaits") => Some((
                "controller.policy",
                "the policy \"gaits\" needs goals = \"given\"",
            )),
            (GoalKind::Given, "clock") => Some(("controller.policy", unseen)),
            (GoalKind::Given, _) if self.goal_scale == 0.0 => {
                Some(("controller.goal_scale", unseen))
            }
            _ => None,
        }
    }
}
