//! Parses the requests of the page and carries them out.

use crate::session::Session;
use cosmic::Registry;
use cosmic::design::Material;
use cosmic::error::{Error, Result};
use cosmic::scene::{BUILTIN, Scene};
use serde::Deserialize;
use serde_json::{Value, json};

/// Lattices with more nodes do not fit into the memory that a browser gives.
const MOST_NODES: usize = 1024;

/// A request that the page sends.
#[derive(Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// Lists the built-in scenes.
    Scenes,
    /// Checks a scene, and lists all its settings.
    Check(Asked),
    /// Begins a design, and returns the robot before the first iteration.
    Begin { scene: Asked, seed: u64 },
    /// Does one iteration of the design.
    Iterate { shown: bool },
    /// Returns what more material in each bar of the robot in design would bring within the horizon of the next iteration.
    /// If `tried` is the number of a bar and a share, also how much farther the robot gets with this share more in it.
    Gains { tried: Option<(usize, f64)> },
    /// Tries more robots of an evolution for the scene of the design, which has no gradients.
    Evolve { tries: usize },
    /// Chooses the robot to deliver, after the last iteration. If `packed`, it is the robot that its link holds.
    Deliver { packed: bool },
    /// Gives the delivered robot other materials. Without `materials`, restores those of the design.
    Edit { materials: Option<Vec<Material>> },
    /// Gives the delivered robot the edits of a link.
    Restore { bytes: Vec<u8> },
    /// Lets the robot that was shown last walk on to a goal, from a frame of its walk. `to` is the place of the goal
    /// along the ground and across (m), counted from the payload at the start; a planar robot ignores the part across.
    Tell { to: [f64; 2], frame: usize },
    /// Lets the robot that was shown last walk on after a push, from a frame of its walk. `velocity` (along,
    /// across, above) is added to the velocity of every node, m/s; a planar robot ignores the part across.
    Push { velocity: [f64; 3], frame: usize },
    /// Lets the delivered robot, with its edits, walk in a world with other settings of the physics.
    Visit { settings: Vec<String> },
    /// Measures the delivered robot with its edits a little further, and judges it when everything is measured.
    Judge,
    /// Returns the delivered robot, with its edits, in bytes for a link.
    Share,
    /// Opens a robot that was packed for a link, in its scene.
    Open { scene: Asked, bytes: Vec<u8> },
    /// Returns the pieces of the delivered robot, and the set points of its actuators.
    Shop,
    /// Returns the texts of `design.json` and `scene.toml`.
    Design,
    /// Panics, for tests.
    Panic,
}

/// The scene of a request: the name of a built-in scene or the TOML text of a scene, and settings that replace some of
/// its own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    scene: String,
    settings: Vec<String>,
}

impl Asked {
    fn read(&self) -> Result<Scene> {
        let (name, text) = match Registry::default().scene(&self.scene) {
            Some(builtin) => (builtin.name, builtin.text),
            None => ("scene.toml", &self.scene[..]),
        };
        let scene = Scene::parse(name, text)?.set(&self.settings)?;
        match scene.lattice.nodes() {
            nodes if nodes > MOST_NODES => Err(Error::Usage(format!(
                "`lattice.columns` and `lattice.rows` make {nodes} nodes; the memory of a browser is enough for {MOST_NODES}"
            ))),
            _ => Ok(scene),
        }
    }
}

/// Carries out a request, and returns the answer as JSON.
pub(crate) fn answer(session: &mut Session, request: &[u8]) -> String {
    let answer = match serde_json::from_slice(request) {
        Ok(request) => carry_out(session, request).map_err(|error| plain(&error)),
        Err(error) => Err(format!("malformed request: {error}")),
    };
    match answer {
        Ok(ok) => json!({ "ok": ok }).to_string(),
        Err(error) => json!({ "error": error }).to_string(),
    }
}

/// An error in one line. The page has no command line, so its errors do not show options with a caret below them.
fn plain(error: &Error) -> String {
    match error {
        Error::Malformed {
            message, allowed, ..
        } if allowed.is_empty() => message.clone(),
        Error::Malformed {
            message, allowed, ..
        } => format!("{message}; {allowed}"),
        error => error.to_string(),
    }
}

fn carry_out(session: &mut Session, request: Request) -> Result<Value> {
    match request {
        Request::Scenes => Ok(scenes()),
        Request::Check(asked) => {
            let scene = asked.read()?;
            let profile = scene.physics.ground.resolved();
            let points = profile.points().iter().map(|point| point.in_plane());
            let points: Vec<[f64; 2]> = points.collect();
            Ok(json!({ "toml": scene.to_toml(), "settings": scene, "profile": points }))
        }
        Request::Begin { scene, seed } => session.begin(&scene.read()?, seed),
        Request::Iterate { shown } => session.iterate(shown),
        Request::Gains { tried } => session.gains(tried),
        Request::Evolve { tries } => session.evolve(tries),
        Request::Deliver { packed } => session.deliver(packed),
        Request::Edit { materials } => session.edit(materials),
        Request::Restore { bytes } => session.restore(bytes),
        Request::Tell { to, frame } => session.tell(to, frame),
        Request::Push { velocity, frame } => session.push(velocity, frame),
        Request::Visit { settings } => session.visit(&settings),
        Request::Judge => session.judge(),
        Request::Share => session.share(),
        Request::Open { scene, bytes } => session.open(&scene.read()?, bytes),
        Request::Shop => session.shop(),
        Request::Design => session.design(),
        Request::Panic => panic!("a panic for tests"),
    }
}

fn scenes() -> Value {
    let scene = |builtin: &cosmic::scene::Builtin| json!({ "name": builtin.name, "about": builtin.about() });
    BUILTIN.iter().map(scene).collect()
}
