//! Bundle adjustment: [`adbench`](crate::adbench::ba)'s. Copies of one observation are sent; the work is
//! done for each.

use serde::Deserialize;
use serde_json::json;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, Work, read, require};
use crate::adbench::Problem;
use crate::adbench::ba::{Ba, Csr, View};

#[derive(Deserialize)]
struct Input {
    n: usize,
    m: usize,
    p: usize,
    cam: [f64; 11],
    x: [f64; 3],
    w: f64,
    feat: [f64; 2],
}

/// More cameras, points or observations are refused.
const MOST: usize = 1 << 24;
/// How many numbers of a list are sent from its beginning.
const SENT: usize = 30;

struct Objective(Ba);

impl Work for Objective {
    fn run(&mut self) {
        self.0.objective();
    }
    fn answer(&self) -> serde_json::Result<String> {
        let (errors, weights) = (self.0.reprojections(), self.0.weight_errors());
        serde_json::to_string(&json!({
            "reproj_error": { "elements": errors[0], "repeated": errors.len() },
            "w_err": { "element": weights[0], "repeated": weights.len() },
        }))
    }
}

struct Jacobian(Ba);

impl Work for Jacobian {
    fn run(&mut self) {
        self.0.derivative();
    }
    fn answer(&self) -> serde_json::Result<String> {
        let Csr { rows, cols, vals } = self.0.jacobian();
        serde_json::to_string(&json!({
            "rows": ends(rows),
            "cols": ends(cols),
            "vals": ends(vals),
        }))
    }
}

/// The first numbers of a list, and the last.
fn ends<T: Copy>(list: &[T]) -> Vec<T> {
    let first = &list[..SENT.min(list.len())];
    [first, &list[list.len() - 1..]].concat()
}

/// Functions `objective` and `jacobian`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let input: Input = read(input)?;
    let counts = [input.n, input.m, input.p];
    let fits = counts.iter().all(|count| (1..=MOST).contains(count));
    require(fits, "a count is zero or too large")?;
    let view = View {
        camera: input.cam,
        point: input.x,
        weight: input.w,
        feature: input.feat,
    };
    let ba = Ba::new(counts, view);
    match function {
        "objective" => Ok(Box::new(Objective(ba))),
        "jacobian" => Ok(Box::new(Jacobian(ba))),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
