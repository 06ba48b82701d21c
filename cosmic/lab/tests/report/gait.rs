use crate::small::short_run;
use cosmic::design::Material;
use cosmic_lab::report::gait::Gait;
use cosmic_lab::report::motion::DrawnMotion;

/// Tests the short three-legged robot of the paper's scene after one iteration. Its rollout lasts 0.3 s.
#[test]
fn a_gait_agrees_with_the_trajectory() {
    let mut run = short_run(|scene| (scene.physics.steps, scene.physics.gravity) = (160, 9.81));
    let motion = DrawnMotion::new(&run.robot, &run.trajectory);
    let gait = Gait::new(&run).unwrap();
    let shown = gait.last_periods(&motion);

    // The largest strain and force equal those in the summary. Both are the largest over all steps.
    let summary = run.summary.loads.clone().unwrap();
    let actuators = run.robot.edges_of(|m| m == Material::Actuator);
    let most = |of: fn(&[f64]) -> f64| {
        let peaks = shown["peaks"].as_array().unwrap().iter();
        let numbers = peaks.map(|peak| serde_json::from_value::<Vec<f64>>(peak.clone()).unwrap());
        numbers.map(|peak| of(&peak)).fold(0.0, f64::max)
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 6e-4 * b, "{a} is not {b}");
    let strain = actuators.iter().map(|&edge| gait.loads[edge].strain.peak);
    assert_eq!(strain.fold(0.0, f64::max), summary.strain.peak);
    assert_eq!(gait.loads_over(), "over all steps of the rollout");
    near(most(|peak| peak[2]), summary.compression);

    // A rollout shorter than a period is shown whole. The robot begins on its three feet.
    let times = shown["times"].as_array().unwrap();
    assert_eq!(times.len(), motion.states().len());
    let feet: Vec<(usize, String)> = serde_json::from_value(shown["feet"].clone()).unwrap();
    let begins: Vec<usize> = feet
        .iter()
        .filter(|(_, stands)| stands.starts_with('1'))
        .map(|(node, _)| *node)
        .collect();
    let lowest = motion
        .seen
        .iter()
        .filter(|node| run.robot.lattice.places[**node].up() == 0.0);
    assert!(lowest.eq(&begins), "{begins:?}");

    // At the start nothing moves, so the kinetic and potential energies are zero. Later they are sums over all
    // nodes.
    let energies = gait.energies(&motion);
    let at = |name: &str, k: usize| energies[name][k].as_f64().unwrap();
    assert_eq!([at("kinetic", 0), at("height", 0)], [0.0; 2]);
    let last = motion.states().last().unwrap();
    let mass = gait.case.body().mass;
    let kinetic = last.v.iter().zip(&mass).map(|(v, m)| 0.5 * m * v.dot(*v));
    near(at("kinetic", motion.states().len() - 1), kinetic.sum());
    assert!(at("elastic", 3) > 0.0);

    // The trajectory file of an undecided design has only states, without loads.
    run.trajectory.bars.clear();
    let gait = Gait::new(&run).unwrap();
    let said = gait.loads_over();
    assert!(
        said.starts_with("in the 11 states of trajectory.json"),
        "{said}"
    );
    let seen = actuators.iter().map(|&edge| gait.loads[edge].speed.peak);
    assert!(seen.fold(0.0, f64::max) < summary.speed.peak);
}
