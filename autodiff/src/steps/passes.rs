//! The passes of a program over its operations. With the feature `rollouts`, this crate compiles them for floats.
//! Without it, each crate compiles the passes that it needs.

use std::marker::PhantomData;

use super::program::Program;
use crate::arrays::{Bars, StepValues};
use crate::real::{ByType, Real};

/// A pass that every number type needs.
pub(super) enum Forward<'a, R> {
    /// Loads the matrices of dense layers from the parameters.
    Load(&'a [&'a [R]]),
    /// Computes the operations of a step. See [`Program::step`].
    Step {
        parameters: &'a [R],
        row: &'a mut [R],
        soon: Option<*const R>,
    },
}

/// A pass of a reverse sweep.
pub(super) enum Reverse<'a, 'b, R> {
    /// Pulls cotangents back through the operations of a step. See [`Program::reverse_step`].
    Step {
        values: StepValues<'a, R>,
        bars: &'a mut Bars<'b, R>,
        soon: *const R,
    },
    /// Adds the cotangents of the matrices of dense layers to the cotangents of the parameters.
    Matrices(&'a mut [Vec<R>]),
}

impl<R: Real> Program<R> {
    pub(super) fn pass_forward(&mut self, pass: Forward<R>) {
        R::by_type(Forwards(PhantomData), (self, pass));
    }

    pub(super) fn pass_back(&mut self, pass: Reverse<R>) {
        R::by_type(Reverses(PhantomData), (self, pass));
    }

    #[inline(always)]
    fn forward(&mut self, pass: Forward<R>) {
        match pass {
            Forward::Load(parameters) => {
                (self.operations.iter_mut()).for_each(|operation| operation.load(parameters));
            }
            Forward::Step {
                parameters,
                row,
                soon,
            } => {
                for k in 0..self.operations.len() {
                    if let Some(soon) = soon {
                        self.prefetch(k, soon);
                    }
                    self.operations[k].forward(parameters, row);
                }
            }
        }
    }

    #[inline(always)]
    fn reverse(&mut self, pass: Reverse<R>) {
        match pass {
            Reverse::Step { values, bars, soon } => {
                for k in (0..self.operations.len()).rev() {
                    self.prefetch(k, soon);
                    self.operations[k].reverse(&values, bars);
                }
            }
            Reverse::Matrices(bars) => {
                (self.operations.iter_mut()).for_each(|operation| operation.matrix_bars(bars));
            }
        }
    }
}

struct Forwards<'a>(PhantomData<&'a ()>);

impl<'a> ByType for Forwards<'a> {
    type Of<R: Real> = (&'a mut Program<R>, Forward<'a, R>);
    type Output<R: Real> = ();
    #[cfg_attr(feature = "rollouts", inline(never))]
    #[cfg_attr(not(feature = "rollouts"), inline)]
    fn f64(self, (program, pass): Self::Of<f64>) {
        program.forward(pass);
    }
    #[cfg_attr(feature = "rollouts", inline(never))]
    #[cfg_attr(not(feature = "rollouts"), inline)]
    fn f32(self, (program, pass): Self::Of<f32>) {
        program.forward(pass);
    }
    fn other<R: Real>(self, (program, pass): Self::Of<R>) {
        program.forward(pass);
    }
}

struct Reverses<'a, 'b>(PhantomData<(&'a (), &'b ())>);

impl<'a, 'b: 'a> ByType for Reverses<'a, 'b> {
    type Of<R: Real> = (&'a mut Program<R>, Reverse<'a, 'b, R>);
    type Output<R: Real> = ();
    #[cfg_attr(feature = "rollouts", inline(never))]
    #[cfg_attr(not(feature = "rollouts"), inline)]
    fn f64(self, (program, pass): Self::Of<f64>) {
        program.reverse(pass);
    }
    #[cfg_attr(feature = "rollouts", inline(never))]
    #[cfg_attr(not(feature = "rollouts"), inline)]
    fn f32(self, (program, pass): Self::Of<f32>) {
        program.reverse(pass);
    }
    fn other<R: Real>(self, (program, pass): Self::Of<R>) {
        program.reverse(pass);
    }
}
