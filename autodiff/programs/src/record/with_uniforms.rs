//! Compiled kernels whose uniform inputs have derivatives.

use autodiff::Real;

use super::replayed::ReplayedKernel;
use crate::arrays::{Array, Bars, Operation, StepValues};

/// A compiled kernel with uniform inputs. Their cotangents come from its recording: they are seldom needed, and every kernel
/// would have to be compiled once more.
pub(crate) struct WithUniforms<R> {
    compiled: Box<dyn Operation<R>>,
    uniforms: Vec<Array>,
    /// The recording, or why there is none.
    recorded: Result<ReplayedKernel, String>,
    /// Whether a uniform input carries a derivative.
    is_active: bool,
}

impl<R> WithUniforms<R> {
    pub(crate) fn new(
        compiled: Box<dyn Operation<R>>,
        uniforms: &[Array],
        recorded: Result<ReplayedKernel, String>,
    ) -> Self {
        Self {
            compiled,
            uniforms: uniforms.to_vec(),
            recorded,
            is_active: false,
        }
    }
}

impl<R: Real> Operation<R> for WithUniforms<R> {
    fn outputs(&self) -> Vec<Array> {
        self.compiled.outputs()
    }

    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        self.compiled.forward(parameters, row);
    }

    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        self.compiled.reverse(values, bars);
        if let (true, Ok(recorded)) = (self.is_active, &self.recorded) {
            recorded.add_uniform_bars(*values, bars);
        }
    }

    /// # Panics
    /// If a uniform input carries a derivative, and the kernel cannot be recorded.
    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) -> bool {
        self.is_active = self.uniforms.iter().any(|uniform| arrays[uniform.id]);
        match &mut self.recorded {
            Ok(recorded) => {
                Operation::<R>::set_active(recorded, arrays, parameters);
            }
            Err(why) => assert!(!self.is_active, "{why}"),
        }
        self.compiled.set_active(arrays, parameters) | self.is_active
    }
}
