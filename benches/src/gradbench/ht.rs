//! Hand tracking: [`adbench`](crate::adbench::hand)'s. Without `us` correspondences are vertices, else they
//! are triangles.

use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, Work, read, require};
use crate::adbench::Problem;
use crate::adbench::hand::{Affine, BONES, Bone, Hand, HandModel, THETA, Target, Vertex};

#[derive(Deserialize)]
struct Input {
    theta: [f64; THETA],
    data: Data,
    us: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
struct Data {
    model: Model,
    correspondences: Vec<usize>,
    points: Vec<[f64; 3]>,
}

type Matrix = [[f64; 4]; 4];

#[derive(Deserialize)]
struct Model {
    parents: Vec<i64>,
    base_relatives: Vec<Matrix>,
    inverse_base_absolutes: Vec<Matrix>,
    base_positions: Vec<Vec<f64>>,
    weights: Vec<Vec<f64>>,
    triangles: Vec<[usize; 3]>,
    is_mirrored: bool,
}

impl Model {
    fn hand(self) -> Result<HandModel, Refusal> {
        let matrices = [&self.base_relatives, &self.inverse_base_absolutes];
        let fits = matrices.iter().all(|list| list.len() == BONES) && self.parents.len() == BONES;
        require(
            fits,
            "a hand has two matrices and a parent for each of 22 bones",
        )?;
        let bone = |i: usize| {
            Ok(Bone {
                parent: usize::try_from(self.parents[i]).ok(),
                relative: affine(&self.base_relatives[i])?,
                inverse_rest: affine(&self.inverse_base_absolutes[i])?,
            })
        };
        let bones: Result<_, Refusal> = (0..BONES).map(bone).collect();
        let vertices = self.base_positions.len();
        require(self.weights.len() == vertices, "a vertex has weights")?;
        let mut corners = self.triangles.iter().flatten();
        require(
            corners.all(|&corner| corner < vertices),
            "a triangle names a missing vertex",
        )?;
        let rows = self.base_positions.iter().zip(&self.weights);
        let vertices: Result<Vec<_>, _> = rows
            .map(|(place, weights)| vertex(place, weights))
            .collect();
        HandModel::new(bones?, &vertices?, self.triangles, self.is_mirrored)
            .ok_or_else(|| Refusal::Shape("a bone comes after its parent".into()))
    }
}

/// The upper rows of a matrix, whose last must be 0 0 0 1.
fn affine(matrix: &Matrix) -> Result<Affine<f64>, Refusal> {
    let [x, y, z, last] = *matrix;
    require(
        last == [0.0, 0.0, 0.0, 1.0],
        "the last row of a transformation is 0 0 0 1",
    )?;
    Ok(Affine([x, y, z]))
}

/// A place, and the bones that it is bound to with their weights.
fn vertex(place: &[f64], weights: &[f64]) -> Result<Vertex, Refusal> {
    require(
        weights.len() == BONES,
        "a vertex has a weight for each bone",
    )?;
    let &[x, y, z, 1.0] = place else {
        return Err(Refusal::Shape("a vertex is x y z 1".into()));
    };
    let bound = weights.iter().copied().enumerate();
    Ok((
        [x, y, z],
        bound.filter(|&(_, weight)| weight != 0.0).collect(),
    ))
}

impl Input {
    fn problem(self) -> Result<Hand, Refusal> {
        let Data {
            model,
            correspondences,
            points,
        } = self.data;
        let (model, complicated) = (model.hand()?, !self.us.is_empty());
        let count = correspondences.len();
        require(
            points.len() == count && count > 0,
            "a correspondence has a point",
        )?;
        require(
            !complicated || self.us.len() == count,
            "a correspondence has its u",
        )?;
        let target = |i: usize| {
            let index = correspondences[i];
            let corners = if complicated {
                model.triangles.get(index).copied()
            } else {
                (index < model.len).then_some([index; 3])
            };
            let missing = || Refusal::Shape(format!("there is no vertex or triangle {index}"));
            Ok(Target {
                point: points[i],
                corners: corners.ok_or_else(missing)?,
                u: self.us.get(i).copied().unwrap_or([1.0, 0.0]),
            })
        };
        let targets: Result<_, Refusal> = (0..count).map(target).collect();
        let targets = targets?;
        Ok(Hand::new(model, self.theta, targets, complicated))
    }
}

struct Objective(Hand);

impl Work for Objective {
    fn run(&mut self) {
        self.0.objective();
    }
    fn answer(&self) -> serde_json::Result<String> {
        serde_json::to_string(self.0.residuals())
    }
}

struct Jacobian(Hand);

impl Work for Jacobian {
    fn run(&mut self) {
        self.0.derivative();
    }
    fn answer(&self) -> serde_json::Result<String> {
        serde_json::to_string(&self.0.rows())
    }
}

/// Functions `objective` and `jacobian`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let hand = read::<Input>(input)?.problem()?;
    match function {
        "objective" => Ok(Box::new(Objective(hand))),
        "jacobian" => Ok(Box::new(Jacobian(hand))),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
