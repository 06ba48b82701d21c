//! Hand tracking. The residuals are the differences between measured points and points on the skin of a posed hand.
//!
//! In a complicated problem, the places of the points on their triangles are unknown, too. A residual depends only on the
//! place of its own point. So one direction moves the places of all points at once (column compression).

use autodiff::{Real, jacobian};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::rotation;
use super::work::{Error, Prepared, flat, read, require, work};

/// The number of bones: a wrist, five fingers of four bones, and a forearm.
const BONES: usize = 22;
/// The number of bones of a finger. It is also the number of angles of a finger.
const JOINTS: usize = 4;
/// The number of pose parameters for the rotation and translation of the whole hand.
const GLOBAL: usize = 6;
/// The number of pose parameters: those of the whole hand, then four angles for each of the five fingers.
const THETA: usize = GLOBAL + JOINTS * 5;
/// The length below which a rotation vector is taken to be no rotation.
const NO_ROTATION: f64 = 1e-4;

/// The input from GradBench. If `us` is empty, each measured point corresponds to a vertex. Otherwise it corresponds to
/// a point on a triangle.
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

/// A problem whose input has been checked.
struct Hand {
    model: Model,
    targets: Vec<Target>,
    /// The arguments of the residuals.
    x: Vec<f64>,
}

/// A measured point, and the three vertices that define the corresponding point of the skin, `u1 a + u2 b + (1 - u1 -
/// u2) c`.
struct Target {
    point: [f64; 3],
    /// The indices of the vertices `a`, `b` and `c`.
    corners: [usize; 3],
    /// The numbers `u1` and `u2`.
    u: [f64; 2],
}

/// An affine transformation of space, as the three upper rows of a homogeneous matrix.
#[derive(Clone, Copy)]
struct Affine<R>([[R; 4]; 3]);

impl<R: Real> Affine<R> {
    fn constant([x, y, z, _]: Matrix) -> Self {
        Self([x, y, z].map(|row| row.map(R::lit)))
    }

    /// Returns the transformation that applies `first`, then `self`.
    fn after(&self, first: &Self) -> Self {
        let [a, b, c] = first.0;
        Self(self.0.map(|[x, y, z, shift]| {
            let mut row = [0, 1, 2, 3].map(|k| x * a[k] + y * b[k] + z * c[k]);
            row[3] += shift;
            row
        }))
    }

    /// Returns the image of a point.
    fn apply(&self, point: [R; 3]) -> [R; 3] {
        let image =
            |[x, y, z, shift]: [R; 4]| x.fma(point[0], y.fma(point[1], z.fma(point[2], shift)));
        self.0.map(image)
    }

    /// Returns the rotation about x by the angle `a`, then about z by the angle `b`.
    fn turn(a: R, b: R) -> Self {
        let ([sa, ca], [sb, cb]) = ([a.sin(), a.cos()], [b.sin(), b.cos()]);
        let o = R::zero();
        Self([
            [cb, -sb * ca, sb * sa, o],
            [sb, cb * ca, -cb * sa, o],
            [o, sa, ca, o],
        ])
    }

    /// Returns the rotation and translation of the whole hand.
    fn of_hand(theta: &[R]) -> Self {
        let r = [theta[0], theta[1], theta[2]];
        let small = R::dot(&r, &r).sqrt().less(R::lit(NO_ROTATION));
        let columns = [0, 1, 2].map(|column| {
            let unit = [0, 1, 2].map(|row| R::lit(f64::from(u8::from(row == column))));
            let turned = rotation::rotate(r, unit);
            [0, 1, 2].map(|row| R::select(small, unit[row], turned[row]))
        });
        let [x, y, z] = columns;
        Self([0, 1, 2].map(|row| [x[row], y[row], z[row], theta[3 + row]]))
    }
}

impl Hand {
    fn new(input: Input) -> Result<Self, Error> {
        let complicated = !input.us.is_empty();
        let (targets, model) = (input.targets()?, input.data.model);
        model.check()?;
        let shifts = if complicated { 2 } else { 0 };
        Ok(Self {
            model,
            targets,
            x: [&vec![0.0; shifts][..], &input.theta].concat(),
        })
    }

    /// Returns the residuals. In a complicated problem, `x` begins with two numbers that are added to `u1` and `u2` of all
    /// points. Then follows `theta`.
    fn residuals<R: Real>(&self, x: &[R]) -> Vec<R> {
        let (shifts, theta) = x.split_at(x.len() - THETA);
        let skin = self.model.skin(theta);
        let shift = |k: usize| shifts.get(k).copied().unwrap_or(R::zero());
        let gap = |target: &Target| {
            let [u1, u2] = [0, 1].map(|k| R::lit(target.u[k]) + shift(k));
            let u3 = R::one() - u1 - u2;
            let [a, b, c] = target.corners.map(|corner| skin[corner]);
            let on_skin = |i: usize| u1 * a[i] + u2 * b[i] + u3 * c[i];
            [0, 1, 2].map(|i| R::lit(target.point[i]) - on_skin(i))
        };
        self.targets.iter().flat_map(gap).collect()
    }

    fn jacobian(&self) -> Vec<Vec<f64>> {
        let rows = jacobian(|x| self.residuals(x), &self.x);
        rows.iter().map(<[f64]>::to_vec).collect()
    }
}

impl Model {
    /// Returns the vertices of the posed hand.
    fn skin<R: Real>(&self, theta: &[R]) -> Vec<[R; 3]> {
        let (hand, bones) = (Affine::of_hand(theta), self.bones(&theta[GLOBAL..]));
        let vertex = |(&[x, y, z, _], weights): (&[f64; 4], &Vec<f64>)| {
            let (rest, mut place) = ([x, y, z].map(R::lit), [R::zero(); 3]);
            // Most bones do not move a vertex.
            for (bone, &weight) in bones.iter().zip(weights).filter(|(_, w)| **w != 0.0) {
                let moved = bone.apply(rest);
                for i in 0..3 {
                    place[i] = moved[i].fma(R::lit(weight), place[i]);
                }
            }
            hand.apply(place)
        };
        let vertices = self.base_positions.iter().zip(&self.weights);
        vertices.map(vertex).collect()
    }

    /// Returns the transformations of all bones from their places at rest.
    fn bones<R: Real>(&self, angles: &[R]) -> Vec<Affine<R>> {
        let mut absolute: Vec<Affine<R>> = Vec::with_capacity(BONES);
        for (i, &relative) in self.base_relatives.iter().enumerate() {
            let mut bone = Affine::constant(relative);
            // No angle moves the wrist, the first bone of each finger and the forearm.
            if let Some(before) = i.checked_sub(1)
                && before % JOINTS > 0
            {
                let own = &angles[before / JOINTS * JOINTS..][..JOINTS];
                bone = bone.after(&match before % JOINTS {
                    1 => Affine::turn(own[0], own[1]),
                    joint => Affine::turn(own[joint], R::zero()),
                });
            }
            if let Ok(parent) = usize::try_from(self.parents[i]) {
                bone = absolute[parent].after(&bone);
            }
            absolute.push(bone);
        }
        let pairs = absolute.iter().zip(&self.inverse_base_absolutes);
        let moves = pairs.map(|(bone, &inverse)| {
            let mut moves = bone.after(&Affine::constant(inverse));
            if self.is_mirrored {
                moves.0[0] = moves.0[0].map(|entry| -entry);
            }
            moves
        });
        moves.collect()
    }

    fn check(&self) -> Result<(), Error> {
        let matrices = [&self.base_relatives, &self.inverse_base_absolutes];
        let fits = matrices.iter().all(|list| list.len() == BONES) && self.parents.len() == BONES;
        require(
            fits,
            "a hand must have 22 bones, each with two matrices and a parent",
        )?;
        let mut parents = (0..).zip(&self.parents);
        require(
            parents.all(|(bone, &parent)| parent < bone),
            "each bone must come after its parent",
        )?;
        let mut all = matrices.into_iter().flatten();
        require(
            all.all(|matrix| matrix[3] == [0.0, 0.0, 0.0, 1.0]),
            "the last row of a transformation must be 0 0 0 1",
        )?;
        require(
            self.base_positions.iter().all(|vertex| vertex[3] == 1.0),
            "each vertex must be `x y z 1`",
        )?;
        let what = "each vertex must have one weight for each of the 22 bones";
        require(self.weights.len() == self.base_positions.len(), what)?;
        flat(&self.weights, BONES, what).map(drop)
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
            points.len() == count && count > 0 && [0, count].contains(&self.us.len()),
            "there must be one point for each correspondence, at least one correspondence, and in `us` no entry or one for \
             each correspondence",
        )?;
        let target = |(i, &index): (usize, &usize)| {
            let corners = match self.us.is_empty() {
                true => Some([index; 3]),
                false => model.triangles.get(index).copied(),
            };
            let corners = corners.filter(|corners| corners.iter().all(|&corner| corner < vertices));
            Ok(Target {
                point: points[i],
                corners: corners
                    .ok_or_else(|| Error::Shape(format!("unknown vertex or triangle {index}")))?,
                u: self.us.get(i).copied().unwrap_or([1.0, 0.0]),
            })
        };
        correspondences.iter().enumerate().map(target).collect()
    }
}

pub(super) fn prepare(function: &str, input: &RawValue) -> Prepared {
    let hand = Hand::new(read(input)?)?;
    match function {
        "objective" => work(move || hand.residuals(&hand.x)),
        "jacobian" => work(move || hand.jacobian()),
        _ => Error::function(function),
    }
}
