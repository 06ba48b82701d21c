//! Gradients of those terms of the objective that need no rollout. At the designs of the reference cases, reverse mode
//! agrees with forward mode and finite differences. The other terms are checked in `rollout_gradients.rs`.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Real, jvp, vjp};
use cosmic::case::Case;
use cosmic::design::Mixture;
use cosmic::objective::{measures, violations};
use cosmic::projection::{Projection, Projector};
use cosmic_tests::{own_reference_folder, references};

/// A function from a vector to a vector, for all number types.
trait Values {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R>;
}

/// Converts a vector function to a scalar function: the sum of its results, each multiplied by a fixed weight. Weights
/// have both signs.
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

/// The small reference cases. Large cases have the same terms, only more of them.
fn cases() -> Vec<Case> {
    let references = references(&own_reference_folder());
    let cases = references.iter().map(|reference| reference.case());
    let small: Vec<Case> = cases.filter(|case| case.lattice.nodes() <= 12).collect();
    assert!(!small.is_empty(), "the reference folder has no small case");
    small
}

fn smooth<F: Values>(function: F, x: &[f64]) {
    let report = check_gradient(&Weighted(function), x, &Options::default());
    assert_eq!(report.verdict, Verdict::Smooth, "{report}");
    assert_eq!(report.control, Some(Verdict::Wrong), "{report}");
}

fn shares<R: Real>(mixtures: &[Mixture<R>]) -> Vec<R> {
    mixtures.iter().flat_map(|mixture| mixture.0).collect()
}

/// The mixtures of a design as a function of the design vectors, for one projection.
struct Mixtures<'a>(&'a Case, Projection);

impl Values for Mixtures<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let Case { scene, lattice, .. } = self.0;
        let projector = Projector::new(&scene.projection, lattice);
        shares(&projector.mixtures(self.1, x.as_chunks().0))
    }
}

/// The derivatives of projections are right for edges with held materials: materials whose share is almost zero.
#[test]
fn projections_with_held_materials() {
    for mut case in cases() {
        case.scene.projection.hold_materials = 0.3;
        case.scene.projection.beta_stability = case.scene.projection.beta_straight_through;
        let z = case.design.vectors().into_owned().into_flattened();
        for projection in [Projection::Performance, Projection::Stability] {
            let held = Mixtures(&case, projection);
            let free = Projector::free(&case.scene.projection);
            let free = free.mixtures(projection, z.as_chunks().0);
            assert_ne!(held.eval(&z), shares(&free));
            smooth(held, &z);
        }
    }
}

/// The derivatives of the stability projection are right. The projection is a straight-through estimator: its value
/// comes from a sharper function than its derivative, so differences of the value disagree with the derivative. For the
/// comparison with differences, the test makes both equally sharp. Reverse mode is compared with forward mode in both
/// cases.
#[test]
fn stability_projections() {
    for mut case in cases() {
        let sharp = case.scene.projection.beta_stability;
        case.scene.projection.beta_stability = case.scene.projection.beta_straight_through;
        let z = case.design.vectors().into_owned().into_flattened();
        smooth(Mixtures(&case, Projection::Stability), &z);
        case.scene.projection.beta_stability = sharp;
        let function = Mixtures(&case, Projection::Stability);
        let direction: Vec<f64> = (0..z.len()).map(|i| (2.3 * i as f64).sin()).collect();
        let cotangent: Vec<f64> = (0..z.len()).map(|i| (1.1 * i as f64).cos()).collect();
        let (_, tangent) = jvp(|x| function.eval(x), &z, &direction);
        let (_, gradient) = vjp(|x| function.eval(x), &z, &cotangent);
        let (forward, reverse) = (
            f64::dot(&cotangent, &tangent),
            f64::dot(&gradient, &direction),
        );
        // The tolerance is for several hundred terms of order one, each rounded at 1e-16.
        assert!((forward - reverse).abs() < 1e-12, "{forward} and {reverse}");
    }
}

fn performance<R: Real>(case: &Case, z: &[R]) -> Vec<Mixture<R>> {
    let projector = Projector::free(&case.scene.projection);
    projector.mixtures(Projection::Performance, z.as_chunks().0)
}

/// The volumes, the measures and the augmented terms of a design as a function of the design vectors.
struct Objectives<'a>(&'a Case);

impl Values for Objectives<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
        let case = self.0;
        let m = measures(&performance(case, x), case.scene.projection.delta);
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
