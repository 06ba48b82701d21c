//! The step and the run forward.

use autodiff::Real;
use autodiff::simd::Lane;

use super::buffer::{Buffer, prefetch};
use super::plan::{BAND, CLOCK, DIRECTIONS, H, JX, JY, ORIGIN, ROW, Register, RobotPlan, U};
use super::product::product;
use super::sizes::{FEW, HIDDEN, NODES, SENSED, STATE};

/// Added to the square of a length, m^2 (D4).
const SOFTENING: f64 = 1e-12;

/// Numbers of all edges by their tails, direction by direction, for two coordinates; zero where
/// there is no edge.
pub(super) struct Bands<R>(pub(super) [Buffer<R>; 2]);

impl<R: Real> Bands<R> {
    pub(super) fn new() -> Self {
        Self([(); 2].map(|()| Buffer::zeros(DIRECTIONS.len() * BAND)))
    }
}

/// Sums over the edges whose tails these nodes are, less those over the edges whose heads they are.
#[inline(always)]
pub(super) fn net<R: Real, L: Lane<R>>(band: &[R], node: usize) -> L {
    let mut parts = [L::zero(); DIRECTIONS.len()];
    for k in 0..parts.len() {
        let from = k * BAND + ORIGIN + node;
        parts[k] = L::load(&band[from..]) - L::load(&band[from - DIRECTIONS[k]..]);
    }
    (parts[0] + parts[1]) + (parts[2] + parts[3])
}

/// Runs all steps, and adds up where the payload is along the ground after those observed. Keeps
/// the rows of all if they are wanted.
#[inline(always)]
pub(super) fn run<R: Real, L: Lane<R>, const OUTPUTS: usize>(
    plan: &RobotPlan<R, L, OUTPUTS>,
    start: &[R],
    (observed, keep): (&[usize], bool),
    rows: &mut Buffer<R>,
) -> R {
    let stride = if keep { ROW } else { 0 };
    rows.reserve(ROW + plan.steps * stride);
    rows[..STATE].copy_from_slice(start);
    let mut bands = Bands::new();
    let mut next = [R::zero(); STATE + 16];
    let mut sum = R::zero();
    let mut wanted = observed.iter().peekable();
    for step in 0..plan.steps {
        let row = &mut rows[step * stride..][..ROW];
        row[CLOCK..SENSED].copy_from_slice(&plan.clock[step]);
        plan.control(row);
        plan.pull(row, &mut bands);
        plan.fly(row, &mut next);
        rows[(step + 1) * stride..][..STATE].copy_from_slice(&next[..STATE]);
        if keep {
            prefetch(&rows[(step + 2).min(plan.steps) * ROW..][..ROW]);
        }
        if wanted.next_if_eq(&&(step + 1)).is_some() {
            sum += next[0];
        }
    }
    sum
}

/// A register of edges in a step.
pub(super) struct Edges<L> {
    /// Their vectors from tail to head, m, their inverse lengths and activations.
    pub(super) d: [L; 2],
    pub(super) inverse: L,
    pub(super) u: L,
    /// Target length over length, and one less that.
    pub(super) relative: L,
    pub(super) change: L,
}

impl<R: Real, L: Lane<R>, const OUTPUTS: usize> RobotPlan<R, L, OUTPUTS> {
    /// Hidden units and activations of a row's state.
    #[inline(always)]
    fn control(&self, row: &mut [R]) {
        let (sensed, row) = row.split_at_mut(H);
        let (hidden, row) = row.split_at_mut(HIDDEN);
        let ([w1, w2], sensed) = (&self.weights, &sensed[..SENSED]);
        let first = (&self.b1[..], &mut *hidden);
        match L::N {
            16 => product::<R, L, 2, 8, true>(w1, sensed, first),
            8 => product::<R, L, 4, 4, true>(w1, sensed, first),
            4 => product::<R, L, 4, 2, true>(w1, sensed, first),
            _ => product::<R, L, 8, 1, true>(w1, sensed, first),
        }
        let second = (&self.b2[..], &mut row[..OUTPUTS]);
        match (L::N, OUTPUTS) {
            (16, FEW) => product::<R, L, 2, 8, true>(w2, hidden, second),
            (16, _) => product::<R, L, 7, 2, true>(w2, hidden, second),
            (8, FEW) => product::<R, L, 4, 4, true>(w2, hidden, second),
            (8, _) => product::<R, L, 14, 1, true>(w2, hidden, second),
            (4, FEW) => product::<R, L, 4, 2, true>(w2, hidden, second),
            (4, _) => product::<R, L, 7, 1, true>(w2, hidden, second),
            _ => product::<R, L, 8, 1, true>(w2, hidden, second),
        }
    }

    /// A register of edges, of that number.
    #[inline(always)]
    pub(super) fn edges(&self, row: &[R], (k, at): (usize, &Register)) -> Edges<L> {
        let mut d = [L::zero(); 2];
        for axis in 0..2 {
            let of = &row[axis * NODES..];
            d[axis] = L::load(&of[at.head..]) - L::load(&of[at.tail..]);
        }
        let squared = d[0].fma(d[0], d[1].fma(d[1], L::lit(SOFTENING)));
        let inverse = squared.sqrt().recip();
        let u = L::load(&row[U + at.first..]).expand(at.outputs);
        let strained = L::load(&self.strain[k * L::N..]).fma(u, L::one());
        let relative = L::load(&self.rest[k * L::N..]) * strained * inverse;
        Edges {
            d,
            inverse,
            u,
            relative,
            change: L::one() - relative,
        }
    }

    /// The impulses on all nodes.
    #[inline(always)]
    fn pull(&self, row: &mut [R], bands: &mut Bands<R>) {
        for (k, at) in self.registers.iter().enumerate() {
            let edges = self.edges(row, (k, at));
            let pull = L::load(&self.stiffness[k * L::N..]) * edges.change;
            for axis in 0..2 {
                (pull * edges.d[axis]).store(&mut bands.0[axis][at.band..]);
            }
        }
        for node in (0..NODES).step_by(L::N) {
            for axis in 0..2 {
                net::<R, L>(&bands.0[axis], node).store(&mut row[[JX, JY][axis] + node..]);
            }
        }
    }

    /// Some nodes' velocities before contact.
    #[inline(always)]
    pub(super) fn velocity(&self, row: &[R], node: usize) -> [L; 2] {
        let (inverse_mass, decay) = (L::load(&self.inverse_mass[node..]), L::splat(self.decay));
        let mut velocity = [L::zero(), L::splat(self.gravity)];
        for k in 0..2 {
            let pushed = L::load(&row[[JX, JY][k] + node..]).fma(inverse_mass, velocity[k]);
            velocity[k] = decay.fma(L::load(&row[(2 + k) * NODES + node..]), pushed);
        }
        velocity
    }

    /// A mask of the nodes that touch the ground, how long they move, and a mask of the times of impact
    /// between their bounds (D9).
    #[inline(always)]
    pub(super) fn touch(&self, height: L, velocity: L) -> (L::Mask, L, L::Mask) {
        let (zero, dt) = (L::zero(), L::splat(self.dt));
        let touches = dt.fma(velocity, height).less(zero) & velocity.less(zero);
        let impact = -height / L::select(touches, velocity, -L::one());
        let inside = touches & zero.less(impact) & impact.less(dt);
        let bounded = impact.clamp(zero, dt);
        (touches, L::select(touches, bounded, dt), inside)
    }

    /// The next state of a row.
    #[inline(always)]
    fn fly(&self, row: &[R], next: &mut [R; STATE + 16]) {
        // From the last nodes to the first: lanes behind an array's last node lie in the next one.
        for node in (0..NODES).step_by(L::N).rev() {
            let velocity = self.velocity(row, node);
            let (x, y) = (L::load(&row[node..]), L::load(&row[NODES + node..]));
            let (touches, moving, _) = self.touch(y, velocity[1]);
            moving.fma(velocity[0], x).store(&mut next[node..]);
            moving.fma(velocity[1], y).store(&mut next[NODES + node..]);
            for k in 0..2 {
                let after = L::select(touches, L::zero(), velocity[k]);
                after.store(&mut next[(2 + k) * NODES + node..]);
            }
        }
    }
}
