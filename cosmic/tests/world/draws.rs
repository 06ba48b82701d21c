use crate::small::lattice;
use cosmic::design::{Design, Material};
use cosmic::policy::Controller;
use cosmic::random::{Purpose, stream};
use cosmic::scene::{GoalsSettings, Scatter, Scene};
use cosmic::world::{Variation, World, draw};
use std::sync::Arc;

#[test]
fn without_ranges_the_variation_is_the_nominal_one() {
    let none = "base = \"stability\"\n[robust]\nsamples = 1\nspread = 0\nfriction = 0";
    let scene = Scene::parse("none", none).unwrap();
    let world = &World::new(lattice(3, 2, 0.0), &scene);
    let none = scene.robust.scatter();
    let drawn = draw(world, &none, &mut stream(3, Purpose::DomainRandomisation));
    assert_eq!(drawn.start, world.lattice().state_at_rest());
    assert_eq!(*drawn.surroundings, world.surroundings());
    let some = Scatter { mass: 0.1, ..none };
    let [a, b] = [4, 4].map(|seed| {
        draw(
            world,
            &some,
            &mut stream(seed, Purpose::DomainRandomisation),
        )
    });
    let design = Design::Layout(vec![Material::Skeleton; world.lattice().edges.len()]);
    let controller = Arc::new(Controller::xavier(&scene.controller, world.lattice(), 1));
    let mass = |drawn: &Variation| world.varied(&design, &controller, drawn).body.mass.clone();
    assert_eq!(mass(&a), mass(&b));
    let pairs = mass(&a).into_iter().zip(world.body(&design).mass);
    let shares: Vec<f64> = pairs.map(|(varied, nominal)| varied / nominal).collect();
    assert!(shares.iter().all(|s| (0.9..=1.1).contains(s)));
    assert!(shares.iter().any(|s| (s - 1.0).abs() > 1e-3));
}

#[test]
fn a_short_rollout_has_at_most_one_goal_per_step() {
    let changes = |steps| -> Vec<usize> { GoalsSettings::changes(steps).collect() };
    assert_eq!([1, 2, 9].map(changes), [vec![], vec![1], vec![3, 6]]);
}
