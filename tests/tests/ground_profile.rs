//! The motion of robots and single nodes on ground with a height profile.

use cosmic::case::Case;
use cosmic::geometry::{Ground, Profile, Vector};
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::scene::{GroundSettings, Integrator, PhysicsSettings, ProfileKind, Scene};
use cosmic_tests::{Bare, least_height, states};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

fn profile(points: &[[f64; 2]]) -> GroundSettings {
    Profile::new(points.iter().copied().map(Vector::from).collect())
        .unwrap()
        .into()
}

/// A robot whose edges are mixtures of materials, on the default lattice. It falls to the ground while it moves
/// forward.
fn falling(change: impl FnOnce(&mut Scene)) -> Case {
    let mut scene = Scene::paper();
    scene.physics.steps = 256;
    scene.lattice.drop = 0.003;
    change(&mut scene);
    let mut case = Case::of_scene(&scene, 1).unwrap();
    for (i, v) in case.start.v.iter_mut().enumerate() {
        *v = Vector::from([0.4 + 0.01 * i as f64, -0.1]);
    }
    case
}

/// On a profile that is a single slope, a robot moves like on a straight incline with the same slope.
#[test]
fn a_profile_of_one_slope_is_the_incline() {
    for (contact, incline_deg) in [
        (ContactLaw::infinite(), 15.0),
        (ContactLaw::coulomb(), 15.0),
        (ContactLaw::coulomb(), -8.0),
    ] {
        let incline = falling(|scene| {
            scene.physics.contact = contact.clone();
            (scene.physics.friction, scene.physics.incline_deg) = (0.3, incline_deg);
        });
        let mut slope = incline.clone();
        let rise = 20.0 * f64::to_radians(incline_deg).tan();
        slope.scene.physics.incline_deg = 0.0;
        slope.scene.physics.ground = profile(&[[-20.0, -rise], [20.0, rise]]);
        let [on_incline, on_slope] = [&incline, &slope].map(states);
        let pairs = on_incline.iter().zip(&on_slope);
        let off = pairs.flat_map(|(a, b)| {
            let numbers = |s: &State<f64>| s.to_columns();
            let pairs = numbers(a).into_iter().zip(numbers(b));
            pairs.map(|(a, b)| (a - b).abs()).collect::<Vec<_>>()
        });
        let off = off.fold(0.0, f64::max);
        println!("{contact:?}, {incline_deg} degrees: {off:.1e}");
        // The computations in the two frames round differently, by about 1e-16 in each of 256 steps, and the motion
        // amplifies the difference.
        assert!(off < 1e-12, "{contact:?}, {incline_deg} degrees: {off:e}");
        // The test is useful only if nodes reach the ground.
        let last = on_slope.last().unwrap();
        assert!(last.v.contains(&Vector::zero()) || contact != ContactLaw::infinite());
        assert!(least_height(&slope.scene.physics, &on_slope).abs() < 1e-12);
    }
}

/// A world for a single node, with a random profile that consists of points. With `walls`, every second corner of the
/// profile is the foot or the edge of a vertical wall.
fn world(rng: &mut ChaCha8Rng, walls: bool) -> PhysicsSettings {
    let mut at = 0.0;
    let count = rng.random_range(1..20);
    let points = (0..count).map(|k| {
        let way = 10f64.powf(rng.random_range(-3.0..-0.5));
        at += if walls && k % 2 == 1 { 0.0 } else { way };
        [at, rng.random_range(-0.1..0.1)]
    });
    let points: Vec<[f64; 2]> = points.collect();
    let contact = [ContactLaw::infinite, ContactLaw::coulomb][rng.random_range(0..2)];
    PhysicsSettings {
        contact: contact(),
        friction: [0.0, 0.1, 0.5, 2.5][rng.random_range(0..4)],
        gravity: 9.81,
        damping: rng.random_range(0.0..5.0),
        ground: profile(&points),
        ..PhysicsSettings::default()
    }
}

/// Drops two nodes on random ground for every seed, and checks that they stay above the ground. Returns how many came
/// down and how many came to rest.
fn drop_nodes(walls: bool, change: impl Fn(&mut PhysicsSettings)) -> (usize, usize) {
    const STEPS: usize = 400;
    let (mut low, mut rest) = (0, 0);
    for seed in 0..300 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut physics = world(&mut rng, walls);
        change(&mut physics);
        let ground = physics.ground.resolved();
        let end = ground.points().last().unwrap().forward();
        let mut node = || {
            let x = rng.random_range(-0.1..end + 0.1);
            let above = 10f64.powf(rng.random_range(-4.0..-0.5));
            [x, ground.height(x) + above]
        };
        let start = State::new(
            vec![node(), node()],
            [(); 2]
                .map(|()| [(); 2].map(|()| rng.random_range(-3.0..3.0)))
                .to_vec(),
        );
        let bare = Bare::free_node(physics);
        let seen = bare.run(&start, (0..=STEPS).collect());
        let least = least_height(&bare.physics, &seen.states);
        // While a node slides along a slope, its position is rounded by 1e-16 in each step.
        assert!(least > -1e-12, "seed {seed}: {least:e} m");
        let rests = |state: &State<f64>| state.v[0] == [0.0; 2];
        (low, rest) = (
            low + usize::from(least < 1e-12),
            rest + usize::from(seen.states.last().is_some_and(rests)),
        );
    }
    (low, rest)
}

/// No node is ever below the ground, on random profiles with sharp ridges and narrow gaps.
#[test]
fn no_node_is_below_the_ground() {
    let (low, rest) = drop_nodes(false, |_| {});
    // Most nodes reach the ground, and many come to rest.
    assert!(low > 250 && rest > 100, "{low} {rest}");
}

/// No node passes a vertical wall, with any integrator. Substeps and leapfrog move a node several times in a step.
#[test]
fn no_node_is_behind_a_wall() {
    for change in [
        (|_| {}) as fn(&mut PhysicsSettings),
        |p| p.integrator = Integrator::Leapfrog,
        |p| p.substeps = 3,
        |p| p.integrator = Integrator::Implicit,
    ] {
        let (low, rest) = drop_nodes(true, change);
        assert!(low > 250 && rest > 50, "{low} {rest}");
    }
}

/// A robot that is driven against a stair with vertical walls on an incline stays in front of it, also if the rollout is
/// begun anew from its last state. In the world's frame the wall leans, and positions at the wall are rounded.
#[test]
fn a_robot_leans_on_an_inclined_wall() {
    for integrator in [Integrator::SymplecticEuler, Integrator::Implicit] {
        let mut case = falling(|scene| {
            scene.physics.contact = ContactLaw::coulomb();
            (scene.physics.friction, scene.physics.incline_deg) = (0.1, -20.0);
            scene.physics.integrator = integrator;
            scene.physics.ground = profile(&[[0.55, 0.0], [0.55, 0.25]]);
            scene.physics.steps = 400;
        });
        let ground = Ground::from(&case.scene.physics);
        for round in 0..4 {
            let seen = states(&case);
            // The tolerance covers rounding of the conversion between the frames.
            let least = least_height(&case.scene.physics, &seen);
            assert!(least > -1e-12, "{integrator:?}, {round}: {least:e} m");
            case.start = seen.last().unwrap().clone();
        }
        let along = |x: &Vector<f64>| ground.vector_to_ground(*x).forward();
        let at_wall = case
            .start
            .x
            .iter()
            .filter(|x| (along(x) - 0.55).abs() < 1e-9);
        assert!(
            at_wall.count() > 0,
            "{integrator:?}: no node is at the wall"
        );
    }
}

/// A robot above a stair. In its lowest row, every second column is above a new step.
fn on_stairs(contact: ContactLaw) -> Case {
    falling(|scene| {
        scene.physics.contact = contact;
        scene.lattice.drop = 0.06;
        scene.physics.ground = GroundSettings {
            profile: ProfileKind::Steps,
            from: 0.05,
            spacing: 0.2,
            count: 3,
            ..GroundSettings::default()
        };
        scene.physics.steps = 2000;
        scene.materials.max_strain = [0.0; 3];
    })
}

/// A robot that has come to rest on steps stays there.
#[test]
fn a_body_at_rest_on_a_step_stays() {
    for contact in [ContactLaw::infinite(), ContactLaw::coulomb()] {
        let mut case = on_stairs(contact.clone());
        case.start.v.fill(Vector::zero());
        let first = states(&case);
        let last = first.last().unwrap();
        let fastest = last.speeds().fold(0.0, f64::max);
        // The robot stands on at least two levels, and all vibrations are damped.
        assert!(fastest < 1e-6, "{contact:?}: {fastest:e}");
        let profile = case.scene.physics.ground.resolved();
        let ground = Ground::from(&case.scene.physics);
        let stands = last
            .x
            .iter()
            .filter(|x| profile.above(ground.vector_to_ground(**x)).abs() < 1e-9);
        let mut levels: Vec<i64> = stands.map(|x| (x.up() * 1e3).round() as i64).collect();
        levels.dedup();
        assert!(levels.len() > 1, "{contact:?}: {levels:?}");
        case.start = last.clone();
        case.start.v.fill(Vector::zero());
        let second = states(&case);
        let moved = last.x.iter().zip(&second.last().unwrap().x);
        let moved = moved.map(|(a, b)| a.distance(*b));
        let moved = moved.fold(0.0, f64::max);
        // The robot kept a vibration below 1e-6 m/s, which is damped at a rate of 20 1/s.
        assert!(moved < 1e-7, "{contact:?}: {moved:e}");
    }
}

/// Profiles also work with leapfrog, with substeps, and in a world without ground.
#[test]
fn a_profile_works_with_the_rest_of_the_physics() {
    let case = |change: fn(&mut PhysicsSettings)| {
        let mut case = on_stairs(ContactLaw::coulomb());
        case.scene.physics.steps = 300;
        change(&mut case.scene.physics);
        case
    };
    for change in [
        (|p| p.integrator = Integrator::Leapfrog) as fn(&mut PhysicsSettings),
        |p| p.substeps = 3,
    ] {
        let case = case(change);
        let least = least_height(&case.scene.physics, &states(&case));
        assert!(least.abs() < 1e-12, "{least:e}");
    }
    let case = case(|p| p.contact = ContactLaw::none());
    assert!(least_height(&case.scene.physics, &states(&case)) < -0.1);
}

/// A profile on an incline is measured along the incline and perpendicular to it.
#[test]
fn a_profile_turns_with_the_ground_line() {
    // The whole world is turned. A robot without weight and without actuators must make the same motion, but turned.
    let mut case = on_stairs(ContactLaw::infinite());
    case.scene.physics.steps = 300;
    (case.scene.physics.gravity, case.scene.physics.damping) = (0.0, 0.0);
    case.start
        .v
        .iter_mut()
        .for_each(|v| *v = v.with_up(v.up() - 0.5));
    let mut turned = case.clone();
    turned.scene.physics.incline_deg = 20.0;
    let [level, ground] = [&case, &turned].map(|case| Ground::from(&case.scene.physics));
    turned.start = case.start.to_ground(&level).to_world(&ground);
    let [straight, turned] = [&case, &turned].map(states);
    let pairs = straight.iter().zip(&turned);
    let off = pairs.flat_map(|(a, b)| {
        let [a, b] = [a.to_ground(&level), b.to_ground(&ground)];
        let pairs = a.x.into_iter().zip(b.x);
        pairs.map(|(a, b)| a.distance(b)).collect::<Vec<_>>()
    });
    // The tolerance covers rounding errors of 1e-16 in each of 300 steps, which the motion amplifies.
    assert!(off.fold(0.0, f64::max) < 1e-9);
    // The robot reaches the stairs.
    assert!(least_height(&case.scene.physics, &straight).abs() < 1e-12);
}
