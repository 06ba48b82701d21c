//! Gradients of the loss with respect to the design and to the controller.

use std::sync::Arc;

use autodiff::{Real, Var};
use autodiff_programs::CotangentBound;

use super::schedule::Schedule;
use super::slope::{GradientPoint, Slope};
use crate::design::{Design, Mixture};
use crate::inputs::{CONTROLLER, DESIGN, InputBlock, NOTHING};
use crate::judge::Evaluator;
use crate::objective::{AnyLoss, LossOf, walks};
use crate::projection::Projection;
use crate::scene::{GradientPrecision, GradientSettings, MovedBody};
use crate::world::{Span, Variation, World, together};

/// The variables that the loss is differentiated with respect to.
#[derive(Clone, Copy)]
pub enum Variables<'a> {
    /// The design vectors. The given projection is applied to them.
    Design(Projection),
    /// The shares of the materials in each edge of a layout. They are the design vectors of the layout (D7).
    Shares,
    /// The controller of a robot that has this design.
    Controller(&'a Design<Mixture<f64>>),
    /// No variable: only the loss is computed, for a robot that has this design.
    Nothing(&'a Design<Mixture<f64>>),
}

impl Variables<'_> {
    pub(super) fn blocks(&self) -> &'static [InputBlock] {
        match self {
            Self::Design(_) | Self::Shares => DESIGN,
            Self::Controller(_) => CONTROLLER,
            Self::Nothing(_) => NOTHING,
        }
    }

    /// The design that is simulated for the design vectors `z`. For [`Shares`](Self::Shares), `z` is treated as an
    /// undecided design, whose void edges keep their small stiffness.
    pub fn design<R: Real>(&self, world: &World, z: &[[R; 3]]) -> Design<Mixture<R>> {
        match self {
            Self::Design(projection) => {
                Design::Undecided(world.projector().mixtures(*projection, z))
            }
            Self::Shares => Design::of_shares(z),
            Self::Controller(design) | Self::Nothing(design) => design.lift(),
        }
    }
}

/// Rollouts whose mean speed exceeds this share of the speed bound are checked. Few walking robots are that fast: the
/// share is 1 m/s if the bound is 100 m/s.
const WALKS: f64 = 0.01;

impl Evaluator {
    /// The horizon of an iteration: the steps that the gradient is computed over, `first` steps after the
    /// start of the clock, and the bound on its cotangents.
    pub(super) fn horizon(&self, now: &Schedule, first: usize) -> Span {
        Span {
            first,
            cotangent_bound: self.cotangent_bound(),
            ..self.rollouts.observing(vec![now.horizon()])
        }
    }

    /// The bound on cotangents of the scene.
    pub(super) fn cotangent_bound(&self) -> Option<CotangentBound> {
        // The cotangent of a position is a loss per length.
        let per_length = self.unit() / self.world.lattice().scale;
        let bound = |norm: f64| CotangentBound {
            norm: norm * per_length,
            every: GradientSettings::COTANGENT_EVERY,
        };
        self.scene.gradient.cotangent_bound.map(bound)
    }

    /// The [unit of the loss](crate::objective::Loss::unit).
    pub(super) fn unit(&self) -> f64 {
        self.loss.unit(self.world.lattice().scale)
    }

    /// The gradients with respect to the design, through the performance projection and through the stability
    /// projection; `None` for a projection that has no share in the update. The two rollouts run in SIMD lanes on one
    /// thread if that is possible, otherwise on two threads.
    pub fn design_slopes(&self, at: &GradientPoint) -> [Option<Slope>; 2] {
        let both = [Projection::Performance, Projection::Stability].map(Variables::Design);
        let alone = |k: usize| {
            let [slope] = self.slopes([both[k]], at);
            Some(slope)
        };
        match self.scene.schedule.stability_share {
            0.0 => [alone(0), None],
            1.0 => [None, alone(1)],
            _ if together(2) == 2 => self.slopes(both, at).map(Some),
            _ => rayon::join(|| alone(0), || alone(1)).into(),
        }
    }

    /// Gradients of the loss, in the precision of the scene: means over the variations, or the gradients of the
    /// robot as designed if there are none. A gradient may overflow, in f32 sooner than in f64; the caller then skips the
    /// update.
    ///
    /// Several gradients in one call must all be with respect to the design, because their rollouts share the
    /// controller.
    ///
    /// A payload that sticks to the ground has a gradient of exactly zero, from which the optimisation could not get
    /// away. If that was so in the last passes, the gradients are therefore those of the centre of mass.
    pub fn slopes<const N: usize>(
        &self,
        variables: [Variables; N],
        at: &GradientPoint,
    ) -> [Slope; N] {
        let body = self.scene.objective.body;
        let mut slopes = self.slopes_of(body, variables, at);
        let may_stick = at.sticks && body == MovedBody::Payload && self.loss.is_far();
        if may_stick && slopes.iter().all(Slope::is_flat) {
            let of_mass = self.slopes_of(MovedBody::Mass, variables, at);
            for (slope, of_mass) in slopes.iter_mut().zip(of_mass) {
                (slope.gradient, slope.stuck) = (of_mass.gradient, true);
            }
        }
        slopes
    }

    /// The gradients of the loss of this part of the robot.
    fn slopes_of<const N: usize>(
        &self,
        body: MovedBody,
        variables: [Variables; N],
        at: &GradientPoint,
    ) -> [Slope; N] {
        let of_body;
        let world = if body == self.scene.objective.body {
            &self.world
        } else {
            of_body = self.world.with_moved(body);
            &of_body
        };
        at.means(world, |variation| match self.scene.gradient.precision {
            GradientPrecision::F64 => {
                self.differentiated::<f64, N>(world, &variables, at, variation)
            }
            GradientPrecision::F32 => {
                self.differentiated::<f32, N>(world, &variables, at, variation)
            }
        })
    }

    /// Returns `displacement`, which was reached in the rollout of a gradient, or NaN if the robot flew apart there.
    ///
    /// The rollout of a gradient does not check whether the robot flies apart. If the mean speed of the payload was
    /// high, the rollout is repeated with this check. Few walking robots are so fast, but all robots that fly apart
    /// are. With variations, the displacement is a mean and is not checked.
    pub(super) fn judged(
        &self,
        displacement: f64,
        variables: Variables,
        at: &GradientPoint,
    ) -> f64 {
        let physics = &self.scene.physics;
        let (Some(bound), []) = (physics.speed_bound, &at.variations[..]) else {
            return displacement;
        };
        let steps = at.horizon.steps().min(physics.steps);
        if displacement.abs() <= WALKS * bound * steps as f64 * physics.dt {
            return displacement;
        }
        let design = variables.design(&self.world, &at.inputs.z);
        let again = self
            .in_world(self.world.shortened(steps))
            .reached(&[design], &at.inputs.controller)[0];
        match again.along().is_nan() {
            true => f64::NAN,
            false => displacement,
        }
    }

    /// The gradients of one robot, computed in the number type `R`.
    fn differentiated<R: Real + Into<f64>, const N: usize>(
        &self,
        world: &World,
        variables: &[Variables; N],
        at: &GradientPoint,
        variation: &Variation,
    ) -> [Slope; N]
    where
        dyn AnyLoss: LossOf<Var<R>>,
    {
        let mut displacements = [f64::NAN; N];
        let in_type = at.inputs.lift::<R>();
        let found = in_type.differentiate_copies(variables[0].blocks(), |copies: &[_; N]| {
            let controller = Arc::new(copies[0].controller.clone());
            let robots: [_; N] = std::array::from_fn(|k| {
                let design = variables[k].design(world, &copies[k].z);
                world.varied(&design, &controller, variation)
            });
            let seen = walks(world, &robots, &*self.loss, &at.horizon);
            std::array::from_fn(|k| {
                displacements[k] = self.between(&variation.start, &seen[k]).forward();
                self.loss.loss_of(&seen[k])
            })
        });
        std::array::from_fn(|k| {
            let (loss, gradient) = &found[k];
            Slope {
                displacement: displacements[k],
                ..Slope::of((*loss).into(), gradient, self.unit())
            }
        })
    }
}
