//! Hand tracking. The residuals are the differences between measured points and points on the skin of a posed hand.
//!
//! A bone moves only with the four angles of its own finger. So four forward directions are enough for all fingers at
//! once (column compression). The position of a vertex is a sum of one part from the palm and one from each of the five
//! fingers. The part from a finger has derivatives along the finger's own four directions.

mod affine;
mod instance;
mod pose;
mod residuals;

use autodiff::Real;
use serde_json::json;
use serde_json::value::RawValue;

use self::instance::{Input, Instance, THETA};
use self::pose::Skin;
use self::residuals::Residuals;
use super::work::{Error, Prepared, Problem, functions, read};

/// A problem that is ready to run, with memory for its results.
pub(super) struct Hand {
    instance: Instance,
    skin: Skin,
    residuals: Vec<f64>,
    /// The Jacobian, row by row.
    jacobian: Vec<f64>,
}

impl Hand {
    pub(super) fn new(input: Input) -> Result<Self, Error> {
        let instance = Instance::new(input)?;
        let rows = 3 * instance.targets.len();
        let columns = THETA + 2 * usize::from(instance.complicated);
        Ok(Self {
            skin: Skin::new(&instance),
            residuals: vec![0.0; rows],
            jacobian: vec![0.0; rows * columns],
            instance,
        })
    }

    fn rows(&self) -> Vec<&[f64]> {
        let columns = self.jacobian.len() / self.residuals.len();
        self.jacobian.chunks(columns).collect()
    }

    /// Computes the residuals from the posed skin. If `with_derivatives` is true, also computes the Jacobian from the
    /// derivatives of the skin.
    fn measure(&mut self, with_derivatives: bool) {
        let rows = if with_derivatives {
            self.jacobian.len()
        } else {
            0
        };
        f64::vectorize(Residuals {
            targets: &self.instance.targets,
            skin: &self.skin,
            residuals: &mut self.residuals,
            jacobian: &mut self.jacobian[..rows],
        });
    }
}

impl Problem for Hand {
    fn objective(&mut self) {
        self.skin.pose(&self.instance);
        self.measure(false);
    }

    fn derivative(&mut self) {
        self.skin.pose_with_derivatives(&self.instance);
        self.measure(true);
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let hand = Hand::new(read(input)?)?;
    functions(
        function,
        hand,
        [|hand| json!(hand.residuals), |hand| json!(hand.rows())],
    )
}
