use crate::small::short_run;
use cosmic::design::Material;
use cosmic::geometry::{Profile, Range, Vector};
use cosmic::policy::Goals;
use cosmic_lab::report::RunFiles;
use cosmic_lab::report::motion::{AT_REST, BEYOND, CONTRACTED, DrawnMotion, EXTENDED, SKELETON};

fn results() -> RunFiles {
    short_run(|scene| scene.physics.steps = 64)
}

#[test]
fn bars_are_the_solid_edges_coloured_by_strain() {
    let results = results();
    let motion = DrawnMotion::new(&results.robot, &results.trajectory);
    let rest = &motion.states()[0];
    let materials = &results.robot.design.materials;
    let count = |m| materials.iter().filter(|e| **e == m).count();
    let [within, beyond] = [0.999 * motion.limit, 1.001 * motion.limit];
    for (strain, colour) in [
        (0.0, AT_REST),
        (within, EXTENDED),
        (-within, CONTRACTED),
        (beyond, BEYOND),
        (-beyond, BEYOND),
    ] {
        let mut stretched = rest.clone();
        for x in &mut stretched.x {
            *x = *x * (1.0 + strain);
        }
        let bars = motion.bars(&stretched);
        let [passive, active] = [false, true].map(|active| {
            let of = bars.iter().filter(move |bar| bar.actuator == active);
            of.map(|bar| bar.colour).collect::<Vec<_>>()
        });
        // Far beyond the strain at which a skeleton breaks, if there is any.
        let skeleton = if strain == 0.0 { SKELETON } else { BEYOND };
        assert_eq!(passive, vec![skeleton; count(Material::Skeleton)]);
        assert_eq!(active, vec![colour; count(Material::Actuator)]);
    }
}

/// The ground has ridges of 1 and 3 cm.
#[test]
fn the_ground_has_its_ridges() {
    let ridge = |at: f64, height| [[at - 0.02, 0.0], [at, height], [at + 0.02, 0.0]];
    let points = [ridge(0.15, 0.01), ridge(0.35, 0.03)].concat();
    let profile = Profile::new(points.into_iter().map(Vector::from).collect()).unwrap();
    let results = short_run(|scene| {
        (scene.physics.steps, scene.physics.ground) = (64, profile.into());
    });
    let motion = DrawnMotion::new(&results.robot, &results.trajectory);
    let floor = |x: f64| motion.ground_height(x);
    // The tolerance allows the rounding errors of sums of numbers below 1.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
    assert!(near(floor(0.35), 0.03) && near(floor(0.3), 0.0) && near(floor(0.34), 0.015));
    let line = motion.ground_line(Range::new(0.0, 0.36));
    assert_eq!(line.len(), 7);
    assert!(near(line[2].up(), 0.01) && near(line[6].up(), 0.015));
}

/// A flag is on the ground, as far from the payload's start along the ground as its goal. A goal that begins after the
/// end has no flag.
#[test]
fn flags_are_where_and_when_their_goals_are() {
    let results = short_run(|scene| {
        (scene.physics.steps, scene.physics.incline_deg) = (64, 20.0);
    });
    let motion = DrawnMotion::new(&results.robot, &results.trajectory);
    assert_eq!(motion.flags(), []);
    let start = motion.states()[0].x[0];
    let tangent = Vector::from([20_f64.to_radians().cos(), 20_f64.to_radians().sin()]);
    let goal = |along: f64| Vector::upright(start.dot(tangent) + along, 0.0);
    let goals = Goals::at(goal(1.5))
        .then(10, goal(-0.5))
        .then(32, goal(0.7))
        .then(64, goal(0.0));
    let motion = motion.with_goals(&goals);
    let flags = motion.flags();
    assert_eq!(flags.len(), 3);
    let expected = [(1.5, 0.0), (-0.5, 0.02), (0.7, 0.064)];
    for (flag, (along, from)) in flags.iter().zip(expected) {
        assert_eq!(flag.from, from);
        let [x, y] = flag.foot.in_plane();
        assert_eq!(y, motion.ground_height(x));
        // A place in the world is a few operations away from the place along the ground.
        assert!((flag.place[0] - along).abs() < 1e-14 && flag.place[1] == 0.0);
        assert!((x - (start + tangent * along).forward()).abs() < 1e-14);
    }
}
