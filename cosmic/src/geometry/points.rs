//! Functions on lists of points: means and bounds.

use autodiff::Real;

use super::vector::Vector;

/// The mean of a list of points. A point may be given as an array of `D` numbers.
pub fn mean<R: Real, const D: usize>(points: &[impl Copy + Into<Vector<R, D>>]) -> Vector<R, D> {
    let share = R::lit(1.0 / points.len() as f64);
    let points: Vec<Vector<R, D>> = points.iter().map(|&point| point.into()).collect();
    Vector::from_fn(|k| R::sum_of(&column(&points, k)) * share)
}

/// The weighted mean of points.
pub(crate) fn weighted_mean<R: Real, const D: usize>(
    points: &[Vector<R, D>],
    weights: &[R],
) -> Vector<R, D> {
    let sum = R::sum_of(weights);
    Vector::from_fn(|k| R::dot(&column(points, k), weights) / sum)
}

/// Component `k` of all points.
fn column<T: Copy, const D: usize>(points: &[Vector<T, D>], k: usize) -> Vec<T> {
    points.iter().map(|point| point.0[k]).collect()
}

/// The smallest box with sides along the axes that contains a set of points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const D: usize = 3> {
    /// The least value of each component. If there are no points, all components are infinite.
    pub low: Vector<f64, D>,
    /// The greatest value of each component. If there are no points, all components are minus infinity.
    pub high: Vector<f64, D>,
}

impl<const D: usize> Bounds<D> {
    /// The smallest box that contains all given points.
    pub fn of(points: impl IntoIterator<Item = Vector<f64, D>>) -> Self {
        let none = Self {
            low: Vector([f64::INFINITY; D]),
            high: Vector([f64::NEG_INFINITY; D]),
        };
        points.into_iter().fold(none, |bounds, point| Self {
            low: bounds.low.zip_with(point, f64::min),
            high: bounds.high.zip_with(point, f64::max),
        })
    }

    /// The box with all sides moved outwards by a distance.
    #[must_use]
    pub fn widened(&self, by: f64) -> Self {
        Self {
            low: self.low.map(|x| x - by),
            high: self.high.map(|x| x + by),
        }
    }

    /// The lengths of the sides.
    pub fn size(&self) -> Vector<f64, D> {
        self.high - self.low
    }

    /// The middle of the box.
    pub fn centre(&self) -> Vector<f64, D> {
        (self.low + self.high) * 0.5
    }
}
