//! The uniform inputs of a mapped kernel. They are loaded once for each operation, and their cotangents are only
//! computed if they are needed.

use super::array::Array;
use super::kernel::{Kernel, MOST_UNIFORMS, Uniforms, by_uniform, checked};
use super::row::{Bars, StepValues};
use crate::real::Real;
use crate::simd::{Lane, WIDEST};

/// Arrays of one number for each start.
pub(super) struct UniformInputs {
    arrays: Vec<Array>,
    /// The indices of the inputs that carry derivatives.
    active: Vec<usize>,
}

impl UniformInputs {
    /// # Panics
    /// If the kernel does not have as many uniform inputs.
    pub(super) fn new<K: Kernel<I, O>, const I: usize, const O: usize>(arrays: &[Array]) -> Self {
        assert_eq!(
            checked(arrays).len(),
            K::UNIFORMS,
            "the kernel needs as many uniform inputs as it declares"
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

    /// A register of each input: the numbers of all starts, repeated.
    #[inline(always)]
    pub(super) fn load<R: Real, L: Lane<R>>(&self, values: StepValues<R>) -> Uniforms<L> {
        let mut uniforms = [L::zero(); MOST_UNIFORMS];
        for (uniform, &array) in uniforms.iter_mut().zip(&self.arrays) {
            let numbers = values.get(array);
            *uniform = match numbers.len() {
                1 => L::splat(numbers[0]),
                starts if starts == L::N => L::load(numbers),
                starts => {
                    let mut lanes = [R::zero(); WIDEST];
                    for k in 0..L::N {
                        lanes[k] = numbers[k % starts];
                    }
                    L::load(&lanes)
                }
            };
        }
        uniforms
    }

    /// Adds the cotangents of the inputs that carry derivatives, one element after the other. `at` returns an element's
    /// place, its inputs and the cotangents of its results. This is not done in lanes: it is rarely needed, and every
    /// kernel would be compiled once more for every width.
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
    use crate::arrays::{Pullback, Uniforms, uniforms, vjp_by_duals_with};
    use crate::check::{Options, Verdict, check_gradient};
    use crate::{Function, Given, Graph, Kernel, Model, Program, Real, Rollout, Var, gradient_of};

    /// A spring of stiffness `u[0]` that pulls harder by `u[1]` at each length.
    #[derive(Clone)]
    struct Spring;

    impl Kernel<1, 1> for Spring {
        const UNIFORMS: usize = 2;

        #[inline(always)]
        fn eval<R: Real>(&self, x: [R; 1]) -> [R; 1] {
            self.eval_with(x, &uniforms(&[0.2, 0.1]))
        }

        #[inline(always)]
        fn eval_with<R: Real>(&self, [d]: [R; 1], u: &Uniforms<R>) -> [R; 1] {
            [u[0] * d + u[1] * d * d * d]
        }

        #[inline(always)]
        fn vjp_with<R: Real, const M: usize>(
            &self,
            at: Pullback<R, 1, 1, M>,
            u: &Uniforms<R>,
        ) -> [[R; 1]; M] {
            vjp_by_duals_with(self, at, u)
        }
    }

    /// A step under a uniform wind.
    #[derive(Clone)]
    struct Move;

    impl Kernel<2, 1> for Move {
        const UNIFORMS: usize = 1;

        #[inline(always)]
        fn eval<R: Real>(&self, x: [R; 2]) -> [R; 1] {
            self.eval_with(x, &uniforms(&[0.3]))
        }

        #[inline(always)]
        fn eval_with<R: Real>(&self, [x, force]: [R; 2], u: &Uniforms<R>) -> [R; 1] {
            [x + force + u[0] * x.sin()]
        }

        #[inline(always)]
        fn vjp_with<R: Real, const M: usize>(
            &self,
            at: Pullback<R, 2, 1, M>,
            u: &Uniforms<R>,
        ) -> [[R; 2]; M] {
            vjp_by_duals_with(self, at, u)
        }
    }

    /// More nodes than a register has lanes, and a part of a register.
    const NODES: usize = 19;

    #[derive(Clone)]
    struct Chain(Graph);

    impl Model for Chain {
        fn record<R: Real>(&self, program: &mut Program<R>) {
            let [stiffness, cubic, wind] = [(); 3].map(|()| program.parameter(1));
            let x = program.state(NODES);
            // Other number types than floats replay the kernels.
            let p = &mut program.any();
            let [force] = p.map_edges_with(&self.0, Spring, [x], &[], &[stiffness, cubic]);
            let [next] = p.map_with(Move, [x, force], &[wind]);
            program.advance(x, next);
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

    /// In pairs, in registers and alone.
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
            let [alone, together] = [
                gradient_of(alone, &of_robots),
                gradient_of(together, &of_robots),
            ];
            assert_eq!(alone, together);
        }
    }
}
