//! One step of a 6x6 lattice of springs, in scalar code.

use std::ops::{Add, Div, Mul, Neg, Sub};

use autodiff::{Real, Var};

/// The operations that the step needs; plain numbers multiply and add in two operations, for without FMA one
/// would be a call.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A constant.
    fn lit(value: f64) -> Self;
    /// The plain number, for comparisons.
    fn primal(self) -> f64;
    /// The square root.
    fn sqrt(self) -> Self;
    /// `self * factor + term`.
    fn fma(self, factor: Self, term: Self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn lit(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn primal(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn fma(self, factor: Self, term: Self) -> Self {
        self * factor + term
    }
}

impl Number for Var<f64> {
    #[inline(always)]
    fn lit(value: f64) -> Self {
        Real::lit(value)
    }
    #[inline(always)]
    fn primal(self) -> f64 {
        self.value()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Real::sqrt(self)
    }
    #[inline(always)]
    fn fma(self, factor: Self, term: Self) -> Self {
        Real::fma(self, factor, term)
    }
}

/// Both operands are computed, as in code that lanes could run.
fn select<T>(mask: bool, if_true: T, if_false: T) -> T {
    if mask { if_true } else { if_false }
}

/// Nodes in a row, and rows.
const SIDE: usize = 6;
/// Nodes of the lattice.
pub const NODES: usize = SIDE * SIDE;
/// Springs of the lattice.
pub const EDGES: usize = 110;

/// Length of a step, s.
pub const DT: f64 = 0.002;
/// The share of a velocity that damping leaves after a step.
pub const DECAY: f64 = 0.960_789_439_152_323_2;
/// Velocity that gravity adds in a step, m/s.
pub const GRAVITY: f64 = -0.0096;
/// Softens the length of an edge, m^2.
pub const SOFTENING: f64 = 1e-12;

/// The constants of a step, by which it is not differentiated.
pub struct SpringLattice {
    /// The nodes that each edge joins.
    pub edges: Vec<[usize; 2]>,
    /// By edge, m.
    pub rest_length: Vec<f64>,
    /// By node, 1/kg.
    pub inverse_mass: Vec<f64>,
}

impl Default for SpringLattice {
    /// Edges 0.1 m long, and their diagonals.
    fn default() -> Self {
        let edges = cosmic::generator::edges(SIDE, SIDE);
        let length = |&[i, j]: &[usize; 2]| {
            if j - i == 1 || j - i == SIDE {
                0.1
            } else {
                0.02f64.sqrt()
            }
        };
        Self {
            rest_length: edges.iter().map(length).collect(),
            inverse_mass: (0..NODES).map(|i| 60.0 + 0.5 * i as f64).collect(),
            edges,
        }
    }
}

impl SpringLattice {
    /// The sum of all positions and velocities after a step from `[x, y, vx, vy]`, node by node,
    /// and then the stiffness of every edge. The ground is at height 0 and holds what touches it.
    pub fn step<T: Number>(&self, inputs: &[T]) -> T {
        let (state, stiffness) = inputs.split_at(4 * NODES);
        let (state, _) = state.as_chunks::<4>();
        let zero = T::lit(0.0);
        let mut impulse = [[zero; 2]; NODES];
        for (e, &[i, j]) in self.edges.iter().enumerate() {
            let ([xi, yi, ..], [xj, yj, ..]) = (state[i], state[j]);
            let (dx, dy) = (xj - xi, yj - yi);
            let length = dx.fma(dx, dy.fma(dy, T::lit(SOFTENING))).sqrt();
            let stretch = length + T::lit(-self.rest_length[e]);
            let per_length = stiffness[e] * stretch * T::lit(DT) / length;
            let [jx, jy] = [per_length * dx, per_length * dy];
            impulse[i] = [impulse[i][0] + jx, impulse[i][1] + jy];
            impulse[j] = [impulse[j][0] - jx, impulse[j][1] - jy];
        }
        let mut sums = [zero; 4];
        for i in 0..NODES {
            let next = fly(state[i], impulse[i], self.inverse_mass[i]);
            for (sum, next) in sums.iter_mut().zip(next) {
                *sum = *sum + next;
            }
        }
        (sums[0] + sums[1]) + (sums[2] + sums[3])
    }
}

/// A node moves until it meets the ground, and stops there.
fn fly<T: Number>([x, y, vx, vy]: [T; 4], [jx, jy]: [T; 2], inverse_mass: f64) -> [T; 4] {
    let decay = T::lit(DECAY);
    let decayed = [vx * decay, vy * decay + T::lit(GRAVITY)];
    let inverse_mass = T::lit(inverse_mass);
    let [vx, vy] = [
        jx.fma(inverse_mass, decayed[0]),
        jy.fma(inverse_mass, decayed[1]),
    ];
    let (height, falling) = (y.primal(), vy.primal());
    let touches = DT * falling + height < 0.0 && falling < 0.0;
    let (zero, dt) = (T::lit(0.0), T::lit(DT));
    let time = -y / select(touches, vy, T::lit(-1.0));
    let time = select(time.primal() <= 0.0, zero, time);
    let time = select(time.primal() >= DT, dt, time);
    let moving = select(touches, time, dt);
    [
        moving.fma(vx, x),
        moving.fma(vy, y),
        select(touches, zero, vx),
        select(touches, zero, vy),
    ]
}
