//! The same step as kernels mapped over arrays: what `autodiff` offers beside its tape.

use autodiff::{Graph, Kernel, Model, Program, Pullback, Real, Rollout, Tape, Var};

use super::Gradient;
use super::step::{DECAY, DT, EDGES, GRAVITY, NODES, SOFTENING, SpringLattice};

/// The impulse of an edge on its tail, from `[dx, dy, stiffness, rest length]`.
pub struct Spring;

impl Kernel<4, 2> for Spring {
    #[inline(always)]
    fn eval<R: Real>(&self, [dx, dy, stiffness, rest_length]: [R; 4]) -> [R; 2] {
        let length = dx.fma(dx, dy.fma(dy, R::lit(SOFTENING))).sqrt();
        let per_length = stiffness * (length - rest_length) * R::lit(DT) / length;
        [per_length * dx, per_length * dy]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 4, 2, M>) -> [[R; 4]; M] {
        self.emitted_vjp(at)
    }
}

/// A node's next `[x, y, vx, vy]`, from these, its impulse and its inverse mass.
pub struct Flight;

impl Kernel<7, 4> for Flight {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let (zero, dt, decay) = (R::zero(), R::lit(DT), R::lit(DECAY));
        let vx = jx.fma(inverse_mass, decay * vx);
        let vy = jy.fma(inverse_mass, decay * vy + R::lit(GRAVITY));
        let touches = dt.fma(vy, y).less(zero) & vy.less(zero);
        let time = -y / R::select(touches, vy, -R::one());
        let moving = R::select(touches, time.clamp(zero, dt), dt);
        let after = |v: R| R::select(touches, zero, v);
        [moving.fma(vx, x), moving.fma(vy, y), after(vx), after(vy)]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 7, 4, M>) -> [[R; 7]; M] {
        self.emitted_vjp(at)
    }
}

#[derive(Clone)]
struct Step(Graph);

impl Model for Step {
    fn record<R: Real>(&self, p: &mut Program<R>) {
        let [stiffness, rest_length] = [(); 2].map(|()| p.parameter(self.0.slots()));
        let inverse_mass = p.parameter(NODES);
        let [x, y, vx, vy] = [(); 4].map(|()| p.state(NODES));
        let [jx, jy] = p.map_edges(&self.0, Spring, [x, y], &[stiffness, rest_length]);
        let next = p.map(Flight, [x, y, vx, vy, jx, jy, inverse_mass]);
        for (state, next) in [x, y, vx, vy].into_iter().zip(next) {
            p.advance(state, next);
        }
    }
}

/// A rollout of so many steps: the sum of its last state.
struct Steps {
    rollout: Rollout<Step>,
    rest_length: Vec<f64>,
    inverse_mass: Vec<f64>,
}

impl Steps {
    fn new(lattice: &SpringLattice, steps: usize) -> Self {
        let graph = Graph::new(NODES, &lattice.edges);
        Self {
            rest_length: graph.to_slots(&lattice.rest_length),
            inverse_mass: lattice.inverse_mass.clone(),
            rollout: Rollout::new(Step(graph), steps),
        }
    }

    /// Inputs as for [`SpringLattice::step`].
    fn sum<R: Real>(&self, inputs: &[R]) -> R {
        let (state, stiffness) = inputs.split_at(4 * NODES);
        let part = |k: usize| (0..NODES).map(move |i| state[4 * i + k]);
        let start: Vec<R> = (0..4).flat_map(part).collect();
        let lift = |numbers: &[f64]| numbers.iter().map(|&x| R::lit(x)).collect::<Vec<R>>();
        let stiffness = self.rollout.model.0.to_slots(&stiffness[..EDGES]);
        let (rest_length, inverse_mass) = (lift(&self.rest_length), lift(&self.inverse_mass));
        let parameters: [&[R]; 3] = [&stiffness, &rest_length, &inverse_mass];
        R::sum_of(&self.rollout.run(&start, &parameters))
    }
}

/// Value alone: a plain rollout.
pub fn value(lattice: &SpringLattice, steps: usize) -> Gradient {
    let rollout = Steps::new(lattice, steps);
    Box::new(move |_, inputs| (rollout.sum(inputs), Vec::new()))
}

/// Value and gradient of the same rollout.
pub fn gradient(lattice: &SpringLattice, steps: usize) -> Gradient {
    let rollout = Steps::new(lattice, steps);
    let mut tape = Tape::new();
    Box::new(move |_, inputs| {
        let sum: Var<f64> = tape.record(inputs, |inputs| rollout.sum(inputs));
        (sum.value(), tape.pullback(&[sum], &[1.0]).to_vec())
    })
}
