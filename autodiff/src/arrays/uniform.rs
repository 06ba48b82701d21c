//! The uniform inputs of kernels: numbers that all elements share. An operation loads these numbers once. It computes
//! their cotangents only if they are needed.

use super::array::Array;
use super::kernel::{Kernel, Pullback, constants, pulled_back};
use super::row::{Bars, StepValues};
use crate::real::Real;
use crate::simd::{Lane, WIDEST};

/// The largest number of uniform inputs that a kernel can have.
pub const MOST_UNIFORMS: usize = 16;

/// A [`Kernel`] whose uniform inputs have constant values, so that it has none.
#[derive(Clone, Debug)]
pub struct Fixed<K> {
    /// The kernel.
    pub kernel: K,
    /// The values of the uniform inputs.
    pub uniforms: Vec<f64>,
}

impl<K: Kernel<I, O>, const I: usize, const O: usize> Kernel<I, O> for Fixed<K> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; I], _: &[R]) -> [R; O] {
        let uniforms = constant_uniforms(&self.uniforms);
        self.kernel.eval(x, &uniforms[..K::UNIFORMS])
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, I, O, M>) -> [[R; I]; M] {
        let uniforms = constant_uniforms(&self.uniforms);
        let uniforms = &uniforms[..K::UNIFORMS];
        self.kernel.vjp(Pullback { uniforms, ..at })
    }
}

#[inline(always)]
#[track_caller]
fn constant_uniforms<R: Real>(values: &[f64]) -> [R; MOST_UNIFORMS] {
    let mut uniforms = [R::zero(); MOST_UNIFORMS];
    for (uniform, &value) in uniforms.iter_mut().zip(checked(values)) {
        *uniform = R::lit(value);
    }
    uniforms
}

/// Returns the list. Panics if it is longer than a kernel's uniform inputs may be.
#[inline(always)]
#[track_caller]
pub(crate) fn checked<T>(list: &[T]) -> &[T] {
    assert!(
        list.len() <= MOST_UNIFORMS,
        "a kernel can have at most {MOST_UNIFORMS} uniform inputs"
    );
    list
}

/// Returns the contribution of one element to the cotangent of uniform input `k`.
#[inline(always)]
fn by_uniform<R, K, const I: usize, const O: usize>(
    kernel: &K,
    (x, y_bar): ([R; I], [R; O]),
    uniforms: &[R; MOST_UNIFORMS],
    k: usize,
) -> R
where
    R: Real,
    K: Kernel<I, O>,
{
    let mut moving = constants::<R, 1, MOST_UNIFORMS>(uniforms);
    moving[k].tangent = [R::one()];
    let y = kernel.eval(constants(&x), &moving[..K::UNIFORMS]);
    let [[bar]] = pulled_back(y, [y_bar]);
    bar
}

/// The uniform inputs of an operation: arrays with one number for each start.
pub(super) struct UniformInputs {
    arrays: Vec<Array>,
    /// The indices of the uniform inputs that carry derivatives.
    active: Vec<usize>,
}

impl UniformInputs {
    /// `count` is the kernel's constant [`Kernel::UNIFORMS`].
    ///
    /// # Panics
    /// If this is not the number of arrays.
    #[track_caller]
    pub(super) fn new(arrays: &[Array], count: usize) -> Self {
        assert_eq!(
            checked(arrays).len(),
            count,
            "the number of uniform arrays must be the kernel's `UNIFORMS`"
        );
        Self {
            arrays: arrays.to_vec(),
            active: (0..arrays.len()).collect(),
        }
    }

    pub(super) fn set_active(&mut self, arrays: &[bool]) {
        let is_active = |k: &usize| arrays[self.arrays[*k].id];
        self.active = (0..self.arrays.len()).filter(is_active).collect();
    }

    /// Loads each uniform input into a register, in which the numbers of all starts repeat. `count` is the kernel's
    /// constant [`Kernel::UNIFORMS`].
    #[inline(always)]
    pub(super) fn load<R: Real, L: Lane<R>>(
        &self,
        count: usize,
        values: StepValues<R>,
    ) -> [L; MOST_UNIFORMS] {
        let mut uniforms = [L::zero(); MOST_UNIFORMS];
        for k in 0..count {
            let numbers = values.get(self.arrays[k]);
            uniforms[k] = match numbers.len() {
                1 => L::splat(numbers[0]),
                starts if starts == L::N => L::load(numbers),
                starts => {
                    let mut lanes = [R::zero(); WIDEST];
                    for i in 0..L::N {
                        lanes[i] = numbers[i % starts];
                    }
                    L::load(&lanes)
                }
            };
        }
        uniforms
    }

    /// Adds the cotangents of the uniform inputs that carry derivatives, one element at a time. `at` returns an
    /// element's index, its inputs and the cotangents of its results. This does not use SIMD lanes: it is rarely
    /// needed, and every kernel would have to be compiled once more for every register width.
    #[inline(never)]
    pub(super) fn add_bars<R, K, E, const I: usize, const O: usize>(
        &self,
        kernel: &K,
        values: StepValues<R>,
        bars: &mut Bars<R>,
        elements: impl Iterator<Item = E>,
        at: impl Fn(&Bars<R>, E) -> (usize, [R; I], [R; O]),
    ) where
        R: Real,
        K: Kernel<I, O>,
    {
        if self.active.is_empty() {
            return;
        }
        for element in elements {
            let (place, x, y_bar) = at(bars, element);
            let mut uniforms = [R::zero(); MOST_UNIFORMS];
            for (uniform, &array) in uniforms.iter_mut().zip(&self.arrays) {
                *uniform = values.get(array)[place % array.len];
            }
            for &k in &self.active {
                let array = self.arrays[k];
                let bar = by_uniform(kernel, (x, y_bar), &uniforms, k);
                bars.get_mut(array)[place % array.len] += bar;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::check::{Options, Verdict, check_gradient};
    use crate::{
        Function, Given, Graph, Kernel, Model, Program, Real, Rollout, Var, gradient, kernel,
    };

    /// A spring with the force `u[0] d + u[1] d^3` for an elongation `d`.
    #[derive(Clone)]
    struct Spring;

    #[kernel]
    impl Kernel<1, 1> for Spring {
        const UNIFORMS: usize = 2;

        fn eval<R: Real>(&self, [d]: [R; 1], u: &[R]) -> [R; 1] {
            [u[0] * d + u[1] * d * d * d]
        }
    }

    /// A kernel that moves a node: it adds to the position the force and a wind of strength `u[0]`, which depends on
    /// the position.
    #[derive(Clone)]
    struct Move;

    #[kernel]
    impl Kernel<2, 1> for Move {
        const UNIFORMS: usize = 1;

        fn eval<R: Real>(&self, [x, force]: [R; 2], u: &[R]) -> [R; 1] {
            [x + force + u[0] * x.sin()]
        }
    }

    /// The number of nodes: more than a register has lanes, and not a multiple of the number of lanes.
    const NODES: usize = 19;

    #[derive(Clone)]
    struct Chain(Graph);

    impl Model for Chain {
        fn record(&self, p: &mut Program) {
            let [stiffness, cubic, wind] = [(); 3].map(|()| p.parameter(1));
            let x = p.state(NODES);
            let [force] = p.map_edges(&self.0, Spring, [x], &[], &[stiffness, cubic]);
            let [next] = p.map(Move, [x, force], &[wind]);
            p.advance(x, next);
        }
    }

    fn rollout() -> Rollout<Chain> {
        let edges: Vec<[usize; 2]> = (1..NODES).map(|i| [i - 1, i]).collect();
        Rollout::new(Chain(Graph::new(NODES, &edges)), 5)
    }

    fn start<R: Real>() -> Vec<R> {
        (0..NODES).map(|i| R::lit((0.7 * i as f64).sin())).collect()
    }

    /// A weighted sum of the last state, as a function of the uniform inputs.
    struct Weighted;

    fn weighted<R: Real>(end: &[R]) -> R {
        let terms = end.iter().enumerate();
        terms.map(|(i, &x)| R::lit(1.0 + 0.1 * i as f64) * x).sum()
    }

    impl Function for Weighted {
        fn eval<R: Real>(&self, u: &[R]) -> R {
            let uniforms: Vec<&[R]> = u.chunks(1).collect();
            weighted(&rollout().run(&start(), &uniforms))
        }
    }

    #[test]
    fn uniform_inputs_have_derivatives() {
        let report = check_gradient(&Weighted, &[0.2, 0.1, 0.3], &Options::default());
        assert_eq!(report.verdict, Verdict::Smooth, "{report}");
        assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
    }

    /// Batches of 2, 8 and 11 starts run in pairs, in whole registers and alone. Every gradient must equal the one from
    /// single runs.
    #[test]
    fn uniform_inputs_of_a_batch_have_the_bits_of_single_runs() {
        for count in [2, 8, 11] {
            let of_robots: Vec<f64> = (0..3 * count).map(|k| 0.1 + 0.01 * k as f64).collect();
            let alone = |u: &[Var<f64>]| u.chunks(3).map(|u| Weighted.eval(u)).sum();
            let together = |u: &[Var<f64>]| {
                let own = |k: usize| -> Vec<&[Var<f64>]> { u[k..].chunks(1).step_by(3).collect() };
                let own = [own(0), own(1), own(2)];
                let given: Vec<Given<Var<f64>>> = own.iter().map(|own| Given::Each(own)).collect();
                let start = start();
                let ends = rollout().run_batch(&vec![&start[..]; count], &given);
                ends.iter().map(|end| weighted(end)).sum()
            };
            let [alone, together] = [gradient(alone, &of_robots), gradient(together, &of_robots)];
            assert_eq!(alone, together);
        }
    }
}
