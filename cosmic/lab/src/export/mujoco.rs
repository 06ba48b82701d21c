//! A robot for MuJoCo: a model in MJCF, the controller's weights, and a player.
//!
//! Flight is the same as here to the rounding of numbers: nodes are bodies that slide along the ground
//! and across it, bars are tendons, and MuJoCo's semi-implicit Euler steps are those of the scene. Contact
//! is another: soft and frictional there, by the time of impact here.

use super::numpy::{NumpyArray, write_npz};
use crate::files::write_text;
use cosmic::case::Case;
use cosmic::error::{Error, Result};
use cosmic::geometry::{Ground, Vector, flat};
use cosmic::lattice::{Body, SOFTENING};
use cosmic::laws::{Damper, Law, Stops};
use cosmic::policy::{Layer, NETWORK, Network, Weights};
use cosmic::record::files::{Format, make_folder, write_json};
use cosmic::scene::{Integrator, PhysicsSettings};
use serde::Serialize;
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// The format of the controller's JSON.
const FORMAT: Format = Format::new("cosmic-mujoco", 1);

/// The model's file.
pub const MODEL: &str = "robot.xml";

/// The player's file.
pub const PLAYER: &str = "walk.py";

/// The largest friction: beyond it MuJoCo's contacts creep and depend on the solver.
pub const MOST_FRICTION: f64 = 5.0;

/// Radius of the sphere at each node that meets the ground, m.
const RADIUS: f64 = 0.002;

/// The settings of MuJoCo that a scene does not have.
#[derive(Clone, Debug, PartialEq)]
pub struct MujocoSettings {
    /// Coefficient of friction; `None` takes the scene's, or [`MOST_FRICTION`] for a larger one and for ground
    /// that holds whatever touches it.
    pub friction: Option<f64>,
    /// Mechanical steps for each of the controller; the scene's own number if that is larger.
    pub substeps: usize,
    /// Time constant of a contact, s. MuJoCo takes two mechanical steps for a shorter one.
    pub contact_time: f64,
    /// Ratio of frictional to normal impedance: large values leave little creep.
    pub impedance_ratio: f64,
    /// The most iterations of the solver of contacts in a step.
    pub iterations: usize,
    /// The tolerance at which it ends.
    pub tolerance: f64,
}

impl Default for MujocoSettings {
    fn default() -> Self {
        Self {
            friction: None,
            substeps: 4,
            contact_time: 0.002,
            impedance_ratio: 100.0,
            iterations: 100,
            tolerance: 1e-8,
        }
    }
}

/// Writes the model, the controller and the player of a case's robot into a folder; returns the paths.
///
/// Void edges of a layout are left out, and nodes that no other edge joins and the controller does not
/// observe.
///
/// # Errors
/// [`Error::Usage`] where MuJoCo has no image of something in the scene; [`Error::Write`].
pub fn write(case: &Case, settings: &MujocoSettings, folder: &Path) -> Result<Vec<PathBuf>> {
    check(case)?;
    let robot = Robot::new(case, settings);
    let paths = [MODEL, "controller.npz", "controller.json", PLAYER].map(|name| folder.join(name));
    make_folder(folder)?;
    write_text(&paths[0], &robot.model())?;
    write_npz(&paths[1], &robot.arrays())?;
    write_json(&paths[2], FORMAT, &robot.weights())?;
    write_text(&paths[3], include_str!("walk.py"))?;
    Ok(paths.to_vec())
}

/// Refuses what has no image.
fn check(case: &Case) -> Result<()> {
    let physics = &case.physics;
    let contact = physics.contact.name();
    let refusals = [
        (
            physics.integrator != Integrator::SymplecticEuler,
            "integrator=symplectic_euler",
        ),
        (physics.stiffening > 0.0, "stiffening=0"),
        (physics.bending_radius > 0.0, "bending_radius=0"),
        (!ForcesOfBars::are_all(physics), "forces=[]"),
        (
            !["none", "infinite", "coulomb"].contains(&contact),
            "contact=coulomb",
        ),
    ];
    let flat = (!physics.ground.resolved().is_flat()).then_some("ground.profile=flat");
    let of_physics = refusals.iter().find(|(is, _)| *is);
    let instead = of_physics.map(|(_, key)| format!("physics.{key}"));
    let policy = !case.observation.policy.is_default();
    let policy = policy.then_some("controller.policy=mlp").map(str::to_owned);
    match instead.or(flat.map(str::to_owned)).or(policy) {
        None => Ok(()),
        Some(setting) => Err(Error::Usage(format!(
            "the model for MuJoCo has no image of what the scene has in place of {setting}; export it \
             without, by --set {setting}"
        ))),
    }
}

/// The laws beside springs that have an image.
struct ForcesOfBars {
    damper: Option<Damper>,
    stops: Option<Stops>,
}

impl ForcesOfBars {
    fn of(physics: &PhysicsSettings) -> Self {
        Self {
            damper: physics.forces.along_bars(),
            stops: physics.forces.along_bars(),
        }
    }

    /// True if a scene has no others.
    fn are_all(physics: &PhysicsSettings) -> bool {
        let known = [Damper::NAME, Stops::NAME];
        let names = physics.forces.about().into_iter();
        names
            .map(|(name, _)| name)
            .all(|name| known.contains(&name))
    }
}

/// A robot in MuJoCo's terms.
struct Robot<'c> {
    case: &'c Case,
    settings: &'c MujocoSettings,
    ground: Ground,
    body: Body<f64>,
    forces: ForcesOfBars,
    /// On `qpos`, `qvel`, sine and cosine of the clock.
    controller: Network<f64>,
    /// The nodes of the model, ascending.
    nodes: Vec<usize>,
    /// The edges that pull, ascending.
    bars: Vec<usize>,
    /// The edges among `bars` that the controller strains.
    actuators: Vec<usize>,
}

impl<'c> Robot<'c> {
    fn new(case: &'c Case, settings: &'c MujocoSettings) -> Self {
        let ground = Ground::from(&case.physics);
        let body = case.body();
        let count = case.lattice.nodes();
        let network = Network::of(&case.controller).expect("`check` has accepted a network");
        let folded = network.folded(&case.observation, count, &body.presence, &ground);
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
        let is_observed = |node| {
            let mut rows = folded.first.weights.chunks_exact(4 * count + 2);
            rows.any(|row| (0..4).any(|part| row[part * count + node] != 0.0))
        };
        // The displacement is that of node 0.
        let is_there = |&node: &usize| node == 0 || is_joined(node) || is_observed(node);
        let nodes: Vec<usize> = (0..count).filter(is_there).collect();
        Self {
            controller: reordered(&folded, &nodes, &actuators, count),
            case,
            settings,
            ground,
            body,
            forces: ForcesOfBars::of(&case.physics),
            nodes,
            bars,
            actuators,
        }
    }

    fn substeps(&self) -> usize {
        self.settings.substeps.max(self.case.physics.substeps)
    }

    fn friction(&self) -> f64 {
        let physics = &self.case.physics;
        let own = match physics.contact.name() {
            "coulomb" => physics.friction,
            _ => MOST_FRICTION,
        };
        self.settings.friction.unwrap_or(own).min(MOST_FRICTION)
    }

    /// The model in MJCF.
    fn model(&self) -> String {
        let physics = &self.case.physics;
        let dt = physics.dt / self.substeps() as f64;
        let MujocoSettings {
            contact_time,
            impedance_ratio,
            iterations,
            tolerance,
            ..
        } = self.settings;
        let (gravity, friction) = (-physics.gravity, self.friction());
        let bodies: String = self.nodes.iter().map(|&node| self.node(node, dt)).collect();
        let of_bar = |&edge: &usize| self.tendon(edge) + &self.stops(edge);
        let tendons: String = self.bars.iter().map(of_bar).collect();
        let actuators: String = self
            .actuators
            .iter()
            .map(|&edge| self.actuator(edge))
            .collect();
        let (ground, start) = (self.ground(), self.start());
        format!(
            "<mujoco model=\"cosmic\">
  <!-- Nodes n0, n1, ... and edges e0, e1, ... have their numbers of design.json. Void edges are left
       out. qpos has two coordinates a node, along the ground and above it. -->
  <option timestep=\"{dt}\" gravity=\"0 0 {gravity}\" integrator=\"Euler\" solver=\"Newton\"
    cone=\"elliptic\" impratio=\"{impedance_ratio}\" iterations=\"{iterations}\" tolerance=\"{tolerance}\">
    <flag eulerdamp=\"disable\"/>
  </option>
  <default>
    <joint type=\"slide\"/>
    <geom type=\"sphere\" size=\"{RADIUS}\" contype=\"1\" conaffinity=\"0\" friction=\"{friction} 0 0\"
      solref=\"{contact_time} 1\" solimp=\"0.95 0.99 0.0005\" rgba=\"0.2 0.2 0.2 1\"/>
    <tendon width=\"0.003\" rgba=\"0.2 0.2 0.2 1\"/>
    <default class=\"actuator\"><tendon width=\"0.004\" rgba=\"0.1 0.4 0.8 1\"/></default>
  </default>
  <statistic center=\"1 0 0.4\" extent=\"1.5\"/>
  <worldbody>
    <light pos=\"1 -2 4\" dir=\"0 0.4 -1\" directional=\"true\"/>
{ground}{bodies}  </worldbody>
  <tendon>
{tendons}  </tendon>
  <actuator>
{actuators}  </actuator>
  <keyframe>
{start}  </keyframe>
</mujoco>
"
        )
    }

    /// The ground, so far below its line that a sphere touches it when its node is on the line.
    fn ground(&self) -> String {
        if !self.case.physics.contact.has_ground() {
            return String::new();
        }
        let normal = spatial(self.ground.normal());
        let place = spatial(self.ground.point_to_world(Vector::new([0.0, -RADIUS])));
        format!(
            "    <geom name=\"ground\" type=\"plane\" pos=\"{place}\" zaxis=\"{normal}\" size=\"0 0 1\" \
             contype=\"0\" conaffinity=\"1\" rgba=\"0.9 0.9 0.9 1\"/>\n"
        )
    }

    /// A node, with the damping of mechanical steps of `dt` seconds: an explicit step takes the share
    /// `damping dt / mass` of the velocity off, which is to be what `exp(-gamma dt)` takes off.
    fn node(&self, node: usize, dt: f64) -> String {
        let mass = self.body.mass[node];
        let damping = -mass * (-self.case.physics.damping * dt).exp_m1() / dt;
        let start = self.case.start.x[node];
        let place = spatial(start);
        let axes = [("x", self.ground.tangent()), ("z", self.ground.normal())];
        let along = self.ground.point_to_ground(start);
        let joints: String = (axes.into_iter().zip(along))
            .map(|((name, axis), at)| {
                let axis = spatial(axis);
                format!(
                    "      <joint name=\"n{node}{name}\" axis=\"{axis}\" ref=\"{at}\" \
                     damping=\"{damping}\"/>\n"
                )
            })
            .collect();
        // Bodies that slide do not turn: their moments of inertia do nothing.
        format!(
            "    <body name=\"n{node}\" pos=\"{place}\">\n{joints}      \
             <inertial pos=\"0 0 0\" mass=\"{mass}\" diaginertia=\"1e-6 1e-6 1e-6\"/>\n      \
             <geom/><site name=\"n{node}\" size=\"{RADIUS}\"/>\n    </body>\n"
        )
    }

    fn tendon(&self, edge: usize) -> String {
        let k = self.body.stiffness[edge];
        let mut bar = if self.actuators.contains(&edge) {
            "class=\"actuator\"".to_owned()
        } else {
            let length = self.rest_length(edge);
            format!("stiffness=\"{k}\" springlength=\"{length}\"")
        };
        if let Some(damper) = &self.forces.damper {
            bar += &format!(" damping=\"{}\"", k * damper.time);
        }
        self.between_ends(edge, &format!("name=\"e{edge}\" {bar}"))
    }

    /// The end stops of an actuator: a spring with a dead band.
    fn stops(&self, edge: usize) -> String {
        let strain = self.body.strain[edge];
        match &self.forces.stops {
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

    /// A tendon between the ends of an edge.
    fn between_ends(&self, edge: usize, attributes: &str) -> String {
        let [from, to] = self.case.lattice.edges[edge];
        format!(
            "    <spatial {attributes}><site site=\"n{from}\"/><site site=\"n{to}\"/></spatial>\n"
        )
    }

    /// The force `k (l0 (1 + strain) - length)` along the tendon, by the strain as control.
    fn actuator(&self, edge: usize) -> String {
        let stiffness = self.body.stiffness[edge];
        let gain = stiffness * self.case.lattice.rest_length[edge];
        let bias = stiffness * self.rest_length(edge);
        format!(
            "    <general name=\"a{edge}\" tendon=\"e{edge}\" biastype=\"affine\" \
             gainprm=\"{gain}\" biasprm=\"{bias} -{stiffness} 0\"/>\n"
        )
    }

    /// The rest length of a tendon. The scene's bars measure themselves a little longer than they are (D4),
    /// some picometres near their rest length: errors of flight are several times larger without these.
    fn rest_length(&self, edge: usize) -> f64 {
        let length = self.case.lattice.rest_length[edge];
        length - 0.5 * SOFTENING / length
    }

    fn start(&self) -> String {
        let start = self.case.start.to_ground(&self.ground);
        let list = |points: &[Vector<f64>]| {
            let own: Vec<Vector<f64>> = self.nodes.iter().map(|&node| points[node]).collect();
            words(flat(&own).into_iter())
        };
        let (x, v) = (list(&start.x), list(&start.v));
        format!("    <key name=\"start\" qpos=\"{x}\" qvel=\"{v}\"/>\n")
    }

    /// How far a bar is strained by an activation of 1.
    fn strain(&self) -> Vec<f64> {
        self.actuators
            .iter()
            .map(|&edge| self.body.strain[edge])
            .collect()
    }

    /// The controller as arrays of NumPy.
    fn arrays(&self) -> [(&'static str, NumpyArray); 9] {
        let Network { first, second } = self.controller.clone();
        let [weights, biases, output_weights, output_biases] = NETWORK;
        let (hidden, outputs) = (first.biases.len(), second.biases.len());
        [
            (weights, NumpyArray::matrix(hidden, first.weights)),
            (biases, NumpyArray::vector(first.biases)),
            (output_weights, NumpyArray::matrix(outputs, second.weights)),
            (output_biases, NumpyArray::vector(second.biases)),
            ("strain", NumpyArray::vector(self.strain())),
            ("omega", NumpyArray::scalar(self.case.observation.omega)),
            ("dt", NumpyArray::scalar(self.case.physics.dt)),
            ("substeps", NumpyArray::scalar(self.substeps() as f64)),
            ("steps", NumpyArray::scalar(self.case.physics.steps as f64)),
        ]
    }

    /// The controller as JSON.
    fn weights(&self) -> ControllerFile {
        ControllerFile {
            nodes: self.nodes.clone(),
            actuators: self.actuators.clone(),
            network: Weights::from(&self.controller),
            strain: self.strain(),
            omega: self.case.observation.omega,
            dt: self.case.physics.dt,
            substeps: self.substeps(),
            steps: self.case.physics.steps,
        }
    }
}

/// The controller of the model in `controller.json`: `strain * tanh(w2 tanh(w1 s + b1) + b2)`, with
/// `s` the model's `qpos`, its `qvel`, `sin(omega t)` and `cos(omega t)`.
#[derive(Serialize)]
struct ControllerFile {
    nodes: Vec<usize>,
    actuators: Vec<usize>,
    #[serde(flatten)]
    network: Weights,
    strain: Vec<f64>,
    omega: f64,
    dt: f64,
    substeps: usize,
    steps: usize,
}

/// A folded controller of so many nodes with its inputs in the order of the model: positions node by node,
/// velocities node by node, the clock; and with outputs for actuators alone.
fn reordered(
    folded: &Network<f64>,
    nodes: &[usize],
    actuators: &[usize],
    count: usize,
) -> Network<f64> {
    let inputs = 4 * count + 2;
    let pairs = |part: usize| {
        let pair = move |&node| [part * count + node, (part + 1) * count + node];
        nodes.iter().flat_map(pair)
    };
    let clock = 4 * count..inputs;
    let columns: Vec<usize> = pairs(0).chain(pairs(2)).chain(clock).collect();
    let Network { first, second } = folded;
    let rows = first.weights.chunks_exact(inputs);
    let hidden = first.biases.len();
    let of_edge = |&edge: &usize| &second.weights[edge * hidden..][..hidden];
    Network {
        first: Layer {
            weights: rows
                .flat_map(|row| columns.iter().map(|&k| row[k]))
                .collect(),
            biases: first.biases.clone(),
        },
        second: Layer {
            weights: actuators.iter().flat_map(of_edge).copied().collect(),
            biases: actuators.iter().map(|&edge| second.biases[edge]).collect(),
        },
    }
}

/// A vector of the plane as one of space.
fn spatial(vector: Vector<f64>) -> String {
    let [x, z] = vector.array();
    format!("{x} 0 {z}")
}

/// Values as words between spaces.
fn words(values: impl Iterator<Item = impl Display>) -> String {
    let words: Vec<String> = values.map(|value| value.to_string()).collect();
    words.join(" ")
}
