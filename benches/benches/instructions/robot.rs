//! Rollouts and gradients of a robot.

use autodiff::{Real, Var};
use autodiff_programs::{Model, Program, Rollout};
use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::inputs::{InputBlock, Inputs};
use cosmic::objective::{Displacement, loss_of};
use cosmic::scene::LossSettings;
use cosmic::world::{Span, World};

/// The number of steps of a measured rollout, unless the case has fewer.
pub(crate) const MEASURED_STEPS: usize = 4096;

/// A case prepared for benchmarks: a rollout and its gradients.
#[derive(Clone, Debug)]
pub(crate) struct Subject<'a> {
    pub(crate) case: &'a Case,
    world: World,
    inputs: Inputs<f64>,
    loss: Displacement,
    span: Span,
}

impl<'a> Subject<'a> {
    /// Prepares rollouts of a case. They have [`MEASURED_STEPS`] steps, or fewer if the case has fewer.
    pub(crate) fn new(case: &'a Case, loss: &LossSettings) -> Self {
        let world = case.world();
        Self {
            loss: Displacement {
                ground: world.ground(),
                settings: loss.clone(),
            },
            span: Span::of_steps(MEASURED_STEPS.min(case.scene.physics.steps)),
            inputs: case.inputs(),
            world,
            case,
        }
    }

    /// Computes the loss without its gradient.
    pub(crate) fn rollout<R: Real>(&self) -> R {
        let inputs = self.inputs.lift::<R>();
        let design = self.case.projected(self.case.projection, &inputs.z);
        let robot = inputs.robot(&self.world, &design);
        loss_of(&self.world, &robot, &self.loss, &self.span)
    }

    /// Computes the loss and its gradient with respect to some blocks of the inputs, such as
    /// [`DESIGN`](cosmic::inputs::DESIGN) or [`CONTROLLER`](cosmic::inputs::CONTROLLER). A layout has no design vectors;
    /// instead, the gradient is with respect to its mixtures.
    pub(crate) fn gradient<R: Real>(&self, blocks: &[InputBlock]) -> (R, Vec<R>) {
        let inputs = self.inputs.lift::<R>();
        inputs.differentiate(blocks, |inputs| {
            let design = self.design(blocks, inputs);
            let robot = inputs.robot(&self.world, &design);
            loss_of(&self.world, &robot, &self.loss, &self.span)
        })
    }

    /// Returns the design for a rollout that is differentiated with respect to some blocks. A layout has no design
    /// vectors, so its mixtures are used instead.
    fn design<R: Real>(
        &self,
        blocks: &[InputBlock],
        inputs: &Inputs<Var<R>>,
    ) -> Design<Mixture<Var<R>>> {
        match self.case.design {
            Design::Layout(_) if blocks.contains(&InputBlock::Z) => Design::of_shares(&inputs.z),
            _ => self.case.projected(self.case.projection, &inputs.z),
        }
    }
}

/// The two products `W2 (W1 x)` with the shapes of a controller: from all positions and velocities to hidden units, and
/// from there to edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TwoMatvecs {
    inputs: usize,
    hidden: usize,
    edges: usize,
}

impl TwoMatvecs {
    /// Prepares the two matrix-vector products with the shapes of a case's controller.
    pub(crate) fn new(case: &Case) -> Self {
        Self {
            inputs: 4 * case.lattice.nodes(),
            hidden: case.scene.controller.hidden,
            edges: case.lattice.edges.len(),
        }
    }

    /// Computes the two matrix-vector products `steps` times. Returns the input vector.
    pub(crate) fn run(self, steps: usize) -> Vec<f64> {
        let (inputs, hidden, edges) = (self.inputs, self.hidden, self.edges);
        let rollout = Rollout::new(self, steps);
        let numbers = |count: usize| vec![0.1; count];
        let parameters = [hidden * inputs, hidden, edges * hidden, edges].map(numbers);
        rollout.run(&numbers(inputs), &parameters.each_ref().map(Vec::as_slice))
    }
}

impl Model for TwoMatvecs {
    fn record(&self, p: &mut Program) {
        let (first, biases) = (p.matrix(self.hidden, self.inputs), p.parameter(self.hidden));
        let (second, outputs) = (p.matrix(self.edges, self.hidden), p.parameter(self.edges));
        let x = p.state(self.inputs);
        let hidden = p.dense(first, &[x], biases);
        p.dense(second, &[hidden], outputs);
        p.advance(x, x);
    }
}
