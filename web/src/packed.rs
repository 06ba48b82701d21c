//! A robot in a few hundred bytes, for links: the material of each bar, and a network that follows the clock alone.
//!
//! The network of a robot with feedback is reduced to open loop: it observes the robot as it is at the start, in every
//! step. Its weights are rounded to 8 bits. The bytes are, in this order:
//!
//! | bytes | content |
//! | --- | --- |
//! | 1 | the version, 1 |
//! | 1 | the number of hidden units `H` |
//! | 4 | the tempo of a learned clock, as a little-endian `f32` |
//! | a quarter of the edges | the materials, two bits each |
//! | 3 rows of `H` | the hidden units' weights of the clock's sine and cosine, and their biases |
//! | 1 row of `H + 1` per solid edge | the weights and the bias of its activation |
//!
//! A row begins with a byte for its scale; then each number has a byte.

use cosmic::design::Material;
use cosmic::error::{Error, Result};
use cosmic::geometry::Ground;
use cosmic::lattice::Lattice;
use cosmic::policy::{Controller, Layer, Network, TEMPO, blocks_of, observation};
use cosmic::scene::{ControllerSettings, GoalKind, Scene};
use std::borrow::Cow;
use std::f64::consts::{FRAC_PI_2, PI};

const VERSION: u8 = 1;
/// A packed robot has this many clocks, at phases that are a quarter of a turn apart.
const CLOCKS: usize = 4;
/// The number of steps between a scale and twice that scale.
const STEPS: f64 = 8.0;
/// The code of the scale 1.
const ONE: f64 = 128.0;

fn refused<T>(says: impl Into<String>) -> Result<T> {
    Err(Error::Usage(says.into()))
}

/// Packs a robot of a scene.
///
/// # Errors
/// [`Error::Usage`] for a policy that is not a network with one hidden layer, and for a robot with given goals.
pub(crate) fn pack(
    settings: &ControllerSettings,
    lattice: &Lattice,
    ground: &Ground,
    materials: &[Material],
    controller: &Controller<f64>,
) -> Result<Vec<u8>> {
    if settings.goals == GoalKind::Given {
        return refused("a robot that can be told where to go does not fit into a link");
    }
    // Of a robot that sees only the time, a link holds the weights of one side: its scene adds the image again.
    let mut sides = Cow::Borrowed(lattice);
    if sees_only_time(settings) {
        sides.to_mut().mirror = None;
    }
    let network =
        Network::of(controller, settings, &sides).filter(|network| network.gates.is_empty());
    let Some(Network { first, second, .. }) = network else {
        return refused("the policy of this robot does not fit into a link");
    };
    let hidden = first.biases.len();
    let Ok(units) = u8::try_from(hidden) else {
        return refused("a robot with more than 255 hidden units does not fit into a link");
    };
    let mut bytes = vec![VERSION, units];
    bytes.extend((tempo(controller) as f32).to_le_bytes());
    for four in materials.chunks(4) {
        let code = |(k, &material): (usize, &Material)| (material as u8) << (2 * k);
        bytes.push(four.iter().enumerate().map(code).sum());
    }
    for row in open_loop(&first, settings, lattice, ground) {
        pack_row(&row, &mut bytes);
    }
    for edge in solid(materials) {
        let mut row = second.weights[edge * hidden..(edge + 1) * hidden].to_vec();
        row.push(second.biases[edge]);
        pack_row(&row, &mut bytes);
    }
    Ok(bytes)
}

/// Returns the scene of a packed robot, in which its policy is in open loop.
///
/// # Errors
/// [`Error::Usage`] for bytes of another version; the errors of [`Scene::set`].
pub(crate) fn scene_of(scene: Scene, bytes: &[u8]) -> Result<Scene> {
    let &[VERSION, hidden, ..] = bytes else {
        return refused("the robot in this link has an unknown format");
    };
    if scene.controller.goals == GoalKind::Given {
        return refused("a robot that can be told where to go does not fit into a link");
    }
    scene.set(&[
        "controller.policy=\"clock\"".to_owned(),
        format!("controller.clocks={CLOCKS}"),
        format!("controller.hidden={hidden}"),
    ])
}

/// Unpacks the materials and the controller of a robot. `settings` belong to the scene of [`scene_of`].
///
/// # Errors
/// [`Error::Usage`] if the bytes do not fit the lattice.
pub(crate) fn unpack(
    settings: &ControllerSettings,
    lattice: &Lattice,
    bytes: &[u8],
) -> Result<(Vec<Material>, Controller<f64>)> {
    let (edges, hidden) = (lattice.edges.len(), settings.hidden);
    let mut rest = bytes.get(2..).unwrap_or_default();
    let mut take = |count: usize| match rest.split_at_checked(count) {
        Some((taken, left)) => {
            rest = left;
            Ok(taken)
        }
        None => refused("the robot in this link is not complete; copy the whole link"),
    };
    let tempo = f32::from_le_bytes(take(4)?.try_into().expect("four bytes"));
    if tempo.is_nan() || tempo.abs() > 3.0 {
        return refused("the robot in this link has no valid tempo");
    }
    let packed = take(edges.div_ceil(4))?;
    let materials = (0..edges).map(|e| material(packed[e / 4] >> (2 * (e % 4)) & 3));
    let materials = materials.collect::<Result<Vec<_>>>()?;
    let mut row = |length: usize| -> Result<Vec<f64>> { Ok(unpack_row(take(length + 1)?)) };
    let columns = [row(hidden)?, row(hidden)?, row(hidden)?];
    let mut rows = Vec::new();
    for edge in solid(&materials) {
        rows.push((edge, row(hidden + 1)?));
    }
    if !rest.is_empty() {
        return refused("the robot in this link does not fit the lattice of its scene");
    }
    let blocks = blocks_of(settings, lattice);
    let zeros = vec![0.0; blocks.iter().map(|block| block.shape.len()).sum()];
    let mut controller = Controller::new(&blocks, zeros);
    let [sines, cosines, biases] = columns;
    let inputs = controller.block("w1").len() / hidden.max(1);
    for (unit, weights) in controller
        .block_mut("w1")
        .chunks_exact_mut(inputs)
        .enumerate()
    {
        // The clocks are sin, cos, -sin and -cos.
        let [sin, cos] = [sines[unit] / 2.0, cosines[unit] / 2.0];
        weights[..CLOCKS].copy_from_slice(&[sin, cos, -sin, -cos]);
    }
    controller.block_mut("b1").copy_from_slice(&biases);
    for (edge, row) in rows {
        controller.block_mut("w2")[edge * hidden..(edge + 1) * hidden]
            .copy_from_slice(&row[..hidden]);
        controller.block_mut("b2")[edge] = row[hidden];
    }
    if has_tempo(&controller) {
        controller.block_mut(TEMPO)[0] = tempo.into();
    }
    Ok((materials, controller))
}

fn solid(materials: &[Material]) -> impl Iterator<Item = usize> {
    let edges = materials.iter().enumerate();
    edges
        .filter(|(_, material)| material.is_solid())
        .map(|(edge, _)| edge)
}

fn material(code: u8) -> Result<Material> {
    match code {
        0 => Ok(Material::Void),
        1 => Ok(Material::Skeleton),
        2 => Ok(Material::Actuator),
        _ => refused("the robot in this link has a bar of an unknown material"),
    }
}

fn sees_only_time(settings: &ControllerSettings) -> bool {
    settings.policy.name() == "clock"
}

fn has_tempo(controller: &Controller<f64>) -> bool {
    controller.blocks().any(|(name, ..)| name == TEMPO)
}

fn tempo(controller: &Controller<f64>) -> f64 {
    if has_tempo(controller) {
        controller.block(TEMPO)[0]
    } else {
        0.0
    }
}

/// Returns the hidden units' weights of the clock's sine and cosine, and their biases, if the network always observes the
/// robot at the start. An observation is linear in the sine and the cosine, so three phases determine them.
fn open_loop(
    first: &Layer<f64>,
    settings: &ControllerSettings,
    lattice: &Lattice,
    ground: &Ground,
) -> [Vec<f64>; 3] {
    let inputs = first.weights.len() / first.biases.len().max(1);
    let rest = lattice.state_at_rest();
    let nodes = if sees_only_time(settings) {
        0
    } else {
        lattice.nodes()
    };
    let length = settings.observation_length(lattice.dimension, nodes);
    assert_eq!(inputs, length, "the network must fit the observation");
    let [ahead, right, behind] = [0.0, FRAC_PI_2, PI].map(|phase| {
        let seen = observation(settings, phase, &rest, &[], ground);
        let rows = first.weights.chunks_exact(inputs).zip(&first.biases);
        let sum = |(row, bias): (&[f64], &f64)| {
            bias + row.iter().zip(&seen).map(|(w, x)| w * x).sum::<f64>()
        };
        rows.map(sum).collect::<Vec<f64>>()
    });
    let biases: Vec<f64> = ahead
        .iter()
        .zip(&behind)
        .map(|(a, b)| (a + b) / 2.0)
        .collect();
    let minus = |of: &[f64]| of.iter().zip(&biases).map(|(x, bias)| x - bias).collect();
    [minus(&right), minus(&ahead), biases]
}

/// Appends a row: its scale, and its numbers as fractions of the scale.
fn pack_row(row: &[f64], bytes: &mut Vec<u8>) {
    let most = row.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    // Without the tolerance, rounding errors of a row that was packed before could give it the next larger scale, and
    // packing it again would change it.
    let code = (ONE + STEPS * most.log2() - 1e-9).ceil().clamp(0.0, 255.0) as u8;
    bytes.push(code);
    let byte = |x: &f64| (127.0 * x / scale(code)).round().clamp(-127.0, 127.0) as i8 as u8;
    bytes.extend(row.iter().map(byte));
}

fn unpack_row(bytes: &[u8]) -> Vec<f64> {
    let scale = scale(bytes[0]);
    bytes[1..]
        .iter()
        .map(|&byte| f64::from(byte as i8) / 127.0 * scale)
        .collect()
}

fn scale(code: u8) -> f64 {
    ((f64::from(code) - ONE) / STEPS).exp2()
}
