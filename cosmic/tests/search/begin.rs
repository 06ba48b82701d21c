use crate::small::{Up, tiny};
use autodiff::Real;
use cosmic::design::Design;
use cosmic::error::Result;
use cosmic::objective::Loss;
use cosmic::policy::Controller;
use cosmic::scene::{GradientPrecision, LossKind, TaskKind};
use cosmic::search::CoDesign;
use cosmic::world::Trajectory;

/// A caller's loss gives the same bits as the built-in loss with the same formula, in both precisions.
#[test]
fn a_caller_s_loss_is_optimised_like_a_built_in_loss() {
    for precision in [GradientPrecision::F64, GradientPrecision::F32] {
        let mut scene = tiny();
        scene.gradient.precision = precision;
        (scene.loss.kind, scene.loss.window, scene.loss.every) = (LossKind::Mean, 24, 12);
        let run = |codesign: Result<CoDesign>| {
            let mut records = Vec::new();
            let mut codesign = codesign.unwrap();
            let delivery = codesign.optimise(1, |record| records.push(record.clone()));
            (records, delivery.unwrap())
        };
        let own = run(CoDesign::with_loss(&scene, Up));
        assert_ne!(run(CoDesign::new(&scene)), own);
        scene.objective.task = TaskKind::Climb;
        assert_eq!(run(CoDesign::new(&scene)), own);
    }
}

#[test]
fn a_loss_that_does_not_observe_the_last_step_is_refused() {
    struct Astray(fn(usize) -> Vec<usize>);
    impl Loss for Astray {
        fn observed(&self, steps: usize) -> Vec<usize> {
            (self.0)(steps)
        }

        fn loss<R: Real>(&self, _: &Trajectory<R>) -> R {
            R::one()
        }
    }
    let said = |observed| {
        let refused = CoDesign::with_loss(&tiny(), Astray(observed)).err();
        refused.expect("it is refused").to_string()
    };
    let text = said(|steps| vec![steps - 1]);
    assert!(
        text.contains("[23]") && text.contains("end with 24"),
        "{text}"
    );
    assert!(said(|steps| vec![steps, 0, steps]).contains("[24, 0, 24]"));
    assert!(said(|_| Vec::new()).contains("[]"));
    // Every length of the horizon is checked, not only the first and the last.
    let mut scene = tiny();
    (scene.schedule.horizon, scene.schedule.horizon_over) = ([12, 24], [1, 5]);
    let astray = Astray(|steps| vec![steps - usize::from(steps == 15)]);
    let refused = CoDesign::with_loss(&scene, astray).err();
    let text = refused.expect("it is refused").to_string();
    assert!(text.contains("a rollout of 15 steps"), "{text}");
}

#[test]
fn a_robot_to_begin_with_must_be_finite_and_fit_the_lattice() {
    let codesign = CoDesign::new(&tiny()).unwrap();
    let progress = codesign.begin(1).unwrap();
    let (z, controller) = (progress.design.vectors(), &progress.controller);
    let said = |z: &[_], controller: &Controller<f64>| {
        let design = Design::of_vectors(z.to_vec());
        let refused = codesign.begin_with(1, design, controller.clone()).err();
        refused.map_or(String::new(), |error| error.to_string())
    };
    assert_eq!(said(&z, controller), "");
    let mut broken = controller.clone();
    broken.numbers_mut()[3] = f64::NAN;
    assert!(said(&z, &broken).contains("NaN or infinite"));
    let mut outside = z.to_vec();
    outside[2][1] = f64::NAN;
    assert!(said(&outside, controller).contains("`z[2]`"));
    assert!(said(&z[1..], controller).contains("entries in `z`"));
}
