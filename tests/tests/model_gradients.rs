//! Every differentiable term between design and objective: reverse mode against forward mode and
//! finite differences, at the designs and weights of the reference cases.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Real, jvp, vjp};
use cosmic::case::Case;
use cosmic::design::{Design, Mixture};
use cosmic::geometry::{Ground, Vector, flat, from_flat};
use cosmic::lattice::Body;
use cosmic::lattice::State;
use cosmic::objective::{Displacement, Loss, measures, violations};
use cosmic::policy::{Controller, Network, observation};
use cosmic::projection::{Holds, Projection, mixtures};
use cosmic::scene::{LossKind, LossSettings};
use cosmic::simulator::Trajectory;
use cosmic_tests::{own_reference_folder, references};

/// A vector function of a vector, generic over its numbers.
trait Values {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R>;
}

/// A vector function made scalar by fixed weights of both signs.
struct Weighted<F>(F);

impl<F: Values> Function for Weighted<F> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let y = self.0.eval(x);
        let weights: Vec<R> = (0..y.len())
            .map(|i| R::lit((1.0 + i as f64).sin()))
            .collect();
        R::dot(&y, &weights)
    }
}

/// Small cases: the others have the same terms, more often.
fn cases() -> Vec<Case> {
    let references = references(&own_reference_folder());
    let cases = references.iter().map(|reference| reference.case());
    let small: Vec<Case> = cases.filter(|case| case.lattice.nodes() <= 12).collect();
    assert!(!small.is_empty(), "no small case");
    small
}

fn smooth<F: Values>(function: F, x: &[f64]) {
    let report = check_gradient(&Weighted(function), x, &Options::default());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
}

fn shares<R: Real>(mixtures: &[Mixture<R>]) -> Vec<R> {
    mixtures.iter().flat_map(|mixture| mixture.0).collect()
}

/// The mixtures of a design.
struct Mixtures<'a>(&'a Case, Projection);

impl Values for Mixtures<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let Case {
            sharpness, lattice, ..
        } = self.0;
        let holds = Holds::new(sharpness, lattice);
        shares(&mixtures(self.1, x.as_chunks().0, sharpness, &holds))
    }
}

#[test]
fn performance_projections() {
    for case in &cases() {
        smooth(
            Mixtures(case, Projection::Performance),
            case.design.vectors().as_flattened(),
        );
    }
}

/// What is held down has shares of its own that are next to nothing, and the rest the derivatives
/// of fewer materials.
#[test]
fn projections_with_held_materials() {
    for mut case in cases() {
        case.sharpness.hold_materials = 0.3;
        case.sharpness.beta_stability = case.sharpness.beta_straight_through;
        let z = case.design.vectors().into_owned().into_flattened();
        for projection in [Projection::Performance, Projection::Stability] {
            let held = Mixtures(&case, projection);
            let free = Holds::default();
            let free = mixtures(projection, z.as_chunks().0, &case.sharpness, &free);
            assert_ne!(held.eval(&z), shares(&free));
            smooth(held, &z);
        }
    }
}

/// The value of the stability projection is sharper than its derivative, and differences see the
/// value: here the two have one sharpness, and then reverse and forward mode with two.
#[test]
fn stability_projections() {
    for mut case in cases() {
        let sharp = case.sharpness.beta_stability;
        case.sharpness.beta_stability = case.sharpness.beta_straight_through;
        let z = case.design.vectors().into_owned().into_flattened();
        smooth(Mixtures(&case, Projection::Stability), &z);
        case.sharpness.beta_stability = sharp;
        let function = Mixtures(&case, Projection::Stability);
        let direction: Vec<f64> = (0..z.len()).map(|i| (2.3 * i as f64).sin()).collect();
        let cotangent: Vec<f64> = (0..z.len()).map(|i| (1.1 * i as f64).cos()).collect();
        let (_, tangent) = jvp(|x| function.eval(x), &z, &direction);
        let (_, gradient) = vjp(|x| function.eval(x), &z, &cotangent);
        let (forward, reverse) = (dot(&cotangent, &tangent), dot(&gradient, &direction));
        // Some hundred terms of order one, each rounded at 1e-16.
        assert!((forward - reverse).abs() < 1e-12, "{forward} and {reverse}");
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Steps of the trajectories that losses look at.
const OBSERVED: usize = 40;

/// The loss of a trajectory by the positions in it.
struct Losses(Displacement);

impl Values for Losses {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let steps = self.0.observed(OBSERVED);
        let nodes = x.len() / (2 * steps.len());
        let states = x.chunks_exact(2 * nodes).map(|x| State {
            x: from_flat(x),
            v: vec![Vector::zero(); nodes],
        });
        let trajectory = Trajectory {
            states: states.collect(),
            steps,
        };
        vec![self.0.loss(&trajectory)]
    }
}

#[test]
fn losses() {
    for kind in [LossKind::Final, LossKind::Mean] {
        for incline_deg in [0.0, 15.0] {
            let loss = Displacement {
                ground: Ground {
                    height: 0.1,
                    incline_deg,
                },
                settings: LossSettings {
                    kind,
                    window: 24,
                    every: 4,
                },
            };
            let states = loss.observed(OBSERVED).len();
            let positions: Vec<f64> = (0..states * 6).map(|i| (i as f64).cos()).collect();
            smooth(Losses(loss), &positions);
        }
    }
}

fn performance<R: Real>(case: &Case, z: &[R]) -> Vec<Mixture<R>> {
    let (z, holds) = (z.as_chunks().0, Holds::default());
    mixtures(Projection::Performance, z, &case.sharpness, &holds)
}

/// Masses, and strains and stiffnesses of the size of masses, of a design.
struct Bodies<'a>(&'a Case);

impl Values for Bodies<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let case = self.0;
        let design = Design::Undecided(performance(case, x));
        let body = Body::new(&design, &case.lattice, &case.materials, &case.physics);
        let stiffness = body.stiffness.into_iter().map(|k| k * R::lit(1e-4));
        [body.mass, body.strain, stiffness.collect()].concat()
    }
}

#[test]
fn bodies() {
    for mut case in cases() {
        for penalisation in [1, 3] {
            case.materials.penalisation = penalisation;
            smooth(Bodies(&case), case.design.vectors().as_flattened());
        }
    }
}

/// Volumes, measures and the augmented terms of a design.
struct Objectives<'a>(&'a Case);

impl Values for Objectives<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let case = self.0;
        let m = measures(&performance(case, x), case.sharpness.delta);
        let violations = violations(m.constrained(), &case.thresholds);
        let augmented = case.lagrangian.objective(R::zero(), violations);
        vec![m.volume, m.actuator_volume, augmented]
    }
}

#[test]
fn objectives() {
    for case in cases() {
        smooth(Objectives(&case), case.design.vectors().as_flattened());
    }
}

/// The controller's activations by its weights and the state.
struct Activations<'a>(&'a Case);

impl Activations<'_> {
    /// Weights and state as one vector.
    fn point(&self) -> Vec<f64> {
        let Case {
            controller, start, ..
        } = self.0;
        [controller.numbers(), &flat(&start.x), &flat(&start.v)].concat()
    }

    /// The controller and the state of such a vector.
    fn read<R: Real>(&self, x: &[R]) -> (Controller<R>, State<R>) {
        let Case {
            controller, start, ..
        } = self.0;
        let mut rest = x;
        let mut take = |count| rest.split_off(..count).expect("a number each").to_vec();
        let mut read = controller.map(|_| R::zero());
        read.numbers_mut()
            .copy_from_slice(&take(controller.weights()));
        let mut points = || from_flat(&take(2 * start.x.len()));
        let (x, v) = (points(), points());
        (read, State { x, v })
    }
}

impl Values for Activations<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let (controller, state) = self.read(x);
        let ground = Ground::from(&self.0.physics);
        let network = Network::of(&controller).expect("a network");
        network.activation(&observation(&self.0.observation, 0.3, &state, &[], &ground))
    }
}

/// The folded first layer by the weights that are folded.
struct FoldedWeights<'a>(Activations<'a>);

impl Values for FoldedWeights<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let case = self.0.0;
        let (controller, _) = self.0.read(x);
        let (nodes, ground) = (case.lattice.nodes(), Ground::from(&case.physics));
        let network = Network::of(&controller).expect("a network");
        let folded = network.folded(&case.observation, nodes, &[], &ground);
        [folded.first.weights, folded.first.biases].concat()
    }
}

#[test]
fn activations_and_folded_weights() {
    for mut case in cases() {
        for goal_relative in [false, true] {
            case.observation.goal_relative = goal_relative;
            let point = Activations(&case).point();
            smooth(Activations(&case), &point);
            smooth(FoldedWeights(Activations(&case)), &point);
        }
    }
}

/// A term with a wrong derivative: what the checks above would not notice, they would not check.
struct Wrong<'a>(Bodies<'a>);

impl Values for Wrong<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let mut y = self.0.eval(x);
        y[0] = y[0].straight_through(y[0] * R::lit(1.01));
        y
    }
}

#[test]
fn a_wrong_derivative_is_noticed() {
    for case in cases() {
        let function = Weighted(Wrong(Bodies(&case)));
        let z = case.design.vectors();
        let report = check_gradient(&function, z.as_flattened(), &Options::default());
        assert_eq!(report.verdict, Verdict::Wrong, "{report}");
    }
}
