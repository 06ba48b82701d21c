//! The plan of a rollout: where everything lies, and the numbers that steps do not change.

use std::marker::PhantomData;

use autodiff::Real;
use autodiff::simd::Lane;
use cosmic::case::Case;
use cosmic::controller::{Controller, clock};
use cosmic::geometry::Ground;
use cosmic::lattice::Body;

use super::buffer::Buffer;
use super::sizes::{COLUMNS, EDGE_PLACES, EDGES, FEW, HIDDEN, NODE_PLACES, NODES, SENSED, STATE};

/// Places in the row of a step: state, clock, hidden units, activations, impulses on nodes.
pub(super) const CLOCK: usize = STATE;
pub(super) const H: usize = 160;
pub(super) const U: usize = H + HIDDEN;
pub(super) const JX: usize = U + EDGE_PLACES;
pub(super) const JY: usize = JX + NODE_PLACES;
pub(super) const ROW: usize = JY + NODE_PLACES;

/// From an edge's tail to its head, for edges to the right, up, up right and up left.
pub(super) const DIRECTIONS: [usize; 4] = [1, COLUMNS, COLUMNS + 1, COLUMNS - 1];
/// Numbers of one direction's edges by their tails, with room for a shift on both sides.
pub(super) const BAND: usize = 80;
/// Where node 0 lies in a band.
pub(super) const ORIGIN: usize = 16;

/// A register of edges with tails in a row.
pub(super) struct Register {
    /// The first tail and head.
    pub(super) tail: usize,
    pub(super) head: usize,
    /// Where its numbers lie in bands.
    pub(super) band: usize,
    /// Its lanes whose edges have an output of the controller.
    pub(super) outputs: u16,
    /// Which output the first of them has.
    pub(super) first: usize,
}

/// All that a rollout needs, with so many places for outputs of the controller.
pub(super) struct RobotPlan<R, L, const OUTPUTS: usize> {
    pub(super) steps: usize,
    pub(super) registers: Vec<Register>,
    /// Every edge's place in registers, and the edges of the outputs.
    pub(super) places: Vec<usize>,
    pub(super) outputs: Vec<usize>,
    /// Per edge, in registers: stiffness times the length of a step, rest length, strain.
    pub(super) stiffness: Buffer<R>,
    pub(super) rest: Buffer<R>,
    pub(super) strain: Buffer<R>,
    pub(super) inverse_mass: Buffer<R>,
    /// Weights of both layers by columns, and by rows for the reverse sweep.
    pub(super) weights: [Buffer<R>; 2],
    pub(super) transposed: [Buffer<R>; 2],
    pub(super) b1: Buffer<R>,
    pub(super) b2: Buffer<R>,
    pub(super) clock: Vec<[R; 2]>,
    pub(super) dt: R,
    pub(super) decay: R,
    pub(super) gravity: R,
    lanes: PhantomData<L>,
}

impl<R: Real, L: Lane<R>, const OUTPUTS: usize> RobotPlan<R, L, OUTPUTS> {
    /// Plans a rollout of a body and a network, with outputs of the controller for the edges that
    /// want one.
    pub(super) fn new(
        case: &Case,
        (body, network, wanted): (&Body<R>, &Controller<R>, &[usize]),
        steps: usize,
    ) -> Self {
        let (physics, width) = (&case.physics, blocks(L::N));
        let time = |step: usize| clock(&case.observation, step as f64 * physics.dt).map(R::lit);
        let (registers, places, outputs) = registers(case, L::N, wanted);
        let in_registers = |of: &dyn Fn(usize) -> R| {
            let mut all = Buffer::zeros(registers.len() * L::N);
            for (edge, &place) in places.iter().enumerate() {
                all[place] = of(edge);
            }
            all
        };
        let w1 = |unit: usize, column: usize| network.w1[unit * SENSED + column];
        let w2 = |output: usize, unit: usize| match outputs.get(output) {
            Some(edge) => network.w2[edge * HIDDEN + unit],
            None => R::zero(),
        };
        let block = match OUTPUTS {
            FEW => width.hidden,
            _ => width.outputs,
        };
        let numbers = |len: usize, of: &dyn Fn(usize) -> R| {
            let mut all = Buffer::zeros(len.next_multiple_of(16));
            (0..len).for_each(|k| all[k] = of(k));
            all
        };
        Self {
            stiffness: in_registers(&|edge| body.stiffness[edge] * R::lit(physics.dt)),
            rest: in_registers(&|edge| R::lit(case.lattice.rest_length[edge])),
            strain: in_registers(&|edge| body.strain[edge]),
            inverse_mass: numbers(NODES, &|node| body.mass[node].recip()),
            weights: [
                packed(width.hidden, (HIDDEN, SENSED), &w1),
                packed(block, (OUTPUTS, HIDDEN), &w2),
            ],
            transposed: [
                packed(width.states, (STATE, HIDDEN), &|s, unit| w1(unit, s)),
                packed(width.hidden, (HIDDEN, outputs.len()), &|unit, o| {
                    w2(o, unit)
                }),
            ],
            b1: numbers(HIDDEN, &|unit| network.b1[unit]),
            b2: numbers(OUTPUTS, &|o| {
                outputs.get(o).map_or(R::zero(), |&e| network.b2[e])
            }),
            clock: (0..steps).map(time).collect(),
            dt: R::lit(physics.dt),
            decay: R::lit((-physics.damping * physics.dt).exp()),
            gravity: R::lit(-physics.gravity * physics.dt),
            steps,
            registers,
            places,
            outputs,
            lanes: PhantomData,
        }
    }
}

/// The state that a case starts from, in the ground's frame.
pub(super) fn start<R: Real>(case: &Case) -> Vec<R> {
    let state = case.start.to_ground(&Ground::from(&case.physics));
    state.map(R::lit).to_columns()
}

/// Rows of matrices that are multiplied at once.
struct Width {
    hidden: usize,
    outputs: usize,
    states: usize,
}

fn blocks(lanes: usize) -> Width {
    let [hidden, outputs, states] = match lanes {
        8 | 16 => [HIDDEN, EDGE_PLACES, STATE],
        4 => [16, 28, 48],
        _ => [8; 3],
    };
    Width {
        hidden,
        outputs,
        states,
    }
}

/// A matrix by blocks of so many rows, which are multiplied at once, and each block by columns.
fn packed<R: Real>(
    block: usize,
    (rows, columns): (usize, usize),
    entry: &dyn Fn(usize, usize) -> R,
) -> Buffer<R> {
    let mut all = Buffer::zeros(rows * columns);
    let mut places = all.iter_mut();
    for first in (0..rows).step_by(block) {
        for column in 0..columns {
            for (row, place) in (first..first + block).zip(&mut places) {
                *place = entry(row, column);
            }
        }
    }
    all
}

/// The edges in registers of so many lanes, every edge's place, and the edges of the outputs.
fn registers(
    case: &Case,
    lanes: usize,
    wanted: &[usize],
) -> (Vec<Register>, Vec<usize>, Vec<usize>) {
    let (mut registers, mut outputs) = (Vec::new(), Vec::new());
    let mut places = vec![0; EDGES];
    for (k, offset) in DIRECTIONS.into_iter().enumerate() {
        for tail in (0..NODES - offset).step_by(lanes) {
            let mut register = Register {
                tail,
                head: tail + offset,
                band: k * BAND + ORIGIN + tail,
                outputs: 0,
                first: outputs.len(),
            };
            for lane in 0..lanes {
                let ends = [tail + lane, tail + lane + offset];
                let Some(edge) = case.lattice.edges.iter().position(|edge| *edge == ends) else {
                    continue;
                };
                places[edge] = registers.len() * lanes + lane;
                if wanted.contains(&edge) {
                    register.outputs |= 1 << lane;
                    outputs.push(edge);
                }
            }
            registers.push(register);
        }
    }
    (registers, places, outputs)
}
