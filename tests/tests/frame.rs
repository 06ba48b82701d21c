//! The world's frame: the ground line passes through the origin, and the first column of a lattice starts there. Formulas,
//! losses, goals and files count from the same origin. Only a case may count from another one.

use cosmic::case::Case;
use cosmic::geometry::{Ground, Range, Vector};
use cosmic::lattice::Lattice;
use cosmic::policy::Goals;
use cosmic::scene::{BUILTIN, Scene};
use cosmic::world::Span;
use cosmic_lab::walk::walk;
use cosmic_tests::{farthest, numbers, own_reference_folder, reference_subfolder, references};
use serde_json::{Value, json};

#[test]
fn every_built_in_scene_starts_at_the_origin() {
    for name in BUILTIN.map(|builtin| builtin.name) {
        let scene = Scene::load(name).unwrap();
        let ground = Ground::from(&scene.physics);
        let profile = scene.physics.ground.resolved();
        assert_eq!(profile.height_in_world(&ground, 0.0), 0.0, "{name}");
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        let places = lattice.positions.iter();
        let places: Vec<_> = places.map(|&x| ground.vector_to_ground(x)).collect();
        let least = |of: fn(&Vector<f64>) -> f64| Range::of(places.iter().map(of)).low;
        // A rotation rounds coordinates below 2 m by some 1e-16.
        let tolerance = if ground.is_flat() { 0.0 } else { 1e-15 };
        let [along, above] = [least(|x| x.forward()), least(|x| x.up())];
        assert!(along.abs() <= tolerance, "{name}: {along:e}");
        assert!(
            (above - scene.lattice.drop).abs() <= tolerance,
            "{name}: {above:e}"
        );
    }
}

/// A force of 1 N/m times the place of a node moves the payload as if it were where the trajectory of a loss, the
/// trajectory of a file and the goals have it. The payload of `errand` is not node 0.
#[test]
fn formulas_losses_files_and_goals_see_the_same_numbers() {
    let speeds = |stiffness: f64| {
        let text = format!(
            "base = 'errand'\nlattice.drop = 0.02\nphysics = {{forces = ['node_formula'], damping = 0.0, steps = 1}}\n\
             node_formula = {{force_x = 'a * x', force_z = 'a * z', a = {stiffness}}}"
        );
        let case = Case::of_scene(&Scene::parse("formula", &text).unwrap(), 1).unwrap();
        let payload = case.lattice.payload[0].node;
        let world = case.world();
        let goals = Goals::at(case.lattice.payload_point(&case.start, &world.ground()));
        let walk = walk(&case, &goals, 1).unwrap();
        let seen = world.run_one(&case.robot(), &Span::from_start(vec![0, 1]));
        assert!(payload != 0 && walk.trajectory.states[0].x[0] != seen.payload(0).x);
        assert_eq!(walk.trajectory.states[0].x[payload], seen.payload(0).x);
        assert_eq!(goals.first, seen.payload(0).x);
        let mass = case.body().mass[payload];
        (
            seen.payload(0).x,
            seen.payload(1).v * (mass / case.scene.physics.dt),
        )
    };
    let ((place, without), (_, with)) = (speeds(0.0), speeds(1.0));
    assert_eq!(place.up(), 0.02);
    // The momentum of a step is the sum of forces of at most some N, times the step.
    let felt = with - without;
    assert!(felt.distance(place) < 1e-12, "{felt:?} {place:?}");
}

/// The file of a reference case with its ground line `lift` metres higher, and with everything on it.
fn raised(file: &Value, lift: f64) -> Value {
    let mut file = file.clone();
    let scene = &mut file["scene"];
    scene["ground_height"] = json!(scene["ground_height"].as_f64().unwrap() + lift);
    scene["goal_relative"] = json!(true);
    let (sin, cos) = scene["alpha_deg"].as_f64().unwrap().to_radians().sin_cos();
    let add = |number: &mut Value, by: f64| *number = json!(number.as_f64().unwrap() + by);
    let goal = scene["goal"].as_array_mut().unwrap();
    add(&mut goal[0], lift * sin);
    add(goal.last_mut().unwrap(), lift * cos);
    let points = file["x0"].as_array_mut().unwrap().iter_mut();
    points.for_each(|x| add(x.as_array_mut().unwrap().last_mut().unwrap(), lift));
    file
}

/// Positions in the results of a case count from the origin of its file, wherever its ground is, and so does a goal that is a
/// place. In the world's frame the ground line passes through the origin.
#[test]
fn a_case_may_have_another_frame() {
    let folders = [own_reference_folder(), reference_subfolder("space")];
    let mut slopes = 0;
    for reference in folders.iter().flat_map(|folder| references(folder)) {
        const LIFT: f64 = 0.25;
        let [here, there] = [0.0, LIFT].map(|lift| {
            let text = raised(&reference.json, lift).to_string();
            Case::parse(&reference.name(), &text).unwrap()
        });
        let steps = [0, 1, 16.min(here.scene.physics.steps)];
        let [a, b] = [&here, &there].map(|case| case.evaluate(false, &steps).unwrap());
        let (height, slope) = (here.frame.ground_height, here.scene.physics.incline_deg);
        assert_eq!(height, 0.1);
        slopes += u32::from(slope != 0.0);
        let up = Vector::upright(0.0, LIFT);
        // Rounding of positions near 1 m, amplified in few steps.
        let near = 1e-12;
        for (a, b) in a.trajectory.values().zip(b.trajectory.values()) {
            let mut lifted = a.clone();
            lifted.x.iter_mut().for_each(|x| *x += up);
            assert!(farthest(&lifted, b) < near, "{}", reference.name());
        }
        // The results have the positions of the file, and the world is lower.
        let file = here
            .lattice
            .dimension
            .from_flat(&numbers(&reference.json["x0"]));
        for ((x, &seen), &own) in file.iter().zip(&a.trajectory[&0].x).zip(&here.start.x) {
            assert!(x.distance(seen) < 1e-15 && (own + up * (height / LIFT)).distance(*x) < 1e-15);
        }
        let sin = slope.to_radians().sin();
        if steps[2] == here.scene.physics.steps {
            assert!((b.l_disp - a.l_disp + LIFT * sin).abs() < near);
        }
        let loss = there.displacement_loss(&there.world(), &there.inputs());
        assert!((loss - b.l_disp).abs() < near, "{}", reference.name());
        // A case is written in the world's frame, and makes the same motion there.
        let again = Case::parse("again", &there.to_json()).unwrap();
        assert_eq!(again.frame.ground_height, 0.0);
        assert_eq!(again.start, there.start);
    }
    assert!(slopes > 1, "{slopes} slopes");
}
