use cosmic::scene::Scene;
use cosmic::search::{PassKind, Phase, Schedule};

#[test]
fn the_paper_s_phases_and_ramps() {
    let scene = Scene::paper();
    let at = |iteration| Schedule::at(&scene, iteration);
    use Phase::{Attraction, CoDesign, FineTuning, Snap};
    let ends = [
        (1, CoDesign),
        (169, CoDesign),
        (170, Attraction),
        (239, Attraction),
        (240, Snap),
    ];
    for (iteration, phase) in ends
        .into_iter()
        .chain([(241, FineTuning), (300, FineTuning)])
    {
        assert_eq!(at(iteration).phase(), phase);
    }
    let horizons = [1, 80, 115, 150, 300].map(|i| at(i).horizon());
    assert_eq!(horizons, [2048, 2048, 3072, 4096, 4096]);
    let widened = [110, 130, 150].map(|i| at(i).volume_bounds().actuator.high);
    // The tolerance covers sums of decimal fractions that are rounded at 1e-17.
    let is = |a: f64, b: f64| (a - b).abs() < 1e-15;
    assert!(
        widened
            .iter()
            .zip([0.22, 0.235, 0.25])
            .all(|(a, b)| is(*a, b))
    );
    let first = [0.4, 0.2, 0.01, 0.3];
    assert_eq!(at(20).thresholds(&first), first);
    assert_eq!(at(180).thresholds(&first), [0.03, 0.03, 0.01, 0.03]);
    assert_eq!(at(170).attraction(), (0.9, 0.002));
    let rates = [1, 241, 285, 300].map(|i| at(i).learning_rate());
    // Iteration 285 is at 44 of 59 steps of the ramp to a tenth. The rate of the last iteration is zero.
    let ramped = (15.0 / 59.0) * 0.003 + (44.0 / 59.0) * 0.0003;
    assert_eq!([rates[0], rates[1], rates[3]], [0.003, 0.003, 0.0]);
    // The tolerance covers three roundings of numbers of this size.
    assert!((rates[2] - ramped).abs() < 1e-18);
    let polishes: Vec<_> = (1..=300).filter(|i| at(*i).polishes()).collect();
    assert!(polishes.into_iter().eq((241..286).step_by(3)));
    let settles = [285, 286, 300].map(|i| at(i).settles());
    assert_eq!(settles, [false, true, true]);
    // Three of every five passes update the design.
    let designs = (1..=240).filter(|i| at(*i).pass() == PassKind::Design);
    assert_eq!(designs.count(), 144);
}

#[test]
fn a_whole_percentage_of_100_iterations_settles() {
    let mut scene = Scene::paper();
    let schedule = &mut scene.schedule;
    (schedule.snap_at, schedule.iterations) = (200, 300);
    for percent in 0..=100 {
        scene.schedule.settle = percent as f64 / 100.0;
        let settles = (1..=300).filter(|iteration| Schedule::at(&scene, *iteration).settles());
        assert_eq!(settles.count(), percent);
    }
}
