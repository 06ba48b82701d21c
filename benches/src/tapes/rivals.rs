//! The tapes compared, ours first, each used as its documentation says.

use autodiff::{Real, Tape, Var};

use super::step::{Number, SpringLattice};

/// Differentiates the step: its value and gradient. Memory is kept where the tape can keep it.
pub type Gradient = Box<dyn FnMut(&SpringLattice, &[f64]) -> (f64, Vec<f64>)>;

impl Number for f64 {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
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
}

impl Number for Var<f64> {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::lit(value)
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

/// A function that makes a gradient, and keeps its own memory.
pub type Maker = fn() -> Gradient;

/// The tapes in this build, by name.
pub fn tapes() -> Vec<(&'static str, Maker)> {
    vec![
        ("`Tape` of this crate", ours),
        #[cfg(feature = "xad-rs")]
        ("xad-rs 1.0", xad::gradient),
        #[cfg(feature = "rivals")]
        ("reverse 0.2", reverse::gradient),
        #[cfg(feature = "rivals")]
        ("ad_trait 0.3", ad_trait::gradient),
        #[cfg(feature = "rivals")]
        ("echidna 0.15", echidna::gradient),
    ]
}

/// The step alone, as plain numbers.
pub fn plain() -> Gradient {
    Box::new(|lattice, inputs| (lattice.step(inputs), Vec::new()))
}

/// The tape of this workspace.
pub fn ours() -> Gradient {
    let mut tape = Tape::new();
    Box::new(move |lattice, inputs| {
        let sum = tape.record(inputs, |inputs| lattice.step(inputs));
        (sum.value(), tape.pullback(&[sum], &[1.0]).to_vec())
    })
}

/// Tape of xad-rs, active by thread.
#[cfg(feature = "xad-rs")]
pub mod xad {
    use xad_rs::{AReal, Tape, math};

    use super::Gradient;
    use crate::tapes::step::Number;

    impl Number for AReal<f64> {
        #[inline(always)]
        fn like(self, value: f64) -> Self {
            Self::new(value)
        }
        #[inline(always)]
        fn primal(self) -> f64 {
            self.value()
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            math::ad::sqrt(&self)
        }
        #[inline(always)]
        fn scale(self, factor: f64) -> Self {
            self * factor
        }
        #[inline(always)]
        fn shift(self, term: f64) -> Self {
            self + term
        }
    }

    /// Its gradient of the step.
    pub fn gradient() -> Gradient {
        let mut tape = Tape::<f64>::new(false);
        Box::new(move |lattice, inputs| {
            let mut inputs: Vec<_> = inputs.iter().map(|&x| AReal::new(x)).collect();
            let _recording = tape.record();
            AReal::register_input(&mut inputs, &mut tape);
            let sum = lattice.step(&inputs);
            sum.set_adjoint(&mut tape, 1.0);
            tape.compute_adjoints();
            let gradient = inputs.iter().map(|x| x.adjoint(&tape)).collect();
            (sum.value(), gradient)
        })
    }
}

/// Tape of reverse.
#[cfg(feature = "rivals")]
pub mod reverse {
    use reverse::{Gradient as _, Tape, Var};

    use super::Gradient;
    use crate::tapes::step::Number;

    impl Number for Var<'_> {
        #[inline(always)]
        fn like(self, value: f64) -> Self {
            self.tape.add_var(value)
        }
        #[inline(always)]
        fn primal(self) -> f64 {
            self.val
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Var::sqrt(&self)
        }
        #[inline(always)]
        fn scale(self, factor: f64) -> Self {
            self * factor
        }
        #[inline(always)]
        fn shift(self, term: f64) -> Self {
            self + term
        }
    }

    /// Its gradient of the step.
    pub fn gradient() -> Gradient {
        let tape = Tape::new();
        Box::new(move |lattice, inputs| {
            tape.clear();
            let inputs = tape.add_vars(inputs);
            let sum = lattice.step(&inputs);
            (sum.val, sum.grad().wrt(&inputs))
        })
    }
}

/// Tape of ad_trait, one for the whole program.
#[cfg(feature = "rivals")]
pub mod ad_trait {
    use ad_trait::AD;
    use ad_trait::reverse_ad::adr::{GlobalComputationGraph, adr};

    use super::Gradient;
    use crate::tapes::step::Number;

    impl Number for adr {
        #[inline(always)]
        fn like(self, value: f64) -> Self {
            adr::constant(value)
        }
        #[inline(always)]
        fn primal(self) -> f64 {
            self.value()
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            ad_trait::nalgebra::ComplexField::sqrt(self)
        }
    }

    /// Its gradient of the step.
    pub fn gradient() -> Gradient {
        Box::new(move |lattice, inputs| {
            GlobalComputationGraph::get().reset();
            let variable = |&x: &f64| adr::new_variable(x, false);
            let inputs: Vec<_> = inputs.iter().map(variable).collect();
            let sum = lattice.step(&inputs);
            let all = sum.get_backwards_mode_grad();
            (sum.value(), inputs.iter().map(|x| all.wrt(x)).collect())
        })
    }
}

/// Tape of echidna, active by thread.
#[cfg(feature = "rivals")]
pub mod echidna {
    use super::Gradient;
    use crate::tapes::step::Number;

    impl Number for echidna::Reverse<f64> {
        #[inline(always)]
        fn like(self, value: f64) -> Self {
            Self::constant(value)
        }
        #[inline(always)]
        fn primal(self) -> f64 {
            echidna::Scalar::value(&self)
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            num_traits::Float::sqrt(self)
        }
        #[inline(always)]
        fn scale(self, factor: f64) -> Self {
            self * factor
        }
        #[inline(always)]
        fn shift(self, term: f64) -> Self {
            self + term
        }
    }

    /// Its gradient of the step.
    pub fn gradient() -> Gradient {
        Box::new(|lattice, inputs| {
            let mut value = 0.0;
            let gradient = echidna::grad(
                |inputs| {
                    let sum = lattice.step(inputs);
                    value = sum.primal();
                    sum
                },
                inputs,
            );
            (value, gradient)
        })
    }
}
