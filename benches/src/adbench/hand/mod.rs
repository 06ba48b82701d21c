//! Hand tracking: how far a posed hand's skin is from measured points.
//!
//! A bone moves with the four angles of its own finger alone. So four directions serve all
//! fingers at once (column compression), and a vertex, to which every bone contributes, has the
//! sum of the palm's and five fingers' parts, each with four directions of its own.

mod lanes;
mod model;
mod skin;
mod transform;

use std::path::Path;

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Dual, Real};
use serde_json::{Value, json};

use self::lanes::{Pose, PoseDerivatives, ResidualDerivatives, Residuals, Skin};
pub use self::model::{BONES, Bone, HandModel, Vertex};
use self::skin::{FINGERS, GLOBAL, JOINTS};
pub use self::skin::{THETA, Target};
pub use self::transform::Affine;
use super::input::{self, Error, Tokens};
use super::{Problem, rotation};

/// Below this length a rotation vector turns nothing.
const NO_ROTATION: f64 = 1e-4;

/// An instance, with memory for its results.
pub struct Hand {
    model: HandModel,
    theta: [f64; THETA],
    targets: Vec<Target>,
    skin: Skin,
    residuals: Vec<f64>,
    /// Row by row.
    jacobian: Vec<f64>,
}

impl Hand {
    /// Reads an instance and the model in `model`, a folder. The form is complicated where
    /// the file holds a `u1 u2` for each correspondence.
    ///
    /// # Errors
    /// If a file cannot be read or is not in the format.
    pub fn read(path: &Path, model: &Path) -> Result<Self, Error> {
        let model = HandModel::read(model)?;
        let text = input::read(path)?;
        let numbers = text.split_ascii_whitespace().count();
        let mut tokens = Tokens::new(path, &text);
        let (count, theta): (usize, usize) = (tokens.count()?, tokens.next()?);
        if theta != THETA {
            return Err(tokens.error(format!("a hand has {THETA} parameters, not {theta}")));
        }
        let barycentric = numbers == 2 + 6 * count + THETA;
        let mut targets = Vec::new();
        for _ in 0..count {
            let index: usize = tokens.next()?;
            let corners = if barycentric {
                model.triangles.get(index).copied()
            } else {
                (index < model.len).then_some([index; 3])
            };
            let missing = || tokens.error(format!("the model has no vertex or triangle {index}"));
            targets.push(Target {
                corners: corners.ok_or_else(missing)?,
                point: tokens.array()?,
                u: [1.0, 0.0],
            });
        }
        if barycentric {
            for target in &mut targets {
                target.u = tokens.array()?;
            }
        }
        let theta = tokens.array()?;
        tokens.end()?;
        Ok(Self::new(model, theta, targets, barycentric))
    }

    /// An instance; derivatives are by the targets' places on their triangles too where the form is
    /// complicated.
    ///
    /// # Panics
    /// If the model has no vertex that a target names.
    pub fn new(
        model: HandModel,
        theta: [f64; THETA],
        targets: Vec<Target>,
        complicated: bool,
    ) -> Self {
        let mut corners = targets.iter().flat_map(|target| target.corners);
        assert!(corners.all(|corner| corner < model.len));
        let room = || [(); 3].map(|()| vec![0.0; model.vertices[0].len()]);
        let columns = if complicated { 2 + THETA } else { THETA };
        Self {
            skin: Skin {
                places: room(),
                derivatives: (0..THETA).map(|_| room()).collect(),
            },
            residuals: vec![0.0; 3 * targets.len()],
            jacobian: vec![0.0; columns * 3 * targets.len()],
            model,
            theta,
            targets,
        }
    }

    /// The residuals that were found last, three a target.
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// The rows of the Jacobian that was found last.
    pub fn rows(&self) -> Vec<&[f64]> {
        let columns = self.jacobian.len() / self.residuals.len().max(1);
        self.jacobian.chunks(columns.max(1)).collect()
    }
}

impl Problem for Hand {
    fn objective(&mut self) {
        let (global_theta, angles) = self.theta.split_at(GLOBAL);
        let model = &self.model;
        f64::vectorize(Pose {
            model,
            bones: &f64::vectorize(Bones { model, angles }),
            global: &global(global_theta),
            skin: &mut self.skin,
        });
        f64::vectorize(Residuals {
            targets: &self.targets,
            skin: &self.skin,
            residuals: &mut self.residuals,
        });
    }

    fn derivative(&mut self) {
        let (global_theta, angles) = self.theta.split_at(GLOBAL);
        let global_theta: Vec<Dual<f64, GLOBAL>> = seeded(global_theta);
        let angles: Vec<Dual<f64, JOINTS>> = angles.chunks(JOINTS).flat_map(seeded).collect();
        let (model, angles) = (&self.model, &angles);
        f64::vectorize(PoseDerivatives {
            model,
            bones: &f64::vectorize(Bones { model, angles }),
            global: &global(&global_theta),
            skin: &mut self.skin,
        });
        f64::vectorize(ResidualDerivatives {
            targets: &self.targets,
            skin: &self.skin,
            residuals: &mut self.residuals,
            jacobian: &mut self.jacobian,
        });
    }

    fn answer(&self) -> Value {
        json!({ "objective": self.residuals, "jacobian": self.rows() })
    }
}

/// Numbers that are variables, each along a direction of its own.
fn seeded<const N: usize>(numbers: &[f64]) -> Vec<Dual<f64, N>> {
    let numbers = numbers.iter().enumerate();
    numbers.map(|(i, &x)| Dual::variable(x, i)).collect()
}

/// The transformations of all bones, given the angles of the fingers. One bone hangs on another,
/// so lanes have nothing to do here; what helps is the instruction set that they are entered with.
struct Bones<'a, R> {
    model: &'a HandModel,
    angles: &'a [R],
}

impl<R: Real> Vectorized<f64> for Bones<'_, R> {
    type Output = Vec<Affine<R>>;
    #[inline(always)]
    fn run<L: Lane<f64>>(self) -> Vec<Affine<R>> {
        let bones = &self.model.bones;
        let mut absolute: Vec<Affine<R>> = Vec::with_capacity(bones.len());
        let mut transforms = Vec::with_capacity(bones.len());
        for (i, bone) in bones.iter().enumerate() {
            let local = Affine::euler(euler(i, self.angles));
            let relative = bone.relative.map(R::lit).after(&local);
            let here = match bone.parent {
                Some(parent) => absolute[parent].after(&relative),
                None => relative,
            };
            let transform = here.after(&bone.inverse_rest.map(R::lit));
            transforms.push(if self.model.mirrored {
                transform.mirrored()
            } else {
                transform
            });
            absolute.push(here);
        }
        transforms
    }
}

/// The angles of a bone about x, y and z.
#[inline(always)]
fn euler<R: Real>(bone: usize, angles: &[R]) -> [R; 3] {
    let zero = R::zero();
    let Some(joint) = bone.checked_sub(1).filter(|at| *at < JOINTS * FINGERS) else {
        return [zero; 3];
    };
    let angles = &angles[joint / JOINTS * JOINTS..][..JOINTS];
    match joint % JOINTS {
        1 => [angles[0], zero, angles[1]],
        2 => [angles[2], zero, zero],
        3 => [angles[3], zero, zero],
        _ => [zero; 3],
    }
}

/// The rotation matrix and the translation of the whole hand.
fn global<R: Real>(theta: &[R]) -> Affine<R> {
    let r = [theta[0], theta[1], theta[2]];
    let small = (r[0] * r[0] + r[1] * r[1] + r[2] * r[2])
        .sqrt()
        .less(R::lit(NO_ROTATION));
    let mut matrix = [[R::zero(); 4]; 3];
    for column in 0..3 {
        let mut unit = [R::zero(); 3];
        unit[column] = R::one();
        let turned = rotation::rotate(r, unit);
        for row in 0..3 {
            matrix[row][column] = R::select(small, unit[row], turned[row]);
        }
    }
    for row in 0..3 {
        matrix[row][3] = theta[3 + row];
    }
    Affine(matrix)
}
