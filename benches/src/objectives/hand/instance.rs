//! The data of a hand-tracking problem: the hand at rest, and the measured points.

use serde::Deserialize;

use super::affine::Affine;
use crate::objectives::work::{Error, flat, require};

/// The number of bones: a wrist, five fingers of four bones, and a forearm.
pub(super) const BONES: usize = 22;
pub(super) const FINGERS: usize = 5;
/// The number of bones of a finger. It is also the number of angles of a finger.
pub(super) const JOINTS: usize = 4;
/// The number of pose parameters for the rotation and translation of the whole hand.
pub(super) const GLOBAL: usize = 6;
/// The number of pose parameters: those of the whole hand, then four angles per finger.
pub(super) const THETA: usize = GLOBAL + JOINTS * FINGERS;
/// Lists are padded to a multiple of this length, which is the largest number of lanes in any register.
const PADDING: usize = 16;

/// The input from GradBench. If `us` is empty, each measured point corresponds to a vertex. Otherwise it corresponds to
/// a point on a triangle.
#[derive(Deserialize)]
pub(crate) struct Input {
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

/// A 4x4 matrix, row by row.
type Matrix = [[f64; 4]; 4];

/// The hand at rest.
#[derive(Deserialize)]
struct Model {
    parents: Vec<i64>,
    base_relatives: Vec<Matrix>,
    inverse_base_absolutes: Vec<Matrix>,
    base_positions: Vec<[f64; 4]>,
    weights: Vec<Vec<f64>>,
    triangles: Vec<[usize; 3]>,
    is_mirrored: bool,
}

/// The data of a problem, arranged so that lanes can load them.
pub(super) struct Instance {
    pub(super) theta: [f64; THETA],
    pub(super) targets: Vec<Target>,
    /// Whether the Jacobian also has derivatives with respect to the positions of the points on their triangles.
    pub(super) complicated: bool,
    pub(super) bones: Vec<Bone>,
    pub(super) mirrored: bool,
    /// The number of vertices, without the padding.
    pub(super) len: usize,
    /// The coordinates of the vertices, in a list for each coordinate. Lists are padded to whole registers.
    pub(super) vertices: [Vec<f64>; 3],
    /// For each bone, its weight for every vertex, padded to whole registers.
    pub(super) weights: Vec<Vec<f64>>,
}

/// A bone of the hand at rest.
pub(super) struct Bone {
    pub(super) parent: Option<usize>,
    /// The transformation from the bone to its parent.
    pub(super) relative: Affine<f64>,
    /// The inverse of the bone's absolute transformation.
    pub(super) inverse_rest: Affine<f64>,
}

/// A measured point, and the three vertices that define the corresponding point of the skin, `u1 a + u2 b + (1 - u1 -
/// u2) c`.
pub(super) struct Target {
    pub(super) point: [f64; 3],
    /// The indices of the vertices `a`, `b` and `c`.
    pub(super) corners: [usize; 3],
    /// The numbers `u1` and `u2`.
    pub(super) u: [f64; 2],
}

impl Instance {
    pub(super) fn new(input: Input) -> Result<Self, Error> {
        let (targets, complicated) = (input.targets()?, !input.us.is_empty());
        let Model {
            base_positions,
            weights,
            ..
        } = &input.data.model;
        let homogeneous = base_positions.iter().all(|position| position[3] == 1.0);
        require(homogeneous, "each vertex must be `x y z 1`")?;
        require(
            weights.len() == base_positions.len(),
            "there must be one row of weights for each vertex",
        )?;
        flat(
            weights,
            BONES,
            "each vertex must have one weight for each of the 22 bones",
        )?;
        let column = |i: usize| padded(base_positions.iter().map(|position| position[i]));
        let weight = |bone: usize| padded(weights.iter().map(|weights| weights[bone]));
        Ok(Self {
            theta: input.theta,
            targets,
            complicated,
            bones: input.data.model.bones()?,
            mirrored: input.data.model.is_mirrored,
            len: base_positions.len(),
            vertices: [column(0), column(1), column(2)],
            weights: (0..BONES).map(weight).collect(),
        })
    }
}

impl Input {
    fn targets(&self) -> Result<Vec<Target>, Error> {
        let Data {
            model,
            correspondences,
            points,
        } = &self.data;
        let (count, vertices) = (correspondences.len(), model.base_positions.len());
        require(
            points.len() == count && count > 0,
            "there must be one point for each correspondence, and at least one correspondence",
        )?;
        let places = self.us.is_empty() || self.us.len() == count;
        require(
            places,
            "`us` must be empty or have one entry for each correspondence",
        )?;
        let target = |i: usize| {
            let index = correspondences[i];
            let triangle = model.triangles.get(index).copied();
            let corners = if self.us.is_empty() {
                Some([index; 3])
            } else {
                triangle
            };
            let corners = corners.filter(|corners| corners.iter().all(|&corner| corner < vertices));
            Ok(Target {
                point: points[i],
                corners: corners
                    .ok_or_else(|| Error::Shape(format!("unknown vertex or triangle {index}")))?,
                u: self.us.get(i).copied().unwrap_or([1.0, 0.0]),
            })
        };
        (0..count).map(target).collect()
    }
}

impl Model {
    fn bones(&self) -> Result<Vec<Bone>, Error> {
        let matrices = [&self.base_relatives, &self.inverse_base_absolutes];
        let fits = matrices.iter().all(|list| list.len() == BONES) && self.parents.len() == BONES;
        require(
            fits,
            "a hand must have 22 bones, each with two matrices and a parent",
        )?;
        let bone = |i: usize| {
            let parent = usize::try_from(self.parents[i]).ok();
            require(
                parent.is_none_or(|parent| parent < i),
                "each bone must come after its parent",
            )?;
            Ok(Bone {
                parent,
                relative: affine(&self.base_relatives[i])?,
                inverse_rest: affine(&self.inverse_base_absolutes[i])?,
            })
        };
        (0..BONES).map(bone).collect()
    }
}

/// Returns the upper three rows of a matrix as an affine transformation.
fn affine(matrix: &Matrix) -> Result<Affine<f64>, Error> {
    let [x, y, z, last] = *matrix;
    require(
        last == [0.0, 0.0, 0.0, 1.0],
        "the last row of a transformation must be 0 0 0 1",
    )?;
    Ok(Affine([x, y, z]))
}

fn padded(numbers: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.resize(numbers.len().next_multiple_of(PADDING), 0.0);
    numbers
}
