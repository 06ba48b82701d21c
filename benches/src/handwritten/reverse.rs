//! The reverse sweep, worked out by hand.

use autodiff::Real;
use autodiff::simd::Lane;

use super::buffer::{Buffer, prefetch};
use super::forward::{Bands, Edges, net};
use super::plan::{CLOCK, H, JX, JY, ROW, RobotPlan, U};
use super::product::{BATCH, Pairs, outer, product};
use super::sizes::{EDGE_PLACES, EDGES, HIDDEN, NODE_PLACES, NODES, SENSED, STATE};

/// Cotangents and where they are gathered.
struct Cotangents<R, const OUTPUTS: usize> {
    /// By the state after a step, and of that before it what does not pass through the controller.
    state: [R; STATE + 16],
    before: [R; STATE + 16],
    /// By the impulses on nodes.
    impulses: [[R; NODE_PLACES + 16]; 2],
    bands: Bands<R>,
    /// By activations.
    outputs: [R; EDGE_PLACES + 16],
    /// By what the tanh of activations and of hidden units takes, for the steps of a batch.
    activations: Buffer<R>,
    hidden: Buffer<R>,
    /// Over all steps, by what edges and nodes are made of.
    stiffness: Buffer<R>,
    strain: Buffer<R>,
    inverse_mass: Buffer<R>,
    /// And by the network, column by column.
    w1: Buffer<R>,
    b1: Buffer<R>,
    w2: Buffer<R>,
    b2: Buffer<R>,
}

/// Cotangents of stiffness, strain and inverse masses, or of the folded controller's matrices and
/// biases, from that of every position of the payload along the ground that was observed.
#[inline(always)]
pub(super) fn run<R: Real, L: Lane<R>, const OUTPUTS: usize, const DESIGN: bool>(
    plan: &RobotPlan<R, L, OUTPUTS>,
    (observed, bar): (&[usize], R),
    rows: &[R],
) -> Vec<Vec<R>> {
    let mut bars = Cotangents::new(plan);
    let mut wanted = observed.iter().rev().peekable();
    for step in (0..plan.steps).rev() {
        if wanted.next_if_eq(&&(step + 1)).is_some() {
            bars.state[0] += bar;
        }
        let row = &rows[step * ROW..][..ROW];
        // Bit by bit: the loads of this step would wait behind all of them.
        let (first, rest) = rows[step.saturating_sub(2) * ROW..][..ROW].split_at(ROW / 4);
        let (second, rest) = rest.split_at(ROW / 4);
        prefetch(first);
        bars.nodes::<L, DESIGN>(plan, row);
        prefetch(second);
        bars.edges::<L, DESIGN>(plan, row);
        prefetch(rest);
        bars.network::<L, DESIGN>(plan, row, step % BATCH);
        if !DESIGN && step.is_multiple_of(BATCH) {
            let steps = (plan.steps - step).min(BATCH);
            bars.weights::<L>(&rows[step * ROW..], steps);
        }
    }
    match DESIGN {
        true => bars.by_body(plan),
        false => bars.by_network(plan),
    }
}

impl<R: Real, const OUTPUTS: usize> Cotangents<R, OUTPUTS> {
    fn new<L>(plan: &RobotPlan<R, L, OUTPUTS>) -> Self {
        Self {
            state: [R::zero(); STATE + 16],
            before: [R::zero(); STATE + 16],
            impulses: [[R::zero(); NODE_PLACES + 16]; 2],
            bands: Bands::new(),
            outputs: [R::zero(); EDGE_PLACES + 16],
            activations: Buffer::zeros(BATCH * OUTPUTS),
            hidden: Buffer::zeros(BATCH * HIDDEN),
            stiffness: Buffer::zeros(plan.stiffness.len()),
            strain: Buffer::zeros(plan.stiffness.len()),
            inverse_mass: Buffer::zeros(NODE_PLACES),
            w1: Buffer::zeros(SENSED * HIDDEN),
            b1: Buffer::zeros(HIDDEN),
            w2: Buffer::zeros(HIDDEN * OUTPUTS),
            b2: Buffer::zeros(OUTPUTS),
        }
    }

    /// Back through contact and flight.
    #[inline(always)]
    fn nodes<L: Lane<R>, const DESIGN: bool>(
        &mut self,
        plan: &RobotPlan<R, L, OUTPUTS>,
        row: &[R],
    ) {
        let (zero, decay) = (L::zero(), L::splat(plan.decay));
        // From the last nodes to the first: lanes behind an array's last node lie in the next one.
        for node in (0..NODES).step_by(L::N).rev() {
            let mut bar = [L::zero(); 4];
            for array in 0..4 {
                bar[array] = L::load(&self.state[array * NODES + node..]);
            }
            let velocity = plan.velocity(row, node);
            let (touches, moving, inside) = plan.touch(L::load(&row[NODES + node..]), velocity[1]);
            // The time of impact is minus height over velocity.
            let by_impact = bar[0].fma(velocity[0], bar[1] * velocity[1]);
            let by_height = -by_impact / L::select(inside, velocity[1], L::one());
            let by_height = L::select(inside, by_height, zero);
            let vx = moving.fma(bar[0], L::select(touches, zero, bar[2]));
            let vy = moving.fma(bar[1] + by_height, L::select(touches, zero, bar[3]));
            let before = [bar[0], bar[1] + by_height, decay * vx, decay * vy];
            for array in 0..4 {
                before[array].store(&mut self.before[array * NODES + node..]);
            }
            let inverse_mass = L::load(&plan.inverse_mass[node..]);
            (vx * inverse_mass).store(&mut self.impulses[0][node..]);
            (vy * inverse_mass).store(&mut self.impulses[1][node..]);
            if DESIGN {
                let sum = L::load(&row[JX + node..]).fma(vx, L::load(&self.inverse_mass[node..]));
                let sum = L::load(&row[JY + node..]).fma(vy, sum);
                sum.store(&mut self.inverse_mass[node..]);
            }
        }
        self.before[STATE..].fill(R::zero());
    }

    /// Back through the springs.
    #[inline(always)]
    fn edges<L: Lane<R>, const DESIGN: bool>(
        &mut self,
        plan: &RobotPlan<R, L, OUTPUTS>,
        row: &[R],
    ) {
        for (k, at) in plan.registers.iter().enumerate() {
            let Edges {
                d,
                inverse,
                u,
                relative,
                change,
            } = plan.edges(row, (k, at));
            let mut bar = [L::zero(); 2];
            for axis in 0..2 {
                let impulses = &self.impulses[axis];
                bar[axis] = L::load(&impulses[at.tail..]) - L::load(&impulses[at.head..]);
            }
            let lane = k * L::N;
            let stiffness = L::load(&plan.stiffness[lane..]);
            let by_pull = bar[0].fma(d[0], bar[1] * d[1]);
            let by_target = by_pull * stiffness * inverse;
            let (pull, turn) = (stiffness * change, by_target * relative * inverse);
            for axis in 0..2 {
                let by_vector = pull.fma(bar[axis], turn * d[axis]);
                (-by_vector).store(&mut self.bands.0[axis][at.band..]);
            }
            let by_strained = -by_target * L::load(&plan.rest[lane..]);
            let by_output = by_strained * L::load(&plan.strain[lane..]);
            let by_output = by_output.compress(at.outputs);
            by_output.store(&mut self.outputs[at.first..]);
            if DESIGN {
                let sum = by_pull.fma(change, L::load(&self.stiffness[lane..]));
                sum.store(&mut self.stiffness[lane..]);
                let sum = by_strained.fma(u, L::load(&self.strain[lane..]));
                sum.store(&mut self.strain[lane..]);
            }
        }
        for node in (0..NODES).step_by(L::N) {
            for axis in 0..2 {
                let place = &mut self.before[axis * NODES + node..];
                let by_net: L = net(&self.bands.0[axis], node);
                (L::load(place) + by_net).store(place);
            }
        }
    }

    /// Back through the network, of a step of a batch.
    #[inline(always)]
    fn network<L: Lane<R>, const DESIGN: bool>(
        &mut self,
        plan: &RobotPlan<R, L, OUTPUTS>,
        row: &[R],
        of_batch: usize,
    ) {
        let outputs = &mut self.activations[of_batch * OUTPUTS..][..OUTPUTS];
        for at in (0..OUTPUTS).step_by(L::N) {
            let bar = before_tanh::<R, L>(L::load(&self.outputs[at..]), L::load(&row[U + at..]));
            bar.store(&mut outputs[at..]);
            if !DESIGN {
                (L::load(&self.b2[at..]) + bar).store(&mut self.b2[at..]);
            }
        }
        let hidden = &mut self.hidden[of_batch * HIDDEN..][..HIDDEN];
        let zeros = [R::zero(); HIDDEN];
        let [w1, w2] = &plan.transposed;
        let outputs = &outputs[..plan.outputs.len()];
        let to = (&zeros[..], &mut *hidden);
        match L::N {
            16 => product::<R, L, 2, 8, false>(w2, outputs, to),
            8 | 4 => product::<R, L, 4, 4, false>(w2, outputs, to),
            _ => product::<R, L, 8, 1, false>(w2, outputs, to),
        }
        for at in (0..HIDDEN).step_by(L::N) {
            let bar = before_tanh::<R, L>(L::load(&hidden[at..]), L::load(&row[H + at..]));
            bar.store(&mut hidden[at..]);
            if !DESIGN {
                (L::load(&self.b1[at..]) + bar).store(&mut self.b1[at..]);
            }
        }
        let to = (&self.before[..STATE], &mut self.state[..STATE]);
        match L::N {
            16 => product::<R, L, 9, 2, false>(w1, hidden, to),
            8 => product::<R, L, 18, 1, false>(w1, hidden, to),
            4 => product::<R, L, 12, 1, false>(w1, hidden, to),
            _ => product::<R, L, 8, 1, false>(w1, hidden, to),
        }
    }

    /// The matrices' share of a batch, whose rows these are.
    #[inline(always)]
    fn weights<L: Lane<R>>(&mut self, rows: &[R], steps: usize) {
        let (by_state, by_clock) = self.w1.split_at_mut(STATE * HIDDEN);
        let (by_state, by_clock) = ((by_state, HIDDEN), (by_clock, HIDDEN));
        let state = Pairs {
            rows: (&self.hidden, HIDDEN),
            columns: (rows, ROW),
            steps,
        };
        let clock = Pairs {
            columns: (&rows[CLOCK..], ROW),
            ..state
        };
        let by_hidden = (&mut self.w2[..], OUTPUTS);
        let hidden = Pairs {
            rows: (&self.activations, OUTPUTS),
            columns: (&rows[H..], ROW),
            steps,
        };
        match L::N {
            16 => outer::<R, L, 2, 12>(by_state, state),
            8 => outer::<R, L, 4, 6>(by_state, state),
            _ => outer::<R, L, 4, 3>(by_state, state),
        }
        match L::N {
            16 => outer::<R, L, 2, 2>(by_clock, clock),
            _ => outer::<R, L, 4, 2>(by_clock, clock),
        }
        match (L::N, OUTPUTS) {
            (8 | 16, EDGE_PLACES) => outer::<R, L, 7, 4>(by_hidden, hidden),
            (16, _) => outer::<R, L, 2, 8>(by_hidden, hidden),
            (8, _) => outer::<R, L, 4, 4>(by_hidden, hidden),
            _ => outer::<R, L, 4, 2>(by_hidden, hidden),
        }
    }

    fn by_body<L>(&self, plan: &RobotPlan<R, L, OUTPUTS>) -> Vec<Vec<R>> {
        let by_edge = |of: &[R], factor: R| plan.places.iter().map(|&k| of[k] * factor).collect();
        vec![
            by_edge(&self.stiffness, plan.dt),
            by_edge(&self.strain, R::one()),
            self.inverse_mass[..NODES].to_vec(),
        ]
    }

    fn by_network<L>(&self, plan: &RobotPlan<R, L, OUTPUTS>) -> Vec<Vec<R>> {
        let entries = (0..HIDDEN).flat_map(|unit| (0..SENSED).map(move |s| s * HIDDEN + unit));
        let mut w2 = vec![R::zero(); EDGES * HIDDEN];
        let mut b2 = vec![R::zero(); EDGES];
        for (output, &edge) in plan.outputs.iter().enumerate() {
            let column = self.w2[output..].iter().step_by(OUTPUTS);
            for (to, &bar) in w2[edge * HIDDEN..].iter_mut().zip(column) {
                *to = bar;
            }
            b2[edge] = self.b2[output];
        }
        let w1 = entries.map(|at| self.w1[at]).collect();
        vec![w1, self.b1.to_vec(), w2, b2]
    }
}

/// The cotangent of what a hyperbolic tangent takes, from its own.
#[inline(always)]
fn before_tanh<R: Real, L: Lane<R>>(bar: L, tanh: L) -> L {
    (-tanh).fma(tanh, L::one()) * bar
}
