//! Running a case.

use autodiff::Real;

use super::{Case, CaseResults, DesignGradient, Gradient};
use crate::controller::{Weights, observation};
use crate::error::Result;
use crate::geometry::Ground;
use crate::inputs::{ALL, DESIGN, Inputs};
use crate::lattice::Body;
use crate::objective::{Displacement, measures};
use crate::projection::{self, Holds, Projection, one_hot};
use crate::simulator::{Divergence, Guarded, Overflow, Span, StepCheck};
use crate::task::{Horizon, Task};

impl Case {
    /// The case as a task.
    pub fn task(&self) -> Task {
        Task::new(
            self.lattice.clone(),
            &self.physics,
            &self.observation,
            &self.materials,
            &self.sharpness,
        )
        .with_one_piece(self.design.one_piece)
    }

    /// Everything that the case's rollout depends on.
    pub fn inputs(&self) -> Inputs<f64> {
        Inputs {
            z: self.z.clone(),
            controller: self.controller.clone(),
            start: self.start.clone(),
        }
    }

    /// The mixture of design vectors by a projection, or the frozen layout's.
    pub fn mixture<R: Real>(&self, projection: Projection, z: &[[R; 3]]) -> Vec<[R; 3]> {
        match &self.frozen {
            Some(materials) => one_hot(materials),
            None => {
                let holds = Holds::new(&self.sharpness, &self.lattice);
                projection::mixture(projection, z, &self.sharpness, &holds)
            }
        }
    }

    /// The mixture that is rolled out: of the case's own design vectors by its own projection.
    pub fn own_mixture(&self) -> Vec<[f64; 3]> {
        self.mixture(self.projection, &self.z)
    }

    /// The body that is rolled out.
    pub fn body(&self) -> Body<f64> {
        let mixture = self.own_mixture();
        Body::new(&mixture, &self.lattice, &self.materials, &self.physics).with_one_piece(
            self.design.one_piece,
            &mixture,
            &self.lattice,
        )
    }

    /// Where the rollout diverges, if it does.
    pub fn divergence(&self) -> Option<Divergence> {
        let (body, simulator, steps) = (self.body(), self.task().simulator, self.physics.steps);
        simulator.divergence(&body, &self.controller, &self.start, 0..steps)
    }

    /// Where the reverse sweep of the gradient of the displacement overflows, if it does.
    pub fn overflow(&self) -> Option<Overflow> {
        let (body, simulator, steps) = (self.body(), self.task().simulator, self.physics.steps);
        simulator.overflow(&body, &self.controller, &self.start, steps)
    }

    /// The time step against the vibrations of the robot at rest in its first positions.
    pub fn step_check(&self) -> StepCheck {
        self.task()
            .step_check(&self.own_mixture(), &self.start.x, 1.0)
    }

    /// The loss of the final position, for any number type.
    pub fn displacement_loss<R: Real>(&self, task: &Task, inputs: &Inputs<R>) -> R {
        let mixture = self.mixture(self.projection, &inputs.z);
        let loss = Displacement::at_end(task.ground());
        task.loss(&mixture, inputs, &loss, &Horizon::head(self.physics.steps))
    }

    /// Runs the case: its results, with the states of the given steps, and with the exact
    /// gradients where they are asked for.
    ///
    /// # Errors
    /// Where a step is to be recorded that the rollout does not reach.
    pub fn evaluate(&self, gradient: bool, record: &[usize]) -> Result<CaseResults> {
        let task = self.task();
        let recorded = self.recorded_steps(record)?;
        let mixture = self.own_mixture();
        let body = task.body(&mixture);
        let Guarded {
            trajectory,
            divergence,
        } = self.rollout(&task, &mixture, &recorded);
        let ground = task.ground();
        let l_disp = -ground.along(trajectory.at(self.physics.steps).x[0]);
        let measures = measures(&mixture, self.sharpness.delta);
        let own_terms = self.augmentation(self.projection, gradient);
        let performance_terms = (self.projection == Projection::Stability)
            .then(|| self.augmentation(Projection::Performance, gradient));
        let grad_l_disp = gradient.then(|| self.gradient(&task));
        let design_gradient = |(_, terms): &(f64, Vec<f64>)| {
            let total = grad_l_disp.as_ref()?.z.iter().zip(terms.as_chunks().0);
            let sum = |(a, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|k| a[k] + b[k]);
            Some(DesignGradient {
                z: total.map(sum).collect(),
            })
        };
        Ok(CaseResults {
            u0: self.first_activation(&ground),
            node_mass: body.mass,
            displacement: -ground.along(self.start.x[0]) - l_disp,
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
                .map(|n| (n, trajectory.at(n).clone()))
                .collect(),
            z_projected: mixture,
            grad_l_disp,
            divergence,
        })
    }

    /// The rollout of a mixture with the states of the given steps and of the last.
    fn rollout(&self, task: &Task, mixture: &[[f64; 3]], recorded: &[usize]) -> Guarded {
        let mut observed = recorded.to_vec();
        observed.push(self.physics.steps);
        observed.dedup();
        let span = Span::from_start(observed);
        task.guarded(mixture, &self.controller, &self.start, &span)
    }

    fn first_activation(&self, ground: &Ground) -> Vec<f64> {
        let seen = observation(
            &self.observation,
            0.0,
            &self.start,
            &self.body().presence,
            ground,
        );
        self.controller.activation(&seen)
    }

    fn gradient(&self, task: &Task) -> Gradient {
        let mut inputs = self.inputs();
        let loss = |inputs: &Inputs<_>| self.displacement_loss(task, inputs);
        let (_, gradient) = inputs.differentiate(ALL, loss);
        inputs.set(ALL, &gradient);
        Gradient {
            z: inputs.z,
            weights: Weights::from(&inputs.controller),
            x0: inputs.start.x,
            v0: inputs.start.v,
        }
    }

    /// The terms that the augmented Lagrangian adds, and their gradient by the design vectors if asked
    /// for.
    fn augmentation(&self, projection: Projection, gradient: bool) -> (f64, Vec<f64>) {
        if gradient {
            let terms = |inputs: &Inputs<_>| self.penalties(projection, &inputs.z);
            self.inputs().differentiate(DESIGN, terms)
        } else {
            (self.penalties(projection, &self.z), Vec::new())
        }
    }

    /// The terms that the augmented Lagrangian adds to the loss, measured on a projection.
    fn penalties<R: Real>(&self, projection: Projection, z: &[[R; 3]]) -> R {
        let measures = measures(&self.mixture(projection, z), self.sharpness.delta);
        self.lagrangian.terms(&measures, &self.thresholds)
    }
}
