use crate::small::short_run;
use cosmic::geometry::Vector;
use cosmic::policy::Goals;
use cosmic::scene::{LatticeKind, StartKind};
use cosmic_lab::report::eye::Eye;
use cosmic_lab::report::motion::DrawnMotion;
use cosmic_lab::report::{RunFiles, player_page};
use serde_json::Value;

fn in_space() -> RunFiles {
    short_run(|scene| {
        scene.start.kind = StartKind::Uniform;
        scene.lattice.kind = LatticeKind::Cubic;
        (scene.lattice.columns, scene.lattice.rows) = (3, 2);
        scene.lattice.depth = 2;
        scene.physics.steps = 512;
        let schedule = &mut scene.schedule;
        (
            schedule.iterations,
            schedule.attraction_from,
            schedule.snap_at,
        ) = (3, 1, 2);
    })
}

/// Returns the data of a page.
fn data(page: &str) -> Value {
    let (_, rest) = page.split_once("id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

/// Returns the positions of the last frame of a walk, in metres.
fn last_frame(walk: &Value) -> Vec<f64> {
    let frames = walk["counts"].as_array().unwrap().iter();
    let frames = frames.map(|frame| frame.as_array().unwrap());
    let mut at = Vec::new();
    for frame in frames {
        at.resize(frame.len(), 0);
        let moved = frame.iter().map(|count| count.as_i64().unwrap());
        at.iter_mut()
            .zip(moved)
            .for_each(|(at, moved)| *at += moved);
    }
    let unit = walk["unit"].as_f64().unwrap();
    at.into_iter().map(|count| count as f64 * unit).collect()
}

#[test]
fn flags_are_beside_a_robot_in_space() {
    let run = in_space();
    let motion = DrawnMotion::new(&run.robot, &run.trajectory);
    let start = motion.states()[0].x[0];
    let goals = Goals::at(start + Vector::new([0.4, -0.7, 0.3]));
    let [flag] = motion.with_goals(&goals).flags()[..] else {
        panic!("a goal has a flag")
    };
    let off = flag.foot - start;
    // Differences of numbers below one.
    assert!(off.with_up(0.0).distance(Vector::new([0.4, -0.7, 0.0])) < 1e-15);
    assert_eq!(flag.foot.up(), 0.0);
    assert!((flag.place[0] - 0.4).abs() < 1e-15 && (flag.place[1] + 0.7).abs() < 1e-15);
}

#[test]
fn pages_have_all_three_components_of_a_robot_in_space() {
    let run = in_space();
    let data = data(&player_page(&run));
    let motion = DrawnMotion::new(&run.robot, &run.trajectory);
    assert_eq!(
        (&data["robot"]["axes"], &data["walk"]["axes"]),
        (&3.into(), &3.into())
    );
    let start = data["robot"]["start"].as_array().unwrap();
    let expected = motion.states()[0].x.iter().flat_map(|x| x.array());
    assert_eq!(start.len(), 3 * run.robot.lattice.nodes());
    for (found, expected) in start.iter().zip(expected) {
        // Positions at the start have four digits.
        assert!((found.as_f64().unwrap() - expected).abs() < 1e-3 * expected.abs().max(1e-3));
    }
    let unit = data["walk"]["unit"].as_f64().unwrap();
    let every = data["walk"]["every"].as_f64().unwrap();
    let frames = data["walk"]["counts"].as_array().unwrap().len();
    let last = &motion.states()[motion.index_at(every * (frames - 1) as f64)];
    let expected: Vec<f64> = last.x.iter().flat_map(|x| x.array()).collect();
    let found = last_frame(&data["walk"]);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 0.51 * unit);
    }
    assert!(
        expected
            .iter()
            .skip(1)
            .step_by(3)
            .any(|across| across.abs() > unit)
    );
}

#[test]
fn pages_have_two_components_of_the_walk_of_a_planar_robot() {
    let run = short_run(|scene| scene.physics.steps = 64);
    let data = data(&player_page(&run));
    let nodes = run.robot.lattice.nodes();
    assert_eq!(data["robot"]["axes"], 2);
    assert_eq!(data["robot"]["start"].as_array().unwrap().len(), 3 * nodes);
    assert_eq!(data["walk"]["axes"], Value::Null);
    assert_eq!(
        data["walk"]["counts"][0].as_array().unwrap().len(),
        2 * nodes
    );
}

/// A footfall has a place for each state in which its node is on the ground, and no other.
#[test]
fn footfalls_are_the_places_where_nodes_touch_the_ground() {
    let run = in_space();
    let motion = DrawnMotion::new(&run.robot, &run.trajectory);
    let falls = motion.footfalls();
    let near = |x: &Vector<f64>| x.up() - motion.ground_height(x.forward()) < 1e-6;
    assert!(falls.iter().flat_map(|fall| &fall.places).all(near));
    let nodes: std::collections::BTreeSet<usize> = falls.iter().map(|fall| fall.node).collect();
    assert!(!nodes.is_empty());
    for node in nodes {
        let of_node = falls.iter().filter(|fall| fall.node == node);
        let places: usize = of_node.map(|fall| fall.places.len()).sum();
        let touching = motion.states().iter().filter(|state| near(&state.x[node]));
        assert_eq!(places, touching.count());
    }
}

#[test]
fn the_views_look_where_their_names_say() {
    let point = Vector::new([1.0, 2.0, 3.0]);
    for (angles, expected) in [
        (Eye::SIDE, [1.0, 2.0, 3.0]),
        // The robot walks towards the viewer, and its left side is on the right.
        (Eye::FRONT, [2.0, -1.0, 3.0]),
        (Eye::TOP, [1.0, -3.0, 2.0]),
    ] {
        let seen = Eye::new(angles).see(point).array();
        // The cosine of a right angle is not exactly 0.
        for (seen, expected) in seen.into_iter().zip(expected) {
            assert!(
                (seen - expected).abs() < 1e-15,
                "{angles:?}: {seen}, {expected}"
            );
        }
    }
    // In three quarters, points ahead are to the right and nearer, and higher points are higher.
    let eye = Eye::new(Eye::THREE_QUARTERS);
    let [ahead, _, above] = Vector::<f64>::axes().map(|axis| eye.see(axis).array());
    assert!(ahead[0] > 0.5 && ahead[1] < 0.0 && above[2] > 0.9 && above[0] == 0.0);
}
