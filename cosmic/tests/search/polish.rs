use crate::small::{MOBILE_ROBOT, after};
use cosmic::design::{Material, VolumeBounds, filled, volumes};
use cosmic::geometry::Range;
use cosmic::judge::Candidate;
use cosmic::scene::{Scene, VolumeSettings};
use cosmic::search::Progress;

fn scene(more: &str) -> Scene {
    let polished = "
        iterations = 16
        snap_trials = 0
        settle = 0.25
    ";
    let mut scene = Scene::parse("polished", &[MOBILE_ROBOT, polished, more].concat()).unwrap();
    // The controller does not change.
    scene.adam.fine_rate = 0.0;
    scene
}

/// The number of edges in which two layouts differ.
fn changes(a: &Progress, b: &Progress) -> usize {
    let [a, b] = [a, b].map(|p| p.design.layout().unwrap());
    a.iter().zip(b).filter(|(a, b)| a != b).count()
}

#[test]
fn a_polish_changes_one_edge_if_that_gives_a_better_robot() {
    let scene = scene("");
    let mut found = 0;
    for seed in 0..4 {
        let (mut codesign, mut progress) = after(&scene, 10, seed);
        assert!(!progress.candidates.is_empty());
        let before = progress.clone();
        let merit = codesign.evaluate(&progress).merit;
        // The learning rate is 0, so iteration 11 only polishes.
        codesign.iterate(&mut progress);
        let reached = codesign.evaluate(&progress).merit;
        assert_eq!(progress.controller, before.controller);
        if changes(&before, &progress) == 0 {
            assert_eq!(reached, merit);
            continue;
        }
        found += 1;
        assert!(reached > merit, "{reached} <= {merit}");
        assert_eq!(changes(&before, &progress), 1);
        // The candidates before were measured with the robot before the change.
        let is_new = |c: &Candidate| c.iteration == before.iteration;
        assert!(progress.candidates.iter().all(is_new));
        let [solid, actuators] = volumes(&codesign.design(&progress).mixtures());
        let bounds = VolumeBounds::widened(&scene.volume, VolumeSettings::WIDENING);
        // A layout may fill a bound exactly, up to rounding.
        let holds = |bound: Range, volume| bound.widened(1e-12).contains(volume);
        assert!(
            holds(bounds.solid, solid) && holds(bounds.actuator, actuators),
            "{solid} {actuators} {bounds:?}"
        );
    }
    assert!(found > 0, "no robot became better");
}

#[test]
fn a_held_material_is_not_tried() {
    let mut scene = scene("polish_trials = 100");
    let wrong = |scene: &Scene| {
        let (codesign, progress) = after(scene, scene.schedule.iterations, 1);
        let held = filled(codesign.world().lattice());
        let materials = progress.design.layout().unwrap();
        let differs = |(&m, own): (&Material, Material)| m.is_solid() && m != own;
        materials.iter().zip(held).filter(|&p| differs(p)).count()
    };
    assert!(wrong(&scene) > 0);
    scene.projection.hold_materials = 1.0;
    assert_eq!(wrong(&scene), 0);
}
