//! The sum of the squared distances of points from their closest centroids.
//!
//! First the closest centroid of each point is found, in lanes over points. Small shifts of the centroids do not change
//! which one is closest. So for the derivatives, each centroid has a fixed set of points, and the objective is a sum
//! over these points.

use autodiff::data::{Sum, Summand};
use autodiff::simd::{Lane, Vectorized};
use autodiff::{Dual, Real, gradient};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Error, Prepared, flat, read, require, work};

#[derive(Deserialize)]
struct Input {
    points: Vec<Vec<f64>>,
    centroids: Vec<Vec<f64>>,
}

/// The points, both point by point and coordinate by coordinate. The list of each coordinate repeats that of the last
/// point to fill whole registers.
struct Cloud {
    points: Vec<Vec<f64>>,
    columns: Vec<Vec<f64>>,
}

/// Lists are padded to a multiple of this length, which is the largest number of lanes in any register.
const PADDING: usize = 16;

impl Cloud {
    fn new(points: Vec<Vec<f64>>) -> Self {
        let column = |i: usize| {
            let mut column: Vec<f64> = points.iter().map(|point| point[i]).collect();
            let last = column[column.len() - 1];
            column.resize(column.len().next_multiple_of(PADDING), last);
            column
        };
        Self {
            columns: (0..points[0].len()).map(column).collect(),
            points,
        }
    }
}

/// Finds the closest centroid of each point, and sums up the squared distances.
struct Closest<'a> {
    cloud: &'a Cloud,
    centroids: &'a [f64],
}

impl Vectorized<f64> for Closest<'_> {
    type Output = (Vec<usize>, f64);
    #[inline(always)]
    fn run<L: Lane<f64>>(self) -> (Vec<usize>, f64) {
        let Cloud { columns, points } = self.cloud;
        let (d, len) = (columns.len(), points.len());
        let mut closest = vec![0; columns[0].len()];
        let (mut indices, mut distances) = ([0.0; PADDING], [0.0; PADDING]);
        let mut total = 0.0;
        for first in (0..len).step_by(L::N) {
            let (mut least, mut index) = (L::lit(f64::INFINITY), L::zero());
            for (k, centroid) in self.centroids.chunks_exact(d).enumerate() {
                let mut distance = L::zero();
                for i in 0..d {
                    let gap = L::load(&columns[i][first..]) - L::splat(centroid[i]);
                    distance = gap.fma(gap, distance);
                }
                let closer = distance.less(least);
                least = L::select(closer, distance, least);
                index = L::select(closer, L::lit(k as f64), index);
            }
            index.store(&mut indices);
            least.store(&mut distances);
            for lane in 0..L::N.min(len - first) {
                closest[first + lane] = indices[lane] as usize;
                total += distances[lane];
            }
        }
        (closest, total)
    }
}

/// The squared distance of a point from a centroid.
#[derive(Clone)]
struct SquaredDistance;

impl Summand for SquaredDistance {
    fn eval<R: Real>(&self, centroid: &[R], point: &[R]) -> R {
        let mut distance = R::zero();
        for i in 0..point.len() {
            let gap = point[i] - centroid[i];
            distance = gap.fma(gap, distance);
        }
        distance
    }
}

/// The derivative of a summand, by forward mode. All shared numbers are shifted by the same amount, and the derivative
/// is with respect to this amount.
#[derive(Clone)]
struct Growth<S>(S);

impl<S: Summand> Summand for Growth<S> {
    fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
        let shared: Vec<Dual<R, 1>> = shared.iter().map(|&x| Dual::variable(x, 0)).collect();
        let datum: Vec<Dual<R, 1>> = datum.iter().map(|&x| Dual::constant(x)).collect();
        self.0.eval(&shared, &datum).tangent[0]
    }
}

/// Returns the negative step of Newton's method for each centroid. The Hessian is diagonal, so its product with a
/// vector of ones gives all its entries. This product is computed by reverse mode over forward mode.
fn direction(cloud: &Cloud, centroids: &[f64]) -> Vec<Vec<f64>> {
    let d = cloud.columns.len();
    let (closest, _) = f64::vectorize(Closest { cloud, centroids });
    let mut clusters = vec![Vec::new(); centroids.len() / d];
    for (point, &cluster) in cloud.points.iter().zip(&closest) {
        clusters[cluster].push(point);
    }
    let of_cluster = |(points, centroid): (&Vec<&Vec<f64>>, &[f64])| {
        let cost = Sum::new(SquaredDistance, points);
        let slope = gradient(|c| cost.run(c), centroid);
        let growth = Sum::new(Growth(SquaredDistance), points);
        let curvature = gradient(|c| growth.run(c), centroid);
        slope.iter().zip(curvature).map(|(g, h)| g / h).collect()
    };
    let pairs = clusters.iter().zip(centroids.chunks(d));
    pairs.map(of_cluster).collect()
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { points, centroids } = read(input)?;
    let d = points.first().map_or(0, Vec::len);
    require(
        d > 0 && !centroids.is_empty(),
        "`points` and `centroids` must not be empty",
    )?;
    flat(&points, d, "all rows of `points` must have the same length")?;
    let centroids = flat(
        &centroids,
        d,
        "each row of `centroids` must be as long as a row of `points`",
    )?;
    let cloud = Cloud::new(points);
    match function {
        "cost" => work(move || {
            let (cloud, centroids) = (&cloud, &centroids[..]);
            f64::vectorize(Closest { cloud, centroids }).1
        }),
        "dir" => work(move || direction(&cloud, &centroids)),
        _ => Error::function(function),
    }
}
