//! Bundle adjustment. The residuals are the distances between the points that cameras see and the points that a model
//! predicts.
//!
//! An observation depends on 15 numbers. Forward mode computes its local Jacobian, with one observation in each lane.
//! If the input repeats a camera, point or weight, each repetition counts as a different one.

use autodiff::Real;
use autodiff_programs::{Kernel, data};
use cosmic::kernel;
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use super::rotation;
use super::work::{Error, Prepared, read, require, reusing};

/// The number of parameters of a camera: rotation vector, centre, focal length, principal point, distortion.
const CAMERA: usize = 11;
/// The number of inputs of an observation: camera, point, weight.
const INPUTS: usize = CAMERA + 4;
/// The largest allowed number of cameras, points or observations.
const MOST: usize = 1 << 24;
/// The number of entries of each list that an answer contains. GradBench compares only this many entries from the
/// beginning of a list.
const SENT: usize = 30;

/// The input from GradBench: the numbers of cameras, points and observations. One camera, one point, one weight and one
/// feature follow, which are repeated as often as needed.
#[derive(Deserialize)]
struct Input {
    n: usize,
    m: usize,
    p: usize,
    cam: [f64; CAMERA],
    x: [f64; 3],
    w: f64,
    feat: [f64; 2],
}

/// A bundle adjustment that is ready to run, with memory for its results.
struct Ba {
    scene: Scene,
    reprojection: Vec<[f64; 2]>,
    weight_error: Vec<f64>,
    jacobian: Csr,
}

/// The cameras, points and observations of an instance.
struct Scene {
    cameras: Vec<[f64; CAMERA]>,
    points: Vec<[f64; 3]>,
    weights: Vec<f64>,
    features: Vec<[f64; 2]>,
    /// For each observation, the index of its camera and of its point.
    seen: Vec<[usize; 2]>,
}

/// A sparse matrix in the compressed sparse row format (CSR).
#[derive(Default)]
struct Csr {
    /// For each row, the index of its first entry. At the end, the number of all entries.
    rows: Vec<u32>,
    cols: Vec<u32>,
    vals: Vec<f64>,
}

/// The residuals of one observation: the weighted reprojection error, and the error `1 - w^2` of the weight. The
/// measured feature is subtracted beforehand from the principal point, because both are constants that are added to the
/// image coordinates.
struct Observation;

#[kernel]
impl Kernel<INPUTS, 3> for Observation {
    fn eval<R: Real>(&self, x: [R; INPUTS], _: &[R]) -> [R; 3] {
        let [r0, r1, r2, c0, c1, c2, focal, rest @ ..] = x;
        let [u0, v0, k1, k2, x0, x1, x2, weight] = rest;
        let [p0, p1, p2] = rotation::rotate([r0, r1, r2], [x0 - c0, x1 - c1, x2 - c2]);
        let (p0, p1) = (p0 / p2, p1 / p2);
        let squared = p0 * p0 + p1 * p1;
        let scale = focal * (R::one() + squared * (k1 + squared * k2));
        let [u, v] = [scale * p0 + u0, scale * p1 + v0];
        [weight * u, weight * v, R::one() - weight * weight]
    }
}

impl Ba {
    fn new(input: Input) -> Result<Self, Error> {
        let Input { n, m, p, .. } = input;
        let fits = [n, m, p].iter().all(|count| (1..=MOST).contains(count));
        require(fits, "`n`, `m` and `p` must be from 1 to 16777216")?;
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

    /// Returns the first residuals, and how many residuals there are.
    fn first(&self) -> Value {
        let (errors, weights) = (&self.reprojection, &self.weight_error);
        json!({
            "reproj_error": { "elements": errors[0], "repeated": errors.len() },
            "w_err": { "element": weights[0], "repeated": weights.len() },
        })
    }

    /// Returns each list of the Jacobian, shortened to its beginning and its last number.
    fn ends(&self) -> Value {
        let Csr { rows, cols, vals } = &self.jacobian;
        json!({ "rows": ends(rows), "cols": ends(cols), "vals": ends(vals) })
    }

    fn objective(&mut self) {
        let scene = &self.scene;
        let keep = |i, [u, v, weight]: [f64; 3]| {
            self.reprojection[i] = [u, v];
            self.weight_error[i] = weight;
        };
        data::values(&Observation, scene.weights.len(), |i| scene.inputs(i), keep);
    }

    /// Computes the rows of the Jacobian. Each reprojection has two rows, and then each weight has one.
    fn derivative(&mut self) {
        let (scene, Csr { rows, cols, vals }) = (&self.scene, &mut self.jacobian);
        let count = scene.weights.len();
        let weights = 2 * INPUTS * count;
        cols.resize(weights + count, 0);
        vals.resize(weights + count, 0.0);
        rows.clear();
        let starts = (0..=weights).step_by(INPUTS);
        let starts = starts.chain(weights + 1..=weights + count);
        rows.extend(starts.map(|start| start as u32));
        let keep = |i: usize, local: data::LocalJacobian<'_, f64, INPUTS, 3>| {
            let columns = scene.columns(i);
            for result in 0..2 {
                self.reprojection[i][result] = local.value(result);
                let row = INPUTS * (2 * i + result);
                cols[row..][..INPUTS].copy_from_slice(&columns);
                for (input, partial) in vals[row..][..INPUTS].iter_mut().enumerate() {
                    *partial = local.partial(result, input);
                }
            }
            self.weight_error[i] = local.value(2);
            cols[weights + i] = columns[INPUTS - 1];
            vals[weights + i] = local.partial(2, INPUTS - 1);
        };
        data::jacobians(&Observation, count, |i| scene.inputs(i), keep);
    }
}

/// Returns the first [`SENT`] numbers of a list and its last number.
fn ends<T: Copy>(list: &[T]) -> Vec<T> {
    let first = &list[..SENT.min(list.len())];
    [first, &list[list.len() - 1..]].concat()
}

impl Scene {
    /// Returns the 15 numbers that an observation depends on.
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

    /// Returns the columns of the Jacobian in which an observation has entries.
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

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let ba = Ba::new(read(input)?)?;
    match function {
        "objective" => reusing(ba, Ba::objective, Ba::first),
        "jacobian" => reusing(ba, Ba::derivative, Ba::ends),
        _ => Error::function(function),
    }
}
