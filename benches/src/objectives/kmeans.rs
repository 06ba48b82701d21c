//! The sum of the squared distances of points from their closest centroids.
//!
//! First the closest centroid of each point is found, in lanes over points. Small shifts of the centroids do not change
//! which one is closest. So for the derivatives, each centroid has a fixed set of points, and the objective is a sum of
//! functions of one coordinate each.

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Dual, Real};
use cosmic::kernel;
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

#[kernel]
impl Vectorized<f64> for Closest<'_> {
    type Output = (Vec<usize>, f64);
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

/// For each coordinate of each centroid: the sum, over the points of the centroid, of the squared distance along this
/// coordinate.
fn spreads<R: Real>(cloud: &Cloud, closest: &[usize], centroids: &[R]) -> Vec<R> {
    let d = cloud.columns.len();
    let mut sums = vec![R::zero(); centroids.len()];
    for (point, &cluster) in cloud.points.iter().zip(closest) {
        let own = cluster * d..(cluster + 1) * d;
        let pairs = sums[own.clone()].iter_mut().zip(&centroids[own]);
        for ((sum, &centroid), &point) in pairs.zip(point) {
            let gap = centroid - R::lit(point);
            *sum += gap * gap;
        }
    }
    sums
}

/// Returns the negative step of Newton's method for each centroid. The objective is the sum of the [`spreads`], each of
/// which depends on one coordinate. So the gradient and the diagonal of the Hessian, which has no other entries, are
/// the derivatives of all spreads along a single direction.
fn direction(cloud: &Cloud, centroids: &[f64]) -> Vec<Vec<f64>> {
    let (closest, _) = f64::vectorize(Closest { cloud, centroids });
    let variable = |&x: &f64| Dual::<_, 1>::variable(Dual::<_, 1>::variable(x, 0), 0);
    let variables: Vec<_> = centroids.iter().map(variable).collect();
    let spreads = spreads(cloud, &closest, &variables);
    let steps: Vec<f64> = spreads
        .iter()
        .map(|f| f.value.tangent[0] / f.tangent[0].tangent[0])
        .collect();
    steps
        .chunks_exact(cloud.columns.len())
        .map(<[f64]>::to_vec)
        .collect()
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
