//! Runs a case.

use autodiff::Real;

use super::{Case, CaseResults, DesignGradient, Gradient};
use crate::design::{Design, Mixture};
use crate::error::Result;
use crate::inputs::{ALL, DESIGN, Inputs};
use crate::lattice::Body;
use crate::objective::{Displacement, loss_of, measures};
use crate::policy::Weights;
use crate::projection::{Projection, Projector};
use crate::walk::{self, Divergence, GuardedRollout, LoadsAndEnergy};
use crate::world::{KEEP_EVERY, Robot, Span, StepCheck, Trajectory, World, kept_steps};

impl Case {
    /// The world of this case: it has the lattice and the settings of the case.
    pub fn world(&self) -> World {
        World::new(self.lattice.clone(), &self.scene)
    }

    /// The robot of this case, with the surroundings of its scene.
    pub fn robot(&self) -> Robot<f64> {
        self.robot_in(&self.world(), &self.own_design())
    }

    /// Like [`robot`](Self::robot), if the world and the [design](Self::own_design) of this case are known already.
    fn robot_in(&self, world: &World, design: &Design<Mixture<f64>>) -> Robot<f64> {
        world.robot(world.body(design), self.controller.clone(), &self.start)
    }

    /// All numbers of the case with respect to which its rollout can be differentiated: design vectors, controller and
    /// initial state.
    pub fn inputs(&self) -> Inputs<f64> {
        Inputs {
            z: self.design.vectors().into_owned(),
            controller: self.controller.clone(),
            start: self.start.clone(),
        }
    }

    /// Projects the design vectors `z` with `projection`: the result has one mixture per edge. If the design of the
    /// case is a layout, the result is this layout, and `z` is ignored.
    pub fn projected<R: Real>(&self, projection: Projection, z: &[[R; 3]]) -> Design<Mixture<R>> {
        match &self.design {
            Design::Layout(layout) => Design::Layout(layout.clone()),
            Design::Undecided(_) => {
                let projector = Projector::new(&self.scene.projection, &self.lattice);
                Design::Undecided(projector.mixtures(projection, z))
            }
        }
    }

    /// The design in the form that is simulated: the design of the case after the projection that the case names.
    pub fn own_design(&self) -> Design<Mixture<f64>> {
        self.projected(self.projection, &self.design.vectors())
    }

    /// The body that the rollout simulates: stiffnesses, strains, masses, the presence of each node, and the
    /// marker whose displacement counts.
    pub fn body(&self) -> Body<f64> {
        self.world().body(&self.own_design())
    }

    /// Simulates the case and returns the first state that diverged; `None` if the rollout does not diverge.
    pub fn divergence(&self) -> Option<Divergence> {
        let steps = self.scene.physics.steps;
        let world = self.world();
        let robot = self.robot_in(&world, &self.own_design());
        walk::divergence(&world, &robot, &Span::of_steps(steps))
    }

    /// Checks whether the time step is short enough for the vibrations of the robot at rest in its initial positions.
    pub fn step_check(&self) -> StepCheck {
        let world = self.world();
        let any_design = world.stable_step_of_any_design(1.0);
        world.step_check(&self.own_design(), &self.start.x, 1.0, any_design)
    }

    /// Simulates the case, but with the design, the controller and the initial state of `inputs`. Returns the loss:
    /// minus the final position along the ground, in metres, of the payload, or of the body that the case names. The
    /// position counts from the origin of the case's file.
    pub fn displacement_loss<R: Real>(&self, world: &World, inputs: &Inputs<R>) -> R {
        let robot = inputs.robot(world, &self.projected(self.projection, &inputs.z));
        let loss = Displacement::at_end(world.ground());
        let span = Span::of_steps(self.scene.physics.steps);
        let loss = loss_of(world, &robot, &loss, &span);
        loss - R::lit(self.frame.along(&world.ground()))
    }

    /// Simulates the case. The results hold the states after the steps in `record` (see
    /// [`recorded_steps`](Self::recorded_steps)). They also hold the exact gradients if `gradient` is true.
    ///
    /// # Errors
    /// If a step to record is beyond the end of the rollout.
    pub fn evaluate(&self, gradient: bool, record: &[usize]) -> Result<CaseResults> {
        let world = self.world();
        let recorded = self.recorded_steps(record)?;
        let design = self.own_design();
        let robot = self.robot_in(&world, &design);
        let steps = self.scene.physics.steps;
        let mut observed = recorded.clone();
        observed.extend(kept_steps(steps, KEEP_EVERY));
        observed.sort_unstable();
        observed.dedup();
        let span = Span::from_start(observed);
        let GuardedRollout {
            trajectory,
            divergence,
        } = walk::guarded(&world, &robot, &span);
        let ground = world.ground();
        let along = |place| ground.along(self.frame.written(place));
        let l_disp = -along(trajectory.position(steps));
        let displacement = -along(self.start.x[robot.body.marker.payload]) - l_disp;
        let measured = match divergence {
            Some(_) => None,
            None => self.loads_and_energy(&world, (&design, &robot), &trajectory, displacement),
        };
        let mixtures = design.mixtures();
        let measures = measures(&mixtures, self.scene.projection.delta);
        let own_terms = self.augmentation(self.projection, gradient);
        let performance_terms = (self.projection == Projection::Stability)
            .then(|| self.augmentation(Projection::Performance, gradient));
        let grad_l_disp = gradient.then(|| self.gradient(&world));
        let design_gradient = |(_, terms): &(f64, Vec<f64>)| {
            let total = grad_l_disp.as_ref()?.z.iter().zip(terms.as_chunks().0);
            let sum = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|k| a[k] + b[k]);
            Some(DesignGradient {
                z: total.map(sum).collect(),
            })
        };
        Ok(CaseResults {
            u0: self.first_activation(&world, &robot),
            displacement,
            energy: measured.as_ref().map(|measured| measured.energy),
            loads: measured.map(|measured| measured.loads),
            node_mass: robot.body.mass.clone(),
            l_disp,
            volume: measures.volume,
            actuator_volume: measures.actuator_volume,
            g_bin: measures.binarisation,
            g_ortho: measures.overlap,
            augmented: l_disp + own_terms.0,
            grad_augmented: design_gradient(&own_terms),
            augmented_performance_constraints: performance_terms.as_ref().map(|t| l_disp + t.0),
            grad_augmented_performance_constraints: performance_terms
                .as_ref()
                .and_then(design_gradient),
            trajectory: (recorded.into_iter())
                .map(|n| (n, self.frame.written_state(trajectory.at(n))))
                .collect(),
            z_projected: mixtures.iter().map(|mixture| mixture.0).collect(),
            grad_l_disp,
            divergence,
        })
    }

    /// The loads and the energy of a layout. `seen` has the states that a run keeps, among others; `displacement` is in m.
    fn loads_and_energy(
        &self,
        world: &World,
        (design, robot): (&Design<Mixture<f64>>, &Robot<f64>),
        seen: &Trajectory<f64>,
        displacement: f64,
    ) -> Option<LoadsAndEnergy> {
        let kept = kept_steps(self.scene.physics.steps, KEEP_EVERY);
        let states = kept.iter().map(|n| seen.at(*n).clone()).collect();
        let kept = Trajectory::new(kept, states);
        let span = Span::of_steps(self.scene.physics.steps);
        LoadsAndEnergy::of(world, design, robot, &span, &kept, displacement)
    }

    /// The activation of each edge in the first step.
    fn first_activation(&self, world: &World, robot: &Robot<f64>) -> Vec<f64> {
        world.activations(robot, &[(&self.start, 0.0)]).concat()
    }

    fn gradient(&self, world: &World) -> Gradient {
        let mut inputs = self.inputs();
        let loss = |inputs: &Inputs<_>| self.displacement_loss(world, inputs);
        let (_, gradient) = inputs.differentiate(ALL, loss);
        inputs.set(ALL, &gradient);
        Gradient {
            z: inputs.z,
            weights: Weights::from(&inputs.controller),
            x0: inputs.start.dimension.rows(&inputs.start.x),
            v0: inputs.start.dimension.rows(&inputs.start.v),
        }
    }

    /// The sum of the terms that the augmented Lagrangian adds to the loss, and the gradient of this sum with respect
    /// to the design vectors. The gradient is empty if `gradient` is false.
    fn augmentation(&self, projection: Projection, gradient: bool) -> (f64, Vec<f64>) {
        if gradient {
            let terms = |inputs: &Inputs<_>| self.penalties(projection, &inputs.z);
            self.inputs().differentiate(DESIGN, terms)
        } else {
            (
                self.penalties(projection, &self.design.vectors()),
                Vec::new(),
            )
        }
    }

    /// The sum of the terms that the augmented Lagrangian adds to the loss. They are computed from the mixtures that
    /// `projection` makes from `z`.
    fn penalties<R: Real>(&self, projection: Projection, z: &[[R; 3]]) -> R {
        let design = self.projected(projection, z);
        let measures = measures(&design.mixtures(), self.scene.projection.delta);
        self.lagrangian.terms(&measures, &self.thresholds)
    }
}
