//! Whether a robot moves in a plane or in space, and how lists of its points become lists of numbers.

use autodiff::Real;
use autodiff_programs::Compiled;
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use super::vector::Vector;

/// The components of a point in a file: two, or three in space.
pub type Row = SmallVec<[f64; 3]>;

/// The directions in which a robot moves. In files, it is the number of components of a vector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(into = "usize", try_from = "usize")]
pub enum Dimension {
    /// In the vertical plane: along the ground, and above it. In files and arrays, points have two numbers.
    #[default]
    Plane,
    /// In space: along the ground, across, and above it.
    Space,
}

impl Dimension {
    /// The number of components of a vector: 2 or 3.
    pub const fn count(self) -> usize {
        self.axes().len()
    }

    /// The components of a [`Vector`] that may differ from 0.
    const fn axes(self) -> &'static [usize] {
        match self {
            Self::Plane => &[0, 2],
            Self::Space => &[0, 1, 2],
        }
    }

    /// Applies a function to the components of a vector.
    #[must_use]
    pub fn map<T: Copy>(self, mut vector: Vector<T>, mut of: impl FnMut(T) -> T) -> Vector<T> {
        for &k in self.axes() {
            vector.0[k] = of(vector.0[k]);
        }
        vector
    }

    /// The vector without the component across if this is the plane.
    #[must_use]
    pub fn onto<R: Real>(self, vector: Vector<R>) -> Vector<R> {
        match self {
            Self::Plane => vector.with_sideways(R::zero()),
            Self::Space => vector,
        }
    }

    /// The length of the part of a vector along the ground. Where that part is zero, the derivative is 0.
    pub fn norm_along<R: Real>(self, vector: Vector<R>) -> R {
        match self {
            Self::Plane => vector.forward().abs(),
            Self::Space => vector.norm_along(),
        }
    }

    /// The unit vectors along the axes.
    pub fn unit_vectors(self) -> Vec<Vector<f64>> {
        let all = Vector::axes();
        self.axes().iter().map(|&k| all[k]).collect()
    }

    /// The components of a vector.
    pub fn components<T: Copy>(self, vector: Vector<T>) -> impl Iterator<Item = T> {
        self.axes().iter().map(move |&k| vector.0[k])
    }

    /// The components of a vector, as a list of numbers.
    pub fn list<T: Copy>(self, vector: Vector<T>) -> Vec<T> {
        self.components(vector).collect()
    }

    /// The vector with these components.
    ///
    /// # Panics
    /// If the number of components is wrong.
    pub fn vector<R: Real>(self, components: &[R]) -> Vector<R> {
        assert_eq!(components.len(), self.count(), "the number of components");
        let mut vector = Vector::zero();
        for (&k, &component) in self.axes().iter().zip(components) {
            vector.0[k] = component;
        }
        vector
    }

    /// The components of points in one list, as columns: the first components of all points, then the second components, and
    /// so on.
    pub fn columns<T: Copy>(self, points: &[Vector<T>]) -> Vec<T> {
        let axes = self.axes().iter();
        axes.flat_map(|&k| points.iter().map(move |point| point.0[k]))
            .collect()
    }

    /// The inverse of [`columns`](Self::columns).
    pub fn from_columns<R: Real>(self, columns: &[R]) -> Vec<Vector<R>> {
        let count = columns.len() / self.count();
        let mut points = vec![Vector::zero(); count];
        for (&k, column) in self.axes().iter().zip(columns.chunks_exact(count.max(1))) {
            for (point, &number) in points.iter_mut().zip(column) {
                point.0[k] = number;
            }
        }
        points
    }

    /// The components of points in one list, point by point.
    pub fn flat<T: Copy>(self, points: &[Vector<T>]) -> Vec<T> {
        let points = points.iter();
        points.flat_map(|&point| self.components(point)).collect()
    }

    /// The inverse of [`flat`](Self::flat).
    pub fn from_flat<R: Real>(self, numbers: &[R]) -> Vec<Vector<R>> {
        let rows = numbers.chunks_exact(self.count());
        rows.map(|row| self.vector(row)).collect()
    }

    /// The components of each point, as in files.
    pub fn rows(self, points: &[Vector<f64>]) -> Vec<Row> {
        let points = points.iter();
        points
            .map(|&point| self.components(point).collect())
            .collect()
    }

    /// The dimension of points with these components.
    ///
    /// # Errors
    /// If not all points have two components, or all three.
    pub fn of_rows<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Result<Self, String> {
        let mut counts = rows.into_iter().map(|row| row.len());
        let first = counts.next().unwrap_or(2);
        match counts.find(|&count| count != first) {
            Some(count) => Err(format!(
                "expected {first} numbers for every point, found {count}"
            )),
            None => Self::try_from(first)
                .map_err(|_| format!("expected points of 2 or 3 numbers, found {first}")),
        }
    }

    /// Replaces points by the points whose numbers are in one list, point by point.
    ///
    /// # Panics
    /// If the list has another length.
    pub fn fill<R: Real>(self, points: &mut [Vector<R>], numbers: &[R]) {
        let given = self.from_flat(numbers);
        assert_eq!(given.len(), points.len(), "the number of points");
        points.copy_from_slice(&given);
    }
}

impl From<Dimension> for usize {
    fn from(dimension: Dimension) -> Self {
        dimension.count()
    }
}

impl TryFrom<usize> for Dimension {
    type Error = String;

    fn try_from(count: usize) -> Result<Self, String> {
        match count {
            2 => Ok(Self::Plane),
            3 => Ok(Self::Space),
            _ => Err(format!("expected 2 or 3, found {count}")),
        }
    }
}

impl Vector<f64> {
    /// The components as text: two if the one across is 0, otherwise three.
    pub fn shown(self) -> String {
        format!("{:?}", self.dimension().list(self))
    }

    /// The plane if the component across is 0, otherwise space.
    pub fn dimension(self) -> Dimension {
        match self.sideways() {
            0.0 => Dimension::Plane,
            _ => Dimension::Space,
        }
    }
}

/// The components of vectors, one array or number for each: two for a planar robot, three in space.
#[derive(Clone, Copy, Debug)]
pub enum Axes<A> {
    /// Forward and up.
    Plane([A; 2]),
    /// Forward, sideways and up.
    Space([A; 3]),
}

impl<A> Axes<A> {
    /// The components, each of which is `of(k)` for its number `k`.
    pub fn from_fn(dimension: Dimension, of: impl FnMut(usize) -> A) -> Self {
        match dimension {
            Dimension::Plane => Self::Plane(std::array::from_fn(of)),
            Dimension::Space => Self::Space(std::array::from_fn(of)),
        }
    }

    /// The dimension of the vectors.
    pub fn dimension(&self) -> Dimension {
        match self {
            Self::Plane(_) => Dimension::Plane,
            Self::Space(_) => Dimension::Space,
        }
    }

    /// The components in order.
    pub fn as_slice(&self) -> &[A] {
        match self {
            Self::Plane(axes) => axes,
            Self::Space(axes) => axes,
        }
    }
}

impl<A: Copy> Axes<A> {
    /// The `D` components.
    ///
    /// # Panics
    /// If the vectors have another number of components.
    pub fn array<const D: usize>(self) -> [A; D] {
        let axes = self.as_slice();
        axes.try_into()
            .unwrap_or_else(|_| panic!("vectors have {} components, not {D}", axes.len()))
    }

    /// The vector of the `D` components.
    ///
    /// # Panics
    /// If the vectors have another number of components.
    pub fn vector<const D: usize>(self) -> Vector<A, D> {
        Vector::new(self.array())
    }

    /// Applies a function to every component.
    pub fn map<B>(self, of: impl FnMut(A) -> B) -> Axes<B> {
        match self {
            Self::Plane(axes) => Axes::Plane(axes.map(of)),
            Self::Space(axes) => Axes::Space(axes.map(of)),
        }
    }

    /// Applies a function to the components of two vectors in pairs.
    ///
    /// # Panics
    /// If the vectors have different numbers of components.
    pub fn zip_with<B: Copy, C>(self, other: Axes<B>, mut of: impl FnMut(A, B) -> C) -> Axes<C> {
        assert_eq!(
            self.dimension(),
            other.dimension(),
            "vectors of different dimensions"
        );
        Axes::from_fn(self.dimension(), |k| {
            of(self.as_slice()[k], other.as_slice()[k])
        })
    }
}

impl<A> From<[A; 2]> for Axes<A> {
    fn from(axes: [A; 2]) -> Self {
        Self::Plane(axes)
    }
}

impl<A> From<[A; 3]> for Axes<A> {
    fn from(axes: [A; 3]) -> Self {
        Self::Space(axes)
    }
}

impl<A, const D: usize> From<Vector<A, D>> for Axes<A>
where
    Self: From<[A; D]>,
{
    fn from(vector: Vector<A, D>) -> Self {
        vector.array().into()
    }
}

/// Evaluates an expression with the constant `D` of the number of components of vectors: 2 or 3.
///
/// ```
/// use cosmic::geometry::{Axes, Dimension};
///
/// let axes: Axes<f64> = [1.0, 2.0, 3.0].into();
/// let sum: f64 = cosmic::in_dimension!(axes.dimension(), D => axes.array::<D>().iter().sum());
/// assert_eq!(sum, 6.0);
/// ```
#[macro_export]
macro_rules! in_dimension {
    ($dimension:expr, $D:ident => $body:expr) => {
        match $dimension {
            $crate::geometry::Dimension::Plane => {
                const $D: usize = 2;
                $body
            }
            $crate::geometry::Dimension::Space => {
                const $D: usize = 3;
                $body
            }
        }
    };
}

/// For what a kernel of an explicit step is compiled at most: registers of 512 bits are for robots in the plane, with the laws
/// of the scene `earth`. The program has 68 functions for them in place of 250.
pub(crate) const fn explicit_in(dimension: usize) -> Compiled {
    match dimension {
        2 => Compiled::Fully,
        _ => Compiled::Narrow,
    }
}

/// Implements a kernel for vectors of the plane, where the constant `D` is 2, and for vectors of space, where it is 3.
#[macro_export]
macro_rules! in_both_dimensions {
    ($D:ident => $($item:tt)*) => {
        const _: () = {
            const $D: usize = 2;
            $($item)*
        };
        const _: () = {
            const $D: usize = 3;
            $($item)*
        };
    };
}
