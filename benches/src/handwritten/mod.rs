//! The robot's rollout and its gradients as a specialist writes them, for one robot alone: 6x6 nodes,
//! 32 hidden units, flat ground that nodes stick to. Sizes are constants, everything has its fixed
//! place, every derivative is worked out by hand, and all of a step is one function in machine code.
//!
//! It is what generic code is timed against (`cargo bench -p benches --bench handwritten`), and
//! nothing else runs on it. Lanes, and with them tanh, are those of `autodiff`; materials and the
//! folding of the controller are `cosmic`'s, once before the rollout and, transposed, once after it.

mod buffer;
mod forward;
mod plan;
mod product;
mod reverse;
mod sizes;

use autodiff::simd::{Lane, Vectorized};
use autodiff::{Real, Var};
use cosmic::case::Case;
use cosmic::inputs::{CONTROLLER, DESIGN, Inputs};
use cosmic::lattice::Body;
use cosmic::laws::ContactLaw;
use cosmic::objective::{Displacement, Loss};
use cosmic::policy::Network;
use cosmic::scene::{Integrator, LossSettings};
use cosmic::task::Task;

pub use buffer::Buffer;
use plan::{RobotPlan, start};
use sizes::{COLUMNS, EDGE_PLACES, EDGES, FEW, HIDDEN, NODES};

/// The gradient that is wanted beside the loss: none, by the design, or by the controller.
/// Each is compiled on its own, as loops are spoilt by what else is in a function.
const NOTHING: u8 = 0;
const BY_DESIGN: u8 = 1;
const BY_CONTROLLER: u8 = 2;

/// The rollout of a case with its loss. Rows of steps are written where the caller keeps them, so
/// that their memory serves again.
pub struct Handwritten<'a> {
    case: &'a Case,
    task: Task,
    inputs: Inputs<f64>,
    steps: usize,
    /// Steps after which the payload's position is looked at.
    observed: Vec<usize>,
}

impl<'a> Handwritten<'a> {
    /// Plans rollouts of so many steps.
    ///
    /// # Panics
    /// If the case is of another robot, or of other physics.
    pub fn new(case: &'a Case, loss: &LossSettings, steps: usize) -> Self {
        assert_eq!(case.layout.columns, COLUMNS, "columns");
        assert_eq!(case.lattice.nodes(), NODES, "nodes");
        assert_eq!(case.lattice.edges.len(), EDGES, "edges");
        assert_eq!(case.observation.hidden, HIDDEN, "hidden units");
        let physics = &case.physics;
        assert_eq!(physics.contact, ContactLaw::infinite(), "contact");
        assert_eq!(physics.integrator, Integrator::SymplecticEuler);
        let others = [
            physics.incline_deg,
            physics.stiffening,
            physics.bending_radius,
        ];
        assert_eq!(
            (physics.substeps, others),
            (1, [0.0; 3]),
            "physics left out"
        );
        let task = case.task();
        let loss = Displacement {
            ground: task.ground(),
            settings: loss.clone(),
        };
        Self {
            case,
            inputs: case.inputs(),
            observed: loss.observed(steps),
            task,
            steps,
        }
    }

    /// The loss.
    pub fn rollout<R: Real>(&self, rows: &mut Buffer<R>) -> R {
        self.run::<R, NOTHING>(rows).0
    }

    /// The loss and its gradient by the design vectors.
    pub fn design_gradient<R: Real>(&self, rows: &mut Buffer<R>) -> (R, Vec<R>) {
        let (loss, by) = self.run::<R, BY_DESIGN>(rows);
        let given = self.inputs.lift::<R>();
        let (_, gradient) = given.differentiate(DESIGN, |inputs| {
            let body = self.body(inputs);
            let inverse_mass: Vec<_> = body.mass.iter().map(|m| m.recip()).collect();
            let parts = [&body.stiffness, &body.strain, &inverse_mass];
            along(&parts.map(|part| &part[..]), &by)
        });
        (loss, gradient)
    }

    /// The loss and its gradient by the controller's weights.
    pub fn controller_gradient<R: Real>(&self, rows: &mut Buffer<R>) -> (R, Vec<R>) {
        let (loss, by) = self.run::<R, BY_CONTROLLER>(rows);
        let given = self.inputs.lift::<R>();
        let (_, gradient) = given.differentiate(CONTROLLER, |inputs| {
            let network = self.folded(inputs);
            let Network { first, second } = &network;
            let parts = [
                &first.weights,
                &first.biases,
                &second.weights,
                &second.biases,
            ];
            along(&parts.map(|part| &part[..]), &by)
        });
        (loss, gradient)
    }

    fn run<R: Real, const WANTED: u8>(&self, rows: &mut Buffer<R>) -> (R, Vec<Vec<R>>) {
        let inputs = self.inputs.lift::<R>();
        let (body, network) = (self.body(&inputs), self.folded(&inputs));
        // Only the gradient by the mixture asks what an edge that does not strain would do.
        let wants_output = |edge: &usize| WANTED == BY_DESIGN || !body.strain[*edge].is_zero();
        let outputs: Vec<usize> = (0..EDGES).filter(wants_output).collect();
        let given = (&body, &network, &outputs[..]);
        match outputs.len() <= FEW {
            true => R::vectorize(RunInLanes::<R, FEW, WANTED>(self, given, rows)),
            false => R::vectorize(RunInLanes::<R, EDGE_PLACES, WANTED>(self, given, rows)),
        }
    }

    /// The mixture of a frozen layout is its design vectors.
    fn body<R: Real>(&self, inputs: &Inputs<R>) -> Body<R> {
        match self.case.frozen {
            Some(_) => self.task.body(&inputs.z),
            None => (self.task).body(&self.case.mixture(self.case.projection, &inputs.z)),
        }
    }

    fn folded<R: Real>(&self, inputs: &Inputs<R>) -> Network<R> {
        let (nodes, ground) = (self.case.lattice.nodes(), self.task.ground());
        let network = Network::of(&inputs.controller).expect("a network");
        network.folded(&self.case.observation, nodes, &[], &ground)
    }
}

/// The sum of numbers times their cotangents, whose gradient is what the cotangents pull back to.
fn along<R: Real>(numbers: &[&[Var<R>]], cotangents: &[Vec<R>]) -> Var<R> {
    let constants = |of: &Vec<R>| of.iter().map(|&c| Var::constant(c)).collect::<Vec<_>>();
    let pairs = numbers.iter().zip(cotangents);
    let sums: Vec<Var<R>> = pairs.map(|(n, c)| Var::dot(n, &constants(c))).collect();
    Var::sum_of(&sums)
}

/// A rollout in lanes: of a body, a network and the edges that want outputs, ascending; and the
/// memory for rows.
struct RunInLanes<'a, R, const OUTPUTS: usize, const WANTED: u8>(
    &'a Handwritten<'a>,
    (&'a Body<R>, &'a Network<R>, &'a [usize]),
    &'a mut Buffer<R>,
);

impl<R: Real, const OUTPUTS: usize, const WANTED: u8> Vectorized<R>
    for RunInLanes<'_, R, OUTPUTS, WANTED>
{
    type Output = (R, Vec<Vec<R>>);
    #[inline(always)]
    fn run<L: Lane<R>>(self) -> Self::Output {
        let Self(by_hand, given, rows) = self;
        let observed = &by_hand.observed[..];
        let plan = RobotPlan::<R, L, OUTPUTS>::new(by_hand.case, given, by_hand.steps);
        let keep = WANTED != NOTHING;
        let sum = forward::run(&plan, &start(by_hand.case), (observed, keep), rows);
        let bar = R::lit(-1.0 / observed.len() as f64);
        let cotangents = match WANTED {
            NOTHING => Vec::new(),
            BY_DESIGN => reverse::run::<R, L, OUTPUTS, true>(&plan, (observed, bar), rows),
            _ => reverse::run::<R, L, OUTPUTS, false>(&plan, (observed, bar), rows),
        };
        (sum * bar, cotangents)
    }
}

#[cfg(test)]
mod tests {
    use autodiff::Real;
    use cosmic::inputs::{CONTROLLER, DESIGN};
    use cosmic_lab::verify::Subject;

    use super::{Buffer, Handwritten};
    use crate::machine::built_in;

    /// Compares the specialist's numbers with those of generic code. Both add up the same terms in
    /// another order: `rounding` is what that may make of a component, as a share of the largest.
    fn agrees<R: Real + Into<f64>>(scene: &str, rounding: f64) {
        let (scene, mut case) = built_in(scene);
        case.physics.steps = 100;
        case.design.one_piece = false;
        let subject = Subject::new(&case, &scene.loss);
        let handwritten = Handwritten::new(&case, &scene.loss, 100);
        let mut rows = Buffer::default();
        let both = [
            (
                subject.gradient::<R>(DESIGN),
                handwritten.design_gradient::<R>(&mut rows),
            ),
            (
                subject.gradient::<R>(CONTROLLER),
                handwritten.controller_gradient::<R>(&mut rows),
            ),
        ];
        for ((value, gradient), (its_value, its_gradient)) in both {
            let (value, its_value): (f64, f64) = (value.into(), its_value.into());
            assert!((value - its_value).abs() < rounding * value.abs());
            let plain: f64 = handwritten.rollout::<R>(&mut rows).into();
            assert!((value - plain).abs() < rounding * value.abs());
            let gradient: Vec<f64> = gradient.into_iter().map(R::into).collect();
            let scale = gradient.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
            assert!(scale > 0.0);
            assert_eq!(gradient.len(), its_gradient.len());
            for (k, (ours, its)) in gradient.iter().zip(its_gradient).enumerate() {
                let its: f64 = its.into();
                assert!(
                    (ours - its).abs() < rounding * scale,
                    "{k}: {its}, not {ours}"
                );
            }
        }
    }

    #[test]
    fn the_specialist_agrees_with_generic_code() {
        // A hundred steps of sums of 146 terms, before contacts multiply what rounding does: some
        // thousand roundings, of 1e-16 and of 6e-8.
        agrees::<f64>("stability", 1e-12);
        agrees::<f64>("baseline_tall", 1e-12);
        agrees::<f32>("stability", 1e-4);
        agrees::<f32>("baseline_tall", 1e-4);
    }
}
