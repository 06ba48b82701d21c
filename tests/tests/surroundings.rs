//! Rollouts in other surroundings, with other numbers for gravity, friction and settings of laws. The tests cover
//! derivatives with respect to these numbers, and batches of robots in different surroundings.

use autodiff::check::{Options, Verdict, check_gradient};
use autodiff::{Function, Parameters, Real, Var, gradient};
use cosmic::case::Case;
use cosmic::geometry::Vector;
use cosmic::policy::Goals;
use cosmic::scene::GoalKind;
use cosmic::world::{Robot, Span, World};

use super::own_laws::robot;

/// The payload's position at the end of a rollout, as a function of one number of the surroundings.
struct ByNumber<'a> {
    world: World,
    robot: Robot<f64>,
    name: &'a str,
}

impl<'a> ByNumber<'a> {
    fn new(case: &Case, name: &'a str) -> Self {
        let (world, mut robot) = (case.world(), case.robot());
        let third = world.physics().steps / 3;
        if case.scene.controller.goals == GoalKind::Given {
            let goal = |place: [f64; 3]| case.lattice.dimension.onto(Vector::new(place));
            let goals = Goals::at(goal([0.4, 0.3, 0.1]));
            let goals = goals.then(third, goal([-0.2, -0.4, 0.1]));
            let goals = goals.then(2 * third, goal([0.2, 0.1, 0.15]));
            robot = robot.with_goals(goals);
        }
        Self { world, robot, name }
    }

    /// The value of the number in the robot's surroundings.
    fn value(&self) -> f64 {
        let surroundings = &self.robot.surroundings;
        match component(self.name) {
            Some((goal, k)) => {
                let goals = surroundings.goals.as_ref().unwrap();
                goals.iter().nth(goal).unwrap().array()[k]
            }
            None => surroundings.value(self.name),
        }
    }

    /// Simulates once for each of `values`, as one batch if `together` is true. Returns the last state of each rollout
    /// as a list of numbers.
    fn ends<R: Real>(&self, values: &[R], together: bool) -> Vec<Vec<R>> {
        let robot = self.robot.map(R::lit);
        let span = Span::of_steps(self.world.physics().steps);
        let with = |&value: &R| {
            let surroundings = (*robot.surroundings).clone();
            match component(self.name) {
                Some((goal, k)) => {
                    let goals = surroundings.goals.unwrap();
                    let mut places: Vec<_> = goals.iter().map(Vector::array).collect();
                    places[goal][k] = value;
                    let mut places = places.into_iter().map(Vector::new);
                    let first = Goals::at(places.next().unwrap());
                    let later = goals.later.iter().zip(places);
                    let goals = later.fold(first, |goals, (&(steps, _), place)| {
                        goals.then(steps, place)
                    });
                    robot.clone().with_goals(goals)
                }
                None => robot
                    .clone()
                    .in_surroundings(surroundings.with(self.name, value)),
            }
        };
        let robots: Vec<_> = values.iter().map(with).collect();
        let run = |robots: &[Robot<R>]| self.world.run(robots, &span);
        let ends = match together {
            true => run(&robots),
            false => robots.chunks(1).flat_map(run).collect(),
        };
        ends.iter().map(|end| end.states[0].to_columns()).collect()
    }
}

impl Function for ByNumber<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.ends(x, false)[0][0]
    }
}

/// For a component of a goal, such as `goal.1.above`: which goal, and which component of a vector.
fn component(name: &str) -> Option<(usize, usize)> {
    let (goal, component) = name.strip_prefix("goal.")?.split_once('.')?;
    let components = ["along", "across", "above"];
    let k = components.iter().position(|other| *other == component)?;
    Some((goal.parse().ok()?, k))
}

/// Robots with laws that have settings. For each robot, also the numbers of its surroundings that the tests vary, by
/// name.
fn with_settings() -> [(Case, &'static [&'static str]); 6] {
    let sliding = robot(
        "[physics]\ncontact = \"coulomb\"\nfriction = 0.3\nincline_deg = 10.0\n\
         forces = [\"tether\", \"damper\", \"stiffening\", \"bending\", \"bar_formula\", \"node_formula\"]\n\
         [tether]\nstiffness = 0.3\ndamping = 0.01\n\
         [bar_formula]\ntension = \"a * rest_length + b * stiffness * rate\"\na = 0.02\nb = 1e-4\n\
         [node_formula]\nforce_x = \"c * sin(d * time)\"\nc = 0.01\nd = 9.0",
    );
    let bouncing = robot(
        "[physics]\ncontact = \"bounce\"\nintegrator = \"leapfrog\"\nforces = [\"stops\"]\n\
         [stops]\nat = 0.003\nstiffness = 3.0",
    );
    let over_terrain = robot(
        "[physics]\ncontact = \"coulomb\"\nfriction = 0.3\n[ground]\nprofile = \"points\"\n\
         points = [[-1.1, 0.0], [0.05, -0.002], [1.9, -0.002]]",
    );
    let implicit = robot(
        "[physics]\nintegrator = \"implicit\"\ncontact = \"coulomb\"\nfriction = 0.3\nincline_deg = 10.0",
    );
    let with_goals = robot(
        "[controller]\ngoals = \"given\"\ngoal_scale = 3.0\n[objective]\ntask = \"reach\"\n[physics]\nincline_deg = 10.0",
    );
    let with_goals_in_space = robot(
        "[lattice]\nkind = \"cubic\"\ndepth = 2\n\
         [controller]\ngoals = \"given\"\ngoal_scale = 3.0\n[objective]\ntask = \"reach\"\n[physics]\nincline_deg = 10.0",
    );
    [
        (
            sliding,
            &[
                "physics.gravity",
                "physics.damping",
                "physics.friction",
                "tether.stiffness",
                "tether.damping",
                "damper.time",
                "stiffening.cubic",
                "bending.radius",
                "bar_formula.a",
                "bar_formula.b",
                "node_formula.c",
                "node_formula.d",
            ],
        ),
        (
            bouncing,
            &["physics.gravity", "bounce.restitution", "stops.stiffness"],
        ),
        (
            over_terrain,
            &["physics.gravity", "physics.damping", "physics.friction"],
        ),
        (
            implicit,
            &["physics.gravity", "physics.damping", "physics.friction"],
        ),
        (
            with_goals,
            &["goal.0.along", "goal.1.along", "goal.2.above"],
        ),
        (
            with_goals_in_space,
            &[
                "goal.0.across",
                "goal.1.along",
                "goal.2.across",
                "goal.2.above",
            ],
        ),
    ]
}

/// Derivatives with respect to gravity, friction and settings of laws agree in reverse mode, forward mode and finite
/// differences. Wrong derivatives are noticed.
#[test]
fn a_rollout_is_differentiated_by_gravity_friction_and_settings() {
    for (case, names) in with_settings() {
        for name in names {
            let by_number = ByNumber::new(&case, name);
            // Along a single number, all directions are alike.
            let options = Options {
                directions: 1,
                ..Options::default()
            };
            let report = check_gradient(&by_number, &[by_number.value()], &options);
            assert_eq!(report.verdict, Verdict::Smooth, "{name}: {report}");
            assert_eq!(report.control, Some(Verdict::Wrong), "{name}: {report}");
        }
    }
}

/// The robots of a batch may have different surroundings: values and gradients are the same as in single rollouts. The
/// batches have two robots, as many robots as a register has lanes, and more.
#[test]
fn robots_of_a_batch_may_differ_in_their_surroundings() {
    for (case, names) in with_settings() {
        for name in names {
            let by_number = ByNumber::new(&case, name);
            for count in [2, 4, 11] {
                let value = by_number.value();
                let values: Vec<f64> = (0..count).map(|k| value * (0.5 + 0.1 * k as f64)).collect();
                let [alone, together] =
                    [false, true].map(|together| by_number.ends(&values, together));
                assert_eq!(alone, together, "{name}");
                assert_ne!(alone[0], alone[1], "{name} has no effect");
                let slopes = |together| {
                    let sum =
                        |x: &[Var<f64>]| by_number.ends(x, together).iter().map(|end| end[0]).sum();
                    gradient(sum, &values)
                };
                assert_eq!(slopes(false), slopes(true), "{name}");
            }
        }
    }
}

/// Setting the friction in the surroundings of a rollout has the same effect as setting it in the scene.
#[test]
fn surroundings_are_those_of_a_scene() {
    let friction = |value: f64| {
        robot(&format!(
            "[physics]\ncontact = \"coulomb\"\nfriction = {value:?}"
        ))
    };
    let (low, high) = (friction(0.2), friction(1.5));
    let end = |case: &Case| {
        let end = (case.world()).run_one(&case.robot(), &Span::of_steps(case.scene.physics.steps));
        end.states[0].to_columns()
    };
    let by_number = ByNumber::new(&low, "physics.friction");
    assert_eq!(by_number.ends(&[1.5], false)[0], end(&high));
    assert_ne!(end(&low), end(&high));
}

#[test]
#[should_panic(
    expected = "the surroundings have no numeric setting `physics.friction`; expected one of physics.gravity"
)]
fn an_unknown_number_of_the_surroundings_is_refused() {
    let case = robot("");
    ByNumber::new(&case, "physics.friction").ends(&[1.0], false);
}
