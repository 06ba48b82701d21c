//! Formulas as terms of sums.

use autodiff::Real;
use autodiff_programs::data::Summand;

use crate::common::Formula;

/// A formula can be a summand. Its arguments are the shared parameters, followed by the datum.
impl Summand for Formula {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        self.values(&[shared, datum].concat())[0]
    }
}
