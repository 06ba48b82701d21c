//! Bundle adjustment: where cameras see points, and how far off that is.
//!
//! A reprojection is two results of 15 numbers: the Jacobian is a pullback for each result, by
//! code that is emitted from a recording of the kernel, one observation a lane. Repeated cameras,
//! points and weights are treated as different ones.

#[rustfmt::skip]
mod adjoints;
#[cfg(test)]
mod emission;

use std::path::Path;

use autodiff::{Kernel, Pullback, Real, data};
use serde_json::{Value, json};

use super::input::{self, Error, Tokens};
use super::{Problem, rotation};

/// Numbers of a camera: rotation vector, centre, focal length, principal point, distortion.
const CAMERA: usize = 11;
/// Numbers that a reprojection depends on: camera, point, weight.
const INPUTS: usize = CAMERA + 4;

/// An instance, with memory for its results.
pub struct Ba {
    scene: Scene,
    reprojection: Vec<[f64; 2]>,
    weight_error: Vec<f64>,
    jacobian: Csr,
}

/// The data of an instance.
struct Scene {
    cameras: Vec<[f64; CAMERA]>,
    points: Vec<[f64; 3]>,
    weights: Vec<f64>,
    features: Vec<[f64; 2]>,
    /// Which camera and which point an observation is of.
    seen: Vec<[usize; 2]>,
}

/// A sparse matrix, row after row.
#[derive(Debug, Default)]
pub struct Csr {
    /// Where each row begins, and where the last ends.
    pub rows: Vec<u32>,
    /// The column of each entry.
    pub cols: Vec<u32>,
    /// The entries.
    pub vals: Vec<f64>,
}

/// What an instance repeats: a camera, a point, and an observation of it.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Rotation vector, centre, focal length, principal point, distortion.
    pub camera: [f64; CAMERA],
    /// The point.
    pub point: [f64; 3],
    /// The weight of the observation.
    pub weight: f64,
    /// Where the point is seen.
    pub feature: [f64; 2],
}

impl Csr {
    /// Makes room for the rows of so many observations: all reprojections, then all weights.
    fn resize(&mut self, observations: usize) {
        let reprojections = 2 * INPUTS * observations;
        let len = reprojections + observations;
        self.cols.resize(len, 0);
        self.vals.resize(len, 0.0);
        self.rows.clear();
        let starts = (0..=reprojections).step_by(INPUTS);
        let starts = starts.chain(reprojections + 1..=len);
        self.rows.extend(starts.map(|start| start as u32));
    }
}

/// The reprojection error of camera, point and weight. The feature is taken off the principal
/// point beforehand: both enter as a constant added to the picture's coordinates.
struct Reprojection;

impl Kernel<INPUTS, 2> for Reprojection {
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; INPUTS]) -> [R; 2] {
        let [
            r0,
            r1,
            r2,
            c0,
            c1,
            c2,
            focal,
            u0,
            v0,
            k1,
            k2,
            x0,
            x1,
            x2,
            weight,
        ] = x;
        let [p0, p1, p2] = rotation::rotate([r0, r1, r2], [x0 - c0, x1 - c1, x2 - c2]);
        let (p0, p1) = (p0 / p2, p1 / p2);
        let squared = p0 * p0 + p1 * p1;
        let scale = focal * (R::one() + squared * (k1 + squared * k2));
        [weight * (scale * p0 + u0), weight * (scale * p1 + v0)]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, INPUTS, 2, M>) -> [[R; INPUTS]; M] {
        self.emitted_vjp(at)
    }
}

/// `1 - w^2`.
struct WeightError;

impl Kernel<1, 1> for WeightError {
    #[inline(always)]
    fn eval<R: Real>(&self, [weight]: [R; 1]) -> [R; 1] {
        [R::one() - weight * weight]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 1, 1, M>) -> [[R; 1]; M] {
        self.emitted_vjp(at)
    }
}

impl Ba {
    /// Reads an instance.
    ///
    /// # Errors
    /// If the file cannot be read or is not in the format.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = input::read(path)?;
        let mut tokens = Tokens::new(path, &text);
        let (cameras, points, observations) = (tokens.count()?, tokens.count()?, tokens.count()?);
        let view = View {
            camera: tokens.array()?,
            point: tokens.array()?,
            weight: tokens.next()?,
            feature: tokens.array()?,
        };
        tokens.end()?;
        Ok(Self::new([cameras, points, observations], view))
    }

    /// An instance of so many cameras, points and observations, all of the same numbers.
    pub fn new([cameras, points, observations]: [usize; 3], view: View) -> Self {
        let scene = Scene {
            cameras: vec![view.camera; cameras],
            points: vec![view.point; points],
            weights: vec![view.weight; observations],
            features: vec![view.feature; observations],
            seen: (0..observations)
                .map(|i| [i % cameras, i % points])
                .collect(),
        };
        Self {
            scene,
            reprojection: vec![[0.0; 2]; observations],
            weight_error: vec![0.0; observations],
            jacobian: Csr::default(),
        }
    }

    /// The reprojection errors that were found last.
    pub fn reprojections(&self) -> &[[f64; 2]] {
        &self.reprojection
    }

    /// The errors of the weights that were found last.
    pub fn weight_errors(&self) -> &[f64] {
        &self.weight_error
    }

    /// The Jacobian that was found last.
    pub fn jacobian(&self) -> &Csr {
        &self.jacobian
    }
}

impl Scene {
    /// The numbers that a reprojection depends on.
    #[inline(always)]
    fn inputs(&self, observation: usize) -> [f64; INPUTS] {
        let [camera, point] = self.seen[observation];
        let mut inputs = [0.0; INPUTS];
        inputs[..CAMERA].copy_from_slice(&self.cameras[camera]);
        inputs[CAMERA..CAMERA + 3].copy_from_slice(&self.points[point]);
        inputs[CAMERA + 3] = self.weights[observation];
        inputs[7] -= self.features[observation][0];
        inputs[8] -= self.features[observation][1];
        inputs
    }

    /// The columns of the variables that a reprojection depends on.
    #[inline(always)]
    fn columns(&self, observation: usize) -> [u32; INPUTS] {
        let [camera, point] = self.seen[observation];
        let points = CAMERA * self.cameras.len();
        let weights = points + 3 * self.points.len();
        let mut columns = [0; INPUTS];
        for (i, column) in columns.iter_mut().enumerate() {
            let place = match i {
                0..CAMERA => CAMERA * camera + i,
                CAMERA..14 => points + 3 * point + i - CAMERA,
                _ => weights + observation,
            };
            *column = place as u32;
        }
        columns
    }
}

impl Problem for Ba {
    fn objective(&mut self) {
        let Self {
            scene,
            reprojection,
            weight_error,
            ..
        } = self;
        let count = scene.weights.len();
        let keep = |i, error| reprojection[i] = error;
        data::values(&Reprojection, count, |i| scene.inputs(i), keep);
        let keep = |i, [error]: [f64; 1]| weight_error[i] = error;
        data::values(&WeightError, count, |i| [scene.weights[i]], keep);
    }

    fn derivative(&mut self) {
        let Self {
            scene,
            reprojection,
            weight_error,
            jacobian,
        } = self;
        let count = scene.weights.len();
        jacobian.resize(count);
        let (cols, weight_cols) = jacobian.cols.split_at_mut(2 * INPUTS * count);
        let (vals, weight_vals) = jacobian.vals.split_at_mut(2 * INPUTS * count);
        let rows = |i| 2 * INPUTS * i..2 * INPUTS * (i + 1);
        data::jacobians(
            &Reprojection,
            count,
            |i| scene.inputs(i),
            |i, local| {
                let columns = scene.columns(i);
                let (cols, vals) = (&mut cols[rows(i)], &mut vals[rows(i)]);
                for result in 0..2 {
                    reprojection[i][result] = local.value(result);
                    cols[INPUTS * result..][..INPUTS].copy_from_slice(&columns);
                    let row = &mut vals[INPUTS * result..][..INPUTS];
                    for (input, partial) in row.iter_mut().enumerate() {
                        *partial = local.partial(result, input);
                    }
                }
            },
        );
        data::jacobians(
            &WeightError,
            count,
            |i| [scene.weights[i]],
            |i, local| {
                weight_error[i] = local.value(0);
                weight_cols[i] = scene.columns(i)[INPUTS - 1];
                weight_vals[i] = local.partial(0, 0);
            },
        );
    }

    fn answer(&self) -> Value {
        let Self {
            scene, jacobian, ..
        } = self;
        let Csr { rows, cols, vals } = jacobian;
        let [cameras, points, observations] =
            [scene.cameras.len(), scene.points.len(), scene.weights.len()];
        json!({
            "reproj_err": self.reprojection.concat(),
            "w_err": self.weight_error,
            "jacobian": {
                "nrows": 3 * observations,
                "ncols": CAMERA * cameras + 3 * points + observations,
                "rows": rows,
                "cols": cols,
                "vals": vals,
            },
        })
    }
}
