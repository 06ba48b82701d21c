//! Bundle adjustment: where cameras see points, and how far off that is.
//!
//! A reprojection has two results of 15 numbers: the Jacobian is a pullback for each result, by code
//! that is emitted from a recording of the kernel, one observation a lane. Repeated cameras, points
//! and weights are treated as different ones.

#[rustfmt::skip]
mod adjoints;
#[cfg(test)]
mod emission;

use autodiff::{Kernel, Pullback, Real, data};
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::rotation;
use super::work::{Error, Prepared, Problem, functions, read, require};

/// Numbers of a camera: rotation vector, centre, focal length, principal point, distortion.
const CAMERA: usize = 11;
/// Numbers that a reprojection depends on: camera, point, weight.
const INPUTS: usize = CAMERA + 4;
/// The most cameras, points or observations.
const MOST: usize = 1 << 24;
/// How many numbers of a list GradBench compares from its beginning.
const SENT: usize = 30;

/// The input, as GradBench sends it: the numbers of cameras, points and observations, and one of each, which
/// is repeated.
#[derive(Deserialize)]
pub(super) struct Input {
    n: usize,
    m: usize,
    p: usize,
    cam: [f64; CAMERA],
    x: [f64; 3],
    w: f64,
    feat: [f64; 2],
}

/// An instance, with memory for its results.
pub(super) struct Ba {
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
    /// The camera and the point of each observation.
    seen: Vec<[usize; 2]>,
}

/// A sparse matrix, row after row.
#[derive(Default)]
struct Csr {
    /// Where each row begins, and where the last ends.
    rows: Vec<u32>,
    /// The column of each entry.
    cols: Vec<u32>,
    vals: Vec<f64>,
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
        let [r0, r1, r2, c0, c1, c2, focal, rest @ ..] = x;
        let [u0, v0, k1, k2, x0, x1, x2, weight] = rest;
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
}

impl Ba {
    pub(super) fn new(input: Input) -> Result<Self, Error> {
        let Input { n, m, p, .. } = input;
        let fits = [n, m, p].iter().all(|count| (1..=MOST).contains(count));
        require(fits, "a count is zero or too large")?;
        let scene = Scene {
            cameras: vec![input.cam; n],
            points: vec![input.x; m],
            weights: vec![input.w; p],
            features: vec![input.feat; p],
            seen: (0..p).map(|i| [i % n, i % m]).collect(),
        };
        Ok(Self {
            scene,
            reprojection: vec![[0.0; 2]; p],
            weight_error: vec![0.0; p],
            jacobian: Csr::default(),
        })
    }

    /// The first residuals, and how many there are.
    fn first(&self) -> Value {
        let (errors, weights) = (&self.reprojection, &self.weight_error);
        json!({
            "reproj_error": { "elements": errors[0], "repeated": errors.len() },
            "w_err": { "element": weights[0], "repeated": weights.len() },
        })
    }

    /// The ends of the lists of the Jacobian.
    fn ends(&self) -> Value {
        let Csr { rows, cols, vals } = &self.jacobian;
        json!({ "rows": ends(rows), "cols": ends(cols), "vals": ends(vals) })
    }
}

/// The first numbers of a list, and the last.
fn ends<T: Copy>(list: &[T]) -> Vec<T> {
    let first = &list[..SENT.min(list.len())];
    [first, &list[list.len() - 1..]].concat()
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

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let ba = Ba::new(read(input)?)?;
    functions(function, ba, [Ba::first, Ba::ends])
}
