//! The squared distances of points from the closest of some centroids.
//!
//! Which centroid is the closest is found first, in lanes over points; it is constant almost
//! everywhere. Derivatives are those of the distances from known centroids.

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Function, Real, hessian_vector};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::work::{Prepared, Refusal, flat, read, require, work};

#[derive(Deserialize)]
struct Input {
    points: Vec<Vec<f64>>,
    centroids: Vec<Vec<f64>>,
}

/// Points by coordinate, the last repeated to fill whole registers.
struct Cloud {
    columns: Vec<Vec<f64>>,
    len: usize,
}

/// At least as many as any register has lanes.
const PADDING: usize = 16;

impl Cloud {
    fn new(points: &[Vec<f64>]) -> Self {
        let column = |i: usize| {
            let mut column: Vec<f64> = points.iter().map(|point| point[i]).collect();
            let last = column[column.len() - 1];
            column.resize(column.len().next_multiple_of(PADDING), last);
            column
        };
        Self {
            columns: (0..points[0].len()).map(column).collect(),
            len: points.len(),
        }
    }
}

/// The closest centroid of each point, and the sum of the squared distances.
struct Closest<'a> {
    cloud: &'a Cloud,
    centroids: &'a [f64],
}

impl Vectorized<f64> for Closest<'_> {
    type Output = (Vec<usize>, f64);
    #[inline(always)]
    fn run<L: Lane<f64>>(self) -> (Vec<usize>, f64) {
        let Cloud { columns, len } = self.cloud;
        let d = columns.len();
        let mut closest = vec![0; columns[0].len()];
        let (mut indices, mut distances) = ([0.0; PADDING], [0.0; PADDING]);
        let mut total = 0.0;
        for first in (0..*len).step_by(L::N) {
            let (mut least, mut index) = (L::lit(f64::INFINITY), L::zero());
            for (k, centroid) in self.centroids.chunks_exact(d).enumerate() {
                let mut distance = L::zero();
                for i in 0..d {
                    let gap = L::load(&columns[i][first..]) - L::splat(centroid[i]);
                    distance = gap.fma(gap, distance);
                }
                let closer = distance.lt(least);
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

/// The cost where the closest centroid of each point is known.
struct Assigned<'a> {
    cloud: &'a Cloud,
    closest: &'a [usize],
}

impl Function for Assigned<'_> {
    fn eval<R: Real>(&self, centroids: &[R]) -> R {
        let Cloud { columns, len } = self.cloud;
        let d = columns.len();
        let mut gaps = Vec::with_capacity(d * len);
        for point in 0..*len {
            let centroid = &centroids[d * self.closest[point]..][..d];
            for i in 0..d {
                gaps.push(R::lit(columns[i][point]) - centroid[i]);
            }
        }
        R::dot(&gaps, &gaps)
    }
}

/// The step of Newton's method, its sign reversed: the Hessian is diagonal, so that its product with
/// ones is all of it.
fn direction(cloud: &Cloud, centroids: &[f64]) -> Vec<f64> {
    let (closest, _) = f64::vectorize(Closest { cloud, centroids });
    let cost = Assigned {
        cloud,
        closest: &closest,
    };
    let ones = vec![1.0; centroids.len()];
    let (gradient, diagonal) = hessian_vector(&cost, centroids, &ones);
    gradient.iter().zip(diagonal).map(|(g, h)| g / h).collect()
}

/// Functions `cost` and `dir`.
///
/// # Errors
/// If there is no such function, or the input is not in its format.
pub fn prepare(function: &str, input: &RawValue) -> Prepared {
    let Input { points, centroids } = read(input)?;
    let d = points.first().map_or(0, Vec::len);
    require(
        d > 0 && !centroids.is_empty(),
        "one point at least, and one centroid",
    )?;
    flat(&points, d, "the points differ in length")?;
    let centroids = flat(&centroids, d, "centroids and points differ in length")?;
    let cloud = Cloud::new(&points);
    match function {
        "cost" => work(move || {
            let (cloud, centroids) = (&cloud, &centroids[..]);
            f64::vectorize(Closest { cloud, centroids }).1
        }),
        "dir" => work(move || {
            let rows = direction(&cloud, &centroids);
            rows.chunks(d).map(<[f64]>::to_vec).collect::<Vec<_>>()
        }),
        _ => Err(Refusal::Function(function.to_owned())),
    }
}
