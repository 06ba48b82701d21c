use crate::small::lattice;
use cosmic::design::{Design, Material};
use cosmic::world::draw;
use cosmic::random::{Purpose, stream};
use cosmic::scene::{GoalsSettings, Scatter, Scene};
use cosmic::world::Task;

#[test]
fn without_ranges_the_domain_is_the_nominal_one() {
    let none = "base = \"stability\"\n[robust]\nsamples = 1\nspread = 0\nfriction = 0";
    let scene = Scene::parse("none", none).unwrap();
    let task = &Task::new(lattice(3, 2, 0.0), &scene);
    let none = scene.robust.scatter();
    let domain = draw(task, &none, &mut stream(3, Purpose::DomainRandomisation));
    assert_eq!(domain.start, task.lattice.state_at_rest());
    assert_eq!(domain.task.physics, task.physics);
    let some = Scatter { mass: 0.1, ..none };
    let [a, b] =
        [4, 4].map(|seed| draw(task, &some, &mut stream(seed, Purpose::DomainRandomisation)));
    let design = Design::Layout(vec![Material::Skeleton; task.lattice.edges.len()]);
    let mass = |task: &Task| task.body::<f64>(&design).mass;
    assert_eq!(mass(&a.task), mass(&b.task));
    let pairs = mass(&a.task).into_iter().zip(mass(task));
    let shares: Vec<f64> = pairs.map(|(varied, nominal)| varied / nominal).collect();
    assert!(shares.iter().all(|s| (0.9..=1.1).contains(s)));
    assert!(shares.iter().any(|s| (s - 1.0).abs() > 1e-3));
}

#[test]
fn a_short_rollout_has_at_most_one_goal_per_step() {
    let changes = |steps| -> Vec<usize> { GoalsSettings::changes(steps).collect() };
    assert_eq!([1, 2, 9].map(changes), [vec![], vec![1], vec![3, 6]]);
}
