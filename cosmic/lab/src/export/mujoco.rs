//! A robot for MuJoCo: a model in MJCF, the controller's weights, and a player.
//!
//! In flight, MuJoCo and this program agree except for rounding. Nodes are bodies with a sliding joint for each
//! coordinate: along and above the ground, and in space also across. Bars are tendons. Both programs take semi-implicit
//! Euler steps. In contact they differ: MuJoCo's contact is soft and frictional, while this program finds the time of each
//! impact.

use super::controller::{Folded, GoalFields};
use crate::files::write_text;
use cosmic::case::Case;
use cosmic::error::{Error, Result};
use cosmic::format::Format;
use cosmic::geometry::{Dimension, Ground, Vector};
use cosmic::lattice::{Body, Marker};
use cosmic::laws::{Actuator, Bumpers, Damper, Law, Stops};
use cosmic::policy::{Weights, frequency};
use cosmic::record::files::{make_folder, write_json};
use cosmic::scene::Integrator;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The format of `controller.json`.
const FORMAT: Format = Format::new("cosmic-mujoco", 1);

/// The name of the model's file.
pub const MODEL: &str = "robot.xml";

/// The name of the player's file, a Python program.
pub const PLAYER: &str = "walk.py";

/// The largest coefficient of friction that is allowed. Above it, MuJoCo's contacts creep and depend on the solver.
pub const MOST_FRICTION: f64 = 5.0;

/// The radius of the sphere at each node, as a share of the lattice's scale: 2 mm if the spacing is 0.1 m. The spheres
/// collide with the ground.
const RADIUS: f64 = 0.002;

/// The keys of the section `physics` that an export knows. A scene that sets any other key is refused.
pub const PHYSICS: [&str; 15] = [
    // In the model and its masses, dampers and contacts.
    "dt",
    "substeps",
    "gravity",
    "damping",
    "node_mass",
    "payload_mass",
    "incline_deg",
    "friction",
    // In `controller.json`.
    "steps",
    // Values that the model cannot express are refused.
    "integrator",
    "contact",
    "forces",
    // Void edges are left out in either case.
    "void_edges",
    // They only judge a rollout.
    "speed_bound",
    "unstable_step",
];

/// Settings that MuJoCo needs and a scene does not have.
#[derive(Clone, Debug, PartialEq)]
pub struct MujocoSettings {
    /// Coefficient of friction. `None` takes the scene's coefficient, but at most [`MOST_FRICTION`]. Ground without
    /// slipping gets [`MOST_FRICTION`].
    pub friction: Option<f64>,
    /// The number of mechanical steps in each step of the controller. If the scene
    /// has more, the model has as many as the scene.
    pub substeps: usize,
    /// Whether skeleton bars are rigid: equality constraints take the place of their springs and dampers.
    pub rigid: bool,
}

impl Default for MujocoSettings {
    fn default() -> Self {
        Self {
            friction: None,
            substeps: 4,
            rigid: false,
        }
    }
}

/// Writes the model, the controller and the player of a case's robot into a folder; returns the paths.
///
/// Leaves out the void edges of a layout. Also leaves out nodes that have no edge and that the controller does not
/// observe, and the law `bumpers`: in MuJoCo bars pass through one another.
///
/// # Errors
/// [`Error::Usage`] if the scene has something that the model cannot express; [`Error::Write`].
pub fn write(case: &Case, settings: &MujocoSettings, folder: &Path) -> Result<Vec<PathBuf>> {
    check(case, settings)?;
    let robot = MujocoRobot::new(case, settings);
    let paths = [MODEL, "controller.json", PLAYER].map(|name| folder.join(name));
    make_folder(folder)?;
    write_text(&paths[0], &robot.model())?;
    write_json(&paths[1], FORMAT, &robot.weights())?;
    write_text(&paths[2], include_str!("walk.py"))?;
    Ok(paths.to_vec())
}

/// Returns an error for a case that the model cannot express.
fn check(case: &Case, settings: &MujocoSettings) -> Result<()> {
    let physics = &case.scene.physics;
    let known = [Damper::NAME, Stops::NAME, Actuator::NAME, Bumpers::NAME];
    let mut forces = physics.forces.about().into_iter();
    let has_other_forces = forces.any(|(name, _)| !known.contains(&name));
    if physics.integrator == Integrator::Implicit && !settings.rigid {
        return Err(Error::Usage(
            "MuJoCo has no implicit step for stiff bars; add --rigid, which holds skeleton bars at their length"
                .to_owned(),
        ));
    }
    let has_other_contact = !["none", "infinite", "coulomb"].contains(&physics.contact.name());
    let beyond = case.scene.physics_beyond(&PHYSICS).into_iter();
    let beyond = beyond.filter_map(|other| Some(format!("{}={}", other.key, other.there?)));
    let refusals = [
        (
            physics.integrator == Integrator::Leapfrog,
            "physics.integrator=symplectic_euler",
        ),
        (has_other_forces, "physics.forces=[]"),
        (has_other_contact, "physics.contact=coulomb"),
        (!physics.ground.resolved().is_flat(), "ground.profile=flat"),
        (
            !["mlp", "clock", "gaits"].contains(&case.scene.controller.policy.name()),
            "controller.policy=mlp",
        ),
    ];
    let refusals = refusals.into_iter().filter(|(is_refused, _)| *is_refused);
    let mut refusals = refusals
        .map(|(_, setting)| setting.to_owned())
        .chain(beyond);
    match refusals.next() {
        None => Ok(()),
        Some(setting) => Err(Error::Usage(format!(
            "the model for MuJoCo can only express {setting}, but the scene has another value; export it \
             with --set {setting}"
        ))),
    }
}

/// The robot of a case, reduced to the nodes and edges that the MuJoCo model contains.
struct MujocoRobot<'c> {
    case: &'c Case,
    settings: &'c MujocoSettings,
    ground: Ground,
    body: Body<f64>,
    damper: Option<Damper>,
    stops: Option<Stops>,
    device: Option<Actuator>,
    controller: Folded<'c>,
    /// The nodes of the model, ascending.
    nodes: Vec<usize>,
    /// The edges of the model, ascending.
    bars: Vec<usize>,
    /// The edges that the controller can strain, ascending.
    actuators: Vec<usize>,
}

impl<'c> MujocoRobot<'c> {
    fn new(case: &'c Case, settings: &'c MujocoSettings) -> Self {
        let ground = Ground::from(&case.scene.physics);
        let body = case.body();
        let controller = Folded::new(case, &body, &ground);
        let controller = controller.expect("`check` accepts only networks");
        let layout = case.design.layout();
        let is_bar = |edge: &usize| layout.is_none_or(|layout| layout[*edge].is_solid());
        let bars = (0..case.lattice.edges.len()).filter(is_bar);
        let bars: Vec<usize> = bars.collect();
        let actuators = bars
            .iter()
            .copied()
            .filter(|&edge| body.strain[edge] != 0.0);
        let actuators: Vec<usize> = actuators.collect();
        let is_joined = |node| {
            bars.iter()
                .any(|&edge| case.lattice.edges[edge].contains(&node))
        };
        // The payload always stays in the model, because its displacement is measured.
        let payload = body.marker.payload;
        let is_there =
            |&node: &usize| node == payload || is_joined(node) || controller.observes(node);
        let nodes: Vec<usize> = (0..case.lattice.nodes()).filter(is_there).collect();
        Self {
            controller,
            case,
            settings,
            ground,
            body,
            damper: case.scene.physics.forces.chosen(),
            stops: case.scene.physics.forces.chosen(),
            device: case.scene.physics.forces.chosen(),
            nodes,
            bars,
            actuators,
        }
    }

    fn dimension(&self) -> Dimension {
        self.case.lattice.dimension
    }

    /// Returns the radius of the sphere at each node, in metres.
    fn radius(&self) -> f64 {
        RADIUS * self.case.lattice.scale
    }

    fn substeps(&self) -> usize {
        self.settings.substeps.max(self.case.scene.physics.substeps)
    }

    fn friction(&self) -> f64 {
        let physics = &self.case.scene.physics;
        let own = match physics.contact.name() {
            "coulomb" => physics.friction,
            _ => MOST_FRICTION,
        };
        self.settings.friction.unwrap_or(own).min(MOST_FRICTION)
    }

    /// Returns the text of the model in MJCF.
    fn model(&self) -> String {
        let physics = &self.case.scene.physics;
        let dt = physics.dt / self.substeps() as f64;
        let (gravity, friction) = (-physics.gravity, self.friction());
        let bodies: String = self.nodes.iter().map(|&node| self.node(node, dt)).collect();
        let of_bar = |&edge: &usize| self.tendon(edge) + &self.stops(edge);
        let tendons: String = self.bars.iter().map(of_bar).collect();
        let actuators: String = self
            .actuators
            .iter()
            .map(|&edge| self.actuator(edge))
            .collect();
        let equalities: String = (self.bars.iter())
            .filter(|edge| self.is_rigid(**edge))
            .map(|&edge| self.equality(edge, dt))
            .collect();
        let (ground, start) = (self.ground(), self.start());
        let (radius, scale) = (self.radius(), self.case.lattice.scale);
        // The depth over which a contact stiffens, the widths of the tendons, and the camera's view.
        let axes = match self.dimension() {
            Dimension::Plane => "two coordinates a node, along the ground and above it",
            Dimension::Space => "three coordinates a node, along the ground, across, and above it",
        };
        let [depth, thin, thick, up, extent] = [0.0005, 0.003, 0.004, 0.4, 1.5].map(|x| x * scale);
        format!(
            "<mujoco model=\"cosmic\">
  <!-- Nodes n0, n1, ... and edges e0, e1, ... have their numbers of design.json. Void edges are left
       out. qpos has {axes}. -->
  <option timestep=\"{dt}\" gravity=\"0 0 {gravity}\" integrator=\"Euler\" solver=\"Newton\"
    cone=\"elliptic\" impratio=\"100\" iterations=\"100\" tolerance=\"0.00000001\">
    <flag eulerdamp=\"disable\"/>
  </option>
  <default>
    <joint type=\"slide\"/>
    <geom type=\"sphere\" size=\"{radius}\" contype=\"1\" conaffinity=\"0\" friction=\"{friction} 0 0\"
      solref=\"0.002 1\" solimp=\"0.95 0.99 {depth}\" rgba=\"0.2 0.2 0.2 1\"/>
    <tendon width=\"{thin}\" rgba=\"0.2 0.2 0.2 1\"/>
    <default class=\"actuator\"><tendon width=\"{thick}\" rgba=\"0.1 0.4 0.8 1\"/></default>
  </default>
  <statistic center=\"{scale} 0 {up}\" extent=\"{extent}\"/>
  <worldbody>
    <light pos=\"1 -2 4\" dir=\"0 0.4 -1\" directional=\"true\"/>
{ground}{bodies}  </worldbody>
  <tendon>
{tendons}  </tendon>
  <equality>
{equalities}  </equality>
  <actuator>
{actuators}  </actuator>
  <keyframe>
{start}  </keyframe>
</mujoco>
"
        )
    }

    /// Returns the element for the plane of the ground. The plane is below the ground's line by the radius of the
    /// spheres, so that a sphere touches the plane when its node is on the line.
    fn ground(&self) -> String {
        if !self.case.scene.physics.contact.has_ground() {
            return String::new();
        }
        let normal = spatial(self.ground.normal());
        let place = spatial(
            self.ground
                .vector_to_world(Vector::from([0.0, -self.radius()])),
        );
        format!(
            "    <geom name=\"ground\" type=\"plane\" pos=\"{place}\" zaxis=\"{normal}\" size=\"0 0 1\" \
             contype=\"0\" conaffinity=\"1\" rgba=\"0.9 0.9 0.9 1\"/>\n"
        )
    }

    /// Returns the element for the body of a node. In an explicit step of `dt` seconds, MuJoCo multiplies the velocity
    /// by `1 - damping dt / mass`. `damping` is chosen such that this factor equals the scene's `exp(-gamma dt)`.
    fn node(&self, node: usize, dt: f64) -> String {
        let (mass, radius) = (self.body.mass[node], self.radius());
        let damping = -mass * (-self.case.scene.physics.damping * dt).exp_m1() / dt;
        let start = self.case.start.x[node];
        let place = spatial(start);
        let dimension = self.dimension();
        let names: &[&str] = match dimension {
            Dimension::Plane => &["x", "z"],
            Dimension::Space => &["x", "y", "z"],
        };
        let places = dimension.components(self.ground.vector_to_ground(start));
        let joints: String = (names.iter().zip(dimension.unit_vectors()))
            .zip(places)
            .map(|((name, axis), at)| {
                let axis = spatial(self.ground.vector_to_world(axis));
                format!(
                    "      <joint name=\"n{node}{name}\" axis=\"{axis}\" ref=\"{at}\" \
                     damping=\"{damping}\"/>\n"
                )
            })
            .collect();
        // Bodies that slide do not turn, so their moments of inertia have no effect.
        format!(
            "    <body name=\"n{node}\" pos=\"{place}\">\n{joints}      \
             <inertial pos=\"0 0 0\" mass=\"{mass}\" diaginertia=\"1e-6 1e-6 1e-6\"/>\n      \
             <geom/><site name=\"n{node}\" size=\"{radius}\"/>\n    </body>\n"
        )
    }

    fn tendon(&self, edge: usize) -> String {
        let k = self.body.stiffness[edge];
        let mut bar = if self.actuators.contains(&edge) {
            "class=\"actuator\"".to_owned()
        } else if self.is_rigid(edge) {
            return self.between_ends(edge, &format!("name=\"e{edge}\""));
        } else {
            let length = self.rest_length(edge);
            format!("stiffness=\"{k}\" springlength=\"{length}\"")
        };
        if let Some(damper) = &self.damper {
            bar += &format!(" damping=\"{}\"", k * damper.time);
        }
        self.between_ends(edge, &format!("name=\"e{edge}\" {bar}"))
    }

    fn is_rigid(&self, edge: usize) -> bool {
        self.settings.rigid && !self.actuators.contains(&edge)
    }

    /// Returns the element that holds a bar at its rest length. MuJoCo counts from the length at the start. Its constraints
    /// are soft: they correct an error with a time constant, which is at least two mechanical steps of `dt` (s).
    fn equality(&self, edge: usize, dt: f64) -> String {
        let [from, to] = self.case.lattice.edges[edge].map(|node| self.case.start.x[node]);
        let longer = self.case.lattice.rest_length[edge] - (to - from).norm();
        format!(
            "    <tendon tendon1=\"e{edge}\" polycoef=\"{longer} 0 0 0 0\" solref=\"{} 1\" \
             solimp=\"0.999 0.9999 0.0001\"/>\n",
            2.0 * dt
        )
    }

    /// Returns an element for the end stops of an actuator. It is a second tendon: a spring that has no force as long
    /// as the length is between the two stops.
    fn stops(&self, edge: usize) -> String {
        let strain = self.body.strain[edge];
        match &self.stops {
            Some(stops) if strain != 0.0 => {
                let stiffness = stops.stiffness * strain / stops.at;
                let rest_length = self.case.lattice.rest_length[edge];
                let [low, high] = [1.0 - stops.at, 1.0 + stops.at].map(|end| end * rest_length);
                let band = format!("stiffness=\"{stiffness}\" springlength=\"{low} {high}\"");
                self.between_ends(edge, &format!("name=\"s{edge}\" {band}"))
            }
            _ => String::new(),
        }
    }

    /// Returns the element for a tendon from one end of an edge to the other.
    fn between_ends(&self, edge: usize, attributes: &str) -> String {
        let [from, to] = self.case.lattice.edges[edge];
        format!(
            "    <spatial {attributes}><site site=\"n{from}\"/><site site=\"n{to}\"/></spatial>\n"
        )
    }

    /// Returns the element for an actuator that pulls along its tendon with the force `k (l0 (1 + strain) - length)`.
    /// Its control is the strain. Under the law `actuator` the player computes the force, which is the control.
    fn actuator(&self, edge: usize) -> String {
        if self.device.is_some() {
            return format!("    <motor name=\"a{edge}\" tendon=\"e{edge}\"/>\n");
        }
        let stiffness = self.body.stiffness[edge];
        let gain = stiffness * self.case.lattice.rest_length[edge];
        let bias = stiffness * self.rest_length(edge);
        format!(
            "    <general name=\"a{edge}\" tendon=\"e{edge}\" biastype=\"affine\" \
             gainprm=\"{gain}\" biasprm=\"{bias} -{stiffness} 0\"/>\n"
        )
    }

    /// Returns the rest length of a tendon. This program softens lengths, which makes them some picometres too long
    /// (D4). MuJoCo does not soften lengths, so the tendon's rest length is shorter by the same amount. Without this
    /// correction, errors in flight are several times larger.
    fn rest_length(&self, edge: usize) -> f64 {
        let length = self.case.lattice.rest_length[edge];
        length - 0.5 * self.case.lattice.softening() / length
    }

    fn start(&self) -> String {
        let start = self.case.start.to_ground(&self.ground);
        let list = |points: &[Vector<f64>]| {
            let own: Vec<Vector<f64>> = self.nodes.iter().map(|&node| points[node]).collect();
            let numbers = self.dimension().flat(&own);
            let numbers: Vec<String> = numbers.iter().map(f64::to_string).collect();
            numbers.join(" ")
        };
        let (x, v) = (list(&start.x), list(&start.v));
        format!("    <key name=\"start\" qpos=\"{x}\" qvel=\"{v}\"/>\n")
    }

    /// Returns one of the numbers of all edges for each actuator.
    fn of_actuators(&self, numbers: &[f64]) -> Vec<f64> {
        self.actuators.iter().map(|&edge| numbers[edge]).collect()
    }

    /// Returns the weight of each node of the model in the displacement that counts. The weights sum to 1.
    fn weights_of_marker(&self) -> Vec<f64> {
        let Marker { payload, weights } = &self.body.marker;
        let own = self.nodes.iter().map(|&node| match weights.get(node) {
            Some(weight) => *weight,
            None => f64::from(u8::from(node == *payload)),
        });
        let own: Vec<f64> = own.collect();
        let sum: f64 = own.iter().sum();
        own.iter().map(|weight| weight / sum).collect()
    }

    /// Returns the content of `controller.json`.
    fn weights(&self) -> ControllerFile {
        ControllerFile {
            nodes: self.nodes.clone(),
            weights: self.weights_of_marker(),
            actuators: self.actuators.clone(),
            network: Weights::from(&self.controller.reordered(&self.nodes, &self.actuators)),
            seen: self.controller.seen(&self.ground, &self.nodes),
            strain: self.of_actuators(&self.body.strain),
            device: self.device.as_ref().map(|law| Device {
                force: law.force,
                speed: law.speed,
                stiffness: self.of_actuators(&self.body.stiffness),
                length: self.of_actuators(&self.case.lattice.rest_length),
            }),
            omega: frequency(&self.case.scene.controller, &self.case.controller),
            dt: self.case.scene.physics.dt,
            substeps: self.substeps(),
            steps: self.case.scene.physics.steps,
        }
    }
}

/// The content of `controller.json`. `weights` has the weight of each node in the displacement that counts. The target
/// strains are `strain * tanh(w2 tanh(w1 s + b1) + b2)`, where `s` is `qpos`, `qvel`, `sin(omega t)`, `cos(omega t)`, and
/// a given goal as it is observed.
#[derive(Serialize)]
struct ControllerFile {
    nodes: Vec<usize>,
    weights: Vec<f64>,
    actuators: Vec<usize>,
    #[serde(flatten)]
    network: Weights,
    #[serde(flatten)]
    seen: Option<GoalFields>,
    strain: Vec<f64>,
    #[serde(flatten)]
    device: Option<Device>,
    omega: f64,
    dt: f64,
    substeps: usize,
    steps: usize,
}

/// The numbers of the law `actuator`, for the player: the largest force (N), the speed without a load (m/s), and the
/// stiffness (N/m) and rest length (m) of each actuator.
#[derive(Serialize)]
struct Device {
    force: f64,
    speed: f64,
    stiffness: Vec<f64>,
    length: Vec<f64>,
}

/// Returns a vector in text. A planar robot moves in MuJoCo's x-z plane.
fn spatial(vector: Vector<f64>) -> String {
    let [x, y, z] = vector.array();
    format!("{x} {y} {z}")
}
