//! A controller's weights as files hold them.

use serde::{Deserialize, Serialize};

use super::Controller;
use crate::error::{Result, fits, some};

/// The weights of a controller, matrices as lists of rows; gradients by them have the same form.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// `[hidden][inputs]`.
    pub w1: Vec<Vec<f64>>,
    /// `[hidden]`.
    pub b1: Vec<f64>,
    /// `[edges][hidden]`.
    pub w2: Vec<Vec<f64>>,
    /// `[edges]`.
    pub b2: Vec<f64>,
}

impl Weights {
    /// The controller with these weights, for observations of `inputs` numbers and so many edges.
    ///
    /// # Errors
    /// Where a matrix or vector has another shape; `file` is named in the message.
    pub fn controller(&self, inputs: usize, edges: usize, file: &str) -> Result<Controller<f64>> {
        let hidden = self.b1.len();
        let fits = |what: &str, found, expected| fits(file, what, found, expected);
        let matrix_fits = |name: &str, matrix: &[Vec<f64>], rows, columns| {
            fits(&format!("rows of `controller.{name}`"), matrix.len(), rows)?;
            matrix.iter().enumerate().try_for_each(|(i, row)| {
                let what = format!("entries in `controller.{name}[{i}]`");
                fits(&what, row.len(), columns)
            })
        };
        some(file, "entries in `controller.b1`", hidden)?;
        matrix_fits("w1", &self.w1, hidden, inputs)?;
        matrix_fits("w2", &self.w2, edges, hidden)?;
        fits("entries in `controller.b2`", self.b2.len(), edges)?;
        Ok(Controller {
            hidden,
            inputs,
            w1: self.w1.concat(),
            b1: self.b1.clone(),
            w2: self.w2.concat(),
            b2: self.b2.clone(),
        })
    }
}

impl From<&Controller<f64>> for Weights {
    fn from(controller: &Controller<f64>) -> Self {
        let rows = |weights: &[f64], length: usize| -> Vec<Vec<f64>> {
            weights.chunks_exact(length).map(<[f64]>::to_vec).collect()
        };
        Self {
            w1: rows(&controller.w1, controller.inputs),
            b1: controller.b1.clone(),
            w2: rows(&controller.w2, controller.hidden),
            b2: controller.b2.clone(),
        }
    }
}
